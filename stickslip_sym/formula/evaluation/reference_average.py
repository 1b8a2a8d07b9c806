"""The average F(r) = -<g'(r(1 + s))>_w of a profile g(x), to some twenty digits more than a float has.

From the closed form in ball arithmetic where there is one, else from the slope as polynomials, in the same
arithmetic. Their pieces double from x = 0, so that all scales are met, and part at kinks and in halves until each
is one polynomial, whose average is exact; what lies far below x = r is summed up once for all r. Beside it:
the mean size of the slope, and the speed at which a profile ends.
"""

import math
from bisect import bisect_right
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import combinations, pairwise

import numpy as np
import sympy as sp
from flint import acb, arb, arb_mat, arb_poly, arb_series, fmpq_poly

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, FloatArray, Substitution
from stickslip_sym.core.balls import BallFunction, ball, ball_function, ball_value, rational, series_function
from stickslip_sym.core.deadline import check_time
from stickslip_sym.core.errors import InputError, NotConverged
from stickslip_sym.core.functions import arguments, write_sech
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.core.numbers import DOUBLE_BITS, LARGEST, NEGLIGIBLE, SAME, binary_fraction
from stickslip_sym.core.precision import working_precision
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.model.expression.canonical_form import HIGHEST_POWER_OF_V
from stickslip_sym.model.expression.pieces import branch_from, jumps, kinks_at
from stickslip_sym.model.expression.transitions import complex_zeros
from stickslip_sym.model.table import STEEPER
from stickslip_sym.model.taylor_model import balls_from_rest, coefficient_near_rest
from stickslip_sym.numerics.chebyshev import gauss_grid, grid
from stickslip_sym.numerics.known import Unknown, required
from stickslip_sym.numerics.subdivide import (
    HALVE,
    Accept,
    Decision,
    DivisionLimits,
    Interval,
    WorkBudget,
    exact_middle,
    locate_boundary,
    shown,
    subdivide,
)

BITS = 2 * DOUBLE_BITS
"""The working precision of values."""
ALLOWED_IN_CODE = 16.0
"""Units of eps <|g'|> by which what is written as code may differ from the definition."""
SMALLEST = 1 / LARGEST
"""What is less counts as 0: floats end there."""

_PLACES = tuple(0.3 * 2.7**k for k in range(5))  # r at which a closed form is checked, over 1 or the largest one

_PIECE_NODES = 32  # in a piece
_INTEGRATED = math.sqrt(NEGLIGIBLE)  # in the innermost panel, where the rule alone counts: it has twice the order
_BITS_OF_CLOSED_FORM = -math.log2(NEGLIGIBLE)  # bits of relative accuracy that a value of the closed form needs
_MOST_PIECES_AN_OCTAVE = 80  # a value takes all of them, and a table takes thousands of values
_MOST_WORK = 20_000  # pieces that all values may take, for each kink: some seconds; balls give single values then
_HALVINGS = round(math.log2(_PIECE_NODES))  # of a piece for balls that bound its slope: as close as its nodes
_ORDER = _PIECE_NODES // 2  # of a power series that bounds it where terms cancel, and of x^order at rest, at most
_EXPANSION = round(_BITS_OF_CLOSED_FORM)  # terms of a weight that is no polynomial, which is expanded up to r
OCTAVES_BEYOND_SCALES = 24
"""Octaves from a scale of a profile, or from a kink, within which a series begins to hold, or a table ends."""
_DEEP = BITS + OCTAVES_BEYOND_SCALES * _ORDER  # bits at rest, for differences between such powers
_P, _Q = sp.symbols("p q", cls=sp.Dummy)
_LARGEST_LOG = math.log(LARGEST)  # of a speed

_Exact = tuple[int, int]
"""The mantissa and the exponent of a number."""
Samples = list[tuple[arb, arb]]
"""Places x, and g'(x) dx there."""


@dataclass(frozen=True)
class _Piece:
    """Where the slope is one polynomial, in t from -1 to 1; and what it adds to a moment and to an average.

    The latter is 1/r times `average` in powers of high/r, and sqrt(high/r) where the weight is no polynomial. In a
    list from 0 both are sums over all pieces up to this one.
    """

    low: arb
    high: arb
    slope: arb_poly
    moment: arb
    average: arb_poly


class ReferenceAverage:
    """F(r) of a profile g(v) at values of its shapes, as a function of balls of the working precision `BITS`.

    `closed` is F as a formula in V; it is forgotten where it is not the average by the Gauss rule too, at a few
    places, or cancels at all of them. A function that has no balls is refused.
    """

    def __init__(self, profile: Expr, criterion: Criterion, closed: Expr | None, point: Substitution) -> None:
        self.profile = profile
        self.criterion = criterion
        self.point = point
        self.kinks = [ball(kink).real for kink in kinks_at(profile, point)]
        inner = [binary_fraction(float(low + high) / 2) for low, high in pairwise([arb(0), *self.kinks])]
        if self.kinks:
            outer = binary_fraction(float(2 * self.kinks[-1]))
        else:
            outer = sp.Integer(1)
        pieces = [branch_from(profile, point, place) for place in (*inner, outer)]
        first, *others = pieces
        self.slopes = [balls_from_rest(first, point, slope=_centred(stable_slope_of(first)))]
        self.slopes += [ball_function(_centred(stable_slope_of(piece)), symbols.v, point) for piece in others]
        self.parts = pieces
        self._series_of: dict[int, Callable[[arb_series], arb_series]] = {}
        self._jumps = [_reals(jump, point) for jump in jumps(profile, point)]
        mean_slope = MeanSlope(profile, criterion, point)
        shapes = [float(value) for value in point.values()]
        self.mean_slope: Callable[[FloatArray], FloatArray] = lambda r: mean_slope(r, *shapes)
        self.reach = reach_of(profile, point)
        self.end = self.reach * (1 - ALLOWED_IN_CODE**-2)  # nearer, the rounding of r counts more
        # In the innermost panel x is this power of the variable, for the slope may be a power of x.
        powers = [node for node in profile.atoms(sp.Pow) if node.base.subs(symbols.v, 0) == 0]
        exponents = [node.exp.xreplace(dict(point)) for node in powers]
        order = 2 * math.lcm(*(int(e.q) if e.is_Rational else _ORDER for e in exponents))
        self._order = min(order, _ORDER)
        self._pieces: dict[int, list[_Piece]] = {}
        self._resolved_pieces: dict[tuple[float, float], list[_Piece] | Unknown] = {}
        self._work = 0  # pieces that all values so far took
        lowest = math.frexp(scales_of(profile, point)[0])[1]
        highest = min([lowest - self._order, *(math.frexp(float(kink))[1] - 1 for kink in self.kinks)])
        tried = range(highest, highest - OCTAVES_BEYOND_SCALES, -self._order)
        self._first = next((octave for octave in tried if self._innermost(octave)[1]), tried[-1])
        self._formula: BallFunction | None = None
        if closed is not None:
            with suppress(InputError):  # a special function that has no balls; the rule has no need of it
                self._formula = ball_function(closed, symbols.V, point)
        if not self._is_formula_known():
            self._formula = None

    def _is_formula_known(self) -> bool:
        """Whether the closed form has digits at some places, and agrees with the rule wherever it has."""
        pairs = list[tuple[arb, arb]]()
        for share in _PLACES:
            r = arb(share * min(self.reach / 40, 1.0))
            value = self._by_formula(r)
            if value is not None:
                pairs.append((value, self._by_rule(r)))
        return bool(pairs) and all(bool(abs(value - other) <= SAME * abs(value)) for value, other in pairs)

    def __call__(self, r: arb) -> arb:
        """Return F(r), or raise `NotConverged`, or `OutOfTime` when the time of a `time_limit` is up."""
        check_time()
        value = self._by_formula(r)
        return self._by_rule(r) if value is None else value

    def _by_formula(self, r: arb) -> arb | None:
        """Return the closed form's value; None where it cancels."""
        if self._formula is None:
            return None
        try:
            whole = self._formula(acb(r), False)
        except (ValueError, ZeroDivisionError):
            return None
        known = (
            whole.is_finite() and whole.imag.contains(0) and whole.real.rel_accuracy_bits() >= _BITS_OF_CLOSED_FORM
        )
        return whole.real if known else None

    def _by_rule(self, r: arb) -> arb:
        if self.criterion.weight is None:
            return -self._slope(r)(acb(r), False).real
        r = r.mid()
        polynomial = self.criterion.is_polynomial
        innermost = min(math.frexp(float(r))[1] - 1 - self._order, self._first)
        pieces = self._pieces_up_to(innermost, 2 * r)
        count = max(bisect_right(pieces, 2 * r if polynomial else r, key=lambda piece: piece.high), 1)
        below = pieces[count - 1]
        near = [piece for piece in pieces[count:] if piece.low < 2 * r]
        self._work += len(near)
        if self._work > _MOST_WORK * (1 + len(self.kinks)):
            raise NotConverged(f"{self.profile} is too narrow in too many places for a table")
        p = below.high / r
        total = below.average(p) * (arb(1) if polynomial else p.sqrt()) / r
        total += self._by_polynomials(near, r) if polynomial else self._by_roots(near, r)
        for place, height in self._jumps:
            if bool(place > 0) and bool(place < 2 * r):
                p = place / r
                weight = ball_value(self.criterion.from_ends(_P, _Q), {_P: acb(p), _Q: acb(2 - p)})
                total += height * weight.real / r
        return -total

    def moments(self, end: arb) -> tuple[list[arb], list[arb]]:
        """Return the terms of the weight, and the moment of g' with each up to an end 2^n, in units of that."""
        if self.criterion.weight is None:
            return [], []
        pieces = self._pieces_up_to(self._first, end)
        below = next(piece for piece in pieces if piece.high >= end)
        weight = list(_weight_in_powers(self.criterion))
        order = 0 if self.criterion.is_polynomial else arb(1) / 2
        moments = [below.average[j] for j in range(len(weight))]
        for place, height in self._jumps:
            if bool(place > 0):
                moments = [
                    m + height * w * (place / end) ** (order + j)
                    for j, (m, w) in enumerate(zip(moments, weight, strict=True))
                ]
        return weight, [moment / end for moment in moments]

    def _slope(self, x: arb) -> BallFunction:
        return self.slopes[self._index(x)]

    def _series(self, x: arb) -> Callable[[arb_series], arb_series]:
        index = self._index(x)
        if index not in self._series_of:
            self._series_of[index] = series_function(
                _centred(stable_slope_of(self.parts[index])), symbols.v, self.point
            )
        return self._series_of[index]

    def _index(self, x: arb) -> int:
        return sum(1 for kink in self.kinks if bool(kink < x))

    # -- the slope as polynomials --------------------------------------------------------------------

    def _pieces_up_to(self, innermost: int, last: arb) -> list[_Piece]:
        """Return pieces, the first up to 2^innermost, as far as a place at least, or to the end of the profile."""
        if innermost not in self._pieces:
            samples = self._innermost(innermost)[0]
            end = arb(2) ** innermost
            share = self._moment(samples), self._average(samples, end)
            self._pieces[innermost] = [_Piece(arb(0), end, arb_poly([]), *share)]
        pieces = self._pieces[innermost]
        while pieces[-1].high < last and pieces[-1].high < self.end:
            below = pieces[-1]
            low = pieces[-1].high
            octave = arb(2) ** math.frexp(float(low))[1]
            high = min([octave, arb(self.end), *(kink.mid() for kink in self.kinks if low < kink.mid())])
            key = float(low), float(high)
            if key not in self._resolved_pieces:
                self._resolved_pieces[key] = self._resolved(low, high, below.moment)
            for piece in required(self._resolved_pieces[key]):
                ratio = (below.high / piece.high).mid()
                before = below.average(arb_poly([0, ratio]))
                before *= arb(1) if self.criterion.is_polynomial else ratio.sqrt()
                average = _middles(before + piece.average)
                below = replace(piece, moment=below.moment + piece.moment, average=average)
                pieces.append(below)
        return pieces

    def _innermost(self, octave: int) -> tuple[Samples, bool]:
        """Return samples from 0 to 2^octave, and whether the slope is resolved there."""
        end = arb(2) ** octave
        order = self._order
        slope = self._slope(end)
        (rule, weights) = gauss_grid(_PIECE_NODES)
        u = [(1 + t) / 2 for t in rule.nodes]
        places = [(end * x**order).mid() for x in u]
        rates = [order * end * x ** (order - 1) / 2 for x in u]
        with working_precision(_DEEP):  # so near to v = 0 differences vanish
            balls = [slope(acb(x), False).real * rate for x, rate in zip(places, rates, strict=True)]
        heights, noise = required(_heights(balls))
        sizes = [abs(float(c)) for c in rule.coefficients(heights)]
        samples = [(x, h * w) for x, h, w in zip(places, heights, weights, strict=True)]
        return samples, max(sizes[-2:]) <= _INTEGRATED * max(sizes) + grid(_PIECE_NODES).lebesgue * noise

    def _resolved(self, low: arb, high: arb, below: arb) -> list[_Piece] | Unknown:
        """Return the slope between two speeds as polynomials, halved until each holds; `below` is a moment."""

        def look(intervals: Sequence[Interval[arb, None]]) -> list[Decision[_Piece, None]]:
            return [self._polynomial(one.low, one.high, below) for one in intervals]

        limits = DivisionLimits(WorkBudget(_MOST_PIECES_AN_OCTAVE))
        return subdivide([(low, high)], look, limits=limits, cut=exact_middle, to_first_open=True).complete()

    def _polynomial(self, low: arb, high: arb, below: arb) -> Decision[_Piece, None]:
        """Accept the polynomial through values of the slope between two speeds if it is smooth, or negligible."""
        middle = ((low + high) / 2).mid()
        half = (high - low) / 2
        (rule, weights) = gauss_grid(_PIECE_NODES)
        slope = self._slope(middle)
        places = [(middle + t * half).mid() for t in rule.nodes]
        values = _heights([slope(acb(x), False).real for x in places])
        if isinstance(values, Unknown):
            return values
        heights, noise = values
        samples = [(x, h * w * half) for x, h, w in zip(places, heights, weights, strict=True)]
        coefficients = [c.mid() for c in rule.coefficients(heights)]
        sizes = [abs(float(c)) for c in coefficients]
        moment = self._moment(samples)
        smooth = max(sizes[-2:]) <= NEGLIGIBLE * max(sizes) + grid(_PIECE_NODES).lebesgue * noise
        power = max(1, int(sp.ceiling(self.criterion.order_at_rest)))
        negligible = (NEGLIGIBLE * below / ((high - low) * high**power)).max(arb(SMALLEST))
        most = negligible
        if smooth:
            most = (STEEPER * max(map(abs, heights), key=float)).max(negligible)
        if not self._bounded(slope, low, high, most):
            return HALVE
        least = max(NEGLIGIBLE * max(sizes), noise)
        kept = max((k for k, size in enumerate(sizes, 1) if size > least), default=1)
        polynomial = _middles(rule.powers(coefficients[:kept]))
        return Accept(_Piece(low, high, polynomial, moment, self._average(samples, high)))

    def bounded(self, low: float, high: float, most: float) -> bool:
        """Say whether the slope nowhere between two speeds exceeds the largest at some, several times over."""
        bound = (arb(most) * STEEPER).max(arb(SMALLEST))
        return self._bounded(self._slope(arb(low + high) / 2), arb(low), arb(high), bound)

    def _bounded(self, slope: BallFunction, low: arb, high: arb, most: arb) -> bool:
        """Say whether balls hold the slope between two speeds below a bound: nothing narrow is missed there."""

        def holds(low: arb, high: arb, _: int) -> bool:
            middle = ((low + high) / 2).mid()
            half = (high - low) / 2
            ball = slope(acb(arb(middle, half.abs_upper())), False).real
            return ball.is_finite() and (bool(abs(ball) <= most) or self._bounded_by_series(middle, half, most))

        return shown(holds, [(low, high)], halvings=_HALVINGS, cut=exact_middle)

    def _bounded_by_series(self, middle: arb, half: arb, most: arb) -> bool:
        """Say the same by a power series, whose remainder counts less where terms of the slope cancel."""
        with working_precision(BITS, _ORDER + 1):
            around = arb(middle, half.abs_upper())
            try:
                slope = self._series(middle)
                at, over = (slope(arb_series([x, 1], prec=_ORDER + 1)) for x in (middle, around))
            except (InputError, ValueError, ZeroDivisionError, TypeError):  # a pole, or no series
                return False
            sizes = [abs(c) * half**k for k, c in enumerate([*(at[k] for k in range(_ORDER)), over[_ORDER]])]
        return bool(sum(sizes, arb(0)) <= most)

    def _moment(self, samples: Samples) -> arb:
        """Return what |g'| contributes to an average over all that is larger."""
        power = max(1, int(sp.ceiling(self.criterion.order_at_rest)))
        return sum((x**power * abs(product) for x, product in samples), arb(0))

    def _average(self, samples: Samples, end: arb) -> arb_poly:
        """Return what samples up to an end add to an average, in powers of end/r."""
        places = tuple((x / end).mid().man_exp() for x, _ in samples)
        powers = _weight_terms(self.criterion, places)
        return _middles(arb_poly((powers * arb_mat([[product] for _, product in samples])).entries()))

    # -- what pieces add to an average ---------------------------------------------------------------

    def _by_polynomials(self, pieces: Sequence[_Piece], r: arb) -> arb:
        """Integrate the slope in pieces, up to 2r, times a weight that is a polynomial."""
        weight = _weight_in_powers(self.criterion)
        total = arb(0)
        for piece in pieces:
            middle = (piece.low + piece.high) / 2
            half = (piece.high - piece.low) / 2
            primitive = (piece.slope * weight(arb_poly([middle / r, half / r]))).integral()
            total += (primitive((min(piece.high, 2 * r) - middle) / half) - primitive(arb(-1))) * half / r
        return total

    def _by_roots(self, pieces: Sequence[_Piece], r: arb) -> arb:
        """Integrate the same times (2/pi) sqrt(1 - s^2): times s^k it is a derivative, and less times s^(k-2)."""
        lost = [piece.slope.degree() * math.log2(2 + 4 * float(r / (piece.high - piece.low))) for piece in pieces]
        with working_precision(BITS + int(max(lost, default=0.0))):
            total = arb(0)
            s = [piece.low / r - 1 for piece in pieces]
            s.append(pieces[-1].high / r - 1 if pieces[-1].high < 2 * r else arb(1))
            roots = [(1 - x * x).sqrt() for x in s]
            arcs = [(x.asin() + x * root) / 2 for x, root in zip(s, roots, strict=True)]
            for i, piece in enumerate(pieces):
                middle = (piece.low + piece.high) / 2
                half = (piece.high - piece.low) / 2
                left = list(piece.slope(arb_poly([(r - middle) / half, r / half]))) or [arb(0)]
                whole = [arb(0)] * len(left)
                for k in range(len(left) - 1, 0, -1):
                    whole[k - 1] = left[k] / (k + 2)
                    if k > 1:
                        left[k - 2] += whole[k - 1] * (k - 1)
                polynomial = arb_poly(whole)
                total += left[0] * (arcs[i + 1] - arcs[i])
                total += polynomial(s[i]) * roots[i] ** 3 - polynomial(s[i + 1]) * roots[i + 1] ** 3
            return 2 / arb.pi() * total


def _reals(exprs: Iterable[Expr], point: Substitution) -> list[arb]:
    return [ball_value(expr, point).real for expr in exprs]


def _heights(balls: Sequence[arb]) -> tuple[list[arb], float] | Unknown:
    """Return the middles of balls, 0 for a constant that cancels and leaves a ball, and the largest radius."""
    if not all(ball.is_finite() for ball in balls):
        return Unknown("the slope of mu is not enclosed there")
    return [arb(0) if ball.contains(0) else ball.mid() for ball in balls], max(float(ball.rad()) for ball in balls)


def _middles(polynomial: arb_poly) -> arb_poly:
    return arb_poly([c.mid() for c in polynomial])


@lru_cache(maxsize=16)
def _weight_in_powers(criterion: Criterion) -> arb_poly:
    """Return the weight in powers of p = 1 + s; one that is no polynomial over sqrt(p), for small p."""
    if criterion.is_polynomial:
        return arb_poly([arb(rational(c)) for c in reversed(criterion.from_rest.all_coeffs())])
    return arb_poly([2 / arb.pi() * arb(2).sqrt() * arb(rational(sp.binomial(sp.S.Half, k) / (-2) ** k))
                     for k in range(_EXPANSION)])  # fmt: skip


@lru_cache
def _weight_terms(criterion: Criterion, places: tuple[_Exact, ...]) -> arb_mat:
    """Return the terms of the weight at some p: a row for each power of the largest one."""
    columns = [arb(place) for place in places]
    powers = [arb(1) if criterion.is_polynomial else p.sqrt() for p in columns]
    rows = []
    for c in _weight_in_powers(criterion):
        rows.append([c * power for power in powers])
        powers = [power * p for power, p in zip(powers, columns, strict=True)]
    return arb_mat(rows)


@lru_cache
def stable_slope_of(profile: Expr) -> Expr:
    """Return g', with sech(a)^2 for 1 - tanh(a)^2, which cancels."""
    if isinstance(profile, sp.Piecewise):  # SymPy would compare all places again
        return sp.Piecewise(*((stable_slope_of(piece), holds) for piece, holds in profile.args), evaluate=False)
    return write_sech(sp.Add(*map(_slope_by_power_rule, sp.Add.make_args(profile))))


def _centred(expr: Expr) -> Expr:
    """Write each quadratic in v by its square, of which a ball is tight where v varies."""

    def complete(node: Expr) -> Expr:
        quadratic = sp.Poly(node, symbols.v)
        if quadratic.degree() != 2:
            return node
        a, b, c = quadratic.all_coeffs()
        return a * (symbols.v + b / (2 * a)) ** 2 + c - b**2 / (4 * a)

    return expr.replace(lambda node: node.is_Add and node.is_polynomial(symbols.v), complete)


def _slope_by_power_rule(term: Expr) -> Expr:
    """Differentiate by the power rule where it applies: SymPy asks for signs, at length."""
    coefficient, rest = term.as_independent(symbols.v, as_Add=False)
    base, exponent = rest.as_base_exp()
    if not exponent.is_Integer:
        return sp.diff(term, symbols.v)
    return coefficient * exponent * base ** (exponent - 1) * sp.diff(base, symbols.v)


# -- in floats -----------------------------------------------------------------------------------------


class MeanSlope:
    """<|g'|> of a profile to a few per cent, the unit in which errors of F are measured.

    Call it with an array of r, and of each parameter; `parameters` have their values where those are known.
    """

    _LEVELS, _POINTS = 70, 6  # panels towards x = 0, nodes in each

    def __init__(self, profile: Expr, criterion: Criterion, parameters: Sequence[Expr] | Substitution) -> None:
        slope = stable_slope_of(profile)
        self._local = criterion.weight is None
        point = parameters if isinstance(parameters, Mapping) else {}
        known = profile.free_symbols <= {symbols.v, *point}
        self._near_rest = coefficient_near_rest(branch_from(profile, point, sp.S.Zero), point) if known else None
        functions = [slope]
        if self._local:
            # At one point the rounding of r itself counts.
            self._p = np.ones(1)
            self._w = np.ones(1)
            functions.append(symbols.v * sp.diff(slope, symbols.v))
        else:
            x, w = np.polynomial.legendre.leggauss(self._POINTS)
            scale = 2.0 ** -np.arange(self._LEVELS)[:, None]
            self._p = (scale * (x + 3) / 2).ravel()
            self._w = (scale * w / 2).ravel()
            self._w *= np.abs(
                np.polyval(np.array(criterion.from_rest.all_coeffs(), dtype=float), self._p)
                if criterion.is_polynomial
                else 2 / np.pi * np.sqrt(self._p * (2 - self._p))
            )
        self._functions: list[Callable[..., FloatArray]] = [
            function_of([symbols.v, *parameters], function, "numpy") for function in functions
        ]

    def __call__(self, r: FloatArray, *parameters: float | FloatArray) -> FloatArray:
        """Return <|g'|> at each r."""
        columns = [np.asarray(parameter)[..., None] for parameter in parameters]
        x = r[:, None] * self._p
        with np.errstate(all="ignore"):
            values = [np.abs(np.broadcast_to(function(x, *columns), x.shape)) for function in self._functions]
            if self._near_rest is not None:  # where terms cancel in floats
                reach, series = self._near_rest
                near = np.abs(series.slope(np.minimum(x, reach)))
                values = [np.where(x <= reach, near, size) for size in values]
            sizes = [np.nansum(size * self._w, axis=1) for size in values]
        return np.asarray(np.max(sizes, axis=0))


_ARGUMENT_GRID = 2.0 ** np.arange(-30, 40, 1 / 16)  # where an argument is looked at for a change of its sign


def reach_of(profile: Expr, point: Substitution) -> float:
    """Return the speed at which a profile ends: at a pole, or where a logarithm or a root has no real value.

    Infinity where there is none up to 2^40.
    """
    arguments = {node.args[0] for node in profile.atoms(sp.log)}
    arguments |= {
        node.base
        for node in profile.atoms(sp.Pow)
        if node.base != symbols.v and not (node.exp.is_Integer and node.exp.is_positive)
    }
    arguments |= {1 - node.args[0] ** 2 for node in profile.atoms(sp.asin, sp.acos)}
    return min((_first_zero(a, point) for a in arguments if a.has(symbols.v)), default=np.inf)


def _first_zero(expr: Expr, point: Substitution) -> float:
    """Return the lowest speed at which a function of v is 0 or changes its sign, or infinity.

    Of a polynomial by its exact roots: in floats a sum that is nearly 0, as beside a narrow peak, has any sign.
    """
    if expr.is_positive:
        return np.inf
    if (zeros := _positive_zeros(expr, point)) is not None:
        return min(zeros, default=np.inf)
    parameters = list(point)
    values = [float(value) for value in point.values()]
    function = function_of([symbols.v, *parameters], expr, "numpy")
    with np.errstate(all="ignore"):
        signs = np.sign(np.broadcast_to(function(_ARGUMENT_GRID, *values), _ARGUMENT_GRID.shape))
    changes = np.flatnonzero(signs[1:] * signs[:-1] <= 0)
    if not changes.size:
        return np.inf
    first = changes[0]

    def is_below(v: float) -> bool:
        with np.errstate(all="ignore"):
            return bool(np.sign(function(v, *values)) == signs[first])

    return locate_boundary(is_below, float(_ARGUMENT_GRID[first]), float(_ARGUMENT_GRID[first + 1]), 0.0)[0]


def _positive_zeros(expr: Expr, point: Substitution) -> list[float] | None:
    """Return the zeros of a polynomial in v above 0; None for another function."""
    bound = expr.xreplace(dict(point))
    if not bound.is_polynomial(symbols.v):
        return None
    coefficients = sp.Poly(bound, symbols.v).all_coeffs()[::-1]
    if len(coefficients) > HIGHEST_POWER_OF_V + 1 or not all(c.is_Rational for c in coefficients):
        return None
    zeros = complex_zeros(fmpq_poly(list(map(rational, coefficients))))
    return [zero.real for zero in zeros if zero.imag == 0 and zero.real > 0]


def scales_of(profile: Expr, point: Substitution) -> tuple[float, float]:
    """Return the lowest and the highest speed at which the formula of a profile changes its way; 1 is between.

    In a sum of powers of v that is where two of them are equal and no other is larger; in the argument of a
    function a 1 counts too.
    """
    scales = [1.0]
    for node in profile.atoms(sp.Function, sp.Pow) - profile.atoms(sp.Piecewise):
        is_power = node.is_Pow and node.base is not sp.E
        for argument in node.args[:1] if is_power else arguments(node):
            if argument != symbols.v and argument.has(symbols.v):
                over, under = map(_power_exponents, sp.fraction(sp.together(argument.xreplace(dict(point)))))
                scales += [s for terms in (over, under, over + under) for s in _power_turns(terms)]
                scales += [] if is_power or len(under) != 1 else _power_turns([*over, (0.0, under[0][1])])
    return min(scales), max(scales)


def _power_exponents(expr: Expr) -> list[tuple[float, float]]:
    """Return exponents of v and logarithms of the coefficients' sizes; nothing for what is no sum of powers."""
    parts = [term.as_coeff_exponent(symbols.v) for term in sp.Add.make_args(sp.expand(expr))]
    if any(not c.is_number or not e.is_Rational or c == 0 for c, e in parts):
        return []
    return [(float(e), float(sp.log(abs(c)).evalf())) for c, e in parts]


def _power_turns(terms: list[tuple[float, float]]) -> list[float]:
    """Return where two of some powers are equal and no other is larger."""
    turns = []
    for (e, a), (f, b) in combinations(terms, 2):
        x = math.inf
        if e != f:
            x = (a - b) / (f - e)
        if abs(x) < _LARGEST_LOG and all(c + g * x <= a + e * x + 1 for g, c in terms):
            turns.append(math.exp(x))
    return turns
