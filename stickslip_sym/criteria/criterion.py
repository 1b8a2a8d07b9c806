"""The criteria: each a weight over which the falling slope of mu is averaged.

With s = (v - V)/V in [-1, 1] every criterion reads

    c = N <-mu'(V(1 + s))>_w = -N * integral_{-1}^{1} w(s) mu'(V(1 + s)) ds,    integral of w = 1.
"""

import re
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import Literal, TypeAlias

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, Rational
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.names import lookup
from stickslip_sym.core.numbers import fraction


@dataclass(frozen=True, eq=False)
class Criterion:
    """A slope average.

    Attributes
    ----------
    name : str
    weight : sympy.Expr or None
        w(s) on [-1, 1] with unit integral: a polynomial in s with exact coefficients, symmetric or not, zero at
        the ends or not; or (2/pi) sqrt(1 - s^2). None for the Dirac delta at s = 0, which takes the mean of
        both slopes at a kink of mu: small motions decay with it.
    source : str

    Raises
    ------
    InputError
        For any other weight.

    Examples
    --------
    >>> s = symbols.s
    >>> Criterion("early", sp.Rational(3, 4) * (1 - s**2) * (1 - s), "a weight on low slip speeds").mean_power(1)
    4/5
    """

    name: str
    weight: Expr | None
    source: str = ""

    def __post_init__(self) -> None:
        """Refuse a weight that is no average, or that nothing here can integrate."""
        if not isinstance(self.name, str) or not self.name.isprintable() or not self.name.strip():
            raise InputError(f"a criterion has a name, got {self.name!r}; give one such as 'early'")
        if self.weight is not None:
            object.__setattr__(self, "weight", _checked_weight(self.name, self.weight))

    def __eq__(self, other: object) -> bool:
        """Whether two criteria have the same name, weight and source."""
        return isinstance(other, Criterion) and self._identity == other._identity

    def __hash__(self) -> int:
        return hash((self.name, self.source))

    @cached_property
    def _identity(self) -> tuple[str, str, Expr | None]:
        return self.name, self.source, None if self.weight is None else sp.expand(self.weight)

    @lru_cache  # noqa: B019  # criteria are few, and kept
    def mean_power(self, k: int | Expr) -> Expr:
        """Return the mean of (1 + s)^k, exact, where it is finite."""
        if self.weight is None:
            return sp.S.One
        if self.is_polynomial:
            return sp.Add(*[c * 2 ** (j + k + 1) / (j + k + 1) for (j,), c in self.from_rest.terms()])
        # 4/pi B(3/2, 3/2) = 1/2 at k = 0
        return (
            2 ** (k + 3) / sp.pi * sp.gamma(k + sp.Rational(3, 2)) * sp.gamma(sp.Rational(3, 2)) / sp.gamma(k + 3)
        )

    @property
    def label(self) -> str:
        """The name as one word of letters, digits and underscores, for code and for references."""
        return re.sub(r"\W+", "_", self.name, flags=re.ASCII).strip("_") or "criterion"

    @property
    def ends(self) -> tuple[Expr, Expr]:
        """The weight at s = -1 and at s = 1."""
        weight = sp.Integer(0) if self.weight is None else self.weight
        return weight.subs(symbols.s, -1), weight.subs(symbols.s, 1)

    @property
    def order_at_rest(self) -> Expr:
        """The power of 1 + s like which the weight vanishes at s = -1, where the slip speed is 0."""
        if not self.is_polynomial:
            return sp.Rational(1, 2)
        return sp.Integer(min(power for (power,) in self.from_rest.monoms()))

    @property
    def from_rest(self) -> sp.Poly:
        """A polynomial weight in powers of p = 1 + s, the slip speed over V, with `symbols.s` for p."""
        return sp.Poly(self.weight, symbols.s).compose(sp.Poly(symbols.s - 1, symbols.s))

    def from_ends(self, p: Expr, q: Expr) -> Expr:
        """Return w(s) in terms of p = 1 + s and q = 1 - s, symbols for numbers that do not cancel at the ends."""
        if not self.is_polynomial:
            return 2 / sp.pi * sp.sqrt(p * q)
        s = symbols.s
        content, factors = sp.factor_list(self._kernel_weight, s)
        # In the middle s = (p - q)/2 cancels, to an absolute error of one unit.
        known = {1 + s: p, s - 1: -q}
        return content * sp.Mul(*[known.get(f, f.subs(s, (p - q) / 2)) ** power for f, power in factors])

    @property
    def kernel(self) -> Expr:
        """The kernel K(v) with c/N = integral_0^{2V} mu(v) K(v) dv + `boundary`, from one integration by parts."""
        return sp.factor(self._weight_slope.subs(symbols.s, symbols.v / symbols.V - 1) / symbols.V**2)

    @property
    def angle_kernel(self) -> Expr:
        """The kernel A(theta) with c/N = integral_0^pi mu(V(1 - cos(theta))) A(theta) dtheta."""
        sine = sp.sin(symbols.theta)
        cosine = sp.cos(symbols.theta)
        kernel = self._weight_slope.subs(symbols.s, -cosine) * sine / symbols.V
        return kernel.subs(sp.sqrt(1 - cosine**2), sine)  # which is not negative on [0, pi]

    def boundary(self, mu: Expr) -> Expr:
        """Return the boundary terms of c/N for a coefficient mu(v): 0 where the weight vanishes at both ends."""
        low, high = self.ends
        terms = ((low, sp.Integer(0)), (-high, 2 * symbols.V))
        return sp.Add(*[weight * mu.subs(symbols.v, v) / symbols.V for weight, v in terms if weight != 0])

    @cached_property
    def is_polynomial(self) -> bool:
        """Whether the weight is a polynomial, so that criteria are ordinary moments of mu."""
        return self.weight is not None and bool(self.weight.is_polynomial(symbols.s))

    @property
    def _kernel_weight(self) -> Expr:
        if self.weight is None:
            raise InputError(f"the criterion {self.name!r} takes the slope at one point; it has no kernel")
        return self.weight

    @property
    def _weight_slope(self) -> Expr:
        return sp.diff(self._kernel_weight, symbols.s)


_LARGEST_DENOMINATOR, _ROUNDING_OF_RATIO = (
    10**6,
    Fraction(1, 10**15),
)  # of a float that rounds a ratio, and by how much
_MOST_WEIGHT_DEGREE = 40  # degree of a weight; double precision holds no polynomial in s of a much higher one
_HARMONIC_WEIGHT = 2 / sp.pi * sp.sqrt(1 - symbols.s**2)


def _simple_ratio(number: Expr) -> Rational:
    """Return a SymPy Float as the ratio of small integers that it rounds, such as 1/3; if it is none, exactly."""
    exactly = fraction(number, "a number of the weight")
    simple = exactly.limit_denominator(_LARGEST_DENOMINATOR)
    ratio = exactly
    if abs(simple - exactly) <= _ROUNDING_OF_RATIO * max(Fraction(1), abs(exactly)):
        ratio = simple
    return sp.Rational(ratio.numerator, ratio.denominator)


def _checked_weight(name: str, weight: Expr) -> Expr:
    """Return a weight in the symbol s of this package, if it can be integrated."""
    what = f"the weight of the criterion {name!r}"
    if not isinstance(weight, str):  # a text would be evaluated as code
        weight = sp.sympify(weight)
    if not isinstance(weight, sp.Expr):
        raise InputError(f"{what} is an expression in s, got {type(weight).__name__}")
    free = {symbol.name for symbol in weight.free_symbols}
    if free - {"s"}:
        raise InputError(f"{what} depends on {', '.join(sorted(free - {'s'}))}; it may hold s only")
    weight = weight.xreplace(dict.fromkeys(weight.free_symbols, symbols.s))
    if weight == _HARMONIC_WEIGHT:
        return weight
    weight = weight.xreplace({number: _simple_ratio(number) for number in weight.atoms(sp.Float)})
    polynomial = weight.is_polynomial(symbols.s)
    if polynomial and (degree := sp.degree(weight, symbols.s)) > _MOST_WEIGHT_DEGREE:
        raise InputError(f"{what} is of degree {degree}; take one of degree {_MOST_WEIGHT_DEGREE} at most")
    if not polynomial or not all(c.is_Rational for c in sp.Poly(weight, symbols.s).all_coeffs()):
        raise InputError(f"{what} is {weight}; it must be a polynomial in s with rational coefficients")
    primitive = sp.Poly(weight, symbols.s).integrate()
    total = primitive.eval(1) - primitive.eval(-1)
    if total != 1:
        scaled = f"; multiply it by {1 / total}" if total != 0 else ""
        raise InputError(f"{what} integrates to {total} over -1 <= s <= 1; an average needs 1{scaled}")
    return weight


equilibrium = Criterion("equilibrium", None, "linear stability of the equilibrium, e.g. Galvanetto & Bishop 1999")
least_squares = Criterion(
    "least_squares", sp.Rational(5, 8) * (1 - symbols.s**4), "Won & Chung 2016, eq. (16), integrated by parts"
)

harmonic = Criterion(
    "harmonic",
    _HARMONIC_WEIGHT,
    "first-harmonic energy balance at velocity amplitude V; for the polynomial law Thomsen & Fidlin 2003",
)

catalogue = {criterion.name: criterion for criterion in (equilibrium, least_squares, harmonic)}
"""Every criterion by name. One that is put here is found by its name wherever a criterion is taken."""


CriterionName: TypeAlias = Literal["equilibrium", "least_squares", "harmonic"] | str
"""A name in the catalogue; editors offer the package's own."""


def find(criterion: CriterionName | Criterion) -> Criterion:
    """Return a criterion by its name; a criterion passes through.

    Raises
    ------
    InputError
        If there is none of that name.
    """
    if isinstance(criterion, Criterion):
        return criterion
    return lookup("criterion", criterion, catalogue)
