"""Generalised power series of a slope at rest and far out, and what they make of its average.

At rest the slope g'(x) is a sum of c x^e (log x)^l with rising exponents e, far out one of c x^-e (log x)^l. An
exponent need not be whole, so that a power of what vanishes at rest is expanded as any other function is. An
average takes each term to the same power of r. Far out the slope at low speeds adds its moments, which belong to
the powers of the weight near v = 0; where both meet in one power, it stands beside log(r).
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache, reduce
from operator import add, mul

import sympy as sp
from flint import acb, arb, arb_series

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.balls import ball_function, ball_value, rational, series_function
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.functions import fold, row
from stickslip_sym.core.precision import working_precision
from stickslip_sym.criteria.criterion import Criterion

_TERMS = 30
"""Terms of a series: (1/4)^30 < 2^-57, so that it holds up to a quarter of its radius of convergence."""
_BITS = 240  # of working precision, for exponents of two that differ by `_STEP`
_STEP = 2.0**-60  # to both sides of an exponent, between which a mean has its finite part or its derivative

_LIMITS: dict[type[Expr], tuple[int | None, int | None]] = {
    sp.exp: (0, None), sp.tanh: (-1, 1), sp.coth: (-1, 1), sp.sech: (0, 0), sp.csch: (0, 0), sp.erf: (-1, 1),
    sp.erfc: (2, 0),
}  # fmt: skip
"""What functions tend to, faster than any power, as their argument falls to -infinity, and as it grows."""

Powers = dict[tuple[int, int], arb]
"""Coefficients by the exponents of x, in units of the series, and of log(x)."""


class Unexpanded(ArithmeticError):
    """A function has no such series, or its leading term is not certain."""


@dataclass(frozen=True)
class Series:
    """A sum of c x^(e/unit) log(x)^l, complete for exponents below `top`."""

    terms: Powers
    top: float = math.inf

    @classmethod
    def of(cls, terms: Powers, top: float) -> "Series":
        """Return a series without zeros, cut where it has more terms than are kept."""
        keys = sorted(key for key, value in terms.items() if value != 0 and key[0] < top)
        if len(keys) > _TERMS:
            top = min(top, keys[_TERMS][0])
        return cls({key: terms[key] for key in keys if key[0] < top}, top)

    @property
    def low(self) -> float:
        """The lowest exponent."""
        return min((exponent for exponent, _ in self.terms), default=self.top)

    @property
    def leading(self) -> tuple[int, arb]:
        """The lowest exponent and its coefficient, which must be certain and stand alone."""
        leaders = [(e, c) for (e, _), c in self.terms.items() if e == self.low]
        if len(leaders) != 1 or (leaders[0][0], 0) not in self.terms or not bool(leaders[0][1] != 0):
            raise Unexpanded("the leading term is not certain")
        return leaders[0]

    def __add__(self, other: "Series") -> "Series":
        terms = dict(self.terms)
        for key, value in other.terms.items():
            terms[key] = terms[key] + value if key in terms else value
        return Series.of(terms, min(self.top, other.top))

    def __mul__(self, other: "Series") -> "Series":
        top = min(self.top + other.low, other.top + self.low)
        terms: Powers = {}
        for (e, n), a in self.terms.items():
            for (f, m), b in other.terms.items():
                if e + f < top:
                    key = e + f, n + m
                    terms[key] = terms[key] + a * b if key in terms else a * b
        return Series.of(terms, top)

    def without(self, exponent: int, coefficient: arb) -> "Series":
        """Return the quotient by a term, less 1: what vanishes of it where the term leads."""
        terms = {(e - exponent, n): c / coefficient for (e, n), c in self.terms.items() if (e, n) != (exponent, 0)}
        return Series(terms, self.top - exponent)

    def inserted_in(self, coefficients: list[arb]) -> "Series":
        """Return the sum of coefficients times powers of this, which vanishes with x."""
        if not self.terms and self.top == math.inf:
            return Series({(0, 0): coefficients[0]})
        top = min(self.top, self.low * len(coefficients))
        total = Series({})
        for coefficient in reversed(coefficients):
            total = total * self + Series({(0, 0): coefficient}, top)
        return total


_BEYOND = Series({}, -math.inf)
"""What grows faster than any power."""


def _beyond(node: Expr, parts: list[Series]) -> Series:
    """Return a node of what grows faster than any power: that too, or what vanishes faster than any."""
    others = [part for part in parts if part is not _BEYOND]
    if node.is_Pow and node.exp.is_negative:
        return Series({})
    if len(others) < len(parts) - 1 or not (node.is_Add or node.is_Mul or (node.is_Pow and node.exp.is_positive)):
        raise Unexpanded(f"{node} grows in ways that may cancel")
    if node.is_Mul:
        for part in others:
            _ = part.leading  # a factor that may be 0 is refused
    return _BEYOND


class _Expander:
    """The algebra of generalised series in x = v, or in x = 1/v far out."""

    def __init__(self, point: Mapping[Expr, Expr], unit: int, far: bool) -> None:
        self.point, self.unit, self.sign = point, unit, -1 if far else 1

    def __call__(self, node: Expr, parts: list[Series]) -> Series:
        if node == symbols.v:
            return Series({(self.sign * self.unit, 0): arb(1)})
        if not node.has(symbols.v):
            value = ball_value(node, self.point)
            if not value.is_finite() or value.imag != 0:
                raise Unexpanded(f"{node} has no value")
            return Series.of({(0, 0): value.real}, math.inf)
        if any(part is _BEYOND for part in parts):
            return _beyond(node, parts)
        if node.is_Add or node.is_Mul:
            return reduce(add if node.is_Add else mul, parts)
        if node.is_Pow and node.base is not sp.E:
            return self._power(parts[0], node.exp.xreplace(dict(self.point)))
        known = row(node)
        if known is None or known.ball is None or len(parts) != 1:
            raise Unexpanded(f"{node} has no series")
        return self._function(known.kind, parts[0])

    def _power(self, base: Series, exponent: Expr) -> Series:
        if not exponent.is_Rational:
            raise Unexpanded(f"the exponent {exponent} is not rational")
        if not base.terms and base.top == math.inf and exponent.is_positive:
            return base  # what is smaller than any power
        low, first = base.leading
        if exponent.is_Integer:
            factor = first ** int(exponent)
        elif bool(first > 0):
            factor = first ** arb(rational(exponent))
        else:
            raise Unexpanded("a root of what is negative")
        whole, rest = divmod(low * int(exponent.p), int(exponent.q))
        if rest:
            raise Unexpanded("the unit of exponents is too large")
        binomials, power = [arb(1)], arb(rational(exponent))
        for k in range(_TERMS):
            binomials.append(binomials[-1] * (power - k) / (k + 1))
        return Series({(whole, 0): factor}) * base.without(low, first).inserted_in(binomials)

    def _function(self, kind: type[Expr], inner: Series) -> Series:
        if inner.low < 0:
            return self._far_function(kind, inner)
        start = inner.terms.get((0, 0), arb(0))
        rest = Series({key: c for key, c in inner.terms.items() if key != (0, 0)}, inner.top)
        if kind is sp.log and start == 0:
            low, first = inner.leading
            whole = Series({(0, 0): first.log(), (0, 1): arb(rational(sp.Rational(low, self.unit)))})
            return whole + inner.without(low, first).inserted_in(_taylor(sp.log, arb(1)))
        if rest.low <= 0:
            raise Unexpanded("a function of a logarithm")
        return rest.inserted_in(_taylor(kind, start))

    def _far_function(self, kind: type[Expr], inner: Series) -> Series:
        """Return a function of what grows without bound: far out, or exp(-1/v) near rest."""
        if self.sign > 0 and kind is not sp.exp:
            raise Unexpanded(f"{kind.__name__} has an essential singularity")
        low, first = inner.leading
        positive = bool(first > 0)
        if kind is sp.log and positive:
            whole = Series({(0, 0): first.log(), (0, 1): arb(rational(sp.Rational(low, self.unit)))})
            return whole + inner.without(low, first).inserted_in(_taylor(sp.log, arb(1)))
        if kind is sp.atan:
            quarter = Series({(0, 0): (arb.pi() if positive else -arb.pi()) / 2})
            return quarter + Series({(0, 0): arb(-1)}) * self._function(
                sp.atan, self._power(inner, sp.Integer(-1))
            )
        limit = _LIMITS.get(kind, (None, None))[positive]
        if kind is sp.exp and positive:
            return _BEYOND
        if limit is None:
            raise Unexpanded(f"{kind.__name__} has no limit")
        return Series.of({(0, 0): arb(limit)}, math.inf)


def _taylor(kind: type[Expr], start: arb) -> list[arb]:
    x = sp.Dummy()
    with working_precision(_BITS, _TERMS + 1):
        series = series_function(kind(x), x, {})(arb_series([start, 1], prec=_TERMS + 1))
        coefficients = [series[k] for k in range(_TERMS + 1)]
    if not all(coefficient.is_finite() for coefficient in coefficients):
        raise Unexpanded(f"{kind.__name__} is not analytic at {float(start)}")
    return coefficients


def expanded(slope: Expr, point: Mapping[Expr, Expr], unit: int, *, far: bool) -> Series:
    """Return the series of a slope at rest, or in 1/v far out; the exponents are in units of 1/`unit`."""
    try:
        series = fold(slope, _Expander(point, unit, far))
    except (InputError, ValueError, ZeroDivisionError, OverflowError) as failure:
        raise Unexpanded(str(failure)) from None
    if series is _BEYOND:
        raise Unexpanded("it grows faster than any power")
    return series


def unit_of(slope: Expr, point: Mapping[Expr, Expr], criterion: Criterion) -> int:
    """Return the common denominator of all exponents in the series of a slope and of its average."""
    exponents = [node.exp.xreplace(dict(point)) for node in slope.atoms(sp.Pow)]
    denominators = [int(exponent.q) for exponent in exponents if exponent.is_Rational]
    return math.prod(denominators) * (1 if criterion.weight is None or criterion.is_polynomial else 2)


@lru_cache(maxsize=16)
def _mean_power(criterion: Criterion) -> Callable[[arb], arb]:
    exponent = sp.Dummy()
    with working_precision(_BITS):
        function = ball_function(criterion.mean_power(exponent), exponent, {})
    return lambda e: function(acb(e), False).real


def _means(criterion: Criterion, exponent: arb) -> tuple[arb, arb]:
    """Return the finite part of <p^e>, p = 1 + s, and of <p^e log(p)>."""
    if criterion.weight is None:
        return arb(1), arb(0)
    with working_precision(_BITS):
        mean = _mean_power(criterion)
        low, high, lower, higher = (mean(exponent + k * _STEP) for k in (-1, 1, -2, 2))
        # Of A/e + B + C e, e being the distance from the exponent, B and C.
        return ((low + high) / 2).mid(), ((2 * (higher - lower) - (high - low)) / (6 * _STEP)).mid()


def near_rest(series: Series, criterion: Criterion, unit: int) -> Series:
    """Return F(r) = -<g'(r (1 + s))> for small r."""
    terms: Powers = {}
    for (e, n), c in series.terms.items():
        mean, beside = _means(criterion, arb(e) / unit)
        if n > 1:
            raise Unexpanded("a power of a logarithm")
        _add(terms, (e, n), -c * mean)
        if n:
            _add(terms, (e, 0), -c * beside)
    return Series.of(terms, series.top)


def far_out(
    series: Series, criterion: Criterion, unit: int, end: arb, weight: list[arb], moments: list[arb]
) -> Series:
    """Return F(r) for large r, in 1/r.

    The series holds for v > `end`; below that the slope has `moments` with the terms of the weight, w = sum of
    `weight` p^(j + order), p = v/r, in units of `end`.
    """
    terms: Powers = {}
    order = 0 if criterion.is_polynomial else unit // 2
    powers = [order + j * unit for j in range(len(weight))]
    for (e, n), c in series.terms.items():
        mean, beside = _means(criterion, -arb(e) / unit)
        if n > 1:
            raise Unexpanded("a power of a logarithm")
        # log(1/v) = -log(p) - log(r), and log(1/r) stands in the result.
        _add(terms, (e, n), -c * mean)
        if n:
            _add(terms, (e, 0), c * beside)
    for power, factor, moment in zip(powers, weight, moments, strict=True):
        total = moment
        for (e, n), c in series.terms.items():
            rate = arb(power + unit - e) / unit
            if rate == 0 and n:
                total += c * factor * end.log() ** 2 / 2 * end ** (-arb(e) / unit)
                _add(terms, (e, 2), c * factor / 2)
            elif rate == 0:
                total -= c * factor * end.log() * end ** (-arb(e) / unit)
                _add(terms, (e, 1), c * factor)
            else:
                share = c * factor * end ** (-arb(e) / unit) / rate
                total -= share * (-(end.log() - 1 / rate)) if n else share
        key = power + unit, 0
        _add(terms, key, -total * end ** (arb(power + unit) / unit))
    return Series.of(terms, series.top)


def _add(terms: Powers, key: tuple[int, int], value: arb) -> None:
    terms[key] = terms[key] + value if key in terms else value
