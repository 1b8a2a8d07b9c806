"""`critical`: every value of one quantity or parameter at which a given damping is just the pure-slip damping.

An average that is a polynomial in the quantity gives all values as its roots. Otherwise threshold minus c is
followed on a grid, to every change of sign, and to every extremum that comes close to one. Its sign is that of
the gap between both halves of the grazing orbit at c (`needed`): it takes one gap, and a threshold some. Where a
half creeps to rest, or is driven away, the sign is known too.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import pairwise
from typing import Any, NoReturn

import numpy as np
import sympy as sp

from stickslip_sym.core import deadline, symbols
from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import NO_RESULT, InputError, NotConverged
from stickslip_sym.core.numbers import lookup, read_array, read_rtol, real
from stickslip_sym.core.units import in_si
from stickslip_sym.criteria.criterion import Criterion, harmonic
from stickslip_sym.criteria.enclosure import Enclosure
from stickslip_sym.criteria.rule import slope_average
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.orbits.needed import ROUNDING, SIGNS, sure_gap
from stickslip_sym.motion.orbits.orbit import obstacle
from stickslip_sym.motion.roots import closest, sign_changes
from stickslip_sym.motion.slip import Dimensionless
from stickslip_sym.motion.steps import TIGHT
from stickslip_sym.motion.thresholds.averages import average, slope_mean
from stickslip_sym.motion.thresholds.boxes import ExactPoint, Transit, transit
from stickslip_sym.motion.thresholds.methods import Method, accuracy, ask, find_method, methods
from stickslip_sym.motion.thresholds.operating_points import OperatingPoints, of_oscillator
from stickslip_sym.motion.thresholds.theorem import Search, checked_hypotheses
from stickslip_sym.motion.thresholds.threshold import pure_slip_damping
from stickslip_sym.output import markup

_PER_DECADE = 8  # values sampled
_WHOLE = (1e-12, 1e12)  # of a quantity in SI units, that is sampled
_STRENGTHS = (1e-3, 1e2)  # N/(V sqrt(k m)) between which V, N, m and k are sought
_AROUND = 100.0  # factor above and below a parameter's value within which it is sought
_NEAR = 0.5  # relative distance of a harmonic average from c, within which a quantity is sought in any case
_FINER = 1e-3  # of rtol, the relative error of a threshold at a root
_FLAT = math.sqrt(SIGNS)  # relative, whose square is nothing: distance of an extremum or an edge, step of Newton's


@dataclass(frozen=True)
class Critical:
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
        With "proof": two values, at one of which the slip from P returns to the belt's speed and at the other not.
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

    def _repr_html_(self) -> str:
        return markup.block(f"critical value: {self}")


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
    method: str | Criterion | Method = "auto",
    rtol: float = 1e-3,
    within: Sequence[float | str] | None = None,
    time_limit: float | None = None,
) -> tuple[Critical, ...]:
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
        Two values of one sign between which to look at 8 points a decade, or more, ascending: all the points.
        If not given, a parameter is sought from 1/100 of its value to 100 times it, and V, N, m and k where
        N/(V sqrt(k m)) is 1e-3 to 100, or the harmonic average comes close to c. Two values closer together than
        points are found if these show the extremum between them, and may otherwise be missed. One at which an
        average jumps past c counts too, as the equilibrium's does where V is at a kink of mu.
        An average that is linear or a polynomial needs no range: all values are found, by their polynomial.
    time_limit : float, optional
        Seconds of computation after which it is given up.

    Returns
    -------
    tuple of Critical
        Empty where there is none.

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
        numbers = of_oscillator(osc, numbers, [name for name in values if name != of])
    missing = [name for name in ("c", "V", "N") if name not in (of, *numbers)]
    if missing and of != "c":
        raise InputError(f"{' and '.join(missing)} must be given to find {of}: {missing[0]}=...")
    rtol = read_rtol(rtol, least=TIGHT, most=1.0)
    with deadline.time_limit(time_limit):
        if of == "c":
            one = pure_slip_damping(law, **numbers, method=method, rtol=rtol)
            return (
                Critical("c", one.value, "kg/s", one.method, one.relative_error, one.sensitivity, one.enclosure),
            )
        unit = (law.parameters[of].unit or "") if of in law.parameters else None
        if isinstance(within, list | tuple):
            within = [real(of, in_si(value, of, unit)) if isinstance(value, str) else value for value in within]
        return _Search(law, of, numbers, find_method(method), rtol).found(_places(within))


def excess(points: OperatingPoints, c: float, method: Method | None) -> float:
    """Return a number with the sign of threshold minus c at one operating point; NaN where there is none.

    An average, or a method that does not converge, has a threshold of its own. For the others it is the gap of the
    grazing orbit, cut at -1 and 1: infinite, with its sign, where a half does not come to w = 1.
    """
    deadline.check_time()
    try:
        if method is not None and method.criterion is not None:
            given = points.law, method.criterion, points.V
            mean = float(slope_mean(*given)[0])  # it has no value where a slope overflows, as with huge exponents
            return float(points.N[0]) * (float(average(*given)[0]) if math.isnan(mean) else mean) - c
        if method is not None and not method.converges:
            return float(ask(points, method, SIGNS)[0].value[0]) - c
        system = Dimensionless.of(points.law, points.oscillator(0, c))
    except NO_RESULT:
        return math.nan
    gap = sure_gap(system.rise, system.eta, system.zeta, system.push(1), 1.0, SIGNS)
    deadline.check_time()
    return math.nan if gap.outside and math.isfinite(system.w_max) else min(max(float(gap.value), -1.0), 1.0)


def _places(within: Sequence[float | str] | None) -> FloatArray | None:
    """Read at which places a value is sought; None where that is not said."""
    if within is None:
        return None
    places: FloatArray = np.asarray(read_array("within", within), dtype=np.float64)
    ascending = places.ndim == 1 and places.size > 1 and (np.diff(places) > 0).all()
    if not ascending or (places.size == 2 and places.prod() <= 0):
        raise InputError(f"within = {within} must be two numbers of one sign, ascending")
    return places if places.size > 2 else _spaced(*places)


class _Search:
    """The search for the roots of threshold minus c along one quantity or parameter.

    - `values`: the others of c, V, N, m and k.
    """

    def __init__(
        self, law: FrictionLaw, of: str, values: Mapping[str, float], method: Method | None, rtol: float
    ) -> None:
        self.law, self.of, self.rtol, self.c = law, of, rtol, values["c"]
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

    def at(self, x: float | str | FloatArray) -> OperatingPoints:
        """Return the operating point for a value of what is sought, or points for several of a quantity."""
        if self.is_quantity:
            return OperatingPoints.of(self.law, **self.quantities, **{self.of: x})
        return OperatingPoints.of(self.law.bind(**{self.of: x}), **self.quantities)

    @property
    def _usual(self) -> float:
        """The value that a parameter has, or typically has; 0 where neither is known."""
        return float(self.law.values.get(self.of, self.law.parameters[self.of].typical or 0))

    def found(self, within: FloatArray | None) -> tuple[Critical, ...]:
        """Return the critical values, ascending."""
        roots = None if self.criterion is None else self._polynomial_roots(self.criterion)
        if roots is not None:
            low, high = (-math.inf, math.inf) if within is None else (within[0], within[-1])
            roots = [x for x in roots if low <= x <= high]
        elif self.criterion is not None and self.of in ("m", "k"):
            raise InputError(
                f'an average of slopes does not depend on {self.of}; give m and k, and try method="orbit"'
            )
        else:
            roots = self._roots(self._grid() if within is None else within)
        results = sorted(map(self._result, roots), key=lambda one: one.value)
        return tuple(map(self._proved, results)) if self.proof else tuple(results)

    # -- where to look -----------------------------------------------------------------------------

    def _grid(self) -> FloatArray:
        """Return the values at which the excess is sampled, ascending.

        Of a quantity all for an average, else where friction is neither weak nor very strong, and where the
        harmonic average, the limit for weak friction, comes close to c.
        """
        if not self.is_quantity:
            if not self._usual:
                raise InputError(f"where to look for {self.of} is not known; give within=(low, high)")
            return _spaced(*sorted((self._usual / _AROUND, self._usual * _AROUND)))
        low, high = _WHOLE
        if self.of == "V" and self.law.v_max is not None:
            high = float(self.law.v_max) / 2  # motions slip at 2 V, and more
        x = _spaced(low, high)
        if self.criterion is not None:
            return x
        points = self.at(x)
        if not points.N.any():
            raise InputError(f"without a normal force nothing depends on {self.of}")
        eta = points.strength / points.V
        with np.errstate(all="ignore"):
            mean, error, _ = slope_average(self.law, points.V, criterion=harmonic)
            off = points.N * mean - self.c
            near = np.abs(off) <= _NEAR * (np.abs(off + self.c) + abs(self.c)) + points.N * error
        near[:-1] |= np.sign(off[:-1]) != np.sign(off[1:])
        near = np.convolve(near & np.isfinite(off) & (self.of in "VN"), np.ones(5), "same") > 0
        if self.of == "V" and near.any() and obstacle(self.law, math.inf) is None:
            return x[near]  # far from there the average of a smooth law has the threshold's sign
        return x[near | ((eta >= _STRENGTHS[0]) & (eta <= _STRENGTHS[1]))]

    # -- roots -------------------------------------------------------------------------------------

    def _roots(self, x: FloatArray) -> list[float]:
        """Return where the excess changes its sign, up to where motions leave the measured speeds."""

        def value(x: float) -> float:
            return excess(self.at(x), self.c, self.method)

        def value_or_refusal(x: float) -> float:
            found = value(x)
            return found if not math.isnan(found) else self._no_threshold(x)

        with np.errstate(all="ignore"):
            nodes = {place: value(place) for place in x.tolist()}
            for ends in pairwise(x.tolist()):
                inside, outside = sorted(ends, key=lambda x: math.isnan(nodes[x]))
                width = _FLAT * max(map(abs, ends)) if math.isnan(nodes[outside]) else math.inf
                while abs(outside - inside) > width and not math.isnan(nodes[inside]):
                    middle = (inside + outside) / 2
                    nodes[middle] = value(middle)
                    inside, outside = (inside, middle) if math.isnan(nodes[middle]) else (middle, outside)
        nodes = {x: nodes[x] for x in sorted(nodes) if not math.isnan(nodes[x])}
        if x.size and not nodes:
            raise NotConverged(f"there is no threshold at any {self.of}; try another method")
        for low, middle, high in list(zip(nodes, [*nodes][1:], [*nodes][2:], strict=False)):
            before, here, after = nodes[low], nodes[middle], nodes[high]
            if before * here > 0 < here * after and abs(here) < min(abs(before), abs(after)):
                sign = math.copysign(1.0, here)
                place, beyond = closest(value, low, high, sign, _FLAT * max(abs(low), abs(high)))
                if sign * beyond < 0:
                    nodes[place] = beyond
        places = sorted(nodes)
        return list(sign_changes(value_or_refusal, places, [nodes[x] for x in places], SIGNS))

    def _no_threshold(self, x: float) -> NoReturn:
        raise NotConverged(f"there is no threshold at {self.of} = {x:.6g}; try another method")

    def _polynomial_roots(self, criterion: Criterion) -> list[float] | None:
        """Return the roots of an average that is a polynomial in what is sought, or None."""
        law, N, V = self.law, self.quantities.get("N", 1.0), np.array([self.quantities.get("V", 1.0)])
        coefficients: Any
        if self.of == "N":
            coefficients = [0.0, float(average(law, criterion, V)[0])]
        elif self.of == "V" and law.expr.is_polynomial(symbols.v):
            # mu = sum of g_n v^n gives c = -N sum of n g_n <(1 + s)^(n-1)> V^(n-1).
            terms = sp.Poly(sp.diff(law.expr, symbols.v), symbols.v).all_coeffs()[::-1]
            coefficients = [-N * law.number(g) * float(criterion.mean_power(n)) for n, g in enumerate(terms)]
        elif self.of in law.parameters and law.expr.is_polynomial(symbol := law.parameters[self.of].symbol):
            degree = max(0, sp.degree(law.slope_expr, symbol))  # that of 0 is minus infinity
            places = np.linspace(0.0, self._usual or 1.0, int(degree) + 1)
            means = [N * average(law.bind(**{self.of: x}), criterion, V)[0] for x in places.tolist()]
            coefficients = np.linalg.solve(np.vander(places, increasing=True), means)
        else:
            return None
        coefficients[0] -= self.c
        polynomial = np.polynomial.Polynomial(coefficients).trim()
        roots: Any = polynomial.roots() if polynomial.degree() else np.empty(0)
        positive = self.is_quantity or law.parameters[self.of].positive
        return [float(x.real) for x in roots if x.imag == 0 and (x.real > 0 or not positive)]

    # -- results -----------------------------------------------------------------------------------

    def _result(self, x: float) -> Critical:
        """Return a root by a step of Newton's method from one close to it; its error is that of the threshold."""
        points = self.at(x)
        computed, names = ask(points, self.method, max(_FINER * self.rtol, TIGHT))
        value = float(computed.value[0])
        if not names[0] or math.isnan(value):
            self._no_threshold(x)
        method = self.method or methods()[names[0]]
        by = {"c": -1.0} | {name: float(one[0]) for name, one in method.sensitivity(points).items()}
        own = by.pop(self.of)
        with np.errstate(all="ignore"):
            sensitivity = {name: float(np.divide(-change, own)) for name, change in by.items()}
        step = -sensitivity["c"] * (value - self.c)
        small = abs(step) < _FLAT * abs(x)
        error = None
        if self.criterion is None:
            off = float((computed.relative_error * points.error_base(computed.value))[0])
            error = (abs(sensitivity["c"]) * off + step**2 / abs(x)) / abs(x) + ROUNDING
            error += 0.0 if small else abs(step / x)
            if not error <= self.rtol:
                raise NotConverged(
                    f"{self.of} = {x:.6g} is known to {error:.1e} relative only, not to rtol = {self.rtol:g}; "
                    "try another rtol"
                )
        return Critical(self.of, x + step if small else x, self.unit, method.name, error, sensitivity)

    def _proved(self, one: Critical) -> Critical:
        """Enclose a value: where the threshold grows with it, the slip returns above it, so minus it is sought."""
        sign = -1 if one.sensitivity["c"] > 0 else 1

        def decision(x: Fraction, bits: int) -> Transit:
            points = self.at(str(sign * x))
            point = ExactPoint(points.law, **points.exact_row(0))
            checked_hypotheses(point)
            return transit(point, Fraction(self.c), bits)

        found = Search(decision, self.of).around(sign * one.value, one.relative_error or self.rtol, self.rtol)
        enclosure = found if sign > 0 else Enclosure(-found.high, -found.low)
        middle = float(enclosure)
        error = float(enclosure.radius) / abs(middle)
        return replace(one, value=middle, method="proof", relative_error=error, enclosure=enclosure)


def _spaced(low: float, high: float) -> FloatArray:
    return np.geomspace(low, high, max(3, math.ceil(abs(math.log10(high / low)) * _PER_DECADE) + 1))
