"""The columns of a table of measurements: their words and units, and which holds which quantity.

One more word or unit is an entry in `_WORDS` or `_UNITS`. A word may mean more than one quantity; the unit
decides, and where it does not the header is refused.
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from stickslip_sym.core.errors import InputError

__all__ = ["EXPECTED", "Column", "Header", "Unit", "choose_columns", "is_header", "read_unit"]

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
EXPECTED = "v [m/s],mu or v [mm/s];F_t [N];F_n [N];sigma_mu"

_GRAVITY = Fraction(980665, 10**5)  # m/s^2, standard
_POUND = Fraction("0.45359237")  # kg
_TURN = Fraction(2 * math.pi)
_POWERS = {"n": -9, "u": -6, "μ": -6, "m": -3, "c": -2, "d": -1, "": 0, "da": 1, "k": 3, "M": 6}


def _multiples(unit: str, prefixes: str) -> dict[str, Fraction]:
    """Return the sizes of a unit with prefixes, parted by commas."""
    return {prefix + unit: Fraction(10) ** _POWERS[prefix] for prefix in prefixes.split(",")}


_LENGTHS = _multiples("m", ",n,u,μ,m,c,d,k") | {
    "micron": Fraction(1, 10**6), "in": Fraction("0.0254"), "inch": Fraction("0.0254"), "ft": Fraction("0.3048"),
    "mi": Fraction("1609.344"),
}  # fmt: skip
_TIMES = {
    "s": Fraction(1), "sec": Fraction(1), "second": Fraction(1), "ms": Fraction(1, 1000), "min": Fraction(60),
    "minute": Fraction(60), "h": Fraction(3600), "hr": Fraction(3600), "hour": Fraction(3600),
}  # fmt: skip
_ANGLES = {
    "rad": Fraction(1), "deg": _TURN / 360, "°": _TURN / 360, "rev": _TURN, "r": _TURN, "U": _TURN, "1": _TURN,
    "turn": _TURN,
}  # fmt: skip
_UNITS: dict[str, dict[str, Fraction]] = {
    "number": dict.fromkeys(("1", "-", "–", "—", "--", "dimensionless", "none", "N/N"), Fraction(1)),
    "speed": {
        "mps": Fraction(1), "kph": Fraction(5, 18), "kmh": Fraction(5, 18), "mph": _LENGTHS["mi"] / 3600,
        "ips": _LENGTHS["in"], "fps": _LENGTHS["ft"], "fpm": _LENGTHS["ft"] / 60, "knot": Fraction(1852, 3600),
    },
    "rotation": {"rpm": _TURN / 60, "RPM": _TURN / 60, "rps": _TURN},
    "force": _multiples("N", ",n,u,μ,m,c,da,k,M") | {
        "newton": Fraction(1), "kgf": _GRAVITY, "kp": _GRAVITY, "gf": _GRAVITY / 1000,
        "lbf": _POUND * _GRAVITY, "ozf": _POUND / 16 * _GRAVITY, "dyn": Fraction(1, 10**5),
    },
}  # fmt: skip
_INVERSE = re.compile(r"[ *.·]?(\w+?)(?:\^|\*\*)?[-−]1$")

_WORDS: dict[tuple[str, ...], str] = {
    ("v",): (
        "v, speed, velocity, vel, v r, v rel, v slip, v sl, v slide, v sliding, slip speed, slip velocity, "
        "slip rate, sliding speed, sliding velocity, slide speed, relative speed, relative velocity, rel speed, "
        "rel velocity, surface speed, surface velocity, linear speed, linear velocity, lin speed, lin velocity, "
        "belt speed, belt velocity, track speed, gleitgeschwindigkeit, geschwindigkeit, relativgeschwindigkeit, "
        "rotational speed, angular velocity, angular speed, spindle speed, rpm, drehzahl"
    ),
    ("mu",): (
        "mu, cof, mu k, mu d, friction coefficient, coefficient of friction, coeff of friction, friction coeff, "
        "coefficient friction, friction factor, reibwert, reibungszahl, reibkoeffizient, "
        "reibungskoeffizient, f t f n"
    ),
    ("F_t",): (
        "f t, f f, f r, f x, f fric, f friction, f tan, f tangential, friction force, frictional force, "
        "tangential force, lateral force, shear force, traction force, tangential load, reibkraft, reibungskraft"
    ),
    ("F_n",): (
        "f n, f z, f normal, force normal, normal force, normal load, load, applied load, contact force, "
        "normalkraft, last"
    ),
    ("mu", "F_t"): "friction, reibung",
    ("sigma_mu",): (
        "sigma mu, s mu, sd mu, std mu, u mu, d mu, delta mu, mu std, mu sd, mu err, mu error, mu uncertainty, "
        "std cof, sd cof, sigma cof, cof std, cof sd, cof error, uncertainty of mu, standard deviation of mu, "
        "std of mu, std dev of mu, standard error of mu"
    ),
    ("sigma_F_t",): (
        "sigma f t, s f t, sd f t, std f t, u f t, sigma f, f t std, f t sd, f t error, friction force std, "
        "sd of f t, std of f t, standard deviation of f t"
    ),
    ("sigma_mu", "sigma_F_t"): (
        "sigma, sd, std, stdev, std dev, stddev, standard deviation, standard error, uncertainty, "
        "standard uncertainty, error, err, scatter, standardabweichung"
    ),
    ("n", "F_n"): "n",
    ("n",): "count, number of values, repeats, replicates, samples, anzahl",
}
_QUALIFIERS = frozenset({"mean", "average", "avg", "ave", "kinetic", "kin", "dynamic", "dyn", "abs", "of", "the"})
"""Words that change nothing: a mean coefficient of kinetic friction is one."""
_TORQUE = re.compile(r"torque|moment|[\[(]\s*[mk]?N\s?[·*.]?\s?[cm]?m\s*[\])]", re.IGNORECASE)
_BREAKS = re.compile(r"[\s_\-.:,/|(){}\\$\"']+")


def _words(text: str) -> list[str]:
    """Return the words of a name without capitals, signs and what qualifies them."""
    text = text.lower()
    for sign, letters in (("\N{MICRO SIGN}", " mu "), ("μ", " mu "), ("σ", " sigma ")):
        text = text.replace(sign, letters)
    return [word for word in _BREAKS.split(text) if word and word not in _QUALIFIERS]


_MEANINGS = {"".join(_words(word)): meanings for meanings, words in _WORDS.items() for word in words.split(", ")}


def _meanings(name: str) -> tuple[str, ...]:
    """Return what a name may mean; two names of one quantity, like friction coefficient mu, mean it too."""
    words = _words(name)
    if meanings := _MEANINGS.get("".join(words)):
        return meanings
    for i in range(1, len(words)):
        first, second = (_MEANINGS.get("".join(half), ()) for half in (words[:i], words[i:]))
        if first and first == second:
            return first
    return ()


@dataclass(frozen=True)
class Unit:
    """A unit: what it measures, one of `KINDS`, and its size in m/s, rad/s, N or 1."""

    kind: str
    size: Fraction


def read_unit(text: str) -> Unit | None:
    """Return the unit that a text names; None for one that is not known.

    Capitals count, as they tell mN from MN. A speed is a length over a time in any of the usual ways:
    ``mm/s``, ``mm s^-1``, ``mm*s**-1``, ``mm·s⁻¹``; a rotational speed is an angle over a time, like ``rev/min``.
    """
    text = " ".join(text.replace("\N{MICRO SIGN}", "μ").replace("⁻¹", "^-1").split())
    for kind, sizes in _UNITS.items():
        if text in sizes:
            return Unit(kind, sizes[text])
    above, over, below = (part.strip() for part in text.partition("/"))
    if not over and (inverse := _INVERSE.search(text)):
        above, below = text[: inverse.start()].strip() or "1", inverse[1]
    for kind, sizes in (("speed", _LENGTHS), ("rotation", _ANGLES)):
        if above in sizes and below in _TIMES:
            return Unit(kind, sizes[above] / _TIMES[below])
    return None


_BRACKETS = re.compile(r"(?P<name>.*?)\s*/?\s*(?:\[(?P<square>[^\[\]]*)\]|\((?P<round>[^()]*)\))", re.DOTALL)
_SPLITS = re.compile(r"\s+in\s+|\s*/\s*|\s*,\s*|\s+|_")


@dataclass(frozen=True)
class Header:
    """A column's name.

    Attributes
    ----------
    text : str
        As written.
    name : str
        Without its unit.
    meanings : tuple of str
        What the column may hold, of `KINDS`; empty where the name is not understood.
    unit_text : str
        The unit as written; empty where there is none.
    """

    text: str
    name: str
    meanings: tuple[str, ...]
    unit_text: str = ""

    @classmethod
    def read(cls, text: str) -> "Header":
        """Return what a cell of a header says."""
        text = " ".join(text.split())
        name, unit_text = _name_and_unit(text)
        return cls(text, name, _meanings(name), unit_text or ("rpm" if "".join(_words(name)) == "rpm" else ""))

    def in_unit(self, text: str) -> "Header":
        """Return the name with a unit from the line below it."""
        text = text.strip().strip("[]()").strip()
        if self.unit_text or not text:
            return self
        return replace(self, text=f"{self.text} [{text}]", unit_text=text)

    @property
    def unit(self) -> Unit | None:
        """The unit; None where none is written, or one that is not known."""
        return read_unit(self.unit_text)

    @property
    def possible(self) -> tuple[str, ...]:
        """What the column may hold, with its unit."""
        if self.unit is None:
            return self.meanings
        return tuple(meaning for meaning in self.meanings if self.unit.kind in KINDS[meaning])


def _name_and_unit(text: str) -> tuple[str, str]:
    """Return a column's name, and its unit as written, empty if it has none."""
    if _meanings(text) and "[" not in text:  # std(mu) has no unit
        return text, ""
    if match := _BRACKETS.fullmatch(text):
        square = match["square"]
        return match["name"], (match["round"] if square is None else square).strip()
    for split in _SPLITS.finditer(text):
        name, unit = text[: split.start()], text[split.end() :]
        if _meanings(name) and (read_unit(unit) is not None or split[0].strip() in ("in", "/", ",")):
            return name, unit.strip()
    return text, ""


def is_header(headers: Sequence[Header]) -> bool:
    """Return whether names hold both a speed and friction, in whatever units."""
    named = {meaning for header in headers for meaning in header.meanings}
    return "v" in named and bool(named & {"mu", "F_t"})


@dataclass(frozen=True)
class Column:
    """A column that is read: its position from 0, its name, and the size of its unit in SI units."""

    position: int
    header: Header
    size: Fraction


def choose_columns(
    headers: Sequence[Header], line: str, chosen: Mapping[str, str | int], radius: Fraction | None
) -> dict[str, Column]:
    """Return which column holds which quantity.

    - `line`: the file and the line of the header, for messages.
    - `chosen`: columns by quantity that the user names, each by its name or its number from 1.
    - `radius`: of the track in m, which makes a speed of a rotational speed.

    Raises `InputError` where a quantity is missing, named twice, ambiguous, or in a unit that is not known or not
    its own; where a unit is a rotational speed's and there is no radius, or there is a radius for nothing.
    """
    headers = list(headers)
    for quantity, text in chosen.items():
        headers = _with_choice(headers, line, quantity, str(text).strip())
    columns: dict[str, Column] = {}
    has_mu = any(header.meanings == ("mu",) for header in headers)
    for i, header in enumerate(headers):
        if has_mu and {"F_t", "F_n"} & {*header.meanings}:  # forces beside mu are not needed
            header = replace(header, meanings=("n",) if "n" in header.possible else ())
        if not header.meanings:
            continue
        where = f"{line}, column {i + 1}, {_quoted(header.text)}"
        _check_unit(header, where, radius)
        meanings = header.possible
        if len(meanings) > 1 and has_mu:
            meanings = tuple(meaning for meaning in meanings if meaning in ("sigma_mu", "n"))
        quantity, choice = meanings[0], _choice(meanings[0], header.text)
        if len(meanings) > 1:
            raise InputError(f"{where}: this may be {' or '.join(meanings)}; {choice}")
        if other := columns.get(quantity):
            second = f"column {other.position + 1}, {_quoted(other.header.text)}, is {quantity} too"
            raise InputError(f"{where}: {second}; {choice}")
        size = Fraction(1) if header.unit is None else header.unit.size
        if header.unit is not None and header.unit.kind == "rotation" and radius is not None:
            size, radius = size * radius, None
        columns[quantity] = Column(i, header, size)
    read = _complete(columns, headers, line)
    if radius is not None:
        raise InputError(
            f"{line}: radius = {float(radius):g} m is for a rotational speed; here v is a speed already"
        )
    return {quantity: columns[quantity] for quantity in read}


def _with_choice(headers: Sequence[Header], line: str, quantity: str, text: str) -> list[Header]:
    """Return the headers with the column that the user chose for a quantity as the only one of it."""
    if quantity not in KINDS:
        raise InputError(f"a column holds {', '.join(KINDS)}, got {quantity!r}")
    matches, name, unit_text = _named(headers, text), text, ""
    if not matches:
        name, unit_text = _name_and_unit(text)
        matches = _named(headers, name)
    if len(matches) != 1:
        known = ", ".join(_quoted(header.text) for header in headers)[:200]
        raise InputError(
            f"{line}: {len(matches) or 'no'} columns are {_quoted(name)}; it has {known}; give the name of one, "
            f"or its number from 1 to {len(headers)}"
        )
    changed = [replace(h, meanings=tuple(other for other in h.meanings if other != quantity)) for h in headers]
    own = headers[matches[0]]
    changed[matches[0]] = replace(own, meanings=(quantity,), unit_text=unit_text or own.unit_text)
    return changed


def _named(headers: Sequence[Header], name: str) -> list[int]:
    """Return the columns of a name, or else of a number from 1."""
    matches = [i for i, header in enumerate(headers) if name in (header.text, header.name)]
    numbered = not matches and name.isdecimal() and 1 <= int(name) <= len(headers)
    return [int(name) - 1] if numbered else matches


def _check_unit(header: Header, where: str, radius: Fraction | None) -> None:
    kind = KINDS[header.meanings[0]][0]
    if header.unit_text and header.unit is None:
        raise InputError(
            f"{where}: the unit {_quoted(header.unit_text)} is not known here; write one {_EXAMPLES[kind]}"
        )
    if header.unit is not None and not header.possible:
        raise InputError(f"{where}: {_quoted(header.unit_text)} is no unit {_EXAMPLES[kind]}; check both")
    if "v" not in header.meanings:
        return
    if header.unit is None and header.text.strip("\"' ") not in ("v", ""):  # V may be volts
        raise InputError(f"{where}: a speed without a unit; write v [m/s], or v [mm/s], whichever it is")
    if header.unit is not None and header.unit.kind == "rotation" and radius is None:
        raise InputError(
            f"{where}: {header.unit_text} is a rotational speed; give the radius of the track in m, like "
            "radius=0.03"
        )


def _complete(columns: Mapping[str, Column], headers: Sequence[Header], line: str) -> list[str]:
    """Return the quantities to read, or refuse a table that lacks one."""
    sigmas = [name for name in ("sigma_mu", "sigma_F_t") if name in columns]
    counted = [name for name in ("n",) if name in columns]
    if "v" in columns and "mu" in columns:
        return ["v", "mu", *(name for name in sigmas if name == "sigma_mu"), *counted]
    forces = {"F_t", "F_n"} & columns.keys()
    if "v" not in columns or len(forces) < 2:
        missing = "the slip speed" if "v" not in columns else "F_n" if "F_t" in forces else "mu, or F_t and F_n"
        raise InputError(f"{line}: no column is {missing}; {_understanding(headers)}")
    without = {name for name, column in columns.items() if column.header.unit is None}
    if len(without & forces) == 1:
        raise InputError(f"{line}: one force has a unit and the other none; write both, like F_t [N], F_n [N]")
    if len(without & {"F_t", "sigma_F_t"}) == 1 and "sigma_F_t" in columns:
        raise InputError(f"{line}: sigma of F_t has no unit; write it, like sigma_F_t [N]")
    if len(sigmas) > 1:
        raise InputError(f"{line}: there are sigma of mu and of F_t; leave one out")
    return ["v", "F_t", "F_n", *sigmas, *counted]


def _understanding(headers: Sequence[Header]) -> str:
    """Return which columns are understood and which are not, and how to name one."""
    known = [f"{_quoted(h.text)} as {' or '.join(h.meanings)}" for h in headers if h.meanings]
    other = [_quoted(h.text) for h in headers if not h.meanings and h.text]
    words = [f"understood: {', '.join(known)}"] if known else []
    words += [f"not understood: {', '.join(other)[:120]}"] if other else []
    torque = next((h.text for h in headers if _TORQUE.search(h.text)), None)
    if torque is not None:
        words.append(f"{_quoted(torque)} is a torque: divide it by its lever arm for F_t [N]")
    example = next((h.text for h in headers if not h.meanings and h.text), "Friction Factor")
    missing = "mu" if any("v" in h.meanings for h in headers) else "v"
    return f"{'; '.join(words)}; {_choice(missing, example)}, or write a header like {EXPECTED}"


def _choice(quantity: str, text: str) -> str:
    return f"name the column, like columns={{'{quantity}': '{text[:40]}'}}"


def _quoted(text: str) -> str:
    return repr(text.strip()[:40])
