"""The criterion of a slope g without parameters, F(r) = -<g(r(1 + s))>_w, as branches in r.

Nothing is known of g but its expression. The branches are found when a law is first evaluated:

- a power series for small r, with exponentials taken out;
- the closed form, from where on its running error bound says that its terms no longer cancel, and what is left of
  it from where on its exponentials are negligible;
- polynomials fitted to Gauss averages of extended precision for what lies between;
- a series in 1/r, or the leading power with its logarithm, for r beyond all scales.

Every branch is compared with Gauss averages before it is used.
"""

from functools import lru_cache

import numpy as np
import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, FloatArray
from stickslip_sym.core.errors import NoClosedForm
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.criteria import gauss
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.evaluation.bounds import rounding_bound, slope_with_bound
from stickslip_sym.formula.evaluation.branches import CENTERS, STRETCHES, Branch, LogTail, Profile, Series, Table
from stickslip_sym.formula.evaluation.closed import Closed, as_closed, as_formula
from stickslip_sym.formula.evaluation.conditioning import conditioned, speed_scales
from stickslip_sym.formula.evaluation.fitting import (
    TERMS,
    chebyshev_fit,
    chebyshev_nodes,
    economised,
    taylor,
    to_monomials,
)
from stickslip_sym.formula.integration.integrals import integrate_terms

__all__ = ["profile_of"]

_EPSILON = float(np.finfo(np.float64).eps)
_LOW, _HIGH = -30, 60  # binary exponents of r between which branches are fitted
_BOUND = 30.0  # units of the running bound up to which the closed form is used; the bound is far from sharp
_AGREED = 5.0  # units of difference from a Gauss average in double precision
_MEASURED = 2.75  # units of error of the closed form, measured
_NEGLIGIBLE = 2.0**-55  # of the value
_CLOSE = 32  # points in an octave where that is measured
_NODES = 19  # of the fit in a panel
_FAR = (0, 140, 400)  # binary orders beyond the fitted range, where the leading term is read off
_CONDITION = 1.5  # of a series: the sum of sizes over the size of the sum
_TAIL_NODES = 31
_TAILS = (3, 4, 5, 6, 7)  # binary exponents of r from where a series in 1/r is tried


@lru_cache(maxsize=128)
def profile_of(mu: Expr, criterion: Criterion) -> Profile | None:
    """Return the branches of F for a coefficient mu(v) without parameters; None if there are none."""
    return _Builder(mu, criterion).build()


class _Builder:
    """Finds the branches of one function."""

    def __init__(self, mu: Expr, criterion: Criterion) -> None:
        self.mu, self.criterion = mu, criterion
        self.slope = sp.diff(mu, symbols.v)
        stable = conditioned(self.slope)
        self.compiled = slope_with_bound(stable, [symbols.v])
        scales = [float(scale) for scale in speed_scales(stable, symbols.v) if scale.is_number]
        self.scale = min(scales, default=1.0)

    def build(self) -> Profile | None:
        """Return the branches in order, or None."""
        if self.slope == 0:
            return Profile((0.0,), (Series(0.0, (0.0,)),), (np.inf,))
        if self.slope.is_polynomial(symbols.v):
            return self._polynomial()
        direct = self._direct()
        last = None if direct is None else self._leading([2.0 ** (_HIGH + k) for k in _FAR])
        # A closed form reaches as far as its leading term takes over; else a series in 1/r does.
        outer: list[tuple[float, Branch]] = []
        if last is not None:
            outer.append((2.0**_HIGH, last))
        elif (tail := self._tail()) is not None:
            outer.append(tail)
        if direct is not None and (not outer or direct[0] < outer[0][0]):
            outer.insert(0, direct)
        if not outer:
            return None
        closed = outer[0][0]
        series = self._series(closed)
        starts = [0.0]
        branches: list[Branch | None] = [series[1] if series else self._leading([2.0 ** (_LOW - k) for k in _FAR])]
        opened = series[0] if series else 2.0**_LOW
        if opened < closed:
            starts.append(opened)
            branches.append(self._table(opened, closed))
            outer[0] = closed, outer[0][1]
        for start, branch in outer:
            starts.append(max(start, opened))
            branches.append(branch)
        if not any(branches):
            return None
        ends = [*starts[1:], np.inf]
        alone = self._without_exponentials(*direct) if direct is not None and len(outer) == 2 else None
        if alone is not None and starts[-2] < alone[0] < starts[-1]:
            starts.insert(-1, alone[0])
            branches.insert(-1, alone[1])
            ends.insert(-1, ends[-2])
        return Profile(tuple(starts), tuple(branches), tuple(ends))

    # -- Gauss averages --------------------------------------------------------------------------

    def averages(
        self, r: FloatArray | list[float], extended: bool = True
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return F, <|g|> and the error of F by Gauss rules."""
        r = np.asarray(r, dtype=np.longdouble if extended else np.float64)
        tolerance = 2.0**-60 if extended else 2.0**-52
        scale = np.full_like(r, self.scale)
        value, size, error = gauss.average(self.compiled, r, [], self.criterion, scale=scale, tolerance=tolerance)
        return -value, size, error

    # -- branches --------------------------------------------------------------------------------

    def _polynomial(self) -> Profile:
        """Sum the moments; for large r the same polynomial in 1/r."""
        coefficients = [
            -g * self.criterion.mean_power(k)
            for k, g in enumerate(reversed(sp.Poly(self.slope, symbols.v).all_coeffs()))
        ]
        low = next(k for k, c in enumerate(coefficients) if c != 0)
        used = coefficients[low:]
        degree = len(used) - 1
        step = 2 if all(c == 0 for c in used[1::2]) else 1
        floats = tuple(float(c) for c in used[::step])
        small = Series(float(low), floats, variable=float(step))
        if degree == 0:
            return Profile((0.0,), (small,), (np.inf,))
        large = Series(float(low + degree), floats[::-1], variable=-float(step))
        return Profile((0.0, 1.0), (small, large), (1.0, np.inf))

    def _series(self, closed: float) -> tuple[float, Series] | None:
        """Expand F around r = 0; return it and the r up to which it is good."""
        decay = self._decay()
        found = taylor(self.slope, self.criterion, decay)
        if found is None:
            return None
        coefficients, radius = found
        low = next((k for k, c in enumerate(coefficients) if c != 0), None)
        if low is None:
            return None
        used = coefficients[low:]
        r = 2.0 ** np.arange(-6, 3.01, 0.125)
        r = r[2 * r <= radius / 2]
        parts = np.array([float(c) for c in used]) * r[:, None] ** np.arange(len(used))
        total, rest = np.abs(parts.sum(axis=1)), np.cumsum(np.abs(parts)[:, ::-1], axis=1)[:, ::-1]
        negligible = rest < 2.0**-57 * total[:, None]
        needed = np.where(negligible.any(axis=1), negligible.argmax(axis=1), len(used))
        good = (needed <= TERMS) & (rest[:, 0] <= _CONDITION * total)
        last = r.size if good.all() else int((~good).argmax())
        if last == 0:
            return None
        chosen = min(last - 1, int((r < closed).sum()))
        end, used = float(r[chosen]), used[: int(needed[chosen])]
        step = 2 if all(c == 0 for c in used[1::2]) else 1
        return end, Series(float(low), economised(used[::step], end**step), decay=decay, variable=float(step))

    def _decay(self) -> float:
        """Return the rate k if every term of g has a factor exp(-k v), else 0."""
        rates = set()
        for term in sp.Add.make_args(sp.expand(self.slope)):
            exponents = [factor.args[0] for factor in sp.Mul.make_args(term) if isinstance(factor, sp.exp)]
            rate = -sp.Add(*exponents).coeff(symbols.v)
            rates.add(float(rate) if rate.is_number and rate.is_positive else 0.0)
        return min(rates)

    def _direct(self) -> tuple[float, Branch] | None:
        """Take the closed form, from where on its rounding error is small for all larger r."""
        try:
            parts = integrate_terms(self.mu, self.criterion, 0.0, lambda _: None)
        except NoClosedForm:
            return None
        raw = sp.Add(*[part.value for part in parts]).subs(symbols.N, 1)
        if raw.has(sp.I):
            return None
        if raw.atoms(sp.Function) and not all(isinstance(f, _ELEMENTARY) for f in raw.atoms(sp.Function)):
            return None
        grid = 2.0 ** np.arange(_LOW, _HIGH + 0.01, 0.25)
        value, size, _ = self.averages(grid, extended=False)
        best: tuple[float, Branch] | None = None
        for branch, expr in (as_closed(raw), as_formula(raw)):
            bound = function_of([symbols.V], rounding_bound(expr), "numpy")
            with np.errstate(all="ignore"):
                got = _value(branch, grid)
                good = np.isfinite(got) & (bound(grid) <= _BOUND * size)
                good &= np.abs(got - value) <= _AGREED * _EPSILON * size
            if good[-1]:
                start = self._measured(branch, float(grid[int(np.flatnonzero(~good).max(initial=-1)) + 1]))
                # Polynomials are faster than the formula as it stands, which may serve further down.
                if best is None or start < best[0] / 4:
                    best = start, branch
        return best

    def _measured(self, branch: Branch, start: float) -> float:
        """Return from where on a branch errs by a few units only, measured closely where it may just begin to."""
        r = start * 2.0 ** (np.arange(0, 8 * _CLOSE) / _CLOSE)
        value, size, _ = self.averages(r)
        wrong = np.flatnonzero(np.abs(_value(branch, r) - value) > _MEASURED * _EPSILON * size)
        return float(r[min(int(wrong.max(initial=-1)) + 1, r.size - 1)])

    def _without_exponentials(self, start: float, branch: Branch) -> tuple[float, Series] | None:
        """Return what is left of a closed form where its exponentials are negligible, and from where on."""
        if not isinstance(branch, Closed) or not branch.is_light:
            return None
        (alone, coefficients), *exponentials = branch.parts
        if alone is not None or not exponentials:
            return None
        r = 2.0 ** np.arange(np.ceil(np.log2(start)), _HIGH + 0.01, 0.25)
        with np.errstate(all="ignore"):
            rest, *others = (np.abs(Closed(0.0, (part,))(r)) for part in branch.parts)
            needed = np.flatnonzero(~(sum(others) <= _NEGLIGIBLE * rest))
        first = int(needed.max(initial=-1)) + 1
        if first == r.size:
            return None
        return float(r[first]), Series(branch.power, coefficients, variable=-1.0)

    def _tail(self) -> tuple[float, Series] | None:
        """Fit r^-power F for large r by a polynomial in 1/r, or in its square root."""
        power = self._power(2.0**_HIGH)
        if power is None:
            return None
        for exponent in _TAILS:
            for variable in (-1.0, -0.5):
                start = 2.0**exponent
                largest = start**variable
                z = (1 + chebyshev_nodes(_TAIL_NODES)) / 2 * largest
                r = z ** np.longdouble(1 / variable)
                value, _, error = self.averages(r)
                coefficients = chebyshev_fit(value * r ** np.longdouble(-power))
                sizes = np.abs(coefficients)
                if not (np.isfinite(error).all() and sizes[-4:].max() <= 2.0**-57 * sizes[0]):
                    continue
                kept = int(np.flatnonzero(sizes > 2.0**-58 * sizes[0]).max()) + 1
                monomials = tuple(float(c) for c in to_monomials(coefficients[:kept]))
                return start, Series(power, monomials, variable=variable, shift=largest / 2, stretch=2 / largest)
        return None

    def _power(self, r: float) -> float | None:
        """Return the power of r by which F goes far out; None if there is a logarithm too."""
        value, _, error = self.averages([r, 2 * r, 4 * r])
        if not (np.isfinite(error).all() and (value != 0).all() and (np.sign(value) == np.sign(value[0])).all()):
            return None
        powers = np.log2(np.abs(value[1:] / value[:-1]))
        power = round(2 * float(powers[0])) / 2
        return power if np.abs(powers - power).max() < 1e-6 else None

    def _leading(self, places: list[float]) -> LogTail | None:
        """Return the leading term beyond three places that lie outside the fitted range, in order."""
        value, _, error = self.averages(places)
        if not np.isfinite(error).all() or (value == 0).any():
            return None
        logs = np.log(np.asarray(places, dtype=np.longdouble))
        for half in range(-12, 5):
            y = value * np.asarray(places, dtype=np.longdouble) ** np.longdouble(-half / 2)
            slope = (y[1] - y[0]) / (logs[1] - logs[0])
            constant = y[0] - slope * logs[0]
            if abs(constant + slope * logs[2] - y[2]) <= 4 * _EPSILON * abs(y[2]):
                if abs(slope * logs[2]) < 4 * _EPSILON * abs(y[2]):
                    return LogTail(half / 2, float(y[0]), 0.0)
                return LogTail(half / 2, float(constant), float(slope))
        return None

    def _table(self, start: float, stop: float) -> Table | None:
        """Fit F by a polynomial in each half octave."""
        first = int(np.floor(np.log2(start))) + 1
        last = int(np.ceil(np.log2(stop)))
        nodes = chebyshev_nodes(_NODES)
        panels = [
            np.ldexp(np.longdouble(1), exponent) * (center + nodes / stretch)
            for exponent in range(first, last + 1)
            for center, stretch in zip(CENTERS, STRETCHES, strict=True)
        ]
        value, size, error = self.averages(np.concatenate(panels))
        if not (error <= 8 * _EPSILON * size).all():
            return None
        rows = []
        for y, scale in zip(value.reshape(-1, _NODES), size.reshape(-1, _NODES), strict=True):
            coefficients = chebyshev_fit(y)
            if np.abs(coefficients[-2:]).max() > 2 * _EPSILON * scale.min():
                return None
            rows.append(to_monomials(coefficients))
        return Table(0.0, first, np.array(rows, dtype=np.float64))


_ELEMENTARY = (sp.exp, sp.log, sp.atan, sp.erf, sp.asinh)


def _value(branch: Branch, r: FloatArray) -> FloatArray:
    """Return F by a branch, for r that no power takes out of range."""
    return branch(r) * r**branch.power
