"""`Findings`: what a study finds of one operating point, and the decision that follows."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from stickslip_sym.comparison.compare import Answer
from stickslip_sym.comparison.study.plane import Plane
from stickslip_sym.core.symbols import QUANTITIES
from stickslip_sym.core.uncertain import UFloat
from stickslip_sym.formula.closed_form import ClosedForm
from stickslip_sym.model.fitting.result import Averaged, ByLaw, Fit
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.measured.measurements import Measurements
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.margins.margins import Margins
from stickslip_sym.motion.regimes.attractors import Regime
from stickslip_sym.motion.simulation.trajectory import Trajectory
from stickslip_sym.motion.thresholds.threshold import Threshold

__all__ = ["Findings"]

_RARE = 0.001  # a probability below it is not told from 0


@dataclass(frozen=True, repr=False)
class Findings:
    """Everything about one operating point.

    Attributes
    ----------
    title : str
    law : FrictionLaw
        With values and, where they are known, their standard errors.
    oscillator : Oscillator
    errors : mapping of str to number with a standard error
        Of V, N, m, k and c.
    fit : Fit or None
        Where the law comes from.
    measured : Measurements or None
    answers : tuple of Answer
        Thresholds by every method.
    choice : Averaged or None
        The threshold by every law that fits the measurements, and its average.
    forms : mapping of str to ClosedForm or str
        Closed forms by criterion, or why there is none.
    regime, motion, plane, margins
        Attractors, the motion from x = 0 with the belt's speed, thresholds over belt speed, and margins; None
        where they could not be computed, for the reason in `refused`.
    refused : mapping of str to str
        Names of such parts, with the reason.
    warnings : tuple of str
        An extrapolation first.
    defaults : tuple of str
        Quantities and parameters whose values are defaults.
    time : str
    seconds : float
        That all this took.
    """

    title: str
    law: FrictionLaw
    oscillator: Oscillator
    errors: Mapping[str, UFloat]
    fit: Fit | None
    measured: Measurements | None
    answers: tuple[Answer, ...]
    choice: Averaged | None
    forms: Mapping[str, ClosedForm | str]
    regime: Regime | None
    motion: Trajectory | None
    plane: Plane | None
    margins: Margins | None
    refused: Mapping[str, str]
    warnings: tuple[str, ...]
    defaults: tuple[str, ...]
    time: str
    seconds: float

    @property
    def threshold(self) -> Threshold | None:
        """The pure-slip damping by the orbit, else by simulation; None where neither has one."""
        by_method = {one.method: one.threshold for one in self.answers if one.threshold is not None}
        return by_method.get("orbit") or by_method.get("simulation")

    @property
    def by_law(self) -> tuple[ByLaw, ...]:
        """Law, weight, threshold and its standard error, where more than one law fits the measurements."""
        return self.choice.rows if self.choice is not None and len(self.choice.rows) > 1 else ()

    @property
    def needed(self) -> tuple[float, float | None] | None:
        """The pure-slip damping and its standard error: averaged over laws, if more than one fits."""
        if self.choice is not None and self.by_law:
            return self.choice.value, self.choice.standard_error
        if self.threshold is None:
            return None
        budget = self.threshold.budget
        return float(self.threshold.value), None if budget is None else float(budget.uncertainty)

    @property
    def damping_error(self) -> float:
        """Standard error of the damping c in kg/s."""
        return self.errors["c"].std_dev if "c" in self.errors else 0.0

    @property
    def probability(self) -> float | None:
        """That stick-slip is possible, c below the threshold; averaged over laws, if more than one fits."""
        if self.choice is not None and self.by_law:
            return self.choice.above(self.oscillator.c, self.damping_error)
        if self.margins is None:
            return None
        sampled = self.margins.sampled
        known = sampled is not None and math.isfinite(sampled.probability)
        return sampled.probability if sampled is not None and known else self.margins.probability

    @property
    def verdict(self) -> str:
        """The motions that attract others, in a line."""
        if self.regime is None:
            return f"motions not found: {self.refused['motions']}"
        motions = [str(attractor) for attractor in self.regime.attractors] or ["none"]
        said = " or ".join(motions) + (", by the initial condition" if self.regime.coexist else "")
        return "; ".join([said, *(f"undecided: {text}" for text in self.regime.undecided)])

    @property
    def headline(self) -> str:
        """The decision: whether there is stick-slip, and how far the damping is from the threshold."""
        if self.regime is None:
            words = "Whether there is stick-slip was not found"
        elif self.regime.stick_slip is None:
            words = "Whether there is stick-slip is not decided" if self.regime.undecided else "No stick-slip"
        elif self.regime.coexist:
            words = "Stick-slip possible, depending on the initial condition"
        else:
            words = "Stick-slip from every initial condition"
        if self.needed is None:
            return f"{words}; no threshold was computed to compare c with"
        value, error = self.needed
        c, own = self.oscillator.c, self.damping_error
        apart = 100 * abs(c / value - 1) if value > 0 else 0.0
        apart_text = f"{apart:{'.0f' if apart >= 10 else '.2g'}} % " if value > 0 else ""
        side = "below" if c < value else "above"
        text = f"{words}: c = {_rounded(c, own)} is {apart_text}{side} the threshold {_rounded(value, error)} kg/s"
        if self.by_law:
            text += f", averaged over {len(self.by_law)} laws"
        remarks = []
        if value <= 0:
            remarks.append("no damping is needed")
        if (spread := math.hypot(error or 0.0, own)) > 0:
            remarks.append(f"{abs(c - value) / spread:.2g} standard errors")
        if (chance := self.probability) is not None:
            shown = f"= {chance:.2g}"
            if min(chance, 1 - chance) < _RARE:
                shown = f"< {_RARE:g}" if chance < _RARE else f"> {1 - _RARE:g}"
            remarks.append(f"P {shown} that stick-slip is possible")
        return text + (f" ({', '.join(remarks)})" if remarks else "")

    def __str__(self) -> str:
        lines = [f"warning: {text}" for text in self.warnings]
        lines += [
            self.headline,
            f"{self.law.name or self.law.text}, {_point(self)}",
            f"attractors: {self.verdict}",
        ]
        if self.threshold is not None:
            lines.append(f"pure-slip damping {self.threshold}")
        if self.by_law:
            laws = [
                f"{one.law} ({one.weight:.2g}): {_rounded(one.value, one.standard_error)}" for one in self.by_law
            ]
            lines.append(f"by law (weight): {'; '.join(laws)} kg/s")
        if self.margins is not None and self.margins.rows and math.isfinite(self.margins.rows[0].change):
            first = self.margins.rows[0]
            change = f"{first.name} by {100 * first.change:+.3g} %"
            lines.append(f"smallest change of one quantity to the threshold: {change}")
        lines += [f"{part}: {reason}" for part, reason in self.refused.items()]
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"Study: {'; '.join(str(self).splitlines())}"


def _rounded(value: float, error: float | None) -> str:
    if not error:
        return f"{value:.4g}"
    from uncertainties import ufloat

    return f"{ufloat(value, error):.2u}".replace("+/-", " +/- ")


def _point(found: Findings) -> str:
    """Return the quantities of the operating point in a line, with units, defaults marked."""
    return ", ".join(
        f"{name} = {getattr(found.oscillator, name):g} {QUANTITIES[name].unit}"
        f"{' (default)' if name in found.defaults else ''}"
        for name in ("c", "V", "N", "m", "k")
    )
