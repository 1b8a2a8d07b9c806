"""Exact arithmetic with square roots and special functions of one variable, their derivatives included.

An expression becomes a polynomial in generators over the field of rational functions of the variable and the
parameters: one generator for each square root, whose square is reduced, and for each special function, whose
derivative is a combination of generators. What comes out as the polynomial 0 is the function 0; the converse is
not claimed.
"""

from collections.abc import Sequence
from functools import reduce

import sympy as sp
from sympy.polys.rings import PolyElement

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.deadline import check_time

__all__ = ["Algebra", "Differential"]

_GENERATORS = 20  # square roots, functions and constants that one formula may hold


class Algebra:
    """The polynomials in the generators of one formula; constants get their generators here."""

    def __init__(self, variable: Expr, parameters: Sequence[Expr]) -> None:
        self.variable = variable
        self.field = sp.QQ.frac_field(variable, *parameters)
        self.ring = sp.ring([f"g{i}" for i in range(_GENERATORS)], self.field)[0]
        self.parameters = set(parameters)
        self.derivatives: list[PolyElement] = []  # of the generators in use
        self.named: dict[Expr, PolyElement] = {}
        self.meanings: dict[Expr, Expr] = {}  # what the generators of constants stand for
        self._squares: dict[int, PolyElement] = {}

    def new(self, square: PolyElement | None = None) -> PolyElement:
        """Return an unused generator, with derivative 0 for now."""
        index = len(self.derivatives)
        if index == _GENERATORS:
            raise ValueError(f"the formula holds more than {_GENERATORS} square roots and functions")
        self.derivatives.append(self.ring.zero)
        if square is not None:
            self._squares[index] = square
        return self.ring.gens[index]

    def scalar(self, value: Expr) -> PolyElement:
        """Return a rational expression in the variable and the parameters."""
        return self.ring.ground_new(self.field.from_sympy(sp.sympify(value)))

    def product(self, a: PolyElement, b: PolyElement) -> PolyElement:
        """Multiply, with squares of square roots reduced."""
        check_time()
        result = a * b
        for index in reversed(self._squares):
            parts: dict[int, PolyElement] = {}
            for monomial, coefficient in result.items():
                twice, once = divmod(monomial[index], 2)
                place = (*monomial[:index], once, *monomial[index + 1 :])
                parts.setdefault(twice, self.ring.zero)[place] = coefficient
            if set(parts) - {0}:
                square = self._squares[index]
                result = sum((part * square**twice for twice, part in parts.items()), self.ring.zero)
        return result

    def inverse(self, a: PolyElement) -> PolyElement:
        """Return 1/a, by conjugates with respect to each square root."""
        above = self.ring.one
        for index in reversed(self._squares):
            if any(monomial[index] for monomial in a):
                conjugate = a.compose(self.ring.gens[index], -self.ring.gens[index])
                above, a = self.product(above, conjugate), self.product(a, conjugate)
        if not a.is_ground or a == 0:
            raise ValueError("a denominator is zero, or holds special functions")
        return above.mul_ground(1 / a.coeff(1))

    def constant(self, expr: Expr) -> PolyElement:
        """Return an expression without the variable."""
        if expr in self.named:
            return self.named[expr]
        if expr.is_Rational or expr in self.parameters:
            value = self.scalar(expr)
        elif expr.is_Add:
            value = sum((self.constant(argument) for argument in expr.args), self.ring.zero)
        elif expr.is_Mul:
            value = reduce(self.product, map(self.constant, expr.args))
        elif expr.is_Pow and expr.exp.is_Integer:
            value = self.power(self.constant(expr.base), int(expr.exp))
        elif expr.is_Pow and expr.exp.is_Rational and expr.exp.q in (2, 4):
            value = self.power(self.root_of_constant(self.constant(expr.base), expr.exp.q), int(expr.exp.p))
        else:
            if expr.has(sp.oo, sp.zoo, sp.nan):
                raise ValueError("a constant is not finite")
            value = self.new()
            self.meanings[value] = expr
        self.named[expr] = value
        return value

    def power(self, a: PolyElement, n: int) -> PolyElement:
        """Return a^n, n an integer."""
        return reduce(self.product, [self.inverse(a) if n < 0 else a] * abs(n), self.ring.one)

    def expression(self, a: PolyElement) -> Expr:
        """Return a polynomial in generators of constants as an expression."""
        total = sp.Integer(0)
        for monomial, coefficient in a.items():
            term = self.field.to_sympy(coefficient)
            for generator, power in zip(self.ring.gens, monomial, strict=True):
                if power:
                    term *= self.meanings[generator] ** power
            total += term
        return sp.factor(total)

    def root_of_constant(self, a: PolyElement, index: int = 2) -> PolyElement:
        """Return the positive square root, or the fourth, of a positive constant."""
        root = sp.root(self.expression(a), index)
        if not root.is_positive:
            raise ValueError(f"{root**index} is not known to be positive")
        result = self.ring.one
        for factor in sp.Mul.make_args(root):
            base, exponent = factor.as_base_exp()
            for prime, times in sp.factorint(base).items() if base.is_Integer else [(base, 1)]:
                power, of = times * exponent, sp.sympify(prime)
                part = self.constant(of) if power.is_Integer else self._root(of, power.q)
                result = self.product(result, self.power(part, int(power.p)))
        return result

    def _root(self, base: Expr, index: int) -> PolyElement:
        """Return the generator of a root of an expression without a rational root."""
        if index not in (2, 4):
            raise ValueError(f"a root of order {index} is not known here")
        root = sp.root(base, index)
        if root not in self.named:
            square = self.constant(base) if index == 2 else self._root(base, 2)
            self.named[root] = self.new(square)
            self.meanings[self.named[root]] = root
        return self.named[root]


class Differential:
    """Expressions in the variable as polynomials in generators, and their derivatives."""

    def __init__(self, algebra: Algebra) -> None:
        self.algebra = algebra
        self._known: dict[Expr, PolyElement] = {}

    def of(self, expr: Expr) -> PolyElement:
        """Return an expression; raise ValueError where it holds what is not known here."""
        algebra = self.algebra
        if not expr.has(algebra.variable):
            return algebra.constant(expr)
        if expr == algebra.variable:
            return algebra.scalar(expr)
        if expr not in self._known:
            self._known[expr] = self._made(expr)
        return self._known[expr]

    def _made(self, expr: Expr) -> PolyElement:
        algebra = self.algebra
        if expr.is_Add:
            return sum((self.of(argument) for argument in expr.args), algebra.ring.zero)
        if expr.is_Mul:
            return reduce(algebra.product, map(self.of, expr.args))
        if expr.is_Pow and expr.exp.is_Integer:
            return algebra.power(self.of(expr.base), int(expr.exp))
        if expr.is_Pow and expr.exp.is_Rational and expr.exp.q in (2, 4):
            return algebra.power(self._root(expr.base, expr.exp.q), int(expr.exp.p))
        return self._function(expr)

    def _root(self, base: Expr, index: int) -> PolyElement:
        """Return the positive root; the fourth is the square root of the square root."""
        key = ("root", base, index)
        if key not in self._known:
            square = self.of(base) if index == 2 else self._root(base, index // 2)
            root = self.algebra.new(square)
            half = self.algebra.product(self.derivative(square), self.algebra.inverse(2 * square))
            self._set(root, half * root)
            self._known[key] = root
        return self._known[key]

    def _function(self, expr: Expr) -> PolyElement:
        kind, arguments = expr.func, expr.args
        if kind in (sp.besseli, sp.besselj) and arguments[0] in (0, 1):
            return self._bessel(kind, arguments[1])[int(arguments[0])]
        if kind is sp.hyper:
            return self._hypergeometric(*arguments)
        if kind in (sp.elliptic_e, sp.elliptic_k) and len(arguments) == 1:
            return self._elliptic(arguments[0])[kind is sp.elliptic_k]
        if kind is sp.elliptic_pi and len(arguments) == 2:
            return self._third_kind(*arguments)
        if kind is sp.exp:
            value = self.algebra.new()
            self._set(value, self.derivative(self.of(arguments[0])) * value)
            return value
        if kind in (sp.sin, sp.cos):
            (sine, cosine), fresh = self._family(("circle", arguments[0]), 2)
            if fresh:
                slope = self.derivative(self.of(arguments[0]))
                self._set(sine, slope * cosine)
                self._set(cosine, -slope * sine)
            return sine if kind is sp.sin else cosine
        if kind in (sp.log, sp.atan, sp.asinh, sp.erf):
            inner, value, x = self.of(arguments[0]), self.algebra.new(), sp.Dummy()
            slope = self.of(kind(x).diff(x).subs(x, arguments[0]))
            self._set(value, self.algebra.product(self.derivative(inner), slope))
            return value
        raise ValueError(f"no differential equation of {kind.__name__} is known here")

    def _set(self, generator: PolyElement, derivative: PolyElement) -> None:
        self.algebra.derivatives[self.algebra.ring.gens.index(generator)] = self.algebra.product(
            derivative, self.algebra.ring.one
        )

    def _family(self, key: Expr, count: int) -> tuple[list[PolyElement], bool]:
        """Return the generators of functions that are closed under d/dV, and whether they are new."""
        fresh = key not in self.algebra.named
        if fresh:
            self.algebra.named[key] = [self.algebra.new() for _ in range(count)]
        return self.algebra.named[key], fresh

    def _bessel(self, kind: Expr, z: Expr) -> list[PolyElement]:
        functions, fresh = self._family((kind, z), 2)
        if fresh:
            zero, one = functions
            inner, sign = self.of(z), 1 if kind is sp.besseli else -1
            slope = self.derivative(inner)
            self._set(zero, sign * slope * one)
            self._set(one, self.algebra.product(slope, zero - self.algebra.inverse(inner) * one))
        return functions

    def _hypergeometric(self, upper: Expr, lower: Expr, z: Expr) -> PolyElement:
        """The generators are F, theta F, theta^2 F, ..., theta = z d/dz; F alone if a + 1 is below an a."""
        raised = next((a for a in upper if a + 1 in lower), None)
        if raised is not None:
            return self._raised(upper, lower, z, raised)
        if not lower and len(upper) == 1 and upper[0].is_Rational and upper[0].q in (1, 2, 4):
            return self.of((1 - z) ** -upper[0])
        functions, fresh = self._family((upper, lower, z), len(lower) + 1)
        if fresh:
            t, inner = sp.Dummy("t"), self.of(z)
            left = sp.Poly(t * sp.prod([t + b - 1 for b in lower]), t).all_coeffs()[::-1]
            right = sp.Poly(sp.prod([t + a for a in upper]), t).all_coeffs()[::-1]
            right += [sp.Integer(0)] * (len(left) - len(right))
            if len(right) > len(left):
                raise ValueError("the hypergeometric series does not converge")
            ring, constant = self.algebra.ring, self.algebra.constant
            last = sum(
                (
                    (self.algebra.product(inner, constant(r)) - constant(q)) * f
                    for q, r, f in zip(left[:-1], right[:-1], functions, strict=True)
                ),
                ring.zero,
            )
            highest = self.algebra.inverse(ring.one - self.algebra.product(inner, constant(right[-1])))
            rate = self.algebra.product(self.derivative(inner), self.algebra.inverse(inner))
            for function, following in zip(functions, [*functions[1:], highest * last], strict=True):
                self._set(function, rate * following)
        return functions[0]

    def _raised(self, upper: Expr, lower: Expr, z: Expr, a: Expr) -> PolyElement:
        """(theta + a) F(a, ...; a + 1, ...; z) = a F(...; ...; z): of one order less than it seems."""
        (value,), fresh = self._family((upper, lower, z), 1)
        if fresh:
            above, below = list(upper), list(lower)
            above.remove(a)
            below.remove(a + 1)
            inner, rest = self.of(z), self._hypergeometric(sp.Tuple(*above), sp.Tuple(*below), z)
            rate = self.algebra.product(self.derivative(inner), self.algebra.inverse(inner))
            self._set(value, self.algebra.product(self.algebra.constant(a) * rate, rest - value))
        return value

    def _elliptic(self, m: Expr) -> list[PolyElement]:
        functions, fresh = self._family(("elliptic", m), 2)
        if fresh:
            (e, k), inner = functions, self.of(m)
            rate = self.algebra.product(self.derivative(inner), self.algebra.inverse(2 * inner))
            self._set(e, rate * (e - k))
            self._set(k, rate * (self.algebra.inverse(1 - inner) * e - k))
        return functions

    def _third_kind(self, n: Expr, m: Expr) -> PolyElement:
        (value,), fresh = self._family(("third kind", n, m), 1)
        if fresh:
            (e, k), of_n, of_m = self._elliptic(m), self.of(n), self.of(m)
            inverse, product = self.algebra.inverse, self.algebra.product
            apart = of_m - of_n
            by_n = product(
                inverse(product(2 * apart, of_n - 1)),
                e + product(inverse(of_n), apart * k + (product(of_n, of_n) - of_m) * value),
            )
            by_m = product(inverse(-2 * apart), inverse(of_m - 1) * e + value)
            slopes = product(self.derivative(of_n), by_n) + product(self.derivative(of_m), by_m)
            self._set(value, slopes)
        return value

    def derivative(self, a: PolyElement) -> PolyElement:
        """Return da/dV."""
        algebra = self.algebra
        variable = algebra.field.gens[0]
        total = algebra.ring.from_dict({m: d for m, c in a.items() if (d := c.diff(variable)) != 0})
        for generator, slope in zip(algebra.ring.gens, algebra.derivatives, strict=False):
            if slope != 0 and (part := a.diff(generator)) != 0:
                total += algebra.product(part, slope)
        return total
