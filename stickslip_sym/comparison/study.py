"""`study`: everything about one operating point; a part that cannot be computed is named with the reason."""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Literal

from stickslip_sym.comparison.compare import EXPLAINED_RTOL, Row, compare
from stickslip_sym.comparison.decision import Decision, unmeasured_part, value_text
from stickslip_sym.comparison.plane import Plane, plane
from stickslip_sym.core.deadline import require_seconds
from stickslip_sym.core.deadline import time_limit as limited
from stickslip_sym.core.errors import InputWarning, StickSlipError
from stickslip_sym.core.numbers import require_type
from stickslip_sym.core.progress import StepOfWork, report_steps_to, steps
from stickslip_sym.core.seconds import SECONDS_OF_PART
from stickslip_sym.core.uncertain import UFloat
from stickslip_sym.criteria.criterion import catalogue
from stickslip_sym.formula.closed_form import ClosedForm, derive
from stickslip_sym.model.fitting.averaged import Averaged
from stickslip_sym.model.fitting.result import Fit, Fits
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.measured.measurements import Measurements
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.margins.margins import Margin, Margins, carried_by, margins, margins_of
from stickslip_sym.motion.regimes.attractors import ATTRACTORS
from stickslip_sym.motion.regimes.regime import Regime, regime
from stickslip_sym.motion.simulation.simulate import simulate
from stickslip_sym.motion.simulation.trajectory import Trajectory
from stickslip_sym.motion.thresholds.threshold import Threshold, pure_slip_damping
from stickslip_sym.motion.thresholds.uncertainty import Budget
from stickslip_sym.output.data import DataResult
from stickslip_sym.output.files import write_text
from stickslip_sym.output.shown import Report, views_of
from stickslip_sym.output.tables import now

_PERIODS_SHOWN = 8  # of free vibration, that the motion is shown for
_PROBABILITY_SAMPLES = 200  # for the probability, where a threshold takes less than a millisecond

REACH = 3.0
"""Times a value, and its inverse: where margins are sought, and motions are shown; none beyond decides."""
DERIVATIVES = "derivatives of the threshold"


@dataclass(frozen=True, repr=False)
class Study(Report, DataResult):
    """Everything about one operating point, and its page; `study` makes it.

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
    answers : tuple of Row
        Thresholds by every method.
    threshold : Threshold or None
        By simulation or by the orbit, the more accurate; None where neither has one.
    sensitivity : mapping of str to float, or None
        Derivatives of the threshold.
    nonlinearity : float or None
        The standard error of the threshold to second order over that to first.
    choice : Averaged or None
        The threshold by every law that fits the measurements, and its average; None where none was fitted.
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

    reported = (
        "warnings", "headline", "verdict", "regime", "answers", "choice", "probability", "margins", "forms",
        "fit", "refused", "defaults", "seconds", "decision",
    )  # fmt: skip

    title: str
    law: FrictionLaw
    oscillator: Oscillator
    errors: Mapping[str, UFloat]
    fit: Fit | None
    measured: Measurements | None
    answers: tuple[Row, ...]
    threshold: Threshold[float] | None
    sensitivity: Mapping[str, float] | None
    nonlinearity: float | None
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
    def budget(self) -> Budget | None:
        """Which standard error brings how much of the threshold's; None where none does, or it was not found."""
        if self.threshold is None or self.sensitivity is None:
            return None
        return self.threshold.budget

    @cached_property
    def decision(self) -> Decision | None:
        """Whether c is below the threshold, and how sure that is; None where there is no threshold.

        The headline, the page, the text and JSON take what they say from it.
        """
        c = self.oscillator.c
        c_error = self.standard_error("c") or 0.0
        if self.choice is not None:
            return Decision.of_measured(c, c_error, self.choice)
        if self.threshold is None or self.fit is not None:
            return None
        error = 0.0 if self.budget is None else float(self.budget.uncertainty)
        return Decision(c, c_error, float(self.threshold.value), error, self._chance_of_values)

    @property
    def _chance_of_values(self) -> float | None:
        """The probability that c is below the threshold of a law whose values carry standard errors."""
        if self.margins is None:
            return None
        sampled = self.margins.sampled
        if sampled is None or math.isnan(sampled.probability):
            return self.margins.probability
        return sampled.probability

    @property
    def needed(self) -> tuple[float, float | None] | None:
        """The pure-slip damping and its standard error: averaged over laws, if more than one fits."""
        if self.decision is None:
            return None
        return self.decision.value, self.decision.standard_error or None

    @property
    def nearest(self) -> Margin | None:
        """The quantity that reaches the threshold by the smallest change; None where none does."""
        rows = () if self.margins is None else self.margins.rows
        return next((row for row in rows if math.isfinite(row.change)), None)

    @property
    def probability(self) -> float | None:
        """The probability that c is below the threshold; None where that is not known, or nothing is uncertain."""
        return None if self.decision is None else self.decision.probability

    @property
    def _contradicted(self) -> bool:
        """Whether the motions are those of a law whose threshold is on the other side of c than the decision's."""
        if self.decision is None or self.threshold is None or self.fit is None:
            return False
        return self.decision.below != bool(self.oscillator.c < self.threshold.value)

    @property
    def _decision_in_words(self) -> str:
        """What the motions come to: without bound first, then stick-slip."""
        motions = self.regime
        if self.fit is not None and (self.decision is None or self.decision.below is None):
            return "Whether there is stick-slip is not decided by these measurements"
        if self.decision is not None and self._contradicted:
            return "Stick-slip is possible" if self.decision.below else "There is no stick-slip"
        if motions is None:
            return "Whether there is stick-slip was not found"
        if motions.unbounded:
            kinds = [kind.region.name for kind in ATTRACTORS if kind.of(motions)]
            others = f", and others come to {' or '.join(kinds)}" if kinds else ""
            return f"{'Motions far out grow' if kinds else 'Every motion grows'} without bound{others}"
        if motions.stick_slip and motions.coexist:
            return "Stick-slip is possible, depending on the initial condition"
        if motions.stick_slip and not motions.undecided:
            return "There is stick-slip from every initial condition"
        if motions.undecided:
            return "Whether there is stick-slip is not decided"
        if any(cycle.stable for cycle in motions.overtaking):
            return "There is no stick-slip, but slip that overtakes the belt"
        return "There is no stick-slip"

    @property
    def state(self) -> Literal["sticks", "either", "rests"]:
        """How the decision is coloured; vibration beyond the belt's speed counts as stick-slip."""
        motions = self.regime
        if self._contradicted:
            if self.decision is not None and self.decision.below is False:
                return "rests"
            return "either"
        if motions is None or motions.coexist or motions.undecided:
            return "either"
        if motions.stick_slip or motions.unbounded or any(cycle.stable for cycle in motions.overtaking):
            return "sticks"
        return "rests"

    @property
    def headline(self) -> str:
        """The decision: whether there is stick-slip, and how far the damping is from the threshold."""
        words = self._decision_in_words
        if self.decision is None:
            return f"{words}, and no threshold was found to compare c with."
        return f"{words}: {self.decision.statement}."

    @property
    def verdict(self) -> str:
        """The motions that attract others, in a sentence."""
        if self.regime is None:
            return f"The motions were not found: {self.refused['motions']}."
        motions = [str(attractor) for attractor in self.regime.attractors]
        undecided = "".join(f" Undecided: {text}." for text in self.regime.undecided)
        if len(motions) > 1:
            some = f"The initial condition decides whether a motion comes to {' or to '.join(motions)}"
        else:
            some = f"Motions come to {motions[0]}" if motions else "There is no attractor"
            if self.regime.misses_an_attractor:
                some = "What motions come to was not found"
        far = "far out grow" if motions else "all grow"
        return f"{some}{f'; motions {far} without bound' if self.regime.unbounded else ''}.{undecided}"

    @property
    def findings(self) -> list[str]:
        """What the study says, in sentences: the decision, the attractors, the threshold, the nearest change."""
        sentences = [self.headline, self.verdict]
        if self.threshold is not None:
            by = f" by {self.fit.name}" if self.fit is not None else ""
            sentences.append(f"The pure-slip damping{by} is {self.threshold}.")
        if self.choice is not None and len(self.choice.rows) > 1:
            laws = [
                f"{value_text(row.value, row.standard_error)} kg/s by {row.law} (weight {row.weight:.2g})"
                for row in self.choice.rows
            ]
            sentences.append(f"It is {', '.join(laws)}.")
        if self.nearest is not None:
            change = f"{100 * self.nearest.change:+.3g} % in {self.nearest.name}"
            sentences.append(f"The smallest change of one quantity that reaches the threshold is {change}.")
        others = {part: why for part, why in self.refused.items() if part != "motions"}  # those the verdict has
        return sentences + [f"The {part} could not be computed: {why}." for part, why in others.items()]

    def value(self, name: str) -> float:
        """Return the value of a quantity or a parameter in SI units."""
        known = self.law.values
        if name in known:
            return float(known[name])
        return float(getattr(self.oscillator, name))

    def standard_error(self, name: str) -> float | None:
        """Return the standard error of a quantity or a parameter; None if it carries none."""
        carried = self.law.uncertain.get(name) or self.errors.get(name)
        return None if carried is None else carried.std_dev

    @cached_property
    def page(self) -> str:
        """The page: HTML that is XML too, needs no script, and refers to nothing elsewhere.

        Raises
        ------
        InputError
            If matplotlib, jinja2 or latex2mathml is not installed.
        """
        return views_of(self).page(self)

    def save(self, path: str | Path) -> Path:
        """Write the page to a file.

        Raises
        ------
        InputError
            If it cannot be written, or what pages need is not installed.
        """
        target = Path(path)
        write_text(target, self.page)
        return target

    def print(self, path: str | Path) -> Path:
        """Print the page to a PDF file of two A4 sheets, by a chromium that is on the path.

        Letters get smaller where it would not fit, down to 6.5 points; what is longer still takes more sheets.

        Raises
        ------
        InputError
            If there is no browser, it cannot print, or the file cannot be written.
        """
        target = Path(path)
        views_of(self).print_page(self, target)
        return target

    def __repr__(self) -> str:
        return f"Study: {self.headline}"


def study(
    law: FrictionLaw | Fit | Fits | str,
    osc: Oscillator,
    *,
    errors: Mapping[str, str | UFloat] | None = None,
    measured: Measurements | None = None,
    name: str | None = None,
    defaults: Iterable[str] = (),
    time_limit: float | None = None,
    progress: Callable[[str], None] | None = None,
) -> Study:
    """Return everything about one operating point: thresholds, motions, sensitivities, margins, formulas.

    Parameters
    ----------
    law : FrictionLaw, Fit, Fits, or a law's name or formula
        With all parameters bound. A fit brings its covariance, and its measurements; of several the best counts,
        and the threshold is averaged over those that fit too.
    osc : Oscillator
    errors : mapping of str to number with a standard error, optional
        V, N, m, k or c with theirs, as in ``{"N": "9.81+/-0.1"}``; their values are those of `osc`.
    measured : Measurements, optional
        To be shown with the law, if it goes through measured points.
    name : str, optional
        Title of the page; the law's name or formula if not given.
    defaults : iterable of str
        Quantities and parameters whose values are defaults, to be marked.
    time_limit : float, optional
        Seconds for each part, 20 if not given; one that takes longer is named instead.
    progress : callable, optional
        Called with the name of each part before it is computed.

    Returns
    -------
    Study
        `save` writes the page, `print` a PDF.

    Raises
    ------
    InputError
        For a law with parameters that have no value, or an error of what has none.

    Warns
    -----
    InputWarning
        Where the law of a fit is extrapolated, and as the functions that it calls; each warning once, and on the
        page too.

    Examples
    --------
    >>> from stickslip_sym import Oscillator, laws
    >>> found = study(laws.linear.typical(), Oscillator(m=1, k=100, c=2, V=0.5, N=9.81))
    >>> found.headline
    'There is no stick-slip: c = 2 kg/s is 36 % above the threshold of 1.472 kg/s.'
    """
    begin = time.perf_counter()
    require_type("measured", measured, Measurements | None, "what read_measurements gives")
    require_type("name", name, str | None, "text")
    require_type("defaults", defaults, Iterable, "an iterable of names")
    fit: Fit | None = None
    fits: Fits | None = None
    if isinstance(law, Fit):
        law = Fits([law], law.measured, {})
    if isinstance(law, Fits):
        fit = law.best
        fits = law
        friction = fit.law.bind(**fit.uncertain)
    else:
        friction = as_law(law)
    friction.require_values()
    carried = carried_by(osc, errors or {})
    friction.require_speed(osc.V)
    limit = require_seconds(time_limit)
    seconds = SECONDS_OF_PART if limit is None else limit
    subject = _Subject(friction, osc, carried, fits, seconds)
    own = []
    if fit is not None:
        own = [text for text in (fit.extrapolation(osc.V), *fit.warnings) if text]
    with warnings.catch_warnings(record=True) as caught, report_steps_to(progress and _named_to(progress)):
        warnings.simplefilter("always")
        parts, refused = _computed(subject)
    said: dict[str, type[Warning]] = dict.fromkeys(own, InputWarning)
    said |= {str(warning.message): warning.category for warning in caught}
    for text, category in said.items():
        warnings.warn(text, category, stacklevel=2)
    return Study(
        title=name or friction.name or friction.text,
        law=friction,
        oscillator=osc,
        errors=carried,
        fit=fit,
        measured=measured if fit is None else fit.measured,
        threshold=subject.threshold,
        refused=refused,
        warnings=tuple(text for text, category in said.items() if issubclass(category, InputWarning)),
        defaults=tuple(defaults),
        time=now(),
        seconds=time.perf_counter() - begin,
        **parts,
    )


def _named_to(progress: Callable[[str], None]) -> Callable[[StepOfWork], None]:
    """Return what hears of parts, and passes on the name of each that begins."""
    return lambda step: progress(step.what) if step.done < step.total else None


# -- the parts: each has a name, a time limit, and the one threshold -----------------------------------


@dataclass
class _Subject:
    """What a study is of, and the threshold that its parts share, once it is there."""

    law: FrictionLaw
    oscillator: Oscillator
    carried: Mapping[str, UFloat]
    fits: Fits | None
    seconds: float  # that each part may take
    threshold: Threshold[float] | None = None

    @property
    def point(self) -> dict[str, Any]:
        """V, N, m and k with their standard errors."""
        return {name: self.carried.get(name, getattr(self.oscillator, name)) for name in "VNmk"}

    @property
    def each(self) -> float:
        """The seconds that one quantity, method or law of a part may take."""
        return self.seconds / len(self.point)


def _computed(subject: _Subject) -> tuple[dict[str, Any], dict[str, str]]:
    """Return every part by its attribute, None for one that was refused, and the reasons by their names."""
    parts = dict[str, Any]()
    refused = dict[str, str]()
    with steps(_PARTS, lambda attribute: _PARTS[attribute][0]) as attributes:
        for attribute in attributes:
            what, compute = _PARTS[attribute]
            if attribute in _LIMITED_WITHIN:
                parts[attribute] = compute(subject)
                continue
            try:
                with limited(subject.seconds):
                    parts[attribute] = compute(subject)
            except StickSlipError as error:
                parts[attribute], refused[what] = None, str(error)
    return parts, refused


def _stated_error(threshold: Threshold[float]) -> float:
    return math.inf if threshold.relative_error is None else threshold.relative_error


def _answers(subject: _Subject) -> tuple[Row, ...]:
    """Return thresholds by every method, and keep the most accurate of those that are not proved for the rest."""
    rows = compare(subject.law, time_limit=subject.each, **subject.point).rows
    thresholds = [row.threshold for row in rows if row.method in ("simulation", "orbit")]
    known = [threshold for threshold in thresholds if threshold is not None]
    subject.threshold = min(known, key=_stated_error, default=None)
    return rows


def _forms(subject: _Subject) -> dict[str, ClosedForm | str]:
    return {name: _form(subject.law, name, subject.seconds) for name in catalogue}


def _form(law: FrictionLaw, criterion: str, seconds: float) -> ClosedForm | str:
    """Return a closed form, without a search by SymPy's integrator, which may take minutes."""
    if law.curve is not None:
        return "exact, piece by piece, and too long for a page; derive gives it"
    try:
        return derive(law, criterion, time_limit=max(seconds, 1e-3), search=False)
    except StickSlipError as error:
        return str(error)


def _motions(subject: _Subject) -> Regime:
    return regime(subject.law, subject.oscillator)


def _motion(subject: _Subject) -> Trajectory:
    """Return the motion from x = 0 with the belt's speed."""
    osc = subject.oscillator
    return simulate(subject.law, osc, t_end=_PERIODS_SHOWN * 2 * math.pi / osc.omega, x0=0.0, v0=osc.V)


def _thresholds_over_speed(subject: _Subject) -> Plane:
    rest = {name: subject.point[name] for name in "Nmk"}
    return plane(subject.law, rest, subject.oscillator.V)


def _margins(subject: _Subject) -> Margins:
    """Return the margins, where laws were fitted without a probability: the choice of law has one of its own."""
    law = subject.law
    osc = subject.oscillator
    carried = subject.carried
    quick = law.bound.obstacle(2 * osc.V) is None
    how: dict[str, Any] = {
        "samples": _PROBABILITY_SAMPLES if quick and subject.fits is None else 0,
        "rtol": EXPLAINED_RTOL,
        "reach": REACH,
        "each": subject.each,
    }
    if subject.threshold is None:
        found = margins(law, osc, errors=carried, **how)
    else:
        found = margins_of(subject.threshold, osc, carried.get("c"), **how)
    if subject.fits is None:
        return found
    return replace(found, probability=None)


def _sensitivity(subject: _Subject) -> Mapping[str, float] | None:
    return None if subject.threshold is None else subject.threshold.sensitivity


def _nonlinearity(subject: _Subject) -> float | None:
    return None if subject.threshold is None else subject.threshold.nonlinearity


def _choice(subject: _Subject) -> Averaged | None:
    """Return the threshold by every law that fits, and its average."""

    def estimate(law: FrictionLaw) -> SimpleNamespace:
        shared = subject.threshold if law == subject.law else None
        threshold = shared or pure_slip_damping(law, **subject.point, rtol=EXPLAINED_RTOL, time_limit=subject.each)
        return SimpleNamespace(
            value=threshold.value,
            uncertainty=threshold.budget and threshold.budget.uncertainty,
            budget=threshold.budget,
            unmeasured=unmeasured_part(law, lowest, subject.oscillator.V, subject.oscillator.N),
        )

    if subject.fits is None:
        return None
    lowest = float(subject.fits.measured.v[0])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InputWarning)  # of laws that are not studied
        return subject.fits.average(estimate)


_PARTS: dict[str, tuple[str, Callable[[_Subject], Any]]] = {
    "answers": ("thresholds by every method", _answers),
    "forms": ("closed forms", _forms),
    "regime": ("motions", _motions),
    "motion": ("motion in time", _motion),
    "plane": ("plane of c over V", _thresholds_over_speed),
    "margins": ("margins", _margins),
    "sensitivity": (DERIVATIVES, _sensitivity),
    "nonlinearity": ("second order of its standard error", _nonlinearity),
    "choice": ("choice of law", _choice),
}
"""Attributes of a study, what they are called, and how they are computed; the first gives the threshold of all."""
_LIMITED_WITHIN = ("answers", "forms")
"""Parts that say of each method or criterion why it has none, and are never refused as a whole."""
