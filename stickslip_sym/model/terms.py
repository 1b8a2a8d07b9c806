"""A law as a sum of terms, mu(v) = sum of amplitude * profile(v / scale; shapes).

A profile is a function of v, the slip speed in units of the scale. It holds no parameter of a law: what neither
the amplitude nor the scale takes out becomes a shape, a symbol p_1, p_2, ... of the profile, such as an exponent
or a ratio of two speeds. Long numbers count as parameters. Laws that differ in their parameters share their
profiles, so what is derived of a profile is derived once.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import pairwise

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Condition, Expr, Substitution
from stickslip_sym.model.expression.letters import name_constants, substitute_numbers
from stickslip_sym.model.expression.pieces import RELATIONS, place_of
from stickslip_sym.model.leading_terms import LeadingTerms, Order, ask_leading_terms, is_zero
from stickslip_sym.numerics.known import Unknown


@dataclass(frozen=True)
class Term:
    """A term amplitude * profile(v / scale; shapes) of a law.

    Its share of a criterion is N amplitude/scale F(V/scale; shapes), F the average of the profile: the criteria
    are linear in mu, and a change of the unit of speed scales them.

    Attributes
    ----------
    amplitude : sympy.Expr
        Of the parameters; may be negative.
    scale : sympy.Expr
        A positive speed: of the parameters, or a number.
    profile : sympy.Expr
        g(v), a function of `symbols.v`, the slip speed in units of the scale, and of the shapes.
    shapes : mapping of Symbol to sympy.Expr
        What each shape p_1, p_2, ... of the profile is in terms of the law's parameters, in order.
    """

    amplitude: Expr
    scale: Expr
    profile: Expr
    shapes: Substitution = field(default_factory=dict)

    @property
    def expr(self) -> Expr:
        """The term as a function of v and the law's parameters."""
        return self.amplitude * self.in_parameters(self.profile)

    def in_parameters(self, function: Expr) -> Expr:
        """Return a function of the shapes and of speeds in units of the scale in terms of the law's parameters."""
        belt = {symbols.V: symbols.V / self.scale}
        return _rescale(substitute_numbers(function, {**belt, **self.shapes}), 1 / self.scale)

    def condition_in_parameters(self, condition: Condition) -> Condition:
        """Return a condition of the shapes in terms of the law's parameters."""
        return condition.func(*map(self.in_parameters, condition.args))

    def __hash__(self) -> int:
        return hash((self.amplitude, self.scale, self.profile, tuple(self.shapes.items())))


def shapes_of(profile: Expr) -> tuple[Expr, ...]:
    """Return the shapes of a profile in order."""
    return tuple(sorted(profile.free_symbols - {symbols.v}, key=lambda symbol: (len(symbol.name), symbol.name)))


@lru_cache
def terms_of(mu: Expr) -> tuple[Term, ...]:
    """Split a coefficient mu(v) into terms; their sum is mu(v).

    A part without v is a term whose profile is 1. A polynomial with one scale is one term, which rounds as one;
    any other is split by powers. Of the exponential law the terms are mu_m and (mu_s - mu_m) exp(-v/(1/alpha)).
    Parts that are infinite at rest, or grow far out, and cancel there are one term: (1 - exp(-v))/v.
    """
    v = symbols.v
    polynomial = sp.S.Zero
    terms = []
    parts = grouped(mu, v)
    for group in _cancelling(parts):
        terms.append(_scaled(sp.Integer(1), sp.Add(*(parts.pop(rest) * rest for rest in group))))
    for rest, constant in parts.items():
        if rest.is_polynomial(v):
            polynomial += constant * rest
        else:
            terms.append(_take_numbers_for_parameters(constant, rest))
    return (*_polynomial_terms(polynomial, v), *terms)


def _cancelling(parts: Substitution) -> list[list[Expr]]:
    """Return functions that are infinite at rest, or far out, like a power of v, where their sum is finite."""
    groups: list[list[Expr]] = []
    for far in (False, True):
        left = [rest for rest in parts if not any(rest in group for group in groups)]
        strengths = [_growing_powers(parts[rest] * rest, far=far) for rest in left]
        for orders in _shared_power_sets(strengths):
            of = [k for k, strength in enumerate(strengths) if orders & strength.keys()]
            totals = [sp.Add(*[strengths[k].get(order, sp.S.Zero) for k in of]) for order in orders]
            if len(of) > 1 and all(is_zero(total, ()) for total in totals):
                groups.append([left[k] for k in of])
    return groups


def _growing_powers(function: Expr, *, far: bool) -> Mapping[Order, Expr]:
    """Return the powers of v in a smooth function that grow at rest, or far out, and their coefficients."""
    if function.has(sp.Piecewise):
        return {}
    powers = ask_leading_terms(function, LeadingTerms.growing_powers, far=far)
    return {} if isinstance(powers, Unknown) else powers


def _shared_power_sets(strengths: Sequence[Mapping[Order, object]]) -> list[set[Order]]:
    """Return sets of powers such that what has one of a set has none of another."""
    sets: list[set[Order]] = []
    for strength in strengths:
        joined = set(strength).union(*(powers for powers in sets if powers & strength.keys()))
        sets = [powers for powers in sets if not powers & joined] + [joined]
    return [powers for powers in sets if powers]


def _polynomial_terms(polynomial: Expr, v: Expr) -> Iterator[Term]:
    if polynomial == 0:
        return
    constant = sp.factor_terms(polynomial.subs(v, 0))
    if constant != 0:
        yield Term(constant, sp.Integer(1), sp.Integer(1))
    varying = sp.Poly(sp.expand(polynomial - constant), v)
    powers = [(int(k), sp.factor(coefficient)) for (k,), coefficient in varying.terms() if coefficient != 0]
    if len(powers) > 1:
        # Numbers such as sqrt(3) stay with the coefficients: there they become fractions.
        whole = _scaled(
            sp.Integer(1),
            sp.Add(*[coefficient * v**power for power, coefficient in powers]),
            lambda scale: scale.as_independent(*scale.free_symbols, as_Add=False)[1],
        )
        if not whole.shapes:
            yield whole
            return
    for power, coefficient in powers:
        yield Term(coefficient, sp.Integer(1), symbols.v**power)


# -- amplitude, scale and shapes ---------------------------------------------------------------------


def _take_numbers_for_parameters(constant: Expr, rest: Expr) -> Term:
    """Return a term whose long numbers are taken for parameters: those that are left in its profile are shapes."""
    general = name_constants(rest)
    term = _scaled(sp.Integer(1), general.expr)
    shapes = {shape: general.put_back(meaning) for shape, meaning in term.shapes.items()}
    amplitude = sp.factor(constant * general.put_back(term.amplitude))
    return Term(amplitude, general.put_back(term.scale), term.profile, shapes)


def _scaled(constant: Expr, rest: Expr, rounded: Callable[[Expr], Expr] = lambda scale: scale) -> Term:
    """Return a term with the scale that leaves the fewest shapes."""
    scales = map(rounded, speed_scales(rest, symbols.v))
    numbers = rest.has(sp.Piecewise)  # places that are numbers stay what they are, and the pieces with them
    candidates = [scale for scale in scales if scale.is_positive and not (numbers and scale.is_number)]
    terms = [_term_of_scale(constant, rest, scale) for scale in dict.fromkeys([*candidates, sp.Integer(1)])]
    return min(terms, key=lambda term: (len(term.shapes), term.profile.count_ops()))


def _term_of_scale(constant: Expr, rest: Expr, scale: Expr) -> Term:
    function = _simplified(_logarithms_apart(_rescale(rest, scale)))
    if function.is_Add and not function.is_polynomial(symbols.v):  # terms that cancel
        function = sp.factor_terms(function)
    coefficient, profile = function.as_independent(symbols.v, as_Add=False)
    if profile.is_polynomial(symbols.v) and not shapes_of(profile):
        polynomial = sp.Poly(profile, symbols.v)
        content, monic = polynomial.monic().as_expr().as_content_primitive()
        coefficient = coefficient * polynomial.LC() * content
        profile = monic
    meanings: dict[Expr, Expr] = {}
    profile = _replace_parameters(profile, meanings)
    shapes = {symbol: meaning for meaning, symbol in meanings.items()}
    return Term(sp.factor(constant * coefficient), scale, profile, shapes)


def _rescale(rest: Expr, scale: Expr) -> Expr:
    """Write scale v for v; the places of kinks are divided by the scale."""
    if scale == 1:
        return rest
    relative = sp.Dummy(nonnegative=True)  # v/scale, until it is called v
    relations = {
        node: relative < sp.powsimp(place_of(node) / scale)
        for node in rest.atoms(*RELATIONS) if node.has(symbols.v)
    }  # fmt: skip
    return substitute_numbers(rest.xreplace(relations), {symbols.v: scale * relative}).xreplace(
        {relative: symbols.v}
    )


def _logarithms_apart(expr: Expr) -> Expr:
    """Write log(a v) as log(a) + log(v), so that log(A) - log(A v) is -log(v)."""
    return expr.replace(
        lambda node: isinstance(node, sp.log) and node.args[0].is_Mul and symbols.v in node.args[0].args,
        lambda node: sp.Add(*map(sp.log, node.args[0].args)),
    )


def _simplified(expr: Expr) -> Expr:
    """Bring out the constant factor of a function of v, so that equal profiles become the same expression."""
    if expr.has(sp.Piecewise):
        return expr.xreplace({node: _simplified_pieces(node) for node in expr.atoms(sp.Piecewise)})
    if expr.is_rational_function(symbols.v):
        return _normalise_factors(sp.factor(expr))
    expr = expr.replace(lambda node: node.is_Pow and not node.exp.is_Integer, _normalise_factors)
    return expr.replace(
        lambda node: isinstance(node, sp.Function), lambda node: node.func(*map(_factored_polynomial, node.args))
    )


def _simplified_pieces(node: sp.Piecewise) -> Expr:
    """Bring out the constant factor that all pieces share."""
    pieces = [sp.factor_terms(piece) for piece, _ in node.args]
    factors = [piece.as_independent(symbols.v, as_Add=False)[0] for piece in pieces if piece != 0]
    common = factors[0].as_coeff_Mul()[1]
    if not all((factor / common).is_number for factor in factors):
        common = sp.Integer(1)
    conditions = [holds for _, holds in node.args]
    return common * node.func(*((piece / common, holds) for piece, holds in zip(pieces, conditions, strict=True)))


def _normalise_factors(product: Expr) -> Expr:
    """Write each power of a polynomial in a product with 1 for its constant coefficient, or its highest one."""
    plain = []
    v = symbols.v
    for factor in sp.Mul.make_args(product):
        base, exponent = factor.as_base_exp()
        if base != v and base.has(v) and base.free_symbols != {v} and base.is_polynomial(v):
            powers = sp.Poly(base, v)
            if (square := _completed_square(powers)) is not None:
                unit, shift, width = square
                plain += [unit**exponent, ((v + shift) ** 2 + width**2) ** exponent]
                continue
            unit = sp.factor(powers.nth(0) or powers.LC())
            if unit.is_positive or exponent.is_Integer:
                plain += [unit**exponent, _factored_polynomial(base, unit) ** exponent]
                continue
        plain.append(factor)
    return sp.Mul(*plain)


def _completed_square(powers: sp.Poly) -> tuple[Expr, Expr, Expr] | None:
    """Return a, b and w > 0 of a ((v + b)^2 + w^2), where v + b may be 0: so b and w are what a reader knows."""
    if powers.degree() != 2 or powers.nth(1).is_nonnegative:
        return None
    a, middle, c = powers.all_coeffs()
    gap = sp.factor(4 * a * c - middle**2)
    if not (a.is_positive and gap.is_positive):
        return None
    return a, sp.factor(middle / (2 * a)), sp.sqrt(gap) / (2 * a)


def _factored_polynomial(expr: Expr, unit: Expr = sp.S.One) -> Expr:
    """Write a polynomial in v by its coefficients, each divided by a unit and factored; leave what is none."""
    if not (expr.has(symbols.v) and expr.is_polynomial(symbols.v)):
        return expr
    powers = sp.Poly(expr, symbols.v).terms()
    return sp.Add(*(sp.factor(coefficient / unit) * symbols.v**k for (k,), coefficient in powers))


def _replace_parameters(expr: Expr, names: dict[Expr, Expr]) -> Expr:
    """Replace the parameters of a function of v by shapes p_1, p_2, ..., which `names` keeps by their meanings."""
    if not shapes_of(expr):
        return expr
    if isinstance(expr, sp.Expr) and not expr.has(symbols.v):
        return _constant_as_shapes(expr, names)
    if expr.is_Add or expr.is_Mul:
        fixed, moving = expr.as_independent(symbols.v, as_Add=expr.is_Add)
        kind = sp.Add if expr.is_Add else sp.Mul
        parts = [_replace_parameters(part, names) for part in kind.make_args(moving)]
        return kind(*([_constant_as_shapes(fixed, names)] if fixed != kind.identity else []), *parts)
    return expr.func(*(_replace_parameters(argument, names) for argument in expr.args))


def _constant_as_shapes(expr: Expr, names: dict[Expr, Expr]) -> Expr:
    """Replace a function of the parameters by shapes: sums term by term, monomials up to a power."""
    if not expr.free_symbols:
        return expr
    if expr.is_Add:
        return sp.Add(*(_constant_as_shapes(term, names) for term in expr.args))
    if expr.is_Pow and expr.exp.free_symbols:
        return _constant_as_shapes(expr.base, names) ** _constant_as_shapes(expr.exp, names)
    if isinstance(expr, sp.exp):
        return sp.exp(_constant_as_shapes(expr.exp, names))
    number, product = expr.as_coeff_Mul()
    powers = product.as_powers_dict()
    if all(exponent.is_Rational for exponent in powers.values()):
        ordered = sorted(powers, key=sp.default_sort_key)
        common = sp.gcd_list([powers[base] for base in ordered]) * sp.sign(powers[ordered[0]])
        primitive = sp.Mul(*(base ** (powers[base] / common) for base in ordered))
        if primitive.is_positive or common.is_Integer:
            return number * _named(primitive, names) ** common
    return number * _named(product, names)


def _named(meaning: Expr, names: dict[Expr, Expr]) -> Expr:
    if meaning not in names:
        kind = next((kind for kind in ("positive", "nonnegative") if getattr(meaning, f"is_{kind}")), "real")
        names[meaning] = sp.Symbol(f"p_{len(names) + 1}", **{kind: True})
    return names[meaning]


# -- what a law is a sum of --------------------------------------------------------------------------


def expand_above(expr: Expr) -> Expr:
    """Multiply out a product of sums but leave denominators whole: 1/(u + w)^2 stays what it is."""
    nodes = expr.atoms(sp.Pow, sp.Function, sp.Max, sp.Min, sp.Integral)
    whole = {
        node: sp.Dummy()
        for node in nodes
        if not (node.is_Pow and node.base.is_Add and node.exp.is_Integer and node.exp > 0)
    }
    return sp.expand(expr.xreplace(whole)).xreplace({dummy: node for node, dummy in whole.items()})


def grouped(f: Expr, u: Expr) -> dict[Expr, Expr]:
    """Split a sum into functions of `u` and their constant factors, f = sum of constant times function.

    Products are expanded, denominators are not, and fractions over one denominator stay together.
    """
    constants: dict[Expr, Expr] = {}
    fractions: dict[Expr, list[Expr]] = {}
    for term in sp.Add.make_args(expand_above(f)):
        constant, rest = _merge_exponentials(term, u).as_independent(u, as_Add=False)
        numerator, denominator = sp.fraction(rest)
        if denominator.has(u) and rest.is_rational_function(u):
            fractions.setdefault(denominator, []).append(constant * numerator)
        else:
            constants[rest] = constants.get(rest, 0) + constant
    for denominator, numerators in fractions.items():
        constant, numerator = sp.factor_terms(sp.Add(*numerators)).as_independent(u, as_Add=False)
        constants[numerator / denominator] = constant
    factored = {rest: sp.factor(constant) for rest, constant in constants.items()}
    return {rest: constant for rest, constant in factored.items() if constant != 0}


def split_polynomial(product: Expr, u: Expr) -> tuple[Expr, list[Expr]]:
    """Split a product into its polynomial in u and its other factors."""
    polynomials, others = sp.sift(
        sp.Mul.make_args(product), lambda factor: bool(factor.is_polynomial(u)), binary=True
    )
    return sp.Mul(*polynomials), others


def _merge_exponentials(term: Expr, u: Expr) -> Expr:
    """Write a product with one exponential of `u` at most; SymPy leaves exp(-v) exp(-p v) as it is."""
    exponentials, others = sp.sift(
        sp.Mul.make_args(term), lambda factor: isinstance(factor, sp.exp) and factor.has(u), binary=True
    )
    if len(exponentials) < 2:
        return term
    return sp.Mul(*others, sp.exp(sp.Add(*(factor.exp for factor in exponentials))))


# -- the speeds at which a function changes ----------------------------------------------------------


def speed_scales(expr: Expr, v: Expr) -> list[Expr]:
    """Return the slip speeds on the scale of which an expression changes, as monomials of its parameters.

    In a sum of monomials a v^p that is the speed at which two of them balance, in a power (a v)^p and in the
    argument of a function the speed at which it is 1, and of pieces the places between them.
    """
    scales = list[Expr]()
    for node in sp.postorder_traversal(expr):
        if node.has(v):
            scales += _scales_of(node, v)
    return [scale for scale in dict.fromkeys(scales) if not scale.has(v) and scale != 0]


def _scales_of(node: Expr, v: Expr) -> Iterator[Expr]:
    if node.is_Pow and node.base.free_symbols - {v} and node.base.is_Add and node.base.is_polynomial(v):
        square = _completed_square(sp.Poly(node.base, v))
        if square is not None:
            yield square[2]
    if isinstance(node, RELATIONS):
        yield place_of(node)
    elif node.is_Pow and not node.exp.is_Integer and node.base.is_Mul:
        constant, rest = node.base.as_independent(v, as_Add=False)
        if rest == v:
            yield _absolute_value(1 / constant)
    elif node.is_Add:
        for (p, a), (q, b) in pairwise(_monomials(node.args, v)):
            if p != q:
                yield _positive_root(a / b, q - p)
        if node.has(sp.log(v)):  # of log(A/v), the speed A
            scale = sp.exp(-node.coeff(sp.log(v), 0) / node.coeff(sp.log(v)))
            if scale.is_positive and not scale.has(v, sp.exp):
                yield scale
    elif (node.is_Pow and node.exp.has(v)) or (
        isinstance(node, sp.Function) and not isinstance(node, sp.Piecewise)
    ):
        for argument in node.args:
            powers: dict[Expr, Expr] = {}
            for p, a in _monomials(sp.Add.make_args(sp.expand_mul(argument)), v):
                powers[p] = powers.get(p, 0) + a
            yield from (_positive_root(1 / sp.factor(a), p) for p, a in powers.items() if p != 0 and a != 0)


def _positive_root(value: Expr, index: Expr) -> Expr:
    return sp.powdenest(_absolute_value(value) ** (1 / index), force=True)


def _absolute_value(value: Expr) -> Expr:
    if value.is_positive:
        return value
    return sp.Abs(value)


def _monomials(terms: Sequence[Expr], v: Expr) -> Iterator[tuple[Expr, Expr]]:
    """Yield (p, a) of each term a v^p among some terms."""
    for term in terms:
        coefficient, rest = sp.expand_power_base(term, force=True).as_independent(v, as_Add=False)
        base, exponent = rest.as_base_exp()
        if rest == 1:
            yield sp.Integer(0), coefficient
        elif base == v and not exponent.has(v):
            yield exponent, coefficient
