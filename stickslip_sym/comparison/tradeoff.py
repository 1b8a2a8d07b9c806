"""`tradeoff`: speed against accuracy, measured, of every method for a criterion, a threshold and a basin.

One more method is one `Candidate` of the number that it is for.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from time import process_time
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
from stickslip_sym.comparison.trade import Row, Trade, Tradeoff
from stickslip_sym.core import deadline, symbols
from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import InputError, NotConverged, NoThreshold, OutOfTime, StickSlipError
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.core.numbers import Number, exact, lookup
from stickslip_sym.core.status import Status
from stickslip_sym.criteria.criterion import Criterion, find
from stickslip_sym.formula.closed_form import ClosedForm, derive
from stickslip_sym.formula.evaluation.values import slope_of
from stickslip_sym.model.expression.pieces import jumps
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.operating_point import LOW_SPEED, PAPER
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.maps.basins import basin_map
from stickslip_sym.motion.motion import Motion
from stickslip_sym.motion.regimes.classification import classify
from stickslip_sym.motion.thresholds.methods import methods
from stickslip_sym.motion.thresholds.threshold import Threshold, pure_slip_damping

KINDS = ("criterion", "threshold", "basin")
Ends = tuple[float, float]
Further = Mapping[str, float | str]
_DERIVING = 120.0  # seconds of the search for a closed form
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
_REACH = 4 / 3  # of the box of initial conditions where none is given: in V/omega to both sides of 0, and in V
SIMULATED = (50, 200, 800)
"""Numbers of initial conditions that are simulated."""
WRITTEN = 50
"""Number that runs of SciPy take: each takes some ten times as long."""
TOLERANCES = (1e-3, 1e-6)
"""Of these runs; the first is SciPy's own."""
_SEED = 1  # of the initial conditions
_LEAST, _ENOUGH = 3, 0.02  # repetitions of a measurement, and seconds that they take together, at least


def tradeoff(
    law: FrictionLaw | str,
    *,
    of: str | Sequence[str] = KINDS,
    criterion: str | Criterion = "least_squares",
    x0: tuple[float, float] | None = None,
    v0: tuple[float, float] | None = None,
    time_limit: float | None = None,
    V: Number | None = None,
    N: Number | None = None,
    m: Number | None = None,
    k: Number | None = None,
    c: Number | None = None,
) -> Tradeoff:
    """Measure what each method for a number costs, and how far it is off; methods without this package too.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    of : str or sequence of str
        Of which numbers: "criterion", "threshold", "basin". Of several, one that cannot be measured here is left
        out, with the reason.
    criterion : str or Criterion
    x0, v0 : tuple of float, optional
        The box of initial conditions, displacements in m and velocities in m/s. If not given 4/3 V/omega to both
        sides of 0, and from 0 to 4/3 V.
    time_limit : float, optional
        Seconds after which no other method is tried; those that are left give no number.
    V, N, m, k : float or str, optional
        In SI units, text exactly. What is not given is the paper's; but the criterion is measured at V = 0.05 m/s,
        where the methods for it differ.
    c : float or str, optional
        Damping in kg/s, of the basins. If not given it is halfway from the linear threshold to the exact one.

    Returns
    -------
    Tradeoff

    Raises
    ------
    InputError
        For an unknown kind or criterion, or unusable numbers.
    StickSlipError
        If nothing can be measured, the reason of the first kind.

    Examples
    --------
    >>> from stickslip_sym import laws
    >>> found = tradeoff(laws.hyperbolic.typical(), of="criterion", V="0.001")
    >>> error = {row.name: row.error for row in found.trades["criterion"].rows}
    >>> error["plain lambdify, array"] > 1e-9 > 1e-15 > error["stable function, array"]
    True
    """
    law = as_law(law)
    kinds = [of] if isinstance(of, str) else list(of) if isinstance(of, Sequence) else []
    if not kinds:
        raise InputError(f"of = {of!r} names nothing to measure; known: {', '.join(KINDS)}")
    for kind in kinds:
        lookup("trade of", kind, dict.fromkeys(KINDS))
    for name, value in {"x0": x0, "v0": v0, "c": c}.items():
        if value is not None and "basin" not in kinds:
            raise InputError(f'{name} belongs to the basins of attraction: of = "basin"')
    if law.missing:
        raise InputError(f"the law has no value for {', '.join(law.missing)}; bind it first")
    chosen = find(criterion)
    given = {name: value for name, value in {"V": V, "N": N, "m": m, "k": k}.items() if value is not None}
    numbers = {name: float(exact(value, name)) for name, value in (PAPER | given).items()}
    damping = None if c is None else float(exact(c, "c"))
    trades: dict[str, Callable[[], Trade]] = {
        "criterion": lambda: _criterion(law, chosen, {**PAPER, "V": LOW_SPEED, **given}),
        "threshold": lambda: _threshold(law, numbers),
        "basin": lambda: _basin(law, numbers, damping, x0, v0),
    }
    found, errors = dict[str, Trade](), dict[str, StickSlipError]()
    with deadline.time_limit(time_limit):
        for kind in kinds:
            try:
                found[kind] = trades[kind]()
            except StickSlipError as error:
                errors[kind] = error
    if not found:
        raise next(iter(errors.values()))
    return Tradeoff(found, {kind: str(error) for kind, error in errors.items()})


# -- how a method is measured ------------------------------------------------------------------------


@dataclass(frozen=True)
class Candidate:
    """One method at one tolerance: a call of `compute` gives `count` values. What takes long is timed once."""

    method: str
    setting: str
    compute: Callable[[], Any]
    count: int = 1
    repeated: bool = True


def _measured(
    candidates: Iterable[Candidate], judge: Callable[[Candidate, Any], tuple[float, Further]]
) -> tuple[Row, ...]:
    """Measure every candidate; `judge` gives the relative error of its result, and what else is known."""
    rows = []
    for one in candidates:
        times: list[float] = []
        least, enough = (_LEAST, _ENOUGH) if one.repeated else (1, 0.0)
        try:
            with np.errstate(all="ignore"):
                while len(times) < least or sum(times) < enough:
                    deadline.check_time()
                    begin = process_time()
                    result = one.compute()
                    times.append(process_time() - begin)
        except (ArithmeticError, NameError, StickSlipError):  # NumPy has no polylog, and lambdify prints it
            rows.append(Row(one.method, one.setting))
        else:
            rows.append(Row(one.method, one.setting, min(times) / one.count, *judge(one, result)))
    return tuple(rows)


def _shown(point: Mapping[str, object]) -> str:
    return ", ".join(f"{name} = {value} {symbols.QUANTITIES[name].unit}" for name, value in point.items())


# -- the value of a criterion ------------------------------------------------------------------------


def _criterion(law: FrictionLaw, criterion: Criterion, point: Mapping[str, Number]) -> Trade:
    """Measure the methods for the value of a criterion, held against the closed form in 70 digits."""
    form = derive(law, criterion, time_limit=max(0.0, min(_DERIVING, deadline.time_left())))
    # Floats are what every method gets, so that none is blamed for the rounding of the input.
    at = {name: float(exact(point[name], name)) for name in "VN"}
    numbers: dict[str, Any] = at | {name: float(value) for name, value in law.values.items()}
    right = form.evaluate(_REFERENCE_DIGITS, **numbers)
    if right == 0:
        raise InputError("the criterion is 0 at this operating point: nothing has a relative error")

    def judge(_: Candidate, result: Any) -> tuple[float, Further]:
        value = result if isinstance(result, mpmath.mpf) else mpmath.mpf(float(np.ravel(result)[0]))
        with mpmath.workdps(_REFERENCE_DIGITS):
            return float(abs(value - right) / abs(right)), {}

    many = numbers | {"V": np.full(_ARRAY, at["V"])}
    plain = function_of(list(form.arguments.values()), form.expr, "numpy")
    candidates = [
        Candidate("plain lambdify", "array", partial(plain, *(many[name] for name in form.arguments)), _ARRAY),
        Candidate("stable function", "array", partial(form, **many), _ARRAY),
        Candidate("stable function", "one value", partial(form, **numbers)),
    ]
    if criterion.weight is not None and not jumps(law.expr):  # a rule for the slope misses a jump
        from scipy.integrate import quad

        integrand = _integrand(form, at["V"], at["N"])
        candidates += [Candidate("Gauss rule", f"{n} nodes", _gauss_rule(integrand, n)) for n in GAUSS_NODES]
        by_quad = partial(quad, integrand, 0, np.pi / 2, epsabs=0, epsrel=1e-13, full_output=1)
        candidates.append(Candidate("scipy.integrate.quad", "", lambda: by_quad()[0]))
    candidates += [
        Candidate("mpmath", f"{digits} digits", partial(form.evaluate, digits, **numbers)) for digits in DIGITS
    ]
    title = f"{criterion.name} of {law.name or 'the law'}, {_shown({name: point[name] for name in 'VN'})}"
    return Trade("value", title, _measured(candidates, judge), at)


def _integrand(form: ClosedForm, V: float, N: float) -> Callable[[FloatArray], FloatArray]:
    """Return -N w(s) mu'(v) ds/dphi with v = 2V sin(phi)^2: smooth at both ends, square roots too."""
    ends, point = sp.symbols("p q", positive=True, cls=sp.Dummy), form.law.point
    weight = function_of(ends, form.criterion.from_ends(*ends), "numpy")
    slope = partial(
        function_of([*point, symbols.v], slope_of(form.law.expr), "numpy"), *map(float, point.values())
    )

    def integrand(angle: FloatArray) -> FloatArray:
        sine, cosine = np.sin(angle), np.cos(angle)
        share: FloatArray = 4 * sine * cosine * weight(2 * sine * sine, 2 * cosine * cosine)
        rise: FloatArray = slope(2 * V * sine * sine)
        return -N * share * rise

    return integrand


def _gauss_rule(integrand: Callable[[FloatArray], FloatArray], n: int) -> Callable[[], float]:
    pairs = [arb.legendre_p_root(n, k, weight=True) for k in range(n)]  # NumPy's weights are off by some units
    x, w = np.array(pairs, dtype=np.float64).T
    return lambda: math.fsum(np.pi / 4 * w * integrand((1 + x) * np.pi / 4))


# -- the threshold -----------------------------------------------------------------------------------


def _threshold(law: FrictionLaw, point: Mapping[str, float]) -> Trade:
    """Measure every method for a threshold, the paper's scan and SciPy, against the grazing orbit to 1e-11."""

    def by(name: str, V: float = point["V"]) -> Threshold:
        """Return the threshold by a method; slope averages do not compute their errors."""
        method = methods()[name]
        numbers = {**point, "V": V} if method.oscillator else {"V": V, "N": point["N"]}
        return pure_slip_damping(law, **numbers, method=method, rtol=_FINE if method.converges else 1.0)

    right = by("orbit").value
    if not right > 0:
        raise NoThreshold(f"the threshold is {right:.3g} kg/s here: nothing has a relative error")
    references = dict[float, float]()
    for speed in SPEEDS.tolist():
        try:
            references[speed] = by("orbit", speed).value
        except (NoThreshold, NotConverged):
            continue
        except OutOfTime:
            break

    def error(found: Threshold, reference: float) -> float:
        """Return the error against the orbit; the orbit's own is its estimate, and that of a proof its bound."""
        own = found.method == "orbit" or found.status is Status.PROVED
        return float(found.relative_error) if own else abs(found.value / reference - 1)

    def judge(candidate: Candidate, result: Any) -> tuple[float, Further]:
        if isinstance(result, float):
            return abs(result / right - 1), {"largest": math.nan, "status": Status.ESTIMATED.value}
        try:
            errors = [error(by(candidate.method, V), there) for V, there in references.items() if there > 0]
        except (OutOfTime, NotConverged, NoThreshold):
            errors = []
        return error(result, right), {"largest": max(errors, default=math.nan), "status": str(result.status)}

    osc = Oscillator(**point)
    candidates = [Candidate(name, "", partial(by, name)) for name in methods()]
    scan = partial(pure_slip_by_scan, law, osc, Scan(np.arange(0.0, 2 * right, SCAN_STEP)))
    candidates.append(Candidate("Newmark scan", "", scan, repeated=False))
    for rtol in BISECTED:
        bisection = partial(pure_slip_by_bisection, law, osc, rtol)
        candidates.append(Candidate("solve_ivp and bisection", f"rtol {rtol:.0e}", bisection, repeated=False))
    shown = _shown({name: f"{value:g}" for name, value in point.items()})
    title = f"threshold of {law.name or 'the law'}, {shown}"
    return Trade("threshold", title, _measured(candidates, judge), point)


# -- the share of initial conditions -----------------------------------------------------------------


def _basin(
    law: FrictionLaw, point: Mapping[str, float], c: float | None, x0: Ends | None, v0: Ends | None
) -> Trade:
    """Measure the methods for the share of initial conditions that come to rest, against its area."""
    osc = Oscillator(c=_between_thresholds(law, point) if c is None else c, **point)
    reach = _REACH * osc.V
    x0, v0 = x0 or (-reach / osc.omega, reach / osc.omega), v0 or (0.0, reach)
    geometry = partial(basin_map, law, osc, x0=x0, v0=v0)
    basins = geometry()
    right = basins.share.get(Motion.REST)
    if right is None or right.counted or not right.value > right.error:
        settled = right is None or right.value == 0
        reason = "no initial condition comes to rest" if settled else "its basins are not settled"
        raise InputError(f"{reason} in this box: nothing has a relative error; try another c or box")

    def rests(x: float, v: float) -> bool:
        return classify(law, osc, x0=x, v0=v) is Motion.REST

    rng = np.random.default_rng(_SEED)
    initial = np.column_stack([rng.uniform(*ends, max(SIMULATED)) for ends in (x0, v0)]).tolist()
    sides = basins.regime.by_side(*np.transpose(initial)).tolist()
    truth = [
        rests(*at) if motion is None else motion is Motion.REST for motion, at in zip(sides, initial, strict=True)
    ]

    def sampled(decide: Callable[[float, float], bool], count: int) -> list[bool]:
        found = []
        for x, v in initial[:count]:
            deadline.check_time()
            found.append(decide(x, v))
        return found

    def judge(_: Candidate, result: Any) -> tuple[float, Further]:
        if not isinstance(result, list):
            share = float(result.share[Motion.REST].value)
            return float(right.error / right.value), {"share": share, "standard error": 0.0}
        share, spread = float(np.mean(result)), math.sqrt(right.value * (1 - right.value) / len(result))
        # The sample's own error is that of its size, and the share that is wrong of these very initial conditions.
        wrong = share - float(np.mean(truth[: len(result)]))
        return math.hypot(wrong, spread) / right.value, {"share": share, "standard error": spread}

    deciders = [("simulation", "", rests, count) for count in SIMULATED] + [
        (f"solve_ivp {name}", f"rtol {rtol:.0e}, ", partial(decide, law, osc, rtol=rtol), WRITTEN)
        for name, decide in (("with events", comes_to_rest), ("smoothed", comes_to_rest_smoothed))
        for rtol in TOLERANCES
    ]
    candidates = [Candidate("geometry", "", geometry)] + [
        Candidate(name, f"{setting}{count} samples", partial(sampled, decide, count), repeated=False)
        for name, setting, decide, count in deciders
    ]
    numbers = {name: getattr(osc, name) for name in "VNmkc"}
    shown = ", ".join(f"{name} = {value:g}" for name, value in numbers.items())
    box = f"x0 = {x0[0]:g} to {x0[1]:g} m, v0 = {v0[0]:g} to {v0[1]:g} m/s"
    title = f"share of initial conditions that come to rest, {law.name or 'the law'}, {shown}, {box}"
    return Trade("share", title, _measured(candidates, judge), numbers, {"x0": x0, "v0": v0})


def _between_thresholds(law: FrictionLaw, point: Mapping[str, float]) -> float:
    """Return the damping halfway from that where rest becomes stable to the threshold."""
    stable, threshold = (
        float(pure_slip_damping(law, **point, method=method).value) for method in ("equilibrium", "auto")
    )
    if not stable < threshold:
        raise NotConverged(
            f"rest is stable from {stable:.4g} kg/s on, and the threshold is {threshold:.4g} kg/s: rest and "
            "stick-slip coexist at no damping; give c, and a box where some motions come to rest"
        )
    return (stable + threshold) / 2
