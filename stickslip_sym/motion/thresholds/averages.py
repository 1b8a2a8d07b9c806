"""Averages of the falling slope at operating points: their dampings, without any derivation, and how they change.

An average of -mu' changes with a parameter by the average of the derivative of mu, and with ln V by that of
v mu' - mu. Nothing is differenced.
"""

from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, FloatArray
from stickslip_sym.core.errors import NotConverged
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.criteria.rule import gauss_average
from stickslip_sym.model.bound import BoundLaw
from stickslip_sym.model.expression.pieces import jumps, rate
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.table import FrictionTable
from stickslip_sym.motion.orbits.needed import SIGNS
from stickslip_sym.motion.thresholds.operating_points import OperatingPoints

if TYPE_CHECKING:
    from stickslip_sym.formula.slope_average import SlopeAverage

_REFUSED_RTOL = 1e-6  # error of an average by Gauss's rule, relative, above which it is refused


@dataclass(frozen=True)
class _Shape:
    """A law up to the values of its parameters; equal for equal formulas."""

    expr: Expr
    law: FrictionLaw = field(compare=False)


@lru_cache
def _fast_function(shape: _Shape, criterion: Criterion) -> "SlopeAverage":
    from stickslip_sym.formula.slope_average import slope_average

    return slope_average(shape.law.with_static(None), criterion)  # no slope average sees it, nor its parameters


def fast_average(law: FrictionLaw, criterion: Criterion, V: FloatArray) -> FloatArray:
    """Return a criterion's average of -mu', in s/m, at belt speeds; no closed form is derived for it."""
    compiled = _fast_function(_Shape(law.expr, law), criterion)
    values: dict[str, Any] = {
        name: float(value) for name, value in law.values.items() if name in compiled.arguments
    }
    return np.atleast_1d(compiled(V=V, N=np.ones_like(V), **values))


def resolved_gauss_average(
    law: BoundLaw,
    criterion: Criterion,
    V: FloatArray,
    table: FrictionTable | None = None,
    like: FrictionTable | None = None,
) -> FloatArray:
    """Return the same by Gauss's rule: nothing is made for each value of a parameter.

    - `table`, `like`: as for `criteria.rule.gauss_average`.

    Raises `NotConverged` where the slopes do not add up to the rise of mu.
    """
    if not law.expr.has(symbols.v):
        return np.zeros_like(V)
    mean, error, size = gauss_average(law, V, criterion=criterion, table=table, like=like)
    # Where slopes cancel it may be rounding, which leaves signs of their sizes sure.
    off = np.flatnonzero((error > _REFUSED_RTOL * np.abs(mean)) & (error > SIGNS * size))
    if off.size:
        raise NotConverged(
            f"the {criterion.name} average of the slope of mu at V = {V[off[0]]:g} m/s is known to "
            f"{error[off[0]]:.1e} s/m only, for a value of {mean[off[0]]:.3g}: mu varies too quickly there"
        )
    return mean


def average_changes(criterion: Criterion, points: OperatingPoints) -> dict[str, FloatArray]:
    """Differentiate the damping by an average of the slope; m and k do nothing to it."""
    law = points.law
    N = points.N
    V = points.V

    def changed(name: str) -> FloatArray:
        partial = law.partial(name).kinetic
        table = law.kinetic.table
        smooth = not (table.kinks or table.narrow.size)
        if smooth:
            own = None
        else:
            own = partial.table_up_to(2 * float(V.max()))
        by_slopes = resolved_gauss_average(partial, criterion, V, own, table if smooth else None)
        return N * (by_slopes + _changes_by_jumps(law, criterion, V, name))

    return (
        {name: np.zeros_like(V) for name in points.columns}
        | {"V": changed("V") / V, "N": resolved_gauss_average(law.kinetic, criterion, V)}
        | {name: changed(name) for name in law.parameters}
    )


def _changes_by_jumps(law: FrictionLaw, criterion: Criterion, V: FloatArray, name: str) -> FloatArray:
    """Return what moving jumps of mu bring: c is the integral of mu times a kernel K(v)."""
    sums = np.zeros_like(V)
    if criterion.weight is None:
        return sums
    for jump, height in jumps(law.expr, law.point):
        if name == "V":
            moved = -jump
        else:
            moved = rate(jump, law.parameters[name].symbol)
        at, by, size = (law.kinetic.number(part) for part in (jump, moved, height))
        kernel = criterion.kernel.subs(symbols.v, at)
        for row, speed in enumerate(V):
            if 0 < at < 2 * speed:
                sums[row] -= size * by * float(kernel.subs(symbols.V, speed))
    return sums
