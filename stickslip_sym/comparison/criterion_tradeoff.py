"""Speed against accuracy of a criterion: every way to its value, the time for one and its error."""

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import mpmath
import numpy as np
import sympy as sp
from flint import arb

from stickslip_sym.comparison.ways import Trade, Way, shortest
from stickslip_sym.core import deadline, symbols
from stickslip_sym.core.aliases import FloatArray, Mpf
from stickslip_sym.core.errors import InputError, StickSlipError
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.core.numbers import Number, exact
from stickslip_sym.criteria import gauss
from stickslip_sym.formula.closed_form import ClosedForm
from stickslip_sym.formula.evaluation.values import slope_of
from stickslip_sym.model.expression.pieces import jumps

__all__ = ["criterion_tradeoff"]

Result = float | FloatArray | Mpf
Slope = Callable[[FloatArray], FloatArray]
GAUSS_NODES = (2, 4, 8, 16, 32)
DIGITS = (15, 30, 50)
_REFERENCE_DIGITS = 70
_ARRAY = 100_000  # elements over which the time of an array function is averaged
_SHORTEST = 0.02  # seconds that a measurement takes at least, all repetitions together


def criterion_tradeoff(
    form: ClosedForm, scene: Mapping[str, Number], *, time_limit: float | None = None
) -> Trade[Way]:
    """Measure the ways to a criterion in one scene.

    - `form`: of a law with all parameters bound.
    - `scene`: V in m/s and N in N.
    - `time_limit`: seconds after which no other way is tried; those that are left give no number.

    They are plain ``lambdify`` of the formula, the stable function, a Gauss rule with n nodes,
      ``scipy.integrate.quad``, and mpmath at 15, 30 and 50 digits.

    Raises `InputError` for an unbound law or unusable numbers, or where the criterion is 0.
    """
    with deadline.time_limit(time_limit):
        ways = _measured(form, scene)
    numbers = {name: float(exact(scene[name], name)) for name in "VN"}
    where = ", ".join(f"{name} = {scene[name]} {unit}" for name, unit in (("V", "m/s"), ("N", "N")))
    return Trade("value", f"{form.criterion.name} of {form.law.name or 'the law'}, {where}", tuple(ways), numbers)


def _measured(form: ClosedForm, scene: Mapping[str, Number]) -> list[Way]:
    values = {name: exact(scene[name], name) for name in ("V", "N")}
    if form.law.missing:
        raise InputError(f"the law has no value for {', '.join(form.law.missing)}; bind it first")
    right = form.evaluate(_REFERENCE_DIGITS, **values)
    if right == 0:
        raise InputError("the criterion is 0 in this scene: nothing has a relative error")
    numbers: dict[str, Any] = {name: float(value) for name, value in (values | dict(form.law.values)).items()}
    # Floats are what every way gets, so that none is blamed for the rounding of the input.
    right = form.evaluate(_REFERENCE_DIGITS, **numbers)

    def way(name: str, compute: Callable[[], Result], count: int = 1) -> Way:
        with np.errstate(all="ignore"):
            try:
                deadline.check_time()
                result, seconds = shortest(compute, enough=_SHORTEST)
            except (
                ArithmeticError,
                NameError,
                StickSlipError,
            ):  # NumPy and SciPy have no polylog, and lambdify prints it
                return Way(name)
        value = mpmath.mpf(float(np.ravel(result)[0])) if count > 1 or isinstance(result, float) else result
        with mpmath.workdps(_REFERENCE_DIGITS):
            error = abs(value - right) / abs(right)
        return Way(name, seconds / count, float(error))

    many: dict[str, Any] = {
        name: np.full(_ARRAY, value) if name == "V" else value for name, value in numbers.items()
    }
    plain = function_of(list(form.arguments.values()), form.expr, "numpy")
    ordered = [many[name] for name in form.arguments]
    ways = [
        way("plain lambdify, array", lambda: plain(*ordered), _ARRAY),
        way("stable function, array", lambda: form(**many), _ARRAY),
        way("stable function, one value", lambda: form(**numbers)),
    ]
    if form.criterion.weight is not None and not jumps(form.law.expr):  # a rule for the slope misses a jump
        point = form.law.point
        compiled = function_of([*point, symbols.v], slope_of(form.law.expr), "numpy")
        slope = partial(compiled, *map(float, point.values()))
        ways += [way(f"Gauss rule, {n} nodes", _gauss_rule(form, slope, numbers, n)) for n in GAUSS_NODES]
        ways.append(way("scipy.integrate.quad", _quad(form, slope, numbers)))
    for digits in DIGITS:
        ways.append(way(f"mpmath, {digits} digits", partial(form.evaluate, digits, **numbers)))
    return ways


def _integrand(form: ClosedForm, slope: Slope, numbers: Mapping[str, float]) -> Slope:
    places = sp.symbols("m p q", positive=True, cls=sp.Dummy)
    weight = function_of(places, gauss.angle_weight(form.criterion, *places), "numpy")
    V, N = numbers["V"], numbers["N"]

    def integrand(angle: FloatArray) -> FloatArray:
        sine, cosine = np.sin(angle), np.cos(angle)
        share: FloatArray = weight((2 * sine * cosine) ** 2, 2 * sine * sine, 2 * cosine * cosine)
        return -N * share * slope(2 * V * sine * sine)

    return integrand


def _gauss_rule(form: ClosedForm, slope: Slope, numbers: Mapping[str, float], n: int) -> Callable[[], float]:
    integrand = _integrand(form, slope, numbers)
    pairs = [arb.legendre_p_root(n, k, weight=True) for k in range(n)]  # NumPy's weights are off by some units
    x, w = np.array([[float(node), float(weight)] for node, weight in pairs]).T
    angles, weights = (1 + x) * np.pi / 4, w * np.pi / 4
    return lambda: math.fsum(weights * integrand(angles))


def _quad(form: ClosedForm, slope: Slope, numbers: Mapping[str, float]) -> Callable[[], float]:
    from scipy.integrate import quad

    integrand = _integrand(form, slope, numbers)
    return lambda: float(quad(integrand, 0, np.pi / 2, epsabs=0, epsrel=1e-13, full_output=1)[0])
