"""Every pure-slip limit cycle of an oscillator, for every law: the roots of d(A) = c/sqrt(k m) in (0, 1].

The damping d(A) that a slip orbit of amplitude A V needs is resolved by `damping`: all cycles are read from it,
also where it is not monotone. A cycle is stable where d falls.
"""

import math
from dataclasses import dataclass, replace

from stickslip_sym.core import deadline
from stickslip_sym.core.numbers import LARGEST, ROOT_OF_ROUNDING
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.kernel.slip_data import TIGHT, SlipEnd
from stickslip_sym.motion.orbits.damping import NeededDamping, needed_damping
from stickslip_sym.motion.orbits.needed import PARTED, forward_and_backward_orbit
from stickslip_sym.motion.slip import NondimensionalOscillator
from stickslip_sym.output.data import DataResult
from stickslip_sym.output.shown import Shown


@dataclass(frozen=True)
class LimitCycle(Shown, DataResult):
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

    @classmethod
    def of(cls, osc: Oscillator, A: float, period: float, factor: float) -> "LimitCycle":
        """Return a cycle from its amplitude over V, its period in 1/omega, and how deviations grow in a round."""
        floquet = math.log(max(factor, 1 / LARGEST)) / period
        return cls(A * osc.V, period / osc.omega, floquet * osc.omega, floquet < 0)

    def __str__(self) -> str:
        return f"pure slip with a highest velocity of {self.amplitude:.6g} m/s, period {self.period:.6g} s"

    def __repr__(self) -> str:
        kind = "stable" if self.stable else "unstable"
        return f"LimitCycle: {self}, {kind}, Floquet exponent {self.floquet:.6g} 1/s"


def limit_cycles(
    law: FrictionLaw | str, osc: Oscillator, *, time_limit: float | None = None
) -> tuple[LimitCycle, ...]:
    """Return every pure-slip limit cycle of an oscillator, by ascending amplitude.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    osc : Oscillator
    time_limit : float, optional
        Seconds of computation after which it is given up.

    Returns
    -------
    tuple of LimitCycle
        All whose amplitude lies between a thousandth of the belt's speed and the belt's speed: they are the roots
        of polynomials that resolve the damping that slip orbits need. Empty if there is none, or if all orbits are
        periodic, as without friction and damping.

    Raises
    ------
    InputError
        For an unbound law, and where orbits leave the speeds at which it was measured.
    NotConverged
        If friction is too strong, or the law too rough, for the bound on the work; it names the amplitudes at
        which cycles may be missed.
    OutOfTime
        When the time limit is reached.

    Examples
    --------
    >>> from stickslip_sym import Oscillator, laws, limit_cycles
    >>> (cycle,) = limit_cycles(laws.exponential.typical(), Oscillator(m=1, k=100, c=2.3, V=0.5, N=9.81))
    >>> f"{cycle.amplitude:.6f} m/s, {'stable' if cycle.stable else 'unstable'}"
    '0.376589 m/s, unstable'
    """
    law = as_law(law)
    with deadline.time_limit(time_limit):
        need = needed_damping(law, osc)
        return tuple(_cycle(need, osc, A, falls) for A, falls in need.cycles(2 * osc.zeta))


def _cycle(need: NeededDamping, osc: Oscillator, A: float, stable: bool) -> LimitCycle:
    """Return the cycle of an amplitude: two motions side by side part or close up by the ratio of their wedges."""
    system = need.system
    ahead, back = forward_and_backward_orbit(
        system.rise, system.eta, osc.zeta, 0.0, A, TIGHT, system.difference, 1.0
    )
    deadline.check_time()
    if A == 1.0 and stable:
        # It slips so slowly beside the belt's speed that it all but sticks: what differs at first is lost there.
        return replace(LimitCycle.of(osc, A, _round_time(replace(system, zeta=osc.zeta)), 0.0), stable=True)
    # A wedge is 0 where its half slides along a jump of mu. Forward, the motions beside it come to lie on it;
    # backward, it is one from which those beside it part at once.
    factor = min(ahead.wedge / max(back.wedge, 1 / LARGEST), LARGEST)
    if abs(need.mismatch(A, 2 * osc.zeta)) > PARTED:
        # The orbit touches a speed where mu jumps, and d steps past the damping that there is. Where it rises
        # those inside shrink, and the jump throws those outside on; where it falls both come to slide along it.
        factor = 0.0 if need.mismatch(A * (1 - ROOT_OF_ROUNDING), 2 * osc.zeta) > 0 else math.inf
    return replace(LimitCycle.of(osc, A, ahead.tau + back.tau, factor), stable=stable)


def _round_time(system: NondimensionalOscillator) -> float:
    """Return how long it takes from where a mass stands still after the slip from P to where it does so again."""
    top = system.slip(0.0, 0.0, until=SlipEnd.MAXIMUM)
    stands = system.slip(top.q, top.w, until=SlipEnd.LEVEL, level=1.0)
    low = system.slip(stands.q, stands.w, until=SlipEnd.MINIMUM)
    top = system.slip(low.q, low.w, until=SlipEnd.MAXIMUM)
    return low.tau + top.tau + system.slip(top.q, top.w, until=SlipEnd.LEVEL, level=1.0).tau
