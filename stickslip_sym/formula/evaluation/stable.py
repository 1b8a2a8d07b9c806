"""A criterion as a fast function that is accurate everywhere.

A law is split into terms, each an amplitude times a function F of one dimensionless speed r (`splitting`).
F is computed by the branch that serves its r (`profile`). Where terms cancel, and for laws that cannot be
split, the slope average is taken by Gauss rules with a bound of their rounding error (`gauss`). What that
bound does not allow goes to arbitrary precision, one value at a time.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import BoolArray, Expr, FloatArray, IntArray, Numbers
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.criteria import gauss
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.evaluation.bounds import rounding_bound, slope_with_bound
from stickslip_sym.formula.evaluation.conditioning import conditioned, speed_scales
from stickslip_sym.formula.evaluation.products import extremes
from stickslip_sym.formula.evaluation.room import Room
from stickslip_sym.formula.evaluation.splitting import split
from stickslip_sym.formula.evaluation.term import Ends, Loops, TermFunction
from stickslip_sym.model.expression.pieces import jumps, places

__all__ = ["Exact", "StableFunction"]

_EPSILON = float(np.finfo(np.float64).eps)
_CANCELLED = 4.0  # the sizes of the terms over the size of their sum, from where the sum is taken otherwise
_ALLOWED = 64.0  # bound of the rounding error of a Gauss average, in units; it is some five times too large
_JUMP = 6.0  # units of rounding error of the weight at a jump
_SLOPE_ALLOWED = 16.0  # the same, of the slope at one point
# Where inputs nearly cancel, most processors have eleven bits to spare.
_REALS: tuple[type[np.floating], ...] = (np.float64, np.longdouble)
_NOTHING = 2.0**-1073  # errors below are no more than the last bit of the smallest numbers

Exact = Callable[[Mapping[Any, Any]], Any]
"""From the exact values of all arguments to the criterion, as a number."""


class StableFunction:
    """A criterion of a law over arrays.

    Parameters
    ----------
    mu : sympy.Expr
        The law.
    criterion : Criterion
    arguments : sequence of Symbol
        V, N and the parameters, in the order in which values come.
    exact : callable
        The last resort.
    loops : callable, optional
        Returns all branches of a profile as one compiled loop, or None.
    """

    def __init__(
        self, mu: Expr, criterion: Criterion, arguments: Sequence[Expr], exact: Exact, loops: Loops | None = None
    ) -> None:
        self.mu, self.criterion, self.exact, self.loops = mu, criterion, exact, loops
        self.arguments = list(arguments)

    @cached_property
    def terms(self) -> list[TermFunction] | None:
        """The terms of the law; None where it cannot be split."""
        if self.criterion.weight is None:
            return None
        terms = split(self.mu)
        return (
            None
            if terms is None
            else [TermFunction(term, self.criterion, self.arguments, self.loops) for term in terms]
        )

    def single(self, values: list[float]) -> float:
        """Evaluate at one scene of finite floats."""
        if self.terms is not None:
            try:
                parts = [term.single(values) for term in self.terms]
            except ArithmeticError:
                parts = [float("nan")]
            total = float(sum(parts))
            if sum(map(abs, parts)) <= _CANCELLED * abs(total) < np.inf or (len(parts) < 2 and total == total):
                return total
        return float(self.array([np.array([values[0]]), *values[1:]])[0])

    def array(self, values: list[Numbers]) -> FloatArray:
        """Evaluate at finite floats and flat arrays of one length, at least one of them an array."""
        result = np.empty(next(value.size for value in values if not isinstance(value, float)))
        if result.size:
            self.fill(values, [extremes(value) for value in values], result, Room())
        return result

    def fill(self, values: list[Numbers], ends: list[Ends], out: FloatArray, room: Room) -> None:
        """Evaluate as `array` does, given the smallest and the largest of each, into an array of one piece.

        Zeros have no sign.
        """
        with np.errstate(all="ignore"):  # what overflows on the way is mended
            self._sum(values, ends, out, room)
            low, high = extremes(out)
        if low > 0 and high < np.inf:  # as it is nearly always
            return
        missing = np.flatnonzero(~np.isfinite(out))
        if missing.size:
            self._mend(out, missing, values)
        out += 0.0  # -0.0 becomes 0.0

    def _sum(self, values: list[Numbers], ends: list[Ends], out: FloatArray, room: Room) -> None:
        if not self.terms:
            out.fill(np.nan if self.terms is None else 0.0)
            return
        self.terms[0].fill(values, ends, out, room)
        if len(self.terms) == 1:
            return
        sizes, part = np.abs(out, out=room("sizes", out.size)), room("term", out.size)
        for term in self.terms[1:]:
            term.fill(values, ends, part, room)
            out += part
            sizes += np.abs(part, out=part)
        out[sizes > _CANCELLED * np.abs(out, out=part)] = np.nan

    def _mend(self, result: FloatArray, missing: IntArray, values: list[Numbers]) -> None:
        """Evaluate by other means what the terms did not give."""
        columns = [
            np.full(missing.size, value) if isinstance(value, float) else value[missing] for value in values
        ]
        found, good = self._slow(columns)
        for i in np.flatnonzero(~good):
            point = {
                symbol: sp.Rational(float(column[i]))
                for symbol, column in zip(self.arguments, columns, strict=True)
            }
            found[i] = float(self.exact(point))
        if not np.isfinite(found).all():
            raise InputError("the damping coefficient is beyond the range of float64; use evaluate(digits=...)")
        result[missing] = found

    def _slow(self, columns: list[FloatArray]) -> tuple[FloatArray, BoolArray]:
        """Return the criterion by its definition, and where it is good: in extended precision where need be."""
        by_definition = self._at_a_point if self.criterion.weight is None else self._averaged
        result, good = np.zeros_like(columns[0]), np.zeros(columns[0].shape, dtype=bool)
        with np.errstate(all="ignore"):
            for real in _REALS:
                here = np.flatnonzero(~good)
                if here.size:
                    result[here], fine = by_definition(*(column[here].astype(real) for column in columns))
                    good[here] = fine & np.isfinite(result[here])
        return result, good

    def _at_a_point(
        self, speed: FloatArray, force: FloatArray, *parameters: FloatArray
    ) -> tuple[FloatArray, BoolArray]:
        """Return the criterion that is the slope at the belt speed, and where it is good."""
        value, bound = (np.broadcast_to(x, speed.shape) for x in self._slope(speed, *parameters))
        bound = bound * np.finfo(speed.dtype).eps
        good = (bound <= _SLOPE_ALLOWED * _EPSILON * np.abs(value)) | (bound * force < _NOTHING)
        return 0.0 - force * value, good

    def _averaged(
        self, speed: FloatArray, force: FloatArray, *parameters: FloatArray
    ) -> tuple[FloatArray, BoolArray]:
        """Return the criterion that is an average, and where it is good."""
        result, good = np.zeros_like(speed), speed > 0
        value, error = self._average(speed[good], [parameter[good] for parameter in parameters])
        result[good] = 0.0 - force[good] * value
        good[good] = error <= _ALLOWED * _EPSILON
        return result, good

    def _average(self, speed: FloatArray, parameters: list[FloatArray]) -> tuple[FloatArray, FloatArray]:
        """Average the slope by Gauss rules; return also the bound of its error relative to <|mu'|>."""
        scale = self._scale(*parameters, speed)
        kinks = [np.broadcast_to(kink, speed.shape) for kink in self._kinks(*parameters, speed)]
        value, size, error = gauss.average(
            self._slope, speed, parameters, self.criterion, scale=scale, kinks=kinks
        )
        with np.errstate(invalid="ignore"):
            for place, height, bound in self._jumps(*parameters, speed):
                # Of the slope there, a delta function of that height over V.
                p, epsilon = place / speed, np.finfo(speed.dtype).eps
                q, width = 2 - p, _JUMP * epsilon
                m = p * q
                share = self._weight(m, p, q) / speed
                near = self._weight(np.abs(m) + width, np.abs(p) + width, np.abs(q) + width) / speed
                inside = (place > 0) & (place < 2 * speed)
                share = np.where(inside, share, 0)
                value, size = value + height * share, size + np.abs(height * share)
                # Right at an end of [0, 2V] rounding decides how much of the jump there is.
                off = np.where(np.abs(m) < width, np.abs(near), np.where(inside, np.abs(near - share), 0))
                error = error + np.abs(height) * off + (bound + _JUMP * np.abs(height)) * np.abs(share) * epsilon
        return value, error / np.where(size > 0, size, 1)

    @cached_property
    def _jumps(self) -> Callable[..., list[FloatArray]]:
        """The places and heights of the jumps of mu, and the bounds of the heights' errors in epsilons."""
        steps = [[place, height, rounding_bound(height)] for place, height in jumps(self.mu)]
        compiled = function_of(self.arguments[2:], steps, "numpy")
        return lambda *columns: compiled(*columns[:-1]) if steps else []

    @cached_property
    def _weight(self) -> Callable[..., FloatArray]:
        """The weight w(s) as a function of m = 1 - s^2, 1 + s and 1 - s."""
        places = sp.symbols("m p q", positive=True, cls=sp.Dummy)
        return function_of(places, gauss.weight_of(self.criterion, *places), "numpy")

    @cached_property
    def _slope(self) -> Callable[..., tuple[FloatArray, FloatArray]]:
        return slope_with_bound(conditioned(sp.diff(self.mu, symbols.v)), [symbols.v, *self.arguments[2:]])

    @cached_property
    def _scale(self) -> Callable[..., FloatArray]:
        """The smallest scale of the law, no larger than the speed."""
        scales = speed_scales(conditioned(sp.diff(self.mu, symbols.v)), symbols.v)
        compiled = function_of(self.arguments[2:], scales, "numpy")

        def smallest(*columns: FloatArray) -> FloatArray:
            found = columns[-1]
            for scale in compiled(*columns[:-1]):
                scale = np.asarray(scale)
                found = np.where(np.isfinite(scale) & (scale > 0), np.minimum(found, scale), found)
            return found

        return smallest

    @cached_property
    def _kinks(self) -> Callable[..., list[FloatArray]]:
        compiled = function_of(self.arguments[2:], places(self.mu), "numpy")
        return lambda *columns: compiled(*columns[:-1])
