"""SI units as text, and whether the units of a law's parameters fit its formula.

The unit of a formula is a sum of powers times [m], [s], [kg], and the units that are not known. Where two parts
are added their units are the same, and a function takes and gives a pure number: linear equations in the units.
"""

import re
from collections.abc import Mapping

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, Substitution
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.functions import fold
from stickslip_sym.model.expression.parsing import parse_expression
from stickslip_sym.output.printing import text

_CALL = re.compile(r"\w\s*\(")
_ALLOWED = "write a product of powers of m, s, kg and N, or 1"
_M, _S, _KG = _BASE = sp.symbols("[m] [s] [kg]", positive=True)
_UNITS: dict[str, Expr] = {"m": _M, "s": _S, "kg": _KG, "N": _KG * _M / _S**2}
_PURE = frozenset(map(sp.Rational, ("1", "-1", "2", "-2", "1/2", "-1/2")))
"""Numbers that carry no unit; another, such as 0.3 in 0.5 - 0.3*v, may."""


def parse_unit(text: str) -> Expr:
    """Translate a unit such as ``"kg/s"``, ``"1"`` or ``"N*s^2/m^2"`` into a product of powers of m, s and kg."""

    def lookup(name: str) -> Expr:
        if name not in _UNITS:
            raise InputError(f"{name!r} is not a unit known here; units are made of m, s, kg and N")
        return _UNITS[name]

    if isinstance(text, str) and _CALL.search(text):
        raise InputError(f"{text[:60]!r} is not a unit: no function may stand in it; {_ALLOWED}")
    unit = parse_expression(text, lookup)
    powers = unit.as_powers_dict().items()
    if unit != 1 and any(base not in _BASE or not exponent.is_Rational for base, exponent in powers):
        raise InputError(f"{text[:60]!r} is not a unit; {_ALLOWED}")
    return unit


def multiply_by_units(expr: Expr, units: Mapping[Expr, str]) -> Expr:
    """Replace each symbol in `units` by itself times its unit."""
    return expr.xreplace({symbol: symbol * parse_unit(unit) for symbol, unit in units.items()})


def check_units(expr: Expr, units: Mapping[Expr, str | None]) -> None:
    """Refuse units of parameters, None where not known, with which a coefficient would be no pure number."""
    known = {symbol: parse_unit(unit) for symbol, unit in units.items() if unit is not None}
    if known:
        dimensions = _Dimensions({**known, symbols.v: _M / _S})
        dimensions.require_pure(fold(expr, dimensions), "the coefficient of friction")


class _Dimensions:
    """The algebra of units: collects what is known of the unknown ones, and refuses a contradiction.

    The unit of a number, or of a condition, that stands for itself is None: it may be any.
    """

    def __init__(self, known: Substitution) -> None:
        powers = {symbol: unit.as_powers_dict() for symbol, unit in known.items()}
        self.units = {symbol: sp.Add(*(base * of[base] for base in _BASE)) for symbol, of in powers.items()}
        self.solved: dict[Expr, Expr] = {}

    def __call__(self, node: Expr, parts: list[Expr | None]) -> Expr | None:
        if node.is_Symbol:
            return self.units.setdefault(node, sp.Dummy(f"unit of {node}"))
        if not parts:
            return sp.S.Zero if node in _PURE or node.is_NumberSymbol else None
        if node.is_Mul:  # a number in a product has a unit of its own
            return sp.Add(*(sp.Dummy("number") if part is None else part for part in parts))
        if node.is_Pow and len(parts) == 2:
            if not node.exp.is_Number:
                self.require_pure(parts[1], f"the exponent {text(node.exp)}")
            return (parts[0] or 0) * node.exp
        if node.is_Add or isinstance(node, sp.Piecewise | sp.Min | sp.Max | sp.core.relational.Relational):
            known = [part for part in parts if part is not None]
            for other in known[1:]:
                self.require_pure(other - known[0], f"a ratio of parts of {text(node)}")
            if isinstance(node, sp.core.relational.Relational) or not known:
                return None
            return known[0]
        for part in parts:
            self.require_pure(part, f"the argument of {text(node)}")
        return sp.S.Zero

    def require_pure(self, unit: Expr | None, what: str) -> None:
        """Take a unit for that of a pure number, which settles an unknown one, or refuse."""
        unit = sp.expand(unit or 0)
        while unit.free_symbols & self.solved.keys():
            unit = sp.expand(unit.xreplace(self.solved))
        powers = {base: unit.coeff(base) for base in sp.ordered(unit.free_symbols) if unit.coeff(base) != 0}
        unknown = next((base for base in powers if isinstance(base, sp.Dummy)), None)
        if unknown is not None:
            self.solved[unknown] = -unit.xreplace({unknown: sp.S.Zero}) / powers[unknown]
        elif sp.simplify(unit) != 0:
            shown = "*".join(f"{str(base)[1:-1]}^({powers[base]})" for base in _BASE if base in powers)
            raise InputError(
                f"the units do not fit: {what[:80]} is a pure number, and has the unit {shown}; check the units "
                "of the parameters"
            )
