"""Every pure-slip limit cycle of an oscillator.

The damping that a slip orbit needs is a function d(A) of its highest velocity A V (`orbit`), so the limit cycles
are the roots of d(A) = c/sqrt(k m) in (0, 1]: all of them, also where d is not monotone. To leading order d(A) is
the harmonic balance, the mean of g(A cos(theta)) with the weight sin(theta)^2 over a period, where
g(z) = -N mu'(V (1 - z))/sqrt(k m). Here d itself is interpolated by a Chebyshev polynomial, whose roots are all
found and then improved on the orbits.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from stickslip_sym.core import deadline
from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import InputError, NotConverged
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.orbits.collocation import Work
from stickslip_sym.motion.orbits.orbit import Orbits, obstacle, orbits
from stickslip_sym.output import markup

__all__ = ["LimitCycle", "NeededDamping", "cycles_among", "limit_cycles", "needed_damping"]

_DEGREES = (16, 32, 64, 128)
_RESOLVED = 1e-9  # of the highest coefficients of d(A), relative to its variation
_FLAT = 1e-12  # variation of d over the largest slope, below which no orbit is isolated
_IMPROVED = 3  # times, by Newton's method
_REAL = 1e-6  # imaginary part of a root, from rounding where two nearly meet
_NEAR = 1e-6  # amplitude by which an interpolant's root may be off
_AT_REST = 1e-6  # amplitude below which a root is the equilibrium itself


@dataclass(frozen=True)
class LimitCycle:
    """A periodic motion in pure slip.

    Attributes
    ----------
    amplitude : float
        Highest velocity of the mass in m/s; above the belt's where a motion overtakes it and does not stick.
    period : float
        In s.
    floquet : float
        Floquet exponent in 1/s, the mean of (-N mu'(V - x') - c)/m over the cycle: small deviations grow by it.
    stable : bool
        Whether it is negative.
    """

    amplitude: float
    period: float
    floquet: float
    stable: bool

    def __str__(self) -> str:
        return f"pure slip with a highest velocity of {self.amplitude:.6g} m/s, period {self.period:.6g} s"

    def __repr__(self) -> str:
        kind = "stable" if self.stable else "unstable"
        return f"LimitCycle: {self}, {kind}, Floquet exponent {self.floquet:.6g} 1/s"

    def _repr_html_(self) -> str:
        rows = [
            ["highest velocity", f"{self.amplitude:.9g}", "m/s"],
            ["period", f"{self.period:.9g}", "s"],
            ["Floquet exponent", f"{self.floquet:.9g}", "1/s"],
        ]
        kind = "stable" if self.stable else "unstable"
        return markup.table(["quantity", "value", "unit"], rows, caption=f"{kind} pure-slip limit cycle")


@dataclass(frozen=True)
class NeededDamping:
    """The damping d(A) that a slip orbit needs, over sqrt(k m), as a function of its amplitude A V."""

    series: FloatArray  # Chebyshev coefficients of d on 0 <= A <= 1; one coefficient if d does not vary

    def at(self, amplitude: ArrayLike) -> FloatArray:
        """Return d at amplitudes over the belt speed; d(0) is the Hopf bifurcation, d(1) the graze."""
        return chebyshev.chebval(2 * np.asarray(amplitude) - 1, self.series)

    def slope(self, amplitude: ArrayLike) -> FloatArray:
        """Return d'(A): an orbit is stable where it is negative."""
        return chebyshev.chebval(2 * np.asarray(amplitude) - 1, chebyshev.chebder(self.series)) * 2

    def amplitudes(self, damping: float) -> FloatArray:
        """Return the amplitudes, over the belt speed, ascending, of all orbits with a damping over sqrt(k m)."""
        return _roots(chebyshev.chebsub(self.series, [damping]))

    @property
    def folds(self) -> FloatArray:
        """The amplitudes at which d turns: a stable and an unstable orbit meet there."""
        return _roots(chebyshev.chebder(self.series))


def needed_damping(law: FrictionLaw, osc: Oscillator, *, most_work: float = math.inf) -> NeededDamping:
    """Return the damping that slip orbits need, as a function of their amplitude; the oscillator's c is not used.

    - `most_work`: as for `orbits`, of all orbits together.

    Raises `InputError` or `NotConverged` as `limit_cycles` does.
    Raises `OutOfTime` when the time of a `time_limit` around it is up.
    """
    found = _needed(law, osc.V, osc.N / osc.impedance, most_work)
    if isinstance(found, NeededDamping):
        return found
    raise type(found)(*found.args)  # raised itself, it would keep the frames of every time


def limit_cycles(law: FrictionLaw, osc: Oscillator, *, time_limit: float | None = None) -> tuple[LimitCycle, ...]:
    """Return every pure-slip limit cycle of an oscillator, by ascending amplitude.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound, smooth on the speeds of the motion.
    osc : Oscillator
    time_limit : float, optional
        Seconds of computation after which it is given up.

    Returns
    -------
    tuple of LimitCycle
        Empty if there is none, or if all orbits are periodic, as without friction and damping.

    Raises
    ------
    InputError
        For a law with a kink in reach.
    NotConverged
        If the orbits are not found, since friction is too strong, or vary too fast with the amplitude.
    OutOfTime
        When the time limit is reached.
    """
    with deadline.time_limit(time_limit):
        return cycles_among(needed_damping(law, osc), law, osc)


def cycles_among(need: NeededDamping, law: FrictionLaw, osc: Oscillator) -> tuple[LimitCycle, ...]:
    """Return the limit cycles among slip orbits whose damping is known as a function of the amplitude."""
    solve = _solver(law, osc.V, osc.N / osc.impedance, Work(math.inf))
    damping = 2 * osc.zeta
    roots = need.amplitudes(damping)
    if not roots.size:
        return ()
    slope = need.slope(roots)
    for _ in range(_IMPROVED):
        with np.errstate(all="ignore"):
            step = (solve(roots).d - damping) / slope
        # Where two roots nearly meet the slope says nothing, and the interpolant's root is as good as any.
        roots = np.where(np.abs(step) < _NEAR, np.clip(roots - step, _AT_REST, 1.0), roots)
    found = solve(roots)
    return tuple(
        LimitCycle(
            amplitude=float(A * osc.V),
            period=2 * math.pi / float(frequency * osc.omega),
            floquet=float(exponent * osc.omega),
            stable=bool(exponent < 0),
        )
        for A, frequency, exponent in zip(roots, found.frequency, found.exponent, strict=True)
    )


@lru_cache(maxsize=64)
def _needed(
    law: FrictionLaw, V: float, strength: float, most_work: float
) -> NeededDamping | InputError | NotConverged:
    """Return the damping that orbits need, or why it is not found: either takes long, and is asked for again."""
    work = Work(most_work)
    try:
        return NeededDamping(_interpolated(_solver(law, V, strength, work), work))
    except (InputError, NotConverged) as error:
        return error.with_traceback(None)


def _solver(law: FrictionLaw, V: float, strength: float, work: Work) -> Callable[[FloatArray], Orbits]:
    """Return the function that finds the orbits of given amplitudes, within a bound on the work."""
    if reason := obstacle(law, V, jump=False):
        raise InputError(f"limit cycles need a law that is smooth: {reason}; try simulate()")

    def solve(A: FloatArray) -> Orbits:
        found = orbits(law, V, strength, A, most_work=work.left)
        work.done += found.work
        if not np.isfinite(found.error).all():
            lost = np.atleast_1d(A)[~np.isfinite(found.error)][0]
            raise NotConverged(
                f"no slip orbit of amplitude {lost * V:g} m/s was found: friction is too strong, or its law "
                "not smooth enough at v = 0, for the bound on work; try simulate()"
            )
        if reason := obstacle(law, V, float(found.lowest.min()), jump=False):
            raise InputError(f"limit cycles need a law that is smooth: {reason}; try simulate()")
        return found

    return solve


def _interpolated(solve: Callable[[FloatArray], Orbits], work: Work) -> FloatArray:
    """Return Chebyshev coefficients of d(A) on [0, 1]."""
    for degree in _DEGREES:
        if 2 * work.done > work.left:  # twice as many orbits take twice as much again, or more
            break
        # Nodes of the first kind: A = 0, where there is no orbit, is none of them.
        nodes = chebyshev.chebpts1(degree + 1)
        found = solve((1 + nodes) / 2)
        from scipy.fft import dct

        need: FloatArray = dct(found.d[::-1]) / (degree + 1)
        need[0] /= 2
        variation = np.ptp(found.d)
        if variation <= _FLAT * found.scale.max():
            return need[:1]
        if np.abs(need[-degree // 8 :]).max() <= _RESOLVED * variation:
            return need
    raise NotConverged(
        f"the damping of slip orbits varies too fast with their amplitude for a polynomial of degree {degree}; "
        "the law may be steep near v = 0: try simulate()"
    )


def _roots(coefficients: FloatArray) -> FloatArray:
    """Return the roots in (0, 1] of a Chebyshev series on it, ascending."""
    if len(coefficients) < 2:
        return np.empty(0)
    found = (1 + chebyshev.chebroots(coefficients)) / 2
    real = found.real[np.abs(found.imag) <= _REAL]
    return np.sort(real[(real > _AT_REST) & (real <= 1)])
