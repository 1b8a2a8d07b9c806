"""What a formula tends to at rest and far out, with letters for its parameters.

A formula is expanded as a whole in x, which is v near rest and 1/v far out, and in L = -log(x):

    f = sum of c x^e L^n  +  O(x^p L^q)

So terms that are infinite one by one and finite together, as those of (1 - exp(-v))/v, cancel. Exponents may have
letters in them: terms stand in no order until one is asked for, and then it may be unknown. An exponential of what
grows is a power of x as well, whose exponent has a `Scale`, an infinite number, in it.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, reduce
from itertools import product
from typing import Any, TypeAlias, TypeVar

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, Substitution
from stickslip_sym.core.balls import number_at
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.functions import FUNCTIONS, Function, elementary, fold, power, write_erfcx
from stickslip_sym.core.numbers import NUMBER_BITS
from stickslip_sym.core.special import Erfcx
from stickslip_sym.model.expression.letters import substitute_numbers
from stickslip_sym.model.expression.pieces import kinked
from stickslip_sym.model.formula_algebra import RECIPROCALS, FormulaAlgebra, NotAnalytic, is_multiplied_out
from stickslip_sym.numerics.known import Unknown

T = TypeVar("T")
Values: TypeAlias = tuple[tuple[Expr, Expr], ...]
Order: TypeAlias = tuple[Expr, Expr]
"""The exponents e and n of x^e L^n."""

_MOST_POWERS = 12
"""Up to which a function is expanded: its value decides most limits, powers what remains where others cancel."""
_CONSTANT: Order = (sp.S.Zero, sp.S.Zero)
_LOGARITHM: Order = (sp.S.Zero, sp.S.One)
_SAMPLE = sp.Rational(17, 16)
"""The value of the first letter at which sums of coefficients are looked at; each next is larger by 1."""
_CANCELLED = 2.0 ** -(NUMBER_BITS // 4)
"""Of the largest term: a sum of numbers that is less is 0, or not told from 0."""

_v = symbols.v
_OF_LARGE_ARGUMENT: dict[type[Expr], Expr] = {
    sp.sinh: (sp.exp(_v) - sp.exp(-_v)) / 2,
    sp.cosh: (sp.exp(_v) + sp.exp(-_v)) / 2,
    sp.tanh: 1 - 2 / (sp.exp(2 * _v) + 1),
    sp.coth: 1 + 2 / (sp.exp(2 * _v) - 1),
    sp.sech: 2 / (sp.exp(_v) + sp.exp(-_v)),
    sp.csch: 2 / (sp.exp(_v) - sp.exp(-_v)),
    sp.erfc: 1 - sp.erf(_v),
}
"""Functions by what is expanded where their argument, which is v here, grows without bound."""
_OF_LARGE_POSITIVE: dict[type[Expr], Expr] = {
    sp.asinh: sp.log(_v + sp.sqrt(_v**2 + 1)),
    sp.atan: sp.pi / 2 - sp.atan(1 / _v),
    sp.erf: sp.S.One,
}
"""The same of odd functions, where it grows to infinity; that of erf leaves out what is below exp(-v^2)."""


class Scale(sp.Dummy):
    """An infinite number Z: x^(-Z) is the exponential of what grows like `order`."""

    order: Order


@lru_cache(maxsize=256)
def _scale(order: Order) -> Expr:
    """Return the scale of an order; for that of L it is the number 1, as exp(L) = 1/x."""
    if order == _LOGARITHM:
        return sp.S.One
    scale = Scale(positive=True)
    scale.order = order
    return scale


def _certain_sign(number: Expr) -> int:
    if scales := list(number.atoms(Scale)):
        largest = reduce(lambda one, other: one if _precedes(one.order, other.order) else other, scales)
        factor = sp.expand(number).coeff(largest)
        return _certain_sign(factor) or _certain_sign(sp.expand(number - factor * largest))
    if number.is_positive or number.is_negative:
        return 1 if number.is_positive else -1
    if number.is_zero:
        return 0
    raise NotAnalytic(f"the sign of {number} is not known")


def _precedence(order: Order, other: Order) -> int:
    """Return 1 for what is larger than another near x = 0, 0 for what is as large, and else -1."""
    return _certain_sign(other[0] - order[0]) or _certain_sign(order[1] - other[1])


def _precedes(order: Order, other: Order) -> bool:
    """Whether one is known to be as large as another, or larger."""
    try:
        return _precedence(order, other) >= 0
    except NotAnalytic:
        return False


def _multiply_orders(order: Order, other: Order) -> Order:
    return sp.expand(order[0] + other[0]), sp.expand(order[1] + other[1])


def _raise_order(order: Order, exponent: Expr) -> Order:
    return sp.expand(order[0] * exponent), sp.expand(order[1] * exponent)


@lru_cache(maxsize=1024)
def is_zero(coefficient: Expr, point: Values) -> bool:
    """Whether a coefficient is 0, for all letters or where they have values; refused where that is not certain."""
    if coefficient.is_Mul:
        return any(is_zero(factor, point) for factor in coefficient.args)
    if not coefficient.is_Add:
        return bool(substitute_numbers(coefficient, dict(point)).is_zero)
    if sp.expand(coefficient) == 0:
        return True
    values = dict(point)
    for number, letter in enumerate(sorted(coefficient.free_symbols - values.keys(), key=str)):
        values[letter] = _SAMPLE + number
    total = number_at(coefficient, values)
    sizes = [abs(number_at(c, values)) for c in coefficient.args]
    if total is sp.nan or abs(total) > _CANCELLED * max(sizes):
        return False
    if total != 0 and sp.simplify(substitute_numbers(coefficient, dict(point))) != 0:
        raise NotAnalytic(f"whether {coefficient} is 0 is not certain")
    return True


@dataclass(frozen=True)
class LeadingTerms:
    """A sum of c x^e L^n, and the orders of what is left out.

    Attributes
    ----------
    terms : mapping of (e, n) to c
    left_out : frozenset of (e, n)
    point : tuple
        Values of letters; coefficients keep the letters.
    """

    terms: Mapping[Order, Expr]
    left_out: frozenset[Order]
    point: Values

    def with_terms(self, terms: Mapping[Order, Expr], left_out: Collection[Order] = ()) -> "LeadingTerms":
        """Return a sum without terms that are 0 or no larger than what is left out."""
        largest = list[Order]()
        for order in left_out:
            if not any(_precedes(other, order) for other in largest):
                largest = [other for other in largest if not _precedes(order, other)] + [order]
        known = {
            order: c
            for order, c in terms.items()
            if not any(_precedes(other, order) for other in largest) and not is_zero(c, self.point)
        }
        return replace(self, terms=known, left_out=frozenset(largest))

    @property
    def orders(self) -> list[Order]:
        """Those of all that it is the sum of."""
        return [*self.terms, *self.left_out]

    def __add__(self, other: "LeadingTerms") -> "LeadingTerms":
        terms = dict(self.terms)
        for order, c in other.terms.items():
            terms[order] = terms.get(order, sp.S.Zero) + c
        return self.with_terms(terms, self.left_out | other.left_out)

    def __mul__(self, other: "LeadingTerms") -> "LeadingTerms":
        terms = dict[Order, Expr]()
        for (order, c), (factor, d) in product(self.terms.items(), other.terms.items()):
            joined = _multiply_orders(order, factor)
            terms[joined] = terms.get(joined, sp.S.Zero) + c * d
        left_out = {
            _multiply_orders(order, factor)
            for one, two in ((self, other), (other, self))
            for order, factor in product(one.left_out, two.orders)
        }
        return self.with_terms(terms, left_out)

    @property
    def leading(self) -> tuple[Order, Expr]:
        """The order and the coefficient of the term that is larger than all others."""
        for order, c in self.terms.items():
            if all(other == order or _precedes(order, other) for other in self.orders):
                return order, c
        raise NotAnalytic("no term is certain to be the first")

    def without(self, *orders: Order) -> "LeadingTerms":
        """Return it without some of its terms."""
        return replace(self, terms={order: c for order, c in self.terms.items() if order not in orders})

    def scaled(self, factor: Expr, order: Order) -> "LeadingTerms":
        """Return it times a term."""
        return self * replace(self, terms={order: factor}, left_out=frozenset())

    @property
    def grows(self) -> bool:
        """Whether it is infinite at x = 0; refused where that is not certain."""
        try:
            return _precedence(_CONSTANT, self.leading[0]) < 0
        except NotAnalytic:
            self.require_all_that_stays()
            return any(_precedence(_CONSTANT, order) < 0 for order in self.terms)

    def require_all_that_stays(self) -> None:
        """Refuse a sum that leaves out what may not vanish at x = 0."""
        if any(_precedence(_CONSTANT, order) <= 0 for order in self.left_out):
            raise NotAnalytic("too many terms cancel, or there is no limit")

    def growing_powers(self) -> dict[Order, Expr]:
        """Return the terms that are powers of 1/x, with whole and with other exponents."""
        self.require_all_that_stays()
        return {(e, n): c for (e, n), c in self.terms.items() if n == 0 and not e.has(Scale) and e.is_negative}

    def limit(self) -> Expr:
        """Return what it tends to."""
        if self.grows:
            return sp.oo * self.sign_of(self.leading[1])
        self.require_all_that_stays()
        return self.terms.get(_CONSTANT, sp.S.Zero)

    def sign_of(self, coefficient: Expr) -> int:
        """Return the sign of a coefficient, which must be certain."""
        return _certain_sign(number_at(coefficient, dict(self.point)) if self.point else coefficient)

    def inserted_in(self, coefficients: Sequence[Expr]) -> "LeadingTerms":
        """Return a power series of this, which vanishes with x."""
        left_out = {_raise_order(order, sp.Integer(len(coefficients))) for order in self.orders}
        total = self.with_terms({}, left_out)
        for coefficient in reversed(coefficients):
            total = total * self + self.with_terms({_CONSTANT: coefficient}, left_out)
        return total


class _LetterAlgebra(FormulaAlgebra[LeadingTerms]):
    """The algebra of leading terms, with so many of each function."""

    def number(self, node: Expr) -> LeadingTerms:
        return self.v.with_terms({_CONSTANT: node})

    def exponent(self, node: Expr) -> Expr:
        return node.xreplace(self.point)

    def __call__(self, node: Expr, parts: list[LeadingTerms]) -> LeadingTerms:
        if node.is_Pow and node.base is not sp.E and node.exp.has(symbols.v):
            base, exponent = parts
            return self.function(FUNCTIONS[sp.exp], exponent * self.function(FUNCTIONS[sp.log], base))
        return super().__call__(node, parts)

    def of(self, expr: Expr, argument: LeadingTerms) -> LeadingTerms:
        """Return an expression in v of what is expanded already."""
        return fold(expr, type(self)(self.point, argument, self.count))

    def power(self, base: LeadingTerms, exponent: Expr) -> LeadingTerms:
        if is_multiplied_out(exponent):
            return self.whole_power(base, exponent)
        if not base.terms and exponent.is_positive:
            return base.with_terms({}, {_raise_order(order, exponent) for order in base.left_out})
        order, first = base.leading
        binomials = [sp.S.One]
        for k in range(self.count):
            binomials.append(binomials[-1] * (exponent - k) / (k + 1))
        rest = base.without(order).scaled(1 / first, _raise_order(order, sp.S.NegativeOne))
        return rest.inserted_in(binomials).scaled(power(first, exponent), _raise_order(order, exponent))

    def function(self, known: Function, inner: LeadingTerms) -> LeadingTerms:
        kind: Any = known.kind
        if kind is sp.log and inner.leading[0] != _CONSTANT:
            return self._logarithm(inner)
        try:
            grows = inner.grows
        except NotAnalytic:
            if known.bounded:
                return inner.with_terms({}, {_CONSTANT})
            raise
        if grows:
            return self._function_of_large(known, inner)
        start = inner.terms.get(_CONSTANT, sp.S.Zero)
        if kind in RECIPROCALS and start == 0:
            return self.by_reciprocal(known, inner)
        return inner.without(_CONSTANT).inserted_in(_letter_coefficients(kind, start, self.count))

    def _logarithm(self, inner: LeadingTerms) -> LeadingTerms:
        """Return the logarithm of what vanishes with x, or grows."""
        order, first = inner.leading
        rest = inner.without(order).scaled(1 / first, _raise_order(order, sp.S.NegativeOne))
        logarithm = rest.inserted_in(_letter_coefficients(sp.log, sp.S.One, self.count))
        exponent, logarithms = order
        of_scales = {one.order: -exponent.coeff(one) for one in exponent.atoms(Scale)}
        number = exponent.xreplace(dict.fromkeys(exponent.atoms(Scale), sp.S.Zero))
        if logarithms != 0:
            raise NotAnalytic("the logarithm of a logarithm")
        return logarithm + inner.with_terms({_CONSTANT: sp.log(first), _LOGARITHM: -number, **of_scales})

    def _large_exponential(self, known: Function, inner: LeadingTerms) -> LeadingTerms:
        """Return the exponential of what grows: a power of x for each such term, times that of the others."""
        growing = [order for order in inner.terms if _precedence(_CONSTANT, order) < 0]
        inner.require_all_that_stays()
        exponent = -sp.Add(*[inner.terms[order] * _scale(order) for order in growing])
        return self.function(known, inner.without(*growing)).scaled(sp.S.One, (sp.expand(exponent), sp.S.Zero))

    def _function_of_large(self, known: Function, inner: LeadingTerms) -> LeadingTerms:
        kind = known.kind
        if kind is sp.exp:
            return self._large_exponential(known, inner)
        if kind in _OF_LARGE_ARGUMENT:
            return self.of(_OF_LARGE_ARGUMENT[kind], inner)
        if known.bounded and kind not in _OF_LARGE_POSITIVE:
            return inner.with_terms({}, {_CONSTANT})
        side = sp.Integer(inner.sign_of(inner.leading[1]))
        if kind is Erfcx and side > 0:
            reciprocal = self.power(inner, sp.S.NegativeOne)
            far = reciprocal.inserted_in(Erfcx.far_coefficients(self.count + 1))
            return far.scaled(1 / sp.sqrt(sp.pi), _CONSTANT)
        if kind not in _OF_LARGE_POSITIVE:
            raise NotAnalytic(f"{known.name} of what grows")
        of_positive = self.of(_OF_LARGE_POSITIVE[kind], inner.scaled(side, _CONSTANT))
        if kind is sp.erf:
            tail = self.of(sp.exp(-(_v**2)), inner)
            of_positive = of_positive.with_terms(of_positive.terms, tail.orders)
        return of_positive.scaled(side, _CONSTANT)


@lru_cache(maxsize=256)
def _letter_coefficients(kind: type[Expr], start: Expr, count: int) -> list[Expr]:
    if kind is sp.exp:
        return [_exponential_of(start) / sp.factorial(k) for k in range(count + 1)]
    x = sp.Dummy()
    coefficients = []
    derivative = kind(x)
    for k in range(count + 1):
        coefficients.append(derivative.xreplace({x: start}) / sp.factorial(k))
        derivative = sp.expand(derivative.diff(x))  # unexpanded, the twelfth of tanh takes seconds
    if any(c.has(sp.nan, sp.zoo, sp.oo, -sp.oo) for c in coefficients):
        raise NotAnalytic(f"{kind.__name__} is not analytic at {start}")
    return coefficients


def _exponential_of(number: Expr) -> Expr:
    """Return an exponential, that of c log(q) as a power of q, which SymPy may not compute."""
    value = sp.S.One
    for term in sp.Add.make_args(number):
        factor, rest = term.as_coeff_Mul()
        value *= power(rest.args[0], factor) if isinstance(rest, sp.log) else sp.exp(term)
    return value


def ask_leading_terms(
    expr: Expr, answer: Callable[[LeadingTerms], T], point: Substitution | None = None, *, far: bool = False
) -> T | Unknown:
    """Return what the leading terms of an expression without kinks answer, at rest or far out.

    - `point`: values of letters, which exponents have then, and which decide signs and what is 0.
    - `answer`: raises `NotAnalytic` where it does not find out.
    """
    values = tuple((point or {}).items())
    reason: Exception = NotAnalytic("it was not asked")
    written = elementary(write_erfcx(expr) if far else expr)
    for count, multiplied_out in product((0, _MOST_POWERS // 4, _MOST_POWERS), (False, True)):
        try:
            shape = sp.expand(written) if multiplied_out else written
            return answer(_expand_in_letters(shape, values, count, far))
        except (NotAnalytic, InputError, ValueError, TypeError) as failure:
            reason = failure
    return Unknown(str(reason))


@lru_cache(maxsize=256)
def _expand_in_letters(expr: Expr, point: Values, count: int, far: bool) -> LeadingTerms:
    order = sp.Integer(-1 if far else 1), sp.S.Zero
    v = LeadingTerms({order: sp.S.One}, frozenset(), point)
    return fold(expr, _LetterAlgebra(dict(point), v, count))


def symbolic_limit_at_rest(expr: Expr, point: Substitution | None = None) -> Expr | Unknown:
    """Return the limit of an expression in v and parameters as v falls to 0.

    Where it depends on the sign of a place, it is a Piecewise.
    """
    for node in kinked(expr):
        cases = []
        for part, condition in node.args:
            if (holds := condition.xreplace({symbols.v: sp.Integer(0)})) != sp.false:
                limit = symbolic_limit_at_rest(expr.xreplace({node: part}), point)
                if isinstance(limit, Unknown):
                    return limit
                cases.append((limit, holds))
            if holds == sp.true:
                break
        return sp.Piecewise(*cases)
    limit = ask_leading_terms(expr, LeadingTerms.limit, point)
    return Unknown("it is complex") if isinstance(limit, sp.Basic) and limit.has(sp.I) else limit


def has_limit_at_rest(expr: Expr, point: Substitution | None = None) -> bool:
    """Whether an expression has a limit at rest that is finite; not where none is found."""
    limit = symbolic_limit_at_rest(expr, point)
    return not isinstance(limit, Unknown) and limit.is_finite is not False
