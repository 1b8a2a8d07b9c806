"""SymPy expressions to Python functions.

The one place that calls `lambdify`. It generates source text, so only symbols that were checked
(`friction`) reach it, and even those are replaced by dummy names.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, Literal

import sympy as sp

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.functions import FUNCTIONS
from stickslip_sym.core.special import Special

Backend = Literal["numpy", "math", "mpmath"]

_FLOATS = {row.name: row.floats for row in FUNCTIONS.values() if row.floats is not None}
_MODULES: dict[Backend, list[Any]] = {
    "math": ["math", _FLOATS],
    "mpmath": [{kind.__name__: kind.mpf for kind in FUNCTIONS if issubclass(kind, Special)}, "mpmath"],
    "numpy": [_FLOATS, "scipy", "numpy"],
}
_LONGEST = 2**62  # whole numbers above make NumPy leave its own types for Python's objects
_DIGITS = 20  # of a number as text: enough that reading it back gives the nearest double


def function_of(arguments: Sequence[Expr], expr: Expr | Sequence[Expr], backend: Backend) -> Callable[..., Any]:
    """Return `expr` as a function of `arguments`, computed by the given library; the same one if asked again.

    `expr` may be a list of expressions; common subexpressions are then computed once.
    """
    return _compiled(tuple(arguments), tuple(expr) if isinstance(expr, list | tuple) else expr, backend)


@lru_cache(maxsize=1024)
def _compiled(arguments: tuple[Expr, ...], expr: Expr | tuple[Expr, ...], backend: Backend) -> Callable[..., Any]:
    several = isinstance(expr, tuple)
    parts = [sp.sympify(part) for part in (expr if several else (expr,))]
    if backend == "numpy":
        parts = [_in_floats(part) for part in parts]
    compiled: Callable[..., Any] = sp.lambdify(
        list(arguments), parts if several else parts[0], modules=_MODULES[backend], dummify=True, cse=several
    )
    return compiled


def _in_floats(expr: Expr) -> Expr:
    """Replace the numbers in an expression that NumPy's integers do not hold."""
    if isinstance(expr, sp.Piecewise):  # SymPy would compare all places again
        return sp.Piecewise(*((_in_floats(part), _in_floats(holds)) for part, holds in expr.args), evaluate=False)
    long = [number for number in expr.atoms(sp.Rational) if max(abs(number.p), number.q) > _LONGEST]
    return expr.xreplace({number: sp.Float(number, _DIGITS) for number in long})
