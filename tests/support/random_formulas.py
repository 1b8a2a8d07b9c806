"""Random expressions of every node that formulas of this package can have, and their values by mpmath.

`value` shares nothing with the printers: it walks the tree. A draw is kept if every part of it is real at its
point and it is well conditioned there, so that what is printed of it can be compared in double precision.
"""

import mpmath
import sympy as sp
from sympy.codegen.cfunctions import expm1, log1p

from stickslip_sym.core.special import Lerch

NAMES = (
    "V", "N", "v", "a", "b", "w", "v_0", "mu_s", "mu_m", "alpha", "beta", "a1", "a_1", "drop", "E", "K", "G", "e",
    "i", "eta", "gamma", "q", "q_1", "p", "h", "I_1", "double", "end", "lamda", "np", "M_PI", "x_", "Gamma",
    "zeta", "d",
)  # fmt: skip
"""Names of symbols, many of them words of a language or names of functions in LaTeX."""
NOTATION = {
    "V": "V'", "N": "F_N", "a": r"\varphi", "v_0": r"v_{\mathrm{ref}}", "alpha": r"\hat{a}_{1}",
    "w": r"w^{*}", "mu_s": r"\mu_0", "drop": r"\Delta v", "b": r"\boldsymbol{b}", "q": r"\mathit{Sk}",
}  # fmt: skip
"""What a user may have printed instead."""
ONE = {
    sp.exp: mpmath.exp, sp.log: mpmath.log, sp.sin: mpmath.sin, sp.cos: mpmath.cos, sp.tan: mpmath.tan,
    sp.sinh: mpmath.sinh, sp.cosh: mpmath.cosh, sp.tanh: mpmath.tanh, sp.sech: mpmath.sech, sp.asinh: mpmath.asinh,
    sp.atan: mpmath.atan, sp.erf: mpmath.erf, sp.Abs: abs,
}  # fmt: skip
"""What laws and their slopes consist of."""
CODE = ONE | {
    expm1: mpmath.expm1, log1p: mpmath.log1p, sp.asin: mpmath.asin, sp.acos: mpmath.acos, sp.acosh: mpmath.acosh,
    sp.atanh: mpmath.atanh, sp.coth: mpmath.coth, sp.sign: mpmath.sign,
}  # fmt: skip
"""What is written as code."""
RARE = {
    sp.coth: mpmath.coth, sp.acosh: mpmath.acosh, sp.atanh: mpmath.atanh, sp.acos: mpmath.acos,
    sp.erfc: mpmath.erfc, sp.erfi: mpmath.erfi, sp.sign: mpmath.sign, sp.gamma: mpmath.gamma,
    sp.elliptic_k: mpmath.ellipk, sp.elliptic_e: mpmath.ellipe, sp.dirichlet_eta: mpmath.altzeta,
    sp.zeta: mpmath.zeta,
}  # fmt: skip
"""What closed forms may have besides."""
SEVERAL = {
    sp.besseli: mpmath.besseli, sp.polylog: mpmath.polylog, sp.elliptic_pi: mpmath.ellippi,
    sp.lowergamma: lambda s, x: mpmath.gammainc(s, 0, x),
    Lerch: lambda z, s, a: mpmath.nsum(lambda n: z**n / (n + a) ** s, [0, mpmath.inf], method="d"),
}  # fmt: skip
KNOWN = CODE | RARE | SEVERAL


class Unfit(Exception):
    """A draw whose value is not real, or hangs on its last digits."""


_NO_DRAW = (
    Unfit, ZeroDivisionError, ValueError, OverflowError, mpmath.mp.NoConvergence, TypeError,
    AttributeError,  # SymPy's own, where it simplifies a hypergeometric function while it is built
)  # fmt: skip


def value(expr, point, noise=lambda x: x):
    """Return the value of an expression; `noise` is applied to every part."""

    def walk(node):
        found = noise(computed(node))
        if not isinstance(found, mpmath.mpf) or not mpmath.isfinite(found) or abs(found) > 1e30:
            raise Unfit
        return found

    def computed(node):
        if node in point:
            return point[node]
        if node.is_Rational:
            return mpmath.mpf(int(node.p)) / int(node.q)
        if isinstance(node, sp.Add):
            return mpmath.fsum(map(walk, node.args))
        if isinstance(node, sp.Mul):
            return mpmath.fprod(map(walk, node.args))
        if isinstance(node, sp.Pow):
            base, exponent = map(walk, node.args)
            if base < 0 and not (node.exp.is_Integer):
                raise Unfit
            return base**exponent
        if isinstance(node, sp.Max | sp.Min):
            return (max if isinstance(node, sp.Max) else min)(map(walk, node.args))
        if isinstance(node, sp.Piecewise):
            parts = [(walk(part), holds) for part, holds in node.args]
            return next(part for part, holds in parts if holds == sp.true or true(holds))
        if isinstance(node, sp.hyper):
            return mpmath.hyper(*([walk(x) for x in group] for group in node.args[:2]), walk(node.args[2]))
        if isinstance(node, sp.Integral):
            variable, low, high = node.limits[0]
            return mpmath.quad(lambda x: value(node.function, point | {variable: x}), [walk(low), walk(high)])
        if isinstance(node, sp.Derivative):
            (variable,) = node.variables
            return mpmath.diff(lambda x: value(node.expr, point | {variable: x}), point[variable])
        if node.is_NumberSymbol:
            return mpmath.mpf({sp.pi: mpmath.pi, sp.E: mpmath.e, sp.Catalan: mpmath.catalan}[node])
        if type(node) not in KNOWN:
            raise Unfit
        return KNOWN[type(node)](*map(walk, node.args))

    def true(relation):
        if not isinstance(relation, sp.core.relational.Relational):
            raise Unfit
        left, right = (walk(side) for side in relation.args)
        if abs(left - right) < 1e-6 * (abs(left) + abs(right)):
            raise Unfit
        return left < right if relation.rel_op in ("<", "<=") else left > right

    return walk(expr)


class Draws:
    """Expressions drawn one after the other."""

    def __init__(self, rng, *, plain=False):
        self.rng, self.plain = rng, plain
        self.symbols = [sp.Symbol(name, positive=True) for name in rng.sample(NAMES, 5)]

    def draw(self):
        """An expression, a point, and the value there; the expression has symbols and a few nodes."""
        while True:
            try:
                expr = self.expression(self.rng.choice((3, 3, 4, 5)))
                point = {symbol: mpmath.mpf(self.rng.randint(30, 250)) / 100 for symbol in self.symbols}
                if not expr.free_symbols or expr.has(sp.I, sp.nan, sp.zoo, sp.oo):
                    continue
                if not 4 <= expr.count_ops() <= 60:
                    continue
                found = value(expr, point)
                for _ in range(2):
                    moved = value(expr, point, lambda x: x * (1 + mpmath.mpf(self.rng.uniform(-1, 1)) * 1e-9))
                    if not abs(found - moved) < 1e-6 * abs(found):
                        raise Unfit
            except _NO_DRAW:
                continue
            return expr, point, found

    def leaf(self):
        if self.rng.random() < 0.75:
            return self.rng.choice(self.symbols)
        small = [sp.Integer(2), sp.Integer(3), sp.Integer(-1), sp.Rational(1, 2), sp.Rational(-2, 3), sp.pi]
        return self.rng.choice([*small, sp.Catalan])

    def positive(self, depth):
        return self.rng.choice(self.symbols) if depth < 1 else sp.Abs(self.expression(depth - 1)) + self.leaf()

    def below_one(self):
        part = self.rng.choice(self.symbols)
        return part / (part + self.rng.choice([sp.Integer(1), *self.symbols]))

    def expression(self, depth):
        if depth == 0:
            return self.leaf()
        rng, inner = self.rng, lambda: self.expression(depth - 1)
        kind = rng.choices(
            ["sum", "product", "quotient", "power", "function", "kink", "special", "open"],
            [9, 4, 8, 4, 6, 1, 0 if self.plain else 2, 0 if self.plain else 0.4],
        )[0]
        if kind == "sum":
            terms = [inner() * rng.choice((1, 1, -1, 2)) for _ in range(rng.choice((2, 2, 3)))]
            return sp.Add(*terms)
        if kind == "product":
            return sp.Mul(*(inner() for _ in range(rng.choice((2, 2, 3)))))
        if kind == "quotient":
            below = inner()
            if below == 0:
                raise Unfit
            return inner() / below
        if kind == "power":
            number = rng.choice((2, 3, -1, -2, *map(sp.Rational, ("1/2", "-1/2", "1/3", "-2/3", "3/2"))))
            exponent = rng.choice((number, number, inner()))
            return sp.Pow(inner(), exponent)
        if kind == "function":
            return rng.choice(list(CODE if self.plain else ONE))(inner())
        if kind == "kink":
            return self.kink(inner)
        return self.special(depth) if kind == "special" else self.open()

    def kink(self, inner):
        part = self.rng.choice(self.symbols)
        if self.rng.random() < 0.4:
            return self.rng.choice((sp.Max, sp.Min))(inner(), part)
        places = [inner() for _ in range(self.rng.choice((1, 1, 2)))]
        if any(place.has(sp.Piecewise, sp.Max, sp.Min, sp.Abs) for place in places):
            raise Unfit
        return sp.Piecewise(*((no_cases(inner()), part < place) for place in places), (no_cases(inner()), True))

    def special(self, depth):
        rng = self.rng
        kind = rng.choice([*RARE, *SEVERAL, sp.hyper])
        if kind is sp.besseli:
            return kind(rng.choice((0, 1, sp.Rational(3, 2))), self.positive(depth - 1))
        if kind in (sp.lowergamma,):
            return kind(rng.choice(self.symbols), self.positive(depth - 1))
        if kind is sp.polylog:
            return kind(rng.choice((2, 3)), -self.below_one(), evaluate=False)  # SymPy would compare for long
        if kind is Lerch:
            return kind(-self.below_one() / 2, rng.choice((1, 2)), self.positive(0))
        if kind is sp.elliptic_pi:
            return kind(self.below_one(), self.below_one())
        if kind is sp.hyper:
            tops = [[self.positive(0), sp.Rational(1, 2)], [sp.S.One / 3], []][rng.randrange(3)]
            return kind(tops, [self.leaf() + 1 for _ in range(max(len(tops) - 1, 1))], -self.below_one() / 2)
        if kind in (sp.elliptic_k, sp.elliptic_e, sp.acos, sp.atanh):
            return kind(self.below_one())
        if kind in (sp.dirichlet_eta, sp.zeta, sp.acosh):
            return kind(self.positive(0) + 1)
        return kind(self.positive(depth - 1))

    def open(self):
        """An integral or a derivative of something smooth, beside something else."""
        x, a, b = (self.rng.choice(self.symbols) for _ in range(3))
        f = self.rng.choice((x**2 + a, a * x / (1 + b), -x / 3, (x + a) / b, sp.exp(-x / b), a * x))
        node = sp.Derivative(f, x) if self.rng.random() < 0.5 else sp.Integral(f, (x, 0, a / 2))
        if not isinstance(node, sp.Integral | sp.Derivative):
            raise Unfit
        other = self.leaf()
        return self.rng.choice((node, node * other, node / (other + 1), other - node, node**2, sp.exp(node)))


def no_cases(expr):
    """A choice inside a choice is none of this package's."""
    if expr.has(sp.Piecewise):
        raise Unfit
    return expr
