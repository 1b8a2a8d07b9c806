"""The transit from P: the one slip phase that decides whether there is stick-slip.

Every forward stick phase ends at the same point P, at the belt's speed. So the slip phase that leaves P
either comes back to the belt's speed, and is the whole cycle together with the stick phase that follows,
or never does: orbits in a plane do not cross, so an orbit that misses once stays inside. Where damping and
friction are weak, or damping feeds energy in, it can come back beyond what static friction holds. The mass then
overtakes the belt, and if that slip does not end in stick either, the motion lies outside its first round from
then on: it never sticks again, and slips on both sides of the belt's speed.
"""

import math
from dataclasses import dataclass, fields

from stickslip_sym.core import deadline
from stickslip_sym.core.errors import NotConverged
from stickslip_sym.core.numbers import read_rtol
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator, Scene
from stickslip_sym.motion.simulation import engines
from stickslip_sym.motion.simulation.levels import Levels
from stickslip_sym.motion.simulation.slip import follow
from stickslip_sym.motion.simulation.slip_phase import End, SlipPhase
from stickslip_sym.motion.simulation.steppers import Point
from stickslip_sym.output import markup

__all__ = ["StickSlipCycle", "horizon", "lowest_slip_speed", "peak_velocity", "stick_slip_cycle"]

_LONGEST = 1e4  # decay times; a motion without a turn by then creeps to rest
_P = Point(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class StickSlipCycle:
    """The periodic motion of stick and slip.

    One stick phase, one slip slower than the belt, and, where the mass returns beyond what static friction
    holds, one slip faster than the belt.

    Attributes
    ----------
    period, stick_time, slip_time : float
        In s; `slip_time` is all slip.
    x_min, x_max : float
        Extreme displacements in m.
    v_min, v_max : float
        Extreme velocities in m/s; the highest is the belt speed unless the mass overtakes the belt.
    """

    period: float
    stick_time: float
    slip_time: float
    x_min: float
    x_max: float
    v_min: float
    v_max: float

    def __str__(self) -> str:
        return f"stick-slip of period {self.period:.6g} s, of which stick {self.stick_time:.6g} s"

    def __repr__(self) -> str:
        return (
            f"StickSlipCycle: {self}; x from {self.x_min:.6g} to {self.x_max:.6g} m, "
            f"v from {self.v_min:.6g} to {self.v_max:.6g} m/s"
        )

    def _repr_html_(self) -> str:
        units = {"period": "s", "stick_time": "s", "slip_time": "s", "x_min": "m", "x_max": "m"}
        rows = [[f.name, f"{getattr(self, f.name):.9g}", units.get(f.name, "m/s")] for f in fields(self)]
        return markup.table(["quantity", "value", "unit"], rows, caption="stick-slip cycle")


def stick_slip_cycle(
    law: FrictionLaw,
    osc: Oscillator,
    *,
    rtol: float = 1e-12,
    engine: str = "scipy",
    time_limit: float | None = None,
) -> StickSlipCycle | None:
    """Return the stick-slip cycle of an oscillator, or None if it has none.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    osc : Oscillator
    rtol : float
        Relative tolerance of an integration step, 1e-13 to 1e-3.
    engine : {"scipy", "heyoka"}
        What integrates the slip, as for `simulate`.
    time_limit : float, optional
        Seconds of computation after which it is given up.

    Raises
    ------
    InputError
        For an unbound law, an unusable tolerance, or an engine that is not there or cannot take the law.
    NotConverged
        When the bound on the work is reached.
    OutOfTime
        When the time limit is reached.
    """
    chosen = engines.find(engine)
    rtol = read_rtol(rtol)
    with deadline.time_limit(time_limit):
        return _cycle(law, osc, chosen, rtol)


def _cycle(law: FrictionLaw, osc: Oscillator, engine: engines.Engine, rtol: float) -> StickSlipCycle | None:
    scene = Scene.of(law, osc)
    slips = [_from_onset(scene, rtol, engine)]
    if slips[0].end is not End.RETURN:
        return None
    if not scene.sticks(slips[0].last.q):
        overtaking = slips[0].last
        latest = overtaking.tau + horizon(scene)
        slips.append(follow(scene, overtaking, -1, horizon=latest, rtol=rtol, engine=engine))
    end = slips[-1].last
    if slips[-1].end is not End.RETURN or not scene.sticks(end.q):
        return None
    # The mass stands still where its slip speed is the belt's, w = 1.
    rests = [point.q for point in slips[0].crossings(1.0)]
    onset = osc.onset(law)
    places = [onset + osc.length * q for q in (0.0, end.q, slips[0].last.q, *rests)]
    speeds = [slip.side * point.w for slip in slips for point in slip.extrema]
    return StickSlipCycle(
        period=(end.tau - end.q) / osc.omega,
        stick_time=-end.q / osc.omega,
        slip_time=end.tau / osc.omega,
        x_min=min(places),
        x_max=max(places),
        v_min=osc.V * (1 - max(speeds)),
        v_max=osc.V * (1 - min(0.0, *speeds)),
    )


def _from_onset(scene: Scene, rtol: float, engine: engines.Engine) -> SlipPhase:
    return follow(scene, _P, 1, horizon=horizon(scene), rtol=rtol, until=End.MINIMUM, engine=engine)


def horizon(scene: Scene) -> float:
    """Return how long to wait for the end of a slip phase, in dimensionless time."""
    return _LONGEST * max(1.0, 2 * abs(scene.zeta))


def peak_velocity(law: FrictionLaw, osc: Oscillator, *, rtol: float = 1e-12, engine: str = "scipy") -> float:
    """Return the velocity in m/s at the peak that follows the slip from P, above V where the mass returns.

    The mass that misses the belt's speed has its peak below. One that returns, with the velocity V and an
    acceleration a, has none, and V + a^2/(2 omega^2 V) stands for it: by so much it would overshoot if the
    spring alone went on to pull, and near a graze that continues the peak with its value and its slope.
    The root of the result minus V, as a function of the damping, is the pure-slip threshold.

    Parameters
    ----------
    law, osc, rtol, engine
        As for `stick_slip_cycle`.

    Raises
    ------
    InputError
        For an unbound law, an unusable tolerance, or an engine that is not there or cannot take the law.
    NotConverged
        If the motion has no peak, since the mass creeps to rest, or when the bound on the work is reached.
    """
    rtol = read_rtol(rtol)
    lowest = lowest_slip_speed(Scene.of(law, osc), rtol, engine)
    if lowest == -math.inf:
        raise NotConverged("the velocity has no peak after the slip from P, it falls for ever; try a larger c")
    if lowest is None:
        raise NotConverged(
            f"the velocity has no peak after the slip from P, the mass creeps to rest: the damping ratio is "
            f"{osc.zeta:g}; try a smaller c"
        )
    return osc.V * (1 - lowest)


def lowest_slip_speed(
    scene: Scene, rtol: float, engine: str = "scipy", levels: Levels | None = None
) -> float | None:
    """Return the first minimum of w after P, or -w'^2/2 at a return; None if the mass creeps to rest.

    - `levels`: of this scene at any damping, where they may be tried before the engine.

    Where it neither turns nor returns, but moves away for ever, it is -infinity, as after the hardest return.
    At a graze w'' = 1, so -w'^2/2 continues the minimum through 0 with its value and its slope.
    """
    found = levels.lowest(scene.zeta, rtol) if levels else None
    if found is not None:
        return found
    slip = _from_onset(scene, rtol, engines.find(engine))
    if slip.end is End.RETURN:
        return -(scene.acceleration(slip.last.q, 0.0, 1) ** 2) / 2
    if slip.end is End.UNBOUNDED:
        return -math.inf
    return slip.last.w if slip.end is End.MINIMUM else None
