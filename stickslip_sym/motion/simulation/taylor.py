"""Slip phases by heyoka: Taylor series of order 20, compiled. Needs the extra `fast`.

The contract is that of `slip.follow`, whatever `rtol`: every step is as accurate as double precision allows. For a
series that costs little more than a rough step, and one compiled integrator then serves all tolerances, both
sides, and all scenes of a law.

The extrema of w, simple roots of w', are heyoka's terminal events. Each ends its step, so w is monotone in every
step and has crossed 0 if and only if it ends at 0 or below. The return needs no event of its own, and none that
would have to tell a graze from a miss.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from threading import local
from typing import Any, Literal

import numpy as np
import sympy as sp
from scipy.optimize import brentq

from stickslip_sym.core import symbols
from stickslip_sym.core.errors import InputError, NotConverged
from stickslip_sym.model.oscillator import Scene
from stickslip_sym.motion.simulation.slip_phase import RUNAWAY, SlipPhase, attracted_to_rest, exhausted
from stickslip_sym.motion.simulation.steppers import Point

__all__ = ["Series", "follow"]

_MOST_TRIES = 20_000  # of a step
_TRIES = 30  # more for every unit of time, on the way to a given horizon
_MOST_COMPILED = 32  # laws whose integrators are kept
_TINY = float(np.finfo(np.float64).tiny)
_DEFECT = 1e-13  # how far a step may miss, in units of its state
_EXTREMUM = -1  # the number by which heyoka names its first terminal event
_OWN = 5  # runtime parameters of the oscillator, before those of the law
_OTHERWISE = 'use engine="scipy"'


@dataclass(frozen=True)
class Series:
    """The Taylor series of (q, w) about the beginning of a step.

    Attributes
    ----------
    t_old, t : float
        Dimensionless times of the beginning and the end.
    coefficients : numpy.ndarray of shape (order + 1, 2)
    """

    t_old: float
    t: float
    coefficients: Any

    @property
    def start(self) -> Point:
        """The state at the beginning."""
        return Point(self.t_old, *self.coefficients[0].tolist())

    def __call__(self, tau: Any) -> Any:
        """Return (q, w) at a time, or rows of q and w at several."""
        return self._sum(np.asarray(tau) - self.t_old)

    def _sum(self, time: Any) -> Any:
        return (np.power.outer(time, np.arange(len(self.coefficients))) @ self.coefficients).T

    def rate(self, time: float) -> float:
        """Return w' at a time after the beginning."""
        height, value = self.coefficients[:, 1].tolist(), 0.0
        for order in range(len(height) - 1, 0, -1):
            value = value * time + order * height[order]
        return value

    def crossing(self, length: float) -> tuple[float, Point]:
        """Return the time after the beginning at which w, which has come to 0 or below at `length`, is 0."""
        height = self.coefficients[::-1, 1].tolist()

        def w(time: float) -> float:
            value = 0.0
            for coefficient in height:
                value = value * time + coefficient
            return value

        time = brentq(w, 0.0, length, xtol=_TINY) if w(length) < 0 < w(0.0) else length
        return time, Point(self.t_old + time, float(self._sum(time)[0]), 0.0)


def follow(
    scene: Scene,
    start: Point,
    side: int,
    *,
    horizon: float,
    rtol: float,
    until: Literal["return", "turn"] = "return",
    max_steps: int | None = None,
    deadline: float = math.inf,
) -> SlipPhase:
    """Integrate a slip phase from `start`.

    Parameters
    ----------
    scene, start, side, horizon, until, max_steps, deadline
        As for `slip.follow`.
    rtol : float
        How close to a rest that attracts it the mass is at rest.

    Raises
    ------
    InputError
        If heyoka is not installed, the law is not one that it can expand, or mu cannot be computed at the start.
    NotConverged
        When the number of steps runs out, as in a stiff scene, or mu cannot be computed on the motion.
    """
    if not math.isfinite(scene.acceleration(start.q, start.w, side)):
        raise InputError(f"mu cannot be computed at a slip speed of {start.w:g} V, where the motion starts")
    integrator = _integrator(scene, side)
    phase = SlipPhase(side, "horizon", start)
    rests = attracted_to_rest(scene, side, rtol)
    rising = True if start.w == 0 else None  # elsewhere the first extremum will tell
    longest = math.inf
    tries = 0
    while phase.last.tau < horizon:
        if (end := exhausted(phase, max_steps, deadline)) is not None:
            phase.end = end
            return phase
        tries += 1
        before = phase.last
        if tries > _MOST_TRIES + (_TRIES * (before.tau - start.tau) if until == "return" else 0):
            raise NotConverged(
                f"one slip phase took over {tries - 1} Taylor steps up to {before.tau - start.tau:.3g}/omega: a "
                f"fast decay, or a law that is not smooth, holds them short; {_OTHERWISE}"
            )
        integrator.time, integrator.state[:] = before.tau, (before.q, before.w)
        outcome, length = integrator.step(min(longest, horizon - before.tau), write_tc=True)
        now = Point(integrator.time, *integrator.state.tolist())
        if not max(abs(now.q), abs(now.w)) < RUNAWAY:
            phase.end, phase.error = _lost(before)
            if phase.error is not None and max_steps is None:
                raise phase.error
            return phase
        piece = Series(before.tau, now.tau, integrator.tc.T.copy())
        crosses = now.w <= 0 and not rising
        if crosses:
            length, now = piece.crossing(length)
        advanced = now.tau > before.tau  # not to an extremum right here, which a step tried again may find again
        if advanced and not _holds(scene, piece, length, now, side):
            longest = length / 4
            continue
        phase.last = now
        if advanced:
            longest = math.inf
        if advanced or not phase.pieces:
            phase.pieces.append(piece)
        if crosses:
            phase.end = "return"
            return phase
        # Where w' = 0, w'' = side - w whatever mu is. At an onset rounding may give w' a root, and w rises on.
        if int(outcome) == _EXTREMUM and (now.w < side) != rising:
            rising = now.w < side
            phase.extrema.append(now)
            if rising and until == "turn":
                phase.end = "minimum"
                return phase
        if rests(now):
            phase.end = "rest"
            return phase
    return phase


def _holds(scene: Scene, piece: Series, length: float, now: Point, side: int) -> bool:
    """Whether the rates at the end of a step are those that its series has there.

    The length of a step follows from its last coefficients, and they do not see a layer of the law ahead: of
    tanh(v/v_0) nothing is left in them at v = 20 v_0, and a step could pass from there to v = 0.
    """
    error = length * abs(piece.rate(length) - scene.acceleration(now.q, now.w, side))
    return error <= _DEFECT * max(1.0, abs(now.q), abs(now.w), length * scene.eta)


def _lost(before: Point) -> tuple[str, NotConverged | None]:
    """Tell a motion that grows for ever from one that comes to where mu has no value."""
    if max(abs(before.q), abs(before.w)) > math.sqrt(RUNAWAY):
        return "unbounded", None
    return "undefined", NotConverged(
        f"the slip phase cannot be expanded in a Taylor series beyond a slip speed of {before.w:.6g} V; mu may "
        f"have no finite value there; {_OTHERWISE}, or another law"
    )


# -- compilation -----------------------------------------------------------------------------------


def _integrator(scene: Scene, side: int) -> Any:
    """Return the compiled integrator of a scene's law with the scene's numbers in it."""
    law = scene.law
    # A power of 0 has a Taylor series only if its exponent is known to be whole.
    symbols_of = {name: parameter.symbol for name, parameter in law.parameters.items()}
    whole = {
        symbol: law.values[name]
        for name, symbol in symbols_of.items()
        if law.values[name].is_Integer and symbol in _exponents(law.expr)
    }
    names = [name for name, symbol in symbols_of.items() if symbol not in whole]
    integrator = _compiled.of(law.expr.xreplace(whole), tuple(symbols_of[name] for name in names))
    values = scene.eta, scene.zeta, scene.static, side, scene.speed, *(float(law.values[name]) for name in names)
    integrator.pars[:] = values[: len(integrator.pars)]  # a constant law has no use for the last ones
    integrator.state[:] = 0.0
    integrator.step(0.0, write_tc=True)
    if not np.isfinite(integrator.tc).all():
        raise InputError(f"{law!r} has no Taylor series at the slip speed 0; {_OTHERWISE}")
    integrator.reset_cooldowns()  # an event of the last phase must not hide one of the next
    return integrator


@lru_cache
def _exponents(expr: Any) -> frozenset[Any]:
    """Return the symbols in exponents of v."""
    powers = [power for power in expr.atoms(sp.Pow) if power.base.has(symbols.v)]
    return frozenset().union(*(power.exp.free_symbols for power in powers))


def _compile(expr: Any, parameters: tuple[Any, ...]) -> Any:
    heyoka = _heyoka()
    q, w = heyoka.make_vars("q", "w")
    eta, zeta, static, side, speed = (heyoka.par[i] for i in range(_OWN))
    leaves = {symbol: heyoka.par[_OWN + i] for i, symbol in enumerate(parameters)}
    mu = _translated(expr, leaves | {symbols.v: speed * w}, heyoka)
    rate = eta * (side * static - mu) + side * q - 2.0 * zeta * w
    return heyoka.taylor_adaptive(
        [(q, 1.0 - side * w), (w, rate)],
        [0.0, 0.0],
        t_events=[heyoka.t_event(rate)],
        compact_mode=True,
    )


class _Compiled(local):
    """Integrators by law. They hold a state, so each thread has its own."""

    def __init__(self) -> None:
        self.of = lru_cache(_MOST_COMPILED)(_compile)


_compiled = _Compiled()


def _heyoka() -> Any:
    try:
        import heyoka
    except ImportError:
        raise InputError(
            f"engine=\"heyoka\" needs the package heyoka: pip install 'stickslip_sym[fast]', or {_OTHERWISE}"
        ) from None
    heyoka.set_logger_level_error()  # it warns of values that are not finite, which here are exceptions
    return heyoka


_FUNCTIONS = frozenset({"exp", "log", "sin", "cos", "tan", "sinh", "cosh", "tanh", "asinh", "atan", "erf"})
"""What heyoka has by the same name."""


def _translated(expr: Any, leaves: dict[Any, Any], heyoka: Any) -> Any:
    """Return a SymPy expression as heyoka's."""
    if expr in leaves:
        return leaves[expr]
    if not expr.free_symbols:
        return heyoka.expression(float(expr))
    name = type(expr).__name__
    if isinstance(expr, sp.Piecewise) or name not in _FUNCTIONS | {"Add", "Mul", "Pow", "sech"}:
        raise InputError(
            f'engine="heyoka" needs a law that is smooth and known to heyoka, got {name}; {_OTHERWISE}'
        )
    arguments = [_translated(argument, leaves, heyoka) for argument in expr.args]
    if isinstance(expr, sp.Add):
        return heyoka.sum(arguments)
    if isinstance(expr, sp.Mul):
        return heyoka.prod(arguments)
    if isinstance(expr, sp.Pow):
        return _power(arguments[0], int(expr.exp)) if _is_whole(expr.exp) else arguments[0] ** arguments[1]
    return 1.0 / heyoka.cosh(*arguments) if name == "sech" else getattr(heyoka, name)(*arguments)


def _is_whole(exponent: Any) -> bool:
    return bool(exponent.is_Integer and exponent > 0)


def _power(base: Any, exponent: int) -> Any:
    """Return a power by products: heyoka's own series of a power, but for squares, divides by its base."""
    if exponent == 1:
        return base
    half = _power(base, exponent // 2)
    return half * half * base if exponent % 2 else half * half
