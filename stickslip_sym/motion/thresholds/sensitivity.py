"""How a threshold changes with every quantity and parameter: exact derivatives dc/dname.

An average of -mu' changes with a parameter by the average of the derivative of mu, and with ln V by that of
v mu' - mu. The damping of a grazing orbit follows from one linear solve, that of a simulated one from the
wedges along its halves. Nothing is differenced.
"""

import numpy as np
import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.model.expression.pieces import jumps
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.orbits.expansion import averages
from stickslip_sym.motion.orbits.orbit import derivatives
from stickslip_sym.motion.thresholds.averages import slope_mean
from stickslip_sym.motion.thresholds.grazing import grazing_sensitivity
from stickslip_sym.motion.thresholds.operating_points import OperatingPoints

__all__ = ["of_average", "of_orbit", "of_slip"]


def of_average(criterion: Criterion, points: OperatingPoints, value: FloatArray) -> dict[str, FloatArray]:
    """Differentiate an average of the slope; m and k do nothing to it."""
    del value
    law, N, V = points.law, points.N, points.V

    def changed(name: str) -> FloatArray:
        return N * (slope_mean(law.partial(name), criterion, V) + _of_jumps(law, criterion, V, name))

    nothing = {} if points.m is None else {"m": np.zeros_like(V), "k": np.zeros_like(V)}
    return (
        {"V": changed("V") / V, "N": slope_mean(law, criterion, V)}
        | nothing
        | {name: changed(name) for name in law.parameters}
    )


def _of_jumps(law: FrictionLaw, criterion: Criterion, V: FloatArray, name: str) -> FloatArray:
    """Return what moving jumps of mu bring: c is the integral of mu times a kernel K(v)."""
    found = np.zeros_like(V)
    if criterion.weight is None:
        return found
    values = {law.parameters[key].symbol: value for key, value in law.values.items()}
    for jump, height in jumps(law.expr):
        moved = -jump if name == "V" else sp.diff(jump, law.parameters[name].symbol)
        at, by, size = (float(part.xreplace(values)) for part in (jump, moved, height))
        kernel = criterion.kernel.subs(symbols.v, at)
        for row, speed in enumerate(V):
            if 0 < at < 2 * speed:
                found[row] -= size * by * float(kernel.subs(symbols.V, speed))
    return found


def _by_impedance(points: OperatingPoints, by_impedance: FloatArray) -> dict[str, FloatArray]:
    """Return the derivatives by m and k: both enter by sqrt(k m) alone."""
    whole = by_impedance * points.impedance / 2
    return {"m": whole / points.m, "k": whole / points.k}


def of_orbit(points: OperatingPoints, value: FloatArray) -> dict[str, FloatArray]:
    """Differentiate c = sqrt(k m) d(V, N/sqrt(k m))."""
    impedance, strength = points.impedance, points.N / points.impedance
    found = derivatives(points.law, points.V, strength)
    (harmonic,) = averages(points.law, points.V)  # exact without friction
    with np.errstate(all="ignore"):
        by_force = np.where(strength > 0, found["strength"] / strength, harmonic)
    changes = (
        {"V": found["V"] * impedance / points.V, "N": by_force}
        | _by_impedance(points, found["d"] - found["strength"])
        | {name: found[name] * impedance for name in points.law.parameters}
    )
    strong = np.flatnonzero(~np.isfinite(found["d"]))  # no orbit on a grid of phases
    if strong.size:
        for name, column in of_slip(points.rows(strong), value[strong]).items():
            changes[name][strong] = column
    return changes


def of_slip(points: OperatingPoints, value: FloatArray) -> dict[str, FloatArray]:
    """Differentiate the gap between both halves of the orbit that grazes the belt's speed, point by point."""
    del value
    found = [grazing_sensitivity(points.law, points.oscillator(row)) for row in range(len(points))]
    names = (*points.columns, *points.law.parameters)
    return {name: np.array([one[name] for one in found]) for name in names}
