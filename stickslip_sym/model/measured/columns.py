"""The columns of a table of measurements: their words and units, and which holds which quantity.

One more word or unit is an entry in `_WORDS` or `_UNITS`. A word may mean more than one quantity; the unit
decides, and where it does not the header is refused.
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import NamedTuple

from stickslip_sym.core.errors import InputError

EXPECTED = "v [m/s],mu or v [mm/s];F_t [N];F_n [N];sigma_mu"
KINDS = {
    "v": ("speed", "rotation"), "mu": ("number",), "F_t": ("force",), "F_n": ("force",), "sigma_mu": ("number",),
    "sigma_F_t": ("force",), "n": ("number",),
}  # fmt: skip
"""Every quantity that is read, and what its unit may measure."""
_EXAMPLES = {
    "speed": "of a speed, like m/s, mm/s or m/min",
    "force": "of a force, like N or mN",
    "number": "of a pure number, like 1 or -",
}


class Unit(NamedTuple):
    """A unit: what it measures, one of `KINDS`, and its size in m/s, rad/s, N or 1."""

    kind: str
    size: Fraction


def _sizes(text: str) -> dict[str, Fraction]:
    return {name: Fraction(size) for name, size in map(str.split, text.split(", "))}


_TURN = Fraction(2 * math.pi)
_LENGTHS = _sizes(
    "nm 1e-9, um 1e-6, μm 1e-6, micron 1e-6, mm 1e-3, cm 1e-2, dm 1e-1, m 1, km 1e3, in 0.0254, inch 0.0254, "
    "ft 0.3048, mi 1609.344"
)
_ANGLES = {"rad": Fraction(1), "deg": _TURN / 360, "°": _TURN / 360}
_ANGLES |= dict.fromkeys(("rev", "r", "U", "1", "turn"), _TURN)
_TIMES = _sizes("ms 1e-3, s 1, sec 1, second 1, min 60, minute 60, h 3600, hr 3600, hour 3600")
_NAMED = {
    "number": dict.fromkeys(("1", "-", "–", "—", "--", "dimensionless", "none", "N/N"), Fraction(1)),
    "speed": _sizes("mps 1, kph 5/18, kmh 5/18, mph 0.44704, ips 0.0254, fps 0.3048, fpm 0.00508, knot 463/900"),
    "rotation": {"rpm": _TURN / 60, "RPM": _TURN / 60, "rps": _TURN},
    "force": _sizes(
        "nN 1e-9, uN 1e-6, μN 1e-6, mN 1e-3, cN 1e-2, N 1, newton 1, daN 10, kN 1e3, MN 1e6, kgf 9.80665, "
        "kp 9.80665, gf 0.00980665, lbf 4.4482216152605, ozf 0.27801385095378125, dyn 1e-5"
    ),
}
_UNITS = {name: Unit(kind, size) for kind, sizes in _NAMED.items() for name, size in sizes.items()} | {
    f"{above}/{below}": Unit(kind, size / time)
    for kind, sizes in (("speed", _LENGTHS), ("rotation", _ANGLES))
    for above, size in sizes.items()
    for below, time in _TIMES.items()
}
"""Capitals count, as they tell mN from MN."""
_INVERSE = re.compile(r"[ *.·]?(\w+?)(?:\^|\*\*)?[-−]1$")


def read_unit(text: str) -> Unit | None:
    """Return the unit that a text names, like ``mm/s``, ``mm s^-1``, ``mm·s⁻¹`` or ``rpm``; None if not known."""
    text = " ".join(text.replace("\N{MICRO SIGN}", "μ").replace("⁻¹", "^-1").split())
    above, _, below = (text if "/" in text else _INVERSE.sub(r"/\1", text)).partition("/")
    return _UNITS.get(text) or _UNITS.get(f"{above.strip() or '1'}/{below.strip()}")


_SPREAD = "sigma|sd|std(dev)?|stdev|(standard)?(error|uncertainty)|standarddeviation|err|scatter"
_WORDS: dict[str, tuple[str, ...]] = {
    r"(v|vel)(r|rel|slip|sl|slide|sliding)?|(slip)rate|rpm|drehzahl|(gleit|relativ)?geschwindigkeit": ("v",),
    r"(slip|slide|sliding|rel|relative|surface|lin|linear|belt|track|rotational|angular|spindle)?(speed|velocity)":
        ("v",),
    r"mu[kd]?|cof|ftfn|(coefficient|coeff)friction|friction(coefficient|coeff|factor)": ("mu",),
    r"reib(ungs)?koeffizient|reibwert|reibungszahl": ("mu",),
    r"f(t|f|r|x|fric|friction|tan|tangential)|reib(ungs)?kraft": ("F_t",),
    r"(friction|frictional|tangential|lateral|shear|traction)(force|load)": ("F_t",),
    r"f(n|z|normal)|forcenormal|(normal|contact)force|(normal|applied)?load|normalkraft|last": ("F_n",),
    r"friction|reibung": ("mu", "F_t"),
    rf"(s|u|d|delta|{_SPREAD})(mu|cof)|(mu|cof)({_SPREAD})": ("sigma_mu",),
    rf"(s|u|d|{_SPREAD})ft|(ft|frictionforce)({_SPREAD})|sigmaf": ("sigma_F_t",),
    rf"{_SPREAD}|standardabweichung": ("sigma_mu", "sigma_F_t"),
    r"n": ("n", "F_n"),
    r"count|numbervalues|repeats|replicates|samples|anzahl": ("n",),
}  # fmt: skip
"""What a name means, its words in small letters without blanks, signs and `_QUALIFIERS`."""
_QUALIFIERS = frozenset({"mean", "average", "avg", "ave", "kinetic", "kin", "dynamic", "dyn", "abs", "of", "the"})
"""Words that change nothing: a mean coefficient of kinetic friction is one."""
_GREEK = str.maketrans({"\N{MICRO SIGN}": " mu ", "μ": " mu ", "σ": " sigma "})
_BREAKS = re.compile(r"[\s_\-.:,/|(){}\\$\"']+")
_TORQUE = re.compile(r"torque|moment|[\[(]\s*[mk]?N\s?[·*.]?\s?[cm]?m\s*[\])]", re.IGNORECASE)


def _words(text: str) -> list[str]:
    """Return the words of a name without capitals, signs and what qualifies them."""
    return [word for word in _BREAKS.split(text.lower().translate(_GREEK)) if word and word not in _QUALIFIERS]


def _meanings(name: str) -> tuple[str, ...]:
    """Return what a name may mean; two names of one quantity, like friction coefficient mu, mean it too."""
    words = _words(name)
    for i in range(len(words)):
        parts = ["".join(part) for part in (words[:i], words[i:]) if part]
        found = {next((kind for form, kind in _WORDS.items() if re.fullmatch(form, part)), ()) for part in parts}
        if len(found) == 1 and (meanings := found.pop()):
            return meanings
    return ()


_BRACKETS = re.compile(r"(?P<name>.*?)\s*/?\s*(?:\[(?P<square>[^\[\]]*)\]|\((?P<round>[^()]*)\))", re.DOTALL)
_SPLITS = re.compile(r"\s+in\s+|\s*/\s*|\s*,\s*|\s+|_")


def _name_and_unit(text: str) -> tuple[str, str]:
    """Return a column's name, and its unit as written, empty if it has none."""
    if _meanings(text) and "[" not in text:  # std(mu) has no unit
        return text, ""
    if match := _BRACKETS.fullmatch(text):
        return match["name"], (match["square"] or match["round"] or "").strip()
    for split in _SPLITS.finditer(text):
        name, unit = text[: split.start()], text[split.end() :]
        if _meanings(name) and (read_unit(unit) is not None or split[0].strip() in ("in", "/", ",")):
            return name, unit.strip()
    return text, ""


@dataclass(frozen=True)
class Column:
    """A column by its header: its name and unit as written, what it may hold, and where it stands, from 0."""

    text: str
    name: str
    meanings: tuple[str, ...]
    unit_text: str = ""
    position: int = 0
    size: Fraction = Fraction(1)

    @classmethod
    def read(cls, text: str, unit: str = "") -> "Column":
        """Return what a cell of a header says, and the cell below it of a row of units."""
        text, unit = " ".join(text.split()), unit.strip().strip("[]()").strip()
        name, unit_text = _name_and_unit(text)
        if unit and not unit_text:
            text, unit_text = f"{text} [{unit}]", unit
        return cls(text, name, _meanings(name), unit_text or ("rpm" if _words(name) == ["rpm"] else ""))

    @property
    def unit(self) -> Unit | None:
        """The unit; None where none is written, or one that is not known."""
        return read_unit(self.unit_text)

    @property
    def turns(self) -> bool:
        """Whether its unit is that of a rotational speed."""
        return self.unit is not None and self.unit.kind == "rotation"

    @property
    def possible(self) -> tuple[str, ...]:
        """What the column may hold, with its unit."""
        unit = self.unit
        return tuple(one for one in self.meanings if unit is None or unit.kind in KINDS[one])


def is_header(cells: Sequence[str]) -> bool:
    """Return whether names hold both a speed and friction, in whatever units."""
    named = {meaning for cell in cells for meaning in Column.read(cell).meanings}
    return "v" in named and bool(named & {"mu", "F_t"})


def _refuse(where: str, *rules: tuple[object, str]) -> None:
    """Raise an `InputError` with the words of the first rule whose condition is true."""
    for wrong, words in rules:
        if wrong:
            raise InputError(f"{where}: {words}")


def choose_columns(
    headers: Sequence[Column], line: str, chosen: Mapping[str, str | int], radius: Fraction | None
) -> dict[str, Column]:
    """Return which column holds which quantity: those the user chose, and those that are understood."""
    headers = list(headers)
    for quantity, text in chosen.items():
        _choose(headers, line, quantity, str(text).strip())
    columns: dict[str, Column] = {}
    has_mu = any(header.meanings == ("mu",) for header in headers)
    for i, header in enumerate(headers):
        meanings = header.meanings
        if has_mu and meanings != ("mu",):  # forces beside mu are not needed
            meanings = tuple(one for one in header.possible or meanings if one in ("v", "sigma_mu", "n"))
        if meanings:
            column = replace(header, meanings=meanings, position=i)
            _check(column, line, columns, radius)
            size = column.unit.size if column.unit else Fraction(1)
            columns[column.possible[0]] = replace(column, size=size * (radius or 1) if column.turns else size)
    _check_complete(columns, headers, line)
    if radius is not None and not columns["v"].turns:
        words = f"radius = {float(radius):g} m is for a rotational speed; here v is a speed already"
        raise InputError(f"{line}: {words}")
    kept = ("v", "mu", "sigma_mu", "n") if "mu" in columns else ("v", "F_t", "F_n", "sigma_mu", "sigma_F_t", "n")
    return {quantity: columns[quantity] for quantity in kept if quantity in columns}


def _choose(headers: list[Column], line: str, quantity: str, text: str) -> None:
    """Make the column that the user chose for a quantity the only one of it."""
    if quantity not in KINDS:
        raise InputError(f"a column holds {', '.join(KINDS)}, got {quantity!r}")

    def named(name: str) -> list[int]:
        matches = [i for i, header in enumerate(headers) if name in (header.text, header.name)]
        numbered = not matches and name.isdecimal() and 1 <= int(name) <= len(headers)
        return [int(name) - 1] if numbered else matches

    name, unit_text = (text, "") if named(text) else _name_and_unit(text)
    matches = named(name)
    if len(matches) != 1:
        known = ", ".join(_quoted(header.text) for header in headers)[:200]
        raise InputError(
            f"{line}: {len(matches) or 'no'} columns are {_quoted(name)}; it has {known}; give the name of one, "
            f"or its number from 1 to {len(headers)}"
        )
    for i, header in enumerate(headers):
        headers[i] = replace(header, meanings=tuple(one for one in header.meanings if one != quantity))
    own = headers[matches[0]]
    headers[matches[0]] = replace(own, meanings=(quantity,), unit_text=unit_text or own.unit_text)


def _check(column: Column, line: str, columns: Mapping[str, Column], radius: Fraction | None) -> None:
    """Refuse a column that is understood for its unit, for two meanings, or as another one holds the same."""
    unit, meanings, shown = column.unit, column.possible, _quoted(column.unit_text)
    example = _EXAMPLES[KINDS[column.meanings[0]][0]]
    fitting = [name for name, kinds in KINDS.items() if unit is not None and unit.kind in kinds]
    choice = _choice((meanings or fitting or column.meanings)[0], column.text)
    other = columns.get(meanings[0]) if meanings else None
    twice = f"column {other.position + 1}, {_quoted(other.text)}, is {meanings[0]} too" if other else ""
    _refuse(
        f"{line}, column {column.position + 1}, {_quoted(column.text)}",
        (column.unit_text and unit is None, f"the unit {shown} is not known here; write one {example}"),
        (not meanings, f"{shown} is no unit {example}; check both, or {choice}"),
        ("v" in meanings and unit is None and column.text.strip("\"' ") not in ("v", ""),  # V may be volts
         "a speed without a unit; write v [m/s], or v [mm/s], whichever it is"),
        (column.turns and radius is None,
         f"{column.unit_text} is a rotational speed; give the radius of the track in m, like radius=0.03"),
        (len(meanings) > 1, f"this may be {' or '.join(meanings)}; {choice}"),
        (other, f"{twice}; {choice}"),
    )  # fmt: skip


def _check_complete(columns: Mapping[str, Column], headers: Sequence[Column], line: str) -> None:
    """Refuse a table that lacks a quantity, with what is understood, or whose forces do not go together."""
    forces = {"F_t", "F_n"} & columns.keys()
    missing = "the slip speed" if "v" not in columns else "F_n" if "F_t" in forces else "mu, or F_t and F_n"
    known = [f"{_quoted(h.text)} as {' or '.join(h.meanings)}" for h in headers if h.meanings]
    other = [h.text for h in headers if not h.meanings and h.text]
    torque = next((h.text for h in headers if _TORQUE.search(h.text)), None)
    wanted = _choice("mu" if any("v" in h.meanings for h in headers) else "v", other[0] if other else "COF")
    words = [
        f"understood: {', '.join(known)}" if known else "",
        f"not understood: {', '.join(map(_quoted, other))[:120]}" if other else "",
        f"{_quoted(torque)} is a torque: divide it by its lever arm for F_t [N]" if torque else "",
        f"{wanted}, or write a header like {EXPECTED}",
    ]
    bare = {name for name, column in columns.items() if column.unit is None}
    by_force = "mu" not in columns
    _refuse(
        line,
        ("v" not in columns or (by_force and len(forces) < 2),
         f"no column is {missing}; {'; '.join(filter(None, words))}"),
        (by_force and len(bare & forces) == 1,
         "one force has a unit and the other none; write both, like F_t [N], F_n [N]"),
        (by_force and "sigma_F_t" in columns and len(bare & {"F_t", "sigma_F_t"}) == 1,
         "sigma of F_t has no unit; write it, like sigma_F_t [N]"),
        (by_force and {"sigma_mu", "sigma_F_t"} <= columns.keys(),
         "there are sigma of mu and of F_t; leave one out"),
    )  # fmt: skip


def _choice(quantity: str, text: str) -> str:
    return f"name the column, like columns={{'{quantity}': '{text[:40]}'}}"


def _quoted(text: str) -> str:
    return repr(text.strip()[:40])
