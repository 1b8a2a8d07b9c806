"""A criterion as a fast function that is accurate everywhere.

A law is split into terms, each an amplitude times a function F of one dimensionless speed r (`splitting`).
F is computed by the branch that serves its r (`profile`). Where terms cancel, and for laws that cannot be
split, the slope average is taken by Gauss rules with a bound of their rounding error (`gauss`). What that
bound does not allow goes to arbitrary precision, one value at a time.
"""

from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.core.numbers import to_mpf
from stickslip_sym.criteria import gauss
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.evaluation.bounds import rounding_bound
from stickslip_sym.formula.evaluation.branches import Branch
from stickslip_sym.formula.evaluation.conditioning import conditioned, speed_scales, without_squares
from stickslip_sym.formula.evaluation.exact import to_digits
from stickslip_sym.formula.evaluation.products import largest_exponent, plain_product, scaled_product
from stickslip_sym.formula.evaluation.profile import Profile, profile_of, slope_with_bound
from stickslip_sym.formula.evaluation.splitting import Term, split
from stickslip_sym.model.expression.pieces import jumps, places

__all__ = ["Exact", "StableFunction", "exact_value"]

_EPSILON = float(np.finfo(np.float64).eps)
_CANCELLED = 4.0  # the sizes of the terms over the size of their sum, from where the sum is taken otherwise
_ALLOWED = 64.0  # bound of the rounding error of a Gauss average, in units; it is some five times too large
_JUMP = 6.0  # units of rounding error of the weight at a jump
_SLOPE_ALLOWED = 16.0  # the same, of the slope at one point
_REALS = (np.float64, np.longdouble)  # where inputs nearly cancel, most processors have eleven bits to spare
_SAFE = 900.0  # binary exponents that no product may pass, lest something overflows on the way
_NOTHING = 2.0**-1073  # errors below are no more than the last bit of the smallest numbers
_WORTH_A_TABLE = 64  # elements with one shape for which branches are found

Exact = Callable[[Mapping[Any, Any]], Any]
"""From the exact values of all arguments to the criterion, as a number."""


def exact_value(expr: Any, slope: Any, point: Mapping[Any, Any], digits: int) -> Any:
    """Evaluate a closed form at exact values to `digits` digits; at V = 0 by its limit -N mu'(0+)."""
    if point[symbols.V] == 0:
        at_rest = _slope_at_rest(slope)
        if at_rest is None:
            return -to_mpf(point[symbols.N]) * _numeric_slope_at_rest(slope, point)
        expr = -symbols.N * at_rest
        if expr.is_infinite:
            raise InputError(_INFINITE)
    return to_digits(_uncancelled(expr), point, digits)


_INFINITE = "the slope of mu is infinite at v = 0, so the criterion has no value at V = 0"


@lru_cache(maxsize=128)
def _slope_at_rest(slope: Any) -> Any:
    """Return the limit of a slope at v = 0+; None where SymPy finds none, as for exponents without a value."""
    try:
        return sp.limit(slope, symbols.v, 0, "+")
    except (TypeError, ValueError, NotImplementedError):  # as SymPy says that it finds none
        return None


def _numeric_slope_at_rest(slope: Any, point: Mapping[Any, Any]) -> Any:
    """Return the limit of a slope at v = 0+ from its values at 1e-100 m/s and 1e-200 m/s."""
    near, nearer = (to_digits(slope, {**point, symbols.v: sp.Rational(1, 10**k)}, 20) for k in (100, 200))
    if abs(nearer) < abs(near) / 2:
        return 0 * nearer
    if abs(nearer - near) > abs(near) * 1e-12:
        raise InputError(_INFINITE)
    return nearer


_uncancelled = lru_cache(maxsize=128)(without_squares)


class _TermFunction:
    """A term of a law, compiled."""

    def __init__(self, term: Term, criterion: Criterion, arguments: Sequence[Any]) -> None:
        self.term, self.criterion = term, criterion
        self.number, self.size = float(term.number), float(term.size)
        self.shapes = [arguments.index(symbol) for symbol in term.shapes]
        bases = list(dict.fromkeys([symbols.V, symbols.N, *term.amplitude, *term.scale]))
        self.base_exprs = bases
        self.bases = [
            arguments.index(base) if base.is_Symbol else function_of(arguments, base, "numpy") for base in bases
        ]
        self.amplitude = [float(term.amplitude.get(base, 0)) + (base == symbols.N) for base in bases]
        self.ratio = [(base == symbols.V) - float(term.scale.get(base, 0)) for base in bases]
        self._profiles: dict[Any, Profile | None] = {}
        self._asked: set[Any] = set()

    def profile(self, shape: tuple[float, ...], count: int) -> Profile | None:
        """Return the branches for values of the shape parameters; None if there are none, or not worth it."""
        if shape not in self._profiles:
            if shape and count < _WORTH_A_TABLE and shape not in self._asked:
                self._asked.add(shape)
                return None
            exact = {symbol: sp.Rational(value) for symbol, value in zip(self.term.shapes, shape, strict=True)}
            self._profiles[shape] = profile_of(self.term.mu.xreplace(exact), self.criterion)
        return self._profiles[shape]

    def __call__(self, values: list[Any]) -> Any:
        """Evaluate at floats and at least one flat array, all of one length; NaN where no branch serves."""
        count = next(value.size for value in values if not isinstance(value, float))
        columns = [values[i] for i in self.shapes]
        if all(isinstance(column, float) for column in columns):
            return self._by_branches(values, self.profile(tuple(columns), count), count)
        shapes = np.stack([np.broadcast_to(column, (count,)) for column in columns])
        kinds, which = np.unique(shapes, axis=1, return_inverse=True)
        result = np.full(count, np.nan)
        if kinds.shape[1] * _WORTH_A_TABLE <= count:
            for kind in range(kinds.shape[1]):
                here = np.flatnonzero(which.ravel() == kind)
                taken = [value if isinstance(value, float) else value[here] for value in values]
                shape = tuple(float(x) for x in kinds[:, kind])
                result[here] = self._by_branches(taken, self.profile(shape, here.size), here.size)
        return result

    def _by_branches(self, values: list[Any], profile: Profile | None, count: int) -> Any:
        if profile is None:
            return np.full(count, np.nan)
        bases = [values[base] if isinstance(base, int) else base(*values) for base in self.bases]
        reach = [largest_exponent(base) for base in bases]
        most = max((abs(branch.power) for branch in profile.branches if branch is not None), default=0.0)
        plain = (
            sum(
                r * (abs(a) + (1 + most) * abs(b))
                for r, a, b in zip(reach, self.amplitude, self.ratio, strict=True)
                if r
            )
            < _SAFE
        )
        ratio = [(base, e) for base, e in zip(bases, self.ratio, strict=True) if e]
        if plain:
            r = plain_product(1 / self.size, ratio)
        else:
            with np.errstate(invalid="ignore"):
                r = scaled_product(1 / self.size, ratio, np.ones(count))
        if isinstance(r, float):
            r = np.full(count, r)
        low, high = float(r.min()), float(r.max())
        if not high < np.inf:
            # One over a scale of 0, or V far beyond all scales.
            finite = np.isfinite(r)
            result = np.full(count, np.nan)
            taken = [value if isinstance(value, float) else value[finite] for value in values]
            if finite.any():
                result[finite] = self._by_branches(taken, profile, int(finite.sum()))
            return result
        first, last = bisect_right(profile.starts, low) - 1, bisect_right(profile.starts, high) - 1
        if first == last:
            return self._branch(profile.branches[first], r, bases, plain)
        result = np.empty(count)
        ends = [*profile.starts[1:], np.inf]
        for branch, start, end in zip(
            profile.branches[first : last + 1], profile.starts[first:], ends[first:], strict=False
        ):
            here = np.flatnonzero((r >= start) & (r < end))
            if here.size:
                part = [base if isinstance(base, float) else base[here] for base in bases]
                result[here] = self._branch(branch, r[here], part, plain)
        return result

    def _branch(self, branch: Branch | None, r: Any, bases: list[Any], plain: bool) -> Any:
        if branch is None:
            return np.full(r.shape, np.nan)
        exponents = [a + branch.power * e for a, e in zip(self.amplitude, self.ratio, strict=True)]
        factors = [(base, e) for base, e in zip(bases, exponents, strict=True) if e]
        number = self.number * self.size**-branch.power
        value = branch.array(r)
        if not plain:
            return scaled_product(number, factors, value)
        value *= plain_product(number, factors)
        return value

    def single(self, values: list[float]) -> float:
        """Evaluate at floats; NaN where no branch serves, or a product might overflow on the way."""
        bases = [values[base] if isinstance(base, int) else float(base(*values)) for base in self.bases]
        if not all(1e-60 < abs(base) < 1e60 for base in bases):
            return float("nan")
        profile = self.profile(tuple(values[i] for i in self.shapes), 1)
        if profile is None:
            return float("nan")
        r = 1 / self.size
        for base, exponent in zip(bases, self.ratio, strict=True):
            if exponent:
                r *= base**exponent
        branch = profile.branches[bisect_right(profile.starts, r) - 1]
        if branch is None:
            return float("nan")
        value: float = branch.scalar(r) * self.number * self.size**-branch.power
        for base, a, e in zip(bases, self.amplitude, self.ratio, strict=True):
            exponent = a + branch.power * e
            if exponent:
                value *= base**exponent
        return value


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
    """

    def __init__(self, mu: Any, criterion: Criterion, arguments: Sequence[Any], exact: Exact) -> None:
        self.mu, self.criterion, self.exact = mu, criterion, exact
        self.arguments = list(arguments)

    @cached_property
    def terms(self) -> list[_TermFunction] | None:
        """The terms of the law; None where there are none to be had."""
        if self.criterion.weight is None:
            return None
        terms = split(self.mu)
        return None if terms is None else [_TermFunction(term, self.criterion, self.arguments) for term in terms]

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

    def array(self, values: list[Any]) -> Any:
        """Evaluate at finite floats and flat arrays of one length, at least one of them an array."""
        count = next(value.size for value in values if not isinstance(value, float))
        with np.errstate(all="ignore"):  # what overflows on the way is mended
            result = np.full(count, np.nan) if self.terms is None else self._sum(values, count)
        missing = np.flatnonzero(~np.isfinite(result))
        if missing.size:
            self._mend(result, missing, values)
        return result

    def _sum(self, values: list[Any], count: int) -> Any:
        assert self.terms is not None
        if not self.terms:
            return np.zeros(count)
        total = self.terms[0](values)
        if len(self.terms) == 1:
            return total
        sizes = np.abs(total)
        for term in self.terms[1:]:
            part = term(values)
            total += part
            sizes += np.abs(part, out=part)
        total[sizes > _CANCELLED * np.abs(total)] = np.nan
        return total

    def _mend(self, result: Any, missing: Any, values: list[Any]) -> None:
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

    def _slow(self, columns: list[Any]) -> tuple[Any, Any]:
        """Return the criterion by its definition, and where it is good."""
        speed, force = columns[:2]
        with np.errstate(all="ignore"):
            if self.criterion.weight is None:
                return self._at_a_point(columns)
            result, good = np.zeros_like(speed), np.zeros(speed.shape, dtype=bool)
            for real in _REALS:
                here = np.flatnonzero((speed > 0) & ~good)
                if here.size:
                    taken = [column[here].astype(real) for column in columns]
                    value, error = self._average(taken[0], taken[2:])
                    result[here] = 0.0 - force[here] * value
                    good[here] = (error <= _ALLOWED * _EPSILON) & np.isfinite(result[here])
            return result, good

    def _at_a_point(self, columns: list[Any]) -> tuple[Any, Any]:
        """Return the criterion that is the slope at the belt speed, and where it is good."""
        result, good = np.zeros_like(columns[0]), np.zeros(columns[0].shape, dtype=bool)
        for real in _REALS:
            here = np.flatnonzero(~good)
            if here.size:
                speed, force, *parameters = (column[here].astype(real) for column in columns)
                value, bound = (np.broadcast_to(x, speed.shape) for x in self._slope(speed, *parameters))
                bound = bound * np.finfo(real).eps
                result[here] = 0.0 - force * value
                good[here] = (bound <= _SLOPE_ALLOWED * _EPSILON * np.abs(value)) | (bound * force < _NOTHING)
                good[here] &= np.isfinite(result[here])
        return result, good

    def _average(self, speed: Any, parameters: list[Any]) -> tuple[Any, Any]:
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
    def _jumps(self) -> Callable[..., list[Any]]:
        """The places and heights of the jumps of mu, and the bounds of the heights' errors in epsilons."""
        steps = [[place, height, rounding_bound(height)] for place, height in jumps(self.mu)]
        compiled = function_of(self.arguments[2:], steps, "numpy")
        return lambda *columns: compiled(*columns[:-1]) if steps else []

    @cached_property
    def _weight(self) -> Callable[..., Any]:
        """The weight w(s) as a function of m = 1 - s^2, 1 + s and 1 - s."""
        places = sp.symbols("m p q", positive=True, cls=sp.Dummy)
        return function_of(places, gauss.weight_of(self.criterion, *places), "numpy")

    @cached_property
    def _slope(self) -> Callable[..., tuple[Any, Any]]:
        return slope_with_bound(conditioned(sp.diff(self.mu, symbols.v)), [symbols.v, *self.arguments[2:]])

    @cached_property
    def _scale(self) -> Callable[..., Any]:
        """The smallest scale of the law, no larger than the speed."""
        scales = speed_scales(conditioned(sp.diff(self.mu, symbols.v)), symbols.v)
        compiled = function_of(self.arguments[2:], scales, "numpy")

        def smallest(*columns: Any) -> Any:
            found = columns[-1]
            for scale in compiled(*columns[:-1]):
                scale = np.asarray(scale)
                found = np.where(np.isfinite(scale) & (scale > 0), np.minimum(found, scale), found)
            return found

        return smallest

    @cached_property
    def _kinks(self) -> Callable[..., list[Any]]:
        compiled = function_of(self.arguments[2:], places(self.mu), "numpy")
        return lambda *columns: compiled(*columns[:-1])
