"""`study`: everything about one operating point; a part that cannot be computed is named with the reason."""

import math
import time
import warnings
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple, TypeVar

import numpy as np
import sympy as sp

from stickslip_sym.comparison.compare import Answer, compare
from stickslip_sym.comparison.study.pictures import (
    ALT,
    CAPTIONS,
    draw_law,
    draw_phase_plane,
    draw_plane,
    draw_time,
    picture,
)
from stickslip_sym.comparison.study.plane import Plane, plane
from stickslip_sym.core import symbols
from stickslip_sym.core.deadline import time_limit as limited
from stickslip_sym.core.errors import InputError, InputWarning, NoClosedForm, StickSlipError
from stickslip_sym.core.symbols import QUANTITIES
from stickslip_sym.core.uncertain import UFloat
from stickslip_sym.criteria.criterion import catalogue
from stickslip_sym.formula.closed_form import ClosedForm, derive
from stickslip_sym.model.fitting.result import Averaged, ByLaw, Fit, Fits
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.measured.measurements import Measurements
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.margins.margins import Margin, Margins, carried_by, margins
from stickslip_sym.motion.orbits.orbit import obstacle
from stickslip_sym.motion.regimes.regime import Regime, regime
from stickslip_sym.motion.simulation.simulate import simulate
from stickslip_sym.motion.simulation.trajectory import Trajectory
from stickslip_sym.motion.thresholds.threshold import Threshold, pure_slip_damping
from stickslip_sym.output import printing
from stickslip_sym.output.browser import print_to_pdf
from stickslip_sym.output.files import write_text
from stickslip_sym.output.markup import Markup, element
from stickslip_sym.output.page.render import equation, now, render, with_error
from stickslip_sym.output.tables import duration

__all__ = ["Study", "study"]

_PERIODS = 8  # of free vibration, that the motion is shown for
_EACH = 20.0  # seconds that one part may take
_RTOL = 1e-10  # of thresholds
_LOOSE = 1e-6  # of critical values
_ROUGH = 1e-4  # of thresholds that are averaged over laws
_SHARE = 5  # of the time for a part, that one quantity, method or law may take
_SAMPLES = 200  # for the probability, where a threshold takes less than a millisecond

_REACH = 3.0
"""Times a value, and its inverse: where margins are sought; no decision turns on those beyond."""
_LEAST = 0.001
"""A probability below it is not told from 0."""
_TEMPLATE = Path(__file__).with_name("study.html")
_WIDEST = 260  # characters of a formula as text, up to which it fits a sheet when it is set
_LONGEST = 1500  # characters that are shown at all
_LONGEST_NAME = 80  # characters of a heading
_DIGITS = 10  # of a value, at most

Part = TypeVar("Part")


@dataclass(frozen=True, repr=False)
class Study:
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
    def nearest(self) -> Margin | None:
        """The quantity that reaches the threshold by the smallest change; None where none does."""
        first = next(iter(self.margins.rows), None) if self.margins is not None else None
        return first if first is not None and math.isfinite(first.change) else None

    @property
    def probability(self) -> float | None:
        """That stick-slip is possible, c below the threshold; averaged over laws, if more than one fits."""
        if self.choice is not None and self.by_law:
            return self.choice.above(self.oscillator.c, self.standard_error("c") or 0.0)
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
        c, own = self.oscillator.c, self.standard_error("c") or 0.0
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
            if min(chance, 1 - chance) < _LEAST:
                shown = f"< {_LEAST:g}" if chance < _LEAST else f"> {1 - _LEAST:g}"
            remarks.append(f"P {shown} that stick-slip is possible")
        return text + (f" ({', '.join(remarks)})" if remarks else "")

    def value(self, name: str) -> float:
        """Return the value of a quantity or a parameter in SI units."""
        known = self.law.values
        return float(known[name]) if name in known else float(getattr(self.oscillator, name))

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
        return _page(self)

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
        """Print the page to a PDF file of A4 sheets, by a chromium that is on the path.

        Raises
        ------
        InputError
            If there is no browser, it cannot print, or the file cannot be written.
        """
        target = Path(path)
        print_to_pdf(self.page, target)
        return target

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
        if self.nearest is not None:
            change = f"{self.nearest.name} by {100 * self.nearest.change:+.3g} %"
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


def _point(found: Study) -> str:
    """Return the quantities of the operating point in a line, with units, defaults marked."""
    return ", ".join(
        f"{name} = {getattr(found.oscillator, name):g} {QUANTITIES[name].unit}"
        f"{' (default)' if name in found.defaults else ''}"
        for name in ("c", "V", "N", "m", "k")
    )


def study(
    law: FrictionLaw | Fit | Fits | str,
    osc: Oscillator,
    *,
    errors: Mapping[str, str | UFloat] | None = None,
    measured: Measurements | None = None,
    name: str | None = None,
    defaults: Iterable[str] = (),
    time_limit: float | None = None,
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
    'No stick-slip: c = 2 is 36 % above the threshold 1.472 kg/s'
    """
    begin = time.perf_counter()
    fit = law.best if isinstance(law, Fits) else law if isinstance(law, Fit) else None
    friction = fit.law.bind(**fit.uncertain) if fit is not None else as_law(law)
    friction.function("numpy")  # refuses a law with parameters that have no value
    friction.at_speeds(np.array([osc.V]))  # and one that was not measured so far
    carried = carried_by(osc, errors or {})
    with limited(time_limit):  # refuses what is no time
        refused: dict[str, str] = {}
    seconds = _EACH if time_limit is None else time_limit

    def part(what: str, compute: Callable[[], Part]) -> Part | None:
        try:
            with limited(seconds):
                return compute()
        except StickSlipError as error:
            refused[what] = str(error)
            return None

    point = {key: carried.get(key, getattr(osc, key)) for key in "VNmk"}
    rest = {key: value for key, value in point.items() if key != "V"}
    samples = _SAMPLES if obstacle(friction, osc.V) is None else 0
    each = seconds / _SHARE
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        answers = compare(friction, rtol=_RTOL, time_limit=each, **point).answers
        forms = {key: _form(friction, key, seconds) for key in catalogue}
        motions = part("motions", lambda: regime(friction, osc))
        periods = _PERIODS * 2 * math.pi / osc.omega
        motion = part("motion in time", lambda: simulate(friction, osc, t_end=periods, x0=0.0, v0=osc.V))
        curves = part("plane of c over V", lambda: plane(friction, rest, osc.V))
        found = part(
            "margins",
            lambda: margins(friction, osc, errors=carried, rtol=_LOOSE, samples=samples, reach=_REACH, each=each),
        )
    choice = part("the choice of law", lambda: _average(law, point, each)) if isinstance(law, Fits) else None
    own = [] if fit is None else [text for text in (fit.extrapolation(osc.V), *fit.warnings) if text]
    for text in own:
        warnings.warn(text, InputWarning, stacklevel=2)
    return Study(
        title=name or friction.name or friction.text,
        law=friction,
        oscillator=osc,
        errors=carried,
        fit=fit,
        measured=measured if fit is None else fit.measured,
        answers=answers,
        choice=choice,
        forms=forms,
        regime=motions,
        motion=motion,
        plane=curves,
        margins=found,
        refused=refused,
        warnings=(*own, *_repeated(caught)),
        defaults=tuple(defaults),
        time=now(),
        seconds=time.perf_counter() - begin,
    )


class _Estimate(NamedTuple):
    value: float
    uncertainty: float


def _average(fits: Fits, point: Mapping[str, float | UFloat], seconds: float) -> Averaged:
    """Return the threshold by every law that fits, with its standard error to first order."""

    def threshold(law: FrictionLaw) -> _Estimate:
        V, N, m, k = (point[key] for key in "VNmk")
        one = pure_slip_damping(law, V=V, N=N, m=m, k=k, rtol=_ROUGH, time_limit=seconds)
        return _Estimate(float(one.value), 0.0 if one.budget is None else float(one.budget.uncertainty))

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InputWarning)  # of laws that are not studied
        return fits.average(threshold)


def _form(law: FrictionLaw, criterion: str, seconds: float) -> ClosedForm | str:
    """Return a closed form, without a search by SymPy's integrator, which may take minutes."""
    if law.curve is not None:
        return "exact, piece by piece, and too long for a page; derive gives it"
    try:
        return derive(law, criterion, time_limit=max(seconds, 1e-3), search=False)
    except (NoClosedForm, InputError) as error:
        return str(error)


def _repeated(caught: Iterable[warnings.WarningMessage]) -> tuple[str, ...]:
    """Repeat warnings, each once, and return those on the input."""
    texts = {str(one.message): one for one in caught}
    for text, one in texts.items():
        warnings.warn(text, one.category, stacklevel=3)
    return tuple(text for text, one in texts.items() if issubclass(one.category, InputWarning))


# -- the page -----------------------------------------------------------------------------------------


def _page(study: Study) -> str:
    """Return the whole page."""
    title = study.title if len(study.title) <= _LONGEST_NAME else f"{study.title[: _LONGEST_NAME - 1]}…"
    return render(
        _TEMPLATE,
        title=f"Stick–slip study: {title}",
        study=study,
        state=_state(study),
        value=lambda name: with_error(study.value(name), study.standard_error(name)),
        number_of=study.value,
        error_of=study.standard_error,
        uncertain=[one.name for one in study.margins.rows if study.standard_error(one.name)]
        if study.margins
        else [],
        units=QUANTITIES,
        digits=_digits,
        duration=duration,
        reach=_REACH,
        least=_LEAST,
        figures=[(key, uri, ALT[key], CAPTIONS[key]) for key, uri in _pictures(study).items()],
        slopes=_slopes(study),
        formulas=_formulas(study),
        time=f"{study.time} in {study.seconds:.1f} s",
    )


def _pictures(study: Study) -> dict[str, str]:
    """Return the figures as data URIs, by name; one whose part could not be computed is not among them."""
    law, V, regime, motion, curves = study.law, study.oscillator.V, study.regime, study.motion, study.plane
    drawn = {"law": picture(lambda ax: draw_law(ax, law, V, measured=study.measured, fit=study.fit))}
    if curves is not None:
        drawn["plane"] = picture(lambda ax: draw_plane(ax, curves, study.oscillator, study.errors))
    if motion is not None:
        drawn["time"] = picture(lambda ax: draw_time(ax, motion))
    if regime is not None:
        drawn["phase"] = picture(lambda ax: draw_phase_plane(ax, regime, motion))
    return drawn


def _state(study: Study) -> str:
    if study.regime is None or study.regime.coexist:
        return "either"
    return "rests" if study.regime.stick_slip is None else "sticks"


def _digits(found: Threshold) -> int:
    """Return the digits of a threshold that its own error leaves."""
    error = found.relative_error
    return _DIGITS if not error else min(max(1 - math.floor(math.log10(error)), 2), _DIGITS)


def _slopes(study: Study) -> object:
    """Return how the threshold changes with each quantity and parameter, or why that is not known."""
    if study.threshold is None:
        return "There is no threshold here."
    try:
        return study.threshold.sensitivity
    except StickSlipError as error:
        return f"Not found: {error}"


def _formulas(study: Study) -> list[tuple[str, str, str]]:
    law = study.law
    parts: list[tuple[str, str, str]] = (
        []
        if law.curve is not None
        else [("law", _formula(sp.Function("mu")(symbols.v), law.expr), "friction law")]
    )
    for criterion, form in study.forms.items():
        name = criterion.replace("_", " ")
        if isinstance(form, ClosedForm):
            about = f"{name}, {form.verdict.status.value}: {form.verdict.evidence}"
            parts.append((criterion, _formula(symbols.c, form.expr), about))
        else:
            parts.append((criterion, "", f"{name}: {form}"))
    return parts


def _formula(left: sp.Expr, expr: sp.Expr) -> Markup:
    text = printing.text(expr)
    if len(text) <= _WIDEST:
        return equation(left, expr)
    if len(text) <= _LONGEST:
        return element("code", f"{printing.text(left)} = {text}")
    return element("p", f"A formula of {len(text)} characters; derive gives it.", class_="note")
