"""SI units as text, and whether the units of a law's parameters fit its formula.

The unit of a formula is a product of powers of m, s, kg, and of the units that are not known. Where two parts are
added their units are the same, and a function takes and gives a pure number: linear equations in the powers.
"""

import re
from collections.abc import Mapping
from typing import TypeAlias

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.functions import fold
from stickslip_sym.output.printing import text

__all__ = ["check_unit", "check_units", "parse_unit", "with_units"]

Unit: TypeAlias = "dict[tuple[str, Expr], Expr]"
"""Powers of m, s, kg and of unknown units: by the name, and the symbolic factor that a power has."""
Units: TypeAlias = Mapping[tuple[str, Expr], Expr]

_CALL = re.compile(r"\w\s*\(")
_ALLOWED = "write a product of powers of m, s, kg and N, or 1"
_BASE: dict[str, dict[str, int]] = {"m": {"m": 1}, "s": {"s": 1}, "kg": {"kg": 1}, "N": {"kg": 1, "m": 1, "s": -2}}
_PURE = frozenset(map(sp.Rational, ("1", "-1", "2", "-2", "1/2", "-1/2")))
"""Numbers that carry no unit; another, such as 0.3 in 0.5 - 0.3*v, may."""


def parse_unit(text: str) -> Expr:
    """Translate a unit such as ``"kg/s"``, ``"1"`` or ``"N*s^2/m^2"`` into a product of powers of m, s and kg.

    Raises
    ------
    InputError
        If the text is no product of powers of m, s, kg and N.
    """
    from stickslip_sym.model.expression.parsing import parse_expression

    def lookup(name: str) -> Expr:
        if name not in _BASE:
            raise InputError(f"{name!r} is not a unit known here; units are made of m, s, kg and N")
        return sp.Mul(*(_symbol(base) ** power for base, power in _BASE[name].items()))

    if isinstance(text, str) and _CALL.search(text):
        raise InputError(f"{text[:60]!r} is not a unit: no function may stand in it; {_ALLOWED}")
    unit = parse_expression(text, lookup)
    known = {_symbol(name) for name in ("m", "s", "kg")}
    powers = unit.as_powers_dict().items()
    if unit != 1 and any(base not in known or not exponent.is_Rational for base, exponent in powers):
        raise InputError(f"{text[:60]!r} is not a unit; {_ALLOWED}")
    return unit


def _symbol(name: str) -> Expr:
    return sp.Symbol(f"[{name}]", positive=True)


def check_unit(text: str) -> None:
    """Refuse what `parse_unit` refuses.

    Raises
    ------
    InputError
    """
    parse_unit(text)


def with_units(expr: Expr, units: Mapping[Expr, str]) -> Expr:
    """Replace each symbol in `units` by itself times its unit."""
    return expr.xreplace({symbol: symbol * parse_unit(unit) for symbol, unit in units.items()})


def check_units(expr: Expr, units: Mapping[Expr, str | None]) -> None:
    """Refuse units with which a coefficient of friction would be no pure number.

    Parameters
    ----------
    expr : sympy.Expr
    units : mapping of symbols to text
        The units of its parameters; None where one is not known.

    Raises
    ------
    InputError
        If no units of the other parameters and numbers make the formula a pure number.
    """
    known = {symbol: _unit_of(parse_unit(unit)) for symbol, unit in units.items() if unit is not None}
    if known:
        _Dimensions({**known, symbols.v: _unit_of(parse_unit("m/s"))}).check(expr)


def _unit_of(unit: Expr) -> Unit:
    powers = {} if unit == 1 else unit.as_powers_dict()
    return {(str(base), sp.S.One): power for base, power in powers.items()}


class _Dimensions:
    """The algebra of units: collects what is known of the unknown ones, and refuses a contradiction."""

    def __init__(self, known: Mapping[Expr, Unit]) -> None:
        self.known = known
        self.solved: dict[tuple[str, Expr], Unit] = {}
        self.numbers = 0

    def check(self, expr: Expr) -> None:
        self._require(fold(expr, self), "the coefficient of friction")

    def __call__(self, node: Expr, parts: list[Unit]) -> Unit:
        if node.is_Symbol:
            return dict(self.known.get(node, {(f"unit of {node}", sp.S.One): sp.S.One}))
        if not parts:
            return {} if node in _PURE or node.is_NumberSymbol else _ANY
        if node.is_Mul:
            self.numbers += 1  # a number in a product has a unit of its own
            number = {(f"number {self.numbers}", sp.S.One): sp.S.One}
            return _product([number if part is _ANY else part for part in parts])
        if node.is_Pow and len(parts) == 2:
            if not node.exp.is_Number:
                self._require(parts[1], f"the exponent {text(node.exp)}")
            return _raised(parts[0], node.exp)
        if node.is_Add or isinstance(node, sp.Piecewise | sp.Min | sp.Max | sp.core.relational.Relational):
            first, *others = [part for part in parts if part is not _ANY] or [_ANY]
            for other in others:
                ratio = _product([other, _raised(first, sp.S.NegativeOne)])
                self._require(ratio, f"a ratio of parts of {text(node)}")
            return _ANY if isinstance(node, sp.core.relational.Relational) else first
        if isinstance(node, sp.functions.elementary.piecewise.ExprCondPair):
            return parts[0]
        for part in parts:
            self._require(part, f"the argument of {text(node)}")
        return {}

    def _require(self, unit: Unit, what: str) -> None:
        """Take a unit for a pure number, which settles an unknown one, or refuse."""
        rest = self._reduced(unit)
        unknown = next((key for key in rest if not key[0].startswith("[")), None)
        if unknown is not None:
            power = rest.pop(unknown)
            self.solved[unknown] = _raised(rest, -1 / power)
        elif rest:
            shown = "*".join(f"{name[1:-1]}^({power * factor})" for (name, factor), power in rest.items())
            raise InputError(
                f"the units do not fit: {what[:80]} is a pure number, and has the unit {shown}; check the units "
                "of the parameters"
            )

    def _reduced(self, unit: Unit) -> Unit:
        while any(key in self.solved for key in unit):
            powers = unit.items()
            unit = _product([_raised(self.solved.get(key, {key: sp.S.One}), power) for key, power in powers])
        return unit


_ANY: Unit = {}
"""The unit of a number, or a condition, that stands for itself: it may be any."""


def _product(units: list[Unit]) -> Unit:
    keys = dict.fromkeys(key for unit in units for key in unit)
    powers = {key: sp.Add(*(unit.get(key, 0) for unit in units)) for key in keys}
    return {key: power for key, power in powers.items() if power != 0}


def _raised(unit: Units, exponent: Expr) -> Unit:
    number, factor = exponent.as_coeff_Mul()
    return {(name, other * factor): power * number for (name, other), power in unit.items()}
