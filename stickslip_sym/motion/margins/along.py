"""The search along one quantity or parameter for the values at which a given damping is the threshold.

An average that is a polynomial in the quantity gives all values as its roots. Otherwise the threshold is computed
on a grid, and every change of sign of threshold minus c, and every extremum that comes close to one, is followed.
"""

import math
from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import Any

import numpy as np
import sympy as sp
from scipy.optimize import brentq, minimize_scalar

from stickslip_sym.core import deadline, symbols
from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import InputError, NotConverged, NoThreshold
from stickslip_sym.core.numbers import real
from stickslip_sym.criteria.criterion import Criterion, harmonic
from stickslip_sym.criteria.enclosure import Enclosure
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.margins.value import Critical
from stickslip_sym.motion.orbits.orbit import obstacle
from stickslip_sym.motion.thresholds.averages import slope_mean
from stickslip_sym.motion.thresholds.boxes import ExactPoint, Transit, transit
from stickslip_sym.motion.thresholds.methods import Computed, Method, best_of, find_method, methods
from stickslip_sym.motion.thresholds.operating_points import OperatingPoints
from stickslip_sym.motion.thresholds.theorem import Search, checked_hypotheses

__all__ = ["Along"]

_PER_DECADE = 8  # values sampled
_SPEEDS = (1e-12, 1e12)  # belt speeds in m/s that are sampled by averages
_AROUND = 100.0  # factor above and below a parameter's value within which it is sought
_WEAKEST, _STRONGEST = 1e-3, 1e2  # N/(V sqrt(k m)) between which V, N, m and k are sought
_NEAR = 0.5  # relative distance of the threshold from c, within which a crossing between two samples is looked for
_SHARE = 0.4  # of the last measured speed, up to which belt speeds are sought: motions slip at a little over 2 V
_LOOSE = 1e-3  # relative error of a threshold on the grid
_FINER = 1e-3  # of rtol, the relative error of a threshold at a root
_TIGHTEST = 1e-12  # relative error of a threshold at a root
_CLOSE = 1e-9  # tolerance of the logarithm of a root, which a Newton step with the exact slope then refines
_BESIDE = 1e-4  # relative distance at which an absolute error is taken where the threshold is 0
_NEWTON = 1e-6  # relative size of that step, up to which it is taken
_ROUNDING = float(4 * np.finfo(np.float64).eps)  # relative, of a root
_DIGITS = 20  # of the coefficients of a polynomial law
_HALVINGS = 8  # bisections of an interval of the grid, for the last value at which mu is known at all speeds


class Along:
    """The search for the roots of threshold minus c along one quantity or parameter.

    Parameters
    ----------
    law : FrictionLaw
        With all other parameters bound.
    of : str
        V, N, m, k or a parameter of the law.
    values : mapping of str to float
        The others of c, V, N, m and k.
    within : (float, float) or None
        Where to look.
    """

    def __init__(
        self, law: FrictionLaw, of: str, values: Mapping[str, float], within: tuple[float, float] | None
    ) -> None:
        self.law, self.of, self.within = law, of, within
        self.quantities: dict[str, Any] = dict(values)
        self.c = self.quantities.pop("c")
        oscillator = {"m", "k"} & (self.quantities.keys() | {of})
        if len(oscillator) == 1:
            raise InputError("give both the mass m and the stiffness k, or neither")
        self.has_oscillator = bool(oscillator)

    @property
    def unit(self) -> str | None:
        """The unit of what is sought; None if it is not known."""
        if self.of in symbols.QUANTITIES:
            return symbols.QUANTITIES[self.of].unit
        return self.law.parameters[self.of].unit

    def at(self, x: float | str | FloatArray) -> OperatingPoints:
        """Return the operating point for a value of what is sought, or points for several of a quantity."""
        if self.of in symbols.QUANTITIES:
            return OperatingPoints.of(self.law, **self.quantities, **{self.of: x})
        return OperatingPoints.of(self.law.bind(**{self.of: x}), **self.quantities)

    def found(self, method: Method | None, rtol: float) -> tuple[Critical, ...]:
        """Return the critical values by a method; None stands for "auto"."""
        if method is None and not self.has_oscillator:
            method = find_method(harmonic)
        if method is not None and method.criterion is not None:
            roots = self._polynomial_roots(method.criterion)
            if roots is not None:
                return tuple(self._result(x, method, rtol) for x in roots)
            if self.of in ("m", "k"):
                raise InputError(f'an average of slopes does not depend on {self.of}; try method="orbit"')
        proof = method is not None and method.name == "proof"
        if proof:
            method = methods()["simulation"]
        results = sorted(self._crossings(method, rtol), key=lambda one: one.value)
        return tuple(self._proved(one, rtol) for one in results) if proof else tuple(results)

    # -- values ------------------------------------------------------------------------------------

    def excess(self, method: Method | None, x: FloatArray, rtol: float) -> FloatArray:
        """Return threshold minus c at values of what is sought; NaN where there is none."""
        if self.of in symbols.QUANTITIES:
            return self._excess(method, self.at(x), rtol)
        return np.concatenate([self._excess(method, self.at(float(value)), rtol) for value in x])

    def _excess(self, method: Method | None, points: OperatingPoints, rtol: float) -> FloatArray:
        found, _ = self._computed(method, points, rtol)
        value = np.where(np.isfinite(found.relative_error), found.value, np.nan)
        for row, refusal in found.refusals.items():
            if isinstance(refusal, NoThreshold):
                value[row] = -1.0 - abs(self.c)  # below 0, by an unknown amount
        excess: FloatArray = value - self.c
        return excess

    def _computed(
        self, method: Method | None, points: OperatingPoints, rtol: float
    ) -> tuple[Computed, Method | None]:
        """Return what a method says, and the method that said it of the first point."""
        deadline.check_time()
        if method is None:
            found, names = best_of(points, rtol)
            return found, methods().get(str(names[0])) if len(names) else None
        if method.criterion is None:
            return method.compute(points, min(max(rtol, method.tightest), method.loosest)), method
        # By Gauss rules: no closed form is made for every value of a parameter.
        value = points.N * slope_mean(points.law, method.criterion, points.V)
        return Computed(value, np.zeros(len(points))), method

    # -- where to look -----------------------------------------------------------------------------

    def _grid(self, method: Method | None) -> FloatArray:
        """Return the values at which the threshold is sampled, ascending in size, of one sign."""
        if self.within is not None:
            low, high = (real("within", end) for end in self.within)
            if not (low * high > 0 and low < high):
                raise InputError(f"within = ({low:g}, {high:g}) must be two numbers of one sign, ascending")
        elif self.of == "V":
            return self._speeds(method)
        elif self.of in symbols.QUANTITIES:
            low, high = self._by_friction()
        else:
            parameter = self.law.parameters[self.of]
            value = self.law.values.get(self.of, parameter.typical)
            if value is None or float(value) == 0:
                raise InputError(f"where to look for {self.of} is not known; give within=(low, high)")
            low, high = sorted(float(value) * factor for factor in (1 / _AROUND, _AROUND))
        return math.copysign(1.0, low) * _spaced(*sorted((abs(low), abs(high))))

    def _speeds(self, method: Method | None) -> FloatArray:
        """Return belt speeds: all for an average, else where friction is neither weak nor very strong.

        And where the harmonic average comes close to c, the limit for weak friction.
        """
        low, high = _SPEEDS
        if self.law.v_max is not None:
            high = _SHARE * float(self.law.v_max)
        V = _spaced(low, high)
        if method is not None and method.criterion is not None:
            return V
        impedance = math.sqrt(self.quantities["m"]) * math.sqrt(self.quantities["k"])
        eta = self.quantities["N"] / (impedance * V)
        with np.errstate(all="ignore"):
            off = self.quantities["N"] * slope_mean(self.law, harmonic, V) - self.c
            near = np.abs(off) <= _NEAR * (np.abs(off + self.c) + abs(self.c))
            near[:-1] |= np.sign(off[:-1]) != np.sign(off[1:])
        near = np.convolve(near & np.isfinite(off), np.ones(5), "same") > 0
        if obstacle(self.law, np.inf) is not None or not near.any():
            near |= (eta >= _WEAKEST) & (eta <= _STRONGEST)
        return V[near]

    def _by_friction(self) -> tuple[float, float]:
        if self.of == "N":
            impedance = math.sqrt(self.quantities["k"] * self.quantities["m"])
            least, most = (ratio * self.quantities["V"] * impedance for ratio in (_WEAKEST, _STRONGEST))
            (slope,) = slope_mean(self.law, harmonic, np.array([self.quantities["V"]]))
            if slope * self.c > 0:  # weak friction: the threshold is nearly N times this
                least = min(least, self.c / slope / 10)
            return least, most
        other = self.quantities["m" if self.of == "k" else "k"]
        if self.quantities["N"] == 0:
            raise InputError(f"without a normal force nothing depends on {self.of}")
        low, high = (
            (self.quantities["N"] / (self.quantities["V"] * ratio)) ** 2 / other
            for ratio in (_STRONGEST, _WEAKEST)
        )
        return low, high

    # -- roots -------------------------------------------------------------------------------------

    def _crossings(self, method: Method | None, rtol: float) -> Iterator[Critical]:
        """Yield the values at which the excess changes sign, up to where motions leave the measured speeds."""
        x = self._grid(method)
        asked = x.size
        with np.errstate(all="ignore"):
            off = self.excess(method, x, _LOOSE)
        known = np.isfinite(off)
        if self.law.v_max is not None:
            edges = np.array(list(self._edges(method, x, known)))
            x, off = np.append(x[known], edges), np.append(off[known], self.excess(method, edges, _LOOSE))
            order = np.argsort(np.abs(x))
            x, off = x[order], off[order]
        else:
            x, off = x[known], off[known]
        if asked and not x.size:
            raise NotConverged(f"there is no threshold at any {self.of}; try another method")
        for low, high in self._brackets(method, x, off):
            yield self._root(low, high, method, rtol)
        # A zero beside zeros is a threshold too small for double precision, not one that changes sign.
        padded = np.concatenate(([0.0], off, [0.0]))
        crossed = (off == 0) & (padded[:-2] != 0) & (padded[2:] != 0)
        for value in x[crossed].tolist():
            yield self._result(value, method, rtol)

    def _edges(self, method: Method | None, x: FloatArray, known: Any) -> Iterator[float]:
        """Yield the last values at which motions stay within the measured speeds."""
        for i in np.flatnonzero(known[1:] != known[:-1]):
            inside, outside = (x[i], x[i + 1]) if known[i] else (x[i + 1], x[i])
            for _ in range(_HALVINGS):
                middle = math.copysign(math.sqrt(inside * outside), inside)
                if np.isfinite(self.excess(method, np.array([middle]), _LOOSE)[0]):
                    inside = middle
                else:
                    outside = middle
            yield inside

    def _brackets(self, method: Method | None, x: FloatArray, off: FloatArray) -> Iterator[tuple[float, float]]:
        """Yield pairs of values between which the excess changes its sign, also between two samples."""
        for i in np.flatnonzero(np.sign(off[:-1]) * np.sign(off[1:]) < 0).tolist():
            yield x[i], x[i + 1]
        size = np.abs(off)
        close = size <= _NEAR * (np.abs(off + self.c) + abs(self.c))
        side = math.copysign(1.0, x[0]) if x.size else 1.0
        for i in range(1, x.size - 1):
            lone = close[i] and size[i] < min(size[i - 1], size[i + 1])
            if not (lone and off[i - 1] * off[i] > 0 < off[i] * off[i + 1]):
                continue
            sign = float(np.sign(off[i]))

            def height(y: float, sign: float = sign) -> float:
                return float(sign * self.excess(method, np.array([side * math.exp(y)]), _LOOSE * 1e-3)[0])

            ends = math.log(abs(x[i - 1])), math.log(abs(x[i + 1]))
            dip = minimize_scalar(height, bounds=ends, method="bounded")
            if dip.fun < 0:
                turn = side * math.exp(dip.x)
                yield x[i - 1], turn
                yield turn, x[i + 1]

    def _root(self, low: float, high: float, method: Method | None, rtol: float) -> Critical:
        side = math.copysign(1.0, low)
        name = "auto" if method is None else method.name

        def excess(logarithm: float) -> float:
            x = side * math.exp(logarithm)
            value = float(self.excess(method, np.array([x]), _tight(rtol))[0])
            if math.isnan(value):
                raise NotConverged(f"there is no {name} threshold at {self.of} = {x:g}")
            return value

        ends = math.log(abs(low)), math.log(abs(high))
        if excess(ends[0]) * excess(ends[1]) > 0:
            raise NotConverged(f"{name} does not see the change between {self.of} = {low:g} and {high:g}")
        return self._result(side * math.exp(brentq(excess, *ends, xtol=_CLOSE, rtol=_ROUNDING)), method, rtol)

    def _polynomial_roots(self, criterion: Criterion) -> list[float] | None:
        """Return the roots of an average that is a polynomial in what is sought, or None."""
        N, V = float(self.quantities.get("N", 1.0)), np.array([self.quantities.get("V", 1.0)])
        if self.of == "N":
            coefficients = [-self.c, float(slope_mean(self.law, criterion, V)[0])]
        elif self.of == "V":
            if not self.law.expr.is_polynomial(symbols.v):
                return None
            terms = sp.Poly(self.law.expr, symbols.v).all_coeffs()[::-1]
            values = {self.law.parameters[name].symbol: value for name, value in self.law.values.items()}
            # mu = sum of g_n v^n gives c = -N sum of n g_n <(1 + s)^(n-1)> V^(n-1).
            coefficients = [
                -N * n * float(g.evalf(_DIGITS, subs=values)) * float(criterion.mean_power(n - 1))
                for n, g in enumerate(terms)
                if n
            ] or [0.0]
            coefficients[0] -= self.c
        elif self.of in symbols.QUANTITIES:
            return None
        else:
            symbol = self.law.parameters[self.of].symbol
            if not self.law.expr.is_polynomial(symbol):
                return None
            part, order = self.law.bind(**{self.of: 0}), 0
            coefficients = [N * float(slope_mean(part, criterion, V)[0]) - self.c]
            while self.of in part.parameters:  # Taylor's expansion at 0 ends
                part, order = part.partial(self.of), order + 1
                coefficients.append(N * float(slope_mean(part, criterion, V)[0]) / math.factorial(order))
        polynomial = np.polynomial.Polynomial(coefficients).trim()
        roots: Any = polynomial.roots() if polynomial.degree() else np.empty(0)
        real_roots = sorted(float(x.real) for x in roots if abs(x.imag) <= _CLOSE * abs(x))
        low, high = (-math.inf, math.inf) if self.within is None else self.within
        positive = self.of in symbols.QUANTITIES or self.law.parameters[self.of].positive
        return [x for x in real_roots if low <= x <= high and (x > 0 or not positive)]

    # -- results -----------------------------------------------------------------------------------

    def _result(self, x: float, method: Method | None, rtol: float) -> Critical:
        """Return a root with its error, from that of the threshold and the slope there."""
        points = self.at(x)
        found, by = self._computed(method, points, _tight(rtol))
        if by is None:
            raise NotConverged(f"there is no threshold at {self.of} = {x:.6g}; try another method")
        sensitivity = self._sensitivity(points, by)
        value, own = float(found.value[0]), float(found.relative_error[0]) * abs(found.value[0])
        step = sensitivity["c"] * (self.c - value)
        if by.criterion is not None:
            return Critical(self.of, x + step, self.unit, by.name, None, sensitivity)
        if not math.isfinite(own):  # where the threshold is 0 its relative error is nothing
            beside, _ = self._computed(method, self.at(x * (1 + _BESIDE)), _TIGHTEST)
            own = float(beside.relative_error[0] * abs(beside.value[0]))
        error = (abs(sensitivity["c"]) * own + step**2 / abs(x)) / abs(x) + _ROUNDING
        if abs(step) < _NEWTON * abs(x):
            x += step
        else:
            error += abs(step / x)
        if not error <= rtol:
            raise NotConverged(
                f"{self.of} = {x:.6g} is known to {error:.1e} relative only, not to rtol = {rtol:g}; "
                "try another rtol"
            )
        return Critical(self.of, x, self.unit, by.name, error, sensitivity)

    def _sensitivity(self, points: OperatingPoints, method: Method) -> dict[str, float]:
        if method.sensitivity is None:
            raise InputError(f"how a threshold by {method.name!r} changes is not known; try another method")
        found = method.sensitivity(points, np.array([self.c]))
        by = {name: float(column[0]) for name, column in found.items()}
        own = by.pop(self.of)
        with np.errstate(all="ignore"):
            return {"c": float(np.divide(1.0, own))} | {
                name: float(np.divide(-value, own)) for name, value in by.items()
            }

    def _proved(self, one: Critical, rtol: float) -> Critical:
        """Enclose a value: where the threshold grows with it, the slip returns above it, so minus it is sought."""
        sign = -1 if one.sensitivity["c"] > 0 else 1

        def decision(x: Fraction, bits: int) -> Transit:
            points = self.at(str(sign * x))
            point = ExactPoint(points.law, **points.exact_row(0))
            checked_hypotheses(point)
            return transit(point, Fraction(self.c), bits)

        found = Search(decision, self.of).around(sign * one.value, one.relative_error or rtol, rtol)
        enclosure = found if sign > 0 else Enclosure(-found.high, -found.low)
        middle = float(enclosure)
        error = float(enclosure.radius) / abs(middle)
        return Critical(self.of, middle, one.unit, "proof", error, one.sensitivity, enclosure)


def _tight(rtol: float) -> float:
    """Return the relative error of a threshold at a root."""
    return max(_FINER * rtol, _TIGHTEST)


def _spaced(low: float, high: float) -> FloatArray:
    return np.geomspace(low, high, max(3, math.ceil(math.log10(high / low) * _PER_DECADE) + 1))
