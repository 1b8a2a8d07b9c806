"""How a threshold changes with every quantity and parameter: exact derivatives, one function a rung.

An average of -mu' changes with a parameter by the average of the derivative of mu, and with ln V by that of
v mu' - mu. The damping of a grazing orbit follows from one linear solve, that of a simulated one from the
variational equation along the slip. Nothing is differenced.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import InputError
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.model.expression.pieces import jumps
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.orbits.expansion import averages, slopes, tangents
from stickslip_sym.motion.orbits.orbit import derivatives
from stickslip_sym.motion.simulation.variation import grazing_variation
from stickslip_sym.motion.thresholds.grazing import grazing_damping
from stickslip_sym.motion.thresholds.rungs import Rung, average
from stickslip_sym.motion.thresholds.scenes import Scenes

__all__ = ["sensitivities", "slope_mean"]

_SHARP = 1e-11  # relative error of a threshold at which the simulated slip may be differentiated


def sensitivities(scenes: Scenes, rung: Rung, value: FloatArray, error: FloatArray) -> dict[str, FloatArray]:
    """Return dc/dname for V, N, m and k, as far as they are given, and every parameter of the law.

    Parameters
    ----------
    scenes : Scenes
    rung : Rung
        That gave the thresholds.
    value, error : numpy.ndarray, shape (n,)
        The thresholds, and their relative errors.

    Raises
    ------
    InputError
        For a rung of one's own, of which only its values are known.
    """
    if rung.criterion is not None:
        return _of_average(scenes, rung.criterion)
    if rung.name not in _WAYS:
        raise InputError(
            f"how a threshold of {rung.name!r} changes with the quantities is not known; try another method"
        )
    with np.errstate(all="ignore"):
        return _WAYS[rung.name](scenes, value, error)


# -- averages --------------------------------------------------------------------------------------


def slope_mean(law: FrictionLaw, criterion: Criterion, V: FloatArray) -> FloatArray:
    """Return the average of minus the slope of a law with all its values, at belt speeds V."""
    if not law.expr.has(symbols.v):
        return np.zeros_like(V)
    if law.kinks():
        return average(Scenes(law, V, np.ones_like(V), None, None, V.shape), criterion)
    return -slopes(law)(V) if criterion.weight is None else averages(law, V, criteria=[criterion])[0]


def _of_average(scenes: Scenes, criterion: Criterion) -> dict[str, FloatArray]:
    law, N, V = scenes.law, scenes.N, scenes.V

    def changed(name: str) -> FloatArray:
        return N * (slope_mean(law.partial(name), criterion, V) + _of_jumps(law, criterion, V, name))

    nothing = {} if scenes.m is None else {"m": np.zeros_like(V), "k": np.zeros_like(V)}
    return (
        {"V": changed("V") / V, "N": slope_mean(law, criterion, V)}
        | nothing
        | {name: changed(name) for name in law.parameters}
    )


def _of_jumps(law: FrictionLaw, criterion: Criterion, V: FloatArray, name: str) -> FloatArray:
    """Return what places bring at which mu jumps, and that move: c is the integral of mu times a kernel K(v)."""
    found = np.zeros_like(V)
    if criterion.weight is None:
        return found
    values = {law.parameters[key].symbol: value for key, value in law.values.items()}
    for place, height in jumps(law.expr):
        moved = -place if name == "V" else sp.diff(place, law.parameters[name].symbol)
        at, by, size = (float(part.xreplace(values)) for part in (place, moved, height))
        kernel = criterion.moment_kernel.subs({symbols.v: at, symbols.N: 1})
        for row, speed in enumerate(V):
            if 0 < at < 2 * speed:
                found[row] -= size * by * float(kernel.subs(symbols.V, speed))
    return found


# -- with m and k ----------------------------------------------------------------------------------


def _by_impedance(scenes: Scenes, by_impedance: FloatArray) -> dict[str, FloatArray]:
    """Return the derivatives by m and k: both enter by sqrt(k m) alone."""
    whole = by_impedance * scenes.impedance / 2
    return {"m": whole / scenes.m, "k": whole / scenes.k}


def _second_order(scenes: Scenes, value: FloatArray, error: FloatArray) -> dict[str, FloatArray]:
    """Differentiate c = N (h + e^2 s), e = N/sqrt(k m)."""
    del value, error
    law, N, impedance = scenes.law, scenes.N, scenes.impedance
    weak, tangent = tangents(law, scenes.V, ["V", *law.parameters])
    e = N / impedance

    def changed(name: str) -> FloatArray:
        return N * (tangent[name].harmonic + e**2 * tangent[name].second)

    return (
        {"V": changed("V") / scenes.V, "N": weak.harmonic + 3 * e**2 * weak.second}
        | _by_impedance(scenes, -2 * e**3 * weak.second)
        | {name: changed(name) for name in law.parameters}
    )


def _on_orbit(scenes: Scenes, value: FloatArray, error: FloatArray) -> dict[str, FloatArray]:
    """Differentiate c = sqrt(k m) d(V, N/sqrt(k m))."""
    del value, error
    impedance, strength = scenes.impedance, scenes.N / scenes.impedance
    found = derivatives(scenes.law, scenes.V, strength)
    (harmonic,) = averages(scenes.law, scenes.V)  # exact without friction
    by_force = np.where(strength > 0, found["strength"] / strength, harmonic)
    return (
        {"V": found["V"] * impedance / scenes.V, "N": by_force}
        | _by_impedance(scenes, found["d"] - found["strength"])
        | {name: found[name] * impedance for name in scenes.law.parameters}
    )


def _simulated(scenes: Scenes, value: FloatArray, error: FloatArray) -> dict[str, FloatArray]:
    """Differentiate the lowest slip speed after the slip from P, which is 0 at the threshold."""
    found: dict[str, Any] = {}
    for row, (V, N, m, k) in enumerate(zip(scenes.V, scenes.N, scenes.m, scenes.k, strict=True)):
        osc = Oscillator(m=m, k=k, V=V, N=N, c=value[row])
        if not error[row] <= _SHARP:
            c, _ = grazing_damping(scenes.law, osc, rtol=_SHARP)
            osc = Oscillator(m=m, k=k, V=V, N=N, c=c)
        changes = grazing_variation(scenes.law, osc)
        by_damping = changes.pop("c")
        for name, change in changes.items():
            found.setdefault(name, np.empty(len(scenes)))[row] = -change / by_damping
    return found


_WAYS: dict[str, Callable[[Scenes, Any, Any], dict[str, Any]]] = {
    "second_order": _second_order,
    "orbit": _on_orbit,
    "simulation": _simulated,
    "proof": _simulated,
}
