"""What is said of a law whose coefficient of friction is negative somewhere, or 0 at rest."""

import warnings

import numpy as np

from stickslip_sym.core.errors import InputWarning
from stickslip_sym.core.numbers import LARGEST, SAME
from stickslip_sym.model.bound import BoundLaw

_SPEED_GRID = np.union1d(np.geomspace(1e-9, 1, 300), np.linspace(0, 1, 4001)[1:])
"""Speeds over the last; at 0 itself the logarithm of rate and state has no value."""


def lowest(law: BoundLaw, end: float) -> tuple[float, float]:
    """Return the slip speed in m/s above 0 and up to `end`, where known, where mu is lowest, and mu there.

    A dip to below 0 that is narrower than a 4000th of `end` may be missed.
    """
    end = min(end, law.reach)
    speeds = min(end, LARGEST) * _SPEED_GRID
    mu = law.at_speeds(speeds)
    if not np.isfinite(mu).any():
        return end, float("nan")
    place = int(np.nanargmin(mu))
    return float(speeds[place]), float(mu[place])


def warn_where_negative(law: BoundLaw, V: float) -> bool:
    """Warn of a coefficient below 0 at a slip speed that motions at the belt speed V reach; return whether."""
    v, mu = lowest(law, 2 * V)
    if negative := mu < -SAME:
        warnings.warn(
            f"mu = {mu:.3g} is negative at the slip speed v = {v:.3g} m/s; at V = {V:g} m/s motions slip at up to "
            "2 V, so what follows is of a law that drives where it should brake; check the law's values and units",
            InputWarning,
            stacklevel=3,
        )
    return negative


def note_at_rest(law: BoundLaw, N: float = 1.0) -> str:
    """Return what is said of a law that holds no mass at rest on the belt; nothing of any other."""
    if law.static != 0 or N == 0:
        return ""
    return (
        "mu(0) = 0: static friction holds nothing, and the mass slips slowly where it would stick by the law "
        "without this regularisation"
    )
