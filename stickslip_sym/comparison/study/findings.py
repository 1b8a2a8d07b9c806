"""What a study finds of one operating point."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from stickslip_sym.comparison.study.plane import Plane
from stickslip_sym.core.uncertain import UFloat
from stickslip_sym.formula.derivation.closed_form import ClosedForm
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.measured.fit import Fit
from stickslip_sym.model.measured.measurements import Measurements
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.margins.margins import Margins
from stickslip_sym.motion.regimes.attractors import Regime
from stickslip_sym.motion.simulation.trajectory import Trajectory
from stickslip_sym.motion.thresholds.threshold import Threshold

__all__ = ["REACH", "Answer", "Findings", "quantities"]

REACH = 3.0
"""Times a value, and its inverse: where margins are sought; no decision turns on those beyond."""


@dataclass(frozen=True)
class Answer:
    """What one rung of the ladder says of the threshold.

    Attributes
    ----------
    method : str
    threshold : Threshold or None
        None where there is none, for the reason in `refused`.
    refused : str
    seconds : float
        For the first call, which for an average makes its function.
    """

    method: str
    threshold: Threshold | None
    refused: str
    seconds: float


@dataclass(frozen=True)
class Findings:
    """Everything about one operating point.

    Attributes
    ----------
    law : FrictionLaw
        With values and, where they are known, their standard errors.
    oscillator : Oscillator
    errors : mapping of str to number with a standard error
        Of V, N, m, k and c.
    fit : Fit or None
        Where the law comes from.
    measured : Measurements or None
    answers : tuple of Answer
        Thresholds by every rung.
    forms : mapping of str to ClosedForm or str
        Closed forms by criterion, or why there is none.
    regime, motion, plane, margins
        Attractors, the motion from x = 0 with the belt's speed, thresholds over belt speed, and margins; None
        where they could not be computed, for the reason in `refused`.
    refused : mapping of str to str
        Names of such parts, with the reason.
    doubts : tuple of str
        Warnings.
    assumed : tuple of str
    time : str
    seconds : float
        That all this took.
    """

    law: FrictionLaw
    oscillator: Oscillator
    errors: Mapping[str, UFloat]
    fit: Fit | None
    measured: Measurements | None
    answers: tuple[Answer, ...]
    forms: Mapping[str, ClosedForm | str]
    regime: Regime | None
    motion: Trajectory | None
    plane: Plane | None
    margins: Margins | None
    refused: Mapping[str, str]
    doubts: tuple[str, ...]
    assumed: tuple[str, ...]
    time: str
    seconds: float

    @property
    def name(self) -> str:
        """The law's name, or its formula."""
        return str(self.law.name or self.law.text)

    @property
    def threshold(self) -> Threshold | None:
        """The pure-slip damping by the orbit, else by simulation; None where neither has one."""
        found = {answer.method: answer.threshold for answer in self.answers if answer.threshold is not None}
        return found.get("orbit") or found.get("simulation")

    @property
    def verdict(self) -> str:
        """What the oscillator does, in a line."""
        if self.regime is None:
            return f"motions not found: {self.refused['motions']}"
        motions = [str(attractor) for attractor in self.regime.attractors] or ["no attractor"]
        return " or ".join(motions) + (", by the start" if self.regime.coexist else "")

    def __str__(self) -> str:
        lines = [f"{self.name}, {quantities(self.oscillator)}", self.verdict]
        if self.threshold is not None:
            lines.append(f"pure-slip damping {self.threshold}")
        if self.margins is not None and self.margins.rows and math.isfinite(self.margins.rows[0].change):
            first = self.margins.rows[0]
            change = f"{first.name} by {100 * first.change:+.3g} %"
            lines.append(f"smallest change of one quantity to the threshold: {change}")
        lines += [f"{part}: {why}" for part, why in self.refused.items()]
        return "\n".join(lines)


def quantities(osc: Oscillator, names: Sequence[str] = ("c", "V", "N", "m", "k")) -> str:
    """Return the quantities of an oscillator in a line, with units."""
    from stickslip_sym.core.symbols import QUANTITIES

    return ", ".join(f"{name} = {getattr(osc, name):g} {QUANTITIES[name].unit}" for name in names)
