"""Averages of the falling slope at operating points: their dampings, without any derivation."""

from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, FloatArray
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.orbits.expansion import averages, slopes
from stickslip_sym.motion.thresholds.operating_points import OperatingPoints

if TYPE_CHECKING:
    from stickslip_sym.formula.slope_average import SlopeAverage

__all__ = ["average", "slope_mean"]


@dataclass(frozen=True)
class _Shape:
    """A law up to the values of its parameters; equal for equal formulas."""

    expr: Expr
    law: FrictionLaw = field(compare=False)


@lru_cache(maxsize=128)
def _slope_average(shape: _Shape, criterion: Criterion) -> "SlopeAverage":
    from stickslip_sym.formula.slope_average import slope_average

    return slope_average(shape.law.with_static(None), criterion)  # no slope average sees it, nor its parameters


def average(points: OperatingPoints, criterion: Criterion) -> FloatArray:
    """Return a criterion's damping in kg/s; no closed form is derived for it."""
    compiled = _slope_average(_Shape(points.law.expr, points.law), criterion)
    values: dict[str, Any] = {
        name: float(value) for name, value in points.law.values.items() if name in compiled.arguments
    }
    return np.atleast_1d(compiled(V=points.V, N=points.N, **values))


@lru_cache(maxsize=128)  # to find them takes longer than an average of a measured law
def _has_kinks(law: FrictionLaw) -> bool:
    return bool(law.kinks())


def slope_mean(law: FrictionLaw, criterion: Criterion, V: FloatArray) -> FloatArray:
    """Return a criterion's average of -mu', in s/m, at belt speeds V, by Gauss rules where mu is smooth."""
    if not law.expr.has(symbols.v):
        return np.zeros_like(V)
    if _has_kinks(law):
        return average(OperatingPoints(law, V, np.ones_like(V), None, None, V.shape), criterion)
    return -slopes(law)(V) if criterion.weight is None else averages(law, V, criteria=[criterion])[0]
