"""The paper's laws and oscillator, and what several checks need of them, computed once in each process."""

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import sympy as sp
from scipy.interpolate import BPoly, PPoly

from stickslip_sym import (
    FrictionLaw,
    NoClosedForm,
    NotConverged,
    Oscillator,
    Phase,
    derive,
    laws,
    simulate,
    stick_slip_cycle,
    symbols,
)
from stickslip_sym.formula.closed_form import ClosedForm
from stickslip_sym.formula.proof.normal_form import normal_form
from stickslip_sym.motion.orbits.damping import NeededDamping, needed_damping
from stickslip_sym.motion.simulation.trajectory import Trajectory
from stickslip_sym.motion.thresholds.methods import methods
from stickslip_sym.motion.thresholds.operating_points import OperatingPoints

LAWS = ("exponential", "polynomial")
SPEEDS = np.arange(1, 101) / 100
"""The belt speeds of Figs. 6, 7 and 10, in m/s."""
AT_05 = 49
"""Where V = 0.5 m/s is among them, the speed of section 3."""

_EXACT = 1e-9  # kg/s, error of a threshold here
_CLOSE = 1e-10  # relative error that is asked for
_PERIODS = 40  # simulated of a motion, about: 25 s, until it is steady
_STEADY = 0.01  # change of the velocity's peak in a period, over V, below which the eye calls it constant
_LOOKED_AT = 5  # periods after the first slip for which it has to stay below
_HAIR = 1e-7  # kg/s above a threshold, where the orbit closes to 1e-7
_PHASES = 512


@cache
def law(name: str, mu_m: str = "0.2") -> FrictionLaw:
    """Return one of the paper's two laws with the parameters of its section 3."""
    if name == "exponential":
        return laws.exponential.bind(mu_s="0.5", mu_m=mu_m, alpha="3")
    return laws.polynomial.bind(mu_s="0.5", mu_m=mu_m, v_m="1")


def oscillator(c: float = 0.0, V: float = 0.5, *, m: float = 1.0, k: float = 100.0) -> Oscillator:
    """Return the oscillator of the paper's section 3."""
    return Oscillator(m=m, k=k, c=c, V=V, N=9.81)


@cache
def thresholds(name: str, mu_m: str = "0.2", k: float = 100.0) -> Any:
    """Return the exact pure-slip damping in kg/s at each of `SPEEDS`."""
    found = _grazing(law(name, mu_m), SPEEDS, 1.0, k)
    found.setflags(write=False)
    return found


def over_speeds(expr: Any, name: str, speeds: Any = SPEEDS) -> Any:
    """Return a formula with the paper's parameters at belt speeds."""
    known = {law(name).parameters[given].symbol: value for given, value in law(name).values.items()}
    return np.broadcast_to(
        sp.lambdify(symbols.V, expr.subs(known | {symbols.N: oscillator().N}))(speeds), np.shape(speeds)
    )


@cache
def closed_form(name: str, criterion: str) -> ClosedForm | None:
    """Return a criterion of a law with symbols for all parameters, or None if it has no closed form."""
    try:
        return derive(laws.catalogue[name], criterion)
    except NoClosedForm:
        return None


def is_criterion(expr: Any, name: str, criterion: str) -> bool:
    """Return whether a formula is a criterion of a law."""
    form = closed_form(name, criterion)
    return form is not None and normal_form(expr - form.expr) == 0


@cache
def threshold(name: str, V: float = 0.5, m: float = 1.0, k: float = 100.0) -> float:
    """Return the exact pure-slip damping in kg/s at one operating point."""
    return float(_grazing(law(name), V, m, k)[0])


def _grazing(law: FrictionLaw, V: Any, m: float, k: float) -> Any:
    """Return the damping of the orbits that graze the belt's speed; unlike a threshold by name, also near 0."""
    found = methods()["orbit"].compute(OperatingPoints.of(law, V=V, N=oscillator().N, m=m, k=k), _CLOSE)
    errors = np.abs(found.value) * found.relative_error
    if not (errors <= _EXACT).all():
        raise NotConverged(f"a grazing orbit is known to {errors.max():.1e} kg/s only")
    return found.value


@cache
def needed(name: str) -> NeededDamping:
    """Return the damping, over sqrt(k m), of the slip orbits of every amplitude."""
    return needed_damping(law(name), oscillator())


@dataclass(frozen=True)
class Response:
    """A motion from the paper's initial condition, x(0) = 0 and x'(0) = V, over some forty periods.

    Its kind is "stick-slip" if the mass sticks again after it slipped. If not, "pure slip" where the peak of the
    velocity changes by less than 1 % of V in each of the first five periods, "damped slip" where it falls by more
    in each, and "other" if neither.
    """

    kind: str
    onsets: Any  # times in s at which slip began
    sticks: Any  # durations in s of the stick phases, after the first
    times: Any  # of the peaks of the velocity in s, P the first of them
    peaks: Any  # in m/s
    slip: PPoly  # displacement in m over time in s, in the slip that leaves P for the first time

    @property
    def period(self) -> float:
        """The last period seen, in s."""
        return float(self.times[-1] - self.times[-2])

    @property
    def swing(self) -> tuple[float, float]:
        """Peak to peak of displacement in m and velocity in m/s, in the first period after P."""
        t = np.linspace(self.times[0], min(self.times[1], self.slip.x[-1]), 2001)
        return float(np.ptp(self.slip(t))), float(np.ptp(self.slip(t, 1)))

    @property
    def after_a_cycle(self) -> float:
        """V_Q in m/s: the velocity with which the mass passes the place of P upward, after a cycle."""
        passes = self.slip.solve(self.slip(self.times[0]), extrapolate=False)
        upward = [t for t in passes[passes > self.times[0] + self.period / 2] if self.slip(t, 1) > 0]
        return float(self.slip(upward[0], 1)) if upward else float(self.peaks[1])


@cache
def response(name: str, c: float, V: float = 0.5) -> Response:
    """Return the motion at a damping and a belt speed."""
    osc = oscillator(c, V)
    motion = simulate(law(name), osc, t_end=_PERIODS * 2 * np.pi / osc.omega, rtol=1e-12)
    onsets, stops = motion.starts_of(Phase.SLIP_BACK), motion.starts_of(Phase.STICK)[1:]
    slip = _smooth(law(name), osc, motion, onsets[0], stops[0] if stops.size else np.inf)
    if stops.size:
        sticks = (onsets[1:] - stops[: onsets.size - 1]) if onsets.size > 1 else np.empty(0)
        return Response("stick-slip", onsets, sticks, onsets, np.full(onsets.size, V), slip)
    turns = slip.derivative(2).roots(extrapolate=False)
    quarter = 0.5 * np.pi / osc.omega
    highest = turns[(slip(turns, 3) < 0) & (turns > onsets[0] + quarter)]
    highest = highest[np.diff(highest, prepend=0) > quarter]  # a turn at a sample is a root of both polynomials
    times, peaks = np.r_[onsets[0], highest], np.r_[V, slip(highest, 1)]
    falls = -np.diff(peaks[: _LOOKED_AT + 1]) / V
    kind = "pure slip" if (abs(falls) < _STEADY).all() else "damped slip" if (falls > _STEADY).all() else "other"
    return Response(kind, onsets, np.empty(0), times, peaks, slip)


def _smooth(law: FrictionLaw, osc: Oscillator, motion: Trajectory, start: float, stop: float) -> PPoly:
    """Join the samples of a slip slower than the belt, with two derivatives from (2), by polynomials."""
    t, first = np.unique(motion.t, return_index=True)
    inside = (t >= start) & (t <= stop)
    t, x, v = t[inside], motion.x[first][inside], motion.v[first][inside]
    slip = np.maximum(osc.V - v, 0.0)
    a = (osc.N * law.mu(slip) - osc.c * v - osc.k * x) / osc.m
    jerk = (-osc.N * law.slope(slip) * a - osc.c * a - osc.k * v) / osc.m
    return PPoly.from_bernstein_basis(BPoly.from_derivatives(t, np.column_stack([x, v, a, jerk])))


@dataclass(frozen=True)
class Orbit:
    """The orbit that grazes the belt's speed, from simulation a hair above the exact threshold."""

    velocity: Any  # in m/s, at equispaced times of one period
    distortion: float  # root of the sum of squares of its overtones, over its fundamental
    gap: float  # change of the velocity over the period, in m/s


@cache
def orbit(name: str) -> Orbit:
    """Return the grazing orbit of a law."""
    run = response(name, threshold(name) + _HAIR)
    v = run.slip(np.linspace(run.times[0], run.times[1], _PHASES, endpoint=False), 1)
    sizes = abs(np.fft.rfft(v))
    gap = float(run.peaks[1] - run.peaks[0])
    return Orbit(v, float(np.linalg.norm(sizes[2:]) / sizes[1]), gap)


@cache
def sticks_and_slips(name: str, c: float, V: float = 0.5) -> bool:
    """Return whether the oscillator has a stick-slip cycle."""
    return stick_slip_cycle(law(name), oscillator(c, V)) is not None
