"""`pure_slip_damping`: the damping that separates stick-slip from slip, by the cheapest method good enough."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Generic, TypeAlias, TypeVar, overload

import numpy as np

from stickslip_sym.core import deadline
from stickslip_sym.core.aliases import FloatArray, Numbers
from stickslip_sym.core.errors import NO_RESULT, InputError, OutOfTime
from stickslip_sym.core.numbers import read_rtol
from stickslip_sym.core.quantity import QuantityResult
from stickslip_sym.core.status import Status
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.negative import warn_where_negative
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.thresholds.methods import (
    Method,
    MethodName,
    Reference,
    accuracy,
    find_method,
    good_enough,
    is_straight,
    methods,
)
from stickslip_sym.motion.thresholds.operating_points import VANISHING, OperatingPoints, Quantity
from stickslip_sym.motion.thresholds.uncertainty import (
    Budget,
    second_order_ratio,
    shaped,
    standard_errors,
    warn_of_ratio,
)
from stickslip_sym.output.data import TableResult
from stickslip_sym.output.shown import Report

if TYPE_CHECKING:
    from stickslip_sym.criteria.enclosure import Enclosure
    from stickslip_sym.motion.thresholds.theorem import Theorem


Value = TypeVar("Value", bound=Numbers, covariant=True)
"""Of a threshold: a number at one operating point, an array at several."""
OneValue: TypeAlias = float | str
"""A quantity at one operating point."""


@dataclass(frozen=True, eq=False)
class Threshold(Report, QuantityResult, TableResult, Generic[Value]):
    """A threshold: its value, the method that gave it, and its relative error.

    Attributes
    ----------
    value : float or numpy.ndarray
        In kg/s. Where it is negative no damping is needed: only a mass that is fed energy sticks and slips.
    method : str or numpy.ndarray of str
    relative_error : float, numpy.ndarray or None
        Error against the exact threshold, relative: an estimate, with "proof" a bound; None if nothing is known.
        Where the threshold is below 1e-8 N <|mu'|>, as where slopes cancel, it is relative to that.
    error : float, numpy.ndarray or None
        The same in kg/s.
    points : OperatingPoints
        Where they are the thresholds; what they depend on follows from it.
    used : mapping of str to Method
        The methods that gave them, by name.
    theorems : tuple of Theorem
        With "proof": what was proved at each point, and how.
    time_limit : float, optional
        Seconds that its derivatives may take, and the second order of its uncertainty.
    """

    reported = ("value", "method", "relative_error", "error", "status", "uncertainty", "nonlinearity", "budget")

    value: Value
    method: Any
    relative_error: Value | None
    error: Value | None
    points: OperatingPoints = field(repr=False, compare=False)
    used: Mapping[str, Method] = field(repr=False, compare=False)
    theorems: tuple[Theorem, ...] = ()
    time_limit: float | None = field(default=None, repr=False, compare=False)

    def _table_columns(self) -> dict[str, Any]:
        columns: dict[str, Any] = dict(self.points.columns)
        for name in ("value", "method", "relative_error", "error"):
            columns[name] = np.broadcast_to(np.ravel(getattr(self, name)), len(self.points))
        return columns

    @cached_property
    def sensitivity(self) -> Mapping[str, Any]:
        """How the threshold changes with each quantity and parameter, alone: name to dc/dname, exact.

        In kg/m for V, s/m for N, 1/s for m, s for k, and kg/s over its unit for a parameter of the law; floats, or
        arrays as `value` is one. It is the derivative of the value that the method gives: that of an average is
        the average of the derivative, and m and k do nothing to it; that of "second_order" is exact too. For the
        threshold itself it follows from the equations of the orbit, or the variational one along the slip. The
        coefficients of measured points are no parameters.
        """
        columns = self._gradient(self.points)
        return {name: shaped(column, self.points.shape) for name, column in columns.items()}

    def _gradient(self, points: OperatingPoints) -> dict[str, FloatArray]:
        """Return dc/dname at points that stand for its own, each by the method that gave the threshold there."""
        names = (*points.columns, *points.law.parameters)
        method = np.ravel(self.method)
        columns: dict[str, FloatArray] = {name: np.empty(len(points)) for name in names}
        with deadline.time_limit(self.time_limit):
            deadline.check_time()
            for chosen in np.unique(method).tolist():
                rows = np.flatnonzero(method == chosen)
                for name, column in self.used[chosen].sensitivity(points.rows(rows)).items():
                    columns[name][rows] = column
        return columns

    @cached_property
    def budget(self) -> Budget | None:
        """Which standard error brings how much of the threshold's; None without errors."""
        names, covariance = standard_errors(self.points)
        if names:
            return Budget.of(names, covariance, self.sensitivity, self.points.shape)
        return None

    @property
    def nonlinearity(self) -> Any:
        """The standard error to second order over that to first order; 1.0 where nothing carries an error.

        NaN where a threshold needed for it does not exist. It takes the sensitivities at 2 n points for n errors.
        """
        return self._second_order[0]

    @cached_property
    def _second_order(self) -> tuple[Any, str]:
        """The ratio of both orders, and why it is not known."""
        ratio: FloatArray = np.ones(len(self.points))
        reason = ""
        if self.budget is not None:
            with deadline.time_limit(self.time_limit):
                ratio, reason = second_order_ratio(self.points, np.ravel(self.value), self._gradient)
        return shaped(ratio, self.points.shape), reason

    @property
    def uncertainty(self) -> Any:
        """Standard error of the threshold in kg/s that comes from those of V, N, m, k and the parameters.

        To first order, correlations included; `relative_error` is the method's, and apart from it. None where
        nothing carries a standard error.

        Warns
        -----
        InputWarning
            If to second order it differs by more than 10 %, or that could not be computed.
        """
        if self.budget is None:
            return None
        warn_of_ratio(*self._second_order)
        return self.budget.uncertainty

    @property
    def theorem(self) -> Theorem | None:
        """What was proved of one point, or None."""
        if len(self.theorems) == 1:
            return self.theorems[0]
        return None

    @property
    def enclosure(self) -> Enclosure | None:
        """Two dampings between which the threshold of one point was proved to lie, or None."""
        return None if self.theorem is None else self.theorem.enclosure

    @property
    def status(self) -> Status:
        """PROVED, or ESTIMATED where the error is an estimate, or not known."""
        return Status.PROVED if self.theorems else Status.ESTIMATED

    @property
    def has_standard_error(self) -> bool:
        """Whether a quantity or a parameter of the law carries a standard error."""
        return bool(self.points.uncertain or self.points.law.uncertain)

    @property
    def known_standard_error(self) -> Any:
        """The standard error as far as it was computed: NaN where that failed, None where nothing carries one."""
        if not self.has_standard_error:
            return None
        budget: Budget | None = vars(self).get("budget")
        if budget is None:
            return np.full(self.points.shape, np.nan)
        return budget.uncertainty

    def accuracy(self, index: tuple[int, ...] = (), form: str = ".0e") -> str:
        """Return the error of one value as text: relative, or in kg/s where the value is 0 within its error."""
        if self.relative_error is None:
            return "relative error unknown"
        scale = VANISHING * self.points.slope_scale.reshape(self.points.shape)
        columns = self.value, self.relative_error, self.error, scale
        value, off, error, least = (float(np.asarray(column)[index]) for column in columns)
        most = "at most " if self.theorems else ""
        if not math.isfinite(error) or abs(value) >= max(error, least) > 0:
            return f"relative error {most}{accuracy(off, form)}"
        text = "error 0"
        if error:
            text = f"error {most}{error:{form}} kg/s"
        if off >= 1 or not error:
            return text
        return f"{text}, which is {off:{form}} of {VANISHING:.0e} N <|mu'|>"

    def __repr__(self) -> str:
        return f"Threshold: {self}"

    def __float__(self) -> float:
        """The threshold in kg/s; several are refused."""
        if np.ndim(self.value):
            raise InputError(
                f"{np.size(self.value)} thresholds are no single number; take value, an array of them"
            )
        return float(self.value)


@overload
def pure_slip_damping(
    law: FrictionLaw | str,
    osc: Oscillator | None = None,
    /,
    *,
    V: OneValue | None = None,
    N: OneValue | None = None,
    m: OneValue | None = None,
    k: OneValue | None = None,
    method: MethodName | Criterion | Method = "auto",
    rtol: float = 1e-3,
    time_limit: float | None = None,
) -> Threshold[float]: ...
@overload
def pure_slip_damping(
    law: FrictionLaw | str,
    osc: Oscillator | None = None,
    /,
    *,
    V: Quantity | None = None,
    N: Quantity | None = None,
    m: Quantity | None = None,
    k: Quantity | None = None,
    method: MethodName | Criterion | Method = "auto",
    rtol: float = 1e-3,
    time_limit: float | None = None,
) -> Threshold[FloatArray]: ...
def pure_slip_damping(
    law: FrictionLaw | str,
    osc: Oscillator | None = None,
    /,
    *,
    V: Quantity | None = None,
    N: Quantity | None = None,
    m: Quantity | None = None,
    k: Quantity | None = None,
    method: MethodName | Criterion | Method = "auto",
    rtol: float = 1e-3,
    time_limit: float | None = None,
) -> Threshold[Any]:
    """Return the pure-slip damping of a law at operating points: with less of it the mass sticks again.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    osc : Oscillator, optional
        Holds V, N, m and k; its c is not used.
    V, N : float or array_like
        Belt speed in m/s and normal force in N. All four quantities broadcast. One number may be text, which
        "proof" takes exactly: "9.81" is 9.81, and 9.81 the nearest binary number. One number may carry a
        standard error, as in `law.bind`.
    m, k : float or array_like, optional
        Mass in kg and stiffness in N/m. Without them the error of an average of slopes is not known, unless
        mu is a straight line, which all methods treat exactly.
    method : str, Criterion or Method
        "auto" asks one method after another, the cheapest there first, and gives the first value that knows its
        own error to be at most `rtol`: "second_order", "simulation" or "orbit", and "proof" for what these have no
        digits for. Without m and k it gives "harmonic", the limit of weak friction. Otherwise one method:
        "equilibrium", "least_squares", "harmonic", "second_order", "orbit", "simulation", the average by a
        criterion of one's own, or "proof", which encloses the threshold, with every error bounded.
    rtol : float
        Relative error that is good enough, 1e-13 to 1; for "simulation" at most 1e-3; for "proof" 1e-40 to 1e-3.
        An average is what it is: its error is stated, whatever `rtol`.
    time_limit : float, optional
        Seconds of computation after which it is given up, and likewise what the result computes when it is asked.

    Returns
    -------
    Threshold
        Of arrays, where an argument is one; each operating point has its own method then. A negative value says
        that no damping is needed.

    Raises
    ------
    InputError
        For an unknown method, numbers that are missing or unusable, or a law that is not smooth, with "orbit"
        or "second_order".
    NoThreshold
        If the slip that follows stick returns to the belt's speed for no damping, or for every one.
    NotConverged
        If the error stays above `rtol`; the message holds the best value, and its error.
    OutOfTime
        When the time limit is reached; the message holds the best value so far, and its error.

    Warns
    -----
    InputWarning
        If mu is negative at a slip speed up to 2 V.

    Examples
    --------
    >>> from stickslip_sym import Oscillator, laws, pure_slip_damping
    >>> osc = Oscillator(m=1.0, k=100.0, V=0.5, N=9.81)
    >>> threshold = pure_slip_damping(laws.exponential.typical(), osc, rtol=1e-8)
    >>> f"{threshold.value:.7f} kg/s by {threshold.method}"
    '2.5730789 kg/s by orbit'
    """
    points = OperatingPoints.of(as_law(law), osc, V=V, N=N, m=m, k=k)
    return threshold_at(points, method, rtol, time_limit)


def threshold_at(
    points: OperatingPoints,
    method: MethodName | Criterion | Method,
    rtol: float,
    time_limit: float | None,
    shared: Reference | None = None,
) -> Threshold[Any]:
    """Return thresholds as `pure_slip_damping` does; `shared` is what several methods share at the same points."""
    law = points.law
    chosen = find_method(method)
    law.require_values()
    if chosen is None and not points.has_oscillator:
        chosen = find_method("equilibrium" if is_straight(law) else "harmonic")
    least, most = (1e-13, 1.0) if chosen is None else (chosen.tightest, chosen.loosest)
    rtol = read_rtol(rtol, least=least, most=most)
    if len(points):
        warn_where_negative(law.kinetic, float(points.V.max()))
    with deadline.time_limit(time_limit):
        deadline.check_time()
        computed, names, errors = good_enough(points, chosen, rtol, shared)
    if shared is not None and (chosen is None or chosen.converges):
        shared.offer(computed.value, computed.relative_error)
    table = methods() if chosen is None else {chosen.name: chosen}
    error = computed.relative_error
    known = np.isfinite(error).any() or not error.size
    threshold = Threshold(
        shaped(computed.value + 0.0, points.shape),  # -0.0 becomes 0.0
        str(names[0]) if points.shape == () else np.array(names.tolist(), dtype=str).reshape(points.shape),
        shaped(error, points.shape) if known else None,
        shaped(errors, points.shape) if known else None,
        points,
        {name: table[name] for name in set(names.tolist())},
        tuple(computed.theorems.values()) if len(computed.theorems) == len(points) else (),
        time_limit,
    )
    if threshold.has_standard_error:
        with suppress(*NO_RESULT, OutOfTime):  # raised again where it is asked for
            _ = threshold.budget
    return threshold
