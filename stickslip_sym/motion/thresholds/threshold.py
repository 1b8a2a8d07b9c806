"""`pure_slip_damping`: the damping that separates stick-slip from slip, by the cheapest method good enough."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from stickslip_sym.core import deadline, symbols
from stickslip_sym.core.aliases import FloatArray, ObjectArray
from stickslip_sym.core.numbers import read_rtol
from stickslip_sym.core.uncertain import with_error
from stickslip_sym.criteria.criterion import Criterion, equilibrium, harmonic
from stickslip_sym.model.doubts import warn_where_negative
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.orbits.orbit import obstacle
from stickslip_sym.motion.thresholds import rungs
from stickslip_sym.motion.thresholds.climb import accuracy, by_name, climb
from stickslip_sym.motion.thresholds.rungs import Rung
from stickslip_sym.motion.thresholds.scenes import Quantity, Scenes
from stickslip_sym.motion.thresholds.uncertainty import Budget, deserved_tolerance, standard_errors
from stickslip_sym.output import markup

if TYPE_CHECKING:
    from stickslip_sym.criteria.enclosure import Enclosure
    from stickslip_sym.motion.thresholds.theorem import Theorem

__all__ = ["Threshold", "pure_slip_damping"]

_ENOUGH = 1e-3  # relative error of a threshold that is good enough where nothing else is said


@dataclass(frozen=True)
class Threshold:
    """A threshold: its value, the method that gave it, and its estimated relative error.

    Attributes
    ----------
    value : float or numpy.ndarray
        In kg/s. A negative value says that only a mass that is fed energy sticks and slips.
    method : str or numpy.ndarray of str
    error : float, numpy.ndarray or None
        Error against the exact threshold, relative: an estimate, with "proof" a bound; None if nothing is known.
    theorems : tuple of Theorem
        With "proof": what was proved of each scene, and how.
    deserved : float, optional
        The tolerance that "auto" took where none was given and the parameters' uncertainty deserves no less.
    scenes : Scenes, optional
        Where they are the thresholds; what they depend on follows from it.
    rung : Rung, optional
        That gave them, where it is not one of the ladder.
    """

    value: Any
    method: Any
    error: Any
    theorems: "tuple[Theorem, ...]" = ()
    deserved: float | None = None
    scenes: Scenes | None = field(default=None, repr=False, compare=False)
    rung: Rung | None = field(default=None, repr=False, compare=False)

    @cached_property
    def sensitivity(self) -> Mapping[str, Any]:
        """How the threshold changes with each quantity and parameter, alone: name to dc/dname, exact.

        In kg/m for V, s/m for N, 1/s for m, s for k, and kg/s over its unit for a parameter of the law; floats, or
        arrays as `value` is one. It is the derivative of the value that the method gives: that of an average is
        the average of the derivative, and m and k do nothing to it; for the grazing orbit it follows from one
        linear solve, by simulation and for a proved threshold from the variational equation along the slip. The
        coefficients of measured points are no parameters.

        Raises
        ------
        InputError
            For a method of one's own, of which only its values are known.
        """
        from stickslip_sym.motion.thresholds.sensitivity import sensitivities

        assert self.scenes is not None
        error = np.full(len(self.scenes), np.inf) if self.error is None else np.ravel(self.error)
        value, method = np.ravel(self.value), np.ravel(self.method)
        names = ["V", "N", *(["m", "k"] if self.scenes.m is not None else []), *self.scenes.law.parameters]
        columns = {name: np.empty(len(self.scenes)) for name in names}
        for chosen in np.unique(method):
            rows = np.flatnonzero(method == chosen)
            rung = self.rung or rungs.rungs()[str(chosen)]
            found = sensitivities(self.scenes.rows(rows), rung, value[rows], error[rows])
            for name, column in columns.items():
                column[rows] = found[name]
        if self.scenes.shape != ():
            return {name: column.reshape(self.scenes.shape) for name, column in columns.items()}
        return {name: float(column[0]) for name, column in columns.items()}

    @cached_property
    def budget(self) -> Budget | None:
        """Which standard error brings how much of the threshold's; None where nothing carries one."""
        assert self.scenes is not None
        errors = standard_errors(self.scenes)
        return None if errors is None else Budget.of(errors, self.sensitivity, self.scenes.shape)

    @cached_property
    def nonlinearity(self) -> Any:
        """The standard error to second order over that to first order; 1.0 where nothing carries an error.

        NaN where a threshold needed for it does not exist. It takes 2 n^2 + 1 thresholds for n errors.
        """
        return self._second_order[0]

    @cached_property
    def _second_order(self) -> tuple[Any, str]:
        from stickslip_sym.motion.thresholds.cubature import second_over_first

        assert self.scenes is not None
        errors, shape = standard_errors(self.scenes), self.scenes.shape
        if self.budget is None or errors is None:
            return (1.0 if shape == () else np.ones(shape)), ""
        first = np.ravel(self.budget.uncertainty)
        ratio, reason = second_over_first(self.scenes, first, np.ravel(self.method), errors, self.rung)
        return (float(ratio[0]) if shape == () else ratio.reshape(shape)), reason

    @property
    def uncertainty(self) -> Any:
        """Standard error of the threshold in kg/s that comes from those of V, N, m, k and the parameters.

        To first order, correlations included; `error` is the method's, and apart from it. None where nothing
        carries a standard error.

        Warns
        -----
        InputWarning
            If to second order it differs by more than 10 %, or that could not be computed.
        """
        from stickslip_sym.motion.thresholds.cubature import warn_of_ratio

        if self.budget is None:
            return None
        warn_of_ratio(*self._second_order)
        return self.budget.uncertainty

    @property
    def theorem(self) -> "Theorem | None":
        """What was proved of one scene, or None."""
        return self.theorems[0] if len(self.theorems) == 1 else None

    @property
    def enclosure(self) -> "Enclosure | None":
        """Two dampings between which the threshold of one scene was proved to lie, or None."""
        return None if self.theorem is None else self.theorem.enclosure

    @property
    def status(self) -> str:
        """PROVED, or ESTIMATED where the error is an estimate, or not known."""
        return "PROVED" if self.theorems else "ESTIMATED"

    def __str__(self) -> str:
        if self.theorem is not None:
            return f"{self.enclosure} kg/s ({self.method}, relative error at most {accuracy(self.error)}, PROVED)"
        if not np.ndim(self.value) and self.scenes is not None and self.budget is not None:
            off = "unknown" if self.error is None else f"{self.error * abs(self.value):.0e}"
            value = with_error(self.value, self.budget.uncertainty)
            return f"{value} kg/s (parameters) +/- {off} (method: {self.method})"
        if not np.ndim(self.value):
            return f"{self.value:.10g} kg/s ({self.method}, relative error {accuracy(self.error)}, {self.status})"
        if not np.size(self.value):
            return "0 thresholds"
        low, high, methods = np.min(self.value), np.max(self.value), ", ".join(np.unique(self.method))
        worst = accuracy(None if self.error is None else float(np.max(self.error)))
        return (
            f"{self.value.size} thresholds from {low:.6g} to {high:.6g} kg/s ({methods}, relative error {worst}, "
            f"{self.status})"
        )

    def __repr__(self) -> str:
        return f"Threshold: {self}"

    def _repr_html_(self) -> str:
        value, method = np.atleast_1d(self.value), np.atleast_1d(self.method)
        error = np.broadcast_to(np.inf if self.error is None else self.error, value.shape)
        rows = [
            ["..."] * 5
            if place is None
            else [
                ", ".join(map(str, place)),
                f"{value[place]:.10g}",
                str(method[place]),
                accuracy(float(error[place])),
                self.status,
            ]
            for place in markup.shortened(list(np.ndindex(value.shape)))
        ]
        header = ["scene", "c in kg/s", "method", "relative error", "status"]
        start = 0 if np.ndim(self.value) else 1
        return markup.table(header[start:], [row[start:] for row in rows], caption="pure-slip damping")


_Found: TypeAlias = "tuple[FloatArray, ObjectArray, FloatArray | None, tuple[Theorem, ...]]"
"""Values, methods, errors, and what was proved."""


def pure_slip_damping(
    law: FrictionLaw,
    *,
    V: Quantity,
    N: Quantity,
    m: Quantity | None = None,
    k: Quantity | None = None,
    method: str | Criterion | Rung = "auto",
    rtol: float | None = None,
    time_limit: float | None = None,
) -> Threshold:
    """Return the pure-slip damping coefficient of a law in a scene.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    V, N : float or array_like
        Belt speed in m/s and normal force in N. All four quantities broadcast. One number may be text, which
        "proof" takes exactly: "9.81" is 9.81, and 9.81 the nearest binary number. Each may carry a standard
        error, as in `law.bind`.
    m, k : float or array_like, optional
        Mass in kg and stiffness in N/m. Without them the error of an average of slopes is not known, unless
        mu is a straight line, which all methods treat exactly.
    method : str, Criterion or Rung
        "auto" gives the first value that knows its own error to be at most `rtol`, the cheapest rung first: to
        know how far an average is off takes a closer value. Without m and k it gives "harmonic", the limit of weak
        friction. Otherwise a rung: by name "equilibrium", "least_squares", "harmonic", "second_order", "orbit" or
        "simulation", or the average by a criterion of one's own. "proof" encloses the threshold, with every error
        bounded.
    rtol : float, optional
        Relative error that is good enough, 1e-13 to 1; for "simulation" at most 1e-3; for "proof" 1e-40 to 1e-3.
        If not given 1e-3, or with "auto" a tenth of the relative standard error that the parameters give c, if
        that is more: no method makes up for what is not known of them.
    time_limit : float, optional
        Seconds of computation after which it is given up.

    Returns
    -------
    Threshold
        Of arrays, where an argument is one; each scene has its own method then.

    Raises
    ------
    InputError
        For an unknown method, numbers that are missing or unusable, or a law that is not smooth, with "orbit"
        or "second_order".
    NoThreshold
        By simulation, if the orbit from P never returns for any c >= 0.
    NotConverged
        If the error is above `rtol` on the highest rung.
    OutOfTime
        When the time limit is reached; it tells the best value found, and its error.

    Warns
    -----
    InputWarning
        If mu is negative at a slip speed up to 2 V.
    """
    rung = rungs.find(method)
    best, worst = (1e-13, 1.0) if rung is None else (rung.tightest, rung.loosest)
    scenes = Scenes.of(law, V=V, N=N, m=m, k=k)
    law.function("numpy")  # refuses a law with parameters that have no value
    deserved = None
    if rtol is None:
        found = deserved_tolerance(scenes) if rung is None and scenes.m is not None else 0.0
        deserved = found if found > _ENOUGH else None
        rtol = max(found, _ENOUGH)
    rtol = read_rtol(rtol, least=best, most=worst)
    if rung is not None:
        rung.require_oscillator(scenes.m)
    if len(scenes):
        warn_where_negative(law, float(scenes.V.max()))
    with deadline.time_limit(time_limit):
        value, names, error, theorems = _found(scenes, rung, rtol)
    value = value + 0.0  # -0.0 becomes 0.0
    names = np.array(names.tolist(), dtype=str)
    own = None if rung is None or rungs.rungs().get(rung.name) is rung else rung
    if scenes.shape != ():
        error = None if error is None else error.reshape(scenes.shape)
        return Threshold(
            value.reshape(scenes.shape), names.reshape(scenes.shape), error, theorems, deserved, scenes, own
        )
    known = float(error[0]) if error is not None and np.isfinite(error[0]) else None
    return Threshold(float(value[0]), str(names[0]), known, theorems, deserved, scenes, own)


def _found(scenes: Scenes, rung: Rung | None, rtol: float) -> _Found:
    deadline.check_time()
    if scenes.m is None and (rung is None or not rung.oscillator):
        return _without_oscillator(scenes, rung, rtol)
    if rung is None:
        return (*climb(scenes, rtol), ())
    value, error, theorems = by_name(scenes, rung, rtol)
    return value, np.full(len(scenes), rung.name), error, theorems


def _without_oscillator(scenes: Scenes, rung: Rung | None, rtol: float) -> _Found:
    """Return what can be said without m and k."""
    reason = obstacle(scenes.law, scenes.V)
    straight = reason is None and not scenes.law.slope_expr.has(symbols.v)
    chosen = rung or rungs.find(equilibrium if straight else harmonic)
    assert chosen is not None
    if rung is None and reason is None:
        value = rungs.numerical_averages(scenes)[chosen.name]
    else:
        value = chosen.compute(scenes, rtol).value
    error = np.full(len(scenes), rungs.ROUNDING) if straight else None
    return value, np.full(len(scenes), chosen.name), error, ()
