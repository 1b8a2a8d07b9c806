"""SymPy expressions to Python functions.

The one place that calls `lambdify`. It generates source text, so only symbols whose names were checked
(`model.expression.parameters`) reach it, and even those are replaced by dummy names.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from typing import Any, Literal, TypeAlias

import mpmath
import numpy as np
import sympy as sp
from sympy.printing.pycode import MpmathPrinter
from sympy.utilities.lambdify import MPMATH_TRANSLATIONS

from stickslip_sym.core.aliases import Expr, ExprOrCondition, Numbers
from stickslip_sym.core.functions import FUNCTIONS, write_erfcx
from stickslip_sym.core.numbers import DOUBLE_DIGITS
from stickslip_sym.core.special import Special

Backend: TypeAlias = Literal["numpy", "math", "mpmath"] | mpmath.MPContext
"""A library of numbers: "mpmath" computes in the user's precision, a context of mpmath in its own."""

_MOST_FLOAT_POWER = 8  # of a whole exponent that is multiplied out


def power_of(base: Numbers, exponent: float) -> Numbers:
    """Raise floats or arrays to a power: whole and half ones by products, quotients and square roots."""
    if exponent == 1.0:
        return base
    if exponent < 0:
        return 1.0 / power_of(base, -exponent)
    whole = int(exponent)
    if whole > _MOST_FLOAT_POWER or exponent - whole not in (0.0, 0.5):
        result: Numbers = np.power(base, exponent)
        return result
    result = np.sqrt(base) if exponent != whole else 1.0
    square = base
    while whole:
        if whole & 1:
            result = square if isinstance(result, float) and result == 1.0 else result * square
        whole >>= 1
        if whole:
            square = square * square
    return result


_FLOATS = {row.name: row.floats for row in FUNCTIONS.values() if row.floats is not None}
_SPECIAL = {kind.__name__: kind for kind in FUNCTIONS if issubclass(kind, Special)}
_MODULES: dict[Backend, list[Any]] = {
    "math": ["math", _FLOATS],
    "numpy": [{"power_of": power_of}, _FLOATS, "scipy", "numpy"],
}
_LARGEST_INTEGER = int(np.iinfo(np.int64).max)  # those above make NumPy leave its own types for Python's objects


def context_of(backend: Backend) -> mpmath.MPContext | None:
    """Return the context of mpmath that a backend computes in; None for one that computes in floats."""
    if isinstance(backend, str):
        return mpmath.mp if backend == "mpmath" else None
    return backend


def _modules(backend: Backend) -> list[Any]:
    """Return where `lambdify` finds the functions of a backend."""
    context = context_of(backend)
    if context is None:
        return _MODULES[backend]
    names = {name: getattr(context, name) for name in dir(context) if not name.startswith("_")}
    names |= {name: names[translated] for name, translated in MPMATH_TRANSLATIONS.items()}
    return [{name: partial(kind.mpf, context) for name, kind in _SPECIAL.items()}, names]


def function_of(arguments: Sequence[Expr], expr: Expr | Sequence[Expr], backend: Backend) -> Callable[..., Any]:
    """Return `expr` as a function of `arguments`, computed by the given library; the same one if asked again.

    `expr` may be a list of expressions; common subexpressions are then computed once.
    """
    return _compiled(tuple(arguments), tuple(expr) if isinstance(expr, list | tuple) else expr, backend)


@lru_cache(maxsize=1024)
def _compiled(arguments: tuple[Expr, ...], expr: Expr | tuple[Expr, ...], backend: Backend) -> Callable[..., Any]:
    several = isinstance(expr, tuple)
    parts = list(map(sp.sympify, expr if isinstance(expr, tuple) else (expr,)))
    if backend == "numpy":
        parts = [_replace_large_numbers(write_erfcx(part)) for part in parts]
    compiled: Callable[..., Any] = sp.lambdify(
        list(arguments), parts if several else parts[0], modules=_modules(backend), dummify=True, cse=several,
        printer=None if context_of(backend) is None else _Exact(), docstring_limit=0,
    )  # fmt: skip
    return compiled


class _Exact(MpmathPrinter):
    """Numbers of any length as Python reads them: in decimals it takes 4300 digits at most."""

    def __init__(self) -> None:
        names = {name: name for name in _SPECIAL}
        settings = {"inline": True, "allow_unknown_functions": True, "user_functions": names}
        super().__init__({"fully_qualified_modules": False, **settings})

    def _print_int(self, expr: int) -> str:
        return hex(expr) if abs(expr) > _LARGEST_INTEGER else str(expr)

    def _print_Integer(self, expr: sp.Integer) -> str:
        return self._print_int(expr.p)


def _replace_large_numbers(expr: ExprOrCondition) -> ExprOrCondition:
    """Replace numbers that NumPy's integers do not hold, and powers that are multiplied out."""
    if isinstance(expr, sp.Piecewise):  # SymPy would compare all places again
        return sp.Piecewise(
            *((_replace_large_numbers(part), _replace_large_numbers(holds)) for part, holds in expr.args),
            evaluate=False,
        )
    long = [number for number in expr.atoms(sp.Rational) if max(abs(number.p), number.q) > _LARGEST_INTEGER]
    expr = expr.xreplace({number: sp.Float(number, 2 * DOUBLE_DIGITS) for number in long})
    power_function = sp.Function("power_of")
    return expr.replace(
        lambda node: is_multiplied(node) and abs(node.exp) > 1, lambda node: power_function(*node.args)
    )


def is_multiplied(node: Expr) -> bool:
    """Whether a node is a power by products, quotients and square roots: the same for a float as in an array."""
    return bool(node.is_Pow and node.exp.is_Rational and node.exp.q <= 2 and abs(node.exp) < _MOST_FLOAT_POWER + 1)
