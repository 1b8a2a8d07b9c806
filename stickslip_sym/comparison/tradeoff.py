"""`tradeoff`: speed against accuracy, measured, of every method for a criterion, a threshold and a basin.

One more method is one row of the number that it is for.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import mpmath
import numpy as np
import sympy as sp
from flint import arb

from stickslip_sym.comparison.compare import TIGHT_RTOL, Comparison, Row, measured, threshold_row
from stickslip_sym.core import deadline, symbols
from stickslip_sym.core.aliases import FloatArray, Json
from stickslip_sym.core.errors import InputError, NotConverged, NoThreshold, OutOfTime, StickSlipError
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.core.names import lookup
from stickslip_sym.core.numbers import SEED, Number, exact
from stickslip_sym.core.precision import mp
from stickslip_sym.core.progress import steps
from stickslip_sym.core.remedies import Call, ParameterValues
from stickslip_sym.core.seconds import SECONDS_TO_DERIVE
from stickslip_sym.core.status import Status
from stickslip_sym.criteria.criterion import Criterion, CriterionName, find
from stickslip_sym.formula.closed_form import ClosedForm, derive
from stickslip_sym.formula.evaluation.reference_average import stable_slope_of
from stickslip_sym.model.expression.pieces import jumps
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.operating_point import LOW_SPEED, PAPER
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.maps.basins import basin_map
from stickslip_sym.motion.motion import Motion
from stickslip_sym.motion.regimes.classification import classify
from stickslip_sym.motion.simulation.reference import absolute_tolerance, simulate_by_solve_ivp, slip_by_solve_ivp
from stickslip_sym.motion.thresholds.methods import methods
from stickslip_sym.motion.thresholds.threshold import Threshold, pure_slip_damping
from stickslip_sym.output.data import TableResult
from stickslip_sym.output.shown import Drawn, Report, views_of

if TYPE_CHECKING:
    from stickslip_sym.output.shown import Axes

KINDS = ("criterion", "threshold", "basin")
GAUSS_NODES = [2**power for power in range(1, 6)]
DIGITS = (15, 30, 50)
_REFERENCE_DIGITS = 2 * DIGITS[-1]
_ARRAY = 100_000  # elements over which the time of an array function is averaged
SPEEDS = np.linspace(0.05, 1.0, 20)
"""Belt speeds in m/s over which the largest error of a threshold is taken, those without a threshold left out."""
BISECTED = (1e-3, 1e-6, 1e-9)
"""Tolerances of ``scipy.integrate.solve_ivp``, whose own is the first; the last is too slow for many motions."""
SCAN_STEP = 0.001  # kg/s, the paper's
_REACH = 4 / 3  # of the box of initial conditions: in V/omega to both sides of 0, and in V
SIMULATED = (50, 200, 800)
"""Numbers of initial conditions that are simulated; runs of SciPy take the least, as each is ten times as long."""
_REPEATED: Any = {"least": 3, "enough": 0.02}  # runs of what takes less, and their seconds together, at least
_LARGEST, _SPREAD = "largest error up to V = 1 m/s", "standard error"  # what else is measured


@dataclass(frozen=True, repr=False)
class Trade(Comparison):
    """The methods for one number, each with its cost.

    - `number`: what kind of number: "value" of a criterion, "threshold" or "share" of a basin.
    - `point`: the operating point in SI units.
    """

    reported = ("title", "point", "rows", "dominators")

    number: str = "value"

    @property
    def dominators(self) -> dict[str, tuple[str, ...]]:
        """For each method which ones dominate it: at least as fast and as accurate, and better in one of the two.

        Named are those that are not dominated themselves: they suffice, as one of them dominates what any does.
        """
        costs = {row.name: (row.seconds, row.relative_error or 0.0) for row in self.rows if row.value is not None}
        by = {
            name: [other for other, cost in costs.items() if cost != mine and np.less_equal(cost, mine).all()]
            for name, mine in costs.items()
        }
        return {row.name: tuple(name for name in by.get(row.name, ()) if not by[name]) for row in self.rows}

    def draw(self, ax: Axes) -> None:
        """Draw error against time: filled what no other method dominates, and hollow what one does."""
        views_of(self).draw(self, ax)


@dataclass(frozen=True, repr=False)
class Tradeoff(Report, Drawn, TableResult):
    """What each method for a number costs, and how far it is off, from one run.

    Attributes
    ----------
    trades : dict of str to Trade
        By kind: "criterion", "threshold" and "basin", as far as they were asked for and measured. Each has `rows`,
        with `seconds` and `relative_error`, and `dominators`.
    refused : dict of str to str
        Of the others that were asked for, why there is none.
    """

    trades: dict[str, Trade]
    refused: dict[str, str] = field(default_factory=dict)

    def _table_columns(self) -> dict[str, list[Any]]:
        columns: dict[str, list[Any]] = {"number": [], **Comparison("", ())._table_columns()}
        for kind, trade in self.trades.items():
            columns["number"] += [kind] * len(trade.rows)
            for name, column in trade._table_columns().items():
                columns[name] += column
        return columns

    def __repr__(self) -> str:
        return (
            f"Tradeoff: {', '.join(f'{len(one.rows)} methods for a {kind}' for kind, one in self.trades.items())}"
        )


def tradeoff(
    law: FrictionLaw | str,
    *,
    of: str | Sequence[str] = KINDS,
    criterion: CriterionName | Criterion = "least_squares",
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
    >>> trade = tradeoff(laws.hyperbolic.typical(), of="criterion", V="0.001").trades["criterion"]
    >>> lambdified, stable = trade["plain lambdify, array"], trade["stable function, array"]
    >>> lambdified.relative_error > 1e-9 > 1e-15 > stable.relative_error
    True
    """
    law = as_law(law)
    if isinstance(of, str):
        kinds = [of]
    elif isinstance(of, Sequence):
        kinds = list(of)
    else:
        kinds = []
    if not kinds:
        raise InputError(f"of = {of!r} names nothing to measure; known: {', '.join(KINDS)}")
    for kind in kinds:
        lookup("trade of", kind, dict.fromkeys(KINDS))
    if c is not None and "basin" not in kinds:
        raise InputError("c belongs to the basins of attraction: ", Call('of="basin"', "tradeoff LAW --basins"))
    if law.missing:
        raise InputError(
            f"the law has no value for {', '.join(law.missing)}; give it first: ", ParameterValues.of(*law.missing)
        )
    chosen = find(criterion)
    given = {name: value for name, value in {"V": V, "N": N, "m": m, "k": k}.items() if value is not None}
    numbers = {name: float(exact(value, name)) for name, value in (PAPER | given).items()}
    damping = None if c is None else float(exact(c, "c"))
    trades: dict[str, Callable[[], Trade]] = {
        "criterion": lambda: _measure_criterion(law, chosen, {**PAPER, "V": LOW_SPEED, **given}),
        "threshold": lambda: _threshold(law, numbers),
        "basin": lambda: _basin(law, numbers, damping),
    }
    kept = dict[str, Trade]()
    errors = dict[str, StickSlipError]()
    with deadline.time_limit(time_limit), steps(kinds, str) as each_kind:
        for kind in each_kind:
            try:
                kept[kind] = trades[kind]()
            except StickSlipError as error:
                errors[kind] = error
    if not kept:
        raise next(iter(errors.values()))
    return Tradeoff(kept, {kind: str(error) for kind, error in errors.items()})


def _title(what: str, law: FrictionLaw, point: Mapping[str, object]) -> str:
    return f"{what}, {law.name or 'the law'}, {symbols.quantities_text(point)}"


# -- the value of a criterion ------------------------------------------------------------------------


def _measure_criterion(law: FrictionLaw, criterion: Criterion, point: Mapping[str, Number]) -> Trade:
    """Measure the methods for the value of a criterion, held against the closed form in twice the digits."""
    form = derive(law, criterion, time_limit=max(0.0, min(SECONDS_TO_DERIVE, deadline.time_left())))
    # Floats are what every method gets, so that none is blamed for the rounding of the input.
    at = {name: float(exact(point[name], name)) for name in "VN"}
    numbers: dict[str, Any] = at | {name: float(value) for name, value in law.values.items()}
    right = form.evaluate(_REFERENCE_DIGITS, **numbers)
    if right == 0:
        raise InputError("the criterion is 0 at this operating point: nothing has a relative error")

    def judge(result: Any) -> Json:
        with mp.workdps(_REFERENCE_DIGITS):
            value = mp.mpf(result if isinstance(result, mpmath.mpf) else float(np.ravel(result)[0]))
            exact_value = mp.mpf(right)
            return {"value": float(value), "relative_error": float(abs(value - exact_value) / abs(exact_value))}

    def row(method: str, setting: str, compute: Callable[[], Any], count: int = 1) -> Row:
        return measured(method, compute, judge, setting=setting, count=count, **_REPEATED)

    many = numbers | {"V": np.full(_ARRAY, at["V"])}
    plain = function_of(list(form.arguments.values()), form.expr, "numpy")
    rows = [
        row("plain lambdify", "array", partial(plain, *(many[name] for name in form.arguments)), _ARRAY),
        row("stable function", "array", partial(form, **many), _ARRAY),
        row("stable function", "one value", partial(form, **numbers)),
    ]
    if criterion.weight is not None and not jumps(law.expr, law.point):  # a rule for the slope misses a jump
        from scipy.integrate import quad

        integrand = _integrand(form, at["V"], at["N"])
        rows += [row("Gauss rule", f"{n} nodes", _gauss_rule(integrand, n)) for n in GAUSS_NODES]
        by_quad = partial(quad, integrand, 0, np.pi / 2, epsabs=0, epsrel=1e-13, full_output=1)
        rows.append(row("scipy.integrate.quad", "", lambda: by_quad()[0]))
    rows += [row("mpmath", f"{digits} digits", partial(form.evaluate, digits, **numbers)) for digits in DIGITS]
    title = _title(criterion.name, law, {name: point[name] for name in "VN"})
    return Trade(title, tuple(rows), at)


def _integrand(form: ClosedForm, V: float, N: float) -> Callable[[FloatArray], FloatArray]:
    """Return -N w(s) mu'(v) ds/dphi with v = 2V sin(phi)^2: smooth at both ends, square roots too."""
    ends = sp.symbols("p q", positive=True, cls=sp.Dummy)
    point = form.law.point
    weight = function_of(ends, form.criterion.from_ends(*ends), "numpy")
    slope = partial(
        function_of([*point, symbols.v], stable_slope_of(form.law.expr), "numpy"), *map(float, point.values())
    )

    def integrand(angle: FloatArray) -> FloatArray:
        sine = np.sin(angle)
        cosine = np.cos(angle)
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

    def by(name: str, V: float = point["V"]) -> Threshold[float]:
        """Return the threshold by a method; slope averages do not compute their errors."""
        method = methods()[name]
        if method.oscillator:
            numbers = {**point, "V": V}
        else:
            numbers = {"V": V, "N": point["N"]}
        return pure_slip_damping(law, **numbers, method=method, rtol=TIGHT_RTOL if method.converges else 1.0)

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

    def error(threshold: Threshold[float], reference: float) -> float:
        """Return the error against the orbit; the orbit's own is its estimate, and that of a proof its bound."""
        own = threshold.method == "orbit" or threshold.status is Status.PROVED
        if own and threshold.relative_error is not None:
            return threshold.relative_error
        return abs(threshold.value / reference - 1)

    def judge(threshold: Threshold[float]) -> Json:
        try:
            errors = [error(by(threshold.method, V), there) for V, there in references.items() if there > 0]
        except (OutOfTime, NotConverged, NoThreshold):
            errors = []
        further = {_LARGEST: max(errors)} if errors else {}
        return threshold_row(threshold) | {"relative_error": error(threshold, right), "further": further}

    def judge_number(value: float) -> Json:
        return {"value": value, "relative_error": abs(value / right - 1), "status": Status.ESTIMATED}

    osc = Oscillator(**point)
    rows = [measured(name, partial(by, name), judge, **_REPEATED) for name in methods()]
    scan = partial(pure_slip_by_scan, law, osc, np.arange(0.0, 2 * right, SCAN_STEP))
    rows.append(measured("Newmark scan", scan, judge_number))
    for rtol in BISECTED:
        bisection = partial(pure_slip_by_bisection, law, osc, 2 * right, rtol)
        rows.append(measured("solve_ivp and bisection", bisection, judge_number, setting=f"rtol {rtol:.0e}"))
    title = _title("threshold", law, point)
    return Trade(title, tuple(rows), point, "threshold")


# -- the share of initial conditions -----------------------------------------------------------------


def _basin(law: FrictionLaw, point: Mapping[str, float], c: float | None) -> Trade:
    """Measure the methods for the share of initial conditions that come to rest, against its area."""
    osc = Oscillator(c=_damping_between_thresholds(law, point) if c is None else c, **point)
    reach = _REACH * osc.V
    x0 = (-reach / osc.omega, reach / osc.omega)
    v0 = (0.0, reach)
    geometry = partial(basin_map, law, osc, x0=x0, v0=v0)
    basins = geometry()
    right = basins.share.get(Motion.REST)
    if right is None or right.counted or not right.value > right.error:
        settled = right is None or right.value == 0
        reason = "no initial condition comes to rest" if settled else "its basins are not settled"
        raise InputError(f"{reason} near rest: nothing has a relative error; try another c")

    def rests(x: float, v: float) -> bool:
        return classify(law, osc, x0=x, v0=v) is Motion.REST

    rng = np.random.default_rng(SEED)
    initial = np.column_stack([rng.uniform(*ends, max(SIMULATED)) for ends in (x0, v0)]).tolist()
    sides = basins.regime.by_side(*np.transpose(initial)).tolist()
    truth = [
        rests(*at) if motion is None else motion is Motion.REST for motion, at in zip(sides, initial, strict=True)
    ]

    def sampled(decide: Callable[[float, float], bool], count: int) -> list[bool]:
        decisions = []
        for x, v in initial[:count]:
            deadline.check_time()
            decisions.append(decide(x, v))
        return decisions

    def judge(decided: list[bool]) -> Json:
        share = float(np.mean(decided))
        spread = math.sqrt(right.value * (1 - right.value) / len(decided))
        # The sample's own error is that of its size, and the share that is wrong of these very initial conditions.
        wrong = share - float(np.mean(truth[: len(decided)]))
        error = math.hypot(wrong, spread) / right.value
        return {"value": share, "relative_error": error, "further": {_SPREAD: spread}}

    exact = {"value": right.value, "relative_error": float(right.error / right.value), "further": {_SPREAD: 0.0}}
    rows = [measured("geometry", geometry, lambda _: exact, **_REPEATED)]
    deciders = [("simulation", "", rests, count) for count in SIMULATED] + [
        (f"solve_ivp {name}", f"rtol {rtol:.0e}, ", partial(decide, law, osc, rtol=rtol), min(SIMULATED))
        for name, decide in (("with events", comes_to_rest), ("smoothed", comes_to_rest_smoothed))
        for rtol in BISECTED[:-1]
    ]
    for name, setting, decide, count in deciders:
        rows.append(measured(name, partial(sampled, decide, count), judge, setting=f"{setting}{count} samples"))
    numbers = {name: getattr(osc, name) for name in "VNmkc"}
    shown = _title("share of initial conditions that come to rest", law, numbers)
    title = f"{shown}, x0 = {x0[0]:g} to {x0[1]:g} m, v0 = {v0[0]:g} to {v0[1]:g} m/s"
    return Trade(title, tuple(rows), numbers, "share")


def _damping_between_thresholds(law: FrictionLaw, point: Mapping[str, float]) -> float:
    """Return the damping halfway from that where rest becomes stable to the threshold."""
    stable, threshold = (
        float(pure_slip_damping(law, **point, method=method).value) for method in ("equilibrium", "auto")
    )
    if not stable < threshold:
        raise NotConverged(
            f"rest is stable from {stable:.4g} kg/s on, and the threshold is {threshold:.4g} kg/s: rest and "
            "stick-slip coexist at no damping; give c, at which some motions come to rest"
        )
    return (stable + threshold) / 2


# -- what one computes without this package ------------------------------------------------------------
#
# Section 3 of the paper: step 1e-4 s, |v_r| <= 1e-4 m/s counts as v_r = 0; section 5: the damping is scanned from
# 0 to 6 kg/s in steps of 0.001 kg/s. The paper leaves open how the friction force enters a step; here it is
# that of the velocity at its beginning, which moves thresholds by a tenth of such a step. All dampings run side by
# side, one element of an array each.

BAND_ABOVE_REST = 1e-4  # m/s, the paper's
_ROUND = 1.5 * 2 * math.pi  # time in 1/omega within which a slip comes back to the belt's speed, if it does
_TIME_OF_RUN = 80 * 2 * math.pi  # time of a run in 1/omega
_QUIET = 0.1  # largest speed at rest, over the belt's
_SMOOTHED = 0.01  # of the smoothed sign of the slip speed, over the belt's
_DEFAULTS = {"method": "RK45", "max_step": math.inf}
"""What ``solve_ivp`` takes where nothing is said, unlike the package's reference."""


def pure_slip_by_scan(
    law: FrictionLaw, osc: Oscillator, dampings: FloatArray, step: float = 1e-4, band: float = BAND_ABOVE_REST
) -> float:
    """Return the lowest of ascending dampings at which the mass, once it slipped, does not come back to v_r = 0.

    - `step`: of time, in s.
    - `band`: relative speed in m/s that counts as none.
    """
    m = osc.m
    k = osc.k
    V = osc.V
    hold = law.mu(0.0) * osc.N
    c = dampings
    h = step
    x = np.zeros_like(c)
    v = np.full_like(c, V)
    a = np.zeros_like(c)
    away = returned = np.zeros(c.shape, dtype=bool)
    effective = m + c * h / 2 + k * h * h / 4  # average acceleration: gamma = 1/2, beta = 1/4
    for _ in range(int((hold / (k * V) + _ROUND / osc.omega) / h)):
        deadline.check_time()
        stick = (np.abs(v - V) <= band) & (np.abs(c * v + k * x) <= hold)
        # One return decides, as orbits in a plane do not cross; a fast one may step over the band.
        returned = returned | (away & (v - V >= -band))
        away = away | (v - V < -band)
        v_free = v + h / 2 * a
        x_free = x + h * v + h * h / 4 * a
        # At v_r = 0 a mass that static friction cannot hold is dragged on by the belt.
        force = np.where(v > V, -1.0, 1.0) * law.mu(np.abs(v - V)) * osc.N
        a_new = (force - c * v_free - k * x_free) / effective
        x = np.where(stick, x + h * V, x_free + h * h / 4 * a_new)
        v = np.where(stick, V, v_free + h / 2 * a_new)
        a = np.where(stick, 0.0, a_new)
    first_free = int(np.argmin(returned))
    if returned[first_free:].any():
        raise NoThreshold("no damping of the scan separates stick-slip from slip; scan another range")
    return float(dampings[first_free])


def pure_slip_by_bisection(law: FrictionLaw, osc: Oscillator, high: float, rtol: float) -> float:
    """Return the damping, below `high`, above which the slip from P does not come back, to the runs' `rtol`."""

    def comes_back(c: float) -> bool:
        deadline.check_time()
        x = (law.mu(0.0) * osc.N - c * osc.V) / osc.k
        t_end = _ROUND / osc.omega
        run = slip_by_solve_ivp(law.bound, replace(osc, c=c), 0.0, x, osc.V, 1, t_end, rtol, **_DEFAULTS)
        return bool(run.t_events[0].size)

    low = 0.0
    if not comes_back(low) or comes_back(high):
        raise NoThreshold(f"no damping from 0 to {high:.3g} kg/s separates slips that come back from others")
    while high - low > rtol * high:
        middle = (low + high) / 2
        if comes_back(middle):
            low = middle
        else:
            high = middle
    return (low + high) / 2


def comes_to_rest(law: FrictionLaw, osc: Oscillator, x0: float, v0: float, rtol: float) -> bool:
    """Return whether a motion comes to rest, by slip up to the belt's speed and stick in closed form."""
    run = simulate_by_solve_ivp(law, osc, x0, v0, _TIME_OF_RUN / osc.omega, rtol, **_DEFAULTS)
    return _is_quiet(run.t, run.v, osc)


def comes_to_rest_smoothed(law: FrictionLaw, osc: Oscillator, x0: float, v0: float, rtol: float) -> bool:
    """Return whether a motion comes to rest where the sign of the slip speed is smoothed; stick is slow slip."""
    from scipy.integrate import solve_ivp

    deadline.check_time()
    mu = law.function("math")
    at_rest = law.mu(0.0)

    def rates(_: float, y: FloatArray) -> tuple[float, float]:
        speed = osc.V - y[1]
        friction = math.tanh(speed / (_SMOOTHED * osc.V)) * osc.N * (mu(abs(speed)) if speed else at_rest)
        return y[1], (friction - osc.c * y[1] - osc.k * y[0]) / osc.m

    span = (0.0, _TIME_OF_RUN / osc.omega)
    run = solve_ivp(rates, span, (x0, v0), method="LSODA", rtol=rtol, atol=absolute_tolerance(osc, rtol))
    return _is_quiet(run.t, run.y[1], osc)


def _is_quiet(t: FloatArray, v: FloatArray, osc: Oscillator) -> bool:
    """Return whether a run is slow for its last period and a half."""
    return bool(np.abs(v[t > t[-1] - _ROUND / osc.omega]).max() <= _QUIET * osc.V)
