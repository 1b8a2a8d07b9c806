"""Coefficients of friction near v = 0: their limits at rest, and how much they rise from there.

Where the belt hardly moves, mu(v) and mu(0+) agree to most of their digits, and their difference is what drives
the mass. Identities such as exp(a) - exp(b) = exp(b) expm1(a - b), which stand in the table of functions, say it
as products, which lose none.
"""

import math
from collections.abc import Callable, Sequence
from functools import cache, partial
from typing import Any

import numpy as np
import sympy as sp
from sympy.codegen.cfunctions import expm1, log1p

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, FloatArray, Substitution
from stickslip_sym.core.balls import number_at
from stickslip_sym.core.functions import fold, row
from stickslip_sym.core.lambdify import Backend, context_of, function_of
from stickslip_sym.core.numbers import to_mpf
from stickslip_sym.model.expression.canonical_form import HIGHEST_POWER_OF_SUM
from stickslip_sym.model.expression.pieces import branch_from, drop_unreachable_kinks
from stickslip_sym.model.leading_terms import symbolic_limit_at_rest
from stickslip_sym.model.taylor_model import coefficient_near_rest
from stickslip_sym.numerics.known import Unknown

Rising = Callable[[FloatArray], FloatArray]
"""mu(v) - mu(0+) of an array of slip speeds in m/s, NaN where mu has no value."""

_ACCURATE_DIFFERENCE = 0.04  # of the value at rest, or of 1 where that is 0: what has lost few digits
_SPEEDS = 2.0 ** np.arange(-80, 81)  # m/s, between which one as large is looked for
_START = sp.Dummy("start", positive=True)
"""The slip speed where a piece begins."""


def function_at(expr: Expr, values: Substitution, backend: Backend) -> Callable[[Any], Any]:
    """Return an expression in v at exact values of its other symbols as a bare function of v.

    Values go in as arguments, not into the expression: SymPy would factor powers of fractions.
    """
    compiled = function_of([*values, symbols.v], drop_unreachable_kinks(expr, values), backend)
    if (context := context_of(backend)) is not None:  # rounded to the precision at a call
        return lambda v: compiled(*(to_mpf(value, context) for value in values.values()), v)
    return partial(compiled, *map(float, values.values()))


def reals(values: Any) -> FloatArray:
    """Return values that a function of NumPy gives as real numbers, NaN where they are complex."""
    if np.iscomplexobj(values):
        return np.where(np.isreal(values), np.real(values), np.nan)
    return np.asarray(values, dtype=np.float64)


# -- limits ----------------------------------------------------------------------------------------


def limit_at_rest(expr: Expr, values: Substitution) -> float:
    """Return the limit of an expression as v falls to 0, at values of its parameters; NaN where none is found."""
    lowest = branch_from(expr, values, sp.Integer(0))
    value = number_at(lowest, {**values, symbols.v: sp.Integer(0)})
    if value is sp.nan:
        limit = symbolic_limit_at_rest(lowest, values)
        if isinstance(limit, Unknown):
            return math.nan
        value = limit if limit.is_infinite else number_at(limit, values)
    return float(value)


# -- rises -----------------------------------------------------------------------------------------


def rises_of(segments: Sequence[tuple[Expr, Expr]], values: Substitution) -> list[tuple[float, Rising]]:
    """Return where each smooth segment of a coefficient begins, and mu(v) - mu(0+) on it.

    The difference has the digits that are lost when two coefficients that are close are subtracted.

    - `segments`: where each begins, exact and ascending from 0, and its formula.
    """
    lowest = segments[0][1]
    return [(float(start), _rise_of_piece(values, lowest, formula, start)) for start, formula in segments]


def _rise_of_piece(values: Substitution, lowest: Expr, piece: Expr, start: Expr) -> Rising:
    plain = function_at(piece, values, "numpy")
    onset = limit_at_rest(lowest, values)
    # A piece that begins at 0 has the 0 itself in its formula, so that what is 0 there is left out.
    gained = stable_difference(piece, symbols.v, _START if start else start)
    before = 0.0
    if start:  # computed by balls: the two may be close
        ends = number_at(piece, {**values, symbols.v: start}), number_at(lowest, {**values, symbols.v: sp.S.Zero})
        before = math.nan
        if all(end.is_finite for end in ends):
            before = float(ends[0] - ends[1])
    if gained is None and start == 0 and (series := coefficient_near_rest(piece, values)) is not None:
        reach, polynomial = series
        return lambda v: np.where(v <= reach, polynomial.rise(v), _plain_difference(plain, onset, v))
    risen = None
    if gained is not None:
        risen = function_at(gained, {**values, _START: start}, "numpy")
    least = _ACCURATE_DIFFERENCE * (abs(onset) or 1.0)
    with np.errstate(all="ignore"):
        large = (np.abs(reals(plain(_SPEEDS)) - onset) > least) & (float(start) <= _SPEEDS)
    terms = cache(lambda: _term_by_term(piece, start, values))
    farthest = np.append(_SPEEDS, np.inf)[np.argmax(np.append(large, True))]  # beyond it products may cancel

    def rising(v: FloatArray) -> FloatArray:
        with np.errstate(all="ignore"):  # what is lost at extreme values is taken from the other
            difference = _plain_difference(plain, onset, v)
            if risen is None:
                return difference
            value = reals(risen(v)) + before
            if (lost := ~np.isfinite(value)).any() and piece.is_Add:
                value = np.array(value)
                value[lost] = before + sum(of(v[lost]) for of in terms())
        return np.where(np.isfinite(value) & (v < farthest) & ~(np.abs(difference) > least), value, difference)

    return rising


def _plain_difference(plain: Callable[[FloatArray], FloatArray], onset: float, v: FloatArray) -> FloatArray:
    with np.errstate(all="ignore"):
        return reals(plain(v)) - onset + np.zeros_like(v)


def _term_by_term(piece: Expr, start: Expr, values: Substitution) -> list[Rising]:
    """Return the rises of the terms of a sum, a difference where products overflow, as of a narrow bump."""

    def rise_of(term: Expr) -> Rising:
        gained = stable_difference(term, symbols.v, _START if start else start)
        low = number_at(term, {**values, symbols.v: start})
        by_products = function_at(sp.nan if gained is None else gained, {**values, _START: start}, "numpy")
        plain = function_at(term, values, "numpy")

        def rising(v: FloatArray) -> FloatArray:
            value = reals(by_products(v)) + 0.0 * v
            difference = reals(plain(v)) - float(low)
            return np.where(np.isfinite(value), value, difference)

        return rising

    return [rise_of(term) for term in piece.args if term.has(symbols.v)]


class _NoValue(Exception):
    """A part has no finite value at the start."""


def stable_difference(expr: Expr, variable: Expr, start: Expr) -> Expr | None:
    """Return expr(variable) - expr(start), without pieces, in a form that does not cancel where the two are close.

    It is None where a part of the expression has no finite value at `start`. A function that has no rule in the
    table is subtracted as it stands, unless it is 0 at `start`.
    """

    def gained(node: Expr, parts: list[tuple[Expr, Expr]]) -> tuple[Expr, Expr]:
        """Return the value of a node at the start, and its difference from there, from those of its arguments."""
        if not node.has(variable):
            return node, sp.S.Zero
        if node == variable:
            return start, node - start
        low = node.subs(variable, start)
        if low.has(sp.nan, sp.zoo, sp.oo, -sp.oo):
            raise _NoValue
        if node.is_Add:
            return low, sp.Add(*(rise for _, rise in parts))
        if node.is_Mul:
            rises = [
                sp.Mul(*(before for before, _ in parts[:i]), rise, *node.args[i + 1 :])
                for i, (_, rise) in enumerate(parts)
            ]
            return low, sp.Add(*rises)
        if node.is_Pow and len(parts) == 2:
            return low, _difference_of_power(node, low, *parts)
        known = row(node)
        if known is None or known.stable_difference is None:
            return low, node - low
        ((before, rise),) = parts
        return low, known.stable_difference(node.exp if node.is_Pow else node.args[0], before, rise)

    try:
        return fold(expr, gained)[1]
    except _NoValue:
        return None


def _difference_of_power(node: Expr, low: Expr, base: tuple[Expr, Expr], exponent: tuple[Expr, Expr]) -> Expr:
    """Return how far a power is from its value at the start, by the values and differences of its two parts."""
    (base_low, base_rise) = base
    (power, power_rise) = exponent
    if power_rise != 0:  # that of p log(b) is (p_0 + rise of p) (rise of log b) + (rise of p) log(b_0)
        if base_low == 0:
            raise _NoValue
        return low * expm1(node.exp * log1p(base_rise / base_low) + power_rise * sp.log(base_low))
    if base_low == 0:
        return base_rise**power - low
    if power.is_Integer and abs(power) <= HIGHEST_POWER_OF_SUM:
        count = abs(int(power))
        terms = sp.Add(*(node.base**i * base_low ** (count - 1 - i) for i in range(count)))
        if power > 0:
            return base_rise * terms
        return -base_rise * terms / (node.base**count * base_low**count)
    return low * expm1(power * log1p(base_rise / base_low))
