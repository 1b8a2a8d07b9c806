"""The methods that give a pure-slip threshold, one entry each.

Every criterion is a method: an average of the falling slope. A further method is one `Method`, given to
`pure_slip_damping` as it is, or put into the table by `add_method` and then known by its name.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray, ObjectArray
from stickslip_sym.core.errors import NO_RESULT, InputError, NotConverged, NoThreshold, OutOfTime, StickSlipError
from stickslip_sym.core.names import lookup
from stickslip_sym.core.numbers import ROUNDING
from stickslip_sym.core.progress import steps
from stickslip_sym.core.remedies import Argument, Name
from stickslip_sym.criteria import criterion as criteria
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.kernel.slip_data import TIGHT
from stickslip_sym.motion.orbits.damping import DAMPING_RTOL
from stickslip_sym.motion.orbits.expansion import damping_of_layer, expand, expansion_changes
from stickslip_sym.motion.orbits.orbit import orbits
from stickslip_sym.motion.thresholds.averages import average_changes, fast_average
from stickslip_sym.motion.thresholds.grazing import grazing_damping, grazing_sensitivity
from stickslip_sym.motion.thresholds.operating_points import VANISHING, OperatingPoints

if TYPE_CHECKING:
    from stickslip_sym.motion.thresholds.theorem import Theorem

THRESHOLDS_TO_COMPILE = 200  # simulated thresholds, for which loading the compiled code is no loss
_PHASES, _COLLOCATION_TAIL = 64, 3e-5  # of half a period, and the tail that the law may have there for collocation
_FALLS = 30.0  # by so much the tail is smaller on the finest grid of collocation, where it has to be within rtol
_RELATIVE_KINK_DISTANCE = 1e-6  # of V: an orbit that comes so close to a kink is taken to pass it


@dataclass(frozen=True)
class Computed:
    """What a method says of operating points.

    - `value`: thresholds in kg/s, shape (n,); NaN where there is none.
    - `relative_error`: as far as the method knows it by itself, shape (n,); infinite where it does not. Where
      a threshold is below a small part of N <|mu'|>, relative to that, as `OperatingPoints.relative` says.
    - `refusals`: why there is no value, or one of a larger error than was asked for, by row.
    - `theorems`: what was proved, by row.
    """

    value: FloatArray
    relative_error: FloatArray
    refusals: Mapping[int, StickSlipError] = field(default_factory=dict)
    theorems: "Mapping[int, Theorem]" = field(default_factory=dict)


def _slip_changes(points: OperatingPoints) -> dict[str, FloatArray]:
    """Differentiate the mismatch between both halves of the orbit that grazes the belt's speed, point by point."""
    by_row = [grazing_sensitivity(points.law, points.oscillator(row)) for row in range(len(points))]
    names = (*points.columns, *points.law.parameters)
    return {name: np.array([sensitivity[name] for sensitivity in by_row]) for name in names}


@dataclass
class Reference:
    """Thresholds at some points that give the errors of averages there: kept, or asked for once."""

    computed: Computed | None = None

    def offer(self, value: FloatArray, relative_error: FloatArray) -> None:
        """Keep thresholds that a method gave, if accurate enough, and more accurate than those that are kept."""
        most = DAMPING_RTOL if self.computed is None else self.computed.relative_error
        if (relative_error <= most).all():
            self.computed = Computed(value, relative_error)

    def at(self, points: OperatingPoints, rows: IntArray) -> Computed:
        """Return those at some rows of all points."""
        if self.computed is None:
            self.computed, _ = evaluate(points, None, DAMPING_RTOL)
        return Computed(self.computed.value[rows], self.computed.relative_error[rows])


@dataclass(frozen=True)
class Method:
    """How a threshold is computed, and what that needs and costs.

    Attributes
    ----------
    name : str
    compute : callable
        From operating points, and the relative error that is good enough, to what is `Computed`.
    converges : bool
        Whether it comes as close to the threshold as is asked for. The value of an average is what it is, and its
        error is stated, however large.
    sensitivity : callable
        From operating points to the derivatives of their thresholds, dc/dname, by name; if not given those of the
        threshold itself.
    cost : float or callable
        What a threshold takes, about in milliseconds, or that at each operating point for a relative error: "auto"
        asks the cheapest method first, and none that is infinite.
    criterion : Criterion or None
        That of an average.
    smooth : bool
        Whether it needs a smooth law.
    tightest, loosest : float
        The smallest and the largest relative error that it can be asked for.
    """

    name: str
    compute: Callable[[OperatingPoints, float], Computed]
    converges: bool = True
    sensitivity: Callable[[OperatingPoints], Mapping[str, FloatArray]] = _slip_changes
    cost: float | Callable[[OperatingPoints, float], FloatArray] = 100.0
    criterion: Criterion | None = None
    smooth: bool = False
    tightest: float = 1e-13
    loosest: float = 1.0

    @property
    def automatic(self) -> bool:
        """Whether "auto" may take it."""
        return self.cost != math.inf

    @property
    def oscillator(self) -> bool:
        """Whether it needs m and k."""
        return self.criterion is None

    def check(self, law: FrictionLaw, V: ArrayLike, has_oscillator: bool) -> None:
        """Refuse operating points without m and k, or a law that is not smooth, where they are needed."""
        if self.oscillator and not has_oscillator:
            raise InputError(Argument("method", self.name), " needs the mass m and the stiffness k")
        if self.smooth and (reason := law.bound.obstacle(2 * float(np.max(V, initial=0.0)))) is not None:
            raise _not_smooth(self.name, reason)


def _not_smooth(name: str, reason: str) -> InputError:
    named = Argument("method", name)
    other = Argument("method", "simulation")
    return InputError(named, f" needs a law that is smooth: {reason}; try ", other)


# -- the table -------------------------------------------------------------------------------------


def add_method(method: Method) -> None:
    """Put a method at the end of the table, so that it is known by its name, unless there is one of that name."""
    if method.name in methods() or method.name == "auto":
        raise InputError(f"there is a method {method.name!r} already; give the new one another name")
    _table[method.name] = method


def methods() -> dict[str, Method]:
    """Return the methods by name: the averages by the criteria of the catalogue, and what comes closer."""
    return {name: _criterion_method(criterion) for name, criterion in criteria.catalogue.items()} | _table


MethodName: TypeAlias = (
    Literal["auto", "equilibrium", "least_squares", "harmonic", "second_order", "simulation", "orbit", "proof"]
    | str
)
"""A name in the table of methods; editors offer the package's own."""


def find_method(method: "MethodName | Criterion | Method") -> Method | None:
    """Return a method; None for "auto". A name that is none is refused."""
    if isinstance(method, Method):
        return method
    if isinstance(method, Criterion):
        return _criterion_method(method)
    known: dict[str, Method | None] = {**methods(), "auto": None}
    return lookup("method", method, known)


# -- one of them, or the cheapest ------------------------------------------------------------------


def good_enough(
    points: OperatingPoints, method: Method | None, rtol: float, shared: Reference | None = None
) -> tuple[Computed, ObjectArray, FloatArray]:
    """Return thresholds by a method, or by the cheapest for None, the names of their methods, and errors in kg/s.

    Their errors are at most `rtol` if the method converges, and stated if not. Where `rtol` is not reached, or
    time is up, the message holds the best value.

    - `shared`: what gives the errors of averages, if several methods are asked at the same points.
    """
    if method is not None:
        method.check(points.law, points.V, points.has_oscillator)
    computed, names = evaluate(points, method, rtol, prove=True)
    far = np.flatnonzero(~(computed.relative_error <= rtol))
    if not far.size:
        return computed, names, computed.relative_error * points.error_base(computed.value)
    row = int(far[0])
    if method is None or method.converges:
        refusal = computed.refusals.get(row)
        if isinstance(refusal, NoThreshold | InputError):
            raise refusal
        reason = (": ", refusal) if refusal is not None else ()
        more = () if method is not None and method.name == "proof" else (", or ", Argument("method", "proof"))
        raise NotConverged(
            Name("rtol"), f" = {rtol:g} is not reached for {points.label(row)}", *reason,
            f"{_best_value(points, computed, row)}; try another ", Name("rtol"), *more,
        )  # fmt: skip
    lacking = far[~np.isfinite(computed.value[far])]
    if lacking.size:
        raise NotConverged(
            f"the method {method.name!r} gives no finite number for {points.label(int(lacking[0]))}: slopes of mu "
            "are no numbers there, or overflow; check the law, or try ",
            Argument("method", "simulation"),
        )
    if points.has_oscillator:  # else nothing is known of the threshold itself
        some = points.rows(far)
        if shared is None:
            reference = evaluate(some, None, DAMPING_RTOL)[0]
        else:
            reference = shared.at(points, far)
        away = np.abs(computed.value[far] - reference.value)
        off = some.relative(away, reference.value) + reference.relative_error
        error = computed.relative_error.copy()
        base = points.error_base(computed.value)
        error[far], base[far] = np.where(np.isnan(off), np.inf, off), some.error_base(reference.value)
        return replace(computed, relative_error=error), names, error * base
    return computed, names, np.full(len(points), np.inf)


def evaluate(
    points: OperatingPoints, method: Method | None, rtol: float, *, prove: bool = False
) -> tuple[Computed, ObjectArray]:
    """Return what a method says, whatever its error, and its name; for None what the cheapest ones say.

    One method after another is asked for the points whose error is not small enough yet, and the best values are
    kept: NaN, an infinite error and "" where there is none.

    - `prove`: whether to end with a proof of what has a finite error.
    """
    count = len(points)
    if method is not None:
        computed = method.compute(points, min(max(rtol, method.tightest), method.loosest))
        return computed, np.full(count, method.name, dtype=object)
    value = np.full(count, np.nan)
    error = np.full(count, np.inf)
    names = np.full(count, "", dtype=object)  # texts of one width would cut longer ones
    refusals: dict[int, StickSlipError] = {}
    theorems: dict[int, Theorem] = {}
    best = Computed(value, error, refusals, theorems)
    for chosen, its_points in _ask_in_turn(points, rtol, prove):
        rows = np.flatnonzero(its_points & ~(error <= rtol) & (chosen.automatic | np.isfinite(error)))
        if not rows.size:
            continue
        try:
            computed, _ = evaluate(points if rows.size == count else points.rows(rows), chosen, rtol)
        except OutOfTime as stop:
            row = int(rows[0])
            raise OutOfTime(f"{stop}{_best_value(points, best, row) if error[row] < 1 else ''}") from None
        closer = computed.relative_error < error[rows]
        value[rows[closer]], error[rows[closer]] = computed.value[closer], computed.relative_error[closer]
        names[rows[closer]] = chosen.name
        if chosen.automatic:
            refusals |= {int(rows[row]): refusal for row, refusal in computed.refusals.items()}
        theorems |= {int(rows[row]): theorem for row, theorem in computed.theorems.items()}
    return best, names


def _ask_in_turn(points: OperatingPoints, rtol: float, prove: bool) -> Iterator[tuple[Method, BoolArray]]:
    """Yield the methods that are asked one after another, and which points are whose turn.

    Time stepping in double precision has an end; a proof takes a hundred times as long, and has any digits.
    """
    smooth = points.obstacle is None
    chosen = [
        candidate for candidate in methods().values() if candidate.automatic and (smooth or not candidate.smooth)
    ]
    costs = [
        candidate.cost(points, rtol) if callable(candidate.cost) else np.full(len(points), candidate.cost)
        for candidate in chosen
    ]
    for turn in np.argsort(costs, axis=0, kind="stable"):
        for number, candidate in enumerate(chosen):
            yield candidate, turn == number
    if prove:
        yield methods()["proof"], np.ones(len(points), dtype=bool)


def accuracy(error: float | None, form: str = ".0e") -> str:
    """Return a relative error as text."""
    if error is None or not np.isfinite(error):
        return "unknown"
    return format(error, form)


def _best_value(points: OperatingPoints, computed: Computed, row: int) -> str:
    """Return the best value of a point, for a message that it is not good enough."""
    value = computed.value[row]
    error = computed.relative_error[row]
    if not error < 1:
        return "; no value was found" if np.isfinite(error) else ""
    off = error * float(points.rows([row]).error_base(computed.value[[row]])[0])
    accurate = f"relative error {accuracy(error)}" if off < abs(value) else f"error {off:.0e} kg/s"
    return f"; the best value found for {points.label(row)} is {value:.10g} kg/s, {accurate}"


# -- averages of the slope -------------------------------------------------------------------------


@lru_cache(maxsize=32)
def _criterion_method(criterion: Criterion) -> Method:
    return Method(
        criterion.name,
        partial(_damping_by_average, criterion),
        converges=False,
        sensitivity=partial(average_changes, criterion),
        cost=math.inf,
        criterion=criterion,
    )


def _damping_by_average(criterion: Criterion, points: OperatingPoints, rtol: float) -> Computed:
    del rtol  # the value of an average is what it is
    error = np.full(len(points), ROUNDING if is_straight(points.law) else np.inf)
    return Computed(points.N * fast_average(points.law, criterion, points.V), error)


def is_straight(law: FrictionLaw) -> bool:
    """Whether mu is a straight line down to rest, of which every average is the threshold."""
    return law.kinetic.is_straight and law.bound.obstacle(0.0) is None


# -- slip orbits -----------------------------------------------------------------------------------


def _damping_by_expansion(points: OperatingPoints, rtol: float) -> Computed:
    """Return the damping to second order in the friction; the error is that of the grid and the next order.

    The expansion goes by the square of the orbit's distortion. It is one of the largest slope, not of the average,
    in which slopes may cancel.
    """
    del rtol  # the value is what it is
    weak = points.weak
    strength = points.strength
    N = points.N
    everything, unsure, _ = points.averaged
    with np.errstate(all="ignore"):  # for strong friction the expansion is no number, or a huge one
        value = N * (weak.harmonic + strength**2 * weak.second)
        # `tail` is relative to the largest slope; a layer between v = 0 and the first phase would pass unseen.
        resolution = N * (weak.tail * weak.largest + np.abs(weak.harmonic - everything) + unsure)
        scale = N * np.maximum(weak.largest, np.abs(everything))
        layer = points.impedance * damping_of_layer(points.bound, points.V, strength, weak.phases)
        more = (strength * weak.overtones) ** 4 * scale + layer
        error = points.relative(resolution + more + ROUNDING * points.slope_scale, value)
        # The orbit goes beyond 2 V by its overtones, to where the expansion does not look.
        beyond = points.V * (2 + strength * weak.overtones + _RELATIVE_KINK_DISTANCE)
        table = points.bound.table
        smooth = table.resolved(2 * points.V, beyond, 1) & (beyond < min(table.kinks, default=math.inf))
        error[~smooth] = np.inf
    return Computed(value, np.where(np.isfinite(value) & ~np.isnan(error), error, np.inf))


def _expansion_changes(points: OperatingPoints) -> dict[str, FloatArray]:
    """Differentiate c = N (h + N^2/(k m) s), h and s averages of slopes and of their products."""
    law = points.law
    weak = points.weak
    N = points.N
    weight = points.strength**2
    by_inertia = -N * weight * weak.second

    def changed(name: str) -> FloatArray:
        harmonic, second = expansion_changes(points.bound, law.partial(name).bound, points.V, weak)
        return np.asarray(N * (harmonic + weight * second))

    with np.errstate(all="ignore"):
        return {
            "V": changed("V") / points.V,
            "N": weak.harmonic + 3 * weight * weak.second,
            "m": by_inertia / points.columns["m"],
            "k": by_inertia / points.columns["k"],
            **{name: changed(name) for name in law.parameters},
        }


def _orbit_cost(points: OperatingPoints, rtol: float) -> FloatArray:
    """Return less than a simulation for a law that few phases resolve: too strong a friction shows at once."""
    tail = expand(points.bound, points.V, fewest=_PHASES, most=_PHASES).tail
    return np.where(tail <= min(_COLLOCATION_TAIL, _FALLS * rtol), 2.0, 10.0)


def _damping_by_orbit(points: OperatingPoints, rtol: float) -> Computed:
    orbit = orbits(points.bound, points.V, points.strength, rtol=rtol)
    value = orbit.d * points.impedance
    with np.errstate(invalid="ignore"):
        error = points.relative(orbit.relative_error * np.abs(value), value)  # NaN where d is 0 but need not be
    error[np.isnan(error)] = np.inf
    lowest = float(np.fmin.reduce(orbit.lowest, initial=0.0)) - _RELATIVE_KINK_DISTANCE
    reason = points.bound.obstacle(float(np.max(points.V, initial=0.0)) * (1 - lowest))
    if reason is not None:
        refusals = dict.fromkeys(range(len(points)), _not_smooth("orbit", reason))
        return Computed(np.full_like(value, np.nan), np.full_like(error, np.inf), refusals)
    # Friction is too strong for a grid of phases, or mu rough.
    far = np.flatnonzero(~(error <= rtol))
    halves = _damping_by_simulation(points.rows(far), rtol)
    closer = ~(error[far] <= halves.relative_error)
    value[far[closer]], error[far[closer]] = halves.value[closer], halves.relative_error[closer]
    return Computed(value, error, {int(far[row]): refusal for row, refusal in halves.refusals.items()})


def _orbit_changes(points: OperatingPoints) -> dict[str, FloatArray]:
    """Differentiate the equations of collocation; the mismatch of both halves where they do not give the orbit."""
    law = points.law
    N = points.N
    partials = [law.partial(name).bound for name in ("V", *law.parameters)]
    orbit = orbits(points.bound, points.V, points.strength, added=[points.bound, *partials])
    by_N, by_V, *others = orbit.changes.T
    by_impedance = (orbit.d * points.impedance - N * by_N) / 2  # c/sqrt(k m) depends on N/sqrt(k m) alone
    columns = {"V": N * by_V / points.V, "N": by_N}
    columns |= {name: by_impedance / points.columns[name] for name in ("m", "k")}
    columns |= {name: N * column for name, column in zip(law.parameters, others, strict=True)}
    far = np.flatnonzero(~(orbit.relative_error <= TIGHT))
    for name, column in _slip_changes(points.rows(far)).items():
        columns[name][far] = column
    return columns


# -- the slip from P -------------------------------------------------------------------------------


def _damping_by_simulation(points: OperatingPoints, rtol: float) -> Computed:
    """Return the damping at which the simulated slip from P grazes the belt's speed."""
    fast = len(points) >= THRESHOLDS_TO_COMPILE
    computed = _each(
        points, lambda row: grazing_damping(points.bound, points.oscillator(row), rtol=rtol, fast=fast)
    )
    relative = points.relative(computed.relative_error, computed.value)
    relative[np.isnan(computed.value)] = np.inf  # of a row that was refused
    return replace(computed, relative_error=relative)


def _each(points: OperatingPoints, compute: Callable[[int], tuple[float, float]]) -> Computed:
    """Return values and errors, or refusals, row by row."""
    columns = np.full((2, len(points)), [[np.nan], [np.inf]])
    refusals: dict[int, StickSlipError] = {}
    with steps(range(len(points)), points.label) as rows:
        for row in rows:
            try:
                columns[:, row] = compute(row)
            except NO_RESULT as refusal:
                refusals[row] = refusal
    return Computed(columns[0], columns[1], refusals)


def _damping_by_proof(points: OperatingPoints, rtol: float) -> Computed:
    """Return the middle of the dampings between which the threshold was proved to lie."""
    from stickslip_sym.motion.thresholds.boxes import ExactPoint
    from stickslip_sym.motion.thresholds.theorem import prove_threshold

    theorems = {}

    def proved(row: int) -> tuple[float, float]:
        c, error = grazing_damping(points.bound, points.oscillator(row), rtol=DAMPING_RTOL)
        scale = float(points.slope_scale[row])
        off = float(points.rows([row]).relative(np.array([error]), np.array([c]))[0])
        theorems[row] = prove_threshold(ExactPoint(points.law, **points.exact_row(row)), c, off, rtol, scale)
        enclosure = theorems[row].enclosure
        base = max(abs(enclosure.mid), Fraction(VANISHING * scale))
        return float(enclosure), float(enclosure.radius / base)

    return replace(_each(points, proved), theorems=theorems)


_table: dict[str, Method] = {
    method.name: method
    for method in (
        Method("second_order", _damping_by_expansion, False, _expansion_changes, cost=1.0, smooth=True),
        Method("simulation", _damping_by_simulation, cost=5.0, loosest=1e-3),
        Method("orbit", _damping_by_orbit, True, _orbit_changes, cost=_orbit_cost, smooth=True),
        Method("proof", _damping_by_proof, cost=math.inf, tightest=1e-40, loosest=1e-3),
    )
}
