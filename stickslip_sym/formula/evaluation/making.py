"""How the branches of an average are made: once for a profile, from values in ball arithmetic alone.

- A power series for small r, with an exponential taken out where every term of g has it.
- The closed form, from where on a dense comparison with balls says that it does not cancel.
- Polynomials in panels for what lies between.
- A series in 1/r for large r, beside one times log(r) or powers of r, or the leading term beyond all scales.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from itertools import pairwise

import numpy as np
import sympy as sp
from flint import arb, arb_mat, arb_poly, arb_series, fmpq

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, FloatArray
from stickslip_sym.core.balls import rational, working_precision
from stickslip_sym.core.status import Status
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.criteria.enclosure import average_ball
from stickslip_sym.formula.evaluation.branches import Branch, Branches, Sum, Table, value_of
from stickslip_sym.formula.evaluation.values import (
    BITS,
    MeanSlope,
    Unresolved,
    Values,
    mean_power,
    radius_of,
    slope_of,
)
from stickslip_sym.formula.proof.gate import kinks_of
from stickslip_sym.formula.proof.proving import Verdict

__all__ = ["branches_of", "compared"]

_EPSILON = 2.0**-52
_NEGLIGIBLE = 2.0**-57  # of a value: what a series may leave out
_CONDITION = 1.5  # of a series: the sum of its terms' sizes over the size of the sum
_BEGINNING, _BEYOND = 2.75, 3.5  # of eps <|g'|>, by which a formula may differ from balls
_WRITTEN = 16  # of the same, by which what is written as code may differ from the definition
_TERMS = 30  # of a series, at most

_LOW, _HIGH = -30, 60  # binary exponents of r between which a profile is followed
_WHERE = (2.0**_HIGH, 2.0 ** (5 * _HIGH))  # r at which the power of r is measured by which F goes
_FAR = (0, 140, 400)  # binary orders beyond these, where a leading term is read off
_LEADING = 4 * _EPSILON  # by which the leading term may differ from the value at the farthest of them
_POWERS = [k / 2 for k in range(-12, 9)]  # that are tried for it, beside those of the profile
_STEEP = 1e-6  # of a measured power of r, to the next half one

_SERIES_BITS = 300  # for coefficients of power series, before they cancel
_INSIDE = 0.25  # of the radius of convergence, up to which a series is tried
_SERIES_ENDS = 2.0 ** np.arange(-6, 3.01, 0.125)
_FRACTIONAL, _FRACTIONAL_END = 16, 0.125  # powers of v^e, and the r up to which such a series is tried

_FIT_NODES = 31  # of a polynomial that is then written in as few terms as it takes
_TAILS = (3, 4, 5, 6, 7, 9, 11)  # binary exponents of the r from where a series in 1/r is tried
_LARGEST_ROOT = 4  # of r, in which a series is tried too
_PLAIN_TERMS, _OTHER_TERMS = 18, 8  # of the polynomials of a tail, where one of them is times another function

_NODES = 19  # of a panel
_SMOOTH = 0.5 * _EPSILON  # of <|g'|>: the last coefficients of a panel
_BEFORE_THE_END = 2.0**-9  # of the r at which a profile ends: nearer to it balls are asked
_PANELS = 4000  # at most
_HALVINGS = 12  # of a panel that is not smooth
_NEAR_KINK = 1.25  # times r at a kink: up to there the panel's variable is the square root

_CLOSE = 4  # octaves from where a closed form begins, in which it is compared at more points
_COARSE, _FINE = 2, 16  # points in an octave at which a closed form is compared: far out, and where it begins
_MODERATE = 8  # binary exponent of r up to which 8 points are compared
_ELEMENTARY = (sp.exp, sp.log, sp.atan, sp.asinh)  # of which a formula costs less than a polynomial


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
        try:
            return _Builder(profile, criterion, closed, dict(shapes)).build()
        except Unresolved:
            return None


def compared(branches: Branches, profile: Expr, criterion: Criterion, shapes: Mapping[Expr, Expr]) -> Verdict:
    """Compare each branch with an enclosure of the definition at a speed in its range."""
    mean_slope, values = MeanSlope(profile, criterion, list(shapes)), [float(x) for x in shapes.values()]
    compared_at, ends = 0, [*branches.starts[1:], math.inf]
    with working_precision(BITS):
        for start, end in zip(branches.starts, ends, strict=True):
            low = start or (end / 4 if end < math.inf else 1.0)
            r = math.sqrt(low * min(end, 4 * low))
            right = average_ball(profile, shapes, kinks_of(profile, shapes), criterion, arb(r))
            with np.errstate(all="ignore"):
                value = float(branches(r))
            if not right.is_finite() or math.isnan(value):
                continue  # infinite at rest, or beyond the last speed: there is nothing to compare with
            size = max(mean_slope(np.array([r]), *values)[0], abs(float(right)))
            if not abs(float(right - arb(value))) <= _WRITTEN * _EPSILON * size:
                return Verdict(Status.REFUTED, f"{value} at r = {r:g}, and by definition {float(right)}")
            compared_at += 1
    if not compared_at:
        return Verdict(Status.ESTIMATED, "no enclosure of the definition to compare with")
    return Verdict(Status.CHECKED, "each branch agrees with an enclosure of the definition")


class _Builder:
    """Makes the branches of one average; each kind with the r where it begins or ends."""

    def __init__(self, profile: Expr, criterion: Criterion, closed: Expr | None, point: dict[Expr, Expr]) -> None:
        self.profile, self.criterion, self.point = profile, criterion, point
        self.values = Values(profile, criterion, closed, point)
        self.local = criterion.weight is None
        self.closed = closed
        if self.local:
            self.closed = -slope_of(self.values.last_piece).subs(symbols.v, symbols.V).xreplace(point)
        # Each r beyond which a kink counts, as a float, and what it is exactly: a root grows from there.
        self.corners = {float(r): r for r in (kink / (1 if self.local else 2) for kink in self.values.kinks)}
        exponents = {node.exp.xreplace(point) for node in profile.atoms(sp.Pow) if node.base == symbols.v}
        fractional = [e for e in exponents if not e.is_Integer]
        # The e of v^e if v occurs, apart from whole powers, in that way only.
        self.exponent = fractional[0] if len(fractional) == 1 else None
        self.panels = 0

    def build(self) -> Branches | None:
        """Return the branches in order, or None."""
        slope = sp.diff(self.profile, symbols.v)
        if not self.profile.has(symbols.v):
            return Branches((0.0,), (Sum.constant(0.0),))
        if not self.corners and slope.is_polynomial(symbols.v):
            return self._polynomial(sp.degree(slope, symbols.v))
        if self.profile.is_Pow and self.profile.base == symbols.v and self.exponent is not None:
            e = rational(self.exponent)
            value = -arb(e) * mean_power(self.criterion, e - 1)
            return Branches((0.0,), (Sum.constant(float(value), float(self.exponent) - 1),))
        if self.values.reach < np.inf and self.local:
            return Branches((0.0,), (Sum(0.0, 1.0, ((self.closed, (1.0,)),)),))
        outer = self._outer()
        first = (self._series(outer[0][0]) or self._leading(2.0**_LOW, -1)) if outer else None
        if first is None:
            return None
        (opened, branch), closed = first, outer[0][0]
        pairs: list[tuple[float, Branch]] = [(0.0, branch)]
        if opened < closed:
            if (table := self._table(opened, closed)) is None:
                return None
            pairs.append((opened, table))
        starts, branches = zip(*pairs, *((max(start, opened), branch) for start, branch in outer), strict=True)
        return Branches(starts, branches)

    def _polynomial(self, degree: int) -> Branches:
        """Sum the moments; for large r the same polynomial in 1/r."""
        slopes = self.values.taylor(degree + 1)
        assert slopes is not None
        coefficients = [float(-g * mean_power(self.criterion, fmpq(k))) for k, g in enumerate(slopes)]
        low = next(k for k, c in enumerate(coefficients) if c != 0)
        used = coefficients[low:]
        step = 2 if not any(used[1::2]) else 1
        small = Sum(float(low), float(step), ((None, tuple(used[::step])),))
        large = Sum(float(degree), -float(step), ((None, tuple(used[::-1][::step])),))
        return Branches((0.0, 1.0), (small, large)) if len(used) > 1 else Branches((0.0,), (small,))

    def _outer(self) -> list[tuple[float, Branch]]:
        """Return the branches for large r, each with the r where it begins."""
        if self.values.reach < np.inf:
            return [((1 - _BEFORE_THE_END) * self.values.reach / 2, Sum.constant(math.nan))]
        last = self._tail() or self._leading(2.0**_HIGH, 1)
        direct = self._direct(last[0] if last else 2.0**_HIGH)
        return [pair for pair in (direct, last) if pair is not None]

    # -- small r ---------------------------------------------------------------------------------

    def _series(self, closed: float) -> tuple[float, Branch] | None:
        """Expand F around r = 0, at most up to where other branches begin; return where that ends, and it."""
        decay = self._decay()
        with working_precision(_SERIES_BITS, 2 * _TERMS):
            slopes = self.values.taylor(2 * _TERMS)
            if slopes is None:
                return self._fractional_series(closed)
            means = [-c * mean_power(self.criterion, fmpq(k)) for k, c in enumerate(slopes)]
            series = arb_series(means, prec=2 * _TERMS) * arb_series([0, arb(decay)], prec=2 * _TERMS).exp()
            coefficients = [series[k] for k in range(2 * _TERMS)]
        function = sp.exp(-sp.Float(decay) * symbols.V) if decay else None
        return self._short_series(coefficients, 0.0, 1.0, function, min(closed, _INSIDE * self.values.radius))

    def _decay(self) -> float:
        """Return the rate k if every term of g' has a factor exp(-k v), else 0."""
        rates = set()
        for term in sp.Add.make_args(sp.expand(sp.diff(self.profile, symbols.v))):
            exponents = [factor.args[0] for factor in sp.Mul.make_args(term) if isinstance(factor, sp.exp)]
            rate = -sp.Add(*exponents).coeff(symbols.v)
            rates.add(float(rate) if rate.is_number and rate.is_positive else 0.0)
        return min(rates)

    def _short_series(
        self, coefficients: list[arb], power: float, step: float, function: Expr | None, end: float
    ) -> tuple[float, Branch] | None:
        """Return f(r) r^p sum_k c_k r^(q k) in as few terms as it takes, and the r up to which it is good."""
        # What may be 0 is: the balls are small beside every coefficient that matters.
        coefficients = [arb(0) if c.contains(0) else c for c in coefficients]
        low = next((k for k, c in enumerate(coefficients) if c != 0), None)
        if low is None:
            return None
        used, end = coefficients[low:], min([end, *self.corners])
        z = _SERIES_ENDS[2 ** (1 / 8) * end >= _SERIES_ENDS] ** step
        parts = np.array([float(c) for c in used]) * z[:, None] ** np.arange(len(used))
        total, sizes = np.abs(parts.sum(axis=1)), np.abs(parts)
        good = sizes.sum(axis=1) <= _CONDITION * total
        good &= sizes[:, _TERMS:].sum(axis=1) <= _NEGLIGIBLE * total
        count = z.size if good.all() else int(good.argmin())
        if count == 0:
            return None
        stride = 2 if step == 1 and not any(used[1::2]) else 1
        short = _shortest(arb_poly(used[::stride]), float(z[count - 1]) ** stride, _TERMS)
        branch = Sum(power + low * step, step * stride, ((function, short),))
        return min([float(_SERIES_ENDS[count - 1]), *self.corners]), branch

    def _fractional_series(self, closed: float) -> tuple[float, Branch] | None:
        """The same for a profile with one power v^e that is not whole."""
        rows = (
            None if self.exponent is None
            else self.values.taylor_in_powers(self.exponent, _FRACTIONAL, 2 * _TERMS)
        )  # fmt: skip
        if rows is None:
            return None
        e = rational(self.exponent)
        means = [
            [-c * (k * e + j) * mean_power(self.criterion, k * e + j - 1) if k or j else arb(0)
             for j, c in enumerate(row)]
            for k, row in enumerate(rows)
        ]  # fmt: skip
        if len(means[0]) == 1:
            coefficients = [row[0] for row in means]
            end = min(closed, _INSIDE * radius_of(coefficients) ** (1 / float(e)))
            return self._short_series(coefficients[1:], float(e) - 1, float(e), None, end)
        end = min(_FRACTIONAL_END, *(_INSIDE * radius_of(row) for row in means))
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

    # -- large r ---------------------------------------------------------------------------------

    def _tail(self) -> tuple[float, Branch] | None:
        """Fit F for large r by a power of r times polynomials."""
        # Two powers that are close part from each other farther out.
        power = next((p for r in _WHERE if (p := self._power(r)) is not None), None)
        if power is None:
            leading = self._leading(2.0**_HIGH, 1)
            return self._mixed_tail(leading[1].power) if leading and len(leading[1].parts) > 1 else None
        return self._plain_tail(power) or self._mixed_tail(power)

    def _starts(self) -> list[float]:
        return [2.0**exponent * max([1.0, *self.corners]) for exponent in _TAILS]

    def _plain_tail(self, power: float) -> tuple[float, Branch] | None:
        """Fit r^-power F for large r by a polynomial in 1/r, or in one of its roots."""
        exponents = {node.exp.xreplace(self.point) for node in self.profile.atoms(sp.Pow)}
        roots = {int(e.q) for e in exponents if e.is_Rational and 2 < e.q <= _LARGEST_ROOT}
        for root in (1, 2, *sorted(roots)):
            for near in self._starts() if root == 1 else self._starts()[2::2]:
                start = near ** max(1.0, root / 2)

                def scaled(z: arb, root: int = root) -> arb:
                    return self.values(z**-root) * z ** arb(root * power)

                try:
                    coefficients = _shortest(scaled, start ** (-1 / root), _FIT_NODES - 5)
                except ArithmeticError:
                    continue
                sizes = np.abs(coefficients) * start ** (-np.arange(len(coefficients)) / root)
                if sizes.sum() <= _CONDITION * abs(np.dot(np.sign(coefficients), sizes)):
                    return start, Sum(power, -1 / root, ((None, coefficients),))
        return None

    def _mixed_tail(self, power: float) -> tuple[float, Branch] | None:
        """Fit r^-power F by two polynomials in 1/r or its root, one times log(r), through values at nodes."""
        counts = ((None, _PLAIN_TERMS), (sp.log(symbols.V), _OTHER_TERMS))
        nodes = [(1 + t) / 2 for t in _chebyshev(_PLAIN_TERMS + _OTHER_TERMS).nodes]  # of (start/r)^(1/root)
        for root, start in [*((1, start) for start in self._starts()[:5]), *((2, r) for r in self._starts()[5:])]:
            speeds = [arb(start) / x**root for x in nodes]
            rows = [
                [factor * x**k for f, count in counts for factor in [arb(1) if f is None else r.log()]
                 for k in range(count)]
                for x, r in zip(nodes, speeds, strict=True)
            ]  # fmt: skip
            values = [[self.values(r) * r ** arb(-power)] for r in speeds]
            try:
                solution = iter(arb_mat(rows).solve(arb_mat(values)).entries())
            except (ZeroDivisionError, ValueError):
                continue
            branch = Sum(
                power,
                -1.0 / root,
                tuple(
                    (f, tuple(float(next(solution)) * start ** (k / root) for k in range(count)))
                    for f, count in counts
                ),
            )
            octaves = np.concatenate([np.arange(0, 4, 1 / 3), np.arange(4, _HIGH - np.log2(start), 4)])
            if self._agreed(branch, start * 2.0**octaves, _BEYOND) == start:
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
        if self.exponent is None:
            return _POWERS
        return [*_POWERS, *(sign * float(self.exponent) - n for sign in (1, -1) for n in (1, 2))]

    def _leading(self, place: float, side: int) -> tuple[float, Sum] | None:
        """Return a place, and the leading term beyond it, at smaller r or at larger ones."""
        r = [arb(place * 2.0 ** (side * order)) for order in _FAR]
        values = [self.values(x) for x in r]
        if all(value == 0 for value in values):
            return place, Sum.constant(0.0)
        if not all(value.is_finite() and not value.contains(0) for value in values):
            return None
        logs = [x.log() for x in r]
        for power in self._powers():
            y = [value * x ** arb(-power) for value, x in zip(values, r, strict=True)]
            slope = (y[1] - y[0]) / (logs[1] - logs[0])
            constant = y[0] - slope * logs[0]
            if bool(abs(constant + slope * logs[2] - y[2]) <= _LEADING * abs(y[2])):
                if bool(abs(slope * logs[2]) < _LEADING * abs(y[2])):
                    return place, Sum.constant(float(y[0]), power)
                parts = ((None, (float(constant),)), (sp.log(symbols.V), (float(slope),)))
                return place, Sum(power, 1.0, parts)
        return None

    # -- what lies between -----------------------------------------------------------------------

    def _direct(self, stop: float) -> tuple[float, Branch] | None:
        """Take the closed form, from where on it agrees with balls; None if it does nowhere below `stop`."""
        if not self.closed or ((self.point or self.corners) and not self.local) or self.closed.has(sp.I):
            return None
        if not self.local and not all(isinstance(f, _ELEMENTARY) for f in self.closed.atoms(sp.Function)):
            return None
        branch = _as_sum(self.closed)
        if branch is None:
            return None
        top, moderate = np.log2(stop), min(float(_MODERATE), np.log2(stop))
        octaves = np.concatenate([np.arange(-4, moderate, 1 / 8), np.arange(moderate, top, 1 / _COARSE)])
        start = self._agreed(branch, 2.0**octaves, _BEYOND)
        if start is None:
            return None
        begin = np.log2(start)
        start = self._agreed(branch, 2.0 ** np.arange(begin, min(begin + _CLOSE, top), 1 / _FINE), _BEGINNING)
        return None if start is None or start >= stop else (start, branch)

    def _agreed(self, branch: Sum, r: FloatArray, units: float) -> float | None:
        """Return the least of some r, ascending, from where on a branch agrees with balls; None if nowhere."""
        with np.errstate(all="ignore"):
            values = np.asarray(value_of(branch, r))
        sizes = self.values.mean_slope(r)
        start = None
        for x, value, size in zip(r[::-1], values[::-1], sizes[::-1], strict=True):
            if not abs(float(self.values(arb(float(x))) - arb(float(value)))) <= units * _EPSILON * size:
                break
            start = float(x)
        return start

    def _table(self, start: float, stop: float) -> Table | None:
        """Fit F by a polynomial in each of some panels, as many as it takes; None where that is too many."""
        halves = np.arange(np.floor(2 * np.log2(start)), np.ceil(2 * np.log2(stop)) + 1) / 2
        inside = [*2.0**halves, *self.corners, *(_NEAR_KINK * corner for corner in self.corners)]
        edges = [start, *sorted({float(x) for x in inside if start < x < stop}), stop]
        rows: list[list[float]] = []
        for left, right in pairwise(edges):
            rooted = left in self.corners and not self.criterion.is_polynomial
            if not self._fit(rows, left, right, left if rooted else None, _HALVINGS):
                return None
        return Table(np.array(rows))

    def _fit(
        self, rows: list[list[float]], left: float, right: float, origin: float | None, halvings: int
    ) -> bool:
        """Add the panel between two r, or its halves where one polynomial is not enough; say whether that did."""
        self.panels += 1
        low, high = (left, right) if origin is None else (np.sqrt(left - origin), np.sqrt(right - origin))
        centre, half = (low + high) / 2, (high - low) / 2
        y = [arb(centre) + t * arb(half) for t in _chebyshev(_NODES).nodes]
        values = [self.values(x if origin is None else self.corners[origin] + x * x) for x in y]
        coefficients = _chebyshev(_NODES).coefficients(values)
        middle = (left + right) / 2
        size = max(self.values.mean_slope(np.array([left, middle, right])).min(), abs(float(coefficients[0])))
        if max(abs(float(c)) for c in coefficients[-2:]) <= _SMOOTH * size:
            powers = _chebyshev(_NODES).monomials(coefficients)(arb_poly([0, 1 / arb(half)]))
            row = [float(powers[k]) for k in range(_NODES)]
            rows.append([left, math.nan if origin is None else origin, centre, *row])
            return True
        return halvings > 0 and self.panels < _PANELS and all(
            self._fit(rows, *part, origin, halvings - 1) for part in ((left, middle), (middle, right))
        )  # fmt: skip


class _Chebyshev:
    """Polynomials through values at Chebyshev nodes, in balls."""

    def __init__(self, n: int) -> None:
        angles = [(2 * k + 1) * arb.pi() / (2 * n) for k in range(n)]
        self.nodes = [angle.cos() for angle in angles]
        rows = [[(arb(2) if j else arb(1)) / n * (j * angle).cos() for angle in angles] for j in range(n)]
        self._matrix = arb_mat(rows)
        self._polynomials = [arb_poly([1]), arb_poly([0, 1])]
        for _ in range(n - 2):
            self._polynomials.append(arb_poly([0, 2]) * self._polynomials[-1] - self._polynomials[-2])

    def coefficients(self, values: Sequence[arb]) -> list[arb]:
        """Return the coefficients of the Chebyshev sum through values at the nodes."""
        return list((self._matrix * arb_mat([[value] for value in values])).entries())

    def monomials(self, coefficients: Sequence[arb]) -> arb_poly:
        """Return a Chebyshev sum in powers of t."""
        pairs = zip(coefficients, self._polynomials, strict=False)
        return sum((c * polynomial for c, polynomial in pairs), arb_poly([0]))


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
    machine = _chebyshev(_FIT_NODES)
    values = [function((1 + t) / 2 * arb(end)) for t in machine.nodes]
    if not all(value.is_finite() for value in values):
        raise ArithmeticError("a value is not finite")
    coefficients = machine.coefficients(values)
    least = min(abs(float(value)) for value in values) * _NEGLIGIBLE
    rest = np.cumsum([abs(float(c)) for c in coefficients[::-1]])[::-1]
    kept = max(int((rest >= least).sum()), 2)
    if kept > most:
        raise ArithmeticError("too many terms")
    in_z = machine.monomials(coefficients[:kept])(arb_poly([-1, 2 / arb(end)]))
    return tuple(float(in_z[k]) for k in range(kept))


def _as_sum(closed: Expr) -> Sum | None:
    """Write a closed form as polynomials in 1/V times functions, times one power of V."""
    V = symbols.V
    groups: dict[Expr, dict[int, Expr]] = {}
    for term in sp.Add.make_args(sp.expand(closed)):
        coefficient, rest = term.as_independent(V, as_Add=False)
        power, function = sp.Integer(0), rest
        for factor in sp.Mul.make_args(rest):
            base, exponent = factor.as_base_exp()
            if base == V:
                power, function = power + exponent, function / factor
        if not power.is_Rational:
            return None
        whole = sp.floor(power)
        group = groups.setdefault(function * V ** (power - whole), {})
        group[int(whole)] = group.get(int(whole), 0) + coefficient
    highest = max(max(group) for group in groups.values())
    parts = []
    for function, group in sorted(groups.items(), key=lambda item: item[0] != 1):
        coefficients = tuple(float(group.get(k, 0)) for k in range(highest, min(group) - 1, -1))
        parts.append((None if function == 1 else function, coefficients))
    return Sum(float(highest), -1.0, tuple(parts))
