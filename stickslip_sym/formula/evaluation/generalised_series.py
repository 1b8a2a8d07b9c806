"""Generalised power series of a slope at rest and far out, and what they make of its average.

At rest the slope g'(x) is a sum of c x^e (log x)^l with rising exponents e, far out one of c x^-e (log x)^l. An
exponent need not be whole, so that a power of what vanishes at rest is expanded as any other function is. An
average takes each term to the same power of r. Far out the slope at low speeds adds its moments, which belong to
the powers of the weight near v = 0; where both meet in one power, it stands beside log(r).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import sympy as sp
from flint import acb, arb

from stickslip_sym.core.aliases import Expr, Substitution
from stickslip_sym.core.balls import ball_function, rational
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.functions import Function, elementary, fold, write_erfcx
from stickslip_sym.core.numbers import NEGLIGIBLE
from stickslip_sym.core.precision import working_precision
from stickslip_sym.core.special import Erfcx
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.model.formula_algebra import Bound, ExpansionAlgebra, NotAnalytic

_SERIES_TERMS = round(-math.log2(NEGLIGIBLE)) // 2
"""Terms of a series: they gain two bits each up to a quarter of its radius of convergence."""
_WORKING_BITS = round(-4 * math.log2(NEGLIGIBLE))  # of working precision, for exponents that differ by that

_LIMITS: dict[type[Expr], tuple[int | None, int | None]] = {
    sp.exp: (0, None), sp.tanh: (-1, 1), sp.coth: (-1, 1), sp.sech: (0, 0), sp.csch: (0, 0), sp.erf: (-1, 1),
    sp.erfc: (2, 0),
}  # fmt: skip
"""What functions tend to, faster than any power, as their argument falls to -infinity, and as it grows."""

Powers = dict[tuple[int, int], arb]
"""Coefficients by the exponents of x, in units of the series, and of log(x)."""


@dataclass(frozen=True)
class GeneralisedSeries:
    """A sum of c x^(e/unit) log(x)^l, complete for exponents below `top`."""

    terms: Powers
    top: float = math.inf

    @classmethod
    def of(cls, terms: Powers, top: float) -> "GeneralisedSeries":
        """Return a series without zeros, cut where it has more terms than are kept."""
        keys = sorted(key for key, value in terms.items() if value != 0 and key[0] < top)
        if len(keys) > _SERIES_TERMS:
            top = min(top, keys[_SERIES_TERMS][0])
        return cls({key: terms[key] for key in keys if key[0] < top}, top)

    @property
    def low(self) -> float:
        """The lowest exponent."""
        return min((exponent for exponent, _ in self.terms), default=self.top)

    @property
    def leading(self) -> arb:
        """The first coefficient, which must be certain and stand alone."""
        leaders = [(n, c) for (e, n), c in self.terms.items() if e == self.low]
        if len(leaders) != 1 or leaders[0][0] or not bool(leaders[0][1] != 0):
            raise NotAnalytic("the leading term is not certain")
        return leaders[0][1]

    def __add__(self, other: "GeneralisedSeries") -> "GeneralisedSeries":
        terms = dict(self.terms)
        for key, value in other.terms.items():
            terms[key] = terms[key] + value if key in terms else value
        return GeneralisedSeries.of(terms, min(self.top, other.top))

    def __mul__(self, other: "GeneralisedSeries") -> "GeneralisedSeries":
        top = min(self.top + other.low, other.top + self.low)
        terms: Powers = {}
        for (e, n), a in self.terms.items():
            for (f, m), b in other.terms.items():
                if e + f < top:
                    key = e + f, n + m
                    terms[key] = terms[key] + a * b if key in terms else a * b
        return GeneralisedSeries.of(terms, top)

    def split(self) -> tuple[arb, "GeneralisedSeries"]:
        """Return the number in it, and what vanishes with x."""
        start = self.terms.get((0, 0), arb(0))
        rest = GeneralisedSeries({key: c for key, c in self.terms.items() if key != (0, 0)}, self.top)
        if rest.low <= 0:
            raise NotAnalytic("a function of a logarithm, or of what grows")
        return start, rest

    def without_first(self) -> "GeneralisedSeries":
        """Return it without its first term."""
        return GeneralisedSeries({key: c for key, c in self.terms.items() if key != (self.low, 0)}, self.top)

    def scaled(self, factor: arb, power: int = 0) -> "GeneralisedSeries":
        """Return it times a number and a power of x."""
        return GeneralisedSeries(
            {(e + power, n): c * factor for (e, n), c in self.terms.items()}, self.top + power
        )

    def constant(self, value: arb) -> "GeneralisedSeries":
        """Return a number."""
        return GeneralisedSeries.of({(0, 0): value}, math.inf)

    def inserted_in(self, coefficients: Sequence[arb], _bound: Bound | None = None) -> "GeneralisedSeries":
        """Return the sum of coefficients times powers of this, which vanishes with x."""
        if not self.terms and self.top == math.inf:
            return GeneralisedSeries({(0, 0): coefficients[0]})
        top = min(self.top, self.low * len(coefficients))
        total = GeneralisedSeries({})
        for coefficient in reversed(coefficients):
            total = total * self + GeneralisedSeries({(0, 0): coefficient}, top)
        return total


_SUPERPOLYNOMIAL = GeneralisedSeries({}, -math.inf)
"""What grows faster than any power."""


def _expand_superpolynomial(node: Expr, parts: list[GeneralisedSeries]) -> GeneralisedSeries:
    """Return a node of what grows faster than any power: that too, or what vanishes faster than any."""
    others = [part for part in parts if part is not _SUPERPOLYNOMIAL]
    if node.is_Pow and node.exp.is_negative:
        return GeneralisedSeries({})
    if len(others) < len(parts) - 1 or not (node.is_Add or node.is_Mul or (node.is_Pow and node.exp.is_positive)):
        raise NotAnalytic(f"{node} grows in ways that may cancel")
    if node.is_Mul:
        for part in others:
            _ = part.leading  # a factor that may be 0 is refused
    return _SUPERPOLYNOMIAL


class _GeneralExpansion(ExpansionAlgebra[GeneralisedSeries]):
    """The algebra of generalised series in x = v, or in x = 1/v far out."""

    def __init__(self, point: Substitution, unit: int, far: bool) -> None:
        super().__init__(point, GeneralisedSeries({(-unit if far else unit, 0): arb(1)}), _SERIES_TERMS)
        self.unit = unit
        self.far = far

    def __call__(self, node: Expr, parts: list[GeneralisedSeries]) -> GeneralisedSeries:
        if any(part is _SUPERPOLYNOMIAL for part in parts):
            return _expand_superpolynomial(node, parts)
        return super().__call__(node, parts)

    def power(self, base: GeneralisedSeries, exponent: Expr) -> GeneralisedSeries:
        if not base.terms and base.top == math.inf and exponent.is_positive:
            return base  # what is smaller than any power
        return super().power(base, exponent)

    def function(self, known: Function, inner: GeneralisedSeries) -> GeneralisedSeries:
        grows = inner.low < 0
        if known.kind is sp.log and (grows or (0, 0) not in inner.terms):
            return self._logarithm(inner)
        if grows:
            return self._far_function(known, inner)
        return super().function(known, inner)

    def _logarithm(self, inner: GeneralisedSeries) -> GeneralisedSeries:
        """Return the logarithm of what vanishes with x, or grows."""
        low = int(inner.low)
        first = inner.leading
        if not first > 0:
            raise NotAnalytic("a logarithm of what is negative")
        whole = GeneralisedSeries({(0, 0): first.log(), (0, 1): arb(rational(sp.Rational(low, self.unit)))})
        rest = inner.without_first().scaled(1 / first, -low)
        return whole + rest.inserted_in(self.coefficients(sp.log, arb(1)))

    def _far_function(self, known: Function, inner: GeneralisedSeries) -> GeneralisedSeries:
        """Return a function of what grows without bound: far out, or exp(-1/v) near rest."""
        kind = known.kind
        positive = bool(inner.leading > 0)
        if not self.far and kind is not sp.exp:
            raise NotAnalytic(f"{known.name} has an essential singularity")
        if kind is sp.atan:
            quarter = GeneralisedSeries({(0, 0): (arb.pi() if positive else -arb.pi()) / 2})
            return quarter + self.function(known, self.power(inner, sp.S.NegativeOne)).scaled(arb(-1))
        if kind is Erfcx and positive:
            coefficients = [arb(rational(c)) for c in Erfcx.far_coefficients(_SERIES_TERMS)]
            return self.power(inner, sp.S.NegativeOne).inserted_in(coefficients).scaled(1 / arb.pi().sqrt())
        if kind is sp.exp and positive:
            return _SUPERPOLYNOMIAL
        limit = _LIMITS.get(kind, (None, None))[positive]
        if limit is None:
            raise NotAnalytic(f"{known.name} has no limit")
        return self.v.constant(arb(limit))


def expanded(slope: Expr, point: Substitution, unit: int, *, far: bool) -> GeneralisedSeries:
    """Return the series of a slope at rest, or in 1/v far out; the exponents are in units of 1/`unit`."""
    try:
        series = fold(write_erfcx(elementary(slope)), _GeneralExpansion(point, unit, far))
    except (InputError, ValueError, ZeroDivisionError, OverflowError) as failure:
        raise NotAnalytic(str(failure)) from None
    if series is _SUPERPOLYNOMIAL:
        raise NotAnalytic("it grows faster than any power")
    return series


def common_denominator(slope: Expr, point: Substitution, criterion: Criterion) -> int:
    """Return the common denominator of all exponents in the series of a slope and of its average."""
    exponents = [node.exp.xreplace(dict(point)) for node in slope.atoms(sp.Pow)]
    denominators = [int(exponent.q) for exponent in exponents if exponent.is_Rational]
    return math.prod(denominators) * (1 if criterion.weight is None or criterion.is_polynomial else 2)


@lru_cache(maxsize=16)
def _mean_power(criterion: Criterion) -> Callable[[arb], arb]:
    exponent = sp.Dummy()
    with working_precision(_WORKING_BITS):
        function = ball_function(criterion.mean_power(exponent), exponent, {})
    return lambda e: function(acb(e), False).real


def _means(criterion: Criterion, exponent: arb) -> tuple[arb, arb]:
    """Return the finite part of <p^e>, p = 1 + s, and of <p^e log(p)>."""
    if criterion.weight is None:
        return arb(1), arb(0)
    with working_precision(_WORKING_BITS):
        mean = _mean_power(criterion)
        low, high, lower, higher = (mean(exponent + k * NEGLIGIBLE) for k in (-1, 1, -2, 2))
        # Of A/e + B + C e, e being the distance from the exponent, B and C.
        return ((low + high) / 2).mid(), ((2 * (higher - lower) - (high - low)) / (6 * NEGLIGIBLE)).mid()


def average_near_rest(series: GeneralisedSeries, criterion: Criterion, unit: int) -> GeneralisedSeries:
    """Return F(r) = -<g'(r (1 + s))> for small r."""
    terms: Powers = {}
    for (e, n), c in series.terms.items():
        mean, beside = _means(criterion, arb(e) / unit)
        if n > 1:
            raise NotAnalytic("a power of a logarithm")
        _add(terms, (e, n), -c * mean)
        if n:
            _add(terms, (e, 0), -c * beside)
    return GeneralisedSeries.of(terms, series.top)


def far_out(
    series: GeneralisedSeries, criterion: Criterion, unit: int, end: arb, weight: list[arb], moments: list[arb]
) -> GeneralisedSeries:
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
            raise NotAnalytic("a power of a logarithm")
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
    return GeneralisedSeries.of(terms, series.top)


def _add(terms: Powers, key: tuple[int, int], value: arb) -> None:
    terms[key] = terms[key] + value if key in terms else value
