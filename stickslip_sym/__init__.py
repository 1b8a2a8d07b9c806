"""Stick-slip vibration of a mass on a moving belt: criteria derived, proved, evaluated and cross-checked.

The friction law mu(v) of a contact decides how much viscous damping c the oscillator
m x'' + c x' + k x = N mu(V - x') needs so that it does not stick and slip. Names are loaded when
first used: importing the package is cheap.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stickslip_sym import criteria
    from stickslip_sym.core import symbols
    from stickslip_sym.core.errors import (
        InputError,
        InputWarning,
        NoClosedForm,
        NotConverged,
        NoThreshold,
        StickSlipError,
    )
    from stickslip_sym.criteria import quadrature
    from stickslip_sym.formula.derivation.closed_form import ClosedForm, derive
    from stickslip_sym.formula.derivation.keeping import load, load_all, save, save_all
    from stickslip_sym.formula.derivation.proving import Status, Verdict
    from stickslip_sym.formula.derivation.steps import Derivation, Step
    from stickslip_sym.formula.evaluation.averages import SlopeAverage, slope_average
    from stickslip_sym.formula.export.export import export_c, export_latex, export_octave, export_python
    from stickslip_sym.model import laws
    from stickslip_sym.model.law import FrictionLaw, Parameter
    from stickslip_sym.model.oscillator import Oscillator
    from stickslip_sym.motion.maps.basins import BasinMap, basin_map
    from stickslip_sym.motion.maps.motions import MotionMap, motion_map
    from stickslip_sym.motion.orbits.cycles import LimitCycle, limit_cycles
    from stickslip_sym.motion.regimes.attractors import Regime, Rest, Separatrix, regime
    from stickslip_sym.motion.regimes.classification import Motion, classify
    from stickslip_sym.motion.simulation.automaton import simulate
    from stickslip_sym.motion.simulation.trajectory import Event, EventKind, Outcome, Phase, Tendency, Trajectory
    from stickslip_sym.motion.simulation.transit import StickSlipCycle, peak_velocity, stick_slip_cycle
    from stickslip_sym.motion.thresholds.threshold import Threshold, pure_slip_damping
    from stickslip_sym.motion.thresholds.transition import TransitionSpeed, transition_speed

__version__ = "0.1.0"

_MODULES = ("criteria", "laws", "quadrature", "symbols")
_HOME = {
    "ClosedForm": "closed_form", "derive": "closed_form",
    "StickSlipCycle": "transit", "peak_velocity": "transit", "stick_slip_cycle": "transit",
    "Derivation": "derivation", "Step": "derivation",
    "InputError": "errors", "InputWarning": "errors", "NoClosedForm": "errors", "NoThreshold": "errors",
    "NotConverged": "errors", "OutOfTime": "errors", "StickSlipError": "errors",
    "FrictionLaw": "friction", "Parameter": "friction",
    "export_c": "export", "export_latex": "export", "export_octave": "export", "export_python": "export",
    "load": "keeping", "load_all": "keeping", "save": "keeping", "save_all": "keeping",
    "BasinMap": "basins", "basin_map": "basins", "MotionMap": "maps", "motion_map": "maps",
    "Oscillator": "oscillator",
    "Status": "proving", "Verdict": "proving",
    "SlopeAverage": "averages", "slope_average": "averages",
    "Event": "trajectory", "EventKind": "trajectory", "Outcome": "trajectory", "Phase": "trajectory",
    "Tendency": "trajectory", "Trajectory": "trajectory", "simulate": "automaton",
    "LimitCycle": "cycles", "limit_cycles": "cycles",
    "Threshold": "threshold", "pure_slip_damping": "threshold",
    "TransitionSpeed": "transition", "transition_speed": "transition",
    "Regime": "regimes", "Rest": "regimes", "Separatrix": "regimes", "regime": "regimes",
    "Motion": "classification", "classify": "classification",
}  # fmt: skip

__all__ = [  # noqa: RUF022  # modules first, then what they hold
    "criteria", "laws", "quadrature", "symbols",
    "BasinMap", "ClosedForm", "Derivation", "Event", "EventKind", "FrictionLaw", "InputError", "InputWarning",
    "LimitCycle", "Motion", "MotionMap", "NoClosedForm", "NoThreshold", "NotConverged", "Oscillator",
    "OutOfTime", "Outcome", "Parameter", "Phase", "Regime", "Rest", "Separatrix", "SlopeAverage", "Status",
    "Step", "StickSlipCycle", "StickSlipError", "Tendency", "Threshold", "Trajectory", "TransitionSpeed",
    "Verdict",
    "basin_map", "classify", "derive", "export_c", "export_latex", "export_octave", "export_python",
    "limit_cycles", "load", "load_all", "motion_map", "peak_velocity", "pure_slip_damping", "regime", "save",
    "save_all", "simulate", "slope_average", "stick_slip_cycle", "transition_speed",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return import_module(f"stickslip_sym.{name}")
    if name in _HOME:
        value = getattr(import_module(f"stickslip_sym.{_HOME[name]}"), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'stickslip_sym' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
