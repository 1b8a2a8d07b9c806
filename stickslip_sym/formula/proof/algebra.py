"""Exact arithmetic with square roots and special functions of one variable, their derivatives and their series.

An expression becomes a polynomial in generators over the field of rational functions of the variable and the
parameters: one generator for each square root, whose square is reduced, for each constant, and for each special
function, whose derivative is a combination of generators. What comes out as the polynomial 0 is the function 0;
the converse is not claimed. Laurent series at 0 have coefficients in the constants of such an algebra.
"""

from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import add, mul

import sympy as sp
from sympy.polys.rings import PolyElement

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.deadline import check_time

__all__ = ["Algebra", "Element", "Expansion"]

_GENERATORS = 20  # square roots, functions and constants that one formula may hold


class Element:
    """A polynomial in the generators of an algebra."""

    __slots__ = ("algebra", "polynomial")

    def __init__(self, algebra: "Algebra", polynomial: PolyElement) -> None:
        self.algebra, self.polynomial = algebra, polynomial

    def __add__(self, other: "Element") -> "Element":
        return Element(self.algebra, self.polynomial + other.polynomial)

    def __sub__(self, other: "Element") -> "Element":
        return Element(self.algebra, self.polynomial - other.polynomial)

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
        ring, slopes = self.algebra.ring, self.algebra.slopes
        variable = self.algebra.field.gens[0]
        terms = {m: d for m, c in self.polynomial.items() if (d := c.diff(variable)) != 0}
        total = Element(self.algebra, ring.from_dict(terms))
        for generator, slope in zip(ring.gens, slopes, strict=False):
            if slope and (part := self.polynomial.diff(generator)) != 0:
                total += Element(self.algebra, part) * slope
        return total


class Algebra:
    """The formulas in one variable and some parameters."""

    def __init__(self, variable: Expr, parameters: Sequence[Expr]) -> None:
        self.variable, self.symbols = variable, {variable, *parameters, sp.pi}
        self.field = sp.QQ.frac_field(variable, *parameters, sp.pi)
        self.ring = sp.ring([f"g{i}" for i in range(_GENERATORS)], self.field)[0]
        self.slopes: list[Element] = []  # the derivatives of the generators in use
        self._meanings: dict[PolyElement, Expr] = {}  # of the generators of constants
        self._squares: dict[int, PolyElement] = {}
        self._seen: dict[Expr, Element] = {}
        self._families: dict[Hashable, list[Element]] = {}

    # -- generators --------------------------------------------------------------------------------

    def _new(self, square: PolyElement | None = None) -> Element:
        index = len(self.slopes)
        if index == _GENERATORS:
            raise ValueError(f"the formula holds more than {_GENERATORS} square roots and functions")
        self.slopes.append(Element(self, self.ring.zero))
        if square is not None:
            self._squares[index] = square
        return Element(self, self.ring.gens[index])

    def _constant(self, meaning: Expr, square: PolyElement | None = None) -> Element:
        if meaning.has(sp.oo, sp.zoo, sp.nan):
            raise ValueError("a constant is not finite")
        element = self._new(square)
        self._meanings[element.polynomial] = meaning
        return element

    def _family(
        self,
        key: Hashable,
        count: int,
        slopes: Callable[..., Sequence[Element]],
        square: PolyElement | None = None,
    ) -> list[Element]:
        """Return the generators of functions that are closed under derivatives, from the first time on."""
        if key not in self._families:
            first = len(self.slopes)
            self._families[key] = functions = [self._new(square) for _ in range(count)]
            self.slopes[first : first + count] = slopes(*functions)
        return self._families[key]

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
                above, a = above * conjugate, a * conjugate
        if not a or not a.polynomial.is_ground:
            raise ValueError("a denominator is zero, or holds special functions")
        return Element(self, above.polynomial.mul_ground(1 / a.polynomial.coeff(1)))

    def expression(self, a: Element) -> Expr:
        """Return a polynomial in generators of constants as an expression."""
        total = sp.Integer(0)
        for monomial, coefficient in a.polynomial.items():
            term = self.field.to_sympy(coefficient)
            for generator, power in zip(self.ring.gens, monomial, strict=True):
                if power:
                    term *= self._meanings[generator] ** power
            total += term
        return sp.factor(total)

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
            return self._constant(expr)
        if expr.is_Pow and not expr.exp.has(self.variable):
            base, exponent = self.of(expr.base), self.of(expr.exp)
            return self._family(expr, 1, lambda power: [exponent * base.derivative / base * power])[0]
        rule = _FUNCTIONS.get(expr.func)
        if rule is None:
            raise ValueError(f"no differential equation of {expr.func.__name__} is known here")
        return rule(self, expr, *expr.args)

    def root(self, base: Expr, index: int) -> Element:
        """Return the positive square root, or the fourth, which is the square root of the square root."""
        if not base.has(self.variable):
            return self.root_of_constant(self.of(base), index)
        square = self.of(base) if index == 2 else self.root(base, index // 2)
        half = square.derivative / (square + square)
        return self._family(("root", base, index), 1, lambda root: [half * root], square.polynomial)[0]

    def root_of_constant(self, a: Element, index: int = 2) -> Element:
        """Return the positive root of a positive constant, as the product of those of its factors."""
        root = sp.root(self.expression(a), index)
        if not root.is_positive:
            raise ValueError(f"{root**index} is not known to be positive")
        result = self.of(sp.S.One)
        for factor in sp.Mul.make_args(root):
            base, exponent = factor.as_base_exp()
            for prime, times in sp.factorint(base).items() if base.is_Integer else [(base, 1)]:
                power, of = times * exponent, sp.sympify(prime)
                part = self.of(of) if power.is_Integer else self._root_of_factor(of, power.q)
                result *= part ** int(power.p)
        return result

    def _root_of_factor(self, base: Expr, index: int) -> Element:
        if index not in (2, 4):
            raise ValueError(f"no {index}th roots are known here")
        meaning = sp.root(base, index)
        if meaning not in self._seen:
            square = self.of(base) if index == 2 else self._root_of_factor(base, 2)
            self._seen[meaning] = self._constant(meaning, square.polynomial)
        return self._seen[meaning]

    # -- special functions -------------------------------------------------------------------------

    def _primitive(self, expr: Expr, z: Expr) -> Element:
        """A function whose derivative holds no further one of its kind."""
        x = sp.Dummy()
        slope = self.of(expr.func(x).diff(x).subs(x, z)) * self.of(z).derivative
        return self._family(expr, 1, lambda value: [slope])[0]

    def _exponential(self, expr: Expr, z: Expr) -> Element:
        slope = self.of(z).derivative
        return self._family(expr, 1, lambda value: [slope * value])[0]

    def _circular(self, expr: Expr, z: Expr) -> Element:
        slope, minus = self.of(z).derivative, self.of(sp.S.NegativeOne)
        both = self._family(("circle", z), 2, lambda sine, cosine: [slope * cosine, minus * slope * sine])
        return both[expr.func is sp.cos]

    def _bessel(self, expr: Expr, order: Expr, z: Expr) -> Element:
        if order not in (0, 1):  # J_(k+1) = 2 k J_k/z - J_(k-1)
            return self.of(sp.expand_func(expr))
        inner, sign = self.of(z), self.of(sp.S.One if expr.func is sp.besseli else sp.S.NegativeOne)
        slope = inner.derivative
        both = self._family(
            (expr.func, z), 2, lambda zero, one: [sign * slope * one, slope * (zero - one / inner)]
        )
        return both[int(order)]

    def _hypergeometric(self, expr: Expr, upper: Expr, lower: Expr, z: Expr) -> Element:
        """The generators are F, theta F, theta^2 F, ..., theta = z d/dz."""
        if len(upper) == 1 and not lower:
            return self.of((1 - z) ** -upper[0])
        inner = self.of(z)
        rate = inner.derivative / inner
        raised = next((a for a in upper if a + 1 in lower), None)
        if raised is not None:
            # (theta + a) F(a, ...; a + 1, ...; z) = a F(...; ...; z): of one order less than it seems.
            above, below = list(upper), list(lower)
            above.remove(raised)
            below.remove(raised + 1)
            less = self.of(sp.hyper(above, below, z))
            return self._family(expr, 1, lambda value: [self.of(raised) * rate * (less - value)])[0]
        t = sp.Dummy("t")
        left = sp.Poly(t * sp.prod([t + b - 1 for b in lower]), t)
        right = sp.Poly(sp.prod([t + a for a in upper]), t)
        order = left.degree()
        if right.degree() > order:
            raise ValueError("the hypergeometric series does not converge")
        # of sum_k row_k theta^k F = 0
        row = [inner * self.of(right.nth(k)) - self.of(left.nth(k)) for k in range(order + 1)]

        def slopes(*functions: Element) -> list[Element]:
            highest = reduce(add, map(mul, row, functions)) * self.of(sp.S.NegativeOne) / row[-1]
            return [rate * function for function in (*functions[1:], highest)]

        return self._family(expr, order, slopes)[0]

    def _elliptic(self, expr: Expr, m: Expr) -> Element:
        inner, one = self.of(m), self.of(sp.S.One)
        rate = inner.derivative / (inner + inner)
        both = self._family(("elliptic", m), 2, lambda e, k: [rate * (e - k), rate * (e / (one - inner) - k)])
        return both[expr.func is sp.elliptic_k]

    def _third_kind(self, expr: Expr, n: Expr, m: Expr) -> Element:
        e, k = self.of(sp.elliptic_e(m)), self.of(sp.elliptic_k(m))
        n, m = self.of(n), self.of(m)
        one, apart = self.of(sp.S.One), m - n

        def slopes(value: Element) -> list[Element]:
            by_n = (e + (apart * k + (n * n - m) * value) / n) / ((apart + apart) * (n - one))
            by_m = (e / (one - m) - value) / (apart + apart)
            return [n.derivative * by_n + m.derivative * by_m]

        return self._family(expr, 1, slopes)[0]


_FUNCTIONS: dict[type[Expr], Callable[..., Element]] = {
    **dict.fromkeys((sp.log, sp.atan, sp.asinh, sp.erf), Algebra._primitive),
    **dict.fromkeys((sp.sin, sp.cos), Algebra._circular),
    **dict.fromkeys((sp.besseli, sp.besselj), Algebra._bessel),
    **dict.fromkeys((sp.elliptic_e, sp.elliptic_k), Algebra._elliptic),
    sp.exp: Algebra._exponential,
    sp.hyper: Algebra._hypergeometric,
    sp.elliptic_pi: Algebra._third_kind,
}


# -- Laurent series ---------------------------------------------------------------------------------

_HALF = sp.Rational(1, 2)


@dataclass(frozen=True)
class Series:
    """x^order (c_0 + c_1 x + ...), known as far as the coefficients go; c_0 is not 0, or there are none."""

    order: int
    coefficients: list[Element]

    @classmethod
    def of(cls, order: int, coefficients: Iterable[Element]) -> "Series":
        """Return a series without its leading zeros."""
        found = list(coefficients)
        zeros = next((i for i, c in enumerate(found) if c), len(found))
        return cls(order + zeros, found[zeros:])

    @property
    def known(self) -> int:
        """The first power of x whose coefficient is not known."""
        return self.order + len(self.coefficients)

    def coefficient(self, power: int) -> Element | None:
        """Return the coefficient of a power below `known`, None where the series has not begun."""
        return self.coefficients[power - self.order] if power >= self.order else None

    def __add__(self, other: "Series") -> "Series":
        powers = range(min(self.order, other.order), min(self.known, other.known))
        pairs = ([c for c in (self.coefficient(n), other.coefficient(n)) if c is not None] for n in powers)
        return Series.of(powers.start, [reduce(add, pair) for pair in pairs])

    def __mul__(self, other: "Series") -> "Series":
        count = min(len(self.coefficients), len(other.coefficients))
        left, right = self.coefficients, other.coefficients
        values = [reduce(add, [left[i] * right[n - i] for i in range(n + 1)]) for n in range(count)]
        return Series.of(self.order + other.order, values)


class Expansion:
    """Expressions in `x` as series with `terms` terms, coefficients in the constants of an algebra."""

    def __init__(self, algebra: Algebra, x: Expr, terms: int) -> None:
        self.algebra, self.x, self.terms = algebra, x, terms
        self._seen: dict[Expr, Series] = {}

    def of(self, expr: Expr) -> Series:
        """Return the series; raise ValueError where there is none at 0."""
        if expr not in self._seen:
            self._seen[expr] = self._made(expr)
        return self._seen[expr]

    def _made(self, expr: Expr) -> Series:
        if not expr.has(self.x):
            return self._constant(self.algebra.of(expr))
        if expr == self.x:
            return Series(1, self._constant(self.algebra.of(sp.S.One)).coefficients)
        if expr.is_Add or expr.is_Mul:
            return reduce(add if expr.is_Add else mul, map(self.of, expr.args))
        if isinstance(expr, sp.exp | sp.sin | sp.cos) and expr.args[0].is_Add:
            expanded = sp.expand(expr, power_exp=True, trig=True)
            if expanded != expr:
                return self.of(expanded)
        if expr.is_Pow and not isinstance(expr, sp.exp):
            return self._power(self.of(expr.base), expr.exp)
        if expr.func in (sp.log, sp.atan, sp.asinh, sp.erf):
            return self._integrated(expr)
        if isinstance(expr, sp.hyper):
            return self._hypergeometric(expr.args[0], expr.args[1], self.of(expr.args[2]))
        if isinstance(expr, sp.elliptic_pi):
            return self._third_kind(*map(self.of, expr.args))
        rule = _AS_HYPERGEOMETRIC.get(expr.func)
        if rule is None:
            raise ValueError(f"the series of {expr.func.__name__} at {self.x} = 0 is not known here")
        return self.of(rule(*expr.args))

    def _constant(self, value: Element) -> Series:
        return Series(0, [value, *[self.algebra.of(sp.S.Zero)] * (self.terms - 1)])

    def _power(self, base: Series, exponent: Expr) -> Series:
        """Return base^p by the series of (1 + x)^p; p an integer, or a half, or base(0) != 0."""
        if not base.coefficients:
            raise ValueError("too many terms of a base cancel")
        order, lead = exponent * base.order, base.coefficients[0]
        if not order.is_Integer:
            raise ValueError(f"a fractional power of {self.x} is no series at {self.x} = 0")
        if exponent.is_Integer:
            front = lead ** int(exponent)
        elif exponent.is_Rational and exponent.q in (2, 4):
            front = self.algebra.root_of_constant(lead, int(exponent.q)) ** int(exponent.p)
        else:
            front = self.algebra.of(self.algebra.expression(lead) ** exponent)
        minus_rest = Series.of(1, [self.algebra.of(sp.S.NegativeOne) * c / lead for c in base.coefficients[1:]])
        series = self._hypergeometric([-exponent], [], minus_rest)
        return Series(int(order), [front * c for c in series.coefficients])

    def _hypergeometric(self, upper: Sequence[Expr], lower: Sequence[Expr], z: Series) -> Series:
        """Return the sum of (upper)_k/(lower)_k z^k/k! for a series z that vanishes at 0."""
        if z.order < 1:
            raise ValueError("a function is needed at another place than 0")
        value, power = sp.S.One, self._constant(self.algebra.of(sp.S.One))
        total = power
        for k in range(1, self.terms):
            power *= z
            if not power.coefficients or power.order >= self.terms:
                break
            value *= sp.Mul(*[a + k - 1 for a in upper]) / sp.Mul(*[b + k - 1 for b in lower]) / k
            total += self._constant(self.algebra.of(value)) * power
        return total

    def _integrated(self, expr: Expr) -> Series:
        """Return f(z) = f(z(0)) + the integral of its derivative."""
        inner, slope = self.of(expr.args[0]), self.of(sp.diff(expr, self.x))
        if slope.order < 0 and slope.coefficients:
            raise ValueError(f"{expr} is infinite at {self.x} = 0")
        if inner.order < 0 or inner.known < 1:
            raise ValueError(f"{expr} is not known at {self.x} = 0")
        start = inner.coefficient(0)
        front = expr.func(sp.S.Zero if start is None else self.algebra.expression(start))
        grown = [c / self.algebra.of(sp.Integer(n)) for n, c in enumerate(slope.coefficients, slope.order + 1)]
        return self._constant(self.algebra.of(front)) + Series(slope.order + 1, grown)

    def _third_kind(self, n: Series, m: Series) -> Series:
        """pi/2 sum over k and j of n^k m^j (1/2)_j (1/2)_(k+j)/(j! (k+j)!)."""
        if n.order < 1:
            raise ValueError("elliptic_pi is needed at another place than 0")
        total, power = self._constant(self.algebra.of(sp.S.Zero)), self._constant(self.algebra.of(sp.S.One))
        for k in range(self.terms):
            front = self.algebra.of(sp.pi / 2 * sp.rf(_HALF, k) / sp.factorial(k))
            series = self._hypergeometric([_HALF, _HALF + k], [sp.Integer(1 + k)], m)
            total += self._constant(front) * power * series
            power *= n
            if power.order >= self.terms:
                break
        return total


def _of_bessel(sign: int) -> Callable[[Expr, Expr], Expr]:
    return lambda n, z: (z / 2) ** n / sp.factorial(n) * sp.hyper((), (n + 1,), sign * z**2 / 4)


_AS_HYPERGEOMETRIC: dict[type[Expr], Callable[..., Expr]] = {
    sp.exp: lambda z: sp.hyper((), (), z),
    sp.cos: lambda z: sp.hyper((), (_HALF,), -(z**2) / 4),
    sp.sin: lambda z: z * sp.hyper((), (3 * _HALF,), -(z**2) / 4),
    sp.besseli: _of_bessel(1),
    sp.besselj: _of_bessel(-1),
    sp.elliptic_k: lambda m: sp.pi / 2 * sp.hyper((_HALF, _HALF), (1,), m),
    sp.elliptic_e: lambda m: sp.pi / 2 * sp.hyper((-_HALF, _HALF), (1,), m),
}
