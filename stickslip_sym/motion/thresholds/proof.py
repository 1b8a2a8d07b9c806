"""A pure-slip threshold as a theorem: two dampings, close together, at which the slip from P is decided.
More damping turns the field one way and moves P inwards (the chapter `one_threshold` of the derivations), so if
the slip from P returns at one damping it does so at every smaller one. One damping at which it returns and one
at which it does not enclose the threshold. Critical values of other quantities are enclosed by the same search.
"""

import math
from collections.abc import Callable
from contextlib import suppress
from fractions import Fraction
from functools import partial

import sympy as sp
from flint import arb

from stickslip_sym.core.aliases import Rational
from stickslip_sym.core.errors import InputError, NotConverged, NoThreshold
from stickslip_sym.criteria.enclosure import Enclosure
from stickslip_sym.motion.thresholds.box_scene import BoxScene
from stickslip_sym.motion.thresholds.box_transit import Transit, transit
from stickslip_sym.motion.thresholds.grazing import grazing_damping
from stickslip_sym.motion.thresholds.hypotheses import checked_hypotheses
from stickslip_sym.motion.thresholds.operating_points import OperatingPoints
from stickslip_sym.motion.thresholds.taylor_boxes import Undecided
from stickslip_sym.motion.thresholds.theorem import Theorem

__all__ = ["Search", "prove_threshold", "theorems"]

_GUESS = 1e-9  # tolerance of the simulation that says where to look
_BITS = (40, 100, 250, 600)  # of a decision, beyond those of its distance from the threshold, until one falls
_UNDAMPED_BITS = 64  # of the slip without damping, which is far from grazing
_CURVED = 10  # the secant is off by the square of the bracket, times this
_WIDEST = 1e-2  # of the first bracket, relative
_FINE = 1000  # parts of a bracket to which its ends are rounded


class Search:
    """Decisions at values of the damping, or of minus it, or of another quantity; and what encloses the threshold.

    Parameters
    ----------
    decision : callable
        From a value, and bits of precision, to the `Transit` there.
    label : str
        What the value is, for messages.
    """

    def __init__(self, decision: Callable[[Rational, int], Transit], label: str) -> None:
        self.decision, self.label = decision, label
        self.found: dict[Rational, Transit] = {}
        self.bits = list(_BITS)

    def decide(self, x: Rational, distance: float) -> Transit:
        """Return the transit at a value, at a precision that suits its relative distance from the threshold."""
        close = int(1.25 * max(0.0, -math.log2(distance)))
        while True:
            try:
                self.found[x] = self.decision(x, self.bits[0] + close)
            except Undecided as error:
                if len(self.bits) == 1:
                    bits = self.bits[0] + close
                    raise NotConverged(
                        f"undecided at {self.label} = {float(abs(x)):.15g} with {bits} bits: {error}"
                    ) from None
                del self.bits[0]  # nor would fewer do at the next value
            else:
                return self.found[x]

    @property
    def low(self) -> Rational:
        """The largest value at which the slip returns."""
        return max((x for x, found in self.found.items() if found.returns), default=None)

    @property
    def high(self) -> Rational:
        """The smallest value at which it does not."""
        return min((x for x, found in self.found.items() if not found.returns), default=None)

    def around(self, value: float, error: float, rtol: float) -> Enclosure:
        """Enclose the threshold by two values within a relative distance.

        - `value, error`: where to look, and its relative error as far as known.
        """
        center = sp.Rational(value)
        half = sp.Rational(rtol) * abs(center) * sp.Rational(2, 5)
        width = max(half, abs(center) * sp.Rational(min(max(2 * error, 1e-15), _WIDEST)))
        self.enclose(center, width)
        self.narrow(half, sp.Rational(rtol))
        return Enclosure.of(self.low, self.high)

    def enclose(self, center: Rational, width: Rational) -> None:
        """Find a value at which the slip returns and one at which it does not, on both sides of a guess."""
        for side in (-1, 1):
            step = width
            while self.decide(_rounded(center + side * step, step), float(step / abs(center))).returns != (
                side < 0
            ):
                step *= 4
                center = self.estimate() or center  # a guess that is off by more than it says is mended
                if not 0 < step < abs(center):
                    raise NotConverged(f"no change is near the guess {self.label} = {float(abs(center)):g}")

    def narrow(self, half: Rational, rtol: Rational) -> None:
        """Bring both values within a relative distance, by the secant where it converges, else by halves."""
        while self.high - self.low > rtol * abs(self.low):
            low, high = self.low, self.high
            middle, radius = self.estimate(), max(half, _CURVED * (high - low) ** 2 / abs(low))
            if middle is None or not low < middle < high or radius > (high - low) / 4:
                middle, radius = (low + high) / 2, sp.Integer(0)
            grain = radius or (high - low) / 8
            for c in sorted({_rounded(middle + side * radius, grain) for side in (-1, 1)}):
                if self.low < c < self.high:
                    self.decide(c, float(grain / abs(low)))

    def estimate(self) -> Rational | None:
        """Return where the lowest slip speed vanishes by the secant through two decisions close to it."""
        points = sorted(
            ((c, found.lowest.mid()) for c, found in self.found.items() if found.turned),
            key=lambda pair: abs(float(pair[1])),
        )[:2]
        if len(points) < 2 or points[0][1] == points[1][1]:
            return None
        (c1, w1), (c2, w2) = points
        return c1 - (c2 - c1) * _rational(w1 / (w2 - w1))


def _rational(value: arb) -> Rational:
    mantissa, exponent = value.mid().man_exp()
    return sp.Rational(int(mantissa)) * sp.Integer(2) ** int(exponent)


def _rounded(c: Rational, width: Rational) -> Rational:
    """Return the nearest decimal number with no more digits than a width calls for."""
    places = max(0, math.ceil(-math.log10(float(width) / _FINE))) if float(width) else 50
    # By integers: SymPy's rounding evaluates, and takes as long as some steps of a slip.
    return sp.Rational(round(Fraction(int(c.p), int(c.q)) * 10**places), 10**places)


def theorems(points: OperatingPoints, rtol: float) -> list[Theorem]:
    """Prove the threshold at every operating point; simulation guesses where it lies.

    Raises `InputError` if the law does not meet a hypothesis of the lemma.
    Raises `NoThreshold` if the slip returns for no damping c >= 0.
    Raises `NotConverged` if a decision does not fall; it says where the boxes grew.
    """
    found = []
    for row in range(len(points)):
        scene = BoxScene(points.law, **points.exact_row(row))
        guess, error = grazing_damping(points.law, points.oscillator(row), rtol=_GUESS)
        found.append(prove_threshold(scene, guess, error, rtol))
    return found


def prove_threshold(scene: BoxScene, guess: float, error: float, rtol: float) -> Theorem:
    """Prove two dampings that enclose the threshold.

    - `guess, error`: a value of the threshold in kg/s, and its relative error as far as known.
    - `rtol`: the width of the enclosure, relative.

    Raises `InputError` if the law does not meet a hypothesis of the lemma.
    Raises `NotConverged` if a decision does not fall; it says where the boxes grew.
    """
    hypotheses = checked_hypotheses(scene)
    search = Search(partial(transit, scene), "c in kg/s")
    if guess == 0:
        raise NoThreshold(
            "the threshold is 0: friction does no work along the orbit, and nothing is left to enclose"
        )
    search.around(guess, error, rtol)
    low, high = search.low, search.high
    undamped = None
    if low > 0:
        with suppress(Undecided, InputError):
            undamped = transit(scene, sp.Integer(0), _UNDAMPED_BITS)
    if undamped is not None and not undamped.returns:
        raise NoThreshold("the slip returns at some damping, but not without any: the lemma does not hold here")
    return Theorem(
        scene.law, scene.values, Fraction(int(low.p), int(low.q)), Fraction(int(high.p), int(high.q)),
        search.found[low], search.found[high], undamped, hypotheses,
    )  # fmt: skip
