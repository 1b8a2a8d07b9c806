"""The header of a table of measurements: which column is what, and in which unit.

A word may mean one quantity or several; the unit decides, and where it does not the header is refused.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from stickslip_sym.core.errors import InputError
from stickslip_sym.model.measured.units import Unit, read_unit

__all__ = ["Column", "Columns", "choose_columns", "is_header", "read_header"]

EXPECTED = "v [m/s],mu or v [mm/s];F_t [N];F_n [N];sigma_mu"

KINDS = {"v": "speed", "mu": "number", "F_t": "force", "F_n": "force", "sigma_mu": "number", "sigma_F_t": "force"}
"""Every quantity of a table, and what its unit measures."""
_FORCES = frozenset({"F_t", "F_n"})
_WORDS: dict[tuple[str, ...], str] = {
    ("v",): (
        "v, speed, velocity, slip speed, slip velocity, sliding speed, sliding velocity, slide speed, "
        "relative speed, relative velocity, rel speed, rel velocity, surface speed, surface velocity, "
        "linear speed, linear velocity, v_r, v_rel, v_slip, v_sl, v_slide, v_sliding, vel, slip rate, "
        "gleitgeschwindigkeit, geschwindigkeit, relativgeschwindigkeit"
    ),
    ("mu",): (
        "mu, μ, cof, friction coefficient, coefficient of friction, coeff of friction, friction coeff, "
        "coefficient friction, mu_k, μ_k, mu_d, kinetic friction coefficient, dynamic friction coefficient, "
        "kinetic cof, dynamic cof, mean cof, average cof, reibwert, reibungszahl, reibkoeffizient"
    ),
    ("F_t",): (
        "f_t, f_f, f_r, f_x, f_fric, f_friction, f_tan, friction force, frictional force, tangential force, "
        "lateral force, shear force, traction force, tangential load, f_tangential, reibkraft, reibungskraft"
    ),
    ("F_n",): (
        "f_n, f_z, normal force, normal load, load, applied load, contact force, f_normal, force normal, "
        "normalkraft, last"
    ),
    ("mu", "F_t"): "friction, reibung",
    ("sigma_mu",): (
        "sigma_mu, σ_μ, σ_mu, s_mu, sd_mu, std_mu, u_mu, std cof, sd cof, sigma cof, cof std, cof sd, mu std, "
        "mu sd, mu_std, mu_sd, mu_err, mu_error, cof error, d_mu, delta_mu, mu uncertainty, uncertainty of mu, "
        "standard deviation of mu, std of mu, std dev of mu, standard error of mu"
    ),
    ("sigma_F_t",): (
        "sigma_f_t, σ_f_t, s_f_t, sd_f_t, std_f_t, u_f_t, sigma_f, f_t std, f_t sd, f_t error, "
        "friction force std, sd of f_t, std of f_t, standard deviation of f_t"
    ),
    ("sigma_mu", "sigma_F_t"): (
        "sigma, σ, sd, std, stdev, std dev, stddev, standard deviation, standard error, uncertainty, "
        "standard uncertainty, error, err, scatter, standardabweichung"
    ),
}


def _plain(text: str) -> str:
    """Return a name without capitals, blanks, signs and brackets, which are written in many ways."""
    return re.sub(r"[\s_\-.(){}\\$]", "", text.replace("\N{MICRO SIGN}", "μ").lower())


_MEANINGS = {_plain(word): meanings for meanings, words in _WORDS.items() for word in words.split(", ")}
_BRACKETS = re.compile(r"(?P<name>.*?)\s*/?\s*(?:\[(?P<square>[^\[\]]*)\]|\((?P<round>[^()]*)\))", re.DOTALL)
_SPLITS = re.compile(r"\s+in\s+|\s*/\s*|\s*,\s*|\s+|_")


@dataclass(frozen=True)
class Column:
    """A column by its header.

    Attributes
    ----------
    text : str
        The header, as written.
    meanings : tuple of str
        What it may be, of `KINDS`; empty for a column that is none of these.
    unit : Unit or None
        None where none is written.
    unit_text : str or None
        The unit as written; there without `unit` if it is not known.
    """

    text: str
    meanings: tuple[str, ...]
    unit: Unit | None
    unit_text: str | None

    @classmethod
    def read(cls, text: str) -> "Column":
        """Return what a cell of a header says."""
        text = " ".join(text.split())
        name, unit_text = _parts(text)
        unit = None if unit_text is None else read_unit(unit_text)
        return cls(text, _MEANINGS.get(_plain(name), ()), unit, unit_text)

    def in_unit(self, text: str) -> "Column":
        """Return the column with a unit from the line below its name."""
        text = text.strip().strip("[]()").strip()
        if self.unit_text is not None or not text:
            return self
        return Column(f"{self.text} [{text}]", self.meanings, read_unit(text), text)

    @property
    def possible(self) -> tuple[str, ...]:
        """What the column may be, given its unit."""
        if self.unit is None:
            return self.meanings
        return tuple(meaning for meaning in self.meanings if KINDS[meaning] == self.unit.kind)


def _parts(text: str) -> tuple[str, str | None]:
    """Return a column's name, and its unit as written, None if it has none."""
    if _plain(text) in _MEANINGS and "[" not in text:  # std(mu) has no unit
        return text, None
    if match := _BRACKETS.fullmatch(text):
        square = match["square"]
        return match["name"], (match["round"] if square is None else square).strip()
    for split in _SPLITS.finditer(text):
        name, unit = text[: split.start()], text[split.end() :]
        if _plain(name) in _MEANINGS and (read_unit(unit) is not None or split[0].strip() in ("in", "/", ",")):
            return name, unit.strip()
    return text, None


def read_header(cells: Sequence[str]) -> list[Column]:
    """Return what the cells of a line say as a header."""
    return [Column.read(cell) for cell in cells]


def is_header(columns: Sequence[Column]) -> bool:
    """Whether a line names both a speed and friction, in whatever units."""
    named = {meaning for column in columns for meaning in column.meanings}
    return "v" in named and bool(named & {"mu", "F_t"})


@dataclass(frozen=True)
class Columns:
    """Which columns of a table are needed.

    Attributes
    ----------
    places : dict of str to int
        Where each quantity stands, from 0.
    sizes : dict of str to Fraction
        Its unit in SI units.
    units, names : dict of str to str
        Its unit, empty where none is written, and its header, as written.
    left_out : tuple of str
        Headers of the other columns.
    count : int
        Of all columns.
    """

    places: dict[str, int]
    sizes: dict[str, Fraction]
    units: dict[str, str]
    names: dict[str, str]
    left_out: tuple[str, ...]
    count: int


def choose_columns(columns: Sequence[Column], line: str) -> Columns:
    """Return which column is which quantity.

    Parameters
    ----------
    columns : sequence of Column
    line : str
        Where the header stands, for messages.

    Raises
    ------
    InputError
        Where a quantity is missing, named twice, ambiguous, or in a unit that is not known or not its own.
    """
    found: dict[str, int] = {}
    has_mu = any(column.meanings == ("mu",) for column in columns)
    for place, column in enumerate(columns):
        if not column.meanings or (has_mu and _FORCES & {*column.meanings}):  # forces beside mu are not needed
            continue
        where = f"{line}, column {place + 1}, {_shown(column.text)}"
        _check_unit(column, where)
        meanings = column.possible
        if len(meanings) > 1 and has_mu:
            meanings = ("sigma_mu",)
        if len(meanings) > 1:
            raise InputError(f"{where}: this may be {' or '.join(meanings)}; write which, like {EXPECTED}")
        if (meaning := meanings[0]) in found:
            first = columns[found[meaning]].text
            raise InputError(
                f"{where}: column {found[meaning] + 1}, {_shown(first)}, is {meaning} too; leave one of the two "
                "out, or rename it"
            )
        found[meaning] = place
    wanted = _complete(found, columns, line)
    chosen = {meaning: columns[found[meaning]] for meaning in wanted}
    places = {meaning: found[meaning] for meaning in wanted}
    return Columns(
        places,
        {meaning: column.unit.size if column.unit else Fraction(1) for meaning, column in chosen.items()},
        {meaning: column.unit_text or "" for meaning, column in chosen.items()},
        {meaning: column.text for meaning, column in chosen.items()},
        tuple(column.text for i, column in enumerate(columns) if i not in places.values() and column.text),
        len(columns),
    )


def _check_unit(column: Column, where: str) -> None:
    kinds = {"speed": "of a speed, like m/s, mm/s or m/min", "force": "of a force, like N or mN"}
    kind = next((kinds[KINDS[m]] for m in column.meanings if KINDS[m] in kinds), "of a pure number, like 1 or -")
    if column.unit_text is not None and column.unit is None:
        raise InputError(f"{where}: the unit {_shown(column.unit_text)} is not known here; write one {kind}")
    if column.unit is not None and not column.possible:
        raise InputError(f"{where}: {_shown(column.unit_text or '')} is no unit {kind}; check both")
    if column.unit is None and "v" in column.meanings and column.text.strip("\"' ") != "v":  # V may be volts
        raise InputError(f"{where}: a speed without a unit; write v [m/s], or v [mm/s], whichever it is")


def _complete(found: dict[str, int], columns: Sequence[Column], line: str) -> list[str]:
    """Return the quantities to read, or refuse a table that lacks one."""
    read = f"it has {', '.join(_shown(column.text) for column in columns)[:90]}"
    if "v" not in found:
        raise InputError(f"{line}: no column is the slip speed; {read}; write a header like {EXPECTED}")
    if "mu" in found:
        return ["v", "mu", *(["sigma_mu"] if "sigma_mu" in found else [])]
    if "F_t" not in found or "F_n" not in found:
        missing = "F_n" if "F_t" in found else "mu, or F_t and F_n"
        raise InputError(f"{line}: no column is {missing}; {read}; write a header like {EXPECTED}")
    if (columns[found["F_t"]].unit is None) != (columns[found["F_n"]].unit is None):
        raise InputError(f"{line}: one force has a unit and the other none; write both, like F_t [N], F_n [N]")
    sigmas = [name for name in ("sigma_mu", "sigma_F_t") if name in found]
    forces = [columns[found[name]].unit for name in ("F_t", "sigma_F_t") if name in found]
    if forces[0] is not None and None in forces:
        raise InputError(f"{line}: sigma of F_t has no unit; write it, like sigma_F_t [N]")
    if len(sigmas) > 1:
        raise InputError(f"{line}: sigma is given both of mu and of F_t; leave one out")
    return ["v", "F_t", "F_n", *sigmas]


def _shown(text: str) -> str:
    return repr(text.strip()[:30])
