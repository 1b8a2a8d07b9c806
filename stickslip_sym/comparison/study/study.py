"""`study`: everything about one operating point; a part that cannot be computed is named with the reason."""

import math
import time
import warnings
from collections.abc import Callable, Iterable, Mapping
from functools import cached_property
from pathlib import Path
from typing import NamedTuple, TypeVar

import numpy as np

from stickslip_sym.comparison.compare import answer
from stickslip_sym.comparison.study.findings import Findings
from stickslip_sym.comparison.study.page import REACH, page
from stickslip_sym.comparison.study.plane import plane
from stickslip_sym.core.deadline import time_limit as limited
from stickslip_sym.core.errors import InputError, InputWarning, NoClosedForm, StickSlipError
from stickslip_sym.core.uncertain import UFloat
from stickslip_sym.criteria.criterion import catalogue
from stickslip_sym.formula.closed_form import ClosedForm, derive
from stickslip_sym.model.fitting.result import Averaged, Fit, Fits
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.measured.measurements import Measurements
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.margins.margins import carried_by, margins
from stickslip_sym.motion.orbits.orbit import obstacle
from stickslip_sym.motion.regimes.attractors import regime
from stickslip_sym.motion.simulation.simulate import simulate
from stickslip_sym.motion.thresholds.methods import methods
from stickslip_sym.motion.thresholds.threshold import pure_slip_damping
from stickslip_sym.output.browser import print_to_pdf
from stickslip_sym.output.files import write_text
from stickslip_sym.output.page.document import now

__all__ = ["Study", "study"]

_PERIODS = 8  # of free vibration, that the motion is shown for
_EACH = 20.0  # seconds that one part may take
_RTOL = 1e-10  # of thresholds
_LOOSE = 1e-6  # of critical values
_ROUGH = 1e-4  # of thresholds that are averaged over laws
_SHARE = 5  # of the time for a part, that one quantity, method or law may take
_SAMPLES = 200  # for the probability, where a threshold takes less than a millisecond

Part = TypeVar("Part")


class Study(Findings):
    """Everything about one operating point, and its page; `Findings` has the attributes."""

    @cached_property
    def page(self) -> str:
        """The page: HTML that is XML too, needs no script, and refers to nothing elsewhere.

        Raises
        ------
        InputError
            If matplotlib, jinja2 or latex2mathml is not installed.
        """
        return page(self)

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
        answers = tuple(answer(friction, point, method, rtol=_RTOL, time_limit=each) for method in methods())
        forms = {key: _form(friction, key, seconds) for key in catalogue}
        motions = part("motions", lambda: regime(friction, osc))
        periods = _PERIODS * 2 * math.pi / osc.omega
        motion = part("motion in time", lambda: simulate(friction, osc, t_end=periods, x0=0.0, v0=osc.V))
        curves = part("plane of c over V", lambda: plane(friction, rest, osc.V))
        found = part(
            "margins",
            lambda: margins(friction, osc, errors=carried, rtol=_LOOSE, samples=samples, reach=REACH, each=each),
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
