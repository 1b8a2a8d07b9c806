"""The transit from P: the one slip phase that decides whether there is stick-slip.

Every forward stick phase ends at the same point P, at the belt's speed. So the slip phase that leaves P
either comes back to the belt's speed, and is the whole cycle together with the stick phase that follows,
or never does: orbits in a plane do not cross, so an orbit that misses once stays inside.
"""

from dataclasses import dataclass

from stickslip_sym.errors import NotConverged
from stickslip_sym.friction import FrictionLaw
from stickslip_sym.oscillator import Oscillator, Scene
from stickslip_sym.slip import Point, SlipPhase, check_rtol, follow

__all__ = ["StickSlipCycle", "lowest_slip_speed", "peak_velocity", "stick_slip_cycle"]

_LONGEST = 1e4  # of dimensionless time; a motion without a turn by then creeps to rest
_P = Point(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class StickSlipCycle:
    """The periodic motion of stick and slip.

    Attributes
    ----------
    period, stick_time, slip_time : float
        In s.
    x_min, x_max : float
        Extreme displacements in m.
    v_min : float
        Lowest velocity in m/s; the highest is the belt speed.
    """

    period: float
    stick_time: float
    slip_time: float
    x_min: float
    x_max: float
    v_min: float


def stick_slip_cycle(law: FrictionLaw, osc: Oscillator, *, rtol: float = 1e-12) -> StickSlipCycle | None:
    """Return the stick-slip cycle of an oscillator, or None if it has none.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    osc : Oscillator
    rtol : float
        Relative tolerance of an integration step, 1e-13 to 1e-3.

    Raises
    ------
    InputError
        For an unbound law or an unusable tolerance.
    NotConverged
        When the bound on the work is reached.
    """
    check_rtol(rtol)
    scene = Scene.of(law, osc)
    slip = follow(scene, _P, 1, horizon=_LONGEST, rtol=rtol, until="turn")
    if slip.end != "return" or not scene.sticks(slip.last.q):
        return None
    stick = -slip.last.q
    # The mass stands still where its slip speed is the belt's, w = 1.
    places = [osc.onset(law) + osc.length * q for q in (slip.last.q, 0.0, *_rests(slip))]
    return StickSlipCycle(
        period=(slip.last.tau + stick) / osc.omega,
        stick_time=stick / osc.omega,
        slip_time=slip.last.tau / osc.omega,
        x_min=min(places),
        x_max=max(places),
        v_min=osc.V * (1 - max(point.w for point in slip.extrema)),
    )


def _rests(slip: SlipPhase) -> list[float]:
    return [point.q for point in slip.crossings(1.0)]


def peak_velocity(law: FrictionLaw, osc: Oscillator, *, rtol: float = 1e-12) -> float:
    """Return the velocity in m/s at the peak that follows the slip from P.

    It is below the belt speed where the mass misses it, and above where it returns: there the slip is
    followed past its end, with mu continued along its tangent at v = 0. Its root minus V, as a function
    of the damping, is the pure-slip threshold.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    osc : Oscillator
    rtol : float
        Relative tolerance of an integration step, 1e-13 to 1e-3.

    Raises
    ------
    NotConverged
        If the motion has no peak: an overdamped mass creeps to rest.
    """
    check_rtol(rtol)
    lowest = lowest_slip_speed(Scene.of(law, osc), rtol)
    if lowest is None:
        raise NotConverged(f"the velocity has no peak after slip from P: the damping ratio is {osc.zeta:g}")
    return osc.V * (1 - lowest)


def lowest_slip_speed(scene: Scene, rtol: float) -> float | None:
    """Return the first minimum of w after P, negative beyond a return; None if w has no minimum."""
    slip = follow(scene, _P, 1, horizon=_LONGEST, rtol=rtol, until="minimum")
    return slip.last.w if slip.end == "minimum" else None
