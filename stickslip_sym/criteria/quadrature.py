"""The criteria by numerical quadrature of their definition, to any number of digits.

Equation (16) as it stands: mu itself times the kernel over [0, 2V], in mpmath, parted where the formula of mu
varies quickly. Nothing here knows an antiderivative, a derivative or a closed form, so agreement with one means
something.
"""

import math
from collections.abc import Callable, Sequence
from itertools import chain, pairwise
from typing import NamedTuple, SupportsIndex, TypeAlias

import mpmath
import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, Mpf, Rational
from stickslip_sym.core.errors import InputError, NotConverged
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.core.numbers import Number, binary_fraction, exact, require_type
from stickslip_sym.core.precision import GUARD_BITS, mp, own_mpf, rounded
from stickslip_sym.criteria.criterion import Criterion, CriterionName, find
from stickslip_sym.model.bound import BoundLaw
from stickslip_sym.model.expression.transitions import transitions
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.numerics.chebyshev import grid
from stickslip_sym.numerics.known import Unknown
from stickslip_sym.numerics.subdivide import (
    HALVE,
    MOST_INTERVALS,
    Accept,
    Decision,
    DivisionLimits,
    Interval,
    WorkBudget,
    subdivide,
)

__all__ = ["MOST_DIGITS", "average", "damping", "read_operating_point"]

Function: TypeAlias = Callable[[Mpf], Mpf]

MOST_DIGITS = 10_000  # of a result
_GUARD_DIGITS = int(GUARD_BITS * math.log10(2))  # digits beyond those asked for, against rounding in the sum
MOST_DIGITS_LOST = 400  # digits of cancellation in an integral that are followed before it counts as zero
_MOST_LOST_IN_SLOPE = 5 * MOST_DIGITS_LOST  # of a slope, which costs a few values of mu only
_PANEL_RATIO = 4  # times, each panel beside a narrow one
_ORDERS_AT_REST = 4
"""Times the digits of a number: decimal orders below the belt speed, as near as rest itself."""
_NODES_OF_LOOKS = ((1 + grid(5).nodes) / 2).tolist()  # of the way through a panel, where its size is looked at


def damping(
    law: FrictionLaw | str,
    criterion: CriterionName | Criterion = "least_squares",
    *,
    V: Number,
    N: Number,
    digits: int = 50,
) -> Mpf:
    """Return the damping coefficient of a criterion by quadrature, c = integral_0^2V mu(u) K(u) du.

    For `least_squares` the kernel is K(u) = 5 N (V - u)^3 / (2 V^5): equation (16). The `equilibrium`
    criterion, c = -N mu'(V), is taken by numerical differentiation of mu; at a kink it is the mean of both sides.

    Parameters
    ----------
    law : FrictionLaw, or its name or formula
        With all parameters bound.
    criterion : str or Criterion
    V : number
        Belt speed in m/s, positive.
    N : number
        Normal force in N, not negative.
    digits : int
        Significant digits of the result. Where the integral cancels, the working precision follows;
        an integral over 400 digits smaller than its integrand is returned as 0.

    Returns
    -------
    mpmath.mpf
        In kg/s.

    Raises
    ------
    InputError
        For an unbound law, unusable numbers, or a law that is not real and finite on [0, 2V].
    NotConverged
        If the integrand is too irregular for the bound on the work.
    """
    law = as_law(law)
    criterion, speed, force = read_operating_point(law, criterion, V, N, digits)
    if force == 0 or not law.expr.has(symbols.v):
        law.require_values()
        return mpmath.mpf(0)  # every kernel averages a slope: it integrates to zero
    with mp.workdps(digits + _GUARD_DIGITS):
        rule = "tanh-sinh" if law.curve is None else "gauss-legendre"  # of polynomials between kinks
        bound = law.kinetic
        mu = bound.function(mp.context)
        quick = _quick(bound)
        if bound.near_rest is not None:
            mu = _recover_lost_digits(mu, _order_of_cancellation(bound), own_mpf(speed))
        result = own_mpf(force) * average(mu, bound.exact_kinks, criterion, speed, digits + 2, rule, quick)
    return rounded(result, digits)


def _order_of_cancellation(law: BoundLaw) -> int:
    """Return a bound on the power of 1/v like which terms grow at rest that cancel there."""
    powers = [node.exp for node in law.expr.atoms(sp.Pow) if node.exp.is_number and node.exp.is_negative]
    return 1 + math.ceil(-float(sum(powers)))


def _recover_lost_digits(mu: Function, order: int, speed: Mpf) -> Function:
    """Return a coefficient whose terms cancel at rest, computed with as many more digits as they lose there.

    At rest itself it is that beside it, where it is the same to all digits.
    """

    def refined(v: Mpf) -> Mpf:
        beside = v or speed * mp.mpf(10) ** (-_ORDERS_AT_REST * mp.dps)
        lost = order * max(0, int(mp.log(speed / beside, 10)) + 1)
        with mp.workdps(mp.dps + lost):
            value = mu(beside)
        return +value

    return refined


def _quick(law: BoundLaw) -> list[Expr]:
    """Return slip speeds between which nothing of mu is narrow: nodes of a rule would step over it."""
    if law.curve is not None:
        return []
    segments = {formula for _, formula in law.segments}
    return [
        binary_fraction(speed + side * width * _PANEL_RATIO**k)
        for speed, width in chain(*(transitions(segment, law.point) for segment in segments))
        for k in range(int(math.log(speed / (2 * width), _PANEL_RATIO)) if 0 < width < speed / 8 else 0)
        for side in (-1, 1)
    ]


def average(
    coefficient: Function, kinks: Sequence[Expr], criterion: Criterion, speed: Expr, digits: int,
    rule: str = "tanh-sinh", quick: Sequence[Expr] = (),
) -> Mpf:  # fmt: skip
    """Return -<mu'(V(1 + s))>_w for a coefficient mu(v) that mpmath evaluates, of which all kinks are given.

    - `quick`: slip speeds at which panels end as well.
    """
    mu = _require_real(coefficient)
    if criterion.weight is None:
        return _confirmed_slope(mu, speed, digits, (-1, 1) if speed in kinks else (0,))
    singular = False
    try:
        mu(mp.mpf(0))
    except InputError:  # as of log(v), and of v*log(v)
        singular = True
        _require_integrable(mu, criterion, speed)
    return _following_cancellation(
        lambda tolerance: _integral_by_parts(mu, [*kinks, *quick], criterion, speed, tolerance, singular, rule),
        digits,
        MOST_DIGITS_LOST,
    )


def read_operating_point(
    law: FrictionLaw, criterion: CriterionName | Criterion, V: Number, N: Number, digits: int
) -> tuple[Criterion, Rational, Rational]:
    """Return a criterion, V and N, exactly, or refuse what no criterion has a value for."""
    criterion = find(criterion)
    speed = exact(V, "V")
    force = exact(N, "N")
    symbols.require_sign("V", speed)
    symbols.require_sign("N", force)
    require_type("digits", digits, SupportsIndex, "a whole number")
    if not 1 <= digits <= MOST_DIGITS:
        raise InputError(f"digits = {digits} is outside 1 to {MOST_DIGITS}")
    law.require_speed(speed if criterion.weight is None else 2 * speed)
    return criterion, speed, force


def _require_real(mu: Function) -> Function:
    """Guard a coefficient: what is not a finite real number is an error, never part of a result."""

    def guarded(v: Mpf) -> Mpf:
        try:
            value = mp.mpmathify(mu(v))
        except (ZeroDivisionError, ValueError):
            value = mp.nan
        if isinstance(value, mp.mpc) or not mp.isfinite(value):
            raise InputError(f"mu is not a finite real number at v = {mp.nstr(v, 8)} m/s: it is {value}")
        return value

    return guarded


def _require_integrable(mu: Function, criterion: Criterion, speed: Expr) -> None:
    """Refuse a coefficient that is infinite at v = 0 faster than the weight vanishes there."""
    order = criterion.order_at_rest
    with mp.workdps(_GUARD_DIGITS + 15):
        near, nearer = (
            abs(mu(v)) * v ** own_mpf(order)
            for v in (own_mpf(speed) * mp.mpf(10) ** -k for k in (2 * mp.dps, _ORDERS_AT_REST * mp.dps))
        )
        grows = nearer > near * (mp.mpf("1.01") if order == 0 else mp.mpf("0.5"))
    if grows and nearer > 0:
        raise InputError(
            f"mu is infinite at v = 0+, faster than the weight of the criterion {criterion.name!r} allows, so it "
            "has no value; cut mu off there: write Max(v, v_c) for v"
        )


def _following_cancellation(compute: Callable[[Mpf], tuple[Mpf, Mpf]], digits: int, most: int) -> Mpf:
    """Repeat a computation at rising precision until it has the digits that were asked for, whatever cancels.

    `compute` takes a relative tolerance and returns a sum, and the size of its terms; over `most` digits of
    cancellation the sum counts as zero.
    """
    lost = 0
    while True:
        with mp.workdps(digits + _GUARD_DIGITS + lost):
            total, size = compute(mp.mpf(10) ** -(digits + lost + _GUARD_DIGITS // 2))
            bits = mp.inf
            if total:
                bits = mp.mag(size) - mp.mag(total)
            needed = max(0, bits * math.log10(2) + 1)
        if needed <= lost + 1:
            return total
        if lost >= most:
            return mp.mpf(0)
        # Where all digits cancelled, what is left is noise that hides how many more there are.
        drowned = needed >= digits + lost
        lost = most if drowned and lost else int(min(most, max(needed + 2, 10)))


def _integral_by_parts(
    mu: Function,
    parting: Sequence[Expr],
    criterion: Criterion,
    speed: Expr,
    tolerance: Mpf,
    singular: bool,
    rule: str,
) -> tuple[Mpf, Mpf]:
    """Return the integral of mu times the kernel with the boundary terms, and the sum of their sizes.

    Over v, or under the harmonic weight over phi, v = 2V sin^2(phi): no singular ends, no v that cancels.
    """
    V = own_mpf(speed)
    inside = [V, *(own_mpf(place) for place in parting if place < 2 * speed)]  # the kernel changes its sign at V
    if criterion.is_polynomial:
        kernel = function_of([symbols.v, symbols.V], criterion.kernel, mp.context)
        ends = [mp.mpf(0), *sorted(set(inside)), 2 * V]
    else:
        angle = criterion.angle_kernel.subs(symbols.theta, 2 * symbols.theta) * 2
        kernel = function_of([symbols.theta, symbols.V], angle, mp.context)
        angles = {mp.asin(mp.sqrt(place / (2 * V))) for place in inside}
        ends = [mp.mpf(0), *sorted(angles), mp.pi / 2]

    def integrand(x: Mpf) -> Mpf:
        weight: Mpf = kernel(x, V)
        return mu(x if criterion.is_polynomial else 2 * V * mp.sin(x) ** 2) * weight

    def stretched(y: Mpf) -> Mpf:
        if y:
            return integrand(y**power) * power * y ** (power - 1)
        return mp.mpf(0)

    power = 1
    if singular:
        # In y, x = y^power, what is infinite at x = 0 but integrable vanishes at y = 0, or almost.
        near, nearer = (ends[-1] * mp.mpf(10) ** -k for k in (mp.dps, 2 * mp.dps))
        values = [abs(integrand(x)) for x in (near, nearer)]
        steepness = 0
        if all(values):
            steepness = mp.log(values[1] / values[0]) / mp.log(near / nearer)
        if 0 < steepness < 1:
            power = 1 + int(1 / (1 - steepness))
        ends = [mp.root(end, power) for end in ends]
    panels = pairwise(ends)
    parts = [_adaptive(stretched if singular else integrand, *panel, tolerance, rule) for panel in panels]
    if singular:
        rest = V * mp.mpf(10) ** (-_ORDERS_AT_REST * mp.dps)
    else:
        rest = mp.mpf(0)
    low, high = criterion.ends
    parts += [own_mpf(weight) * mu(v) / V for weight, v in ((low, rest), (-high, 2 * V)) if weight]
    return mp.fsum(parts), mp.fsum(parts, absolute=True)


def _confirmed_slope(mu: Function, speed: Expr, digits: int, sides: Sequence[int]) -> Mpf:
    """Differentiate mu numerically, twice: a formula for mu may cancel inside, where nothing else shows it.

    - `sides`: -1 and 1 at a kink, for the mean of the slopes on both.
    """

    def slope(tolerance: Mpf) -> tuple[Mpf, Mpf]:
        V = own_mpf(speed)
        step = mp.ldexp(V, -mp.prec - _GUARD_DIGITS)  # mpmath's own relative one is 1/V of what it should be
        # The differences stay on their side: their steps are smaller than the tolerance.
        slopes = [mp.diff(mu, V * (1 + side * tolerance), h=step) for side in sides]
        return -mp.fsum(slopes) / len(slopes), abs(mu(V) / V)

    wanted = digits
    while wanted < _MOST_LOST_IN_SLOPE:
        result = _following_cancellation(slope, wanted, _MOST_LOST_IN_SLOPE)
        again = _following_cancellation(slope, wanted + digits + _GUARD_DIGITS, _MOST_LOST_IN_SLOPE)
        with mp.workdps(digits + _GUARD_DIGITS):
            if abs(again - result) <= abs(again) * mp.mpf(10) ** -digits:
                return again
        wanted = 2 * (wanted + digits + _GUARD_DIGITS)
    raise NotConverged(f"the slope of mu at V = {float(speed):g} does not settle to {digits} digits")


class _Estimate(NamedTuple):
    """The integral over a panel, and its error."""

    value: Mpf
    error: Mpf


def _adaptive(f: Function, a: Mpf, b: Mpf, tolerance: Mpf, rule: str) -> Mpf:
    """Integrate by one of mpmath's rules, halving panels until the sum of their errors is small enough."""
    accepted = list[_Estimate]()

    def look(panels: Sequence[Interval[Mpf, None]]) -> list[Decision[Mpf, None]]:
        estimates = [_estimate(f, panel.low, panel.high, rule) for panel in panels]
        size = mp.fsum((one.value for one in (*accepted, *estimates)), absolute=True)
        left = tolerance * size - mp.fsum(one.error for one in accepted)
        if mp.fsum(one.error for one in estimates) <= left:
            return [Accept(one.value) for one in estimates]
        share = left / (2 * len(panels))  # so that at least half is left for what is halved
        accepted.extend(one for one in estimates if one.error <= share)
        return [Accept(one.value) if one.error <= share else HALVE for one in estimates]

    limits = DivisionLimits(WorkBudget(MOST_INTERVALS))
    values = subdivide([(a, b)], look, limits=limits, at_once=MOST_INTERVALS).complete()
    if isinstance(values, Unknown):
        raise NotConverged(
            f"the quadrature did not reach {mp.nstr(tolerance, 2)} relative with {MOST_INTERVALS} panels; "
            "ask for fewer digits, or split the law where it is not smooth"
        )
    return mp.fsum(values)


def _estimate(f: Function, left: Mpf, right: Mpf, rule: str) -> _Estimate:
    # mpmath's error estimate is absolute, so the integrand is brought to the order of 1 first.
    looks = [abs(f(left + (right - left) * fraction)) for fraction in _NODES_OF_LOOKS]
    scale = max(looks) * (right - left) or mp.mpf(1)
    value, error = mp.quad(lambda u: f(u) / scale, [left, right], error=True, method=rule)
    # Its degrees agree where all of them step over a narrow peak; the halves have other nodes.
    halves = mp.quad(lambda u: f(u) / scale, [left, (left + right) / 2, right], method=rule)
    return _Estimate(halves * scale, max(error, abs(halves - value)) * scale)
