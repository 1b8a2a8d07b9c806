"""Exact arithmetic with square roots and special functions of one variable, their derivatives and their series.

An expression becomes a polynomial in generators over the field of rational functions of the variable and the
parameters: one generator for each square root, whose square is reduced, for each constant, and for each special
function, whose derivative by SymPy is a combination of generators again. What comes out as the polynomial 0 is the
function 0; the converse is not claimed. Laurent series at 0 have coefficients in the constants of such an algebra.
"""

from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache, partial, reduce
from operator import add, mul
from typing import NamedTuple

import sympy as sp
from sympy.polys.rings import PolyElement

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.deadline import check_time
from stickslip_sym.core.functions import row

_GENERATORS = 20  # square roots, functions and constants that one formula may hold
_HALF = sp.Rational(1, 2)


class Element:
    """A polynomial in the generators of an algebra."""

    __slots__ = ("algebra", "polynomial")

    def __init__(self, algebra: "Algebra", polynomial: PolyElement) -> None:
        self.algebra = algebra
        self.polynomial = polynomial

    def __add__(self, other: "Element") -> "Element":
        return Element(self.algebra, self.polynomial + other.polynomial)

    def __neg__(self) -> "Element":
        return Element(self.algebra, -self.polynomial)

    def __mul__(self, other: "Element") -> "Element":
        check_time()
        return Element(self.algebra, self.algebra.reduced(self.polynomial * other.polynomial))

    def __truediv__(self, other: "Element") -> "Element":
        return self * other**-1

    def __pow__(self, n: int) -> "Element":
        return reduce(mul, [self.algebra.inverse(self) if n < 0 else self] * abs(n), self.algebra.of(sp.S.One))

    def __bool__(self) -> bool:
        return bool(self.polynomial != 0)

    @property
    def derivative(self) -> "Element":
        """Its derivative by the variable."""
        algebra = self.algebra
        variable = algebra.field.gens[0]
        slopes = {m: c.diff(variable) for m, c in self.polynomial.items()}
        terms = {m: slope for m, slope in slopes.items() if slope != 0}
        total = Element(algebra, algebra.ring.from_dict(terms))
        for generator, slope in algebra.slopes.copy().items():
            if (part := self.polynomial.diff(generator)) != 0:
                total += Element(algebra, part) * slope()
        return total


class Generator(NamedTuple):
    """A generator by name, what it means, and its derivative and its square where it has such, by names."""

    symbol: Expr
    meaning: Expr
    slope: Expr | None
    square: Expr | None


class Algebra:
    """The formulas in one variable and some parameters."""

    def __init__(self, variable: Expr, parameters: Sequence[Expr]) -> None:
        self.variable = variable
        self.symbols = {variable, *parameters, sp.pi}
        self.field = sp.QQ.frac_field(variable, *parameters, sp.pi)
        self.ring = sp.ring([f"g{i}" for i in range(_GENERATORS)], self.field)[0]
        self.slopes: dict[PolyElement, Callable[[], Element]] = {}  # of the generators that are functions
        self._meanings: list[Expr] = []  # of all generators
        self._names: list[Expr] = []
        self._squares: dict[int, PolyElement] = {}
        self._seen: dict[Hashable, Element] = {}

    def _generator(
        self, meaning: Expr, slope: Callable[[], Element] | None = None, square: PolyElement | None = None
    ) -> Element:
        index = len(self._meanings)
        if index == _GENERATORS:
            raise ValueError(f"the formula holds more than {_GENERATORS} square roots and functions")
        if meaning.has(sp.oo, sp.zoo, sp.nan):
            raise ValueError("a constant is not finite")
        self._meanings.append(meaning)
        if square is not None:
            kind = "root"
        elif meaning.is_Mul:
            kind = "theta"
        else:
            kind = meaning.func.__name__
        self._names.append(sp.Symbol(f"{kind}_{index + 1}"))
        generator = self.ring.gens[index]
        if meaning.has(self.variable) and slope is not None:
            self.slopes[generator] = cache(slope)
        if square is not None:
            self._squares[index] = square
        return Element(self, generator)

    # -- arithmetic --------------------------------------------------------------------------------

    def reduced(self, polynomial: PolyElement) -> PolyElement:
        """Reduce the squares of square roots, the last one first: it may be the root of another."""
        for index in reversed(self._squares):
            parts: dict[int, PolyElement] = {}
            for monomial, coefficient in polynomial.items():
                twice, once = divmod(monomial[index], 2)
                place = (*monomial[:index], once, *monomial[index + 1 :])
                parts.setdefault(twice, self.ring.zero)[place] = coefficient
            if set(parts) - {0}:
                square = self._squares[index]
                polynomial = sum((part * square**twice for twice, part in parts.items()), self.ring.zero)
        return polynomial

    def inverse(self, a: Element) -> Element:
        """Return 1/a, by conjugates with respect to each square root."""
        above = self.of(sp.S.One)
        for index in reversed(self._squares):
            if any(monomial[index] for monomial in a.polynomial):
                conjugate = Element(self, a.polynomial.compose(self.ring.gens[index], -self.ring.gens[index]))
                above *= conjugate
                a *= conjugate
        if not a or not a.polynomial.is_ground:
            raise ValueError("a denominator is zero, or holds special functions")
        return Element(self, above.polynomial.mul_ground(1 / a.polynomial.coeff(1)))

    def expression(self, a: Element) -> Expr:
        """Return a polynomial in generators of constants as an expression."""
        return sp.factor(self._with(self._meanings, a.polynomial))

    def _with(self, generators: Sequence[Expr], polynomial: PolyElement) -> Expr:
        terms = [
            sp.Mul(self.field.to_sympy(coefficient), *map(sp.Pow, generators, monomial))
            for monomial, coefficient in polynomial.items()
        ]
        return sp.Add(*terms)

    def by_names(self, a: Element) -> Expr:
        """Return an element with a symbol for each generator."""
        return self._with(self._names, a.polynomial)

    def table(self, elements: Iterable[Element]) -> list[Generator]:
        """Return the generators of which elements and their derivatives consist, in the order of their making."""
        rows: dict[int, Generator] = {}

        def add(polynomial: PolyElement) -> None:
            for index, powers in enumerate(zip(*polynomial, strict=True)):
                if index in rows or not any(powers):
                    continue
                slope = self.slopes.get(self.ring.gens[index])
                square = self._squares.get(index)
                derivative = None if slope is None else slope()
                written = None if derivative is None else self.by_names(derivative)
                squared = None if square is None else self._with(self._names, square)
                rows[index] = Generator(self._names[index], self._meanings[index], written, squared)
                if derivative is not None:
                    add(derivative.polynomial)
                if square is not None:
                    add(square)

        for a in elements:
            add(a.polynomial)
        return [rows[index] for index in sorted(rows)]

    # -- expressions -------------------------------------------------------------------------------

    def of(self, expr: Expr) -> Element:
        """Return an expression; raise ValueError where it holds what is not known here."""
        if expr not in self._seen:
            self._seen[expr] = self._made(expr)
        return self._seen[expr]

    def _made(self, expr: Expr) -> Element:
        if expr.is_Rational or expr in self.symbols:
            return Element(self, self.ring.ground_new(self.field.from_sympy(expr)))
        if expr.is_Add or expr.is_Mul:
            return reduce(add if expr.is_Add else mul, map(self.of, expr.args))
        if expr.is_Pow and expr.exp.is_Integer:
            return self.of(expr.base) ** int(expr.exp)
        if expr.is_Pow and expr.exp.is_Rational and expr.exp.q in (2, 4):
            return self.root(expr.base, int(expr.exp.q)) ** int(expr.exp.p)
        if not expr.has(self.variable):
            return self._generator(expr)
        if expr.is_Pow and not expr.exp.has(self.variable):
            return self._power(expr, expr.base, expr.exp)
        if row(expr) is None:
            raise ValueError(f"no differential equation of {expr.func.__name__} is known here")
        if isinstance(expr, sp.hyper):
            return self._hypergeometric(expr, *expr.args)
        if isinstance(expr, sp.besseli | sp.besselj) and expr.args[0] not in (0, 1):
            return self.of(sp.expand_func(expr))  # J_(k+1) = 2 k J_k/z - J_(k-1)
        return self._generator(expr, lambda: self.of(expr.diff(self.variable)))

    def _power(self, meaning: Expr, base: Expr, exponent: Expr, square: PolyElement | None = None) -> Element:
        def slope() -> Element:
            inner = self.of(base)
            return self.of(exponent) * inner.derivative / inner * power

        power = self._generator(meaning, slope, square)
        return power

    def root(self, base: Expr, index: int) -> Element:
        """Return the positive root of order 2 or 4; of a constant as the product of those of its factors."""
        if base.has(self.variable):
            return self._square_root(base, index)
        root = sp.root(self.expression(self.of(base)), index)
        if not root.is_positive:
            raise ValueError(f"{base} is not known to be positive")
        result = self.of(sp.S.One)
        for factor in sp.Mul.make_args(root):
            inner, exponent = factor.as_base_exp()
            for prime, times in sp.factorint(inner).items() if inner.is_Integer else [(inner, 1)]:
                power = times * exponent
                result *= self._square_root(sp.sympify(prime), int(power.q)) ** int(power.p)
        return result

    def _square_root(self, base: Expr, index: int) -> Element:
        """Return the positive root of order 1, 2 or 4, the last as the square root of the square root."""
        if index == 1:
            return self.of(base)
        if index not in (2, 4):
            raise ValueError(f"no {index}th roots are known here")
        if (base, index) not in self._seen:
            square = self._square_root(base, index // 2)
            exponent = sp.Rational(1, index)
            self._seen[base, index] = self._power(base**exponent, base, exponent, square.polynomial)
        return self._seen[base, index]

    def _hypergeometric(self, expr: Expr, upper: Sequence[Expr], lower: Sequence[Expr], z: Expr) -> Element:
        """Return F, of the generators F, theta F, theta^2 F, ..., theta = z d/dz."""
        if len(upper) == 1 and not lower:
            return self.of((1 - z) ** -upper[0])
        inner = self.of(z)
        rate = inner.derivative / inner
        raised = next((a for a in upper if a + 1 in lower), None)
        if raised is not None:
            # (theta + a) F(a, ...; a + 1, ...; z) = a F(...; ...; z): of one order less than it seems.
            above = list(upper)
            below = list(lower)
            above.remove(raised)
            below.remove(raised + 1)
            less = sp.hyper(above, below, z)
            value = self._generator(expr, lambda: self.of(raised) * rate * (self.of(less) + -value))
            return value
        t = sp.Dummy("t")
        left = sp.Poly(t * sp.prod([t + b - 1 for b in lower]), t)
        right = sp.Poly(sp.prod([t + a for a in upper]), t)
        order = left.degree()
        if right.degree() > order:
            raise ValueError("the hypergeometric series does not converge")
        # sum_k equation_k theta^k F = 0
        equation = [inner * self.of(right.nth(k)) + -self.of(left.nth(k)) for k in range(order + 1)]

        def slope(k: int) -> Element:
            if k + 1 < order:
                return rate * functions[k + 1]
            lower: Element = reduce(add, map(mul, equation, functions))
            return -rate * lower / equation[-1]

        meanings = [expr]
        for _ in range(order - 1):
            meanings.append(z * sp.diff(meanings[-1], self.variable) / sp.diff(z, self.variable))
        functions = [self._generator(meaning, partial(slope, k)) for k, meaning in enumerate(meanings)]
        return functions[0]


# -- Laurent series ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class LaurentSeries:
    """x^order (c_0 + c_1 x + ...), known as far as the coefficients go; c_0 is not 0, or there are none."""

    order: int
    coefficients: list[Element]

    @classmethod
    def of(cls, order: int, coefficients: Iterable[Element]) -> "LaurentSeries":
        """Return a series without its leading zeros."""
        elements = list(coefficients)
        zeros = next((i for i, c in enumerate(elements) if c), len(elements))
        return cls(order + zeros, elements[zeros:])

    @property
    def known(self) -> int:
        """The first power of x whose coefficient is not known."""
        return self.order + len(self.coefficients)

    def coefficient(self, power: int) -> Element | None:
        """Return the coefficient of a power below `known`, None where the series has not begun."""
        if power >= self.order:
            return self.coefficients[power - self.order]
        return None

    def __add__(self, other: "LaurentSeries") -> "LaurentSeries":
        powers = range(min(self.order, other.order), min(self.known, other.known))
        pairs = ([c for c in (self.coefficient(n), other.coefficient(n)) if c is not None] for n in powers)
        return LaurentSeries.of(powers.start, [reduce(add, pair) for pair in pairs])

    def __mul__(self, other: "LaurentSeries") -> "LaurentSeries":
        count = min(len(self.coefficients), len(other.coefficients))
        left = self.coefficients
        right = other.coefficients
        values = [reduce(add, [left[i] * right[n - i] for i in range(n + 1)]) for n in range(count)]
        return LaurentSeries.of(self.order + other.order, values)


class SeriesExpansion:
    """Expressions in `x` as series with `terms` terms, coefficients in the constants of an algebra."""

    def __init__(self, algebra: Algebra, x: Expr, terms: int) -> None:
        self.algebra = algebra
        self.x = x
        self.terms = terms
        self._seen: dict[Expr, LaurentSeries] = {}

    def of(self, expr: Expr) -> LaurentSeries:
        """Return the series; raise ValueError where there is none at 0."""
        if expr not in self._seen:
            self._seen[expr] = self._made(expr)
        return self._seen[expr]

    def _made(self, expr: Expr) -> LaurentSeries:
        if not expr.has(self.x):
            return self._constant(expr)
        if expr == self.x:
            return LaurentSeries(1, self._constant(sp.S.One).coefficients)
        if expr.is_Add or expr.is_Mul:
            return reduce(add if expr.is_Add else mul, map(self.of, expr.args))
        if isinstance(expr, sp.exp | sp.sin | sp.cos) and expr.args[0].is_Add:
            expanded = sp.expand(expr, power_exp=True, trig=True)
            if expanded != expr:
                return self.of(expanded)
        if expr.is_Pow and not isinstance(expr, sp.exp):
            return self._power(self.of(expr.base), expr.exp)
        if isinstance(expr, sp.hyper):
            return self._hypergeometric(expr.args[0], expr.args[1], self.of(expr.args[2]))
        if isinstance(expr, sp.elliptic_pi):
            return self._third_kind(*expr.args)
        if (known := row(expr)) is not None and known.hypergeometric is not None:
            return self.of(known.hypergeometric(*expr.args))
        return self._integrated(expr)

    def _constant(self, value: Expr) -> LaurentSeries:
        return LaurentSeries(0, [self.algebra.of(value), *[self.algebra.of(sp.S.Zero)] * (self.terms - 1)])

    def _power(self, base: LaurentSeries, exponent: Expr) -> LaurentSeries:
        """Return base^p by the series of (1 + x)^p; p an integer, or a half, or base(0) != 0."""
        if not base.coefficients:
            raise ValueError("too many terms of a base cancel")
        order = exponent * base.order
        lead = base.coefficients[0]
        if not order.is_Integer:
            raise ValueError(f"a fractional power of {self.x} is no series at {self.x} = 0")
        if exponent.is_Integer:
            front = lead ** int(exponent)
        else:
            front = self.algebra.of(self.algebra.expression(lead) ** exponent)
        minus_rest = LaurentSeries.of(1, [-c / lead for c in base.coefficients[1:]])
        series = self._hypergeometric([-exponent], [], minus_rest)
        return LaurentSeries(int(order), [front * c for c in series.coefficients])

    def _hypergeometric(self, upper: Sequence[Expr], lower: Sequence[Expr], z: LaurentSeries) -> LaurentSeries:
        """Return the sum of (upper)_k/(lower)_k z^k/k! for a series z that vanishes at 0."""
        if z.order < 1:
            raise ValueError("a function is needed at another place than 0")
        value = sp.S.One
        power = self._constant(sp.S.One)
        total = power
        for k in range(1, self.terms):
            power *= z
            if not power.coefficients or power.order >= self.terms:
                break
            value *= sp.Mul(*[a + k - 1 for a in upper]) / sp.Mul(*[b + k - 1 for b in lower]) / k
            total += self._constant(value) * power
        return total

    def _integrated(self, expr: Expr) -> LaurentSeries:
        """Return f(z) = f(z(0)) + the integral of its derivative, of other functions than f."""
        slope = sp.diff(expr, self.x)
        if len(expr.args) > 1 or slope.has(expr.func):
            raise ValueError(f"the series of {expr.func.__name__} at {self.x} = 0 is not known here")
        inner = self.of(expr.args[0])
        series = self.of(slope)
        if series.order < 0 and series.coefficients:
            raise ValueError(f"{expr} is infinite at {self.x} = 0")
        if inner.order < 0 or inner.known < 1:
            raise ValueError(f"{expr} is not known at {self.x} = 0")
        start = inner.coefficient(0)
        front = expr.func(sp.S.Zero if start is None else self.algebra.expression(start))
        grown = [c / self.algebra.of(sp.Integer(n)) for n, c in enumerate(series.coefficients, series.order + 1)]
        return self._constant(front) + LaurentSeries(series.order + 1, grown)

    def _third_kind(self, n: Expr, m: Expr) -> LaurentSeries:
        """Return Pi(n, m) as a power series in n: pi/2 sum_k n^k (1/2)_k/k! 2F1(1/2, k + 1/2; k + 1; m)."""
        if self.of(n).order < 1:
            raise ValueError("elliptic_pi is needed at another place than 0")
        return self.of(sp.Add(*[
            sp.pi / 2 * n**k * sp.rf(_HALF, k) / sp.factorial(k) * sp.hyper((_HALF, k + _HALF), (k + 1,), m)
            for k in range(self.terms)
        ]))  # fmt: skip
