"""How the branches of an average are made: once for a profile, from values in ball arithmetic alone.

- For small and for large r a power of r times a polynomial in r or 1/r, or in a root of it; for small r with an
  exponential taken out, and where it has to be beside others times log(r) or powers of r.
- The closed form, from where on a dense comparison with balls says that it does not cancel.
- Polynomials in panels for what lies between.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from itertools import pairwise

import numpy as np
import sympy as sp
from flint import acb, arb, arb_mat, arb_poly

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, FloatArray
from stickslip_sym.core.balls import ball_value, rational
from stickslip_sym.core.functions import elementary, row
from stickslip_sym.core.precision import working_precision
from stickslip_sym.core.status import Status
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.criteria.enclosure import average_ball
from stickslip_sym.formula.evaluation.branches import Branch, Branches, Sum, Table, value_of
from stickslip_sym.formula.evaluation.interpolation import chebyshev
from stickslip_sym.formula.evaluation.values import BITS, MeanSlope, Unresolved, Values, slope_of
from stickslip_sym.formula.proof.proving import Verdict

_EPSILON = 2.0**-52
_NEGLIGIBLE = 2.0**-57  # of a value: what a polynomial may leave out
_CONDITION = 1.5  # of a polynomial: the sum of its terms' sizes over the size of the sum
_UNITS = 2.75  # of eps <|g'|>, by which a formula may differ from balls
_WRITTEN = 16  # of the same, by which what is written as code may differ from the definition

_HIGH = 60  # binary exponent of r up to which a profile is followed
_WHERE = (60, 120, 300)  # binary exponents at which the power of r is read off by which F goes
_POWERS = [sp.Rational(k, 2) for k in range(-12, 17)]  # that are tried for it, beside those of the profile
_STRAIGHT, _LEVEL = 1e-6, 1e-4  # F over the right power of r is linear in log(r); with no slope it is constant
_ENDS = {1: (11, 9, 7, 6, 5, 4, 3), -1: (-9, -6, -4, -3, -2, -1, 0, 1, 2, 3)}
"""Binary exponents of the r from where, or up to where, one polynomial is tried."""
_FIT_NODES, _TERMS = 27, 23  # of a polynomial that is then written in as few terms as it takes
_LARGEST_ROOT = 4  # of r, in which a polynomial is tried too

_NODES = 19  # of a panel
_SMOOTH = 0.5 * _EPSILON  # of <|g'|>: the last coefficients of a panel
_PANELS = 4000  # at most
_HALVINGS = 12  # of a panel that is not smooth
_NEAR_KINK = 1.25  # times r at a kink: up to there the panel's variable is the square root

_POINTS = 16  # in an octave, at which a closed form is compared; from 2^_MODERATE on 2
_MODERATE = 8


@lru_cache(maxsize=256)
def branches_of(
    profile: Expr, criterion: Criterion, closed: Expr | None = None, shapes: tuple[tuple[Expr, Expr], ...] = ()
) -> Branches | None:
    """Return the branches of F for a profile g(v) at values of all its shapes; None if there are none.

    `closed` is F as a formula in V and the shapes.
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
            right = average_ball(profile, shapes, criterion, arb(r))
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


_Fit = Callable[[float], tuple[float, Branch] | None]
"""From an r up to or from where a branch is tried to that r and the branch; None where it does not hold."""

_Terms = tuple[tuple[Expr | None, int], ...]
"""Functions, None for 1, and the number of terms of the polynomial that stands before each."""


class _Builder:
    """Makes the branches of one average: both ends first, then the closed form, then a table of what is left."""

    def __init__(self, profile: Expr, criterion: Criterion, closed: Expr | None, point: dict[Expr, Expr]) -> None:
        self.profile, self.criterion, self.point = profile, criterion, point
        self.values = Values(profile, criterion, closed, point)
        self.local = criterion.weight is None
        self.closed = None if point else closed
        if self.local:
            self.closed = -elementary(slope_of(self.values.last_piece)).subs(symbols.v, symbols.V).xreplace(point)
        # Each r beyond which a kink counts, as a float, and what it is exactly: a root grows from there.
        self.corners = {float(r): r for r in (kink / (1 if self.local else 2) for kink in self.values.kinks)}
        powers = [node for node in profile.atoms(sp.Pow) if node.base.has(symbols.v)]
        exponents = {node.exp.xreplace(point) for node in powers}
        self.roots = sorted({int(e.q) for e in exponents if e.is_Rational and 2 < e.q <= _LARGEST_ROOT})
        # The e of v^e if v occurs, apart from whole powers, in that way only.
        fractional = [
            e for e in {node.exp.xreplace(point) for node in powers if node.base == symbols.v} if not e.is_Integer
        ]
        self.exponent = fractional[0] if len(fractional) == 1 else None
        self.panels = 0

    def build(self) -> Branches | None:
        """Return the branches in order, or None."""
        if (whole := self._powers_alone()) is not None:
            return whole
        reach = self.values.reach
        if reach < math.inf and self.local:
            return Branches((0.0,), (Sum(0.0, 1.0, ((self.closed, (1.0,)),)),))
        last = (
            (self.values.end / 2, Sum(0.0, 1.0, ((None, (math.nan,)),))) if reach < math.inf else self._end(1, 0.0)
        )
        direct = self._direct(last[0] if last else 2.0**_HIGH) if reach == math.inf else None
        outer = [pair for pair in (direct, last) if pair is not None]
        first = self._end(-1, outer[0][0]) if outer else None
        if first is None:
            return None
        (opened, branch), stop = first, outer[0][0]
        pairs: list[tuple[float, Branch]] = [(0.0, branch)]
        if opened < stop:
            if (table := self._table(opened, stop)) is None:
                return None
            pairs.append((opened, table))
        starts, branches = zip(*pairs, *outer, strict=True)
        return Branches(starts, branches)

    def _powers_alone(self) -> Branches | None:
        """Return the average of a sum of whole powers of v, or of one power, by the moments of the weight."""
        if self.values.kinks:
            return None
        terms: dict[Expr, float] = {}
        for term in sp.Add.make_args(sp.expand(slope_of(self.profile))):
            coefficient, power = term.as_independent(symbols.v, as_Add=False)
            base, exponent = power.as_base_exp()
            if base not in (1, symbols.v):
                return None
            exponent = (exponent if base == symbols.v else sp.S.Zero).xreplace(self.point)
            terms[exponent] = float(-coefficient.xreplace(self.point) * self.criterion.mean_power(exponent))
        low, high = min(terms), max(terms)
        if low == high:
            return Branches((0.0,), (_sum(low, sp.S.One, ((None, (terms[low],)),)),))
        if not all(exponent.is_Integer for exponent in terms):
            return None
        step = math.gcd(*(int(e - low) for e in terms))
        used = tuple(terms.get(e, 0.0) for e in range(low, high + 1, step))
        small, large = _sum(low, step, ((None, used),)), _sum(high, -step, ((None, used[::-1]),))
        return Branches((0.0, 1.0), (small, large))

    # -- the ends ----------------------------------------------------------------------------------

    def _end(self, side: int, stop: float) -> tuple[float, Branch] | None:
        """Fit F for all small r, side -1, or for all large ones; return up to or from where, and the branch.

        It is a power of r times a polynomial in r or 1/r, or in a root of it, or several such beside each other.
        """
        asymptote = self._asymptote(side)
        if asymptote is None:
            return None
        power, logarithm = asymptote
        steps = [sp.Rational(1, root) for root in (1, 2, *self.roots)]
        fits: list[tuple[Expr, _Fit]] = [
            (step, partial(self._mixed, side, power, step, parts))
            for step in steps[:2]
            for parts in self._mixtures(side, power, logarithm)
        ]
        if not logarithm:
            steps += [self.exponent] if side < 0 and self.exponent is not None else []
            plain = [(step, function) for step in steps for function in self._decays(side)]
            fits = [(step, partial(self._plain, side, power, step, f)) for step, f in plain] + fits
        bound = min if side < 0 else max
        corner, edge = bound([1.0, *self.corners]), bound([stop, *self.corners])
        for step, fit in fits:
            ends = [corner * 2.0 ** (exponent * max(1.0, 0.5 / float(step))) for exponent in _ENDS[side]]
            if (pair := _farthest([bound(end, edge) for end in ends], fit)) is not None:
                return pair
        return None

    def _asymptote(self, side: int) -> tuple[Expr, bool] | None:
        """Return the power of r by which F goes at an end, and whether it is times log(r) too."""
        powers = _POWERS
        if self.exponent is not None:
            powers = [*_POWERS, *(sign * self.exponent - n for sign in (1, -1) for n in (1, 2))]
        for exponent in _WHERE:
            r = [arb(2) ** (side * exponent + k) for k in (0, 1, 2)]
            values = [self.values(x) for x in r]
            if all(value == 0 for value in values):
                return sp.S.Zero, False
            if any(value.contains(0) or not value.is_finite() for value in values):
                continue
            for power in powers:
                y = [value * x ** -arb(rational(power)) for value, x in zip(values, r, strict=True)]
                rises = [float((b - a) / y[0]) for a, b in pairwise(y)]
                if abs(rises[1] - rises[0]) < _STRAIGHT:
                    return power, abs(rises[0]) > _LEVEL
        return None

    def _decays(self, side: int) -> list[Expr | None]:
        """Return what may stand before a polynomial for small r: an exponential, or nothing."""
        rates = [
            -node.exp.coeff(symbols.v) for node in self.profile.atoms(sp.exp) if node.exp.is_polynomial(symbols.v)
        ]
        rates = [float(rate) for rate in rates if rate.is_number and rate.is_positive]
        return [sp.exp(-sp.Float(min(rates)) * symbols.V), None] if side < 0 and rates else [None]

    def _plain(
        self, side: int, power: Expr, step: Expr, function: Expr | None, end: float
    ) -> tuple[float, Branch] | None:
        """Fit F by r^power f(r) P(z), z = r^step or r^-step, up to or from where r is `end`."""
        exponent, last = -side * step, arb(end) ** arb(rational(-side * step))

        def scaled(z: arb) -> arb:
            r = z ** arb(rational(1 / exponent))
            before = r ** arb(rational(power))
            return self.values(r) / (before if function is None else before * _at(function, r))

        coefficients = _shortest(scaled, last)
        if coefficients is None:
            return None
        sizes = np.abs(coefficients) * float(last) ** np.arange(len(coefficients))
        if not sizes.sum() <= _CONDITION * abs(np.dot(np.sign(coefficients), sizes)):
            return None
        stride = 2 if (sizes[1::2] <= _NEGLIGIBLE**2 * sizes.max()).all() else 1
        parts = ((function, tuple(coefficients[::stride])),)
        return end, _sum(power, exponent * stride, parts)

    def _mixtures(self, side: int, power: Expr, logarithm: bool) -> Sequence[_Terms]:
        """Return functions that may stand beside each other, and the number of terms of their polynomials."""
        V, e = symbols.V, self.exponent
        beside_logarithm: list[_Terms] = [((None, 18), (sp.log(V), 8))]
        if e is None or logarithm:
            return beside_logarithm
        if side < 0:
            return [*beside_logarithm, ((None, 10), (V**e, 7), (V ** (2 * e), 5), (V ** (3 * e), 4))]
        # Far out there are powers of the slope there, and of the weight near v = 0.
        offsets = {(other - power) % 1 for other in (e - 1, -e - 1, -1 - self.criterion.order_at_rest)} - {0}
        return [*beside_logarithm, *(((None, 13), (V ** (offset - 1), 13)) for offset in offsets)]

    def _mixed(self, side: int, power: Expr, step: Expr, terms: _Terms, end: float) -> tuple[float, Branch] | None:
        """Fit F by r^power times a sum of functions times polynomials, through values at nodes."""
        exponent, last = -side * step, arb(end) ** arb(rational(-side * step))
        nodes = [(1 + t) / 2 for t in chebyshev(sum(count for _, count in terms)).nodes]  # of z over the last one
        speeds = [(x * last) ** arb(rational(1 / exponent)) for x in nodes]
        rows = [
            [factor * x**k for f, count in terms for factor in [_at(f, r)] for k in range(count)]
            for x, r in zip(nodes, speeds, strict=True)
        ]
        values = [[self.values(r) * r ** -arb(rational(power))] for r in speeds]
        try:
            solution = iter(arb_mat(rows).solve(arb_mat(values)).entries())
        except (ZeroDivisionError, ValueError):
            return None
        parts = tuple((f, tuple(float(next(solution) / last**k) for k in range(count))) for f, count in terms)
        branch = _sum(power, exponent, parts)
        # At the last nodes it is not as good as beyond them.
        octaves = np.concatenate([np.arange(2, 6, 1 / 3), np.arange(6, _HIGH, 4)])
        r = end * 2.0 ** (side * octaves)
        return (float(r[0]), branch) if self._agreed(branch, r) == r.size else None

    # -- what lies between -------------------------------------------------------------------------

    def _direct(self, stop: float) -> tuple[float, Branch] | None:
        """Take the closed form, from where on it agrees with balls; None if it does nowhere below `stop`."""
        if not self.closed or self.closed.has(sp.I):
            return None
        if not self.local and not all(_is_fast(function) for function in self.closed.atoms(sp.Function)):
            return None
        branch = _as_sum(self.closed)
        if branch is None:
            return None
        octaves = np.arange(-4, np.log2(stop), 1 / _POINTS)
        r = 2.0 ** octaves[(octaves < _MODERATE) | (octaves % 0.5 == 0)][::-1]
        count = self._agreed(branch, r)
        return (float(r[count - 1]), branch) if count else None

    def _agreed(self, branch: Sum, r: FloatArray) -> int:
        """Return at how many of some r, from the first on, a branch agrees with balls."""
        with np.errstate(all="ignore"):
            values = np.asarray(value_of(branch, r))
        allowed = _UNITS * _EPSILON * self.values.mean_slope(r)
        for i, (x, value, most) in enumerate(zip(r, values, allowed, strict=True)):
            if not abs(float(self.values(arb(float(x))) - arb(float(value)))) <= most:
                return i
        return r.size

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
        y = [arb(centre) + t * arb(half) for t in chebyshev(_NODES).nodes]
        values = [self.values(x if origin is None else self.corners[origin] + x * x) for x in y]
        coefficients = chebyshev(_NODES).coefficients(values)
        middle = (left + right) / 2 if origin is None else float(origin + centre**2)
        size = max(self.values.mean_slope(np.array([left, middle, right])).min(), abs(float(coefficients[0])))
        if max(abs(float(c)) for c in coefficients[-2:]) <= _SMOOTH * size:
            powers = chebyshev(_NODES).monomials(coefficients)(arb_poly([0, 1 / arb(half)]))
            row = [float(powers[k]) for k in range(_NODES)]
            rows.append([left, math.nan if origin is None else origin, centre, *row])
            return True
        return halvings > 0 and self.panels < _PANELS and all(
            self._fit(rows, *part, origin, halvings - 1) for part in ((left, middle), (middle, right))
        )  # fmt: skip


def _is_fast(function: Expr) -> bool:
    known = row(function)
    return known is not None and (known.python or "").startswith("np.")


def _sum(power: Expr, variable: Expr, parts: Sequence[tuple[Expr | None, tuple[float, ...]]]) -> Sum:
    """Return a branch with its power as a float: far from r = 1 a factor restores what rounding took from it."""
    if rest := float(power - sp.Rational(float(power))):
        factor = 1 + rest * sp.log(symbols.V)
        parts = [(factor if f is None else factor * f, coefficients) for f, coefficients in parts]
    return Sum(float(power), float(variable), tuple(parts))


def _at(function: Expr | None, r: arb) -> arb:
    return arb(1) if function is None else ball_value(function, {symbols.V: acb(r)}).real


def _farthest(ends: Sequence[float], fit: _Fit) -> tuple[float, Branch] | None:
    """Return the last of some fits that holds, by bisection; None where the first one does not."""
    best, high = fit(ends[0]), len(ends)
    low = 0
    while best is not None and high - low > 1:
        middle = (low + high) // 2
        if (pair := fit(ends[middle])) is None:
            high = middle
        else:
            best, low = pair, middle
    return best


def _shortest(function: Callable[[arb], arb], end: arb) -> list[float] | None:
    """Return the polynomial in z, in as few terms as possible, that equals a function on [0, end] in floats."""
    machine = chebyshev(_FIT_NODES)
    values = [function((1 + t) / 2 * end) for t in machine.nodes]
    if not all(value.is_finite() for value in values):
        return None
    coefficients = machine.coefficients(values)
    least = min(abs(float(value)) for value in values) * _NEGLIGIBLE
    rest = np.cumsum([abs(float(c)) for c in coefficients[::-1]])[::-1]
    kept = max(int((rest >= least).sum()), 1)
    if kept > _TERMS:
        return None
    in_z = machine.monomials(coefficients[:kept])(arb_poly([-1, 2 / end]))
    return [float(in_z[k]) for k in range(kept)]


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
