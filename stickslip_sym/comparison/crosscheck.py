"""The table of `derive`: a criterion in closed form and by quadrature, and the oscillator's own threshold."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import mpmath
import numpy as np

from stickslip_sym.comparison.compare import EXPLAINED_RTOL, TIGHT_RTOL, Comparison, measured
from stickslip_sym.core.aliases import Json, Mpf
from stickslip_sym.core.errors import StickSlipError
from stickslip_sym.core.numbers import Number, exact
from stickslip_sym.core.precision import mp
from stickslip_sym.criteria import quadrature
from stickslip_sym.criteria.criterion import Criterion, harmonic
from stickslip_sym.criteria.rule import gauss_average_of_slope
from stickslip_sym.formula.closed_form import ClosedForm
from stickslip_sym.formula.slope_average import slope_average
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.samples import SampledCurve
from stickslip_sym.motion.thresholds.threshold import pure_slip_damping

_NAMED_DIFFERENCE = 0.05  # relative difference of two values from which on its reason is named
_STIFFNESS_RATIO = 1e4  # times the stiffness: N/(V sqrt(k m)) falls to a hundredth, where friction is weak
_THRESHOLD_DIGITS = 1 - round(math.log10(TIGHT_RTOL))  # of the threshold in the table: the last may be off
_FEWEST_SCATTERED = 5  # points of which one may be left out


@dataclass(frozen=True, repr=False)
class CrossCheck(Comparison):
    """A criterion by its closed form and by quadrature, and the simulated threshold; errors are from the first.

    - `remarks`: what has no number: how far measured points scatter, and why the threshold differs.
    """

    remarks: tuple[str, ...] = ()
    reported = ("rows", "remarks")


def crosscheck(
    law: FrictionLaw, criterion: Criterion, point: Mapping[str, Number], form: ClosedForm | None, digits: int = 50
) -> CrossCheck:
    """Compute a criterion in closed form and by quadrature, and the simulated threshold, and why they differ."""
    numbers = {name: float(exact(value, name)) for name, value in point.items()}
    at = {name: point[name] for name in "VN"}
    methods: dict[str, Callable[[], Mpf | float]] = {}
    if form is not None:
        methods["closed form"] = partial(form.evaluate, digits, **at)
    methods |= {
        f"quadrature, {digits} digits": partial(quadrature.damping, law, criterion, **at, digits=digits),
        "event-driven threshold": partial(_simulated, law, numbers, TIGHT_RTOL),
    }
    error = scatter(law, criterion, numbers["V"], numbers["N"])
    values = list[Mpf | float]()

    def judge(value: Mpf | float) -> Json:
        values.append(value)
        shown = digits if isinstance(value, mpmath.mpf) else _THRESHOLD_DIGITS
        with mp.workdps(digits):
            number = mp.mpf(value)
            if error and number:
                shown = min(shown, max(2, 2 + int(mp.floor(mp.log10(abs(number) / error)))))
            first = mp.mpf(values[0])
            apart = float(abs(number - first) / (abs(first) or 1))
            return {"value": mp.nstr(number, shown), "relative_error": apart}

    rows = [measured(method, compute, judge) for method, compute in methods.items()]
    remarks = list[str]()
    if error:
        text = f"the points' scatter alone makes that +-{error:.1g} kg/s, one standard error (jackknife)"
        remarks.append(f"measured points: {text}")
    if values and values[0] and (rows[-1].relative_error or 0.0) > _NAMED_DIFFERENCE:
        reasons = differences(law, criterion, numbers, float(values[0]), float(values[-1]))
        remarks += [f"why the threshold differs: {text}" for text in reasons]
    return CrossCheck(criterion.name, tuple(rows), point, tuple(remarks))


def _simulated(law: FrictionLaw, point: Mapping[str, float], rtol: float = EXPLAINED_RTOL) -> float:
    return float(pure_slip_damping(law, **point, method="simulation", rtol=rtol).value)


def differences(
    law: FrictionLaw, criterion: Criterion, point: Mapping[str, float], value: float, threshold: float
) -> list[str]:
    """Return why a criterion and the simulated threshold, both in kg/s, differ: each reason computed."""

    def simulated(law: FrictionLaw, **changed: float) -> float:
        try:
            return _simulated(law, {**point, **changed})
        except StickSlipError:
            return math.nan  # which explains nothing, as no comparison below holds

    weak = float(slope_average(law, harmonic)(V=point["V"], N=point["N"]))
    reasons = []
    if criterion != harmonic and abs(weak - value) > _NAMED_DIFFERENCE * abs(value):
        reasons.append(
            f"the weight: for weak friction the threshold is the harmonic average, {weak:.4g} kg/s, and the "
            f"criterion {criterion.name} weighs other slip speeds"
        )
    if law.static is not None:
        without = simulated(law.with_static(None))
        if abs(without - threshold) > _NAMED_DIFFERENCE * abs(threshold):
            reasons.append(
                "the static coefficient, which no slope average sees: without it the threshold is "
                f"{without:.4g} kg/s"
            )
    stiff = simulated(law, k=point["k"] * _STIFFNESS_RATIO)
    if abs(stiff - weak) < abs(threshold - weak) / 3 and abs(threshold - stiff) > _NAMED_DIFFERENCE * abs(
        threshold
    ):
        eta = point["N"] / (point["V"] * math.sqrt(point["k"] * point["m"]))
        reasons.append(
            f"friction that is not weak: N/(V sqrt(k m)) = {eta:.3g}; at a hundredth of that (k times 10^4) "
            f"the threshold is {stiff:.4g} kg/s"
        )
    return reasons


def scatter(law: FrictionLaw, criterion: Criterion, V: float, N: float) -> float:
    """Return the standard error of a criterion of measured points, in kg/s, by the jackknife; 0 for a formula."""
    if law.curve is None:
        return 0.0
    end = law.curve.end
    points = [(place, cubic[0]) for place, cubic in zip(law.curve.places, law.curve.cubics, strict=True)]
    if end is not None:
        points += [(end, exact(law.mu(float(end)), "mu"))]
    if len(points) < _FEWEST_SCATTERED:
        return 0.0
    values = []
    whole = law.kinetic.table  # between whose places all curves are smooth
    for i in range(1, len(points) - 1):
        v, mu = zip(*points[:i], *points[i + 1 :], strict=True)
        slope = SampledCurve.through(v, mu, extrapolate=end is None).function("numpy", derivative=True)
        average, _, _ = gauss_average_of_slope(slope, whole, [V], criterion=criterion)
        values.append(N * float(average[0]))
    return math.sqrt((len(values) - 1) * float(np.var(values)))
