"""`pure_slip_damping`: the damping that separates stick-slip from slip, by the cheapest method good enough.

The ladder has six rungs: equilibrium, least_squares, harmonic, second_order, orbit, simulation. The first three
are averages of the slope of mu. The error of a rung is its difference from a higher one.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core import deadline, symbols
from stickslip_sym.core.errors import InputError, NotConverged, OutOfTime, StickSlipError
from stickslip_sym.core.numbers import lookup
from stickslip_sym.model.doubts import warn_where_negative
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import read_rtol
from stickslip_sym.motion.orbits.orbit import obstacle
from stickslip_sym.motion.thresholds.rungs import (
    AVERAGES,
    Scenes,
    average,
    numerical_averages,
    on_orbit,
    second_order,
    simulated,
)
from stickslip_sym.output import markup

__all__ = ["METHODS", "Threshold", "pure_slip_damping"]

LADDER = (*AVERAGES, "second_order", "orbit", "simulation")
METHODS = (*LADDER, "auto")
_ROUNDING = 1e-14
_REACHABLE = 1e-9  # an orbit's error that is rounding where thresholds are near 0, and not refused
_REFERENCE = 1e-10  # error of the best value, from which the error of others is told
_GOOD = 1e-8  # of that error, what need not be improved by simulation
_LOOSEST = 1e-7  # of a simulation: what it costs hardly depends on it, and stiff motions get lost in rounding
_TIGHTER = (0.1, 1e-3, 1e-5)  # tolerances of simulation over rtol, until the error is at most that


@dataclass(frozen=True)
class Threshold:
    """A threshold: its value, the method that gave it, and its estimated relative error.

    Attributes
    ----------
    value : float or numpy.ndarray
        In kg/s. A negative value says that only a mass that is fed energy sticks and slips.
    method : str or numpy.ndarray of str
    error : float, numpy.ndarray or None
        Estimated error against the exact threshold, relative; None where nothing is known of it.
    """

    value: Any
    method: Any
    error: Any

    def __str__(self) -> str:
        if not np.ndim(self.value):
            return f"{self.value:.10g} kg/s ({self.method}, relative error {_accuracy(self.error)})"
        if not np.size(self.value):
            return "0 thresholds"
        low, high, methods = np.min(self.value), np.max(self.value), ", ".join(np.unique(self.method))
        worst = _accuracy(None if self.error is None else np.max(self.error))
        return (
            f"{self.value.size} thresholds from {low:.6g} to {high:.6g} kg/s ({methods}, relative error {worst})"
        )

    def __repr__(self) -> str:
        return f"Threshold: {self}"

    def _repr_html_(self) -> str:
        value, method = np.atleast_1d(self.value), np.atleast_1d(self.method)
        error = np.broadcast_to(np.inf if self.error is None else self.error, value.shape)
        rows = [
            ["..."] * 4
            if place is None
            else [
                ", ".join(map(str, place)),
                f"{value[place]:.10g}",
                str(method[place]),
                _accuracy(error[place]),
            ]
            for place in markup.shortened(list(np.ndindex(value.shape)))
        ]
        header = ["scene", "c in kg/s", "method", "relative error"]
        start = 0 if np.ndim(self.value) else 1
        return markup.table(header[start:], [row[start:] for row in rows], caption="pure-slip damping")


def _accuracy(error: float | None) -> str:
    return "unknown" if error is None or not np.isfinite(error) else f"{error:.0e}"


def pure_slip_damping(
    law: FrictionLaw,
    *,
    V: ArrayLike,
    N: ArrayLike,
    m: ArrayLike | None = None,
    k: ArrayLike | None = None,
    method: str = "auto",
    rtol: float = 1e-3,
    time_limit: float | None = None,
) -> Threshold:
    """Return the pure-slip damping coefficient of a law in a scene.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    V, N : float or array_like
        Belt speed in m/s and normal force in N. All four quantities broadcast.
    m, k : float or array_like, optional
        Mass in kg and stiffness in N/m. Without them the error of an average of slopes is not known, unless
        mu is a straight line, which all methods treat exactly.
    method : {"auto", "equilibrium", "least_squares", "harmonic", "second_order", "orbit", "simulation"}
        "auto" gives the cheapest rung whose error is known to be at most `rtol`, and climbs no further than is
        needed to know it. Without m and k it gives "harmonic", the limit of weak friction.
    rtol : float
        Relative error that is good enough, 1e-13 to 1; for "simulation" by name at most 1e-3.
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
    lookup("method", method, dict.fromkeys(METHODS))
    rtol = read_rtol(rtol) if method == "simulation" else read_rtol(rtol, most=1.0)
    scenes = Scenes.of(law, V=V, N=N, m=m, k=k)
    if scenes.m is None and method in ("second_order", "orbit", "simulation"):
        raise InputError(f'method="{method}" needs the mass m and the stiffness k')
    law.function("numpy")  # refuses a law with parameters that have no value
    if len(scenes):
        warn_where_negative(law, float(scenes.V.max()))
    with deadline.time_limit(time_limit):
        value, names, error = _found(scenes, method, rtol)
    names = np.array(names.tolist(), dtype=str)
    if scenes.shape != ():
        columns = (column if column is None else column.reshape(scenes.shape) for column in (value, names, error))
        return Threshold(*columns)
    known = error is not None and np.isfinite(error[0])
    return Threshold(float(value[0]), str(names[0]), float(error[0]) if known else None)


def _found(scenes: Scenes, method: str, rtol: float) -> tuple[Any, Any, Any]:
    deadline.check_time()
    if scenes.m is None:
        return _without_oscillator(scenes, method)
    if method == "auto":
        return _climb(scenes, rtol)
    value, error = _named(scenes, method, rtol)
    return value, np.full(len(scenes), method), error


def _without_oscillator(scenes: Scenes, method: str) -> tuple[Any, Any, Any]:
    """Return what can be said without m and k."""
    reason = obstacle(scenes.law, scenes.V)
    straight = reason is None and not scenes.law.slope_expr.has(symbols.v)
    if method == "auto":
        method = "equilibrium" if straight else "harmonic"
        value = numerical_averages(scenes)[method] if reason is None else average(scenes, method)
    else:
        value = average(scenes, method)
    names = np.full(len(scenes), method)
    return value, names, np.full(len(scenes), _ROUNDING) if straight else None


def _named(scenes: Scenes, method: str, rtol: float) -> tuple[Any, Any]:
    """Return the value of one rung, and its error."""
    if method == "simulation":
        return simulated(scenes, rtol)
    reason = obstacle(scenes.law, scenes.V)
    if method in AVERAGES:
        value, resolution = average(scenes, method), 0.0
    elif reason is not None:
        raise InputError(f'method="{method}" needs a law that is smooth: {reason}; try method="simulation"')
    elif method == "second_order":
        value, resolution, _ = second_order(scenes)
        _require(scenes, resolution <= rtol, f"1024 phases do not resolve the slope of mu to {rtol:g}", resolution)
    else:
        value, error, reason = on_orbit(scenes, rtol)
        _require(scenes, error <= max(rtol, _REACHABLE), str(reason), error)
        return value, error
    reference, doubt, _ = _best(scenes, _REFERENCE, reason is None)
    return value, _distance(value, reference) + doubt + resolution


def _best(scenes: Scenes, rtol: float, smooth: bool) -> tuple[Any, Any, Any]:
    """Return the best value known of each scene, its error, infinite where there is none, and the method."""
    value, error = np.zeros(len(scenes)), np.full(len(scenes), np.inf)
    names = np.full(len(scenes), "orbit", dtype=object)
    if smooth:
        value, error, _ = on_orbit(scenes, rtol)
    for row in np.flatnonzero(~(error <= max(rtol, _GOOD))):
        try:
            (simulation,), (doubt,) = simulated(scenes.rows([row]), max(rtol, _GOOD))
        except OutOfTime:
            raise
        except StickSlipError:
            continue
        if doubt < error[row]:
            value[row], error[row], names[row] = simulation, doubt, "simulation"
    return value, error, names


def _climb(scenes: Scenes, rtol: float) -> tuple[Any, Any, Any]:
    """Return for each scene the cheapest rung that is known to be good enough."""
    chosen = _Choice(len(scenes), rtol)
    if obstacle(scenes.law, scenes.V) is None:
        rungs = numerical_averages(scenes)
        second, resolution, next_order = second_order(scenes)
        doubt = next_order + resolution + _ROUNDING
        chosen.settle(np.arange(len(scenes)), rungs, second, doubt)
        rungs["second_order"] = second
        if (rows := chosen.open).size:
            try:
                value, error, _ = on_orbit(scenes.rows(rows), rtol / 10)
            except OutOfTime as stop:
                raise OutOfTime(_so_far(stop, scenes, rows[0], second, doubt)) from None
            chosen.settle(rows, rungs | {"orbit": value}, value, error)
    else:
        rungs = {name: average(scenes, name) for name in AVERAGES}
    for row in chosen.open:
        _settle_by_simulation(scenes, row, rungs, chosen)
    return chosen.value, chosen.method, chosen.error


def _so_far(stop: OutOfTime, scenes: Scenes, row: int, value: Any, error: Any) -> str:
    """Say what is known of the first scene that is not settled."""
    best = f"{value[row]:.10g} kg/s, relative error {_accuracy(error[row])}"
    return f"{stop}; the best value found for {scenes.label(row)} is {best}"


def _settle_by_simulation(scenes: Scenes, row: int, rungs: dict[str, Any], chosen: "_Choice") -> None:
    """Choose a rung for one scene by tighter and tighter simulations: a kink costs the integrator its order."""
    for part in _TIGHTER:
        try:
            value, error = simulated(scenes.rows([row]), min(max(chosen.rtol * part, 1e-13), _LOOSEST))
        except NotConverged as failure:
            reason = str(failure)
            continue
        chosen.settle(np.array([row]), rungs | {"simulation": value}, value, error)
        if row not in chosen.open:
            return
        reason = f"the threshold is known to {error[0]:.1e} relative only"
    raise NotConverged(
        f"rtol = {chosen.rtol:g} is not reached for {scenes.label(row)}: {reason}; try another rtol"
    )


class _Choice:
    """The rungs chosen so far."""

    def __init__(self, count: int, rtol: float) -> None:
        self.rtol = rtol
        self.value, self.error = np.zeros(count), np.full(count, np.inf)
        self.method = np.full(count, "", dtype=object)  # texts of one width would cut longer ones

    @property
    def open(self) -> Any:
        """Scenes without a rung."""
        return np.flatnonzero(self.method == "")

    def settle(self, rows: Any, rungs: dict[str, Any], reference: Any, doubt: Any) -> None:
        """Choose the first rung close enough to a reference that is itself in doubt by `doubt`.

        Columns of rungs belong to all scenes, or like the reference to `rows` only.
        """
        for name, column in rungs.items():
            value = column if len(column) == len(rows) else column[rows]
            error = _distance(value, reference) + doubt
            fits = (self.method[rows] == "") & (error <= self.rtol)
            self.value[rows[fits]], self.error[rows[fits]] = value[fits], error[fits]
            self.method[rows[fits]] = name


def _distance(value: Any, reference: Any) -> Any:
    """Return the relative difference, infinite where one of the two is no number."""
    with np.errstate(all="ignore"):
        difference = np.where(value == reference, 0.0, np.abs(value - reference) / np.abs(reference))
    return np.where(np.isnan(difference), np.inf, difference)


def _require(scenes: Scenes, good: Any, reason: str, error: Any) -> None:
    """Refuse what has not the accuracy that was asked for."""
    bad = np.flatnonzero(~np.asarray(good))
    if bad.size:
        row = int(bad[0])
        reached = f"the error is {error[row]:.1e}" if np.isfinite(error[row]) else "there is no value"
        raise NotConverged(f'{reached} for {scenes.label(row)}: {reason}; try method="simulation"')
