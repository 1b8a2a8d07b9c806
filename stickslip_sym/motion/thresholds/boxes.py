"""Whether the slip that leaves P comes back to the belt's speed, decided with every error bounded.

The state is (q, w) as in `slip`: P is the origin, and w the slip speed over the belt's. *It returns* where a
box with w < 0 is reached, or one from which w falls to 0 at a bounded rate. *It does not* where w > 0 all the
way to its first minimum, at w < 1: on the line at that height between the orbit's first crossing and its end w'
is not negative, so that nothing leaves what the orbit and this line enclose. As long as q > 0, w > 0 holds by
itself: at w = 0, w' = eta (static - mu(0+)) + q is positive.

Boxes of states are carried by Taylor series in ball arithmetic. On a polydisc of radii R around a box, where the
field is analytic and at most M in size, a solution stays inside for the time rho = min R/M at least, so by
Cauchy's estimate the k-th coefficient of its series is at most R rho^-k, and what n terms leave over at the time t
is at most R (t/rho)^n/(1 - t/rho).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

import sympy as sp
from flint import acb, arb, arb_poly, arb_series, ctx

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, Rational
from stickslip_sym.core.balls import BallFunction, ball, ball_function, series_function
from stickslip_sym.core.deadline import check_time
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.precision import working_precision
from stickslip_sym.core.remedies import Argument
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.leading_terms import symbolic_limit_at_rest
from stickslip_sym.model.taylor_model import SHARE_OF_RADIUS
from stickslip_sym.motion.kernel.slip_data import MOST_STEPS
from stickslip_sym.numerics.known import Unknown

_SCALES = tuple(2.0**-i for i in range(-1, 9))  # of the radii that are tried for the polydisc
_HALVINGS_AT_HIGHEST = 8  # halvings of a step on which w is highest
_START_SHARE = 3  # the first step from a point where mu is not analytic is 2^-(bits/3)
_w = sp.Symbol("w")


class Undecided(Exception):
    """Boxes grew until nothing could be decided; the message says where."""


@dataclass(frozen=True)
class ExactPoint:
    """An operating point in exact numbers, in SI units: a bound law, and an oscillator without damping."""

    law: FrictionLaw
    V: Rational
    N: Rational
    m: Rational
    k: Rational

    @property
    def values(self) -> dict[str, Rational]:
        """All that was given, by name."""
        return {"V": self.V, "N": self.N, "m": self.m, "k": self.k, **self.law.values}

    @property
    def at_rest(self) -> Expr:
        """The coefficient mu(0+), by the first segment at v = 0, or its limit there; refused where it has none."""
        _, first = self.law.bound.segments[0]
        onset = symbolic_limit_at_rest(first, self.law.bound.point)
        if isinstance(onset, Unknown) or onset.is_infinite:
            raise InputError(f"no finite limit mu(0+) was found for {self.law!r}, as a proof needs it")
        return onset

    def segments(self, c: Rational) -> list["Segment"]:
        """Return the smooth segments of the field, ascending, at the working precision."""
        law = self.law.bound
        impedance = sp.sqrt(self.k * self.m)
        static = self.at_rest if law.static_expr is None else law.static_expr
        segments = []
        for (start, formula), end in zip(law.segments, [*law.exact_kinks, law.end], strict=True):
            mu = formula.xreplace({symbols.v: self.V * _w})
            push = self.N / (self.V * impedance) * (static - mu) - c / impedance * _w
            segments.append(
                Segment(
                    ball(start / self.V).real,
                    None if end is None else ball(end / self.V).real,
                    ball_function(push, _w, law.point),
                    series_function(push, _w, law.point),
                    series_function(sp.diff(push, _w), _w, law.point),
                )
            )
        return segments


@dataclass(frozen=True)
class Segment:
    """The field q' = 1 - w, w' = eta (static - mu(V w)) + q - 2 zeta w, on one smooth segment of mu.

    - `low`, `high`: between which slip speeds over V; the last segment has no end unless the law has.
    - `push`: w' - q of a ball w, and the flag.
    - `push_series`, `slope_series`: the same of a power series w, and its derivative by w.
    """

    low: arb
    high: arb | None
    push: BallFunction
    push_series: Callable[[arb_series], arb_series]
    slope_series: Callable[[arb_series], arb_series]

    def rate(self, q: arb, w: arb) -> arb:
        """Return w' over real balls."""
        return self.push(acb(w), False).real + q


# -- one step --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Flow:
    """All solutions from a box, over a time.

    - `q`, `w`: their Taylor polynomials.
    - `time`: how long they hold, exact.
    - `rest_q`, `rest_w`: bounds of what the polynomials leave over, at that time.
    """

    q: arb_poly
    w: arb_poly
    time: arb
    rest_q: arb
    rest_w: arb

    def at(self, t: arb) -> tuple[arb, arb]:
        """Return q and w over a ball of times."""
        if t == 0:
            return self.q[0], self.w[0]
        return self.q(t) + self.rest_q, self.w(t) + self.rest_w


def flow(segment: Segment, q: arb, w: arb, terms: int, *, start: bool = False) -> Flow:
    """Follow all solutions from a box for one step, by Taylor polynomials of so many terms.

    - `start`: whether the box is P with w' = 0 there exactly, since mu(0+) is the static coefficient.
    """
    rho, radius_q, radius_w = _polydisc(segment, q, w)
    try:
        polynomials = _taylor_polynomials(segment, q, w, terms, start)
    except (ValueError, ZeroDivisionError) as error:  # a series is divided by one whose first ball holds 0
        raise Undecided(f"the field has no power series around w = {w.str(6)}: {error}") from None
    time = arb(float(rho) * SHARE_OF_RADIUS)
    ratio = time / rho
    left = arb(0, 1) * ratio**terms / (1 - ratio)
    return Flow(*polynomials, time, arb(radius_q) * left, arb(radius_w) * left)


def _polydisc(segment: Segment, q: arb, w: arb) -> tuple[arb, float, float]:
    """Return a time for which every solution from a box stays near, and how near: the best of some polydiscs."""
    best = (arb(0), 0.0, 0.0)
    size = abs(float(w.mid()))
    for radius_w in sorted({share * scale for share in _SCALES for scale in (max(1.0, size), size)}, reverse=True):
        if not radius_w:
            break
        around = arb(0, 1) * arb(radius_w)
        disc = acb(w + around, around)  # a square that holds the disc around every point of the ball
        push = segment.push(disc, True)
        if not push.is_finite():
            continue
        most_q = (1 - disc).abs_upper()
        most_w = (push + acb(q)).abs_upper()
        # The radius of q that is used up when that of w is.
        speed = float(most_w)
        way = radius_w * float(most_q)
        radius_q = 2 * way / (math.hypot(speed, 2 * math.sqrt(way)) + speed)
        rho = arb((arb(radius_q) / most_q).min(arb(radius_w) / (most_w + arb(radius_q))).lower())
        if rho < best[0]:
            break  # smaller ones are left sooner still
        best = (rho, radius_q, radius_w)
    if not best[0] > 0:
        raise Undecided(f"the field is not analytic around w = {w.str(6)}")
    return best


def _taylor_polynomials(segment: Segment, q: arb, w: arb, terms: int, start: bool) -> tuple[arb_poly, arb_poly]:
    """Return Taylor polynomials by Newton's iteration, which doubles the number of terms each time.

    What the first k of them leave over in the equations is linear in the next k, up to order 2k.
    """
    zero = arb(0)
    all_q = [q, 1 - w]
    all_w = [w, zero if start else segment.rate(q, w)]
    while (known := len(all_q)) < terms:
        upto = min(2 * known, terms)
        ctx.cap = upto
        push = segment.push_series(arb_series(all_w, prec=upto)).coeffs()
        ctx.cap = upto - known
        slope = segment.slope_series(arb_series(all_w[: upto - known], prec=upto - known)).coeffs()
        push += [zero] * (upto - len(push))
        slope += [zero] * (upto - known - len(slope))
        new_q: list[arb] = []
        new_w: list[arb] = []
        for order in range(known, upto):
            carried = sum((a * d for a, d in zip(slope, reversed(new_w), strict=False)), push[order - 1])
            # The equation for q holds with the known coefficients up to their last one.
            rate_q = -(all_w[order - 1] if order == known else new_w[-1])
            rate_w = carried + (all_q[order - 1] if order == known else new_q[-1])
            new_q.append(rate_q / order)
            new_w.append(rate_w / order)
        all_q += new_q
        all_w += new_w
    return arb_poly(all_q), arb_poly(all_w)


# -- the slip from P -------------------------------------------------------------------------------


@dataclass(frozen=True)
class Transit:
    """What was shown of the slip from P.

    - `returns`: whether it comes back to the belt's speed.
    - `lowest`: the first minimum of w, or what stands for it where the slip returns.
    - `turned`: whether `lowest` is that minimum, also where the slip returns and mu goes on smoothly for w < 0.
    - `highest`: a ball that holds the largest w on the way.
    - `steps`, `bits`, `width`: how many Taylor steps, the working precision, and the width of the last box.
    """

    returns: bool
    lowest: arb
    turned: bool
    highest: arb
    steps: int
    bits: int
    width: float


def transit(point: ExactPoint, c: Rational | Fraction, bits: int) -> Transit:
    """Decide whether the slip from P returns at a damping c in kg/s, an exact rational.

    Raises `Undecided` with the words where the boxes grew too wide to tell.
    """
    with working_precision(bits):
        return ValidatedIntegrator(point, c, bits).run()


class ValidatedIntegrator:
    """Integration of the slip from P in balls: a box of states on its way, and what it was shown to do."""

    def __init__(self, point: ExactPoint, c: Rational | Fraction, bits: int) -> None:
        self.segments = point.segments(sp.Rational(c))
        self.smooth_start = point.law.static is None  # w' = 0 at P exactly
        self.bits = bits
        self.number = 0  # of the segment
        self.q = arb(0)
        self.w = arb(0)
        self.steps = 0
        self.highest = arb(0)  # a bound of w so far
        self.reached = arb(0)  # a value that w certainly has had

    @property
    def segment(self) -> Segment:
        """The smooth piece of the law in which the box is."""
        return self.segments[self.number]

    def run(self) -> Transit:
        """Integrate until it is shown that the slip returns, or that it does not."""
        while self.steps < MOST_STEPS:
            check_time()
            if self.steps and self.number == 0 and (most := self._falls_to_zero()) is not None:
                return self._result(True, most)
            start = not self.steps
            self.steps += 1
            try:
                step = flow(self.segment, self.q, self.w, self.bits // 2, start=start and self.smooth_start)
            except Undecided:
                if not start:
                    raise
                self._leave_roughly()
            else:
                if (result := self._follow(step)) is not None:
                    return result
        raise Undecided(f"after {MOST_STEPS} steps the slip from P has not turned: it creeps to rest")

    def _result(self, returns: bool, lowest: arb, *, turned: bool = False) -> Transit:
        highest = self.reached.union(self.highest)
        return Transit(returns, lowest, turned, highest, self.steps, self.bits, float(self.w.rad()))

    def _leave_roughly(self) -> None:
        """Take a first step so short that bounds of mu suffice, where it is not analytic at v = 0.

        With w <= top on [0, h], q' is from 1 - top to 1 and w' from q + low to q + high.
        """
        h = arb(2) ** -(self.bits // _START_SHARE)
        top = arb((4 * h * (h + abs(self.segment.push(acb(0), False).real))).upper())
        bounds = self.segment.push(acb(arb(0).union(top)), False).real
        if bounds.is_finite() and (h + bounds) * h < top:
            self.q = (h * (1 - top)).union(h)
            low, high = (h * h / 2 * part for part in (1 - top, 1))
            self.w = (low + h * arb(bounds.lower())).union(high + h * arb(bounds.upper()))
            if self.w > 0:
                return
        raise Undecided("mu changes too fast at v = 0 for a first step from P")

    def _falls_to_zero(self) -> arb | None:
        """Return a bound of w' < 0 if from this box, at w < 1, w falls to 0: there is no way out before."""
        rate = self.segment.rate(self.q, self.w)
        if not (rate < 0 and self.w < 1):
            return None
        highest = arb(self.w.abs_upper())
        time = 2 * highest / abs(rate)
        most = self.segment.rate(self.q.union(self.q + time), arb(0).union(highest))
        if most < 0 and highest / abs(most) < time:
            return most
        return None

    def _follow(self, step: Flow) -> Transit | None:
        """Go to the end of a step, or to the turn or the kink on the way."""
        before = self.segment.rate(self.q, self.w)
        for halvings in range(self.bits):
            time = step.time * arb(2) ** -halvings
            q, w = step.at(time)
            if self.number == 0 and w < 0 and self._is_below_kink(step, time):
                return self._result(True, w)
            if before < 0 < self.segment.rate(q, w):
                return self._turn(step, time)
            side = self._side(w)
            if side is None:
                continue
            if side:
                self._cross(step, time, side)
            else:
                self._require_inside(step, time)
                self.q = q
                self.w = w
                self.reached = self.reached.max(arb(w.lower()))
            return None
        raise self._too_wide()

    def _too_wide(self) -> Undecided:
        return Undecided(f"boxes of width {float(self.w.rad()):.1e} at w = {self.w.str(6)} are too wide to go on")

    def _is_below_kink(self, step: Flow, until: arb) -> bool:
        """Return whether w is certainly below the end of its segment up to a time: the field was the law's."""
        high = self.segment.high
        return high is None or bool(step.at(arb(0).union(until))[1] < high)

    def _side(self, w: arb) -> int | None:
        """Return -1, 0 or 1 for below, in and above the segment; None where that is not certain."""
        low = self.segment.low
        high = self.segment.high
        if self.number and not w > low:
            return -1 if w < low else None
        if high is not None and not w < high:
            return 1 if w > high else None
        if self.number or w > 0 or self.q >= 0:
            return 0
        return None

    def _require_inside(self, step: Flow, until: arb) -> None:
        """Show that w stays in the segment, and above 0, up to a time, halving what is too wide to tell."""
        low = self.segment.low
        high = self.segment.high
        waiting = [(arb(0), until, 0)]
        while waiting:
            start, stop, depth = waiting.pop()
            span = start.union(stop)
            q, w = step.at(span)
            rate = self.segment.rate(q, w)
            (q_start, w_start) = step.at(start)
            (_, w_stop) = step.at(stop)
            if rate > 0:
                lowest = w_start
                highest = w_stop
            elif rate < 0:
                lowest = w_stop
                highest = w_start
            else:  # nearly level: the value at the end and the rate tell more than the polynomial
                lowest = highest = w.intersection(w_stop + rate * (span - stop))
            above = rate > 0 or lowest > low or (not self.number and w < 1 and q_start >= 0)
            below = high is None or rate < 0 or highest < high
            top = arb(highest.upper())
            if (
                above
                and below
                and (depth >= _HALVINGS_AT_HIGHEST or not (rate.overlaps(arb(0)) and top > self.highest))
            ):
                self.highest = self.highest.max(top)
            elif depth == self.bits:
                raise self._too_wide()
            else:
                middle = arb(((start + stop) / 2).mid())
                waiting += [(middle, stop, depth + 1), (start, middle, depth + 1)]

    def _around(self, step: Flow, end: arb, event: Callable[[arb, arb], arb]) -> tuple[arb, arb]:
        """Return two times close together: where a function of the box was certainly below 0, and where above."""
        times = [arb(0), end]
        for side, sign in enumerate((-1, 1)):
            sure = times[side]
            unsure = times[1 - side]
            for _ in range(self.bits):
                middle = arb(((sure + unsure) / 2).mid())
                if event(*step.at(middle)) * sign > 0:
                    sure = middle
                else:
                    unsure = middle
            times[side] = sure
        return times[0], times[1]

    def _turn(self, step: Flow, end: arb) -> Transit | None:
        """Decide at the first minimum of w."""
        start, stop = self._around(step, end, self.segment.rate)
        span = start.union(stop)
        q, w = step.at(span)
        lowest = step.at(start)[1] + self.segment.rate(q, w) * (span - start)
        if not w < 1:
            raise self._too_wide()
        if self.number == 0 and lowest < 0 and self._is_below_kink(step, end):
            return self._result(True, lowest, turned=True)
        if lowest > self.segment.low:
            self._require_inside(step, start)
            return self._result(False, lowest, turned=True)
        if not (self.number and lowest < self.segment.low):
            raise Undecided(f"the lowest slip speed is {lowest.str(3)} V, of no certain sign at {self.bits} bits")
        self._cross(step, start, -1)
        return None

    def _cross(self, step: Flow, end: arb, side: int) -> None:
        """Go over to the next segment: w is the level there exactly, and q what it may be meanwhile."""
        level = self.segment.low if side < 0 else self.segment.high
        if level is None or not 0 <= self.number + side < len(self.segments):
            raise InputError(
                "the slip that follows stick goes beyond the last measured speed; "
                "measure further, or hold the last coefficient: ",
                Argument("extrapolate", True),
            )
        start, stop = self._around(step, end, lambda q, w: (w - level) * side)
        self._require_inside(step, start)
        q, w = step.at(start.union(stop))
        before = self.segment.rate(q, w)
        self.number += side
        self.q = q
        self.w = level
        if not (before * side > 0 and self.segment.rate(q, level) * side > 0):
            raise Undecided(
                f"at the kink at {level.str(6)} V the slip does not certainly go on: it touches or slides"
            )
