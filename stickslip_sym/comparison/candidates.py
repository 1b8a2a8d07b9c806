"""What a trade-off measures: for each kind of number the methods for it, and what their error is held against."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import mpmath
import numpy as np
import sympy as sp
from flint import arb

from stickslip_sym.comparison.procedures import (
    Scan,
    comes_to_rest,
    comes_to_rest_smoothed,
    pure_slip_by_bisection,
    pure_slip_by_scan,
)
from stickslip_sym.core import deadline, symbols
from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import InputError, NotConverged, NoThreshold, OutOfTime
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.core.numbers import Number, exact
from stickslip_sym.core.status import Status
from stickslip_sym.criteria import gauss
from stickslip_sym.formula.closed_form import ClosedForm
from stickslip_sym.formula.evaluation.values import slope_of
from stickslip_sym.model.expression.pieces import jumps
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.maps.basins import basin_map
from stickslip_sym.motion.maps.shares import motions_by_side
from stickslip_sym.motion.motion import MOTIONS, Motion
from stickslip_sym.motion.regimes.classification import classify
from stickslip_sym.motion.thresholds.methods import Method, methods
from stickslip_sym.motion.thresholds.threshold import pure_slip_damping

__all__ = ["SPEEDS", "Candidate", "Problem", "of_criterion", "of_share", "of_threshold"]

GAUSS_NODES = (2, 4, 8, 16, 32)
DIGITS = (15, 30, 50)
_REFERENCE_DIGITS = 70
_ARRAY = 100_000  # elements over which the time of an array function is averaged
SPEEDS = np.linspace(0.05, 1.0, 20)
"""Belt speeds in m/s over which the largest error of a threshold is taken, those without a threshold left out."""
BISECTED = (1e-3, 1e-6, 1e-9)
"""Tolerances of ``scipy.integrate.solve_ivp`` for a threshold, whose own is the first."""
SCAN_STEP = 0.001  # kg/s, the paper's
_FINE = 1e-11  # relative error that methods are asked for; a simulation states 1e-12 at best, and is refused there
SIMULATED = (50, 200, 800)
"""Numbers of initial conditions that are simulated."""
WRITTEN = 50
"""Number that runs of SciPy take: each takes some ten times as long."""
TOLERANCES = (1e-3, 1e-6)
"""Of these runs; the first is SciPy's own."""
_SEED = 1  # of the initial conditions
_UNITS = {"V": "m/s", "N": "N", "m": "kg", "k": "N/m", "c": "kg/s"}


@dataclass(frozen=True)
class Candidate:
    """One method at one tolerance.

    Attributes
    ----------
    method : str
    setting : str
        Tolerance, number of nodes, digits or initial conditions; empty where there is nothing to set.
    compute : callable
        Without arguments; returns what the problem's `error` takes.
    count : int
        Values that one call computes.
    repeated : bool
        Whether the time is the shortest of several; a method that takes long is measured once.
    """

    method: str
    setting: str
    compute: Callable[[], Any]
    count: int = 1
    repeated: bool = True

    @property
    def name(self) -> str:
        """The method, and after a comma its setting."""
        return ", ".join(filter(None, (self.method, self.setting)))


@dataclass(frozen=True)
class Problem:
    """One number, the methods for it, and what their values are held against.

    Attributes
    ----------
    number : str
        What kind of number: "value" of a criterion, "threshold" or "share" of a basin.
    title : str
        Which number it is, and at which operating point.
    candidates : tuple of Candidate
    error : callable
        From a candidate's result to its relative error.
    further : callable
        From a candidate and its result to what else is known, by the keys of `columns`.
    columns : mapping of str to str
        Titles of what else is known, in the table.
    point, box : mapping
        The operating point in SI units; ends of the initial displacements x0 and velocities v0.
    """

    number: str
    title: str
    candidates: tuple[Candidate, ...]
    error: Callable[[Any], float]
    further: Callable[[Candidate, Any], Mapping[str, float | str]] = lambda candidate, result: {}
    columns: Mapping[str, str] = field(default_factory=dict)
    point: Mapping[str, float] = field(default_factory=dict)
    box: Mapping[str, tuple[float, float]] = field(default_factory=dict)


def _at(point: Mapping[str, Number], names: Iterable[str]) -> str:
    return ", ".join(f"{name} = {point[name]} {_UNITS[name]}" for name in names)


# -- the value of a criterion ------------------------------------------------------------------------


def of_criterion(form: ClosedForm, point: Mapping[str, Number]) -> Problem:
    """Return the methods for the value of a criterion, held against the closed form in 70 digits.

    They are plain ``lambdify`` of the formula, the stable function, a Gauss rule with n nodes,
    ``scipy.integrate.quad``, and mpmath at 15, 30 and 50 digits.

    - `form`: of a law with all parameters bound.
    - `point`: V in m/s and N in N.

    Raises `InputError` for unusable numbers, or where the criterion is 0.
    """
    values = {name: exact(point[name], name) for name in "VN"}
    # Floats are what every method gets, so that none is blamed for the rounding of the input.
    numbers: dict[str, Any] = {name: float(value) for name, value in (values | dict(form.law.values)).items()}
    right = form.evaluate(_REFERENCE_DIGITS, **numbers)
    if right == 0:
        raise InputError("the criterion is 0 at this operating point: nothing has a relative error")

    def error(result: Any) -> float:
        value = result if isinstance(result, mpmath.mpf) else mpmath.mpf(float(np.ravel(result)[0]))
        with mpmath.workdps(_REFERENCE_DIGITS):
            return float(abs(value - right) / abs(right))

    many = numbers | {"V": np.full(_ARRAY, numbers["V"])}
    plain = function_of(list(form.arguments.values()), form.expr, "numpy")
    ordered = [many[name] for name in form.arguments]
    candidates = [
        Candidate("plain lambdify", "array", lambda: plain(*ordered), _ARRAY),
        Candidate("stable function", "array", lambda: form(**many), _ARRAY),
        Candidate("stable function", "one value", lambda: form(**numbers)),
    ]
    if form.criterion.weight is not None and not jumps(form.law.expr):  # a rule for the slope misses a jump
        integrand = _integrand(form, numbers)
        candidates += [Candidate("Gauss rule", f"{n} nodes", _gauss_rule(integrand, n)) for n in GAUSS_NODES]
        candidates.append(Candidate("scipy.integrate.quad", "", _quad(integrand)))
    candidates += [
        Candidate("mpmath", f"{digits} digits", partial(form.evaluate, digits, **numbers)) for digits in DIGITS
    ]
    title = f"{form.criterion.name} of {form.law.name or 'the law'}, {_at(point, 'VN')}"
    return Problem("value", title, tuple(candidates), error, point={name: numbers[name] for name in "VN"})


def _integrand(form: ClosedForm, numbers: Mapping[str, float]) -> Callable[[FloatArray], FloatArray]:
    places = sp.symbols("m p q", positive=True, cls=sp.Dummy)
    weight = function_of(places, gauss.angle_weight(form.criterion, *places), "numpy")
    point = form.law.point
    slope = function_of([*point, symbols.v], slope_of(form.law.expr), "numpy")
    parameters, V, N = [float(value) for value in point.values()], numbers["V"], numbers["N"]

    def integrand(angle: FloatArray) -> FloatArray:
        sine, cosine = np.sin(angle), np.cos(angle)
        share: FloatArray = weight((2 * sine * cosine) ** 2, 2 * sine * sine, 2 * cosine * cosine)
        falling: FloatArray = -slope(*parameters, 2 * V * sine * sine)
        return N * share * falling

    return integrand


def _gauss_rule(integrand: Callable[[FloatArray], FloatArray], n: int) -> Callable[[], float]:
    pairs = [arb.legendre_p_root(n, k, weight=True) for k in range(n)]  # NumPy's weights are off by some units
    x, w = np.array([[float(node), float(weight)] for node, weight in pairs]).T
    angles, weights = (1 + x) * np.pi / 4, w * np.pi / 4
    return lambda: math.fsum(weights * integrand(angles))


def _quad(integrand: Callable[[FloatArray], FloatArray]) -> Callable[[], float]:
    from scipy.integrate import quad

    return lambda: float(quad(integrand, 0, np.pi / 2, epsabs=0, epsrel=1e-13, full_output=1)[0])


# -- the threshold -----------------------------------------------------------------------------------


def of_threshold(law: FrictionLaw, point: Mapping[str, float]) -> Problem:
    """Return the methods for a threshold, held against the grazing orbit to 1e-11.

    They are the package's, with their largest errors over `SPEEDS`; and at the operating point only the paper's
    scan of Newmark runs up to twice the threshold in steps of 0.001 kg/s, and bisection by
    ``scipy.integrate.solve_ivp``.

    - `law`: smooth, with all parameters bound.
    - `point`: V, N, m and k in SI units.

    Raises `InputError`, `NoThreshold` or `NotConverged` where the operating point itself has no exact threshold.
    Raises `OutOfTime` if the time is up before that is known.
    """

    def by(method: Method, V: float) -> Any:
        """Return the threshold by a method; averages of slopes are not made to look for their error."""
        numbers = {**point, "V": V} if method.oscillator else {"V": V, "N": point["N"]}
        return pure_slip_damping(law, **numbers, method=method, rtol=_FINE if method.converges else 1.0)

    table = methods()
    right = by(table["orbit"], point["V"]).value
    if not right > 0:
        raise NoThreshold(f"the threshold is {right:.3g} kg/s here: nothing has a relative error")
    references = {}
    for speed in SPEEDS.tolist():
        try:
            references[speed] = by(table["orbit"], speed).value
        except (NoThreshold, NotConverged):
            continue
        except OutOfTime:
            break

    def error(result: Any, reference: float = right) -> float:
        """Return the error against the orbit; the orbit's own is its estimate, and that of a proof its bound."""
        if isinstance(result, float):
            return abs(result / reference - 1)
        own = result.method == "orbit" or result.status is Status.PROVED
        return float(result.relative_error) if own else abs(result.value / reference - 1)

    def further(candidate: Candidate, result: Any) -> Mapping[str, float | str]:
        if isinstance(result, float):
            return {"largest": math.nan, "status": "ESTIMATED"}
        try:
            errors = [
                error(by(table[candidate.method], speed), reference)
                for speed, reference in references.items()
                if reference > 0
            ]
        except (OutOfTime, NotConverged, NoThreshold):
            errors = []
        return {"largest": max(errors, default=math.nan), "status": str(result.status)}

    osc = Oscillator(**point)
    scan = Scan(np.arange(0.0, 2 * right, SCAN_STEP))
    candidates = [Candidate(name, "", partial(by, method, point["V"])) for name, method in table.items()]
    candidates.append(Candidate("Newmark scan", "", partial(pure_slip_by_scan, law, osc, scan), repeated=False))
    candidates += [
        Candidate(
            "solve_ivp and bisection", f"rtol {rtol:.0e}", partial(pure_slip_by_bisection, law, osc, rtol),
            repeated=False,
        )
        for rtol in BISECTED
    ]  # fmt: skip
    columns = {"largest": "largest error up to V = 1 m/s", "status": "status"}
    title = f"threshold of {law.name or 'the law'}, {_at({k: f'{v:g}' for k, v in point.items()}, 'VNmk')}"
    return Problem("threshold", title, tuple(candidates), error, further, columns, point)


# -- the share of initial conditions -----------------------------------------------------------------


def of_share(law: FrictionLaw, osc: Oscillator, x0: tuple[float, float], v0: tuple[float, float]) -> Problem:
    """Return the methods for the share of a box of initial conditions that come to rest, held against its area.

    They are the area inside the separatrices; seeded samples, by event-driven simulation; and fewer, by runs of
    ``scipy.integrate.solve_ivp`` over 80 natural periods, once with events and stick, once with the sign of the
    slip speed smoothed over a hundredth of the belt's speed. The error of a sample is the root of the sum of two
    squares: of the standard error of its size, and of the share that is wrong of these very initial conditions.

    - `law`: with all parameters bound.
    - `osc`: an oscillator whose basins geometry settles, as it does for every law without jumps.
    - `x0, v0`: the box, displacements in m and velocities in m/s.

    Raises `InputError` where geometry does not settle the basins, or no motion comes to rest.
    Raises `OutOfTime` if the time is up before the areas are known.
    """
    geometry = partial(basin_map, law, osc, x0=x0, v0=v0)
    basins = geometry()
    right = basins.share.get(Motion.REST)
    if right is None or right.counted or not right.value > right.error:
        settled = right is None or right.value == 0
        reason = "no initial condition comes to rest" if settled else "its basins are not settled"
        raise InputError(f"{reason} in this box: nothing has a relative error; try another c or box")
    rng = np.random.default_rng(_SEED)
    starts = np.column_stack([rng.uniform(*ends, max(SIMULATED)) for ends in (x0, v0)])
    rest = MOTIONS.index(Motion.REST)

    def rests(x: float, v: float) -> bool:
        return classify(law, osc, x0=x, v0=v) is Motion.REST

    sides = [int(motions_by_side(basins.regime, *start[:, None])[0, 0]) for start in starts]
    truth = np.array(
        [rests(*at) if side < 0 else side == rest for side, at in zip(sides, starts.tolist(), strict=True)]
    )

    def sampled(decide: Callable[[float, float], bool], count: int) -> list[bool]:
        found = []
        for start in starts[:count].tolist():
            deadline.check_time()
            found.append(decide(*start))
        return found

    def further(candidate: Candidate, result: Any) -> Mapping[str, float | str]:
        if not isinstance(result, list):
            return {"share": float(result.share[Motion.REST].value), "standard error": 0.0}
        spread = math.sqrt(right.value * (1 - right.value) / len(result))
        return {"share": float(np.mean(result)), "standard error": spread}

    def error(result: Any) -> float:
        if not isinstance(result, list):
            return float(right.error / right.value)
        wrong = float(np.mean(result)) - float(np.mean(truth[: len(result)]))
        spread = math.sqrt(right.value * (1 - right.value) / len(result))
        return math.hypot(wrong, spread) / right.value

    deciders = [("simulation", "", rests, count) for count in SIMULATED]
    deciders += [
        (f"solve_ivp {name}", f"rtol {rtol:.0e}, ", partial(decide, law, osc, rtol=rtol), WRITTEN)
        for name, decide in (("with events", comes_to_rest), ("smoothed", comes_to_rest_smoothed))
        for rtol in TOLERANCES
    ]
    candidates = [Candidate("geometry", "", geometry)]
    candidates += [
        Candidate(name, f"{setting}{count} samples", partial(sampled, decide, count), repeated=False)
        for name, setting, decide, count in deciders
    ]
    point = {name: getattr(osc, name) for name in "VNmkc"}
    numbers = ", ".join(f"{name} = {value:g}" for name, value in point.items())
    box = f"x0 = {x0[0]:g} to {x0[1]:g} m, v0 = {v0[0]:g} to {v0[1]:g} m/s"
    title = f"share of initial conditions that come to rest, {law.name or 'the law'}, {numbers}, {box}"
    columns = {"share": "share", "standard error": "standard error"}
    return Problem("share", title, tuple(candidates), error, further, columns, point, {"x0": x0, "v0": v0})
