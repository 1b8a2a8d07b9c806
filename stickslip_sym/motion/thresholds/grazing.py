"""The pure-slip threshold by simulation: the damping at which the orbit from P grazes the belt's speed.

Nothing here knows a closed form, so the threshold is a check of every criterion.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
from scipy.optimize import brentq

from stickslip_sym.core.errors import NotConverged, NoThreshold, OutOfTime
from stickslip_sym.core.numbers import read_rtol
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator, Scene
from stickslip_sym.motion.simulation.levels import Levels
from stickslip_sym.motion.simulation.transit import lowest_slip_speed

__all__ = ["grazing_damping"]

_SLOPE_SAMPLES = 257
_TIGHTEST = 1e-13
_LOOSEST = 1e-6  # of a root: looser ones cost hardly less, and in stiff motions say little of what they are off
_OFF = 10  # tolerances by which the lowest slip speed of an integration may be off
_MOST_SECANTS = 16  # as many as a root takes where friction is strong; a canard takes more
_NEAR = 1e-3  # relative distance of a root from which on integrations are tight
_LEFT = 1e-2  # of the tolerance, what the last secant may leave
_SURE = 1e-2  # relative error; of a root that is less certain brackets say whether there is one
_FLAT = 1e-12  # fall of mu along an orbit, below which it is none
_PHASES = 128  # for the first guess
_COARSE = 1e-5  # tolerance of a first root, whose orbits cost little


def grazing_damping(
    law: FrictionLaw, osc: Oscillator, *, rtol: float, engine: str = "scipy"
) -> tuple[float, float]:
    """Return the damping c in kg/s at which the orbit from P comes down to w = 0 and no further.

    - `law`: with all parameters bound.
    - `osc`: its own c is not used.
    - `rtol`: relative tolerance of the root, 1e-13 to 1e-3; the steps of the integration are held to a tenth of
      it, or of 1e-6.
    - `engine`: what integrates the slip, as for `simulate`; "scipy" is spared where steps from level to level of
      the slip speed do (`Levels`).

    Returns `value, error`: the damping, and its estimated relative error.

    Raises `InputError` for an unbound law, one measured up to less than 2 V, an unusable tolerance, or an engine
      that is not there or cannot take the law.
    Raises `NoThreshold` if the orbit from P never returns, for any c >= 0.
    Raises `NotConverged` when the bound on the work is reached.
    Raises `OutOfTime` when the time of a `time_limit` around it is up; it says between which dampings the
      threshold lies.
    """
    rtol = read_rtol(rtol)
    sides = {False: -math.inf, True: math.inf}  # the dampings next to the threshold that return, and do not
    try:
        return _root(law, osc, rtol, engine, sides)
    except OutOfTime:
        low, high = sides.values()
        raise OutOfTime(_best(low, high)) from None


def _best(low: float, high: float) -> str:
    """Say what is known of a threshold between two dampings."""
    if math.isinf(high - low):
        return f"the time limit was reached; the threshold lies between {low:.6g} and {high:.6g} kg/s"
    middle = (low + high) / 2
    error = max(abs(high - low) / (2 * middle), _COARSE) if middle else math.inf
    return f"the time limit was reached; the best value found is {middle:.10g} kg/s, relative error {error:.1e}"


def _root(
    law: FrictionLaw, osc: Oscillator, rtol: float, engine: str, sides: dict[bool, float]
) -> tuple[float, float]:
    scene = Scene.of(law, osc)
    levels = Levels(scene) if engine == "scipy" else None

    @cache
    def lowest(c: float, tolerance: float) -> float:
        found = lowest_slip_speed(replace(scene, zeta=c / (2 * osc.impedance)), tolerance, engine, levels)
        found = 1.0 if found is None else found  # creeping to rest, it does not return
        missed = found > 0
        sides[missed] = min(sides[True], c) if missed else max(sides[False], c)
        # Where the graze is a canard, w jumps by orders of magnitude.
        return found / (1 + abs(found)) if found > -math.inf else -1.0

    tight = max(min(rtol, _LOOSEST) / 10, _TIGHTEST)
    guess = _harmonic(law, osc)
    found = _by_secants(lowest, guess, math.pi / osc.impedance, tight, sides)
    if found is None:
        found = _by_brackets(lowest, guess, _steep(law, osc, scene.static), tight, osc)
    value, error = found
    return value, max(error, rtol)


def _by_secants(
    lowest: Callable[[float, float], float], guess: float, slope: float, tight: float, sides: dict[bool, float]
) -> tuple[float, float] | None:
    """Return the root near a guess, and its error; None where secants do not find it at once.

    - `slope`: of the lowest slip speed at the graze, as where friction is weak: one round at the amplitude V has
      its peak lowered by pi c/impedance.
    """
    loose, tolerance = 10 * tight, 10 * tight
    c = max(guess, 0.0)
    height, bent = lowest(c, loose), math.inf
    if c == 0 and height >= 0:
        return None
    for _ in range(_MOST_SECANTS):
        step = -height / slope
        # A secant is off by as much as the one before it had another slope.
        left = abs(step) * min(bent, 1.0) / c if c else math.inf
        if tolerance == tight and (left <= _LEFT * tight or abs(height) <= tight):
            break
        if abs(step) < _NEAR * c:
            tolerance = tight
        ahead = c + (max(min(step, c), -c / 2) if c else step)
        low, high = sides.values()
        if not low < ahead < high:  # a layer of mu at the belt's speed bends the lowest slip speed there
            ahead = (low + high) / 2
        if not math.isfinite(ahead) or ahead == c:
            return None
        risen = lowest(ahead, tolerance)
        if not (risen - height) * (ahead - c) > 0:
            if tolerance == tight and abs(height) <= _OFF * tight:
                break
            return None
        rise = (risen - height) / (ahead - c)
        slope, bent, c, height = rise, abs(rise / slope - 1), ahead, risen
    else:
        return None
    # How far the root moves with an integration ten times looser is more than it is off; twice that, since the
    # errors of both may by chance agree. Where friction is weak the lowest slip speed hardly depends on c, and
    # what an integration of its tolerance may be off by moves the root far.
    error = max(2 * abs(lowest(c, loose) - height), _OFF * tight) / (slope * c) + left
    c += step
    return (c, error) if error < _SURE else None


def _by_brackets(
    lowest: Callable[[float, float], float], guess: float, high: float, tight: float, osc: Oscillator
) -> tuple[float, float]:
    """Return the root between 0 and a damping that is doubled until it is one, and its error."""
    undamped = lowest(0.0, tight)
    if 0 <= undamped <= _OFF * tight and guess * osc.V > _FLAT * osc.N:
        raise NotConverged(
            "whether the slip that leaves P returns to the belt's speed without damping is lost in rounding: "
            f"friction changes too little at V = {osc.V:g}, N = {osc.N:g}"
        )
    if undamped >= 0:
        raise NoThreshold(
            "the slip that leaves P does not return to the belt's speed even without damping, "
            f"so no c >= 0 is a threshold at V = {osc.V:g}, N = {osc.N:g}"
        )
    for _ in range(60):
        if lowest(high, tight) > 0:
            break
        high *= 2
    else:
        raise NotConverged(
            f"no damping up to {high:g} kg/s was found at which the orbit from P does not return; "
            "try a law that falls less steeply"
        )

    def root(low: float, high: float, tolerance: float) -> float:
        if not lowest(low, tolerance) < 0 < lowest(high, tolerance):
            raise NotConverged(
                f"between {low:g} and {high:g} kg/s the return of the orbit from P is lost in rounding; "
                "the threshold is too small a part of the damping there"
            )
        return float(brentq(lowest, low, high, (tolerance,), xtol=1e-300, rtol=tolerance))

    loose = 10 * tight
    coarse = max(_COARSE, loose)
    values = [root(0.0, high, coarse)]
    for width, tolerance in ((10 * coarse, loose), (10 * loose, tight)):
        around = values[-1]
        while not lowest(around * max(1 - width, 0.0), tolerance) < 0 < lowest(around * (1 + width), tolerance):
            width *= 10
            if around * width > 10 * high:
                raise NotConverged(f"the threshold is lost in rounding near {around:g} kg/s; try another rtol")
        values.append(root(around * max(1 - width, 0.0), around * (1 + width), tolerance))
    # How far the root moved from an integration ten times looser is more than it is off; twice that, since
    # the errors of both may by chance agree. Where friction is weak the lowest slip speed hardly depends on c, and
    # what an integration of its tolerance may be off by moves the root far: the slope there tells how far.
    _, before, value = values
    rise = lowest(value * (1 + 10 * width), tight) - lowest(value * max(1 - 10 * width, 0.0), tight)
    moved = _OFF * tight * 20 * width / rise if rise > 0 else math.inf
    return value, max(2 * abs(value - before) / value, moved)


def _steep(law: FrictionLaw, osc: Oscillator, static: float) -> float:
    """Return a damping of the size that the falls of mu over (0, 2V] can feed, the static jump included."""
    v = np.linspace(0.0, 2 * osc.V, _SLOPE_SAMPLES)[1:]  # at v = 0 the slope may be infinite
    mu = law.mu(v)
    drop = max(static, mu.max()) - mu.min()
    return float(osc.N * max(np.max(-law.slope(v)), drop / osc.V))


def _harmonic(law: FrictionLaw, osc: Oscillator) -> float:
    """Return the damping by the harmonic criterion, as far as equal steps of the phase have it."""
    phase = np.arange(1, 2 * _PHASES, 2) * math.pi / (2 * _PHASES)
    mu = law.at_speeds(osc.V * (1 - np.cos(phase)))
    return float(2 * osc.N / osc.V * np.mean(mu * np.cos(phase)))
