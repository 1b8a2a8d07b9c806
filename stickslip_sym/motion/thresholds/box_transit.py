"""Whether the slip that leaves P comes back to the belt's speed, decided with every error bounded.

The state is (q, w) as in `slip`: P is the origin, and w the slip speed over the belt's. *It returns* where a
box with w < 0 is reached, or one from which w falls to 0 at a bounded rate. *It does not* where w > 0 all the
way to its first minimum, at w < 1: on the line at that height between the orbit's first crossing and its end w'
is not negative, so that nothing leaves what the orbit and this line enclose. As long as q > 0, w > 0 holds by
itself: at w = 0, w' = eta (static - mu(0+)) + q is positive.
"""

from collections.abc import Callable
from dataclasses import dataclass

from flint import acb, arb

from stickslip_sym.core.aliases import Rational
from stickslip_sym.core.balls import working_precision
from stickslip_sym.core.deadline import check_time
from stickslip_sym.core.errors import InputError
from stickslip_sym.motion.thresholds.box_scene import BoxScene, Segment
from stickslip_sym.motion.thresholds.taylor_boxes import Flow, Undecided, flow

__all__ = ["Transit", "transit"]

Event = Callable[[arb, arb], bool]
_MOST_STEPS = 20_000
_CUTS = 60  # halvings of a time at which something changes sign
_SHORTER = 0.7  # of a step that ends too close to a kink
_FINE = 8  # halvings of a step on which w is highest
_LOW = 0.5  # of w, below which a fall to 0 is looked for
_START_SHARE = 3  # the first step from a point where mu is not analytic is 2^-(bits/3)


@dataclass(frozen=True)
class Transit:
    """What was shown of the slip from P."""

    returns: bool
    lowest: arb  # the first minimum of w, or what stands for it where it returns
    turned: bool  # whether `lowest` is that minimum, also where the slip returns and mu goes on smoothly for w < 0
    highest: arb  # a ball that holds the largest w on the way
    steps: int  # Taylor steps
    bits: int  # the working precision
    width: float  # of the last box


def transit(scene: BoxScene, c: Rational, bits: int) -> Transit:
    """Decide whether the slip from P returns at a damping c in kg/s, an exact rational.

    Raises `Undecided` with the words where the boxes grew too wide to tell.
    """
    with working_precision(bits):
        return _Walk(scene, c, bits).run()


class _Walk:
    """A box on its way from P."""

    def __init__(self, scene: BoxScene, c: Rational, bits: int) -> None:
        self.segments = scene.segments(c)
        self.gentle = scene.starts_gently
        self.bits, self.terms = bits, bits // 2
        self.number = 0  # of the segment
        self.q, self.w = arb(0), arb(0)
        self.steps = 0
        self.highest = arb(0)  # a bound of w so far
        self.reached = arb(0)  # a value that w certainly has had

    @property
    def segment(self) -> Segment:
        return self.segments[self.number]

    def run(self) -> Transit:
        while self.steps < _MOST_STEPS:
            check_time()
            if self.steps and self.number == 0 and (most := self._falls_to_zero()) is not None:
                return self._result(True, most)
            try:
                step = flow(self.segment.field, self.q, self.w, self.terms, start=self.gentle and not self.steps)
            except Undecided:
                if self.steps:
                    raise
                self._leave_roughly()
                continue
            finally:
                self.steps += 1
            if (result := self._follow(step)) is not None:
                return result
        raise Undecided(f"after {_MOST_STEPS} steps the slip from P has not turned: it creeps to rest")

    def _result(self, returns: bool, lowest: arb, *, turned: bool = False) -> Transit:
        highest = _between(self.reached, self.highest)
        return Transit(returns, lowest, turned, highest, self.steps, self.bits, float(self.w.rad()))

    def _leave_roughly(self) -> None:
        """Take a first step so short that bounds of mu suffice, where it is not analytic at v = 0.

        With w <= top on [0, h], q' is from 1 - top to 1 and w' from q + low to q + high.
        """
        h = arb(2) ** -(self.bits // _START_SHARE)
        push = self.segment.field.push
        top = arb((4 * h * (h + abs(push(acb(0), False).real))).upper())
        bounds = push(acb(_between(arb(0), top)), False).real
        if bounds.is_finite() and (h + bounds) * h < top:
            self.q = _between(h * (1 - top), h)
            self.w = _between(h * h / 2 * (1 - top) + h * arb(bounds.lower()), h * h / 2 + h * arb(bounds.upper()))
            if self.w > 0:
                return
        raise Undecided("mu changes too fast at v = 0 for a first step from P")

    def _falls_to_zero(self) -> arb | None:
        """Return a bound of w' < 0 if from this box w falls to 0: there is no way out before."""
        field, q, w = self.segment.field, self.q, self.w
        rate = field.rate(q, w)
        if not (rate < 0 and w < _LOW):
            return None
        highest = arb(w.abs_upper())
        time = 2 * highest / abs(rate)
        most = field.rate(_between(q, q + time), _between(arb(0), highest))
        return most if most < 0 and highest / abs(most) < time else None

    def _follow(self, step: Flow) -> Transit | None:
        """Go to the end of a step, or to the turn or the kink on the way."""
        field = self.segment.field
        before, time = field.rate(self.q, self.w), step.time
        for _ in range(_CUTS):
            q, w = step.at(time)
            after = field.rate(q, w)
            if self.number == 0 and w < 0:
                return self._result(True, w)
            if before < 0 < after:
                return self._turn(step, time)
            side = self._side(w)
            if side is not None:
                if side:
                    self._cross(step, time, side)
                else:
                    self._require_inside(step, time)
                    self.q, self.w = q, w
                    self.reached = self.reached.max(arb(w.lower()))
                return None
            time = arb((time * _SHORTER).mid())
        raise self._too_wide()

    def _too_wide(self) -> Undecided:
        return Undecided(f"boxes of width {float(self.w.rad()):.1e} at w = {self.w.str(6)} are too wide to go on")

    def _side(self, w: arb) -> int | None:
        """Return -1, 0 or 1 for below, in and above the segment; None where that is not certain."""
        low, high = self.segment.low, self.segment.high
        if self.number and not w > low:
            return -1 if w < low else None
        if high is not None and not w < high:
            return 1 if w > high else None
        return 0 if self.number or w > 0 or self.q >= 0 else None

    def _require_inside(self, step: Flow, until: arb) -> None:
        """Show that w stays in the segment, and above 0, up to a time, halving what is too wide to tell."""
        low, high, field = self.segment.low, self.segment.high, self.segment.field
        waiting = [(arb(0), until, 0)]
        while waiting:
            start, stop, depth = waiting.pop()
            span = _between(start, stop)
            q, w = step.at(span)
            rate = field.rate(q, w)
            # Where w is nearly level, its value at the end and its rate tell more than its polynomial.
            end = step.at(stop)[1]
            level = end + rate * (span - stop)
            if self.number:
                above = w > low or rate > 0 or level > low
            else:
                above = w > 0 or level > 0 or (w < 1 and (step.at(start)[0] >= 0))
            below = high is None or w < high or rate < 0 or level < high
            top = arb((end if rate > 0 else step.at(start)[1] if rate < 0 else w).upper())
            if above and below and (depth >= _FINE or not (rate.overlaps(arb(0)) and top > self.highest)):
                self.highest = self.highest.max(top)
            elif depth == self.bits:
                raise self._too_wide()
            else:
                middle = arb(((start + stop) / 2).mid())
                waiting += [(middle, stop, depth + 1), (start, middle, depth + 1)]

    def _bracket(self, step: Flow, end: arb, is_before: Event, is_after: Event) -> tuple[arb, arb]:
        """Return two times as close as the box allows, one certainly before and one certainly after an event."""
        start, stop = arb(0), end
        for _ in range(2 * self.bits):
            middle = arb(((start + stop) / 2).mid())
            q, w = step.at(middle)
            if is_before(q, w):
                start = middle
            elif is_after(q, w):
                stop = middle
            else:
                # In the middle nothing is certain; halve both sides of it.
                left, right = arb(((start + middle) / 2).mid()), arb(((middle + stop) / 2).mid())
                moved = False
                if is_before(*step.at(left)):
                    start, moved = left, True
                if is_after(*step.at(right)):
                    stop, moved = right, True
                if not moved:
                    break
        return start, stop

    def _turn(self, step: Flow, end: arb) -> Transit | None:
        """Decide at the first minimum of w."""
        field = self.segment.field
        start, stop = self._bracket(
            step, end, lambda q, w: field.rate(q, w) < 0, lambda q, w: field.rate(q, w) > 0
        )
        span = _between(start, stop)
        q, w = step.at(span)
        lowest = step.at(start)[1] + field.rate(q, w) * (span - start)
        if not w < 1:
            raise self._too_wide()
        if self.number == 0 and lowest < 0:
            return self._result(True, lowest, turned=True)
        if lowest > self.segment.low:
            self._require_inside(step, start)
            return self._result(False, lowest, turned=True)
        if self.number and lowest < self.segment.low:
            self._cross(step, start, -1)
            return None
        raise Undecided(f"the lowest slip speed is {lowest.str(3)} V: its sign is not certain at {self.bits} bits")

    def _cross(self, step: Flow, end: arb, side: int) -> None:
        """Go over to the next segment: w is the level there exactly, and q what it may be meanwhile."""
        segment = self.segment
        level = segment.low if side < 0 else segment.high
        if level is None or not 0 <= self.number + side < len(self.segments):
            raise InputError(
                "the slip from P goes beyond the last measured speed; "
                "measure further, or hold the last coefficient: extrapolate=True"
            )
        start, stop = self._bracket(
            step, end, lambda q, w: (level - w) * side > 0, lambda q, w: (w - level) * side > 0
        )
        self._require_inside(step, start)
        q, w = step.at(_between(start, stop))
        rate = segment.field.rate(q, w)
        self.number += side
        self.q, self.w = q, level
        if not (rate * side > 0 and self.segment.field.rate(q, level) * side > 0):
            raise Undecided(
                f"at the kink at {level.str(6)} V the slip does not certainly go on: it touches or slides"
            )


def _between(low: arb, high: arb) -> arb:
    """Return a ball that holds all numbers between two."""
    return low.union(high)
