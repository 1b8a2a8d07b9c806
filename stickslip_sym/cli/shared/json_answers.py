"""Thresholds, critical values, margins and attractors as the objects that commands print with ``--json``."""

from typing import TYPE_CHECKING, Union

from stickslip_sym.cli.shared import json_output
from stickslip_sym.cli.shared.words import in_options
from stickslip_sym.core.errors import StickSlipError

if TYPE_CHECKING:
    from stickslip_sym.motion.margins.margins import Margins
    from stickslip_sym.motion.margins.value import Critical
    from stickslip_sym.motion.regimes.attractors import Attractor
    from stickslip_sym.motion.thresholds.threshold import Threshold

__all__ = ["Found", "attractor", "critical", "margins", "threshold"]

Found = Union["Threshold", StickSlipError, str]  # a text has no |
"""A threshold, or why there is none."""
_UNITS = {
    **dict.fromkeys(("x", "x_min", "x_max"), "m"),
    **dict.fromkeys(("period", "stick_time", "slip_time"), "s"),
    **dict.fromkeys(("amplitude", "v_min", "v_max"), "m/s"),
    **dict.fromkeys(("rate", "floquet"), "1/s"),
}


def threshold(method: str, found: Found, seconds: float) -> json_output.Json:
    """Return what a rung says, or why it says nothing."""
    if isinstance(found, StickSlipError | str):
        return {"method": method, "c": json_output.missing("kg/s", in_options(str(found)))}
    return {
        "method": found.method,
        "c": json_output.quantity(found.value, "kg/s"),
        "relative_error": json_output.number(found.error),
        "status": found.status,
        "seconds": seconds,
    } | _uncertainty(found)


def _uncertainty(threshold: "Threshold") -> json_output.Json:
    """Return the standard error that the parameters give a threshold, and its budget, if they carry any."""
    budget = threshold.budget
    if budget is None:
        return {}
    shares = [
        {
            "name": name,
            "standard_error": json_output.number(budget.deviations[name]),
            "sensitivity": json_output.number(threshold.sensitivity[name]),
            "alone": json_output.number(budget.alone[name]),
            "share": json_output.number(budget.shares[name]),
        }
        for name in budget.names
    ]
    return {
        "standard_error": json_output.quantity(threshold.uncertainty, "kg/s"),
        "second_order_ratio": json_output.number(threshold.nonlinearity),
        "budget": shares,
        "correlations": [{"names": [one, other], "value": r} for one, other, r in budget.correlated],
        "deserved_rtol": threshold.deserved,
    }


def critical(one: "Critical") -> json_output.Json:
    """Return a value at which the damping just suffices."""
    return {
        "value": json_output.quantity(one.value, one.unit),
        "method": one.method,
        "relative_error": json_output.number(one.error),
        "sensitivity": {name: json_output.number(value) for name, value in one.sensitivity.items()},
        "proved": one.enclosure is not None,
    }


def margins(found: "Margins") -> json_output.Json:
    """Return how far an oscillator is from its threshold in each quantity, and the probability of stick-slip."""
    rows = [
        {
            "name": row.name,
            "value": row.value,
            "below": None if row.below is None else critical(row.below),
            "above": None if row.above is None else critical(row.above),
            "change": json_output.number(row.change),
        }
        for row in found.rows
    ]
    return {
        "stick_slip": found.stick_slip,
        "threshold": json_output.quantity(found.threshold.value, "kg/s"),
        "margins": rows,
        "probability": found.probability,
        "sampled": None if found.sampled is None else list(found.sampled),
        "refused": dict(found.refused),
    }


def attractor(one: "Attractor") -> json_output.Json:
    """Return a motion that attracts others, with its numbers."""
    numbers = {
        name: json_output.quantity(getattr(one, name), unit) for name, unit in _UNITS.items() if hasattr(one, name)
    }
    return {"attractor": str(one), **numbers}
