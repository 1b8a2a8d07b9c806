"""`critical`: every value of one quantity or parameter at which a given damping is just the pure-slip damping.

An average that is a polynomial in the quantity gives all values as its roots. Otherwise the threshold becomes a
resolved function of the quantity, and what passes c is sought where that does. There the sign of threshold minus c
is that of the mismatch between both halves of the grazing orbit at c (`search_damping_ratio`): that takes one
mismatch, a threshold some.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property, lru_cache, partial
from itertools import compress, groupby, pairwise
from operator import not_
from typing import Any, NamedTuple

import numpy as np
import sympy as sp
from scipy.optimize import brentq

from stickslip_sym.core import deadline, symbols
from stickslip_sym.core.aliases import BoolArray, Expr, FloatArray
from stickslip_sym.core.errors import NO_RESULT, InputError, NotConverged
from stickslip_sym.core.names import lookup
from stickslip_sym.core.numbers import LEAST_RTOL, ROUNDING, SAME, read_array, read_rtol, real
from stickslip_sym.core.quantity import QuantityResult
from stickslip_sym.core.remedies import Argument
from stickslip_sym.core.units import si_number
from stickslip_sym.criteria.criterion import Criterion, harmonic
from stickslip_sym.criteria.enclosure import Enclosure
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.kernel.slip_data import TIGHT, SlipEnd
from stickslip_sym.motion.orbits.damping import OF_ORBITS, quick_speeds
from stickslip_sym.motion.orbits.needed import SIGNS, orbit_damping_ratio, velocity_mismatch_at
from stickslip_sym.motion.slip import NondimensionalOscillator
from stickslip_sym.motion.thresholds.averages import fast_average, resolved_gauss_average
from stickslip_sym.motion.thresholds.boxes import ExactPoint, Transit, transit
from stickslip_sym.motion.thresholds.methods import (
    THRESHOLDS_TO_COMPILE,
    Method,
    MethodName,
    accuracy,
    evaluate,
    find_method,
    methods,
)
from stickslip_sym.motion.thresholds.operating_points import VANISHING, OperatingPoints, oscillator_quantities
from stickslip_sym.motion.thresholds.theorem import Search, checked_hypotheses
from stickslip_sym.motion.thresholds.threshold import Threshold, pure_slip_damping
from stickslip_sym.numerics.known import Column, Unknown, attempted
from stickslip_sym.numerics.resolved import ERRORS_OF_CLEAR_SIGN, NODES, Resolved, Root, Sampled, nodes, resolve
from stickslip_sym.numerics.subdivide import MOST_INTERVALS, joined
from stickslip_sym.output.content import content
from stickslip_sym.output.data import DataResult, TableResult, columns_of
from stickslip_sym.output.shown import Shown

_FASTEST_BELT = 1e12  # m/s, belt speed up to which one is sought, and down to one over that
_STRONGEST = 10.0  # N <|mu'|>/sqrt(k m), or static excess over V sqrt(k m), up to which N, m and k are sought
_AROUND = 100.0  # factor above and below a parameter's value within which it is sought, and of a first interval
_WITHIN = Argument("within", ("low", "high"))
_DIGITS_OF_KEY = round(-math.log10(SAME))  # of N/(V sqrt(k m)), by which one value is known from others
_ROUGH_RTOL = math.sqrt(OF_ORBITS)  # of a threshold in a sketch: half of the digits
_NONE = Unknown("there is no threshold")
_ROOT_RTOL_RATIO = 1e-3  # of rtol, the relative error of a threshold at a root
_FLAT = math.sqrt(SIGNS)  # relative, whose square is nothing: distance of an extremum or an edge, step of Newton's


@dataclass(frozen=True, eq=False)
class Critical(Shown, QuantityResult, DataResult):
    """A value of one quantity or parameter at which the given damping is just the pure-slip damping.

    Attributes
    ----------
    of : str
        Which one.
    value : float
        In SI units.
    unit : str or None
    method : str
    relative_error : float or None
        Estimated error, relative; with "proof" a bound; None where nothing is known of it.
    sensitivity : mapping of str to float
        How the value changes with c and with everything else, by name.
    enclosure : Enclosure or None
        With "proof": two values, at one of which the slip that follows stick returns to
        the belt's speed and at the other not.
    """

    reported = ("value", "unit", "method", "relative_error", "sensitivity")

    of: str
    value: float
    unit: str | None
    method: str
    relative_error: float | None
    sensitivity: Mapping[str, float] = field(repr=False)
    enclosure: Enclosure | None = None

    def __str__(self) -> str:
        unit = "" if self.unit in (None, "1") else f" {self.unit}"
        proof = "" if self.enclosure is None else ", PROVED"
        error = accuracy(self.relative_error)
        return f"{self.of} = {self.value:.10g}{unit} ({self.method}, relative error {error}{proof})"

    def __repr__(self) -> str:
        return f"Critical: {self}"


class CriticalValues(tuple[Critical, ...], TableResult):
    """All critical values of one quantity or parameter, ascending, and where they were looked for.

    Attributes
    ----------
    of : str
    unit : str or None
    looked : tuple of float
        Between which values; from 0 to infinity where an average is a polynomial, of which all roots are found.
    unresolved : tuple of (float, float)
        Intervals in it in which more values may lie, or in which there is no threshold.
    """

    of: str
    unit: str | None
    looked: tuple[float, float]
    unresolved: tuple[tuple[float, float], ...]

    def __new__(
        cls, values: Iterable[Critical], of: str, unit: str | None, looked: tuple[float, float],
        unresolved: tuple[tuple[float, float], ...] = (),
    ) -> CriticalValues:  # fmt: skip
        """Make the values a tuple."""
        made = super().__new__(cls, values)
        made.of = of
        made.unit = unit
        made.looked = looked
        made.unresolved = unresolved
        return made

    def __getnewargs__(self) -> tuple[Any, ...]:
        """Return what makes it again, for copies and other processes."""
        return tuple(self), self.of, self.unit, self.looked, self.unresolved

    @property
    def range(self) -> str:
        """Between which values they were looked for, as a sentence."""
        low, high = self.looked
        unit = "" if self.unit in (None, "1") else f" {self.unit}"
        if (low, high) in ((0.0, math.inf), (-math.inf, math.inf)):
            text = f"every {'positive ' if low == 0 else ''}value of {self.of} was looked at"
        else:
            text = f"{self.of} was looked at from {low:.6g} to {high:.6g}{unit}"
        gaps = ", ".join(f"{a:.6g} to {b:.6g}{unit}" for a, b in self.unresolved)
        if gaps:
            return f"{text}; not decided, or without a threshold: {gaps}"
        return text

    def to_dict(self) -> dict[str, Any]:
        """Return the values, and where they were looked for, as ``--json`` prints them."""
        said = {"of": self.of, "values": list(self), "looked": self.looked, "unresolved": self.unresolved}
        return {name: content(part) for name, part in said.items()}

    def _table_columns(self) -> dict[str, list[Any]]:
        return columns_of(self, "of", "value", "unit", "method", "relative_error")

    def __str__(self) -> str:
        values = [str(critical) for critical in self] or [f"there is no such value of {self.of}"]
        return "\n".join([*values, self.range])


def critical(
    law: FrictionLaw | str,
    of: str,
    osc: Oscillator | None = None,
    /,
    *,
    c: float | None = None,
    V: float | None = None,
    N: float | None = None,
    m: float | None = None,
    k: float | None = None,
    method: MethodName | Criterion | Method = "auto",
    rtol: float = 1e-3,
    within: Sequence[float | str] | None = None,
    time_limit: float | None = None,
) -> CriticalValues:
    """Return every value of one quantity or parameter at which the pure-slip damping is c, ascending.

    Parameters
    ----------
    law : FrictionLaw
        With all other parameters bound.
    of : str
        "V", "N", "m", "k", "c", or a parameter of the law; if the parameter has a value, it is sought around that.
    osc : Oscillator, optional
        Holds c, V, N, m and k, but for that which is sought.
    c, V, N, m, k : float, optional
        The others, in SI units. Without m and k averages of slopes only.
    method : str, Criterion or Method
        As for `pure_slip_damping`: "auto" takes for each value the cheapest method that knows its own error to be
        within `rtol`; without m and k "harmonic". "proof" encloses each value between two of which it is proved
        that stick-slip is there at one and not at the other; that there are no more such values it does not prove.
    rtol : float
        Relative error that is good enough, 1e-12 to 1; the width of a proved enclosure.
    within : sequence of float or str, optional
        Two values of one sign between which to look, or more, ascending, where thresholds may have kinks.
        If not given, a parameter is sought from 1/100 of its value to 100 times it, V from 1e-12 to 1e12 m/s
        as far as N <|mu'|>/sqrt(k m) is at most 10, and N, m and k where that is from 1e-8 to 10. The
        result says between which values it looked, and which are not decided: the threshold is resolved by
        polynomials between its values until what they leave out cannot hide a root. A value at which an average
        jumps past c counts too, as the equilibrium's does where V is at a kink of mu.
        An average that is linear or a polynomial needs no range: all values are found, by their polynomial.
    time_limit : float, optional
        Seconds of computation after which it is given up.

    Returns
    -------
    CriticalValues
        A tuple of `Critical`, empty where there is none.

    Raises
    ------
    InputError
        For an unknown name or method, numbers that are missing or unusable, or an average that does not depend on
        m and k.
    NotConverged
        If a method does not reach `rtol`, or a proof does not succeed.
    OutOfTime
        When the time limit is reached.

    Examples
    --------
    >>> from stickslip_sym import critical, laws
    >>> (force,) = critical(laws.exponential.typical(), "N", c=2.0, V=0.5, method="equilibrium")
    >>> f"{force.value:.6f} {force.unit}"
    '9.959309 N'
    """
    law = as_law(law)
    values = {"V": V, "N": N, "m": m, "k": k, "c": c}
    lookup("quantity or parameter", of, {**values, **law.parameters})
    numbers = {name: real(name, value) for name, value in values.items() if value is not None}
    if of in numbers:
        raise InputError(f"{of} is sought; leave its value out")
    if osc is not None:
        numbers = oscillator_quantities(osc, numbers, [name for name in values if name != of])
    missing = [name for name in ("c", "V", "N") if name not in (of, *numbers)]
    if missing and of != "c":
        raise InputError(f"{' and '.join(missing)} must be given to find {of}: ", Argument(missing[0]))
    rtol = read_rtol(rtol, least=TIGHT, most=1.0)
    with deadline.time_limit(time_limit):
        if of == "c":
            return critical_damping(pure_slip_damping(law, **numbers, method=method, rtol=rtol))
        if of in law.parameters:
            unit = law.parameters[of].unit or ""
        else:
            unit = None
        if isinstance(within, list | tuple):
            within = [
                real(of, si_number(value, of, unit)) if isinstance(value, str) else value for value in within
            ]
        return _Search(law, of, numbers, find_method(method), rtol).found(_read_places(within))


def critical_damping(threshold: Threshold[float]) -> CriticalValues:
    """Return the critical value of c, the threshold itself."""
    value = Critical(
        "c", threshold.value, "kg/s", threshold.method, threshold.relative_error, threshold.sensitivity,
        threshold.enclosure,
    )  # fmt: skip
    return CriticalValues([value], "c", "kg/s", (-math.inf, math.inf))


def excess(points: OperatingPoints, c: float, method: Method | None) -> float | Unknown:
    """Return a number with the sign of threshold minus c at one operating point, or why none is known.

    An average, or a method that does not converge, has a threshold of its own. For the others it is the mismatch
    of the grazing orbit, cut at -1 and 1: infinite, with its sign, where a half does not come to w = 1. It is 0
    where rounding hides its sign.
    """
    deadline.check_time()
    try:
        if method is not None and method.criterion is not None:
            return _known_number(float(_damping_of_average(points, method.criterion)[0]) - c)
        if method is not None and not method.converges:
            return _known_number(float(evaluate(points, method, SIGNS)[0].value[0]) - c)
        system = NondimensionalOscillator.of(points.bound, points.oscillator(0, c))
    except NO_RESULT as error:
        return Unknown(*error.args)
    mismatch = velocity_mismatch_at(system, 1.0, rtol=SIGNS)
    if mismatch.leaves and math.isfinite(system.w_max):
        return Unknown(*system.unmeasured(system.w_max).args)
    if math.isnan(mismatch.value):
        return Unknown("the halves of the grazing orbit take too many steps")
    is_sure = math.isinf(mismatch.value) or abs(mismatch.value) > mismatch.rounding
    if is_sure:
        return min(max(float(mismatch.value), -1.0), 1.0)
    return 0.0


def _damping_of_average(points: OperatingPoints, criterion: Criterion) -> FloatArray:
    """Return the thresholds that an average gives."""
    value = points.N * resolved_gauss_average(points.law.kinetic, criterion, points.V)
    lost = np.isnan(value)  # as where a slope overflows, with huge exponents
    if lost.any():
        some = points.rows(lost)
        value[lost] = some.N * fast_average(some.law, criterion, some.V)
    return value


def _known_number(value: float) -> float | Unknown:
    return Unknown("slopes of mu are no numbers there, or overflow") if math.isnan(value) else value


def _read_places(within: Sequence[float | str] | None) -> FloatArray | None:
    """Read at which places a value is sought; None where that is not said."""
    if within is None:
        return None
    places: FloatArray = np.asarray(read_array("within", within), dtype=np.float64)
    ascending = places.ndim == 1 and places.size > 1 and (np.diff(places) > 0).all()
    if not ascending or (places.size == 2 and places.prod() <= 0):
        raise InputError(f"within = {within} must be two numbers of one sign, ascending")
    return places


class _QuickSpeeds(NamedTuple):
    """Slip speeds in m/s near which a law varies quickly, ascending, and two that thresholds come from.

    - `reached`: the highest slip speed of the orbit that grazes, and the belt speed.
    """

    speeds: tuple[float, ...]
    reached: tuple[float, float]

    @property
    def met(self) -> tuple[int, int]:
        """How many are lower than either."""
        return bisect_left(self.speeds, self.reached[0]), bisect_left(self.speeds, self.reached[1])

    def distance(self, side: int, i: int) -> float:
        """Return the logarithm of one of them over what it is compared with; 1 where there are fewer."""
        if i >= len(self.speeds):
            return 1.0
        ratio = self.speeds[i] / self.reached[side]
        return math.log(ratio) if ratio > 0 else -1.0


class _Scale(NamedTuple):
    """The argument by which a quantity is varied: its logarithm, where all its values have one sign.

    - `sign`: that of all values; 0 where they have none in common, and the argument is the quantity itself.
    """

    low: float
    high: float
    sign: float

    @classmethod
    def of(cls, edges: FloatArray) -> _Scale:
        low = float(edges[0])
        high = float(edges[-1])
        sign = 0.0
        if low > 0:
            sign = 1.0
        elif high < 0:
            sign = -1.0
        return cls(low, high, sign)

    def argument(self, x: float) -> float:
        if self.sign:
            return self.sign * math.log(self.sign * x)
        return x

    def values(self, u: FloatArray) -> FloatArray:
        if self.sign:
            u = self.sign * np.exp(self.sign * u)
        return np.clip(u, self.low, self.high)

    def value(self, u: float) -> float:
        return float(self.values(np.asarray(u)))


class _Search:
    """The search for the roots of threshold minus c along one quantity or parameter.

    Where it can it is made of the logarithm: thresholds are smooth functions of that.

    - `values`: the others of c, V, N, m and k.
    """

    def __init__(
        self, law: FrictionLaw, of: str, values: Mapping[str, float], method: Method | None, rtol: float
    ) -> None:
        self.law = law
        self.of = of
        self.rtol = rtol
        self.c = values["c"]
        self.quantities: dict[str, Any] = {name: value for name, value in values.items() if name != "c"}
        given = {"m", "k"} <= self.quantities.keys() | {of}
        if method is not None:
            method.check(law, values.get("V", math.inf), given)
        elif not given:
            method = find_method(harmonic)
        self.proof = method is not None and method.name == "proof"
        self.method = methods()["simulation"] if self.proof else method
        self.criterion = None if self.method is None else self.method.criterion
        self.is_quantity = of in symbols.QUANTITIES
        self.unit = symbols.QUANTITIES[of].unit if self.is_quantity else law.parameters[of].unit
        self.converges = self.criterion is None and (self.method is None or self.method.converges)
        self.ratios = dict[float, tuple[float, float]]()
        self.work = 0.0  # of thresholds by slips so far, in that of one where friction is weak
        self.sampled = dict[float, tuple[float, float]]()
        self.sketched = dict[float, tuple[float, float]]()

    def at(self, x: float | str | FloatArray) -> OperatingPoints:
        """Return the operating point for a value of what is sought, or points for several of a quantity."""
        if self.is_quantity:
            return OperatingPoints.of(self.law, **self.quantities, **{self.of: x})
        return OperatingPoints.of(self.law.bind(**{self.of: x}), **self.quantities)

    @cached_property
    def similarity(self) -> tuple[Expr, Expr] | None:
        """The factors of the slip speed and of mu' that hold the parameter that is sought; None if more holds it.

        Slip depends on mu only by how it changes with speed: such a parameter acts as the belt's speed and the
        normal force do.
        """
        if self.law.static is not None or not self.law.values.get(self.of):
            return None
        symbol = self.law.parameters[self.of].symbol
        for speed in (sp.S.One, symbol, 1 / symbol):
            slope = self.law.slope_expr.subs(symbols.v, symbols.v / speed)
            _, factor = slope.as_independent(symbol, as_Add=False)
            if not factor.has(symbols.v) and self.law.number(factor):
                return speed, factor
        return None

    @cached_property
    def is_idle(self) -> bool:
        """Whether mu' does not hold the parameter that is sought: it only shifts mu, and moves no threshold."""
        if self.is_quantity or self.similarity is None:
            return False
        return not self.law.slope_expr.has(self.law.parameters[self.of].symbol)

    def _ratios(self, x: float) -> tuple[float, float]:
        """Return by what a value multiplies the belt's speed and the normal force; 0 where that is not known."""
        if self.similarity is None:
            return 0.0, 0.0
        if x not in self.ratios:
            law = self.law.bind(**{self.of: x})
            speed, force = (law.number(factor) / self.law.number(factor) for factor in self.similarity)
            self.ratios[x] = speed, force
        return self.ratios[x]

    def _kin(self, x: float) -> float:
        """Return an infinity that all values have whose thresholds one law has; a value that has its own law."""
        if self.is_quantity:
            return math.inf
        speed, force = self._ratios(x)
        return math.copysign(math.inf, force) if speed > 0 and force else x

    def _alike(self, x: float | FloatArray) -> OperatingPoints:
        """Return operating points of one law with the thresholds of those for a value, or values of one kin."""
        if self.is_quantity:
            return self.at(x)
        places = np.ravel(x).tolist()
        if math.isfinite(self._kin(places[0])):
            return self.at(places[0])
        law = self.law
        speed, force = np.transpose([self._ratios(place) for place in places])
        if force[0] < 0:
            like = np.abs(np.log(-force)).argmin()  # the law that is most like it but for the sign
            law = law.bind(**{self.of: places[like]})
            speed, force = speed / speed[like], force / force[like]
        similar = {"V": self.quantities["V"] * speed, "N": self.quantities["N"] * force}
        return OperatingPoints.of(law, **self.quantities | similar)

    @property
    def _usual(self) -> float:
        """The value that a parameter has, or typically has; 0 where neither is known."""
        return float(self.law.values.get(self.of, self.law.parameters[self.of].typical or 0))

    def found(self, within: FloatArray | None) -> CriticalValues:
        """Return the critical values, ascending."""
        roots = None if self.criterion is None else self._polynomial_roots(self.criterion)
        unresolved = list[tuple[float, float]]()
        if roots is not None:
            looked = 0.0 if self.is_quantity else -math.inf, math.inf
            if within is not None:
                looked = float(within[0]), float(within[-1])
            results = [self._result(x) for x in roots if looked[0] <= x <= looked[1]]
        elif self.criterion is not None and self.of in ("m", "k"):
            raise InputError(
                f"an average of slopes does not depend on {self.of}; give m and k, and try ",
                Argument("method", "orbit"),
            )
        else:
            with np.errstate(all="ignore"):
                edges = np.asarray(self._edges() if within is None else within)
                looked = float(edges[0]), float(edges[-1])
                results, unresolved = self._resolved_roots(edges)
        results.sort(key=lambda result: result.value)
        values = map(self._proved, results) if self.proof else results
        return CriticalValues(values, self.of, self.unit, looked, tuple(unresolved))

    # -- thresholds --------------------------------------------------------------------------------

    def thresholds(self, x: FloatArray, *, sketch: bool) -> tuple[FloatArray, FloatArray]:
        """Return thresholds and their errors in kg/s, NaN where there is none.

        - `sketch`: whether a small part of their distance from c is a small enough error.
        """
        known = self.sketched if sketch else self.sampled
        if self.is_idle:
            x = np.full_like(x, self._usual)
        new = set(x.tolist()) - known.keys()
        for _, kin in groupby(sorted(new, key=self._kin), self._kin):
            places = list(kin)
            found = self._thresholds(np.array(places), sketch)
            known.update(zip(places, zip(*found, strict=True), strict=True))
        columns = np.array([known[place] for place in x.tolist()]).reshape(-1, 2)
        return columns[:, 0], columns[:, 1]

    def _thresholds(self, x: float | FloatArray, sketch: bool) -> tuple[FloatArray, FloatArray]:
        deadline.check_time()
        none: FloatArray = np.full(np.size(x), np.nan)
        try:
            points = self._alike(x)
            if self.criterion is not None:
                return _damping_of_average(points, self.criterion), SAME * points.slope_scale
            if self.method is not None and not self.method.converges:
                value = evaluate(points, self.method, SIGNS)[0].value
                return value, SAME * points.slope_scale
            value = none.copy()
            error = np.full(len(points), np.inf)
            if sketch and len(points) > 1 and points.obstacle is None:
                computed, _ = evaluate(points, methods()["second_order"], OF_ORBITS)
                value = computed.value
                error = computed.relative_error * points.error_base(computed.value)
            # Of a polynomial through values whose signs are clear the sign is to be clear too.
            far = ~(ERRORS_OF_CLEAR_SIGN**2 * error <= np.abs(value - self.c))
            rows = np.flatnonzero(far).tolist()
            for row in rows:
                value[row], error[row] = self._by_slip(points, row, sketch, len(rows))
        except NO_RESULT:
            if np.size(x) == 1:
                return none, none
            columns = np.array([self._thresholds(place, sketch) for place in np.ravel(x).tolist()])
            return columns[:, 0, 0], columns[:, 1, 0]
        return value, error

    def _by_slip(self, points: OperatingPoints, row: int, sketch: bool, count: int) -> tuple[float, float]:
        """Return a threshold, the first of some, by the slip from P."""
        system = NondimensionalOscillator.of(points.bound, points.oscillator(row))
        unit = 2 * float(points.impedance[row])
        self.work += 1 + float(points.slope_scale[row] / points.impedance[row])
        fast = self.work + count > THRESHOLDS_TO_COMPILE
        if sketch:
            alike = replace(system, eta=float(f"{system.eta:.{_DIGITS_OF_KEY}g}"))
            ratio = attempted(_rough_ratio, alike, fast)
            if isinstance(ratio, Unknown):
                return math.nan, math.nan
            zeta, error = ratio
        else:
            zeta, error = orbit_damping_ratio(system, rtol=OF_ORBITS, fast=fast)
        return zeta * unit, error * unit

    # -- where to look -----------------------------------------------------------------------------

    def _edges(self) -> list[float]:
        """Return arguments between which thresholds are resolved: the range that is looked at, and kinks in it."""
        if not self.is_quantity:
            if not self._usual:
                raise InputError(f"where to look for {self.of} is not known; give ", _WITHIN)
            return sorted(self._usual * factor for factor in (1 / _AROUND, 1.0, _AROUND))
        if self.of == "V":
            table = self.law.bound.table
            end = table.reach
            if len(table.pieces) > MOST_INTERVALS:  # as of a law that varies for ever
                end = float(table.pieces[MOST_INTERVALS, 0])
            whole = 1 / _FASTEST_BELT, min(_FASTEST_BELT, end / 2)  # slip reaches 2 V, and more
            speeds = np.geomspace(*whole, NODES * len(_spaced(*whole)))
            strong = [0, *np.flatnonzero(self._strong(speeds)) + 1, speeds.size + 1]
            first = int(np.diff(strong).argmax())  # of the widest range in which friction is nowhere too strong
            weak = speeds[strong[first] : strong[first + 1] - 1]
            if weak.size < 2:
                raise NotConverged(f"friction is too strong at every {self.of}; give ", _WITHIN)
            return _spaced(float(weak[0]), float(weak[-1]))
        unit = self.at(1.0)
        excess = float((unit.strength / unit.V)[0]) * (self.law.bound.static - self.law.bound.onset)
        slopes = float((unit.slope_scale / unit.impedance)[0])
        if not max(slopes, excess):
            raise InputError(f"without a normal force, or a slope of mu, nothing depends on {self.of}")
        ends = VANISHING / max(slopes, excess), _STRONGEST / (slopes or excess)
        if self.of == "N":
            return _spaced(*ends)
        return _spaced(*(end**-2 for end in ends[::-1]))

    def _strong(self, speeds: FloatArray) -> BoolArray:
        """Return at which belt speeds thresholds are not looked for, since they take long."""
        points = self.at(speeds)
        if not points.has_oscillator:
            return np.zeros(len(points), dtype=bool)
        return np.asarray(points.slope_scale / points.impedance > _STRONGEST)

    # -- roots -------------------------------------------------------------------------------------

    def _resolved_roots(self, edges: FloatArray) -> tuple[list[Critical], list[tuple[float, float]]]:
        """Return the values at which thresholds pass c, and the intervals in which that is not decided."""
        scale = _Scale.of(edges)

        def column(u: FloatArray, *, sketch: bool) -> Column:
            value, error = self.thresholds(scale.values(u), sketch=sketch)
            return Column.of(value - self.c, error, _NONE)

        value = partial(column, sketch=False)
        sketch = partial(column, sketch=True)

        arguments = sorted({scale.argument(x) for x in edges.tolist()})
        parts, missing = self._stretches(sketch, self._parted(arguments, scale))
        if not parts:
            raise NotConverged(f"there is no threshold at any {self.of}; try another method")
        most = MOST_INTERVALS
        first: Sampled = sketch
        if not self.converges:
            most *= NODES
            first = value  # averages have no digits to save, and take no time
        resolved = [resolve(value, part, rtol=OF_ORBITS, most=most, sketch=first) for part in parts]
        self._refuse_constant()

        results = list[Critical]()
        undecided = [(part[0], part[-1]) for part in missing]
        for stretch in resolved:
            undecided += stretch.open_at(0.0)
            undecided += _touching(stretch)
            for root in stretch.roots():
                result = self._at_root(root, scale)
                if result is None:
                    undecided.append((root.low, root.high))
                else:
                    results.append(result)
        return results, [(scale.value(low), scale.value(high)) for low, high in joined(undecided)]

    def _refuse_constant(self) -> None:
        """Refuse thresholds that are c everywhere, within their errors."""
        if not self.sampled:
            return
        values, errors = np.array(list(self.sampled.values())).T
        if (np.abs(values - self.c) <= errors).all():
            raise NotConverged(f"the threshold is c, within its error, whatever {self.of} is")

    def _at_root(self, root: Root, scale: _Scale) -> Critical | None:
        """Return the critical value at a root of polynomials through thresholds; None if it is not confirmed."""
        x = scale.value(root.x)
        width = min(abs(scale.value(end) - x) for end in (root.low, root.high))
        result = self._confirmed(x, width)
        if result is not None:
            return result

        def off(u: float) -> float:
            x = scale.value(u)
            gap = excess(self.at(x), self.c, self.method)
            if isinstance(gap, Unknown):
                raise NotConverged(f"there is no threshold at {self.of} = {x:.6g}: ", *gap.reason)
            return min(max(gap, -1.0), 1.0)

        polished = _polished(off, root)
        if polished is None:
            return None
        return self._result(scale.value(polished))

    def _confirmed(self, x: float, width: float) -> Critical | None:
        """Return the root beside one of a polynomial, if the slip from P returns on one side of it only.

        - `width`: how far it is to where the threshold turns.
        """
        if not self.converges:
            return None
        try:
            result = self._result(x, width)
            if abs(result.value - x) >= width:
                return None
            beside = ERRORS_OF_CLEAR_SIGN * (result.relative_error or 0.0) * abs(result.value)
            beside = min(max(beside, _FLAT * abs(result.value)), width)
            below = excess(self.at(result.value - beside), self.c, self.method)
            above = excess(self.at(result.value + beside), self.c, self.method)
        except NO_RESULT:
            return None
        if isinstance(below, Unknown) or isinstance(above, Unknown):
            return None
        return result if below * above < 0 else None

    # -- where the law varies quickly --------------------------------------------------------------

    def _parted(self, arguments: list[float], scale: _Scale) -> list[float]:
        """Part a range where the slip speeds of the orbit that grazes come to one near which mu varies quickly.

        Thresholds may turn, jump, or begin anew there as a power of the distance.

        - `arguments`: ascending; they part the range already.
        """
        u = nodes(np.array(arguments[:-1]), np.array(arguments[1:])).ravel()
        seen = [self._quick(scale.value(one)) for one in u.tolist()]
        edges = set(arguments)
        for (low, before), (high, after) in pairwise(zip(u.tolist(), seen, strict=True)):
            if len(before.speeds) != len(after.speeds):
                continue  # one came or went: the law itself changes there
            for side in (0, 1):  # the highest slip speed, and the belt's
                for i in range(*sorted((before.met[side], after.met[side]))):

                    def off(u: float, side: int = side, i: int = i) -> float:
                        return self._quick(scale.value(u)).distance(side, i)

                    if before.distance(side, i) * after.distance(side, i) < 0:
                        edges.add(float(brentq(off, low, high, xtol=LEAST_RTOL * max(abs(low), abs(high)))))
        return sorted(edges)

    def _quick(self, x: float) -> _QuickSpeeds:
        """Return near which slip speeds mu varies quickly, beside those of the orbit that grazes."""
        with suppress(*NO_RESULT):
            points = self._alike(x)
            V = float(points.V[0])
            law = self.law if math.isinf(self._kin(x)) else points.law
            if speeds := quick_speeds(law.bound.table, math.inf if self.of == "V" else V):
                return _QuickSpeeds(tuple(speeds), (self._highest(points), V))
        return _QuickSpeeds((), (1.0, 1.0))

    def _highest(self, points: OperatingPoints) -> float:
        """Return the highest slip speed of the orbit that grazes, in m/s: twice the belt's for averages."""
        if not self.converges:
            return 2 * float(points.V[0])
        system = NondimensionalOscillator.of(points.bound, points.oscillator(0))
        zeta, _ = orbit_damping_ratio(system, rtol=OF_ORBITS)
        slip = replace(system, zeta=zeta).slip(0.0, 0.0, until=SlipEnd.MAXIMUM, rtol=TIGHT)
        return math.inf if slip.end is SlipEnd.OUTSIDE else system.V * slip.u_most

    # -- stretches with thresholds -----------------------------------------------------------------

    def _stretches(self, value: Sampled, arguments: list[float]) -> list[list[list[float]]]:
        """Part a range where thresholds end, as where motions leave measured speeds: parts with and without.

        - `arguments`: ascending; they part the range further.
        """
        low = np.array(arguments[:-1])
        high = np.array(arguments[1:])
        u = nodes(low, high).ravel()
        missing = ~value(u).known
        ends = [arguments[0]]
        for i in np.flatnonzero(missing[:-1] != missing[1:]).tolist():
            inside, outside = u[i : i + 2]
            if missing[i]:
                inside, outside = outside, inside
            while abs(outside - inside) > self.rtol * max(1.0, abs(inside)):
                middle = (inside + outside) / 2
                if value(np.array([middle])).known[0]:
                    inside = middle
                else:
                    outside = middle
            ends += sorted((float(inside), float(outside)))
        ends.append(arguments[-1])
        parts = [[a, *(x for x in arguments if a < x < b), b] for a, b in pairwise(ends) if a < b]
        # Every second part is the narrow one in which thresholds begin or end.
        there = [i % 4 == (2 if missing[0] else 0) for i in range(len(parts))]
        return [list(compress(parts, kind)) for kind in (there, map(not_, there))]

    def _polynomial_roots(self, criterion: Criterion) -> list[float] | None:
        """Return the roots of an average that is a polynomial in what is sought, or None."""
        law = self.law
        N = self.quantities.get("N", 1.0)
        V = np.array([self.quantities.get("V", 1.0)])
        coefficients: Any
        if self.of == "N":
            coefficients = [0.0, float(fast_average(law, criterion, V)[0])]
        elif self.of == "V" and law.expr.is_polynomial(symbols.v):
            # mu = sum of g_n v^n gives c = -N sum of n g_n <(1 + s)^(n-1)> V^(n-1).
            terms = sp.Poly(sp.diff(law.expr, symbols.v), symbols.v).all_coeffs()[::-1]
            coefficients = [
                -N * law.kinetic.number(g) * float(criterion.mean_power(n)) for n, g in enumerate(terms)
            ]
        elif self.of in law.parameters and law.expr.is_polynomial(symbol := law.parameters[self.of].symbol):
            degree = max(0, sp.degree(law.slope_expr, symbol))  # that of 0 is minus infinity
            places = np.linspace(0.0, self._usual or 1.0, int(degree) + 1)
            means = [N * fast_average(law.bind(**{self.of: x}), criterion, V)[0] for x in places.tolist()]
            coefficients = np.linalg.solve(np.vander(places, increasing=True), means)
        else:
            return None
        coefficients[0] -= self.c
        polynomial = np.polynomial.Polynomial(coefficients).trim()
        roots: Any = polynomial.roots() if polynomial.degree() else np.empty(0)
        positive = self.is_quantity or law.parameters[self.of].positive
        return [float(x.real) for x in roots if x.imag == 0 and (x.real > 0 or not positive)]

    # -- results -----------------------------------------------------------------------------------

    def _result(self, x: float, width: float = 0.0) -> Critical:
        """Return a root by Newton's method from one close to it; its error is that of the threshold.

        - `width`: how far it is to where the threshold turns.
        """
        for rtol in (_ROOT_RTOL_RATIO * self.rtol, TIGHT, TIGHT):
            result = self._newton(x, max(rtol, TIGHT), width)
            moved = abs(result.value - x) / (min(width, abs(x)) or abs(x))  # and the sensitivities are those at x
            x, error = result.value, result.relative_error or 0.0  # None of what is defined, not approximated
            if error <= _ROOT_RTOL_RATIO * self.rtol and moved <= self.rtol:
                return result
        if error <= self.rtol:
            return result
        raise NotConverged(
            f"{self.of} = {x:.6g} is known to {error:.1e} relative only, "
            f"not to rtol = {self.rtol:g}; try another rtol"
        )

    def _newton(self, x: float, rtol: float, width: float) -> Critical:
        """Return a root by a step of Newton's method, from a threshold within a tolerance."""
        points = self.at(x)
        computed, names = evaluate(points, self.method, rtol)
        value = float(computed.value[0])
        if not names[0] or math.isnan(value):
            raise NotConverged(f"there is no threshold at {self.of} = {x:.6g}; try another method")
        method = self.method or methods()[names[0]]
        by = {"c": -1.0} | {name: float(change[0]) for name, change in method.sensitivity(points).items()}
        own = by.pop(self.of)
        with np.errstate(all="ignore"):
            sensitivity = {name: float(np.divide(-change, own)) for name, change in by.items()}
        step = -sensitivity["c"] * (value - self.c)
        # Where it turns at a distance d, a smooth threshold has the curvature 1/d over its slope.
        size = abs(x)
        error = None
        farthest = _FLAT * size
        if self.criterion is None:
            off = float((computed.relative_error * points.error_base(computed.value))[0])
            curved = step**2 / (min(width, size) or size)
            error = (abs(sensitivity["c"]) * off + curved) / size + ROUNDING
            farthest = size / 2
        return Critical(
            self.of, x + step if abs(step) < farthest else x, self.unit, method.name, error, sensitivity
        )

    def _proved(self, value: Critical) -> Critical:
        """Enclose a value: where the threshold grows with it, the slip returns above it, so minus it is sought."""
        sign = -1 if value.sensitivity["c"] > 0 else 1

        def decision(x: Fraction, bits: int) -> Transit:
            points = self.at(str(sign * x))
            point = ExactPoint(points.law, **points.exact_row(0))
            checked_hypotheses(point)
            return transit(point, Fraction(self.c), bits)

        enclosure = Search(decision, self.of).around(
            sign * value.value, value.relative_error or self.rtol, self.rtol
        )
        if sign < 0:
            enclosure = Enclosure(-enclosure.high, -enclosure.low)
        middle = float(enclosure)
        error = float(enclosure.radius) / abs(middle)
        return replace(value, value=middle, method="proof", relative_error=error, enclosure=enclosure)


@lru_cache(maxsize=256)  # m and k are one search: the ratio depends on them by their product
def _rough_ratio(system: NondimensionalOscillator, fast: bool) -> tuple[float, float]:
    """Return the damping ratio that the slip from P needs, and its error, for a sketch."""
    return orbit_damping_ratio(system, rtol=_ROUGH_RTOL, fast=fast)


def _polished(function: Callable[[float], float], root: Root) -> float | None:
    """Return where a function changes its sign about a root, up to where it turns; None if it does not."""
    x = root.x
    step = _FLAT * max(1.0, abs(x))
    if root.low == root.high:
        if function(x - step) * function(x + step) < 0:
            return x
        return None
    for width in (step, math.inf):
        low = max(root.low, x - width)
        high = min(root.high, x + width)
        below = function(low)
        above = function(high)
        if below != above and below * above <= 0:
            return float(brentq(function, low, high, xtol=SIGNS * max(1.0, abs(x))))
    return None


def _touching(function: Resolved) -> list[tuple[float, float]]:
    """Return the intervals in which a function turns within its errors from 0, and may come to it twice."""
    turns = [turn.x for turn in function.turns[1:-1] if abs(turn.value) <= turn.error]
    return [
        (piece.low, piece.high) for piece in function.pieces if any(piece.low <= x <= piece.high for x in turns)
    ]


def _spaced(low: float, high: float) -> list[float]:
    count = max(1, round(math.log(high / low, _AROUND)))
    return [float(x) for x in np.geomspace(low, high, count + 1)]
