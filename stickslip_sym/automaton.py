"""The event-driven stick/slip automaton.

Three states: stick, slip slower than the belt, slip faster than the belt. Slip is integrated
(`slip.follow`, or another engine); stick is not, as it is known: x' = V exactly, until static friction gives way.
"""

from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from stickslip_sym.engines import follower
from stickslip_sym.errors import InputError, NotConverged
from stickslip_sym.friction import FrictionLaw
from stickslip_sym.oscillator import Oscillator, Scene, check_rtol, real
from stickslip_sym.slip import Point, SlipPhase

__all__ = ["Event", "Phase", "Trajectory", "simulate"]

_MOST_PHASES = 100_000


class Phase(Enum):
    """What the contact does."""

    STICK = "stick"
    SLIP_BACK = "slip, slower than the belt"
    SLIP_FORWARD = "slip, faster than the belt"


@dataclass(frozen=True)
class Event:
    """A change of phase: the time in s, the state in m and m/s, and the phase that begins."""

    t: float
    x: float
    v: float
    begins: Phase


@dataclass(frozen=True)
class Trajectory:
    """A motion of the mass.

    Attributes
    ----------
    t : numpy.ndarray
        Times in s, ascending, at the integrator's steps and at every event.
    x, v : numpy.ndarray
        Displacement in m and velocity in m/s at these times.
    phase : numpy.ndarray of Phase
        The phase in which each sample lies; a sample at an event belongs to the phase that ends there.
    events : tuple of Event
    """

    t: Any
    x: Any
    v: Any
    phase: Any
    events: tuple[Event, ...]

    def starts_of(self, phase: Phase) -> Any:
        """Return the times at which a phase began."""
        return np.array([event.t for event in self.events if event.begins is phase])


def simulate(
    law: FrictionLaw,
    osc: Oscillator,
    *,
    t_end: float,
    x0: float = 0.0,
    v0: float | None = None,
    rtol: float = 1e-10,
    engine: str = "scipy",
) -> Trajectory:
    """Integrate m x'' + c x' + k x = friction from x(0) = x0, x'(0) = v0, events included.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    osc : Oscillator
    t_end : float
        Duration in s, positive.
    x0 : float
        Initial displacement in m.
    v0 : float, optional
        Initial velocity in m/s; the belt speed if not given.
    rtol : float
        Relative tolerance of a step, 1e-13 to 1e-3.
    engine : {"scipy", "heyoka"}
        What integrates the slip phases. "heyoka" is faster, for smooth laws that are not stiff; it needs
        ``pip install 'stickslip_sym[fast]'``.

    Returns
    -------
    Trajectory

    Raises
    ------
    InputError
        For unusable numbers, an unbound law, or an engine that is not there or cannot take the law.
    NotConverged
        When the bound on the work is reached.
    """
    follow = follower(engine)
    t_end, x0, v0 = real("t_end", t_end), real("x0", x0), real("v0", osc.V if v0 is None else v0)
    if t_end <= 0:
        raise InputError(f"t_end = {t_end:g} must be positive")
    check_rtol(rtol)
    scene = Scene.of(law, osc)
    recorder = _Recorder(law, osc)
    horizon = t_end * osc.omega
    tau, q, w = 0.0, recorder.q_of(x0), (osc.V - v0) / osc.V
    side = 1 if w > 0 else -1
    for _ in range(_MOST_PHASES):
        if tau >= horizon:
            return recorder.trajectory()
        if w == 0 and scene.sticks(q) and q < 0:
            end = min(horizon, tau - q)
            recorder.stick(tau, q, end)
            tau, q = end, (0.0 if end < horizon else q + end - tau)
            continue
        if w == 0:  # at P, or beyond what static friction holds on either side
            side = 1 if q >= 0 else -1
        phase = follow(scene, Point(tau, q, abs(w)), side, horizon=horizon, rtol=rtol)
        recorder.slip(phase)
        if phase.end == "rest":
            recorder.rest(horizon, osc.N * float(law.mu(osc.V)) / osc.k)
            return recorder.trajectory()
        tau, q, w = phase.last.tau, phase.last.q, phase.last.w
    raise NotConverged(f"over {_MOST_PHASES} phases before t_end = {t_end:g} s; simulate a shorter time")


class _Recorder:
    """Collects phases and gives them their units back."""

    def __init__(self, law: FrictionLaw, osc: Oscillator) -> None:
        self.osc = osc
        self.length = osc.length
        self.x_onset = osc.onset(law)
        self.samples: list[tuple[Any, Any, Any, Phase]] = []
        self.events: list[Event] = []

    def q_of(self, x: float) -> float:
        return (x - self.x_onset) / self.length

    def stick(self, tau: float, q: float, end: float) -> None:
        # Two samples hold all there is to a straight line.
        times = np.array([tau, end])
        self._add(times, q + times - tau, np.zeros(2), 1, Phase.STICK)

    def slip(self, phase: SlipPhase) -> None:
        start = phase.pieces[0].t_old
        ends = [piece.t for piece in phase.pieces if piece.t < phase.last.tau]
        times = np.array([start, *ends, phase.last.tau])
        q, w = phase.at(times)
        q[-1], w[-1] = phase.last.q, phase.last.w
        self._add(times, q, w, phase.side, Phase.SLIP_BACK if phase.side > 0 else Phase.SLIP_FORWARD)

    def rest(self, end: float, x: float) -> None:
        """Prolong a slip phase that came to rest at x, which is known better than integrated."""
        self.samples.append((np.array([end / self.osc.omega]), np.array([x]), np.zeros(1), self.samples[-1][3]))

    def _add(self, tau: Any, q: Any, w: Any, side: int, phase: Phase) -> None:
        t, x, v = tau / self.osc.omega, self.x_onset + self.length * q, self.osc.V * (1 - side * w)
        self.samples.append((t, x, v, phase))
        self.events.append(Event(float(t[0]), float(x[0]), float(v[0]), phase))

    def trajectory(self) -> Trajectory:
        t, x, v = (np.concatenate(parts) for parts in list(zip(*self.samples, strict=True))[:3])
        phase = np.concatenate([np.full(part[0].size, part[3], dtype=object) for part in self.samples])
        return Trajectory(t, x, v, phase, tuple(self.events))
