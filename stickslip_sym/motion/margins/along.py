"""The search for critical values along one quantity or parameter.

An average that is a polynomial in it gives all roots as such. Otherwise the threshold is computed on a grid over a
range, and every change of sign of threshold minus c, and every extremum that comes close to one, is followed.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from stickslip_sym.core import deadline, symbols
from stickslip_sym.core.aliases import BoolArray, FloatArray
from stickslip_sym.core.errors import InputError, NotConverged, NoThreshold
from stickslip_sym.core.numbers import real
from stickslip_sym.criteria.criterion import Criterion, harmonic
from stickslip_sym.criteria.enclosure import Enclosure
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.margins.proved import proved
from stickslip_sym.motion.margins.transition import Search, transition_speed
from stickslip_sym.motion.margins.value import Critical
from stickslip_sym.motion.orbits.orbit import obstacle
from stickslip_sym.motion.thresholds.rungs import Found, Rung, rungs, second_order
from stickslip_sym.motion.thresholds.scenes import Scenes
from stickslip_sym.motion.thresholds.sensitivity import sensitivities, slope_mean

__all__ = ["Along"]

_PER_DECADE = 8  # values sampled
_STRONG = 1e-2  # relative size of the next order, from which the orbit takes longer than a simulation
_AROUND = 100.0  # factor above and below a parameter's value within which it is sought
_WEAKEST, _STRONGEST = 1e-3, 1e2  # N/(V sqrt(k m)) between which N, m and k are sought
_LOOSE, _TIGHT, _SINGLE = 1e-6, 1e-12, 1e-9  # relative errors on a grid, at a root, and by simulation
_ROUNDING = float(4 * np.finfo(np.float64).eps)  # relative, of a root
_HALVINGS = 8  # bisections of an interval of the grid, for the last value at which mu is known at all speeds
_NEWTON = 1e-6  # relative size of a last Newton step, up to which it is taken


class Along(Search):
    """The search for the roots of threshold minus c along one quantity or parameter."""

    closest = 1e-9  # tolerance of the logarithm of a root, which a Newton step with the exact slope then refines

    def __init__(
        self, of: str, law: FrictionLaw, given: Mapping[str, float], within: tuple[float, float] | None
    ) -> None:
        self.of, self.law, self.within = of, law, within
        self.given: dict[str, Any] = dict(given)
        self.c = self.given.pop("c")
        oscillator = {"m", "k"} & (self.given.keys() | {of})
        if len(oscillator) == 1:
            raise InputError("give both the mass m and the stiffness k, or neither")
        self.has_oscillator = bool(oscillator)
        self.sign = 1.0

    @property
    def unit(self) -> str | None:
        """The unit of what is sought; None if it is not known."""
        if self.of in symbols.QUANTITIES:
            return symbols.QUANTITIES[self.of].unit
        return self.law.parameters[self.of].unit

    def at(self, x: float) -> tuple[FrictionLaw, dict[str, float]]:
        """Return the law and the scene for a value of what is sought."""
        if self.of in symbols.QUANTITIES:
            return self.law, {**self.given, self.of: x}
        return self.law.bind(**{self.of: x}), self.given

    def excess(self, rung: Rung, V: FloatArray, orbit_rtol: float = _TIGHT) -> FloatArray:
        """Return threshold minus c at sizes of what is sought; NaN where there is none."""
        deadline.check_time()
        x = self.sign * np.asarray(V)
        tolerance = _SINGLE if rung.singly else orbit_rtol
        if self.of in symbols.QUANTITIES and not rung.singly:
            return self._values(rung, Scenes.of(self.law, **(self.given | {self.of: x})), tolerance) - self.c
        found = []
        for value in x:
            law, scene = self.at(float(value))
            found.append(self._values(rung, Scenes.of(law, **scene), tolerance)[0] - self.c)
        return np.array(found)

    def _values(self, rung: Rung, scenes: Scenes, tolerance: float) -> FloatArray:
        try:
            found = rung.compute(scenes, tolerance)
        except NoThreshold:
            return np.full(len(scenes), -1.0 - abs(self.c))  # below 0, by an unknown amount
        except NotConverged:
            return np.full(len(scenes), np.nan)
        except InputError:
            if scenes.law.v_max is None:
                raise
            return np.full(len(scenes), np.nan)  # the motion goes beyond the last measured speed
        return np.where(np.isfinite(found.error), found.value, np.nan)

    def found(self, rung: Rung | None, rtol: float) -> tuple[Critical, ...]:
        """Return the critical values, by the given rung or, without one, by that which "auto" takes."""
        if self.of == "V":
            return self._speeds(rung, rtol)
        automatic = rung is None
        rung = rung or self._automatic()
        if rung.criterion is not None:
            roots = self._polynomial_roots(rung.criterion)
            if roots is not None:
                return tuple(self._result(x, rung, None) for x in roots)
            if self.of in ("m", "k"):
                raise InputError(f'an average of slopes does not depend on {self.of}; try method="orbit"')
        proof = rung.name == "proof"
        if proof:
            rung = rungs()["simulation"]
        sizes = self.grid()
        sought = _filled(rung) if automatic and rung.name == "orbit" else rung
        roots = sorted(self.sign * x for x in self.crossings(sought, sizes))
        results = [self._result(x, rung, rtol, automatic) for x in roots]
        return tuple(self._proved(one, rtol) for one in results) if proof else tuple(results)

    def crossings(self, rung: Rung, V: FloatArray) -> list[float]:
        """Return the sizes at which the excess changes sign, up to where motions leave the measured speeds."""
        if self.law.v_max is None:
            return super().crossings(rung, V)
        known = np.isfinite(self.excess(rung, V, _LOOSE))
        edges = []
        for place in np.flatnonzero(known[1:] != known[:-1]):
            inside, outside = (V[place], V[place + 1]) if known[place] else (V[place + 1], V[place])
            for _ in range(_HALVINGS):
                middle = math.sqrt(inside * outside)
                if np.isfinite(self.excess(rung, np.array([middle]), _LOOSE)[0]):
                    inside = middle
                else:
                    outside = middle
            edges.append(inside)
        return super().crossings(rung, np.sort(np.append(V[known], edges)))

    def _automatic(self) -> Rung:
        if not self.has_oscillator:
            return rungs()["harmonic"]
        law, scene = self.at(self.sign * float(np.median(self.grid())))
        return rungs()["orbit" if obstacle(law, scene["V"]) is None else "simulation"]

    def _speeds(self, rung: Rung | None, rtol: float) -> tuple[Critical, ...]:
        proof = rung is not None and rung.name == "proof"
        method = "auto" if rung is None else ("simulation" if proof else rung)
        speeds = transition_speed(
            self.law,
            c=self.c,
            N=self.given["N"],
            m=self.given.get("m"),
            k=self.given.get("k"),
            method=method,
            rtol=rtol,
        )
        low, high = (0.0, math.inf) if self.within is None else sorted(self.within)
        results = [
            Critical("V", speed.value, "m/s", speed.method, speed.error, self._sensitivity(
                speed.value, rung if rung and not proof else rungs()[speed.method]))
            for speed in speeds if low <= speed.value <= high
        ]  # fmt: skip
        return tuple(self._proved(one, rtol) for one in results) if proof else tuple(results)

    def grid(self) -> FloatArray:
        """Return the sizes at which the threshold is sampled."""
        if self.within is not None:
            low, high = (real("within", end) for end in self.within)
            if not (low * high > 0 and low < high):
                raise InputError(f"within = ({low:g}, {high:g}) must be two numbers of one sign, ascending")
        elif self.of in symbols.QUANTITIES:
            low, high = self._by_friction()
        else:
            parameter = self.law.parameters[self.of]
            value = self.law.values.get(self.of, parameter.typical)
            if value is None or float(value) == 0:
                raise InputError(f"where to look for {self.of} is not known; give within=(low, high)")
            low, high = sorted(float(value) * factor for factor in (1 / _AROUND, _AROUND))
        self.sign = math.copysign(1.0, low)
        low, high = sorted((abs(low), abs(high)))
        return np.geomspace(low, high, max(3, math.ceil(math.log10(high / low) * _PER_DECADE) + 1))

    def _by_friction(self) -> tuple[float, float]:
        if self.of == "N":
            impedance = math.sqrt(self.given["k"] * self.given["m"])
            least, most = (ratio * self.given["V"] * impedance for ratio in (_WEAKEST, _STRONGEST))
            (slope,) = slope_mean(self.law, harmonic, np.array([self.given["V"]]))
            if slope * self.c > 0:  # weak friction: the threshold is nearly N times this
                least = min(least, self.c / slope / 10)
            return least, most
        other = self.given["m" if self.of == "k" else "k"]
        if self.given["N"] == 0:
            raise InputError(f"without a normal force nothing depends on {self.of}")
        low, high = (
            (self.given["N"] / (self.given["V"] * ratio)) ** 2 / other for ratio in (_STRONGEST, _WEAKEST)
        )
        return low, high

    def _polynomial_roots(self, criterion: Criterion) -> list[float] | None:
        """Return the roots of an average that is a polynomial in what is sought, or None."""
        V = np.array([self.given["V"]])
        if self.of == "N":
            (slope,) = slope_mean(self.law, criterion, V)
            coefficients = [-self.c, float(slope)]
        elif self.of in symbols.QUANTITIES:
            return None
        else:
            symbol = self.law.parameters[self.of].symbol
            if not self.law.expr.is_polynomial(symbol):
                return None
            part, coefficients, order = self.law.bind(**{self.of: 0}), [-self.c], 0
            coefficients[0] += self._mean(part, criterion, V)
            while self.of in part.parameters:  # Taylor's expansion at 0 ends
                part, order = part.partial(self.of), order + 1
                coefficients.append(self._mean(part, criterion, V) / math.factorial(order))
        roots: Any = (
            np.polynomial.Polynomial(coefficients).trim().roots() if len(coefficients) > 1 else np.empty(0)
        )
        real_roots = sorted(float(x.real) for x in roots if abs(x.imag) <= 1e-9 * abs(x))
        low, high = (-math.inf, math.inf) if self.within is None else self.within
        positive = self.of in symbols.QUANTITIES or self.law.parameters[self.of].positive
        return [x for x in real_roots if low <= x <= high and (x > 0 or not positive)]

    def _mean(self, law: FrictionLaw, criterion: Criterion, V: FloatArray) -> float:
        mean: float = slope_mean(law, criterion, V).item()
        return float(self.given["N"]) * mean

    def _sensitivity(self, x: float, rung: Rung) -> dict[str, float]:
        law, scene = self.at(x)
        found = sensitivities(Scenes.of(law, **scene), rung, np.array([self.c]), np.array([np.inf]))
        by = {name: float(column[0]) for name, column in found.items()}
        own = by.pop(self.of)
        with np.errstate(all="ignore"):
            return {"c": float(np.divide(1.0, own))} | {
                name: float(np.divide(-value, own)) for name, value in by.items()
            }

    def _result(self, x: float, rung: Rung, rtol: float | None, automatic: bool = False) -> Critical:
        """Return a root with its error, from that of the threshold and the slope there."""
        name = rung.name
        if rtol is None:
            return Critical(self.of, x, self.unit, name, None, self._sensitivity(x, rung))
        law, scene = self.at(x)
        tolerance = _SINGLE if rung.singly else _TIGHT
        scenes = Scenes.of(law, **scene)
        if automatic and rung.smooth and not _easy(scenes)[0]:
            rung, tolerance = rungs()["simulation"], _SINGLE
        found = rung.compute(scenes, tolerance)
        sensitivity = self._sensitivity(x, rung)
        if not rung.knows_its_error:
            return Critical(self.of, x, self.unit, rung.name, None, sensitivity)
        value = float(found.value[0])
        step = sensitivity["c"] * (self.c - value)
        error = (abs(sensitivity["c"] * value) * float(found.error[0]) + step**2 / abs(x)) / abs(x) + _ROUNDING
        if abs(step) < _NEWTON * abs(x):
            x += step
        if not error <= max(rtol, rung.reachable if not rung.singly else 0.0):
            raise NotConverged(
                f"{self.of} = {x:.6g} is known to {error:.1e} relative only, not to rtol = {rtol:g}; "
                "try another rtol"
            )
        return Critical(self.of, x, self.unit, rung.name, error, sensitivity)

    def _proved(self, one: Critical, rtol: float) -> Critical:
        low, high = proved(self.at, self.c, one.value, one.error or rtol, rtol)
        enclosure = Enclosure(low, high)
        middle = float(enclosure)
        error = float(high - low) / 2 / abs(middle)
        return Critical(self.of, middle, one.unit, "proof", error, one.sensitivity, enclosure)


def _easy(scenes: Scenes) -> BoolArray:
    """Return where friction is so weak that the orbit costs less than a simulation."""
    _, resolution, next_order = second_order(scenes)
    return (next_order < _STRONG) & (resolution < _STRONG)


def _filled(orbit: Rung) -> Rung:
    """Return the orbit, with simulation where friction is strong or there is none."""
    simulation = rungs()["simulation"]

    def compute(scenes: Scenes, rtol: float) -> Found:
        found = Found(np.full(len(scenes), np.nan), np.full(len(scenes), np.inf))
        easy = np.flatnonzero(_easy(scenes))
        if easy.size:
            by_orbit = orbit.compute(scenes.rows(easy), rtol)
            found.value[easy], found.error[easy] = by_orbit.value, by_orbit.error
        for row in np.flatnonzero(~np.isfinite(found.error)).tolist():
            try:
                one = simulation.compute(scenes.rows([row]), max(rtol, _SINGLE))
            except (NoThreshold, NotConverged):
                continue
            found.value[row], found.error[row] = one.value[0], one.error[0]
        return found

    return replace(orbit, compute=compute)
