"""`Coefficient`: mu(v) as functions of the slip speed, compiled once for all values of the parameters."""

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cache, lru_cache, partial
from typing import TYPE_CHECKING, Any

from stickslip_sym.core import symbols
from stickslip_sym.core.algebra import sp
from stickslip_sym.core.aliases import Expr, FloatArray, Mpf
from stickslip_sym.core.lambdify import Backend, function_of
from stickslip_sym.core.numbers import to_mpf

if TYPE_CHECKING:
    from stickslip_sym.model.samples import SampledCurve

__all__ = ["Coefficient", "limit_at_rest", "symbolic_limit_at_rest"]

_DIGITS = 50  # of mu where a piece begins, whose difference from mu(0+) may be small


@cache
def _start() -> Expr:
    """Return the symbol of the slip speed where a piece begins."""
    return sp.Dummy("start", positive=True)


@lru_cache(maxsize=256)
def limit_at_rest(expr: Expr) -> float:
    """Return the limit of an expression in v as v falls to 0; NaN where none is found, or it is no number."""
    try:
        return float(symbolic_limit_at_rest(expr))
    except TypeError:
        return math.nan


def symbolic_limit_at_rest(expr: Expr) -> Expr:
    """Return the limit of an expression in v and parameters as v falls to 0; `sympy.nan` if none is found."""
    from stickslip_sym.model.expression.pieces import at_rest

    # SymPy says in these ways that it finds no limit.
    try:
        limit = sp.limit(at_rest(expr, {}), symbols.v, 0, "+")
    except (ArithmeticError, NotImplementedError, TypeError, ValueError):
        return sp.nan
    return sp.nan if limit.has(symbols.v, sp.Limit, sp.AccumBounds) else limit


def _reals(values: Any) -> FloatArray:
    """Return values that a function of NumPy gives as real numbers, NaN where they are complex."""
    import numpy as np  # here: a formula is derived without it

    if np.iscomplexobj(values):
        return np.where(np.isreal(values), np.real(values), np.nan)
    return np.asarray(values, dtype=np.float64)


class Coefficient:
    """A coefficient of friction as a function of v, for any values of its parameters.

    Parameters
    ----------
    expr : sympy.Expr
    parameters : sequence of sympy.Symbol
        All that `expr` holds but v.
    curve : SampledCurve, optional
        The same through measured points, which is faster to evaluate as such.
    """

    def __init__(self, expr: Expr, parameters: Sequence[Expr], curve: "SampledCurve | None" = None) -> None:
        self.expr = expr
        self.parameters = tuple(parameters)
        self.curve = curve
        self._functions: dict[tuple[Expr, Backend, tuple[Expr, ...]], Callable[..., Any]] = {}

    def __reduce__(self) -> tuple[object, ...]:
        # Compiled functions cannot be pickled, and are made again when they are needed.
        return Coefficient, (self.expr, self.parameters, self.curve)

    def function(
        self, values: Mapping[Expr, Expr], backend: Backend, *, derivative: bool = False
    ) -> Callable[[Any], Any]:
        """Return mu(v), or its slope, at exact values of the parameters, as a bare function."""
        if self.curve is not None:
            return self.curve.function(backend, derivative=derivative)
        return self._at(sp.diff(self.expr, symbols.v) if derivative else self.expr, values, backend)

    def _at(self, expr: Expr, values: Mapping[Expr, Expr], backend: Backend, *more: Expr) -> Callable[[Any], Any]:
        import mpmath

        known = *self.parameters, *more
        key = expr, backend, more
        if key not in self._functions:
            # Values go in as arguments, not into the expression: SymPy would factor powers of fractions.
            self._functions[key] = function_of([*known, symbols.v], expr, backend)
        compiled, ordered = self._functions[key], [values[symbol] for symbol in known]
        if backend == "mpmath":
            rounded: dict[int, list[Any]] = {}  # by working precision

            def at_precision(v: Mpf) -> Mpf:
                precision = mpmath.mp.prec
                if precision not in rounded:
                    rounded[precision] = [to_mpf(value) for value in ordered]
                return compiled(*rounded[precision], v)

            return at_precision
        return partial(compiled, *map(float, ordered))

    def by_piece(
        self, values: Mapping[Expr, Expr], kinks: Sequence[Expr], names: Sequence[str]
    ) -> Callable[..., Any]:
        """Return mu of arrays of slip speeds, of the places of pieces, and of the parameters that have names."""
        import numpy as np

        from stickslip_sym.model.expression.pieces import branch_from

        if self.curve is not None:
            return self.curve.by_piece
        branches = [branch_from(self.expr, values, start) for start in (sp.Integer(0), *kinks)]
        compiled = [function_of([symbols.v, *self.parameters], branch, "numpy") for branch in branches]
        floats = [float(values[symbol]) for symbol in self.parameters]
        places = [[symbol.name for symbol in self.parameters].index(name) for name in names]

        def mu(v: Any, piece: Any, *given: Any) -> Any:
            arguments: list[Any] = list(floats)
            for place, column in zip(places, given, strict=True):
                arguments[place] = column
            value = compiled[0](v, *arguments)
            for i, branch in enumerate(compiled[1:], 1):
                value = np.where(piece == i, branch(v, *arguments), value)
            return value

        return mu

    def kinks(self, values: Mapping[Expr, Expr]) -> set[Expr]:
        """Return where mu or its slope may jump, exact."""
        from stickslip_sym.model.expression.pieces import places

        return {place.xreplace(values) for place in places(self.expr)}

    def rises(
        self, values: Mapping[Expr, Expr], kinks: Sequence[Expr], backend: Backend = "math"
    ) -> list[tuple[float, Callable[[Any], Any]]]:
        """Return where each smooth piece begins, ascending from 0, and mu(v) - mu(0+) on it.

        The difference has the digits that are lost when two coefficients are subtracted.

        - `backend`: "math" for functions of a float, or "numpy" for functions of an array, NaN where no value is.
        """
        from stickslip_sym.model.expression.pieces import branch_from

        if self.curve is not None:
            return self.curve.rises
        starts = [sp.Integer(0), *kinks]
        pieces = [branch_from(self.expr, values, start) for start in starts] if kinks else [self.expr]
        return [
            (float(start), self._rise(values, pieces[0], piece, start, backend))
            for piece, start in zip(pieces, starts, strict=True)
        ]

    def _rise(
        self, values: Mapping[Expr, Expr], lowest: Expr, piece: Expr, start: Expr, backend: Backend
    ) -> Callable[[Any], Any]:
        from stickslip_sym.model.expression.rises import rise

        plain, onset = self._at(piece, values, backend), limit_at_rest(lowest.xreplace(values))
        # A piece that begins at 0 has the 0 itself in its formula, so that what is 0 there is left out.
        gained = rise(piece, symbols.v, _start() if start else start)
        before = self._between(values, lowest, piece, start) if start else 0.0
        if gained is None or not math.isfinite(before):
            return (
                (lambda v: float(plain(v)) - onset) if backend == "math" else (lambda v: _reals(plain(v)) - onset)
            )
        compiled = self._at(gained, {**values, _start(): start}, backend, _start())

        def risen(v: float) -> float:
            try:
                found = float(compiled(v)) + before
            except (ArithmeticError, TypeError, ValueError):  # a TypeError is a complex coefficient
                found = math.nan
            return found if math.isfinite(found) else float(plain(v)) - onset

        def all_risen(v: FloatArray) -> FloatArray:
            import numpy as np

            found = _reals(compiled(v)) + before
            lost = ~np.isfinite(found)
            return np.where(lost, _reals(plain(v)) - onset, found) if lost.any() else found

        return risen if backend == "math" else all_risen

    def _between(self, values: Mapping[Expr, Expr], lowest: Expr, piece: Expr, start: Expr) -> float:
        """Return what mu gains from 0+ to where a piece begins; NaN where that cannot be computed."""
        import mpmath

        with mpmath.workdps(_DIGITS):
            try:
                low = self._at(lowest, values, "mpmath")(mpmath.mpf(0))
                return float(self._at(piece, values, "mpmath")(to_mpf(start)) - low)
            except (ArithmeticError, TypeError, ValueError):
                return math.nan
