"""The table of `derive`: a criterion in closed form and by quadrature, and the oscillator's own threshold."""

import math
import textwrap
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import mpmath
import numpy as np
import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Mpf
from stickslip_sym.core.errors import StickSlipError
from stickslip_sym.core.numbers import Number, exact
from stickslip_sym.criteria import quadrature
from stickslip_sym.criteria.criterion import Criterion, harmonic
from stickslip_sym.formula.closed_form import ClosedForm
from stickslip_sym.formula.slope_average import slope_average
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.samples import SampledCurve
from stickslip_sym.motion.thresholds.threshold import pure_slip_damping
from stickslip_sym.output.tables import duration, table

__all__ = ["Check", "crosscheck", "differences", "report", "scatter"]

_WIDTH = 100  # characters of a line of text
_LARGE = 0.05
"""Relative difference of a criterion from the threshold from which on its reason is looked for."""
_STIFFER = 1e4
"""Times the stiffness: N/(V sqrt(k m)) falls to a hundredth, where friction is weak."""
_SHOWN = 1e-11
"""Relative error of the threshold in the table, of which twelve digits are shown: the last may be off."""
_THRESHOLD_DIGITS = 12
_RTOL = 1e-6  # of the thresholds that a difference is explained by
_FEWEST = 5  # points of which one may be left out
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)


@dataclass(frozen=True)
class Check:
    """One row of the table.

    Attributes
    ----------
    method : str
    value : str
        In kg/s, with as many digits as the method gives; or why there is none.
    difference : float or None
        Relative to the first method that has a value; None where there is none.
    seconds : float
    """

    method: str
    value: str
    difference: float | None = None
    seconds: float = 0.0


def crosscheck(
    law: FrictionLaw, criterion: Criterion, point: Mapping[str, Number], form: ClosedForm | None, digits: int = 50
) -> list[Check]:
    """Compute a closed form, the quadrature of its definition, and the event-driven threshold.

    - `law`: with all parameters bound.
    - `point`: V, N, m and k in SI units.
    - `form`: of this law and criterion; None where there is none, and quadrature is the reference.
    - `digits`: of the closed form and of the quadrature.

    A method that has no value at this operating point says why in its place.
    """
    V, N = point["V"], point["N"]
    numbers = {name: float(exact(value, name)) for name, value in point.items()}
    rows: list[tuple[str, Callable[[], Mpf], int]] = [
        (
            f"quadrature, {digits} digits",
            partial(quadrature.damping, law, criterion, V=V, N=N, digits=digits),
            digits,
        ),
        ("event-driven threshold", partial(_simulated, law, numbers, _SHOWN), _THRESHOLD_DIGITS),
    ]
    if form is not None:
        rows.insert(0, ("closed form", partial(form.evaluate, digits, V=V, N=N), digits))
    error = None if law.curve is None else scatter(law, criterion, numbers["V"], numbers["N"])
    checks: list[Check] = []
    values: list[Mpf] = []
    for method, compute, known in rows:
        begin = time.perf_counter()
        try:
            values.append(compute())
        except StickSlipError as reason:
            checks.append(Check(method, f"none: {reason}"))
            continue
        seconds, value, reference = time.perf_counter() - begin, values[-1], values[0]
        with mpmath.workdps(digits):
            difference = float(abs(value - reference) / (abs(reference) or 1))
        shown = known if error is None else min(known, _digits(value, error))
        checks.append(Check(method, mpmath.nstr(value, shown), difference, seconds))
    last = checks[-1].difference
    if error:
        text = f"the points' scatter alone makes that +-{error:.1g} kg/s, one standard error (jackknife)"
        checks.append(Check("measured points", text))
    if last is not None and last > _LARGE and values[0]:
        for text in differences(law, criterion, numbers, float(values[0]), float(values[-1])):
            checks.append(Check("why the threshold differs", text))
    return checks


def _simulated(law: FrictionLaw, point: Mapping[str, float], rtol: float) -> Mpf:
    """Return the event-driven threshold."""
    return mpmath.mpf(pure_slip_damping(law, **point, method="simulation", rtol=rtol).value)


def _digits(value: Mpf, error: float) -> int:
    """Return the digits of a value that its standard error leaves, and one more."""
    if not value or not error:
        return 17
    return max(2, 2 + int(mpmath.floor(mpmath.log10(abs(value) / error))))


def report(checks: list[Check]) -> str:
    """Return the checks as a table, and below it, in lines of a readable length, what has no number."""
    rows = [
        [check.method, check.value, f"{check.difference:.2g}", duration(check.seconds)]
        for check in checks
        if check.difference is not None
    ]
    words = [
        textwrap.fill(f"{check.method}: {check.value}", _WIDTH, subsequent_indent="  ", break_long_words=False)
        for check in checks
        if check.difference is None
    ]
    return "\n".join([table(["method", "c in kg/s", "difference", "time"], rows), *words])


def differences(
    law: FrictionLaw, criterion: Criterion, point: Mapping[str, float], value: float, threshold: float
) -> list[str]:
    """Return what a criterion and the event-driven threshold differ by, part by part, each computed.

    - `law`: with all parameters bound.
    - `point`: V, N, m and k in SI units.
    - `value, threshold`: the criterion and the threshold, in kg/s.
    """

    def simulated(law: FrictionLaw, changed: Mapping[str, float]) -> float | None:
        try:
            return float(_simulated(law, {**point, **changed}, _RTOL))
        except StickSlipError:
            return None

    reasons = []
    weak = float(slope_average(law, harmonic)(V=point["V"], N=point["N"]))
    if criterion != harmonic and abs(weak - value) > _LARGE * abs(value):
        reasons.append(
            f"the weight: for weak friction the threshold is the harmonic average, {weak:.4g} kg/s, and the "
            f"criterion {criterion.name} weighs other slip speeds"
        )
    if law.static is not None:
        names = {name for name, parameter in law.parameters.items() if law.expr.has(parameter.symbol)}
        plain = FrictionLaw(law.expr).bind(**{name: law.values[name] for name in names})
        without = simulated(plain, {})
        if without is not None and abs(without - threshold) > _LARGE * abs(threshold):
            reasons.append(
                "the static coefficient, which no slope average sees: without it the threshold is "
                f"{without:.4g} kg/s"
            )
    stiff = simulated(law, {"k": point["k"] * _STIFFER})
    closer = stiff is not None and abs(stiff - weak) < abs(threshold - weak) / 3
    if stiff is not None and closer and abs(threshold - stiff) > _LARGE * abs(threshold):
        eta = point["N"] / (point["V"] * math.sqrt(point["k"] * point["m"]))
        reasons.append(
            f"friction that is not weak: N/(V sqrt(k m)) = {eta:.3g}; at a hundredth of that (k times 10^4) "
            f"the threshold is {stiff:.4g} kg/s"
        )
    return reasons


def scatter(law: FrictionLaw, criterion: Criterion, V: float, N: float) -> float:
    """Return the standard error of a criterion of measured points, in kg/s: the jackknife over the points.

    Each point but the first and the last is left out in turn; 0 for fewer than five points.
    """
    assert law.curve is not None
    curve, end = law.curve, law.curve.end
    v, mu = list(curve.places), [cubic[0] for cubic in curve.cubics]
    if end is not None:
        v, mu = [*v, end], [*mu, exact(float(law.mu(float(end))), "mu")]
    if len(v) < _FEWEST:
        return 0.0
    values = []
    for i in range(1, len(v) - 1):
        other = SampledCurve.through([*v[:i], *v[i + 1 :]], [*mu[:i], *mu[i + 1 :]], extrapolate=end is None)
        values.append(_gauss(other, criterion, V, N))
    return math.sqrt((len(values) - 1) * float(np.var(values)))


def _gauss(curve: SampledCurve, criterion: Criterion, V: float, N: float) -> float:
    """Return a criterion by Gauss-Legendre rules between the points, in phi with v = V(1 - cos(phi)).

    In phi the integrand is smooth for every weight; a standard error wants no more digits.
    """
    slope = curve.function("numpy", derivative=True)
    if criterion.weight is None:
        return -N * float(slope(V))
    inside = [float(place) for place in curve.places if 0 < place < 2 * V]
    ends = np.arccos(1 - np.array([0.0, *inside, 2 * V]) / V)
    phi = (ends[:-1, None] * (1 - _NODES) + ends[1:, None] * (1 + _NODES)) / 2
    weight = sp.lambdify(symbols.s, criterion.weight, "numpy")(-np.cos(phi))
    integrand = weight * np.sin(phi) * slope(V * (1 - np.cos(phi)))
    return -N * float(((ends[1:] - ends[:-1]) / 2) @ (integrand @ _WEIGHTS))
