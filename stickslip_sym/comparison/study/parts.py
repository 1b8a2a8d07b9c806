"""`study`: each part computed by itself; one that cannot be is named with the reason, and leaves the others."""

import math
import time
import warnings
from collections.abc import Callable, Iterable, Mapping
from typing import TypeVar

import numpy as np

from stickslip_sym.comparison.study.findings import REACH, Answer
from stickslip_sym.comparison.study.plane import plane
from stickslip_sym.comparison.study.study import Study
from stickslip_sym.core.deadline import time_limit as limited
from stickslip_sym.core.errors import InputError, InputWarning, NoClosedForm, StickSlipError
from stickslip_sym.core.uncertain import UFloat
from stickslip_sym.criteria.criterion import catalogue
from stickslip_sym.formula.derivation.closed_form import ClosedForm, derive
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.measured.fit import Fit
from stickslip_sym.model.measured.fits import Fits
from stickslip_sym.model.measured.measurements import Measurements
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.margins.margins import carried_by, margins
from stickslip_sym.motion.orbits.orbit import obstacle
from stickslip_sym.motion.regimes.attractors import regime
from stickslip_sym.motion.simulation.automaton import simulate
from stickslip_sym.motion.simulation.trajectory import Trajectory
from stickslip_sym.motion.thresholds.rungs import rungs
from stickslip_sym.motion.thresholds.threshold import pure_slip_damping
from stickslip_sym.output.page.document import now

__all__ = ["study"]

_PERIODS = 8  # of free vibration, that the motion is shown for
_EACH = 20.0  # seconds that one part may take
_RTOL = 1e-10  # of thresholds
_LOOSE = 1e-6  # of critical values
_SHARE = 5  # of the time for margins, that one quantity may take; and of that for thresholds, one rung
_SAMPLES = 200  # for the probability, where a threshold takes less than a millisecond

Part = TypeVar("Part")


def study(
    law: FrictionLaw | Fit | Fits,
    osc: Oscillator,
    *,
    errors: Mapping[str, str | UFloat] | None = None,
    measured: Measurements | None = None,
    assumed: Iterable[str] = (),
    time_limit: float | None = None,
) -> Study:
    """Return everything about one operating point: thresholds, motions, sensitivities, margins, formulas.

    Parameters
    ----------
    law : FrictionLaw, Fit or Fits
        With all parameters bound. A fit brings its covariance, and its measurements; of several the best counts.
    osc : Oscillator
    errors : mapping of str to number with a standard error, optional
        V, N, m, k or c with theirs, as in ``{"N": "9.81+/-0.1"}``; their values are those of `osc`.
    measured : Measurements, optional
        To be shown with the law, if it goes through measured points.
    assumed : iterable of str
        Sentences on what else was assumed, for the page.
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
        As the functions that it calls; each warning once, and on the page too.

    Examples
    --------
    >>> from stickslip_sym import Oscillator, laws
    >>> found = study(laws.linear.typical(), Oscillator(m=1, k=100, c=4, V=0.5, N=9.81))
    >>> found.verdict
    'rest at x = 0.04905 m'
    """
    begin = time.perf_counter()
    fit = law.best if isinstance(law, Fits) else law if isinstance(law, Fit) else None
    friction = law if fit is None else _fitted(fit)
    assert isinstance(friction, FrictionLaw)
    friction.function("numpy")  # refuses a law with parameters that have no value
    friction.at_speeds(np.array([osc.V]))  # and one that was not measured so far
    carried = carried_by(osc, errors or {})
    with limited(time_limit):  # refuses what is no time
        refused: dict[str, str] = {}
    seconds = _EACH if time_limit is None else time_limit

    def part(name: str, compute: Callable[[], Part]) -> Part | None:
        try:
            with limited(seconds):
                return compute()
        except StickSlipError as error:
            refused[name] = str(error)
            return None

    smooth = obstacle(friction, osc.V) is None
    scene = {name: carried.get(name, getattr(osc, name)) for name in "VNmk"}
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        answers = tuple(_answer(friction, scene, method, seconds / _SHARE) for method in rungs())
        forms = {name: _form(friction, name, seconds) for name in catalogue}
        motions = part("motions", lambda: regime(friction, osc))
        motion = part("motion in time", lambda: _motion(friction, osc))
        rest = {name: value for name, value in scene.items() if name != "V"}
        curves = part("plane of c over V", lambda: plane(friction, rest, osc.V))
        found = part(
            "margins",
            lambda: margins(
                friction,
                osc,
                errors=carried,
                rtol=_LOOSE,
                samples=_SAMPLES if smooth else 0,
                reach=REACH,
                each=seconds / _SHARE,
            ),
        )
    doubts = _told(caught)
    return Study(
        law=friction,
        oscillator=osc,
        errors=carried,
        fit=fit,
        measured=measured if fit is None else fit.measured,
        answers=answers,
        forms=forms,
        regime=motions,
        motion=motion,
        plane=curves,
        margins=found,
        refused=refused,
        doubts=(*doubts, *(fit.warnings if fit is not None else ())),
        assumed=tuple(assumed),
        time=now(),
        seconds=time.perf_counter() - begin,
    )


def _fitted(fit: Fit) -> FrictionLaw:
    """Return the law of a fit with the values' standard errors and correlations."""
    law: FrictionLaw = fit.law
    return law.bind(**fit.uncertain)


def _answer(law: FrictionLaw, scene: Mapping[str, float | UFloat], method: str, seconds: float) -> Answer:
    begin = time.perf_counter()
    try:
        found = pure_slip_damping(law, **scene, method=method, rtol=_RTOL, time_limit=seconds)
    except StickSlipError as error:
        return Answer(method, None, str(error), time.perf_counter() - begin)
    return Answer(method, found, "", time.perf_counter() - begin)


def _form(law: FrictionLaw, criterion: str, seconds: float) -> ClosedForm | str:
    """Return a closed form, without a search by SymPy's integrator, which may take minutes."""
    if law.curve is not None:
        return "exact, piece by piece, and too long for a page; derive gives it"
    try:
        return derive(law, criterion, time_limit=max(seconds, 1e-3), search=False)
    except (NoClosedForm, InputError) as error:
        return str(error)


def _motion(law: FrictionLaw, osc: Oscillator) -> Trajectory:
    return simulate(law, osc, t_end=_PERIODS * 2 * math.pi / osc.omega, x0=0.0, v0=osc.V)


def _told(caught: Iterable[warnings.WarningMessage]) -> tuple[str, ...]:
    """Repeat warnings, each once, and return those on the input."""
    texts = {str(one.message): one for one in caught}
    for text, one in texts.items():
        warnings.warn(text, one.category, stacklevel=3)
    return tuple(text for text, one in texts.items() if issubclass(one.category, InputWarning))
