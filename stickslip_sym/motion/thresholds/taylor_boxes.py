"""Steps of a slip phase with every error bounded: boxes of states, carried by Taylor series in ball arithmetic.
On a polydisc of radii R around a box of states, where the field is analytic and at most M in size, a solution
stays inside for the time rho = min R/M at least, so by Cauchy's estimate the k-th coefficient of its series is
at most R rho^-k, and what n terms leave over at the time t is at most R (t/rho)^n/(1 - t/rho).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

from flint import acb, arb, arb_series, ctx

from stickslip_sym.core.balls import BallFunction

__all__ = ["Field", "Flow", "Undecided", "flow"]

_RADII = tuple(2.0**-i for i in range(-1, 9))  # over the largest sensible one, tried for the polydisc
_SHARE = 0.25  # of the time rho that a step takes: with it a term gains two bits


class Undecided(Exception):
    """Boxes grew until nothing could be decided; the message says where."""


@dataclass(frozen=True)
class Field:
    """The field q' = 1 - w, w' = eta (static - mu(V w)) + q - 2 zeta w, on one smooth segment of mu."""

    push: BallFunction  # eta (static - mu(V w)) - 2 zeta w, of a ball w and the flag
    push_series: Callable[[arb_series], arb_series]  # the same of a power series w
    slope_series: Callable[[arb_series], arb_series]  # its derivative to w, of a power series w

    def rate(self, q: arb, w: arb) -> arb:
        """Return w' over real balls."""
        return self.push(acb(w), False).real + q


@dataclass(frozen=True)
class Flow:
    """All solutions from a box, over a time."""

    q: list[arb]
    w: list[arb]  # both: coefficients of their Taylor polynomials
    time: arb  # how long they hold, exact
    rest_q: arb
    rest_w: arb  # both: bounds of what the polynomials leave over, at that time

    def at(self, t: arb) -> tuple[arb, arb]:
        """Return q and w over a ball of times."""
        if t == 0:
            return self.q[0], self.w[0]
        return _value(self.q, t) + self.rest_q, _value(self.w, t) + self.rest_w


def _value(coefficients: list[arb], t: arb) -> arb:
    total = arb(0)
    for coefficient in reversed(coefficients):
        total = total * t + coefficient
    return total


def _around(center: arb, radius: float) -> acb:
    """Return a square of the complex plane that holds the disc of a radius around every point of a real ball."""
    reach = arb(radius)
    real = center + arb(0, 1) * reach
    return acb(real, arb(0, 1) * reach)


def _reach(field: Field, q: arb, w: arb) -> tuple[arb, float, float]:
    """Return a time for which every solution from a box stays near, and how near: the best of some polydiscs."""
    best = (arb(0), 0.0, 0.0)
    size = abs(float(w.mid()))
    radii = {share * scale for share in _RADII for scale in (max(1.0, size), size) if scale}
    for radius_w in sorted(radii, reverse=True):
        disc = _around(w, radius_w)
        push = field.push(disc, True)
        if not push.is_finite():
            continue
        most_q, most_w = (1 - disc).abs_upper(), (push + acb(q)).abs_upper()
        # The radius of q that is used up when that of w is.
        speed = float(most_w)
        room = radius_w * float(most_q)
        radius_q = 2 * room / (math.hypot(speed, 2 * math.sqrt(room)) + speed)
        rho = (arb(radius_q) / most_q).min(arb(radius_w) / (most_w + arb(radius_q)))
        if arb(rho.lower()) < best[0]:
            break  # smaller ones are left sooner still
        best = (arb(rho.lower()), radius_q, radius_w)
    if not best[0] > 0:
        raise Undecided(f"the field is not analytic around w = {w.str(6)}")
    return best


def _series(field: Field, q: arb, w: arb, terms: int, start: bool) -> tuple[list[arb], list[arb]]:
    """Return Taylor coefficients by Newton's iteration, which doubles their number each time.

    What the first k of them leave over in the equations is linear in the next k, up to order 2k.
    """
    zero = arb(0)
    all_q = [q, 1 - w]
    all_w = [w, zero if start else field.rate(q, w)]
    while (known := len(all_q)) < terms:
        upto = min(2 * known, terms)
        ctx.cap = upto
        series = arb_series(all_w, prec=upto)
        push = field.push_series(series).coeffs()
        ctx.cap = upto - known
        slope = field.slope_series(arb_series(all_w[: upto - known], prec=upto - known)).coeffs()
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
    return all_q, all_w


def flow(field: Field, q: arb, w: arb, terms: int, *, start: bool = False) -> Flow:
    """Follow all solutions from a box for one step.

    - `q, w`: the box.
    - `terms`: of the Taylor polynomial.
    - `start`: whether the box is P with w' = 0 there exactly, since mu(0+) is the static coefficient.
    """
    rho, radius_q, radius_w = _reach(field, q, w)
    before = ctx.cap
    try:
        coefficients = _series(field, q, w, terms, start)
    except (ValueError, ZeroDivisionError) as error:  # a series is divided by one whose first ball holds 0
        raise Undecided(f"the field has no power series around w = {w.str(6)}: {error}") from None
    finally:
        ctx.cap = before
    time = arb(float(rho) * _SHARE)
    ratio = time / arb(rho)
    left = ratio**terms / (1 - ratio)
    around = arb(0, 1)
    return Flow(*coefficients, time, around * arb(radius_q) * left, around * arb(radius_w) * left)
