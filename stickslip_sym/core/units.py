"""The table of units, and numbers that users write with one: "400 mm/s" or "400(5) mm/s" for 0.4 m/s.

One more unit is an entry in `SIZES`; files of measurements, the command line and parameters read it.
"""

import re
from decimal import Context, Decimal
from fractions import Fraction
from typing import Any

from stickslip_sym.core.errors import InputError
from stickslip_sym.core.remedies import Name
from stickslip_sym.core.symbols import QUANTITIES

SIZES = {
    "length": "nm 1e-9, um 1e-6, μm 1e-6, micron 1e-6, mm 1e-3, cm 1e-2, dm 1e-1, m 1, km 1e3, in 0.0254, "
              "inch 0.0254, ft 0.3048, mi 1609.344",
    "time": "ms 1e-3, s 1, sec 1, second 1, min 60, minute 60, h 3600, hr 3600, hour 3600",
    "mass": "mg 1e-6, g 1e-3, kg 1, t 1e3, lb 0.45359237, lbm 0.45359237, oz 0.028349523125, "
            "slug 14.593902937206364829396325459317585302",
    "frequency": "Hz 1, kHz 1e3",
    "speed": "mps 1, kph 5/18, kmh 5/18, mph 0.44704, ips 0.0254, fps 0.3048, fpm 0.00508, knot 463/900",
    "force": "nN 1e-9, uN 1e-6, μN 1e-6, mN 1e-3, cN 1e-2, N 1, newton 1, daN 10, kN 1e3, MN 1e6, kgf 9.80665, "
             "kp 9.80665, gf 0.00980665, lbf 4.4482216152605, ozf 0.27801385095378125, dyn 1e-5",
    "number": "1 1, % 1/100",
}  # fmt: skip
"""Sizes in SI units. Capitals count, as they tell mN from MN."""
_POWERS = {"length": (1, 0, 0), "time": (0, 1, 0), "mass": (0, 0, 1), "frequency": (0, -1, 0), "speed": (1, -1, 0),
           "force": (1, -2, 1), "number": (0, 0, 0)}  # fmt: skip
"""Powers of m, s and kg."""
_UNITS = {
    name: (Fraction(size), _POWERS[kind])
    for kind, text in SIZES.items()
    for name, size in map(str.split, text.split(", "))
}
_ARGUMENTS = {"radius": "m", "speeds": "m/s", "x0": "m", "v0": "m/s", "t_end": "s"}
_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻−\N{MICRO SIGN}", "0123456789--μ")
_WITH_UNIT = re.compile(
    r"\s*(?P<number>[-+(\d.].*?)\s*(?P<unit>(?:1/)?(?![eE][-+]?\d)[A-Za-zμ%][A-Za-zμ%\d\s*·/^.()-]*?)\s*"
)
_BELOW_IN_BRACKETS = re.compile(r"/\(\s*([A-Za-zμ]+)\s*/\s*([A-Za-zμ]+)\s*\)")  # N/(m/s) is N s/m
_FORCE_SECONDS = re.compile(r"(?<![A-Za-zμ])([kmMμ]?N)s(?![A-Za-zμ])")  # Ns/m is N s/m
_SPEED_IN_CAPITALS = re.compile(r"(MM|CM|M|KM|IN|FT)/(S|SEC|MIN|H|HR)")  # as some instruments write them
_FACTOR = re.compile(r"(?P<name>1|[A-Za-zμ%]+)\^?(?P<power>-?\d)?")
_DECIMAL = r"(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,4})?"
_SIZE = rf"{_DECIMAL}(?:/{_DECIMAL})?"
_NUMBER = re.compile(
    rf"\(?(?:(?P<value>[-+]?{_SIZE})(?:\s*(?:\+/-|±)\s*(?P<error>{_SIZE}))?"
    rf"|(?P<digits>[-+]?{_DECIMAL})\s*\((?P<last>\d+)\))\)?"
)


def dimensions(text: str) -> tuple[Fraction, tuple[int, ...]] | None:
    """Return the size of a unit in SI units, and its powers of m, s and kg; None for one that is not known."""
    size = Fraction(1)
    powers = tuple[int, ...]((0, 0, 0))
    text = text.translate(_SUPERSCRIPTS).replace("**", "^")
    text = _BELOW_IN_BRACKETS.sub(r" \2/\1", text)
    text = _FORCE_SECONDS.sub(r"\1 s", text)
    if _SPEED_IN_CAPITALS.fullmatch(text):
        text = text.lower()
    for i, product in enumerate(text.split("/")):
        for factor in re.split(r"[\s*·.]+", product.strip()):
            match = _FACTOR.fullmatch(factor)
            if match is None or match["name"] not in _UNITS:
                return None
            power = int(match["power"] or 1) * (-1 if i else 1)
            of, its = _UNITS[match["name"]]
            size *= of**power
            powers = tuple(a + power * b for a, b in zip(powers, its, strict=True))
    return size, powers


def si_number(value: Any, name: str, unit: str | None = None) -> Any:
    """Return text with a unit as a number in SI units, still text and exact, and quantities of other libraries.

    What has no unit is returned as it is.

    - `unit`: the one that is expected, empty if any; by default that of the quantity of this name.
    """
    if not isinstance(value, str):
        return strip_unit(value, name, unit)
    match = _WITH_UNIT.fullmatch(value.translate(_SUPERSCRIPTS))
    expected = _expected(name, unit)
    if match is None or expected is None:
        return value
    number = _NUMBER.fullmatch(match["number"])
    unit_of_text = dimensions(match["unit"])
    if number is None or unit_of_text is None:
        return value
    size, powers = unit_of_text
    required = dimensions(expected) if expected else None
    if required is not None and required[1] != powers:
        raise InputError(
            Name(name),
            f" = {value.strip()[:60]!r} has the unit {match['unit']}, and {name} is "
            f"{'a pure number' if expected == '1' else f'in {expected}'}; write it so, or in a unit like that",
        )
    try:
        return _converted(number, size)
    except ZeroDivisionError:
        return value


def has_no_unit(text: str) -> bool:
    """Return whether no unit stands behind a number."""
    return _WITH_UNIT.fullmatch(text.translate(_SUPERSCRIPTS)) is None


def unknown_unit(text: str) -> str | None:
    """Return the unit behind a number if it is not known; None where it is, or where there is none."""
    match = _WITH_UNIT.fullmatch(text.translate(_SUPERSCRIPTS))
    if match is None or _NUMBER.fullmatch(match["number"]) is None or dimensions(match["unit"]) is not None:
        return None
    return match["unit"]


def has_error(text: str) -> bool:
    """Return whether a text is a number with its standard error, like 0.400(5) or 0.400+/-0.005."""
    match = _NUMBER.fullmatch(text.strip())
    return match is not None and (match["error"] or match["last"]) is not None


def _converted(number: re.Match[str], size: Fraction) -> str:
    """Return a number with its standard error, if it has one, as text in SI units."""
    if number["last"] is not None:  # in units of the last digit
        value = Fraction(number["digits"])
        error = Fraction(last_digits(number["digits"], number["last"]))
    else:
        value = _quotient(number["value"])
        if number["error"] is None:
            return _number_text(value * size)
        error = _quotient(number["error"])
    return f"{_number_text(value * size, decimal=True)}+/-{_number_text(error * size, decimal=True)}"


def last_digits(number: str, digits: str) -> Decimal:
    """Return the standard error that digits in brackets behind a decimal say: 5 behind 0.400 is 0.005."""
    return Decimal(digits).scaleb(int(Decimal(number).as_tuple().exponent))


def _quotient(text: str) -> Fraction:
    above, _, below = text.partition("/")
    return Fraction(above) / Fraction(below or 1)


def strip_unit(value: Any, name: str, unit: str | None = None) -> Any:
    """Return a quantity of pint or astropy, or an array of them, as numbers in SI units; anything else as it is.

    The library that made the quantity converts it. A unit that does not fit, or for which none is known here,
    is refused: to drop it would change the number.

    - `unit`: the one that is expected, as of `si_number`.
    """
    its_unit = getattr(value, "units", None) or getattr(value, "unit", None)
    if its_unit is None or isinstance(its_unit, str):
        return value
    expected = _expected(name, unit)
    if not expected:
        raise InputError(
            Name(name),
            f" carries the unit {its_unit}, and no unit is known here for it; give a plain number in SI units",
        )
    try:
        converted = value.to("" if expected == "1" else expected)
        return converted.magnitude if hasattr(converted, "magnitude") else converted.value
    except Exception as error:  # whatever a library raises where units do not fit: its words are passed on
        raise InputError(
            Name(name), f" carries the unit {its_unit}, and {name} is in {expected}: {str(error)[:120]}"
        ) from None


def _expected(name: str, unit: str | None) -> str | None:
    """Return the unit of a quantity or an argument by its name, unless one is given; None where none is known."""
    if unit is not None:
        return unit
    if name in QUANTITIES:
        return QUANTITIES[name].unit
    return _ARGUMENTS.get(name)


def share_unit(last: str, first: str) -> str:
    """Return the first end of a range with the unit of the last where it has none, as in "10:400 mm/s"."""
    its = _WITH_UNIT.fullmatch(last.translate(_SUPERSCRIPTS))
    own = _WITH_UNIT.fullmatch(first.translate(_SUPERSCRIPTS))
    if its is None or own is not None:
        return first
    return f"{first} {its['unit']}"


def _number_text(number: Fraction, *, decimal: bool = False) -> str:
    """Return a number as the decimal that it is, or a quotient, or else a decimal of many digits."""
    quotient = Context().divide(Decimal(number.numerator), Decimal(number.denominator))
    if decimal or Fraction(quotient) == number:
        return str(quotient)
    return f"{number.numerator}/{number.denominator}"
