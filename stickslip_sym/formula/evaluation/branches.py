"""The average F(r) of a profile in floats: short formulas, each for a range of r.

They are made once for a profile, from values in ball arithmetic alone:

- a power series for small r, with an exponential taken out where every term of g has it;
- the closed form, from where on a dense comparison with balls says that it does not cancel;
- polynomials in panels for what lies between;
- a series in 1/r for large r, or the leading term beyond all scales.

Each branch is r^power G(r), and G and the power stay apart where a product would leave the range of floats. A
float and an array go through the same operations, so that they agree to the last digit.
"""

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
import sympy as sp
from flint import arb, arb_mat, arb_poly, arb_series, fmpq

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, FloatArray, Numbers
from stickslip_sym.core.balls import rational, working_precision
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.evaluation.values import BITS, Values, mean_power, slope_of

__all__ = ["Branch", "Branches", "MeanSlope", "Sum", "Table", "alike", "branches_of", "power_of"]

_EPSILON = 2.0**-52
_NEGLIGIBLE = 2.0**-57  # of a value: what a series may leave out
_CONDITION = 1.5  # of a series: the sum of its terms' sizes over the size of the sum
_UNITS, _SOME_UNITS = (
    2.75,
    3.5,
)  # of eps <|g'|>, by which a closed form may differ from balls: where it begins, beyond
_TERMS = 30  # of a series, at most
_LARGEST_POWER = 8  # of a whole exponent that is multiplied out


# -- what a branch is ----------------------------------------------------------------------------


def power_of(base: Numbers, exponent: float) -> Numbers:
    """Raise floats or arrays to a power: whole and half ones by products, quotients and square roots."""
    if exponent < 0:
        return 1.0 / power_of(base, -exponent)
    whole = int(exponent)
    if whole > _LARGEST_POWER or exponent - whole not in (0.0, 0.5):
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


def horner(coefficients: Sequence[float], z: Numbers) -> Numbers:
    """Evaluate a polynomial at floats or arrays."""
    if len(coefficients) == 1:
        return coefficients[0] if isinstance(z, float) else np.full_like(z, coefficients[0])
    value = z * coefficients[-1]
    for coefficient in coefficients[-2:0:-1]:
        value += coefficient
        value *= z
    value += coefficients[0]
    return value


@dataclass(frozen=True)
class Sum:
    """G = sum_i f_i(r) P_i(z) with polynomials P_i in z = r^variable.

    Attributes
    ----------
    power, variable : float
    parts : tuple of (sympy.Expr or None, tuple of float)
        Functions f_i of the symbol V, None for 1, and the coefficients of P_i.
    """

    power: float
    variable: float
    parts: tuple[tuple[Expr | None, tuple[float, ...]], ...]

    @cached_property
    def is_light(self) -> bool:
        """Whether G costs less than picking elements out of an array and putting them back."""
        return all(function is None or isinstance(function, sp.exp) for function, _ in self.parts)

    @cached_property
    def _functions(self) -> list[Callable[[Numbers], Numbers] | None]:
        return [None if f is None else alike(function_of([symbols.V], f, "numpy"), f) for f, _ in self.parts]

    def __call__(self, r: Numbers) -> Numbers:
        """Return G."""
        z = power_of(r, self.variable)
        total: Numbers | None = None
        for function, (_, coefficients) in zip(self._functions, self.parts, strict=True):
            part = horner(coefficients, z)
            if function is not None:
                part = part * function(r)
            total = part if total is None else total + part
        assert total is not None
        return total


def alike(function: Callable[..., Any], expr: Expr) -> Callable[..., Any]:
    """Return a function of an expression that has the same digits for floats as in arrays.

    NumPy has other powers for a float than for an array; sums, products and its functions are the same.
    """
    if not any(node.exp != -1 for node in expr.atoms(sp.Pow)):
        return function

    def of_numbers(*values: Numbers) -> Any:
        if any(not isinstance(value, float) for value in values):
            return function(*values)
        results = function(*(np.array([value]) for value in values))
        return [np.ravel(x)[0] for x in results] if isinstance(results, list) else results[0]

    return of_numbers


@dataclass(frozen=True, eq=False)
class Table:
    """G as polynomials in panels: panel i reaches from edges[i] to edges[i + 1].

    Attributes
    ----------
    edges : numpy.ndarray
        One more than there are panels.
    origins : numpy.ndarray
        Of each panel: its variable y is r, or sqrt(r - origin) where the origin is a number: beyond a kink the
        average under a weight that ends like a square root is analytic in that.
    centres, stretches : numpy.ndarray
        Bring y to t = (y - centre) stretch, -1 <= t <= 1.
    rows : numpy.ndarray
        Panels by coefficients of powers of t.
    """

    edges: FloatArray
    origins: FloatArray
    centres: FloatArray
    stretches: FloatArray
    rows: FloatArray
    power = 0.0
    is_light = False

    @cached_property
    def _columns(self) -> list[FloatArray]:
        return [np.ascontiguousarray(column) for column in self.rows.T]

    @cached_property
    def has_roots(self) -> bool:
        """Whether a panel has an origin."""
        return bool(np.isfinite(self.origins).any())

    def __call__(self, r: Numbers) -> Numbers:
        """Return G."""
        panel = np.searchsorted(self.edges[1:-1], r, side="right")
        y = r
        if self.has_roots:
            origin = self.origins[panel]
            y = np.where(np.isfinite(origin), np.sqrt(np.abs(r - origin)), r)
        t = (y - self.centres[panel]) * self.stretches[panel]
        *rest, last = self._columns
        value = last[panel]
        for column in reversed(rest):
            value = value * t
            value += column[panel]
        return value


Branch = Sum | Table


@dataclass(frozen=True, eq=False)
class Branches:
    """F(r) by branches.

    Attributes
    ----------
    starts : tuple of float
        Where each branch begins; the first at 0.
    branches : tuple of Branch
    """

    starts: tuple[float, ...]
    branches: tuple[Branch, ...]

    @cached_property
    def steepest(self) -> float:
        """The largest size of a branch's power."""
        return max(abs(branch.power) for branch in self.branches)

    def at(self, r: float) -> Branch:
        """Return the branch that holds at r."""
        return self.branches[bisect_right(self.starts, r) - 1]

    def __call__(self, r: Numbers) -> Numbers:
        """Return F at a float or at each element of a flat array, as far as r^power stays within range."""
        if isinstance(r, float):
            return _full(self.at(r), r)
        first, last = (bisect_right(self.starts, float(end)) - 1 for end in (r.min(), r.max()))
        if first == last:
            return _full(self.branches[first], r)
        edges = [-np.inf, *self.starts[first + 1 : last + 1], np.inf]
        below = [0, *(int(np.count_nonzero(r < edge)) for edge in edges[1:-1]), r.size]
        counts = [high - low for low, high in pairwise(below)]
        common = max(range(len(counts)), key=counts.__getitem__)
        if self.branches[first + common].is_light:
            # For all, without copies; the others, where it may overflow, are put right.
            with np.errstate(all="ignore"):
                result = np.asarray(_full(self.branches[first + common], r))
            counts[common] = 0
        else:
            result = np.empty_like(r)
        for branch, low, high, count in zip(self.branches[first:], edges, edges[1:], counts, strict=False):
            if count:
                mask = r < high if low == -np.inf else r >= low if high == np.inf else (r >= low) & (r < high)
                here = np.flatnonzero(mask)
                result[here] = _full(branch, r.take(here))
        return result

    def apart(self, r: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return G and the power of r at each element of a flat array."""
        which = np.searchsorted(self.starts, r, side="right") - 1
        values, powers = np.empty_like(r), np.empty_like(r)
        for i in np.unique(which):
            here = np.flatnonzero(which == i)
            values[here] = self.branches[i](r[here])
            powers[here] = self.branches[i].power
        return values, powers


def _full(branch: Branch, r: Numbers) -> Numbers:
    value = branch(r)
    return value if branch.power == 0 else value * power_of(r, branch.power)


# -- how branches are made -----------------------------------------------------------------------

_LOW, _HIGH = -30, 60  # binary exponents of r between which a profile is followed
_FAR = (0, 140, 400)  # binary orders beyond these, where a leading term is read off
_LEADING = 4 * _EPSILON  # by which the leading term may differ from the value at the farthest of them
_POWERS = [k / 2 for k in range(-12, 9)]  # that are tried for it, beside those of the profile
_STEEP = 1e-6  # of a measured power of r, to the next half one
_SERIES_BITS = 300  # for coefficients of power series, before they cancel
_INSIDE = 0.25  # of the radius of convergence, up to which a series is tried
_FRACTIONAL, _FRACTIONAL_END = 16, 3  # powers of v^e, and the binary order of the r where such a series ends
_SERIES_GRID = 2.0 ** np.arange(-6, 3.01, 0.125)
_TAIL_NODES = 31
_TAILS = ((3, -1.0), (4, -1.0), (5, -1.0), (6, -1.0), (7, -1.0), (9, -1.0), (11, -1.0), (5, -0.5), (7, -0.5))
"""Binary exponents of the r from where a series is tried, and powers of r that it runs in."""
_PLAIN_TERMS, _LOG_TERMS = 18, 8
_LOG_TAILS = (3, 4, 5, 6, 8)
"""Terms of the two polynomials of a tail with a logarithm, and binary exponents of r from where it is tried."""
_NODES = 19  # of a panel
_SMOOTH = 0.5 * _EPSILON  # of <|g'|>: the last coefficients of a panel
_BEFORE_THE_END = 2.0**-9  # of the r at which a profile ends: nearer to it balls are asked
_PANELS = 4000  # at most
_HALVINGS = 12  # of a panel that is not smooth
_NEAR_KINK = 1.25  # times r at a kink: up to there the panel's variable is the square root
_CLOSE = 4  # octaves from where a closed form begins, in which it is compared at more points
_COARSE, _FINE = 2, 16  # points in an octave at which a closed form is compared: far out, and where it begins
_MODERATE = 8  # binary exponent of r up to which 8 points are compared
_ELEMENTARY = (sp.exp, sp.log, sp.atan, sp.asinh)


@lru_cache(maxsize=256)
def branches_of(
    profile: Expr, criterion: Criterion, closed: Expr | None = None, shapes: tuple[tuple[Expr, Expr], ...] = ()
) -> Branches | None:
    """Return the branches of F for a profile; None if there are none.

    Parameters
    ----------
    profile : sympy.Expr
        g in the symbol v, and in shapes.
    criterion : Criterion
    closed : sympy.Expr, optional
        F in the symbol V and the shapes.
    shapes : tuple of (Symbol, Rational)
        Values of all shapes.
    """
    with working_precision(BITS):
        return _Builder(profile, criterion, closed, dict(shapes)).build()


class _Builder:
    """Makes the branches of one average."""

    def __init__(self, profile: Expr, criterion: Criterion, closed: Expr | None, point: dict[Expr, Expr]) -> None:
        self.profile, self.criterion, self.point = profile, criterion, point
        self.values = Values(profile, criterion, closed, point)
        local = criterion.weight is None
        self.closed = closed
        if local:
            self.closed = -slope_of(self.values.last_piece).subs(symbols.v, symbols.V).xreplace(point)
        mean_slope, shapes = MeanSlope(profile, criterion, list(point)), [float(value) for value in point.values()]

        def of_shapes(r: FloatArray) -> FloatArray:
            return mean_slope(r, *shapes)

        self._mean_slope = of_shapes
        reach = 1 if criterion.weight is None else 2
        self.corners = [float(kink) / reach for kink in self.values.kinks]
        self._panels = 0

    def build(self) -> Branches | None:
        """Return the branches in order, or None."""
        slope = sp.diff(self.profile, symbols.v)
        if not self.profile.has(symbols.v):
            return Branches((0.0,), (Sum(0.0, 1.0, ((None, (0.0,)),)),))
        if not self.corners and slope.is_polynomial(symbols.v):
            return self._polynomial(sp.degree(slope, symbols.v))
        if self.profile.is_Pow and self.profile.base == symbols.v and (e := self._exponent()) is not None:
            value = -arb(rational(e)) * mean_power(self.criterion, rational(e) - 1)
            return Branches((0.0,), (Sum(float(e) - 1, 1.0, ((None, (float(value),)),)),))
        if self.values.reach < np.inf:
            return self._up_to(self.values.reach)
        last = self._tail()
        if last is None and (leading := self._leading([2.0 ** (_HIGH + k) for k in _FAR])) is not None:
            last = 2.0**_HIGH, leading
        direct = self._direct(2.0**_HIGH if last is None else last[0])
        outer = [pair for pair in (direct, last) if pair is not None]
        if not outer:
            return None
        closed = outer[0][0]
        first = self._series(closed)
        if first is None and (leading := self._leading([2.0 ** (_LOW - k) for k in _FAR])) is not None:
            first = 2.0**_LOW, leading
        if first is None:
            return None
        opened = first[0]
        pairs: list[tuple[float, Branch]] = [(0.0, first[1])]
        if opened < closed:
            table = self._table(opened, closed)
            if table is None:
                return None
            pairs.append((opened, table))
        pairs += [(max(start, opened), branch) for start, branch in outer]
        return Branches(tuple(start for start, _ in pairs), tuple(branch for _, branch in pairs))

    def _up_to(self, reach: float) -> Branches | None:
        """Return the branches of a profile that ends at a speed."""
        if self.criterion.weight is None:
            formula = Sum(0.0, 1.0, ((self.closed, (1.0,)),))
            return Branches((0.0,), (formula,))
        end = (1 - _BEFORE_THE_END) * reach / 2
        first = self._series(end)
        if first is None or (table := self._table(first[0], end)) is None:
            return None
        nothing = Sum(0.0, 1.0, ((None, (math.nan,)),))
        return Branches((0.0, first[0], end), (first[1], table, nothing))

    def _polynomial(self, degree: int) -> Branches:
        """Sum the moments; for large r the same polynomial in 1/r."""
        slopes = self.values.taylor(degree + 1)
        assert slopes is not None
        coefficients = [float(-g * mean_power(self.criterion, fmpq(k))) for k, g in enumerate(slopes)]
        low = next(k for k, c in enumerate(coefficients) if c != 0)
        used = coefficients[low:]
        step = 2 if all(c == 0 for c in used[1::2]) else 1
        small = Sum(float(low), float(step), ((None, tuple(used[::step])),))
        if len(used) == 1:
            return Branches((0.0,), (small,))
        large = Sum(float(degree), -float(step), ((None, tuple(used[::-1][::step])),))
        return Branches((0.0, 1.0), (small, large))

    # -- small r ---------------------------------------------------------------------------------

    def _series(self, closed: float) -> tuple[float, Sum] | None:
        """Expand F around r = 0, at most up to where other branches begin; return it and where it ends."""
        decay = self._decay()
        with working_precision(_SERIES_BITS, 2 * _TERMS):
            slopes = self.values.taylor(2 * _TERMS)
            if slopes is None:
                return self._fractional_series(closed)
            means = [-c * mean_power(self.criterion, fmpq(k)) for k, c in enumerate(slopes)]
            result = arb_series(means, prec=2 * _TERMS) * arb_series([0, arb(decay)], prec=2 * _TERMS).exp()
            # What may be 0 is: the balls are small beside every coefficient that matters.
            coefficients = [arb(0) if result[k].contains(0) else result[k] for k in range(2 * _TERMS)]
        function = sp.exp(-sp.Float(decay) * symbols.V) if decay else None
        return self._short_series(coefficients, 0.0, 1.0, function, min(closed, self._inside(self.values.radius)))

    def _inside(self, radius: float) -> float:
        return min(_INSIDE * radius, *self.corners, np.inf)

    def _short_series(
        self, coefficients: list[arb], power: float, step: float, function: Expr | None, end: float
    ) -> tuple[float, Sum] | None:
        """Return f(r) r^p sum_k c_k r^(q k) in as few terms as it takes, and the r up to which it is good."""
        low = next((k for k, c in enumerate(coefficients) if c != 0), None)
        if low is None:
            return None
        used = coefficients[low:]
        z = _SERIES_GRID[2 ** (1 / 8) * end >= _SERIES_GRID] ** step
        parts = np.array([float(c) for c in used]) * z[:, None] ** np.arange(len(used))
        total, rest = np.abs(parts.sum(axis=1)), np.cumsum(np.abs(parts)[:, ::-1], axis=1)[:, ::-1]
        negligible = rest < _NEGLIGIBLE * total[:, None]
        needed = np.where(negligible.any(axis=1), negligible.argmax(axis=1), len(used))
        good = (needed <= _TERMS) & (rest[:, 0] <= _CONDITION * total)
        last = z.size if good.all() else int((~good).argmax())
        if last == 0:
            return None
        used = used[: max(2, int(needed[last - 1]))]
        stride = 2 if step == 1 and all(c == 0 for c in used[1::2]) else 1
        short = _shortest(arb_poly(used[::stride]), float(z[last - 1]) ** stride, _TERMS)
        branch = Sum(power + low * step, step * stride, ((function, short),))
        return min(float(_SERIES_GRID[last - 1]), *self.corners, np.inf), branch

    def _fractional_series(self, closed: float) -> tuple[float, Sum] | None:
        """The same for a profile with one power v^e that is not whole."""
        exponent = self._exponent()
        rows = None if exponent is None else self.values.taylor_in_powers(exponent, _FRACTIONAL, 2 * _TERMS)
        if rows is None:
            return None
        e = rational(exponent)
        means = [
            [
                -c * (k * e + j) * mean_power(self.criterion, k * e + j - 1) if k or j else arb(0)
                for j, c in enumerate(row)
            ]
            for k, row in enumerate(rows)
        ]
        if len(means[0]) == 1:
            coefficients = [row[0] for row in means]
            radius = _radius(coefficients) ** (1 / float(e))
            return self._short_series(
                coefficients[1:], float(e) - 1, float(e), None, min(closed, self._inside(radius))
            )
        end = 2.0**-_FRACTIONAL_END
        while end > 2.0**_LOW and abs(float(means[-1][0]) * end ** (float(e) * (len(means) - 1))) > _NEGLIGIBLE:
            end /= 2
        parts = []
        for k, row in enumerate(means):
            # Of k = 0 the constant of g has no slope; r^(k e - 1) stands before the others.
            kept = row[1:] if k == 0 else row
            count = 1 + max((n for n, c in enumerate(kept) if abs(float(c)) * end**n > _NEGLIGIBLE), default=0)
            function = None if k == 0 else symbols.V ** sp.Float(float(k * e) - 1)
            parts.append((function, tuple(float(c) for c in kept[:count])))
        return end, Sum(0.0, 1.0, tuple(parts))

    def _exponent(self) -> Expr | None:
        """Return the value of e if v occurs, apart from whole powers, as v^e only."""
        exponents = {node.exp for node in self.profile.atoms(sp.Pow) if node.base == symbols.v}
        exponents = {e.xreplace(self.point) for e in exponents if not e.is_Integer}
        return exponents.pop() if len(exponents) == 1 else None

    def _decay(self) -> float:
        """Return the rate k if every term of g' has a factor exp(-k v), else 0."""
        rates = set()
        for term in sp.Add.make_args(sp.expand(sp.diff(self.profile, symbols.v))):
            exponents = [factor.args[0] for factor in sp.Mul.make_args(term) if isinstance(factor, sp.exp)]
            rate = -sp.Add(*exponents).coeff(symbols.v)
            rates.add(float(rate) if rate.is_number and rate.is_positive else 0.0)
        return min(rates)

    # -- large r ---------------------------------------------------------------------------------

    def _tail(self) -> tuple[float, Sum] | None:
        """Fit F for large r by a power of r times polynomials."""
        power = self._power(2.0**_HIGH)
        plain = None if power is None else self._plain_tail(power)
        return self._logarithmic_tail(power) if plain is None else plain

    def _plain_tail(self, power: float) -> tuple[float, Sum] | None:
        """Fit r^-power F for large r by a polynomial in 1/r, or in its square root."""
        for exponent, variable in _TAILS:
            start = 2.0**exponent * max(1.0, *self.corners, 0.0)

            def scaled(z: arb, variable: float = variable) -> arb:
                r = z ** arb(1 / variable)
                return self.values(r) * r ** arb(-power)

            try:
                coefficients = _shortest(scaled, start**variable, _TAIL_NODES - 5)
            except ArithmeticError:
                continue
            sizes = np.abs(coefficients) * start ** (variable * np.arange(len(coefficients)))
            if sizes.sum() <= _CONDITION * abs(np.dot(np.sign(coefficients), sizes)):
                return start, Sum(power, variable, ((None, coefficients),))
        return None

    def _logarithmic_tail(self, power: float | None) -> tuple[float, Sum] | None:
        """Fit F for large r by two polynomials in z = 1/r, one of them times log(r), through values at nodes."""
        if power is None:
            leading = self._leading([2.0 ** (_HIGH + k) for k in _FAR])
            if leading is None or len(leading.parts) < 2:
                return None
            power = leading.power
        size = _PLAIN_TERMS + _LOG_TERMS
        for exponent in _LOG_TAILS:
            start = 2.0**exponent * max(1.0, *self.corners, 0.0)
            nodes = [(1 + t) / 2 for t in _chebyshev(size).nodes]  # of z times start
            speeds = [arb(start) / x for x in nodes]
            rows = [
                [x**k for k in range(_PLAIN_TERMS)] + [x**k * r.log() for k in range(_LOG_TERMS)]
                for x, r in zip(nodes, speeds, strict=True)
            ]
            values = [[self.values(r) * r ** arb(-power)] for r in speeds]
            try:
                found = arb_mat(rows).solve(arb_mat(values)).entries()
            except (ZeroDivisionError, ValueError):
                continue
            scaled = [
                float(c) * start ** (k if k < _PLAIN_TERMS else k - _PLAIN_TERMS) for k, c in enumerate(found)
            ]
            plain, logarithmic = tuple(scaled[:_PLAIN_TERMS]), tuple(scaled[_PLAIN_TERMS:])
            branch = Sum(power, -1.0, ((None, plain), (sp.log(symbols.V), logarithmic)))
            checked = start * 2.0 ** np.concatenate([np.arange(0, 4, 1 / 3), np.arange(4, _HIGH - exponent, 4)])
            if self._agreed(branch, checked, _SOME_UNITS) == checked[0]:
                return start, branch
        return None

    def _power(self, r: float) -> float | None:
        """Return the power of r by which F goes far out; None if there is a logarithm too."""
        values = [float(self.values(arb(factor * r))) for factor in (1.0, 2.0, 4.0)]
        if not (np.isfinite(values).all() and (min(values) > 0 or max(values) < 0)):
            return None
        powers = [np.log2(b / a) for a, b in pairwise(values)]
        power = min(self._powers(), key=lambda p: abs(p - powers[0]))
        return power if max(abs(p - power) for p in powers) < _STEEP else None

    def _powers(self) -> list[float]:
        exponent = self._exponent()
        return _POWERS if exponent is None else [*_POWERS, float(exponent) - 1, -float(exponent) - 1]

    def _leading(self, places: list[float]) -> Sum | None:
        """Return the leading term beyond three places that lie outside the range, in order."""
        r = [arb(place) for place in places]
        values = [self.values(x) for x in r]
        if all(value == 0 for value in values):
            return Sum(0.0, 1.0, ((None, (0.0,)),))
        if not all(value.is_finite() and not value.contains(0) for value in values):
            return None
        logs = [x.log() for x in r]
        for power in self._powers():
            y = [value * x ** arb(-power) for value, x in zip(values, r, strict=True)]
            slope = (y[1] - y[0]) / (logs[1] - logs[0])
            constant = y[0] - slope * logs[0]
            if bool(abs(constant + slope * logs[2] - y[2]) <= _LEADING * abs(y[2])):
                if bool(abs(slope * logs[2]) < _LEADING * abs(y[2])):
                    return Sum(power, 1.0, ((None, (float(y[0]),)),))
                return Sum(power, 1.0, ((None, (float(constant),)), (sp.log(symbols.V), (float(slope),))))
        return None

    # -- what lies between -----------------------------------------------------------------------

    def _direct(self, stop: float) -> tuple[float, Sum] | None:
        """Take the closed form, from where on it agrees with balls; None if it does nowhere below `stop`."""
        local = self.criterion.weight is None
        if not self.closed or ((self.point or self.corners) and not local) or self.closed.has(sp.I):
            return None
        if not local and not all(isinstance(f, _ELEMENTARY) for f in self.closed.atoms(sp.Function)):
            return None
        branch = _as_sum(self.closed)
        if branch is None:
            return None
        top, moderate = np.log2(stop), min(float(_MODERATE), np.log2(stop))
        far, near = np.arange(moderate, top, 1 / _COARSE), np.arange(-4, moderate, 1 / 8)
        start = self._agreed(branch, 2.0 ** np.concatenate([near, far]), _SOME_UNITS)
        if start is None:
            return None
        begin = np.log2(start)
        start = self._agreed(branch, 2.0 ** np.arange(begin, min(begin + _CLOSE, top), 1 / _FINE), _UNITS)
        return None if start is None or start >= stop else (start, branch)

    def _agreed(self, branch: Sum, r: FloatArray, units: float) -> float | None:
        """Return the least of some r, ascending, from where on a branch agrees with balls; None if nowhere."""
        with np.errstate(all="ignore"):
            got = np.asarray(_full(branch, r))
        sizes = self._mean_slope(r)
        start = None
        for x, value, size in zip(r[::-1], got[::-1], sizes[::-1], strict=True):
            if not abs(float(self.values(arb(float(x))) - arb(float(value)))) <= units * _EPSILON * size:
                break
            start = float(x)
        return start

    def _table(self, start: float, stop: float) -> Table | None:
        """Fit F by a polynomial in each of some panels, as many as it takes."""
        halves = np.arange(np.floor(2 * np.log2(start)), np.ceil(2 * np.log2(stop)) + 1) / 2
        inside = [x for x in 2.0**halves if start < x < stop]
        inside += [x for corner in self.corners for x in (corner, _NEAR_KINK * corner) if start < x < stop]
        edges = [start, *sorted(set(inside)), stop]
        panels: list[_Panel] = []
        for left, right in pairwise(edges):
            rooted = left in self.corners and not self.criterion.is_polynomial
            parts = self._fitted(left, right, left if rooted else None, _HALVINGS)
            if parts is None:
                return None
            panels += parts
        columns = list(zip(*panels, strict=True))
        ends, origins, centres, stretches, rows = (np.array(column) for column in columns)
        return Table(np.append(ends, stop), origins, centres, stretches, rows)

    def _fitted(self, left: float, right: float, origin: float | None, halvings: int) -> "list[_Panel] | None":
        """Fit F between two r, in halves where one polynomial is not enough."""
        self._panels += 1
        if self._panels > _PANELS:
            return None
        low, high = (left, right) if origin is None else (np.sqrt(left - origin), np.sqrt(right - origin))
        centre, stretch = (low + high) / 2, 2 / (high - low)
        y = [arb(centre) + t / arb(stretch) for t in _chebyshev(_NODES).nodes]
        r = y if origin is None else [arb(origin) + t * t for t in y]
        coefficients = _chebyshev(_NODES).coefficients([self.values(x) for x in r])
        size = max(
            self._mean_slope(np.array([left, (left + right) / 2, right])).min(), abs(float(coefficients[0]))
        )
        if max(abs(float(c)) for c in coefficients[-2:]) <= _SMOOTH * size:
            row = [float(c) for c in _chebyshev(_NODES).monomials(coefficients)]
            return [(left, np.nan if origin is None else origin, centre, stretch, row)]
        if not halvings:
            return None
        middle = (left + right) / 2
        first = self._fitted(left, middle, origin, halvings - 1)
        second = None if first is None else self._fitted(middle, right, origin, halvings - 1)
        return None if first is None or second is None else [*first, *second]


_Panel = tuple[float, float, float, float, list[float]]
"""Left end, origin (NaN without one), centre, stretch, coefficients."""


class MeanSlope:
    """<|g'|> of a profile to a few per cent, the unit in which errors of F are measured.

    Call it with an array of r, and of each parameter.
    """

    _LEVELS, _POINTS = 70, 6  # panels towards x = 0, nodes in each

    def __init__(self, profile: Expr, criterion: Criterion, parameters: Sequence[Expr]) -> None:
        slope = slope_of(profile)
        self._slope = function_of([symbols.v, *parameters], slope, "numpy")
        x, w = np.polynomial.legendre.leggauss(self._POINTS)
        scale = 2.0 ** -np.arange(self._LEVELS)
        self._sensitive: Callable[..., FloatArray] | None = None
        if criterion.weight is None:
            # At one point the rounding of r itself counts.
            self._p, self._w = np.ones(1), np.ones(1)
            self._sensitive = function_of([symbols.v, *parameters], symbols.v * sp.diff(slope, symbols.v), "numpy")
        else:
            self._p = (scale[:, None] * (x + 3) / 2).ravel()
            weight = np.abs(function_of([symbols.s], _from_rest(criterion), "numpy")(self._p))
            self._w = weight * (scale[:, None] * w / 2).ravel()

    def __call__(self, r: FloatArray, *parameters: float | FloatArray) -> FloatArray:
        """Return <|g'|> at each r."""
        columns = [np.asarray(parameter)[..., None] for parameter in parameters]
        x = r[:, None] * self._p
        with np.errstate(all="ignore"):
            slopes = np.broadcast_to(np.abs(self._slope(x, *columns)), x.shape)
            sizes = np.nansum(slopes * self._w, axis=1)
            if self._sensitive is not None:
                sizes = np.fmax(sizes, np.abs(np.broadcast_to(self._sensitive(x, *columns), x.shape))[:, 0])
        return np.asarray(sizes)


def _from_rest(criterion: Criterion) -> Expr:
    """Return w(s) in the symbol s for 1 + s, without the 1."""
    s = symbols.s
    if criterion.is_polynomial:
        return criterion.from_rest.as_expr()
    return 2 / sp.pi * sp.sqrt(s * (2 - s))


class _Chebyshev:
    """Polynomials through values at Chebyshev nodes, in balls."""

    def __init__(self, n: int) -> None:
        angles = [(2 * k + 1) * arb.pi() / (2 * n) for k in range(n)]
        self.nodes = [angle.cos() for angle in angles]
        rows = [[(arb(2) if j else arb(1)) / n * (j * angle).cos() for angle in angles] for j in range(n)]
        self._matrix = arb_mat(rows)
        polynomials = [arb_poly([1]), arb_poly([0, 1])]
        for _ in range(n - 2):
            polynomials.append(arb_poly([0, 2]) * polynomials[-1] - polynomials[-2])
        self._polynomials = polynomials

    def coefficients(self, values: Sequence[arb]) -> list[arb]:
        """Return the coefficients of the Chebyshev sum through values at the nodes."""
        return list((self._matrix * arb_mat([[value] for value in values])).entries())

    def monomials(self, coefficients: Sequence[arb]) -> list[arb]:
        """Return the coefficients of powers of t of a Chebyshev sum, as many."""
        total = arb_poly([0])
        for c, polynomial in zip(coefficients, self._polynomials, strict=False):
            total += c * polynomial
        return [total[k] for k in range(len(coefficients))]


@lru_cache(maxsize=4)
def _chebyshev(n: int) -> _Chebyshev:
    return _Chebyshev(n)


def _shortest(function: Callable[[arb], arb], end: float, most: int) -> tuple[float, ...]:
    """Return the polynomial in z, in as few terms as possible, that equals a function on [0, end] in floats.

    Raises
    ------
    ArithmeticError
        If `most` terms are not enough.
    """
    machine = _chebyshev(_TAIL_NODES)
    values = [function((1 + t) / 2 * arb(end)) for t in machine.nodes]
    if not all(value.is_finite() for value in values):
        raise ArithmeticError("a value is not finite")
    coefficients = machine.coefficients(values)
    least = min(abs(float(value)) for value in values) * _NEGLIGIBLE
    sizes = np.abs([float(c) for c in coefficients])
    rest = np.cumsum(sizes[::-1])[::-1]
    kept = int((rest >= least).sum())
    if kept > most:
        raise ArithmeticError("too many terms")
    kept = max(kept, 2)
    in_t = arb_poly(machine.monomials(coefficients[:kept]))
    in_z = in_t(arb_poly([-1, 2 / arb(end)]))
    return tuple(float(in_z[k]) for k in range(kept))


def _radius(coefficients: Sequence[arb]) -> float:
    count = len(coefficients)
    rate = max(float(abs(c).upper()) ** (1 / k) for k, c in enumerate(coefficients) if k >= 2 * count // 3)
    return 1 / rate if rate else np.inf


def _as_sum(closed: Expr) -> Sum | None:
    """Write a closed form as polynomials in 1/V times functions, times one power of V."""
    V = symbols.V
    groups: dict[Expr, dict[int, Expr]] = {}
    for term in sp.Add.make_args(sp.expand(closed)):
        coefficient, rest = term.as_independent(V, as_Add=False)
        monomials, others = sp.sift(
            sp.Mul.make_args(rest), lambda factor: factor.as_base_exp()[0] == V, binary=True
        )
        function, power = sp.Mul(*others), sp.Mul(*monomials).as_base_exp()[1] if monomials else sp.Integer(0)
        if not power.is_Rational:
            return None
        if not power.is_Integer:
            function, power = function * V ** (power - sp.floor(power)), sp.floor(power)
        group = groups.setdefault(function, {})
        group[int(power)] = group.get(int(power), 0) + coefficient
    highest = max(max(group) for group in groups.values())
    parts = []
    for function, group in sorted(groups.items(), key=lambda item: item[0] != 1):
        coefficients = tuple(float(group.get(k, 0)) for k in range(highest, min(group) - 1, -1))
        parts.append((None if function == 1 else function, coefficients))
    return Sum(float(highest), -1.0, tuple(parts))
