"""`Coefficient`: mu(v) as functions of the slip speed, compiled once for all values of the parameters."""

import math
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from typing import Any

import mpmath
import numpy as np
import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, FloatArray, Mpf
from stickslip_sym.core.balls import number_at
from stickslip_sym.core.lambdify import Backend, function_of
from stickslip_sym.core.numbers import to_mpf
from stickslip_sym.model.expression.gain import gain
from stickslip_sym.model.expression.pieces import at_rest, branch_from, places
from stickslip_sym.model.samples import SampledCurve

__all__ = ["Coefficient", "limit_at_rest", "symbolic_limit_at_rest"]

_DIGITS = 50  # of mu where a piece begins, whose difference from mu(0+) may be small
_START = sp.Dummy("start", positive=True)
"""The slip speed where a piece begins."""


def limit_at_rest(expr: Expr, values: Mapping[Expr, Expr]) -> float:
    """Return the limit of an expression as v falls to 0, at values of its parameters; NaN where none is found."""
    lowest = branch_from(expr, values, sp.Integer(0))
    value = number_at(lowest, {**values, symbols.v: sp.Integer(0)})
    if value is sp.nan:
        # Values of exponents decide the limit of v^p/v; those of other parameters stay out of the algebra.
        limit = symbolic_limit_at_rest(lowest.replace(sp.Pow, lambda base, power: base ** _valued(power, values)))
        value = limit if limit.has(sp.nan) or limit.is_infinite else number_at(limit, values)
    return float(value)


def _valued(power: Expr, values: Mapping[Expr, Expr]) -> Expr:
    return power if power.has(symbols.v) else number_at(power, values)


@lru_cache(maxsize=256)
def symbolic_limit_at_rest(expr: Expr) -> Expr:
    """Return the limit of an expression in v and parameters as v falls to 0; `sympy.nan` if none is found.

    Where it depends on the sign of a place, it is a Piecewise.
    """
    lowest = at_rest(expr)
    for node in lowest.atoms(sp.Piecewise):
        cases = [(symbolic_limit_at_rest(lowest.xreplace({node: part})), holds) for part, holds in node.args]
        return sp.nan if any(part is sp.nan for part, _ in cases) else sp.Piecewise(*cases)
    # SymPy says in these ways that it finds no limit.
    try:
        limit = sp.limit(lowest, symbols.v, 0, "+")
    except (ArithmeticError, NotImplementedError, TypeError, ValueError):
        return sp.nan
    return sp.nan if limit.has(symbols.v, sp.Limit, sp.AccumBounds, sp.I, sp.nan) else limit


def _reals(values: Any) -> FloatArray:
    """Return values that a function of NumPy gives as real numbers, NaN where they are complex."""
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

    def __init__(self, expr: Expr, parameters: Sequence[Expr], curve: SampledCurve | None = None) -> None:
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
        known = *self.parameters, *more
        key = expr, backend, more
        if key not in self._functions:
            # Values go in as arguments, not into the expression: SymPy would factor powers of fractions.
            self._functions[key] = function_of([*known, symbols.v], expr, backend)
        compiled, ordered = self._functions[key], [values[symbol] for symbol in known]
        if backend != "mpmath":
            return partial(compiled, *map(float, ordered))
        rounded: dict[int, list[Any]] = {}  # by working precision

        def at_precision(v: Mpf) -> Mpf:
            precision = mpmath.mp.prec
            if precision not in rounded:
                rounded[precision] = [to_mpf(value) for value in ordered]
            return compiled(*rounded[precision], v)

        return at_precision

    def kinks(self, values: Mapping[Expr, Expr]) -> set[Expr]:
        """Return where mu or its slope may jump: exact rationals, or numbers of 4000 bits."""
        return {number_at(place, values) for place in places(self.expr)}

    def rises(
        self, values: Mapping[Expr, Expr], kinks: Sequence[Expr], backend: Backend
    ) -> list[tuple[float, Callable[[Any], Any]]]:
        """Return where each smooth piece begins, ascending from 0, and mu(v) - mu(0+) on it.

        The difference has the digits that are lost when two coefficients are subtracted.

        - `backend`: "math" for functions of a float, or "numpy" for functions of an array, NaN where no value is.
        """
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
        plain, onset = self._at(piece, values, backend), limit_at_rest(lowest, values)
        # A piece that begins at 0 has the 0 itself in its formula, so that what is 0 there is left out.
        gained = gain(piece, symbols.v, _START if start else start)
        before = self._between(values, lowest, piece, start) if start else 0.0
        if gained is None or not math.isfinite(before):
            return (
                (lambda v: float(plain(v)) - onset) if backend == "math" else (lambda v: _reals(plain(v)) - onset)
            )
        compiled = self._at(gained, {**values, _START: start}, backend, _START)

        def risen(v: float) -> float:
            try:
                value = float(compiled(v)) + before
            except (ArithmeticError, TypeError, ValueError):  # a TypeError is a complex coefficient
                value = math.nan
            return value if math.isfinite(value) else float(plain(v)) - onset

        def all_risen(v: FloatArray) -> FloatArray:
            value = _reals(compiled(v)) + before
            lost = ~np.isfinite(value)
            return np.where(lost, _reals(plain(v)) - onset, value) if lost.any() else value

        return risen if backend == "math" else all_risen

    def _between(self, values: Mapping[Expr, Expr], lowest: Expr, piece: Expr, start: Expr) -> float:
        """Return what mu gains from 0+ to where a piece begins; NaN where that cannot be computed."""
        with mpmath.workdps(_DIGITS):
            try:
                low = self._at(lowest, values, "mpmath")(mpmath.mpf(0))
                return float(self._at(piece, values, "mpmath")(to_mpf(start)) - low)
            except (ArithmeticError, TypeError, ValueError):
                return math.nan
