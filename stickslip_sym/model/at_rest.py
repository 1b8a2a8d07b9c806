"""Coefficients of friction near v = 0: their limits at rest, and how much they rise from there."""

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
from stickslip_sym.model.expression.pieces import at_rest, branch_from

__all__ = ["Rising", "function_at", "limit_at_rest", "reals", "rises_of", "symbolic_limit_at_rest"]

Rising = Callable[[FloatArray], FloatArray]
"""mu(v) - mu(0+) of an array of slip speeds in m/s, NaN where mu has no value."""

_DIGITS = 50  # of mu where a piece begins, whose difference from mu(0+) may be small
_LARGE = 0.02  # a difference of coefficients that has lost few digits
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
    return math.nan if value.has(sp.zoo) else float(value)


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


def function_at(expr: Expr, values: Mapping[Expr, Expr], backend: Backend) -> Callable[[Any], Any]:
    """Return an expression in v at exact values of its other symbols as a bare function of v.

    Values go in as arguments, not into the expression: SymPy would factor powers of fractions.
    """
    compiled, ordered = function_of([*values, symbols.v], expr, backend), values.values()
    if backend != "mpmath":
        return partial(compiled, *map(float, ordered))
    rounded: dict[int, list[Any]] = {}  # by working precision

    def at_precision(v: Mpf) -> Mpf:
        precision = mpmath.mp.prec
        if precision not in rounded:
            rounded[precision] = [to_mpf(value) for value in ordered]
        return compiled(*rounded[precision], v)

    return at_precision


def reals(values: Any) -> FloatArray:
    """Return values that a function of NumPy gives as real numbers, NaN where they are complex."""
    if np.iscomplexobj(values):
        return np.where(np.isreal(values), np.real(values), np.nan)
    return np.asarray(values, dtype=np.float64)


def rises_of(expr: Expr, values: Mapping[Expr, Expr], kinks: Sequence[Expr]) -> list[tuple[float, Rising]]:
    """Return where each smooth piece of a coefficient begins, ascending from 0, and mu(v) - mu(0+) on it.

    The difference has the digits that are lost when two coefficients that are close are subtracted.
    """
    starts = [sp.Integer(0), *kinks]
    pieces = [branch_from(expr, values, start) for start in starts] if kinks else [expr]
    return [
        (float(start), _rise(values, pieces[0], piece, start)) for piece, start in zip(pieces, starts, strict=True)
    ]


def _rise(values: Mapping[Expr, Expr], lowest: Expr, piece: Expr, start: Expr) -> Rising:
    plain, onset = function_at(piece, values, "numpy"), limit_at_rest(lowest, values)
    # A piece that begins at 0 has the 0 itself in its formula, so that what is 0 there is left out.
    gained = gain(piece, symbols.v, _START if start else start)
    before = _between(values, lowest, piece, start) if start else 0.0
    risen = None if gained is None else function_at(gained, {**values, _START: start}, "numpy")

    def rising(v: FloatArray) -> FloatArray:
        with np.errstate(all="ignore"):  # what is lost at extreme values is taken from the other
            difference = reals(plain(v)) - onset + np.zeros_like(v)
            if risen is None:
                return difference
            value = reals(risen(v)) + before
        return np.where(np.isfinite(value) & ~(np.abs(difference) > _LARGE), value, difference)

    return rising


def _between(values: Mapping[Expr, Expr], lowest: Expr, piece: Expr, start: Expr) -> float:
    """Return what mu gains from 0+ to where a piece begins; NaN where that cannot be computed."""
    with mpmath.workdps(_DIGITS):
        try:
            low = function_at(lowest, values, "mpmath")(mpmath.mpf(0))
            return float(function_at(piece, values, "mpmath")(to_mpf(start)) - low)
        except (ArithmeticError, TypeError, ValueError):
            return np.nan
