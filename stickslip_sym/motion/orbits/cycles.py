"""Every pure-slip limit cycle of an oscillator, for every law.

The damping that a slip orbit needs is a function d(A) of its highest velocity A V (`needed`), so the limit cycles
are the roots of d(A) = c/sqrt(k m) in (0, 1]: all of them, also where d is not monotone. At a damping the gap of
the halves of an orbit has the sign of d(A) - c/sqrt(k m), so d itself need not be known.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core import deadline
from stickslip_sym.core.aliases import FloatArray, IntArray
from stickslip_sym.core.errors import NotConverged
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.orbits.needed import PARTED, ROUNDING, halves, needed_ratio, sure_gap
from stickslip_sym.motion.roots import NEAREST, closest, orbit_signs, sign_changes
from stickslip_sym.motion.slip import Dimensionless
from stickslip_sym.motion.steps import TIGHT
from stickslip_sym.output import markup

_NEUTRAL = 3e-12  # gap below which an orbit is periodic within the errors of the steps
_BESIDE = 1e-7  # distance from an orbit over its amplitude: by its square the gap changes beside a fold
_STRONGEST = 1e-300  # contraction in a round, or backward, that is distinguished from 0


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

    @classmethod
    def of(cls, osc: Oscillator, A: float, period: float, factor: float) -> "LimitCycle":
        """Return a cycle from its amplitude over V, its period in 1/omega, and how deviations grow in a round."""
        floquet = math.log(max(factor, _STRONGEST)) / period
        return cls(A * osc.V, period / osc.omega, floquet * osc.omega, floquet < 0)

    def __str__(self) -> str:
        return f"pure slip with a highest velocity of {self.amplitude:.6g} m/s, period {self.period:.6g} s"

    def __repr__(self) -> str:
        kind = "stable" if self.stable else "unstable"
        return f"LimitCycle: {self}, {kind}, Floquet exponent {self.floquet:.6g} 1/s"

    def _repr_html_(self) -> str:
        units = {"amplitude": "m/s", "period": "s", "floquet": "1/s"}
        rows = [[name, f"{getattr(self, name):.9g}", unit] for name, unit in units.items()]
        kind = "stable" if self.stable else "unstable"
        return markup.table(["quantity", "value", "unit"], rows, caption=f"{kind} pure-slip limit cycle")


@dataclass(frozen=True)
class NeededDamping:
    """The damping d(A) that a slip orbit needs, over sqrt(k m), as a function of its amplitude A V.

    - `system`: without a static excess, which no orbit in slip meets.
    """

    system: Dimensionless

    def at(self, amplitude: ArrayLike) -> FloatArray:
        """Return d at amplitudes over the belt speed; d(0) is the Hopf bifurcation, d(1) the graze."""
        A, hopf = np.asarray(amplitude, dtype=np.float64), -replace(self.system, zeta=0.0).decay(1.0)
        d = [hopf if one < NEAREST else 2 * needed_ratio(self.system, one)[0] for one in A.ravel().tolist()]
        return np.array(d).reshape(A.shape)

    def gap(self, A: float, damping: float) -> float:
        """Return the gap of an orbit at a damping over sqrt(k m), of the sign of d(A) - damping."""
        system = self.system
        value, _ = sure_gap(system.rise, system.eta, damping / 2, 0.0, A, TIGHT, tuple(system.no_wedge))
        deadline.check_time()
        if math.isnan(value):
            raise NotConverged(
                f"the slip orbit of amplitude {A * system.V:g} m/s takes too many steps: friction is too strong; "
                "try simulate()"
            )
        return 0.0 if abs(value) <= _NEUTRAL else float(value)

    def amplitudes(self, damping: float) -> FloatArray:
        """Return the amplitudes, over the belt speed, ascending, of all orbits with a damping over sqrt(k m)."""
        gaps = dict[float, float]()

        def gap(A: float) -> float:
            gaps[A] = self.gap(A, damping)
            return gaps[A]

        def clipped(_: IntArray, amplitudes: FloatArray) -> FloatArray:
            return np.clip([gap(A) for A in amplitudes.tolist()], -1.0, 1.0)

        found = orbit_signs(clipped, np.zeros(1, dtype=bool))
        for _, low, high in found.open:  # beside a fold: the gap may change its sign twice
            closest(gap, low, high, math.copysign(1.0, gap(low)), _BESIDE)
        nodes = sorted(gaps)
        return np.array(list(sign_changes(gap, nodes, [gaps[A] for A in nodes], ROUNDING)))


def needed_damping(law: FrictionLaw, osc: Oscillator) -> NeededDamping:
    """Return the damping that slip orbits need as a function of their amplitude; the c of `osc` is not used."""
    system = Dimensionless.of(law, osc)
    return NeededDamping(replace(system, table=replace(system.table, static=system.table.onset)))


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
        Empty if there is none, or if all orbits are periodic, as without friction and damping. Cycles slower than
        a thousandth of the belt's speed are not looked for.

    Raises
    ------
    InputError
        For an unbound law.
    NotConverged
        If friction is too strong for the bound on the work.
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
        return tuple(_cycle(need, osc, A) for A in need.amplitudes(2 * osc.zeta).tolist())


def _cycle(need: NeededDamping, osc: Oscillator, A: float) -> LimitCycle:
    """Return the cycle of an amplitude: two motions side by side part or close up by the ratio of their wedges."""
    system = need.system
    ahead, back, _ = halves(system.rise, system.eta, osc.zeta, 0.0, A, TIGHT, True, 1.0, tuple(system.no_wedge))
    deadline.check_time()
    # A wedge is 0 where its half slides along a jump of mu. Forward, the motions beside it come to lie on it;
    # backward, it is one from which those beside it part at once.
    factor = min(ahead[2] / max(back[2], _STRONGEST), 1 / _STRONGEST)
    if abs(need.gap(A, 2 * osc.zeta)) > PARTED:
        # The orbit touches a speed where mu jumps, and d steps past the damping that there is. Where it rises
        # those inside shrink, and the jump throws those outside on; where it falls both come to slide along it.
        factor = 0.0 if need.gap(A * (1 - _BESIDE), 2 * osc.zeta) > 0 else math.inf
    return LimitCycle.of(osc, A, ahead[3] + back[3], factor)
