"""How the branches of an average are made: once for a profile, from its structure and values in ball arithmetic.

- Near rest and far out the generalised power series of `generalised_series`, as polynomials; near rest with an
  exponential taken out where they reach further so.
- The closed form, from where on a dense comparison with balls says that it does not cancel.
- Polynomials in panels for what lies between.

Each is compared with balls at its ends and between them before it is used.
"""

import math
from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache, reduce
from itertools import pairwise

import numpy as np
import sympy as sp
from flint import acb, arb
from sympy.printing.numpy import NumPyPrinter

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, FloatArray, Substitution
from stickslip_sym.core.balls import ball
from stickslip_sym.core.errors import NotConverged
from stickslip_sym.core.functions import elementary
from stickslip_sym.core.numbers import EPSILON, LARGEST, NEGLIGIBLE, binary_fraction
from stickslip_sym.core.precision import refined, working_precision
from stickslip_sym.core.status import Status
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.criteria.decay import decay_at_rest
from stickslip_sym.criteria.enclosure import average_enclosure
from stickslip_sym.formula.evaluation.branches import Branch, Branches, PanelTable, Sum, value_of
from stickslip_sym.formula.evaluation.generalised_series import (
    GeneralisedSeries,
    Powers,
    average_near_rest,
    common_denominator,
    expanded,
    far_out,
)
from stickslip_sym.formula.evaluation.reference_average import (
    ALLOWED_IN_CODE,
    BITS,
    OCTAVES_BEYOND_SCALES,
    SMALLEST,
    MeanSlope,
    ReferenceAverage,
    scales_of,
    stable_slope_of,
)
from stickslip_sym.formula.proof.proving import Verdict
from stickslip_sym.model.expression.pieces import branch_from, kinks_at
from stickslip_sym.model.formula_algebra import NotAnalytic
from stickslip_sym.numerics.chebyshev import ball_grid
from stickslip_sym.numerics.known import Unknown, attempted
from stickslip_sym.numerics.subdivide import (
    HALVE,
    MOST_INTERVALS,
    Accept,
    Decision,
    DivisionLimits,
    Interval,
    WorkBudget,
    middle,
    subdivide,
)

# What each is worth, in seconds, panels and digits, `tests/benchmarks/measure_branches.py` prints.
_CONDITION = {-1: 1.5, 1: 4.0}
"""Of a series at rest, and far out: the sum of its terms' sizes over the size of the sum, before balls decide."""
_ALLOWED_UNITS = 2.75  # of eps <|g'|>, by which a formula may differ from balls

_WAVING = 5  # octaves beyond all scales, up to which a profile that waves for ever has a table
_MOST_DEFINITION_BITS = 5 * BITS  # for an enclosure of the definition: mu cancels by 2 bits an octave at rest
_OCTAVES = (0.0, *(0.4 * 1.6**k for k in range(9)))
"""From the end of a series, at which it is compared with balls: the farther, the fewer terms are left."""

_BRANCH_NODES = 19  # of a panel; in an octave as many at which a closed form is compared
_SMOOTH = 0.5 * EPSILON  # of <|g'|>: the last coefficients of a panel
_AT_KINK = 4 * EPSILON  # relative: what products of a belt speed and powers of parameters are rounded by


@lru_cache
def branches_of(
    profile: Expr, criterion: Criterion, closed: Expr | None = None, shapes: tuple[tuple[Expr, Expr], ...] = ()
) -> Branches | Unknown:
    """Return the branches of F for a profile g(v) at values of all its shapes, or why there are none.

    `closed` is F as a formula in V and the shapes.
    """

    def made() -> Branches | Unknown:
        return _Builder(profile, criterion, closed, dict(shapes)).build()

    with working_precision(BITS):
        return attempted(made)


def compared(branches: Branches, profile: Expr, criterion: Criterion, shapes: Substitution) -> Verdict:
    """Compare each branch with enclosures of the definition: at its ends, between them, and far beyond."""
    mean_slope = MeanSlope(profile, criterion, shapes)
    values = [float(x) for x in shapes.values()]
    count = 0
    decay = decay_at_rest(branch_from(profile, shapes, sp.S.Zero), shapes)
    local = criterion.weight is None
    kinks = kinks_at(profile, shapes)

    def by_definition(r: arb, kink: Expr | None = None) -> arb:
        return refined(
            lambda: average_enclosure(profile, shapes, criterion, r, kink), BITS // 2, _MOST_DEFINITION_BITS
        )

    for r in _looked_at(branches):
        with np.errstate(all="ignore"):
            value = float(branches(r))
        size = max(mean_slope(np.array([r]), *values)[0], abs(value))
        if math.isnan(value):
            continue  # beyond the last speed
        kink = next((kink for kink in kinks if _is_at(r, float(kink) / (1 if local else 2))), None)
        if kink is None:
            sides = [by_definition(arb(r))]
        elif local:
            sides = [by_definition(ball(kink).real, kink)]
        else:  # where a jump of mu joins the average, by which rounding says on which side of it a speed is
            sides = [by_definition(arb(r) * (1 + arb(shift))) for shift in (-_AT_KINK, _AT_KINK)]
        size *= 1 if decay is None else 1 + decay.steepness(2 * r)
        if not all(side.is_finite() and float(side.rad()) <= EPSILON * size for side in sides):
            continue  # infinite at rest, or not enclosed: there is nothing to compare with
        exact = reduce(arb.union, sides)
        if not float((exact - arb(value)).abs_lower()) <= ALLOWED_IN_CODE * EPSILON * size + SMALLEST:
            return Verdict(Status.REFUTED, f"{value} at r = {r:g}, and by definition {float(exact)}")
        count += 1
    if not count:
        return Verdict(Status.ESTIMATED, "no enclosure of the definition to compare with")
    return Verdict(
        Status.CHECKED,
        f"each branch agrees with enclosures of the definition, at its ends and between: {count} speeds",
    )


def _is_at(r: float, kink: float) -> bool:
    """Whether a ratio of speeds is that at a kink, up to its rounding."""
    return kink * (1 - _AT_KINK) <= r <= kink * (1 + _AT_KINK)


def _looked_at(branches: Branches) -> list[float]:
    """Return the r at which branches are compared with the definition."""
    places: list[float] = []
    for start, end, branch in zip(
        branches.starts, [*branches.starts[1:], math.inf], branches.branches, strict=True
    ):
        if isinstance(branch, PanelTable):
            edges = [*branch.rows[:, 0], end]
            places += [x for low, high in pairwise(edges) for x in (low, (low + high) / 2)]
        elif start and end < math.inf:
            steps = np.linspace(0, 1, 2 + math.ceil(2 * math.log2(end / start)))
            places += [start * (end / start) ** step for step in steps[:-1]]
        elif start:
            places += [start * 2.0**k for k in _OCTAVES if k < _WAVING]  # a wave has too many periods beyond
        else:
            places += [min(end, 1.0) / 2.0**k for k in _OCTAVES]
        places.append(math.nextafter(end, 0.0) if end < math.inf else places[-1])
    return list(dict.fromkeys(float(x) for x in places))


class _Builder:
    """Makes the branches of one average: both ends first, then the closed form, then a table of what is left."""

    def __init__(self, profile: Expr, criterion: Criterion, closed: Expr | None, point: dict[Expr, Expr]) -> None:
        self.profile = profile
        self.criterion = criterion
        self.point = point
        self.values = ReferenceAverage(profile, criterion, closed, point)
        self.local = criterion.weight is None
        self.closed = None if point else closed
        if self.local:
            self.closed = self._at_belt(self.values.parts[-1])
        # Each r beyond which a kink counts, as a float, and what it is exactly: a root grows from there.
        self.corners = {float(r): r for r in (kink / (1 if self.local else 2) for kink in self.values.kinks)}
        lowest, highest = scales_of(profile, point)
        self.lowest, self.highest = min([lowest, *self.corners]), max([highest, *self.corners])
        self.panels = WorkBudget(MOST_INTERVALS)
        self.decay = decay_at_rest(self.values.parts[0], point)

    def build(self) -> Branches | Unknown:
        """Return the branches in order, or why there are none."""
        powers = self._powers_alone()
        if powers is not None:
            return powers
        if self.local and self.values.reach < math.inf:
            starts = (0.0, *self.corners)
            slopes = map(self._at_belt, self.values.parts)
            return self._with_means(Branches(starts, tuple(Sum(0.0, 1.0, ((slope, (1.0,)),)) for slope in slopes)))
        whole = self._from_end_to_end()
        if isinstance(whole, Unknown) or not self.local:
            return whole
        return self._with_means(whole)

    def _at_belt(self, piece: Expr) -> Expr:
        """Return the falling slope of a piece at the belt's speed."""
        return -elementary(stable_slope_of(piece)).subs(symbols.v, symbols.V).xreplace(self.point)

    def _with_means(self, whole: Branches) -> Branches:
        """Return branches of a slope that are the mean of both sides at each kink."""
        starts = list(whole.starts)
        branches = list(whole.branches)
        for number, exact in enumerate(self.values.kinks):
            corner = float(exact)
            slopes = [self.values.slopes[i](acb(exact), False).real for i in (number, number + 1)]
            mean = Sum(0.0, 1.0, ((None, (-float(sum(slopes) / 2),)),))
            low = corner * (1 - _AT_KINK)
            high = math.nextafter(corner * (1 + _AT_KINK), math.inf)
            first = bisect_left(starts, low)
            last = bisect_right(starts, high)
            before = branches[first - 1]
            after = branches[last - 1]
            if before is after and isinstance(before, PanelTable):  # a panel ends at the corner
                beyond = before.rows[:, 0] >= corner
                before, after = (replace(before, rows=before.rows[rows]) for rows in (~beyond, beyond))
            starts[first:last], branches[first - 1 : last] = [low, high], [before, mean, after]
        return Branches(tuple(starts), tuple(branches))

    def _from_end_to_end(self) -> Branches | Unknown:
        """Return the branches at rest, in between and far out."""
        reach = self.values.reach
        nothing = Sum(0.0, 1.0, ((None, (math.nan,)),))
        last = (self.values.end / 2, nothing) if reach < math.inf else self._far_out()
        direct = None
        if reach == math.inf:
            direct = self._direct(last[0] if last else self.highest * 2.0**OCTAVES_BEYOND_SCALES)
        if last is None and direct is None:
            farthest = next(filter(self._is_tabulated, (OCTAVES_BEYOND_SCALES, *range(_WAVING, 0, -1))), None)
            if farthest is None:
                return Unknown(f"{self.profile} varies too often for a table, and has no series far out")
            last = self.highest * 2.0**farthest, nothing
        outer = [pair for pair in (direct, last) if pair is not None]
        stop = outer[0][0]
        opened, branch = self._near_rest(stop) or (self.lowest * 2.0**-OCTAVES_BEYOND_SCALES, nothing)
        pairs: list[tuple[float, Branch]] = [(0.0, branch)]
        if opened < stop:
            table = self._table(opened, stop)
            if isinstance(table, Unknown):
                return table
            pairs.append((opened, table))
        starts, branches = zip(*pairs, *outer, strict=True)
        return Branches(starts, branches)

    def _is_tabulated(self, octaves: int) -> bool:
        """Whether panels are enough in the octave that ends so many beyond all scales: the farther, the fewer."""
        r = self.highest * 2.0**octaves
        halvings = 2 * OCTAVES_BEYOND_SCALES // octaves
        return not isinstance(attempted(self._panels, r / 2, r, None, halvings), Unknown)

    def _powers_alone(self) -> Branches | None:
        """Return the average of a sum of whole powers of v, or of one power, by the moments of the weight."""
        if self.values.kinks:
            return None
        coefficients: dict[Expr, Expr] = {}
        for term in sp.Add.make_args(sp.expand(stable_slope_of(self.profile))):
            coefficient, power = term.as_independent(symbols.v, as_Add=False)
            base, exponent = power.as_base_exp()
            if base not in (1, symbols.v):
                return None
            exponent = (exponent if base == symbols.v else sp.S.Zero).xreplace(self.point)
            coefficients[exponent] = -coefficient.xreplace(self.point)
        terms = {e: float(c * self.criterion.mean_power(e)) for e, c in coefficients.items()}
        low = min(terms)
        high = max(terms)
        if low == high:
            return Branches((0.0,), (_sum(low, sp.S.One, ((None, (terms[low],)),)),))
        if not all(exponent.is_Integer for exponent in terms):
            return None
        step = math.gcd(*(int(e - low) for e in terms))
        used = tuple(terms.get(sp.Integer(e), 0.0) for e in range(int(low), int(high) + 1, step))
        small = _sum(low, step, ((None, used),))
        large = _sum(high, -step, ((None, used[::-1]),))
        return Branches((0.0, 1.0), (small, large))

    # -- the ends ----------------------------------------------------------------------------------

    def _near_rest(self, stop: float) -> tuple[float, Branch] | None:
        """Return up to where the series at rest is F, and the branch, with an exponential if that helps."""
        slope = stable_slope_of(self.values.parts[0])
        unit = common_denominator(slope, self.point, self.criterion)
        best = None
        edge = min([stop, *self.corners])
        try:
            series = average_near_rest(expanded(slope, self.point, unit, far=False), self.criterion, unit)
            for decay in self._decays():
                if decay is None:
                    factor = GeneralisedSeries({(0, 0): arb(1)})
                else:
                    factor = expanded(1 / decay, {}, unit, far=False)
                pair = self._written(
                    series * factor, unit, -1, min(edge, self.lowest * 2.0**OCTAVES_BEYOND_SCALES), decay
                )
                if pair is not None and (best is None or pair[0] > best[0]):
                    best = pair
        except NotAnalytic:
            return None
        return best

    def _decays(self) -> list[Expr | None]:
        """Return what may stand before a series at rest: nothing, or an exponential."""
        rates = [
            -node.exp.coeff(symbols.v) for node in self.profile.atoms(sp.exp) if node.exp.is_polynomial(symbols.v)
        ]
        decays = [float(rate) for rate in rates if rate.is_number and rate.is_positive]
        if decays:
            return [None, sp.exp(-sp.Rational(min(decays)) * symbols.v)]
        return [None]

    def _far_out(self) -> tuple[float, Branch] | None:
        """Return from where the series in 1/r is F, and the branch."""
        slope = stable_slope_of(self.values.parts[-1])
        unit = common_denominator(slope, self.point, self.criterion)
        try:
            series = expanded(slope, self.point, unit, far=True)
            first = math.ceil(math.log2(self.highest))
            for octave in range(first + 2, first + OCTAVES_BEYOND_SCALES):
                end = arb(2) ** octave
                weight, moments = self.values.moments(end)
                whole = far_out(series, self.criterion, unit, end, weight, moments)
                if (pair := self._written(whole, unit, 1, float(end) / 2, None)) is not None:
                    return pair
        except (NotAnalytic, NotConverged):  # or its values far out are not known
            pass
        return None

    def _written(
        self, series: GeneralisedSeries, unit: int, side: int, edge: float, function: Expr | None
    ) -> tuple[float, Branch] | None:
        """Return from where, or up to where, a series holds as far as it goes, and the branch."""
        for half in range(8 * OCTAVES_BEYOND_SCALES):
            end = edge * 2.0 ** (side * half / 2)
            if end > self.highest * 2.0**OCTAVES_BEYOND_SCALES:
                return None
            kept = _terms_that_count(series, arb(end) ** (-side), unit, _CONDITION[side])
            if kept is None:
                continue
            branch = _powers_of_series(kept, unit, side, function)
            points = end * 2.0 ** (side * np.array(_OCTAVES))
            if self._agreed(branch, points) == points.size:
                return end, branch
            if side > 0:
                return None  # what is smaller than any power still counts, or a series that diverges
        return None

    # -- what lies between -------------------------------------------------------------------------

    def _direct(self, stop: float) -> tuple[float, Branch] | None:
        """Take the closed form, from where on it agrees with balls; None if it does nowhere below `stop`."""
        if not self.closed or self.closed.has(sp.I):
            return None
        if not self.local and not all(_is_fast(function) for function in self.closed.atoms(sp.Function)):
            return None
        octaves = np.arange(-4, np.log2(stop), 1 / _BRANCH_NODES)
        r = 2.0 ** octaves[::-1]
        for spelling in (sp.expand(self.closed), self.closed):  # expanded, 1 - exp(-V) may become exp(V) - 1
            branch = _as_sum(spelling)
            count = 0 if branch is None else self._agreed(branch, r)
            if branch is not None and count >= _BRANCH_NODES // 2:  # fewer may be luck
                return float(r[count - 1]), branch
        return None

    def _agreed(self, branch: Sum, r: FloatArray) -> int:
        """Return at how many of some r, from the first on, a branch agrees with balls."""
        with np.errstate(all="ignore"):
            values = np.asarray(value_of(branch, r))
        allowed = _ALLOWED_UNITS * EPSILON * np.fmax(self.values.mean_slope(r), np.abs(values)) + SMALLEST
        for i, (x, value, most) in enumerate(zip(r, values, allowed, strict=True)):
            if not abs(float(self.values(arb(float(x))) - arb(float(value)))) <= most:
                return i
        return r.size

    def _table(self, start: float, stop: float) -> PanelTable | Unknown:
        """Fit F by a polynomial in each of some panels, as many as it takes."""
        halves = np.arange(np.floor(2 * np.log2(start)), np.ceil(2 * np.log2(stop)) + 1) / 2
        inside = [*2.0**halves, *self.corners]
        edges = [start, *sorted({float(x) for x in inside if start < x < stop}), stop]
        rows: list[list[float]] = []
        for left, right in pairwise(edges):
            rooted = left in self.corners and not (self.local or self.criterion.is_polynomial)
            panels = self._panels(left, right, left if rooted else None)
            if isinstance(panels, Unknown):
                return panels
            rows += panels
        return PanelTable(np.array(rows), None if self.decay is None else self.decay.function)

    def _fitted(self, r: arb) -> arb:
        """Return F, over what stands before a table."""
        value = self.values(r)
        if self.decay is None:
            return value
        return value / self.decay.ball(2 * r)

    def _panels(
        self, left: float, right: float, origin: float | None, halvings: float = math.inf
    ) -> list[list[float]] | Unknown:
        """Return rows of a table between two r, whose panels are halved until one polynomial is enough.

        - `origin`: beyond which the square root is the variable.
        """

        def look(intervals: Sequence[Interval[float, None]]) -> list[Decision[list[float], None]]:
            return [self._panel(one.low, one.high, origin) for one in intervals]

        def middle_in_root(low: float, high: float) -> float:
            assert origin is not None
            return float(origin + middle(math.sqrt(low - origin), math.sqrt(high - origin)) ** 2)

        cut = middle if origin is None else middle_in_root
        limits = DivisionLimits(self.panels, halvings=halvings)
        return subdivide([(left, right)], look, limits=limits, cut=cut, to_first_open=True).complete()

    def _panel(self, left: float, right: float, origin: float | None) -> Decision[list[float], None]:
        """Accept the polynomial through values between two r if it is smooth, and holds between them."""
        low, high = (left, right) if origin is None else (np.sqrt(left - origin), np.sqrt(right - origin))
        centre = (low + high) / 2
        half = (high - low) / 2
        grid = ball_grid(_BRANCH_NODES)

        def value_at(t: arb) -> arb:
            x = arb(centre) + t * arb(half)
            return self._fitted(x if origin is None else self.corners[origin] + x * x)

        values = [value_at(t) for t in grid.nodes]
        coefficients = grid.coefficients(values)
        between = centre if origin is None else float(origin + centre**2)
        size = abs(float(coefficients[0]))
        if self.decay is None:
            size = max(self.values.mean_slope(np.array([left, between, right])).min(), size)
        else:  # what is smaller than any float is not resolved, and is 0 in floats
            size = max(float(arb(SMALLEST) / self.decay.ball(arb(2 * right))), size)
        if not max(abs(float(c)) for c in coefficients[-2:]) <= _SMOOTH * size:
            return HALVE
        # An average of the slope is smooth on its whole width; the slope itself may be narrow between the nodes.
        if self.local and not self.values.bounded(left, right, max(abs(float(x)) for x in values)):
            return HALVE
        powers = grid.powers(coefficients)
        for t in ((grid.nodes[0] - 1) / 2, (grid.nodes[-2] + grid.nodes[-1]) / 2):  # its very end may be a kink
            if not abs(float(powers(t.mid()) - value_at(t.mid()))) <= _ALLOWED_UNITS * EPSILON * size:
                return HALVE
        row = [float(powers[k]) for k in range(_BRANCH_NODES)]
        return Accept([left, math.nan if origin is None else origin, centre, 1 / half, *row])


def _is_fast(function: Expr) -> bool:
    """Whether NumPy has a function, itself or as a quotient."""
    return function.func.__name__ in _OF_NUMPY or isinstance(function, sp.sech | sp.coth | sp.csch)


_OF_NUMPY = {name for name, text in NumPyPrinter().known_functions.items() if text.startswith("numpy.")}


def _sum(power: Expr, variable: Expr | int, parts: Sequence[tuple[Expr | None, tuple[float, ...]]]) -> Sum:
    """Return a branch with its power as a float: far from r = 1 a factor restores what rounding took from it."""
    if rest := float(power - binary_fraction(float(power))):
        factor = 1 + rest * sp.log(symbols.V)
        parts = [(factor if f is None else factor * f, coefficients) for f, coefficients in parts]
    return Sum(float(power), float(variable), tuple(parts))


def _terms_that_count(series: GeneralisedSeries, x: arb, unit: int, condition: float) -> Powers | None:
    """Return the terms of a series that count at x and below it; None where it is cut too early, or cancels."""
    logarithm = x.log()
    balls = {(e, n): c * x ** (arb(e) / unit) * logarithm**n for (e, n), c in series.terms.items()}
    largest = max(
        (abs(ball) for ball in balls.values()),
        key=lambda ball: ball.mid().man_exp()[1] + ball.mid().man_exp()[0].bit_length(),
        default=arb(1),
    )
    shares = {key: float(ball / largest) for key, ball in balls.items()}
    total = sum(shares.values())
    size = sum(map(abs, shares.values()))
    if not size <= condition * abs(total):
        if not series.terms and series.top == math.inf:
            return {}
        return None
    least = NEGLIGIBLE * abs(total)
    late = math.inf
    if series.top < math.inf:
        late = series.top - (series.top - series.low) / 4
    if any(e >= late and abs(share) > least for (e, _), share in shares.items()):
        return None
    rest = 0.0
    kept = {key: c for key, c in series.terms.items() if abs(float(balls[key])) > SMALLEST}
    for key in sorted(shares, reverse=True):
        rest += abs(shares[key])
        if rest > least:
            break
        kept.pop(key, None)
    if all(SMALLEST < abs(float(c)) < LARGEST for c in kept.values()):
        return kept
    return None


def _powers_of_series(terms: Powers, unit: int, side: int, function: Expr | None) -> Sum:
    """Write a series as one power of r times polynomials in another, beside powers and a logarithm if need be."""
    low = min((e for e, _ in terms), default=0)
    offsets = [e - low for e, _ in terms]

    def lengths(step: int) -> dict[tuple[int, int], int]:
        """Return how long the polynomials in r^step are, each by the power and the logarithm before it."""
        longest: dict[tuple[int, int], int] = {}
        for e, n in terms:
            k, rest = divmod(e - low, step)
            longest[rest, n] = max(k + 1, longest.get((rest, n), 0))
        return longest

    each_alone = max(offsets, default=0) + 1  # where powers, as of a measured exponent, have no common step
    steps = sorted({math.gcd(*offsets) or unit, unit, min((o for o in offsets if o), default=unit), each_alone})
    step = min(steps, key=lambda step: sum(lengths(step).values()))
    polynomials = {before: [0.0] * length for before, length in lengths(step).items()}
    for (e, n), c in terms.items():
        k, rest = divmod(e - low, step)
        polynomials[rest, n][k] = float(c)

    parts = []
    for (rest, n), coefficients in sorted(polynomials.items()) or [((0, 0), [0.0])]:
        before = symbols.V ** sp.Rational(-side * rest, unit) * (-side * sp.log(symbols.V)) ** n
        before *= 1 if function is None else function.subs(symbols.v, symbols.V)
        parts.append((None if before == 1 else before, tuple(coefficients)))
    return _sum(sp.Rational(-side * low, unit), sp.Rational(-side * step, unit), parts)


def _as_sum(closed: Expr) -> Sum | None:
    """Write a closed form, a sum, as polynomials in 1/V times functions, times one power of V."""
    V = symbols.V
    groups: dict[Expr, dict[int, Expr]] = {}
    for term in sp.Add.make_args(closed):
        coefficient, rest = term.as_independent(V, as_Add=False)
        power = sp.S.Zero
        function = rest
        for factor in sp.Mul.make_args(rest):
            base, exponent = factor.as_base_exp()
            if base == V:
                power += exponent
                function /= factor
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
