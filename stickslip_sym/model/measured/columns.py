"""The columns of a table of measurements: their words and units, and which holds which quantity.

One more word or unit is an entry in `_WORDS`, or in `SIZES` of `core.units`. A word may mean more than one
quantity; the unit decides, and where it does not the header is refused.
"""

import math
import re
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple

from stickslip_sym.core.errors import InputError
from stickslip_sym.core.remedies import Argument
from stickslip_sym.core.units import SIZES
from stickslip_sym.model.measured.preamble import WrittenRadius

EXPECTED = "v [m/s],mu or v [mm/s];F_t [N];F_n [N];sigma_mu"
"""Headers that name all that is needed."""
KINDS = {
    "v": ("speed", "rotation"), "mu": ("number",), "F_t": ("force", "torque"), "F_n": ("force",),
    "sigma_mu": ("number",), "sigma_F_t": ("force", "torque"), "n": ("number",),
}  # fmt: skip
"""Every quantity that is read, and what its unit may measure."""
_FORCES = "F_t", "F_n", "sigma_F_t"
_EXAMPLES = {
    "speed": "of a speed, like m/s, mm/s or m/min",
    "force": "of a force, like N or mN",
    "number": "of a pure number, like 1 or -",
}


class Unit(NamedTuple):
    """A unit: what it measures, one of `KINDS`, and its size in m/s, rad/s, N, N m or 1."""

    kind: str
    size: Fraction


_RADIANS_OF_TURN = Fraction(2 * math.pi)
_NUMBERS = ("1", "-", "–", "—", "--", "dimensionless", "none", "N/N")
_UNITS = {
    name: Unit(kind, Fraction(size))
    for kind, text in SIZES.items()
    for name, size in map(str.split, text.split(", "))
} | {name: Unit("number", Fraction(1)) for name in _NUMBERS}
_UNITS |= {
    "rpm": Unit("rotation", _RADIANS_OF_TURN / 60),
    "RPM": Unit("rotation", _RADIANS_OF_TURN / 60),
    "Hz": Unit("rotation", _RADIANS_OF_TURN),  # of a speed: turns in a second
    "rps": Unit("rotation", _RADIANS_OF_TURN),
    "kg": Unit("force", Fraction("9.80665")),  # of a load that weighs as much
}
_WEIGHTS = {
    name: Unit("force", unit.size * Fraction("9.80665"))
    for name, unit in _UNITS.items() if unit.kind == "mass"
} | {"kg": _UNITS["kg"]}  # fmt: skip
"""Units of mass that a column of a force is in: those of what weighs as much."""
_ANGLES = {"rad": Fraction(1), "deg": _RADIANS_OF_TURN / 360, "°": _RADIANS_OF_TURN / 360}
_ANGLES |= dict.fromkeys(("rev", "r", "U", "1", "turn", ""), _RADIANS_OF_TURN)
_POWER_OF_TEN = re.compile(r"(?:10(?:\^|\*\*)?|1[eE])(?P<power>[+-]\d\d?)[ *·]*(?P<unit>[^\W\d].*)")  # 10^-3 m/s
_SUPERSCRIPT = re.compile("[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+")
_TORQUE = re.compile(r"(?P<force>[^\W\d]+?)[ .·*]?(?P<length>m|cm|mm|in|ft)")  # N m, mNm, lbf ft
_SCALED = re.compile(
    r"(?P<size>\d+\.?\d*(?:[eE][+-]?\d{1,3})?)\s*(?P<unit>[^\W\d].*)"
)  # 50 N: of one in the column
_INVERSE = re.compile(r"[ *.·]?(\w+?)(?:\^|\*\*)?[-−]1$")


def _plain_power(match: re.Match[str]) -> str:
    """Return a power in small raised digits as ^-1."""
    return "^" + match[0].replace("⁻", "-").translate(str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹", "0123456789"))


def read_unit(text: str) -> Unit | None:
    """Return the unit that a text names, like ``mm/s``, ``mm s^-1``, ``mm·s⁻¹`` or ``rpm``; None if not known."""
    text = " ".join(_SUPERSCRIPT.sub(_plain_power, text.replace("\N{MICRO SIGN}", "μ")).split())
    text = re.sub(r"^([^\W_]+)(?:_per_|_| per )([^\W_]+)$", r"\1/\2", text)  # mm_s
    if power := _POWER_OF_TEN.fullmatch(text):
        unit = read_unit(power["unit"])
        if unit is None:
            return None
        return Unit(unit.kind, unit.size * Fraction(10) ** int(power["power"]))
    if "/" in text and text.isupper():  # MM/S; no unit of a speed differs from another by its capitals alone
        text = text.lower()
    known = _UNITS.get(text)
    if known is not None:
        return None if known.kind in ("length", "time", "mass") else known
    if torque := _TORQUE.fullmatch(text):
        force = _UNITS.get(torque["force"])
        arm = _UNITS[torque["length"]]
        if force is not None and force.kind == "force":
            return Unit("torque", force.size * arm.size)
        return None
    above, _, below = map(str.strip, (text if "/" in text else _INVERSE.sub(r"/\1", text)).partition("/"))
    length = _UNITS.get(above)
    time = _UNITS.get(below)
    if time is None or time.kind != "time":
        return None
    if above in _ANGLES:
        return Unit("rotation", _ANGLES[above] / time.size)
    if length is not None and length.kind == "length":
        return Unit("speed", length.size / time.size)
    return None


_SPREAD = "sigma|sd|std(dev)?|stdev|(standard)?(error|uncertainty)|standarddeviation|err|scatter"
_BARE_SPREAD = rf"{_SPREAD}|standardabweichung"
_WORDS: dict[str, tuple[str, ...]] = {
    r"(v|vel)(1|2|r|rel|slip|sl|slide|sliding)?|(slip)rate|rpm|drehzahl|(gleit|relativ)?geschwindigkeit": ("v",),
    r"(slip|slide|sliding|rel|relative|surface|lin|linear|belt|track|carriage|stage)?(speed|velocity)": ("v",),
    r"(rotational|rotation|angular|spindle|disc|disk)(speed|velocity)": ("v",),
    r"mu[kd]?|cof|f[trfxy]f[nz]|(coefficient|coeff|coef)(friction|traction)": ("mu",),
    r"(friction|traction)(coefficient|coeff|coef|factor)": ("mu",),
    r"reib(ungs)?koeffizient|reibwert|reibungszahl": ("mu",),
    r"f(t|f|r|x|y|fric|friction|tan|tangential)|reib(ungs)?kraft": ("F_t",),
    r"(friction|frictional|tangential|lateral|shear|traction)(force|load)": ("F_t",),
    r"(friction|frictional|reib|dreh|joint|motor|axis)?(torque|moment)|tau": ("F_t",),
    r"f(n|z|normal)|forcenormal|(normal|contact)force|(normal|applied)?load|normalkraft|last": ("F_n",),
    r"friction|reibung": ("mu", "F_t"),
    rf"(s|u|d|delta|{_SPREAD})(mu|cof)|(mu|cof)({_SPREAD})": ("sigma_mu",),
    rf"(s|u|d|{_SPREAD})ft|(ft|frictionforce)({_SPREAD})|sigmaf": ("sigma_F_t",),
    _BARE_SPREAD: ("sigma_mu", "sigma_F_t"),
    r"n": ("n", "F_n"),
    r"count|numbervalues|repeats|replicates|samples|anzahl": ("n",),
}  # fmt: skip
"""What a name means, its words in small letters without blanks, signs and `_QUALIFIERS`."""
_QUALIFIERS = frozenset({"mean", "average", "avg", "ave", "kinetic", "kin", "dynamic", "dyn", "abs", "of", "the"})
"""Words that change nothing: a mean coefficient of kinetic friction is one."""
_GREEK = str.maketrans({"\N{MICRO SIGN}": " mu ", "μ": " mu ", "σ": " sigma "})
_QUOTIENT = re.compile(r"(?<=\w)\s*[=(\[]\s*F_?[a-z]+\s*/\s*F_?[a-z]+\s*[)\]]?", re.IGNORECASE)  # COF (Fx/Fz)
_RPM = re.compile(r"[\s_,(\[/]*\brpm\b[\s)\]]*", re.IGNORECASE)
_ROLLING = re.compile(r"srr|slide(to)?roll(ing)?(ratio)?|sliproll(ratio)?|sliptorollratio", re.IGNORECASE)
_OF_TORQUE = re.compile("torque|moment|tau", re.IGNORECASE)
_OF_SLIP = re.compile("sli[dp]|rel|diff", re.IGNORECASE)
_MODULE = re.compile(r"^[^\W\d]\w*\.(?=[^\W\d])")  # of a program, before the name of its column: DAQ.COF
_BREAKS = re.compile(r"[\s_\-.:,/|(){}\\$\"']+")
_BRACKETS = re.compile(r"(?P<name>.*?)\s*/?\s*(?:\[(?P<square>[^\[\]]*)\]|\((?P<round>[^()]*)\))", re.DOTALL)
_SPLITS = re.compile(r"\s+in\s+|\s*/\s*|\s*,\s*|\s+|_")


def _name_words(name: str) -> list[str]:
    return [word for word in _BREAKS.split(name.lower().translate(_GREEK)) if word and word not in _QUALIFIERS]


def _plain(name: str) -> str:
    return "".join(_name_words(name))


def _meanings(name: str) -> tuple[str, ...]:
    """Return what a name may mean; two names of one quantity, like friction coefficient mu, mean it too."""
    words = _name_words(name)
    for i in range(len(words)):
        parts = ["".join(part) for part in (words[:i], words[i:]) if part]
        senses = {next((kind for form, kind in _WORDS.items() if re.fullmatch(form, part)), ()) for part in parts}
        if len(senses) == 1 and (meanings := senses.pop()):
            return meanings
    return ()


def _name_and_unit(text: str) -> tuple[str, str]:
    """Return a column's name, and its unit as written, empty if it has none."""
    if _meanings(text) and "[" not in text:  # std(mu) has no unit
        return text, ""
    if match := _BRACKETS.fullmatch(text):
        return match["name"], (match["square"] or match["round"] or "").strip()
    for split in _SPLITS.finditer(text):
        name = text[: split.start()]
        unit = text[split.end() :]
        if _meanings(name) and (read_unit(unit) is not None or split[0].strip() in ("in", "/", ",")):
            return name, unit.strip()
    return text, ""


@dataclass(frozen=True)
class HeaderColumn:
    """A column by its header: its name and unit as written, what it may hold, and its number, from 1."""

    text: str
    name: str
    meanings: tuple[str, ...]
    unit_text: str = ""
    number: int = 0
    chosen: bool = False  # by the user, who may give a unit times a number
    value: str = ""  # of all rows, where the user gave one and no column

    @classmethod
    def read(cls, text: str, number: int = 0) -> "HeaderColumn":
        """Return what a cell of a header says."""
        text = " ".join(text.split())
        plain = _QUOTIENT.sub("", text)
        if not _meanings(_name_and_unit(plain)[0]):
            plain = _MODULE.sub("", plain)
        rest = _RPM.sub(" ", plain.replace("_", " ")).strip("\"' ")
        if rest != plain.replace("_", " ").strip("\"' ") and _meanings(rest) in ((), ("v",)):
            return cls(text, rest or plain, ("v",), "rpm", number)
        name, unit_text = _name_and_unit(plain)
        column = cls(text, name, _meanings(name), unit_text, number)
        if name == "n" and column.turns:
            return replace(column, meanings=("v",))
        return column

    def without(self, quantity: str) -> "HeaderColumn":
        """Return the column as one that does not hold a quantity."""
        return replace(self, meanings=tuple(meaning for meaning in self.meanings if meaning != quantity))

    @property
    def unit(self) -> Unit | None:
        """The unit; None where none is written, or one that is not known."""
        if self.is_mass:
            return _WEIGHTS[self.unit_text]
        if self.chosen and (scaled := _SCALED.fullmatch(self.unit_text)) and (unit := read_unit(scaled["unit"])):
            return Unit(unit.kind, unit.size * Fraction(scaled["size"]))
        return read_unit(self.unit_text)

    @property
    def turns(self) -> bool:
        """Whether its unit is that of a rotational speed."""
        return self.unit is not None and self.unit.kind == "rotation"

    @property
    def is_torque(self) -> bool:
        """Whether it holds a torque, which is a friction force times a radius."""
        if self.unit is not None:
            return self.unit.kind == "torque"
        return not self.unit_text and bool(_OF_TORQUE.search(self.name)) and "F_t" in self.meanings

    @property
    def is_mass(self) -> bool:
        """Whether a force is given by the mass that weighs as much."""
        return self.unit_text in _WEIGHTS and any("force" in KINDS[meaning] for meaning in self.meanings)

    @property
    def possible(self) -> tuple[str, ...]:
        """What the column may hold, with its unit."""
        unit = self.unit
        return tuple(meaning for meaning in self.meanings if unit is None or unit.kind in KINDS[meaning])

    @property
    def size(self) -> Fraction:
        """The size of its unit in SI units, 1 without one."""
        return Fraction(1) if self.unit is None else self.unit.size


def is_header(cells: Sequence[str]) -> bool:
    """Return whether names hold both a speed and friction, in whatever units."""
    named = {meaning for cell in cells for meaning in HeaderColumn.read(cell).meanings}
    return "v" in named and bool(named & {"mu", "F_t"})


def choose_columns(
    cells: Sequence[str],
    where: str,
    chosen: Mapping[str, str | int],
    radius: Fraction | None,
    copies: Container[int] = (),
    written: WrittenRadius | None = None,
) -> dict[str, HeaderColumn]:
    """Return which column holds which quantity: those the user chose, and those that are understood.

    - `copies`: numbers of columns that repeat the name and the cells of an earlier one.
    - `written`: the radius of the track that stands above the table.
    """
    read = [HeaderColumn.read(cell, number) for number, cell in enumerate(cells, 1)]
    headers = [replace(header, meanings=()) if header.number in copies else header for header in read]
    headers = _keep_slip_alone(headers)
    for quantity, text in chosen.items():
        headers = _chosen(headers, where, quantity, str(text).strip(), copies)
    headers = _drop_spreads_of_speed(headers, chosen)
    if forces := [quantity for quantity in _FORCES if quantity in chosen]:
        if "mu" in chosen:
            raise InputError(f"mu and {forces[0]} are chosen; choose mu, or the forces that it is the ratio of")
        headers = [header.without("mu") for header in headers]
    if any({"mu", "F_t"} & {*header.possible} and not header.is_torque for header in headers):
        headers = [header.without("F_t") if header.is_torque else header for header in headers]
    columns = dict[str, HeaderColumn]()
    faults = list[str]()
    rolling = next((header for header in headers if _ROLLING.fullmatch(_BREAKS.sub("", header.name))), None)
    has_mu = any(header.meanings == ("mu",) for header in headers)
    for header in headers:
        meanings = header.meanings
        if has_mu and meanings != ("mu",):  # forces beside mu are not needed
            meanings = tuple(name for name in header.possible or meanings if name in ("v", "sigma_mu", "n"))
        if meanings:
            column = replace(header, meanings=meanings)
            fault = _fault(column, columns, radius, written)
            if rolling and column.meanings == ("v",) and "v" not in chosen and not _OF_SLIP.search(column.name):
                fault = (
                    f"beside {_quoted(rolling.text)} this may be the mean speed of two rolling bodies, and the "
                    f"slip speed that ratio times it; if it is the slip speed, "
                    f"{Argument('columns', {'v': column.number})}"
                )
            if fault:
                faults.append(f"column {column.number}, {_quoted(column.text)}: {fault}")
            columns.setdefault((column.possible or meanings)[0], column)
    if fault := _fault_of_all(columns, radius):
        known = [f"{_quoted(h.text)} as {' or '.join(h.meanings) or 'nothing'}" for h in headers if h.text]
        faults.append(f"{fault}; understood: {', '.join(known)[:300]}")
    if faults:
        before = ", " if faults[0].startswith("column") else ": "
        raise InputError(f"{where}{before}{'; '.join(faults)}")
    return {quantity: columns[quantity] for quantity in KINDS if quantity in columns}


def _drop_spreads_of_speed(headers: Sequence[HeaderColumn], chosen: Mapping[str, str | int]) -> list[HeaderColumn]:
    """Return the columns without a deviation just behind the speed, as in v,std,mu: it is that of the speed."""
    kept = list(headers[:1])
    for before, header in pairwise(headers):
        is_spread = header.meanings and set(header.meanings) <= {"sigma_mu", "sigma_F_t"}
        of_speed = is_spread and before.meanings == ("v",) and re.fullmatch(_BARE_SPREAD, _plain(header.name))
        if of_speed and not chosen.keys() & {*header.meanings}:
            header = replace(header, meanings=())
        kept.append(header)
    return kept


def _keep_slip_alone(headers: Sequence[HeaderColumn]) -> list[HeaderColumn]:
    """Return the columns with one named a slip speed as the only speed, as beside those of two bodies."""
    speeds = [header for header in headers if header.meanings == ("v",)]
    slip = [header for header in speeds if _OF_SLIP.search(header.name)]
    if len(slip) != 1:
        return list(headers)
    return [header.without("v") if header in speeds and header not in slip else header for header in headers]


def _chosen(
    headers: Sequence[HeaderColumn], where: str, quantity: str, text: str, copies: Container[int]
) -> list[HeaderColumn]:
    """Return the columns with the one that the user chose as the only one of a quantity."""
    if quantity not in KINDS:
        raise InputError(f"a column holds {', '.join(KINDS)}, got {quantity!r}")
    for name, unit_text in ((text, ""), _name_and_unit(text)):
        named = [
            header for header in headers if name in (header.text, header.name) and header.number not in copies
        ]
        named = named or [header for header in headers if name == str(header.number)]
        if len(named) == 1:
            others = [header.without(quantity) for header in headers]
            unit_text = unit_text or named[0].unit_text
            column = replace(named[0], meanings=(quantity,), unit_text=unit_text, chosen=True)
            others[others.index(named[0].without(quantity))] = column
            return others
    if quantity == "F_n" and (value := _SCALED.fullmatch(text)):
        force = HeaderColumn(text, text, ("F_n",), value["unit"].strip(), chosen=True, value=value["size"])
        if force.unit is not None and force.unit.kind == "force":
            return [*(header.without("F_n") for header in headers), force]
    known = ", ".join(_quoted(header.text) for header in headers)[:200]
    raise InputError(
        f"{where}: {len(named) or 'no'} columns are {_quoted(name)}; it has {known}; give the name of one, or its "
        f"number from 1 to {len(headers)}"
    )


def _fault(
    column: HeaderColumn,
    columns: Mapping[str, HeaderColumn],
    radius: Fraction | None,
    written: WrittenRadius | None,
) -> str:
    """Return what is wrong with a column that is understood: its unit, two meanings, or another one like it."""
    unit = column.unit
    possible = column.possible
    if not possible or (column.unit_text and unit is None):
        example = _EXAMPLES[KINDS[column.meanings[0]][0]]
        return f"{_quoted(column.unit_text)} is no unit {'' if unit else 'known here '}{example}"
    if "v" in possible and unit is None and column.text.strip("\"' ") not in ("v", ""):  # V may be volts
        return "a speed without a unit; write v [m/s], or v [mm/s], whichever it is"
    if column.is_torque and column.unit is None:
        return "a torque without a unit; write torque [N m]"
    if (column.turns or column.is_torque) and radius is None and (written is None or written.size is None):
        need = f"{column.unit_text} is a rotational speed; give the radius of the track"
        if column.is_torque:
            need = f"{column.unit_text} is a torque; give the radius at which friction acts"
        if written is None:
            return f"{need} in m, like {Argument('radius', 0.03)}"
        length = f"{written.text} mm" if written.text[-1].isdigit() else written.text
        return (
            f"{need}: line {written.line} has {_quoted(written.name)} = {written.text}; if that is the track's in "
            f"{length.split()[-1]}, {Argument('radius', length)}"
        )
    if len(possible) > 1:
        return f"this may be {' or '.join(possible)}"
    if column.unit_text == "%" and possible[0] == "sigma_mu":
        return "this may be in per cent of each mu, or of 1; write a column of standard deviations without unit"
    other = columns.get(possible[0])
    if other is None:
        return ""
    both = " or ".join(str(Argument("columns", {possible[0]: same.number})) for same in (other, column))
    return f"column {other.number}, {_quoted(other.text)}, is {possible[0]} too; give {both}"


def _fault_of_all(columns: Mapping[str, HeaderColumn], radius: Fraction | None) -> str:
    """Return which quantity a table lacks, or which of its columns do not go together."""
    by_force = "mu" not in columns
    missing = ["no column is the slip speed"] * ("v" not in columns)
    if by_force and not {"F_t", "F_n"} <= columns.keys():
        missing.append("no column is F_n" if "F_t" in columns else "no column is mu, or F_t and F_n")
    if missing:
        return " and ".join(missing)
    forces = [columns[name] for name in ("F_t", "F_n", "sigma_F_t") if by_force and name in columns]
    if len({column.unit is None for column in forces}) > 1:
        return "one force has a unit and another none; write those of all, like F_t [N], F_n [N], sigma_F_t [N]"
    if {"sigma_mu", "sigma_F_t"} <= columns.keys():
        return "there are sigma of mu and of F_t; leave one out"
    if radius is not None and not (columns["v"].turns or any(column.is_torque for column in columns.values())):
        return f"radius = {float(radius):g} m is for a rotational speed; here v is a speed already"
    return ""


def _quoted(text: str) -> str:
    return repr(text.strip()[:40])
