"""The criteria by numerical quadrature of their definition, to any number of digits.

Equation (16) as it stands: mu itself times the kernel over [0, 2V], in mpmath. Nothing here knows an
antiderivative, a derivative or a closed form, so agreement with one means something.
"""

import heapq
import math
from collections.abc import Callable
from typing import Any

import mpmath

from stickslip_sym import symbols
from stickslip_sym.codegen import function_of
from stickslip_sym.criteria import Criterion, find
from stickslip_sym.errors import InputError, NotConverged
from stickslip_sym.friction import FrictionLaw
from stickslip_sym.values import Number, exact

__all__ = ["damping", "to_mpf"]

_GUARD = 10  # digits beyond those asked for, against rounding in the sum
_MOST_LOST = 1000  # digits of cancellation that are followed before a result counts as zero
_MOST_PANELS = 120
_LOOKS = (0.001, 0.25, 0.5, 0.75, 0.999)  # of the way through a panel, where its size is looked at


def damping(
    law: FrictionLaw,
    criterion: str | Criterion = "least_squares",
    *,
    V: Number,
    N: Number,
    digits: int = 50,
) -> Any:
    """Return the damping coefficient of a criterion by quadrature, c = integral_0^2V mu(u) K(u) du.

    For `least_squares` the kernel is K(u) = 5 N (V - u)^3 / (2 V^5): equation (16). The `equilibrium`
    criterion, c = -N mu'(V), is taken by numerical differentiation of mu.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    criterion : str or Criterion
    V : number
        Belt speed in m/s, positive.
    N : number
        Normal force in N, not negative.
    digits : int
        Significant digits of the result. Where the integral cancels, the working precision follows;
        a result over 1000 digits smaller than its integrand is returned as 0.

    Returns
    -------
    mpmath.mpf
        In kg/s.

    Raises
    ------
    InputError
        For an unbound law or unusable numbers.
    NotConverged
        If the integrand is too irregular for the bound on the work.
    """
    criterion = find(criterion)
    speed, force = exact(V, "V"), exact(N, "N")
    if speed <= 0:
        raise InputError(f"V = {float(speed):g} must be positive; at V = 0 there is nothing to integrate over")
    if force < 0:
        raise InputError(f"N = {float(force):g} must not be negative")
    if not 1 <= digits <= 10_000:
        raise InputError(f"digits = {digits} is outside 1 to 10000")
    mu = function_of([symbols.v], law.substitute(law.expr), "mpmath")
    if force == 0 or not law.expr.has(symbols.v):
        return mpmath.mpf(0)  # every kernel averages a slope: it integrates to zero
    if criterion.weight is None:
        result = _following_cancellation(lambda tolerance: _slope(mu, speed, force), digits)
    else:
        kernel = function_of([symbols.u, symbols.V, symbols.N], criterion.moment_kernel, "mpmath")
        result = _following_cancellation(
            lambda tolerance: _weighted_integral(mu, kernel, speed, force, tolerance), digits
        )
    with mpmath.workdps(digits):
        return +result


def to_mpf(rational: Any) -> Any:
    """Round an exact rational to the current working precision of mpmath."""
    return mpmath.mpf(int(rational.p)) / int(rational.q)


def _following_cancellation(compute: Callable[[Any], tuple[Any, Any]], digits: int) -> Any:
    """Repeat a computation at rising precision until the digits that cancelled are paid for.

    `compute` takes a relative tolerance and returns a sum, and the size of its terms.
    """
    lost = 0
    while True:
        with mpmath.workdps(digits + _GUARD + lost):
            total, size = compute(mpmath.mpf(10) ** -(digits + lost + _GUARD // 2))
            if size == 0:
                return total
            bits = mpmath.mag(size) - mpmath.mag(total) if total else mpmath.inf
            needed = max(0, bits * math.log10(2) + 1)
        if needed <= lost + 1:
            return total
        if lost >= _MOST_LOST:
            return mpmath.mpf(0)
        # Noise hides how much is lost, so go up by more than what is seen.
        lost = int(min(_MOST_LOST, max(min(needed, _MOST_LOST) + 2, 2 * lost, 10)))


def _weighted_integral(mu: Any, kernel: Any, speed: Any, force: Any, tolerance: Any) -> tuple[Any, Any]:
    """Integrate mu times kernel; its two halves apart, as the kernel changes sign in the middle."""
    V, N = to_mpf(speed), to_mpf(force)
    halves = [
        _adaptive(lambda u: mu(u) * kernel(u, V, N), *limits, tolerance)
        for limits in ((mpmath.mpf(0), V), (V, 2 * V))
    ]
    return mpmath.fsum(halves), mpmath.fsum(halves, absolute=True)


def _slope(mu: Any, speed: Any, force: Any) -> tuple[Any, Any]:
    """Differentiate mu numerically; what cancels is mu itself."""
    V, N = to_mpf(speed), to_mpf(force)
    return -N * mpmath.diff(mu, V, relative=True), abs(N * mu(V) / V)


def _adaptive(f: Callable[[Any], Any], a: Any, b: Any, tolerance: Any) -> Any:
    """Integrate by the tanh-sinh rule, halving the panel with the largest error until all is small enough."""
    panels: list[tuple[Any, Any, Any, Any]] = []  # minus error, left, right, value: worst first

    def add(left: Any, right: Any) -> None:
        # mpmath's error estimate is absolute, so the integrand is brought to the order of 1 first.
        looks = [abs(f(left + (right - left) * fraction)) for fraction in _LOOKS]
        scale = max(looks) * (right - left) or mpmath.mpf(1)
        value, error = mpmath.quad(lambda u: f(u) / scale, [left, right], error=True)
        heapq.heappush(panels, (-error * scale, left, right, value * scale))

    add(a, b)
    while len(panels) <= _MOST_PANELS:
        error = -mpmath.fsum(panel[0] for panel in panels)
        if error <= tolerance * mpmath.fsum((panel[3] for panel in panels), absolute=True):
            return mpmath.fsum(panel[3] for panel in panels)
        _, left, right, _ = heapq.heappop(panels)
        middle = (left + right) / 2
        add(left, middle)
        add(middle, right)
    raise NotConverged(
        f"the quadrature did not reach {mpmath.nstr(tolerance, 2)} relative with {_MOST_PANELS} panels; "
        "ask for fewer digits, or split the law where it is not smooth"
    )
