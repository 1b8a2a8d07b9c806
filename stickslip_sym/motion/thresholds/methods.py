"""The methods that give a pure-slip threshold, one entry each.

Every criterion is a method: an average of the falling slope. A further method is one `Method`, given to
`pure_slip_damping` as it is, or put into the table by `add_method` and then known by its name.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache, partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import FloatArray, ObjectArray
from stickslip_sym.core.errors import NO_RESULT, InputError, NotConverged, NoThreshold, OutOfTime, StickSlipError
from stickslip_sym.core.numbers import lookup
from stickslip_sym.criteria import criterion as criteria
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.orbits.expansion import averages, expand, of_layer
from stickslip_sym.motion.orbits.orbit import obstacle, orbits
from stickslip_sym.motion.thresholds import sensitivity
from stickslip_sym.motion.thresholds.averages import average
from stickslip_sym.motion.thresholds.grazing import grazing_damping
from stickslip_sym.motion.thresholds.operating_points import OperatingPoints

if TYPE_CHECKING:
    from stickslip_sym.motion.thresholds.theorem import Theorem

__all__ = [
    "Computed", "Method", "accuracy", "add_method", "best_of", "by_method", "cheapest", "find_method",
    "is_straight", "methods", "second_order",
]  # fmt: skip

ROUNDING = 1e-14
_REFERENCE = 1e-8  # relative error of the threshold from which the error of an average is taken
_TAIL = 0.5  # part of rtol that the tail of an orbit's spectrum may have: its error is a little more than that
_GUESS = 1e-9  # tolerance of the simulation that says where a proof has to look
_MANY = 200  # simulated thresholds, for which loading the compiled code is no loss
_ORBIT_WORK = 3e6  # cubes of grids that collocation may take for one orbit: as much as a simulation


@dataclass(frozen=True)
class Computed:
    """What a method says of operating points.

    Attributes
    ----------
    value : numpy.ndarray, shape (n,)
        Thresholds in kg/s; NaN where there is none.
    relative_error : numpy.ndarray, shape (n,)
        As far as the method knows it by itself; infinite where it does not.
    refusals : mapping of int to StickSlipError
        Why there is no value, or one of a larger error than was asked for, by row.
    theorems : tuple of Theorem
        What was proved of each point, if anything was.
    """

    value: FloatArray
    relative_error: FloatArray
    refusals: Mapping[int, StickSlipError] = field(default_factory=dict)
    theorems: "tuple[Theorem, ...]" = ()


@dataclass(frozen=True)
class Method:
    """One way to a threshold.

    Attributes
    ----------
    name : str
    compute : callable
        From operating points, and the relative error that is good enough, to what is `Computed`.
    converges : bool
        Whether it comes as close to the threshold as is asked for. The value of an average is what it is, and its
        error is stated, however large.
    sensitivity : callable or None
        From operating points and their thresholds to the derivatives of these, dc/dname, by name.
    automatic : bool
        Whether "auto" may take it; it asks in the order of the table, the cheapest first.
    criterion : Criterion or None
        That of an average.
    oscillator, smooth : bool
        Whether it needs m and k, and whether a smooth law.
    tightest, loosest : float
        The smallest and the largest relative error that it can be asked for.
    """

    name: str
    compute: Callable[[OperatingPoints, float], Computed]
    converges: bool = True
    sensitivity: Callable[[OperatingPoints, FloatArray], Mapping[str, FloatArray]] | None = None
    automatic: bool = True
    criterion: Criterion | None = None
    oscillator: bool = True
    smooth: bool = False
    tightest: float = 1e-13
    loosest: float = 1.0

    def check(self, law: FrictionLaw, V: ArrayLike, has_oscillator: bool) -> None:
        """Refuse operating points without m and k, or a law that is not smooth, where they are needed.

        Raises
        ------
        InputError
        """
        if self.oscillator and not has_oscillator:
            raise InputError(f'method="{self.name}" needs the mass m and the stiffness k')
        reason = obstacle(law, V) if self.smooth else None
        if reason is not None:
            raise InputError(f'method="{self.name}" needs a law that is smooth: {reason}; try method="simulation"')


# -- the table -------------------------------------------------------------------------------------


def add_method(method: Method) -> None:
    """Put a method at the end of the table, so that it is known by its name.

    Raises
    ------
    InputError
        If there is one of that name.
    """
    if method.name in methods() or method.name == "auto":
        raise InputError(f"there is a method {method.name!r} already; give the new one another name")
    _table[method.name] = method


def methods() -> dict[str, Method]:
    """Return the methods by name: the averages by the criteria of the catalogue, and what comes closer."""
    return {name: _of_criterion(criterion) for name, criterion in criteria.catalogue.items()} | _table


def find_method(method: "str | Criterion | Method") -> Method | None:
    """Return a method; None for "auto".

    Raises
    ------
    InputError
        If there is none of that name.
    """
    if isinstance(method, Method):
        return method
    if isinstance(method, Criterion):
        return _of_criterion(method)
    known: dict[str, Method | None] = {**methods(), "auto": None}
    return lookup("method", method, known)


# -- one of them, or the cheapest ------------------------------------------------------------------


def accuracy(error: float | None) -> str:
    """Return a relative error as text."""
    return "unknown" if error is None or not np.isfinite(error) else f"{error:.0e}"


def by_method(points: OperatingPoints, method: Method, rtol: float) -> Computed:
    """Return the thresholds by one method; its errors are at most `rtol` if it converges, and stated if not.

    Raises
    ------
    InputError
        For a law that is not smooth, where the method needs one.
    NoThreshold, NotConverged
        If a method that converges does not reach `rtol` at some point; the message holds the best value.
    """
    method.check(points.law, points.V, points.m is not None)
    computed = method.compute(points, rtol)
    far = np.flatnonzero(~(computed.relative_error <= rtol))
    if not far.size:
        return computed
    lacking = far[~np.isfinite(computed.value[far])]
    if lacking.size and not method.converges:
        row = int(lacking[0])
        raise NotConverged(
            f"the method {method.name!r} gives no finite number for {points.label(row)}: slopes of mu are no "
            'numbers there, or overflow; check the law, or try method="simulation"'
        )
    if method.converges:
        _refuse(points, computed, int(far[0]), rtol)
    if points.m is None:
        return computed  # nothing is known of the threshold itself
    reference, _ = best_of(points.rows(far), _REFERENCE)
    whole = computed.relative_error.copy()
    whole[far] = _difference(computed.value[far], reference.value) + reference.relative_error
    return Computed(computed.value, whole)


def cheapest(points: OperatingPoints, rtol: float) -> tuple[Computed, ObjectArray]:
    """Return at each point the first value that is known to be good enough, and the name of its method.

    Raises
    ------
    NoThreshold, NotConverged
        If no method reaches `rtol` at some point; the message holds the best value.
    OutOfTime
        With the best value so far.
    """
    best, name = best_of(points, rtol)
    far = np.flatnonzero(~(best.relative_error <= rtol))
    if far.size:
        _refuse(points, best, int(far[0]), rtol)
    return best, name


def best_of(points: OperatingPoints, rtol: float) -> tuple[Computed, ObjectArray]:
    """Ask one method after another for the points whose error is not small enough yet, and keep the best values.

    Returns
    -------
    Computed, numpy.ndarray of str
        Values and the names of their methods; NaN, an infinite error and "" where there is none.
    """
    value, error = np.full(len(points), np.nan), np.full(len(points), np.inf)
    name = np.full(len(points), "", dtype=object)  # texts of one width would cut longer ones
    refusals: dict[int, StickSlipError] = {}
    smooth = obstacle(points.law, points.V) is None
    for method in methods().values():
        rows = np.flatnonzero(~(error <= rtol))
        if not method.automatic or (method.smooth and not smooth) or not rows.size:
            continue
        try:
            computed = method.compute(points.rows(rows), min(max(rtol, method.tightest), method.loosest))
        except OutOfTime as stop:
            row = int(rows[0])
            raise OutOfTime(f"{stop}{_so_far(value[row], error[row], points.label(row))}") from None
        closer = computed.relative_error < error[rows]
        value[rows[closer]], error[rows[closer]] = computed.value[closer], computed.relative_error[closer]
        name[rows[closer]] = method.name
        refusals |= {int(rows[row]): refusal for row, refusal in computed.refusals.items()}
    return Computed(value, error, refusals), name


def _so_far(value: float, error: float, label: str) -> str:
    if not np.isfinite(error):
        return ""
    return f"; the best value found for {label} is {value:.10g} kg/s, relative error {accuracy(error)}"


def _refuse(points: OperatingPoints, computed: Computed, row: int, rtol: float) -> None:
    """Raise why a point has no value that is good enough."""
    refusal = computed.refusals.get(row)
    if isinstance(refusal, NoThreshold | InputError):
        raise refusal
    reason = f": {refusal}" if refusal is not None else ""
    label = points.label(row)
    best = _so_far(computed.value[row], computed.relative_error[row], label)
    raise NotConverged(f"rtol = {rtol:g} is not reached for {label}{reason}{best}; try another rtol")


def _difference(value: FloatArray, reference: FloatArray) -> FloatArray:
    """Return the relative difference, infinite where one of the two is no number."""
    with np.errstate(all="ignore"):
        difference = np.where(value == reference, 0.0, np.abs(value - reference) / np.abs(reference))
    return np.where(np.isnan(difference), np.inf, difference)


# -- averages of the slope -------------------------------------------------------------------------


@lru_cache(maxsize=32)
def _of_criterion(criterion: Criterion) -> Method:
    return Method(
        criterion.name,
        partial(_by_average, criterion),
        converges=False,
        sensitivity=partial(sensitivity.of_average, criterion),
        automatic=False,
        criterion=criterion,
        oscillator=False,
    )


def _by_average(criterion: Criterion, points: OperatingPoints, rtol: float) -> Computed:
    del rtol  # the value of an average is what it is
    error = np.full(len(points), ROUNDING if is_straight(points.law) else np.inf)
    return Computed(average(points, criterion), error)


def is_straight(law: FrictionLaw) -> bool:
    """Whether mu is a straight line down to rest, of which every average is exact."""
    return not law.slope_expr.has(symbols.v) and not law.kinks() and obstacle(law, 0.0) is None


# -- methods that need m and k ---------------------------------------------------------------------


def second_order(points: OperatingPoints) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the damping to second order in the friction, its resolution, and what the next order may add.

    Both are relative errors; the resolution is that of the grid. The expansion goes by the square of the orbit's
    distortion, the amplitudes of the overtones times their orders: friction changes along an orbit as fast as its
    highest ones do. It is one of the largest slope, not of the average, in which slopes may cancel.
    """
    strength, N = points.N / points.impedance, points.N
    (everything,) = averages(points.law, points.V)
    with np.errstate(all="ignore"):  # for strong friction the expansion is no number, or a huge one
        weak = expand(points.law, points.V)
        value = N * (weak.harmonic + strength**2 * weak.second)
        # `tail` is relative to the largest slope.
        resolution = np.where(weak.tail == 0, 0.0, weak.tail * weak.largest / np.abs(weak.harmonic))
        # A layer of the law between v = 0 and the first phase would pass unseen.
        unseen = np.abs(weak.harmonic - everything)
        resolution += np.where(unseen == 0, 0.0, unseen / np.abs(weak.harmonic))
        distortion = strength * (np.abs(weak.sines) @ np.arange(weak.sines.shape[1]))
        scale = N * np.maximum(weak.largest, np.abs(everything))
        layer = points.impedance * of_layer(points.law, points.V, strength, weak.sines.shape[1])
        more = distortion**4 * scale + layer
        next_order = np.where(more == 0, 0.0, more / np.abs(value))
    resolution = np.where(np.isfinite(value), resolution, np.inf)
    return value, resolution, np.where(np.isnan(next_order), np.inf, next_order)


def _by_expansion(points: OperatingPoints, rtol: float) -> Computed:
    del rtol  # the value is what it is
    value, resolution, next_order = second_order(points)
    return Computed(value, next_order + resolution + ROUNDING)


def _by_orbit(points: OperatingPoints, rtol: float) -> Computed:
    strength = points.N / points.impedance
    found = orbits(points.law, points.V, strength, rtol=_TAIL * rtol, most_work=_ORBIT_WORK)
    value, error = found.d * points.impedance, found.relative_error
    reason = obstacle(points.law, points.V, float(found.lowest.min(initial=0.0)))
    if reason is not None:
        refusal = InputError(f'method="orbit" needs a law that is smooth: {reason}; try method="simulation"')
        return Computed(
            np.full_like(value, np.nan), np.full_like(error, np.inf), dict.fromkeys(range(len(points)), refusal)
        )
    refusals: dict[int, StickSlipError] = {}
    for row in np.flatnonzero(
        ~(error <= rtol)
    ).tolist():  # friction is too strong for a grid of phases, or mu rough
        try:
            halves = grazing_damping(points.law, points.oscillator(row), rtol=rtol)
        except NO_RESULT as refusal:
            refusals[row] = refusal
            continue
        if not error[row] <= halves[1]:
            value[row], error[row] = halves
    return Computed(value, error, refusals)


def _by_simulation(points: OperatingPoints, rtol: float) -> Computed:
    """Return the damping at which the simulated slip from P grazes the belt's speed, point by point."""
    found = np.full((2, len(points)), [[np.nan], [np.inf]])
    refusals: dict[int, StickSlipError] = {}
    fast = len(points) >= _MANY
    for row in range(len(points)):
        try:
            found[:, row] = grazing_damping(points.law, points.oscillator(row), rtol=rtol, fast=fast)
        except NO_RESULT as refusal:
            refusals[row] = refusal
    return Computed(found[0], found[1], refusals)


def _by_proof(points: OperatingPoints, rtol: float) -> Computed:
    """Return the middle of the dampings between which the threshold was proved to lie."""
    from stickslip_sym.motion.thresholds.boxes import ExactPoint
    from stickslip_sym.motion.thresholds.theorem import prove_threshold

    found = []
    for row in range(len(points)):
        guess, error = grazing_damping(points.law, points.oscillator(row), rtol=_GUESS)
        found.append(prove_threshold(ExactPoint(points.law, **points.exact_row(row)), guess, error, rtol))
    enclosures = [theorem.enclosure for theorem in found]
    value = np.array([float(enclosure) for enclosure in enclosures])
    error = np.array([float(one.radius / abs(one.mid)) for one in enclosures])
    return Computed(value, error, theorems=tuple(found))


_table: dict[str, Method] = {
    method.name: method
    for method in (
        Method("second_order", _by_expansion, converges=False, sensitivity=sensitivity.of_orbit, smooth=True),
        Method("simulation", _by_simulation, sensitivity=sensitivity.of_slip, loosest=1e-3),
        Method("orbit", _by_orbit, sensitivity=sensitivity.of_orbit, smooth=True),
        Method("proof", _by_proof, sensitivity=sensitivity.of_slip, automatic=False, tightest=1e-40, loosest=1e-3),
    )
}
