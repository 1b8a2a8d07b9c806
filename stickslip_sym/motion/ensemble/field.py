"""The rates of slip of many masses at once, and a step of all of them: DOP853 with a step length for each.

In the stages of a step only w' is new. Since q' = 1 - side w, and w' has q linearly, what q adds up to at a stage
is a second sum of the same rates, with the square of the method's matrix:

    w_i = w + h sum_j A_ij w'_j,    side q_i = side q + c_i h (side - w) - h^2 sum_j (A^2)_ij w'_j.

So one product of small matrices makes both, and the stages of q are never written down.
"""

from collections.abc import Callable

import numpy as np
from scipy.integrate import DOP853

from stickslip_sym.core.aliases import FloatArray, IntArray
from stickslip_sym.model.oscillator import Scene

__all__ = ["EXPONENT", "Field", "Rise", "error_of"]

Rise = Callable[[FloatArray], FloatArray]
"""mu(V w) - mu(0+) of many w, each on a segment of mu."""
EXPONENT = -1 / (DOP853.error_estimator_order + 1)
"""Of the error of a step, in the length of the next one."""

_A = np.array(DOP853.A)
_PAIRS = [np.array((_A[i, :i], (_A @ _A)[i, :i])) for i in range(12)]
_NODES = DOP853.C[:12].tolist()
_ROWS = np.array((DOP853.B, DOP853.E5[:12], DOP853.E3[:12]))  # the rates at the end of a step have no share
_LAST = np.concatenate((_ROWS, _ROWS @ _A))
_SMALL = 0.01  # states below count as that large, as in a single motion
_JUMP = 1e-12  # of mu, relative, below which it is rounding
_NEAR = 1e-6  # slip speed, relative, over which a slope of mu is taken


class Field:
    """What the masses of one scene are subject to, as arrays.

    Attributes
    ----------
    scene : Scene
    lows, highs : numpy.ndarray
        The slip speeds w between which each smooth segment of mu holds.
    jumps : numpy.ndarray
        For each segment, whether mu jumps where it begins.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        lows, rises = zip(*scene.law.rises("numpy"), strict=True)
        self.lows = np.array(lows) / scene.speed
        self.highs = np.append(self.lows[1:], np.inf)
        everywhere = scene.law.curve is not None
        self.pieces = [
            _of_w(rise, scene.speed, low, high, everywhere=everywhere)
            for rise, low, high in zip(rises, self.lows.tolist(), self.highs.tolist(), strict=True)
        ]
        ends = [
            (scene.onset + self.pieces[max(i - 1, 0)](low), scene.onset + self.pieces[i](low))
            for i, low in enumerate(self.lows[:, None])
        ]
        before, after = np.array(ends)[..., 0].T
        self.jumps = np.abs(after - before) > _JUMP * np.maximum(np.abs(before), np.abs(after))
        self._stages = np.empty((12, 0))

    def rise(self, segment: IntArray) -> Rise:
        """Return the rise of mu for masses of which each is on a segment of its own."""
        if len(self.pieces) == 1:
            return self.pieces[0]
        groups = [(self.pieces[i], np.flatnonzero(segment == i)) for i in np.unique(segment)]

        def of_each(w: FloatArray) -> FloatArray:
            found = np.empty_like(w)
            for piece, rows in groups:
                found[rows] = piece(w[rows])
            return found

        return of_each if len(groups) != 1 else groups[0][0]

    def slope(self, rise: Rise, q: FloatArray, w: FloatArray, side: FloatArray) -> FloatArray:
        """Return w'."""
        scene = self.scene
        return scene.eta * (side * scene.static - scene.onset - rise(w)) + side * q - 2 * scene.zeta * w

    def bend(self, rise: Rise, w: FloatArray, side: FloatArray, slope: FloatArray) -> FloatArray:
        """Return w'', side - w less what w' loses as w changes."""
        return side - w - self.decay(rise, w) * slope

    def decay(self, rise: Rise, w: FloatArray) -> FloatArray:
        """Return -dw'/dw."""
        half = _NEAR * np.maximum(np.abs(w), 1.0)
        return self.scene.eta * (rise(w + half) - rise(w - half)) / (2 * half) + 2 * self.scene.zeta

    def step(
        self, rise: Rise, q: FloatArray, w: FloatArray, side: FloatArray, slope: FloatArray, h: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return q and w after a step, and rows of its errors: of order 5 in w and q, and of order 3."""
        scene, count = self.scene, q.size
        if not count <= self._stages.shape[1] <= 4 * count + 64:  # as narrow as may be, for the cache
            self._stages = np.empty((12, count))
        stages = self._stages[:, :count]
        held = scene.eta * (side * scene.static - scene.onset) + side * q
        lean, square = h * (side - w), h * h
        stages[0] = slope
        for i in range(1, 12):
            once, twice = _PAIRS[i] @ stages[:i]
            once *= h
            once += w
            np.multiply(rise(once), -scene.eta, out=stages[i])
            once *= 2 * scene.zeta
            stages[i] -= once
            twice *= square
            stages[i] -= twice
            stages[i] += held
            stages[i] += _NODES[i] * lean
        end, fifth, third, end_q, fifth_q, third_q = _LAST @ stages
        fifth_q *= h
        third_q *= h
        return q + side * (lean - square * end_q), w + h * end, np.array((fifth, fifth_q, third, third_q))


def error_of(
    before: tuple[FloatArray, FloatArray], after: tuple[FloatArray, FloatArray], errors: FloatArray,
    h: FloatArray, rtol: float,
) -> FloatArray:  # fmt: skip
    """Return the error of a step over its tolerance, estimated as for a single motion; states are w and q."""
    of_w, of_q = (_SMALL + np.maximum(np.abs(a), np.abs(b)) for a, b in zip(before, after, strict=True))
    fifth, fifth_q, third, third_q = errors
    high, low = (fifth / of_w) ** 2 + (fifth_q / of_q) ** 2, (third / of_w) ** 2 + (third_q / of_q) ** 2
    both = 2 * (high + 0.01 * low)
    return np.where(both == 0, 0.0, h * high / np.sqrt(both)) / rtol


def _of_w(rise: Rise, speed: float, low: float, high: float, *, everywhere: bool) -> Rise:
    """Return a rise as a function of w that a step may try anywhere, as `model.oscillator` has it of one w."""
    if everywhere:
        return lambda w: rise(speed * w)

    def value(w: FloatArray) -> FloatArray:
        found = rise(speed * w)
        return found if found.shape == w.shape else np.full(w.shape, found)

    def continued(w: FloatArray) -> FloatArray:
        found = value(np.maximum(w, -1.0))
        if np.isfinite(found.sum()):
            return found
        lost = ~np.isfinite(found) & ~((w > low) & (w < high))
        ends = value(np.clip(w, low, high))
        return np.where(lost, np.where(w > 0, ends, 0.0), found)

    return continued
