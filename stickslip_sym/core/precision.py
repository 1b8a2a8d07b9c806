"""Working precision: Arb's, set for a block or raised until a ball is small, and that of mpmath, one a thread."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

import mpmath
from flint import acb, arb, ctx
from mpmath.libmp import dps_to_prec, mpf_pos, round_nearest

from stickslip_sym.core.aliases import Expr, Mpf
from stickslip_sym.core.deadline import check_time
from stickslip_sym.core.numbers import to_mpf

Ball = TypeVar("Ball", arb, acb)

GUARD_BITS = 40
"""Bits of working precision beyond those that are needed."""
_lock = threading.RLock()  # Arb's precision is one setting of the whole process


@contextmanager
def working_precision(bits: int, terms: int | None = None) -> Iterator[None]:
    """Compute with so many bits, and terms of a power series, inside the block; other threads wait."""
    with _lock:
        before = ctx.prec, ctx.cap
        ctx.prec = bits
        ctx.cap = ctx.cap if terms is None else terms
        try:
            yield
        finally:
            ctx.prec, ctx.cap = before


def refined(compute: Callable[[], Ball], goal: int, most: float) -> Ball:
    """Compute a ball at rising precision, until so many bits of it are certain, or at `most` bits of precision.

    Raises `OutOfTime` when the time of a `time_limit` is up.
    """
    bits = goal + GUARD_BITS
    while True:
        check_time()
        with working_precision(bits):
            value = compute()
        reached = value.rel_accuracy_bits() if value.is_finite() else 0
        if reached >= goal or bits >= most:
            return value
        bits = int(min(most, bits + max(min(goal - reached, bits) + GUARD_BITS, bits // 4)))


# -- mpmath ------------------------------------------------------------------------------------------


class _OwnContext(threading.local):
    """A context of mpmath for each thread: its precision is no setting of the user's, and of no other thread."""

    def __init__(self) -> None:
        self.context = mpmath.MPContext()

    def __getattr__(self, name: str) -> Any:
        return getattr(self.context, name)


mp: mpmath.MPContext = _OwnContext()  # type: ignore[assignment]  # it behaves as one
"""What `mpmath` is elsewhere: all that computes here sets the precision of this one, never of `mpmath.mp`."""


def own_mpf(number: Expr) -> Mpf:
    """Round a SymPy number to the working precision of `mp`."""
    return to_mpf(number, mp.context)


def rounded(value: Mpf, digits: int) -> Mpf:
    """Return a number of any context, rounded to so many digits, as the user's own `mpmath.mpf`."""
    return mpmath.make_mpf(mpf_pos(value._mpf_, dps_to_prec(digits), round_nearest))


def middle_in_mpmath(value: arb | acb) -> Mpf:
    """Return the middle of a ball as a number of `mp`, exactly."""
    if isinstance(value, acb):
        real = middle_in_mpmath(value.real)
        imaginary = middle_in_mpmath(value.imag)
        if imaginary:
            return mp.make_mpc((real._mpf_, imaginary._mpf_))
        return real
    mantissa, exponent = value.mid().man_exp()
    return mp.ldexp(int(mantissa), int(exponent))


def ball_of_mpmath(value: Mpf, error: Mpf | int = 0) -> acb:
    """Return a ball around a number of mpmath, real or complex."""

    def exactly(part: Mpf | int) -> arb:
        sign, mantissa, exponent, _ = mp.mpmathify(part)._mpf_
        return arb(((-1) ** sign * int(mantissa), int(exponent)))

    real = mp.re(value)
    imaginary = mp.im(value)
    return acb(arb(exactly(real), exactly(error)), arb(exactly(imaginary), exactly(error)) if imaginary else 0)
