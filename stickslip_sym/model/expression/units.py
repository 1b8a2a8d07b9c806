"""SI units as text, and proofs that a formula has the unit it should.

A formula is dimensionally right exactly if scaling the units scales its value: replace every symbol by
symbol times unit, and the units must come out in front, as one factor. With `sympy.physics.units` the
units are symbols, so the proof is an identity like any other.
"""

import re
from collections.abc import Mapping

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import InputError

__all__ = ["check_unit", "parse_unit", "with_units"]

_CALL = re.compile(r"\w\s*\(")
_POWER = r"(m|s|kg|N)(\^-?[1-9])?"
_PLAIN = re.compile(rf"1|(1/)?{_POWER}([*/]{_POWER})*")
_ALLOWED = "write a product of powers of m, s, kg and N, or 1"


def parse_unit(text: str) -> Expr:
    """Translate a unit such as ``"kg/s"``, ``"1"`` or ``"N*s^2/m^2"`` into kilogram, meter and second.

    Raises
    ------
    InputError
        If the text is no product of powers of m, s, kg and N.
    """
    from sympy.physics import units

    from stickslip_sym.model.expression.parsing import parse_expression

    base = {
        "m": units.meter,
        "s": units.second,
        "kg": units.kilogram,
        "N": units.kilogram * units.meter / units.second**2,
    }

    def lookup(name: str) -> Expr:
        if name not in base:
            raise InputError(f"{name!r} is not a unit known here; units are made of m, s, kg and N")
        return base[name]

    if isinstance(text, str) and _CALL.search(text):
        raise InputError(f"{text[:60]!r} is not a unit: no function may stand in it; {_ALLOWED}")
    unit = parse_expression(text, lookup)
    powers = unit.as_powers_dict().items()
    known = {units.meter, units.second, units.kilogram}
    if unit != 1 and any(base not in known or not exponent.is_Rational for base, exponent in powers):
        raise InputError(f"{text[:60]!r} is not a unit; {_ALLOWED}")
    return unit


def check_unit(text: str) -> None:
    """Refuse what `parse_unit` refuses. As nearly all units are written, that takes no algebra.

    Raises
    ------
    InputError
    """
    if not (isinstance(text, str) and _PLAIN.fullmatch(text)):
        parse_unit(text)


def with_units(expr: Expr, units: Mapping[Expr, str]) -> Expr:
    """Replace each symbol in `units` by itself times its unit."""
    return expr.xreplace({symbol: symbol * parse_unit(text) for symbol, text in units.items()})
