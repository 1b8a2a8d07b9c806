"""`pure_slip_damping`: the damping that separates stick-slip from slip, by the cheapest method good enough."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core import deadline, symbols
from stickslip_sym.core.aliases import FloatArray, ObjectArray
from stickslip_sym.core.numbers import read_rtol
from stickslip_sym.criteria.criterion import Criterion, equilibrium, harmonic
from stickslip_sym.model.doubts import warn_where_negative
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.orbits.orbit import obstacle
from stickslip_sym.motion.thresholds import rungs
from stickslip_sym.motion.thresholds.climb import accuracy, by_name, climb
from stickslip_sym.motion.thresholds.rungs import Rung
from stickslip_sym.motion.thresholds.scenes import Scenes
from stickslip_sym.output import markup

if TYPE_CHECKING:
    from stickslip_sym.criteria.enclosure import Enclosure
    from stickslip_sym.motion.thresholds.theorem import Theorem

__all__ = ["Threshold", "pure_slip_damping"]


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
    """

    value: Any
    method: Any
    error: Any
    theorems: "tuple[Theorem, ...]" = ()

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
    V: ArrayLike,
    N: ArrayLike,
    m: ArrayLike | None = None,
    k: ArrayLike | None = None,
    method: str | Criterion | Rung = "auto",
    rtol: float = 1e-3,
    time_limit: float | None = None,
) -> Threshold:
    """Return the pure-slip damping coefficient of a law in a scene.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    V, N : float or array_like
        Belt speed in m/s and normal force in N. All four quantities broadcast. One number may be text, which
        "proof" takes exactly: "9.81" is 9.81, and 9.81 the nearest binary number.
    m, k : float or array_like, optional
        Mass in kg and stiffness in N/m. Without them the error of an average of slopes is not known, unless
        mu is a straight line, which all methods treat exactly.
    method : str, Criterion or Rung
        "auto" gives the cheapest rung whose error is known to be at most `rtol`, and climbs no further than is
        needed to know it. Without m and k it gives "harmonic", the limit of weak friction. Otherwise a rung: by
        name "equilibrium", "least_squares", "harmonic", "second_order", "orbit" or "simulation", or the average
        by a criterion of one's own. "proof" encloses the threshold, with every error bounded.
    rtol : float
        Relative error that is good enough, 1e-13 to 1; for "simulation" at most 1e-3; for "proof" 1e-40 to 1e-3.
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
    rtol = read_rtol(rtol, least=best, most=worst)
    scenes = Scenes.of(law, V=V, N=N, m=m, k=k)
    if rung is not None:
        rung.require_oscillator(scenes.m)
    law.function("numpy")  # refuses a law with parameters that have no value
    if len(scenes):
        warn_where_negative(law, float(scenes.V.max()))
    with deadline.time_limit(time_limit):
        value, names, error, theorems = _found(scenes, rung, rtol)
    value = value + 0.0  # -0.0 becomes 0.0
    names = np.array(names.tolist(), dtype=str)
    if scenes.shape != ():
        error = None if error is None else error.reshape(scenes.shape)
        return Threshold(value.reshape(scenes.shape), names.reshape(scenes.shape), error, theorems)
    known = float(error[0]) if error is not None and np.isfinite(error[0]) else None
    return Threshold(float(value[0]), str(names[0]), known, theorems)


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
