"""The classes of results, for annotations: what public functions return, and what those results hold.

``def report(threshold: ss.results.Threshold) -> str``. Functions make them; nobody else has to.
"""

from stickslip_sym.comparison.compare import Comparison, Row
from stickslip_sym.comparison.decision import Decision
from stickslip_sym.comparison.study import Study
from stickslip_sym.comparison.tradeoff import Trade, Tradeoff
from stickslip_sym.criteria.enclosure import EnclosedCriterion, Enclosure
from stickslip_sym.formula.average import Average
from stickslip_sym.formula.closed_form import ClosedForm
from stickslip_sym.formula.derivation import Derivation, Step
from stickslip_sym.formula.limits import Limits
from stickslip_sym.formula.proof.proving import Verdict
from stickslip_sym.formula.slope_average import SlopeAverage
from stickslip_sym.model.bound import BoundLaw
from stickslip_sym.model.fitting.averaged import Averaged, ByLaw
from stickslip_sym.model.fitting.result import Fit, Fits
from stickslip_sym.model.laws import Catalogue
from stickslip_sym.model.measured.blocks import Block
from stickslip_sym.model.measured.measurements import Measurements
from stickslip_sym.motion.maps.basins import BasinMap, Share
from stickslip_sym.motion.maps.motions import MotionMap
from stickslip_sym.motion.maps.sweep import BasinSweep, Change
from stickslip_sym.motion.margins.critical import Critical, CriticalValues
from stickslip_sym.motion.margins.margins import Margin, Margins
from stickslip_sym.motion.orbits.cycles import LimitCycle
from stickslip_sym.motion.regimes.attractors import Region
from stickslip_sym.motion.regimes.overtaking import Rounds
from stickslip_sym.motion.regimes.regime import Regime, Rest
from stickslip_sym.motion.regimes.separatrix import Separatrix
from stickslip_sym.motion.simulation.cycle import StickSlipCycle
from stickslip_sym.motion.simulation.trajectory import Event, EventKind, State, Stretch, Trajectories, Trajectory
from stickslip_sym.motion.thresholds.operating_points import OperatingPoints
from stickslip_sym.motion.thresholds.theorem import Theorem
from stickslip_sym.motion.thresholds.threshold import Threshold
from stickslip_sym.motion.thresholds.uncertainty import Budget
from stickslip_sym.numerics.known import Unknown

__all__ = [
    "Average",
    "Averaged",
    "BasinMap",
    "BasinSweep",
    "Block",
    "BoundLaw",
    "Budget",
    "ByLaw",
    "Catalogue",
    "Change",
    "ClosedForm",
    "Comparison",
    "Critical",
    "CriticalValues",
    "Decision",
    "Derivation",
    "EnclosedCriterion",
    "Enclosure",
    "Event",
    "EventKind",
    "Fit",
    "Fits",
    "LimitCycle",
    "Limits",
    "Margin",
    "Margins",
    "Measurements",
    "MotionMap",
    "OperatingPoints",
    "Regime",
    "Region",
    "Rest",
    "Rounds",
    "Row",
    "Separatrix",
    "Share",
    "SlopeAverage",
    "State",
    "Step",
    "StickSlipCycle",
    "Stretch",
    "Study",
    "Theorem",
    "Threshold",
    "Trade",
    "Tradeoff",
    "Trajectories",
    "Trajectory",
    "Unknown",
    "Verdict",
]
