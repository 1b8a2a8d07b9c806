"""Slope averages by Gauss rules in NumPy: any law, kinks included, as accurate as the slope itself.

With v = 2V sin(phi)^2 a criterion reads

    c = -N * integral_0^(pi/2) w(s) mu'(v) 4 sin(phi) cos(phi) dphi,    s = -cos(2 phi),

and the integrand is smooth at both ends for every weight, square roots too. Panels are split at kinks,
shrink geometrically towards v = 0 down to the law's smallest scale, and are halved until two Gauss-Legendre
rules agree.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from stickslip_sym.core import symbols
from stickslip_sym.core.algebra import sp
from stickslip_sym.core.aliases import Expr, FloatArray, IntArray
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.criteria.criterion import Criterion

__all__ = ["COARSE", "FINE", "FIRST_PANEL", "angle_weight", "average", "gauss_legendre", "weight_of"]

Slope = Callable[..., tuple[FloatArray, FloatArray]]
"""From slip speeds and parameters to mu' and a bound of its rounding error, in machine epsilons."""

COARSE, FINE = 11, 21  # nodes of the two rules
_MOST_HALVINGS = 60
_MOST_PANELS = 4096  # of one element; a law that needs more is not averaged in double precision
FIRST_PANEL = 0.25  # of the smallest scale: there the slope is still a short polynomial
_NODES_AT_ONCE = 1 << 18
_SMALLEST_ANGLE = 1e-160  # its square is still a normal number


@lru_cache(maxsize=16)
def gauss_legendre(n: int, extended: bool = False) -> tuple[FloatArray, FloatArray]:
    """Return the nodes and weights of the Gauss-Legendre rule on [-1, 1], to the last bit but one.

    Parameters
    ----------
    n : int
    extended : bool
        In NumPy's longdouble; that is 64 bits on most machines, and 53 on some.
    """
    real = np.longdouble
    x = np.polynomial.legendre.leggauss(n)[0].astype(real)
    slope = np.ones_like(x)
    for _ in range(3):
        before, value = np.ones_like(x), x.copy()
        for k in range(2, n + 1):
            before, value = value, ((2 * k - 1) * x * value - (k - 1) * before) / real(k)
        slope = n * (before - x * value) / (1 - x * x)
        x = x - value / slope
    dtype = real if extended else np.float64
    return x.astype(dtype), (2 / ((1 - x * x) * slope * slope)).astype(dtype)


def weight_of(criterion: Criterion, m: Expr, p: Expr, q: Expr) -> Expr:
    """Return w(s) in terms of m = 1 - s^2, p = 1 + s and q = 1 - s, which do not cancel at the ends."""
    assert criterion.weight is not None
    weight, s = criterion.weight, symbols.s
    if sp.expand(weight.subs(s, -s) - weight) == 0:
        even = sp.powdenest(weight.subs(s, sp.sqrt(1 - m)), force=True)
        return sp.factor(even) if even.is_polynomial(m) else even
    content, factors = sp.factor_list(weight, s)
    result = content
    for factor, power in factors:
        # In the middle s = (p - q)/2 cancels, to an absolute error of one unit.
        known = {1 + s: p, s - 1: -q}
        result *= known.get(factor, factor.subs(s, (p - q) / 2)) ** power
    return result


def angle_weight(criterion: Criterion, m: Expr, p: Expr, q: Expr) -> Expr:
    """Return w(s) ds/dphi in the same terms; m = 4 sin(phi)^2 cos(phi)^2, p = 2 sin(phi)^2, q = 2 cos(phi)^2."""
    return 2 * sp.sqrt(m) * weight_of(criterion, m, p, q)


@lru_cache(maxsize=16)
def _weight(criterion: Criterion) -> Callable[..., FloatArray]:
    places = sp.symbols("m p q", positive=True, cls=sp.Dummy)
    return function_of(places, angle_weight(criterion, *places), "numpy")


def average(
    slope: Slope,
    speed: FloatArray,
    parameters: Sequence[FloatArray],
    criterion: Criterion,
    *,
    scale: FloatArray | None = None,
    kinks: Sequence[FloatArray] = (),
    tolerance: float = 2.0**-54,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Average a slope over many scenes at once.

    Parameters
    ----------
    slope : callable
        Takes slip speeds and the parameters; returns mu' and a bound of its rounding error, in machine epsilons.
    speed : numpy.ndarray
        Belt speeds V > 0, flat; float64 or longdouble, and all is computed in that.
    parameters : sequence of numpy.ndarray
        Each of the same length.
    criterion : Criterion
        With a weight.
    scale : numpy.ndarray, optional
        The smallest slip speed at which something happens.
    kinks : sequence of numpy.ndarray
        Slip speeds at which the slope may jump.
    tolerance : float
        Of the integration, relative to the average of the slope's size.

    Returns
    -------
    value, size, error : numpy.ndarray
        <mu'>, <|mu'|>, and a bound of the error of <mu'>; infinite where the panels did not suffice.
    """
    count = speed.size
    value, size, error = np.zeros_like(speed), np.zeros_like(speed), np.zeros_like(speed)
    step = max(1, _NODES_AT_ONCE // (40 * (COARSE + FINE)))
    for start in range(0, count, step):
        part = slice(start, start + step)
        columns = [speed[part], *(column[part] for column in parameters)]
        first = None if scale is None else scale[part]
        value[part], size[part], error[part] = _block(
            slope, columns, criterion, first, [kink[part] for kink in kinks], tolerance
        )
    return value, size, error


def _block(
    slope: Slope, columns: list[FloatArray], criterion: Criterion, scale: FloatArray | None,
    kinks: list[FloatArray], tolerance: float,
) -> tuple[FloatArray, FloatArray, FloatArray]:  # fmt: skip
    speed = columns[0]
    owner, left, right = _first_panels(speed, scale, kinks)
    value, size, error = np.zeros_like(speed), np.zeros_like(speed), np.zeros_like(speed)
    panels = np.bincount(owner, minlength=speed.size)
    epsilon = float(np.finfo(speed.dtype).eps)
    for level in range(_MOST_HALVINGS):
        fine, sizes, noise, off = _panel_sums(slope, columns, criterion, owner, left, right)
        # Sizes of the panels that are open do not count yet as long as they are not known.
        known = size + _sum(owner, sizes, speed)
        small = off <= np.maximum(tolerance * known[owner] * 0.25, epsilon * sizes * 0.25)
        small |= ~np.isfinite(off) | (panels[owner] > _MOST_PANELS) | (level == _MOST_HALVINGS - 1)
        done = owner[small]
        value += _sum(done, fine[small], speed)
        size += _sum(done, sizes[small], speed)
        # The estimate is that of the coarse rule; where it is met, the fine one is far better.
        good = off[small] <= np.maximum(tolerance * known[done], epsilon * sizes[small])
        error += _sum(done, np.where(good, epsilon * noise[small], np.inf), speed)
        if small.all():
            break
        owner, left, right = owner[~small], left[~small], right[~small]
        middle = (left + right) / 2
        owner = np.concatenate([owner, owner])
        left, right = np.concatenate([left, middle]), np.concatenate([middle, right])
        panels += np.bincount(owner, minlength=speed.size) // 2
    return value, size, error


def _sum(owner: IntArray, values: FloatArray, like: FloatArray) -> FloatArray:
    total = np.zeros_like(like)
    np.add.at(total, owner, values)
    return total


def _first_panels(
    speed: FloatArray, scale: FloatArray | None, kinks: list[FloatArray]
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return owner, left end and right end of the panels to begin with."""
    real = speed.dtype.type
    half_pi = real(2) * np.arctan(real(1))
    if scale is None:
        first = np.full_like(speed, half_pi)
    else:
        ratio = np.minimum(np.maximum(FIRST_PANEL * scale / (2 * speed), real(_SMALLEST_ANGLE) ** 2), 1)
        first = np.arcsin(np.sqrt(ratio))
    counts = np.maximum(np.ceil(np.log2(half_pi / first)), 0).astype(int) + 1
    owner = np.repeat(np.arange(speed.size), counts)
    order = np.arange(owner.size) - np.repeat(np.cumsum(counts) - counts, counts)
    growth = np.exp2(np.log2(half_pi / first) / np.maximum(counts - 1, 1))[owner]
    left = np.where(order == 0, 0, first[owner] * growth ** (order - 1.0))
    right = np.where(order == counts[owner] - 1, half_pi, first[owner] * growth ** (order + 0.0))
    for kink in kinks:
        with np.errstate(invalid="ignore"):
            place = np.arcsin(np.sqrt(kink / (2 * speed)))[owner]  # NaN where it lies outside
        inside = (left < place) & (place < right)
        owner, left, right = (
            np.concatenate([owner, owner[inside]]),
            np.concatenate([left, place[inside]]),
            np.concatenate([np.where(inside, place, right), right[inside]]),
        )
        left, right = left.astype(speed.dtype), right.astype(speed.dtype)
    return owner, left.astype(speed.dtype), right.astype(speed.dtype)


def _panel_sums(
    slope: Slope,
    columns: list[FloatArray],
    criterion: Criterion,
    owner: IntArray,
    left: FloatArray,
    right: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return for each panel the fine sum, the sum of sizes, the rounding bound, and the rules' difference."""
    speed = columns[0][owner][:, None]
    extended = columns[0].dtype != np.float64
    center, half = (right + left)[:, None] / 2, (right - left)[:, None] / 2
    weight = _weight(criterion)
    sums = []
    for n in (COARSE, FINE):
        x, w = gauss_legendre(n, extended)
        angle = center + half * x
        sine = np.sin(angle)
        cosine = np.cos(angle)
        parts = half * w * weight((2 * sine * cosine) ** 2, 2 * sine * sine, 2 * cosine * cosine)
        with np.errstate(all="ignore"):
            slopes, bound = slope(2 * speed * sine * sine, *(column[owner][:, None] for column in columns[1:]))
            sums.append(((parts * slopes).sum(axis=1), parts, slopes, bound))
    (coarse, *_), (fine, parts, slopes, bound) = sums
    with np.errstate(all="ignore"):
        sizes = (parts * np.abs(slopes)).sum(axis=1)
        bound = np.where((slopes == 0) & ~np.isfinite(bound), 0, bound)  # exp(-infinity) is 0 exactly
        noise = (parts * (bound + 2 * np.abs(slopes))).sum(axis=1)
        # As in QUADPACK: the difference is the error of the coarse rule, and that of the fine one is smaller.
        difference = np.abs(fine - coarse)
        relative = np.where(sizes > 0, difference / np.where(sizes > 0, sizes, 1), 0)
        off = sizes * np.minimum(relative, (200 * relative) ** 1.5)
    return fine, sizes, noise, off
