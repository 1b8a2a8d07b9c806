"""Letters for the numbers of a formula, so that algebra never multiplies decimals together.

With exponents such as 1.23456789, or decimals of fifteen digits, exact algebra makes polynomials in V^(1/10^8) and
integers of fifty digits. A formula in letters has neither; the numbers return where a value is asked for.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import lru_cache

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, Substitution
from stickslip_sym.core.functions import power
from stickslip_sym.core.special import NumberPower
from stickslip_sym.output.text_printer import decimal

_AT_A_GLANCE = 100
"""Numbers with a larger numerator or denominator get a letter."""
_BESIDE_LETTERS = 9
"""The same in a formula that has such numbers: 0.34 beside 0.1234 gets a letter too."""
HIGHEST_ROOT = 6
"""Exponents with a larger denominator get a letter; those of others decide which functions integrals lead to."""
_NAMES = {
    "coefficient": ("a", "q", "b", "g", "h", "z"),
    "speed": ("v", "w", "u", "s"),
    "rate": ("alpha", "beta", "kappa", "r"),
    "exponent": ("delta", "nu", "p", "epsilon"),
}
"""What letters of a role are called: the first that begins no other name."""


@dataclass(frozen=True)
class NamedConstants:
    """A formula in letters, and what each letter stands for: a positive number, or a sum of parameters."""

    expr: Expr
    meanings: Substitution = field(default_factory=dict)

    def put_back(self, expr: Expr) -> Expr:
        """Write what the letters stand for in their place."""
        return substitute_numbers(expr, self.meanings)


@lru_cache
def name_constants(expr: Expr) -> NamedConstants:
    """Return a formula with a letter for every long number in it, and for every sum of parameters that v is times.

    Coefficients of polynomials under a fraction bar or a root stay, from the second degree on: the sign of a
    discriminant decides which functions an integral leads to. So do laws in pieces.
    """
    if not expr.has(symbols.v) or expr.has(sp.Piecewise, sp.Min, sp.Max):
        return NamedConstants(expr)
    letters = _Letters(expr, _AT_A_GLANCE)
    general = letters.of(expr)
    if letters.meanings:
        letters = _Letters(expr, _BESIDE_LETTERS)
        general = letters.of(expr)
    found = NamedConstants(general, letters.meanings)
    if letters.meanings and is_same(found.put_back(general), expr):
        return found
    return NamedConstants(expr)


def is_same(expr: Expr, other: Expr) -> bool:
    """Whether two formulas are the same when multiplied out."""
    return bool(expr == other or sp.expand(expr) == sp.expand(other))


def substitute_numbers(expr: Expr, meanings: Substitution) -> Expr:
    """Replace letters by what they stand for; no power of a number is computed that SymPy would take apart."""
    if not meanings or not expr.free_symbols & meanings.keys():
        return expr
    if expr in meanings:
        return meanings[expr]
    arguments = [substitute_numbers(argument, meanings) for argument in expr.args]
    if expr.is_Pow and expr.base is not sp.E:
        return power(*arguments)
    return expr.func(*arguments)


class _Letters:
    """The letters of one formula, as they are given out."""

    def __init__(self, expr: Expr, largest: int) -> None:
        self._largest = largest
        self.meanings: dict[Expr, Expr] = {}
        self._given: dict[Expr, Expr] = {}  # what is written for a positive number or sum
        self._taken = {symbol.name for symbol in expr.free_symbols} - {symbols.v.name}
        self._prefix: dict[str, str] = {}

    def of(self, node: Expr, *, within: bool = False) -> Expr:
        """Return a node in letters; `within` a function or a power, sums of parameters get one too."""
        if node.is_Rational:
            if _size_of_rational(node) > self._largest:
                return self._of_number(node, "coefficient")
            return node
        if isinstance(node, NumberPower) or (node.is_Pow and node.base.is_Rational):
            return self._of_power_of_number(*node.args)
        if not node.args:
            return node
        if node.is_Pow and node.base is not sp.E:
            return self._of_power(*node.args)
        if node.is_Mul:
            return self._of_product(node, within=within)
        inside = within or isinstance(node, sp.Function) or node.is_Pow
        return node.func(*(self.of(argument, within=inside) for argument in node.args))

    def _of_power(self, base: Expr, exponent: Expr) -> Expr:
        counted = exponent.is_Integer and exponent > 0
        decides = base.is_Add and base.is_polynomial(symbols.v) and sp.degree(base, symbols.v) > 1 and not counted
        return (base if decides else self.of(base, within=True)) ** self._of_exponent(exponent)

    def _of_exponent(self, exponent: Expr) -> Expr:
        if not exponent.is_Rational:
            return self.of(exponent)
        if exponent.q <= HIGHEST_ROOT:
            return exponent
        return self._of_number(exponent, "exponent")

    def _of_power_of_number(self, base: Expr, exponent: Expr) -> Expr:
        raised = self._of_exponent(exponent)
        if raised == exponent:
            return power(base, exponent)
        return self._of_number(base, "speed") ** raised

    def _of_product(self, node: Expr, *, within: bool) -> Expr:
        """Write a product; beside v, the number and the sum of parameters are a rate, or one over a speed."""
        number, factors = node.as_coeff_mul(rational=True)
        has_v = within and node.has(symbols.v)
        parts = []
        for factor in factors:
            base, exponent = factor.as_base_exp()
            is_sum = base.is_Add and not base.has(symbols.v) and exponent.is_Integer
            if has_v and is_sum and (base.is_positive or base.is_negative):
                sign = 1 if base.is_positive else -1
                letter = self._named(sign * base, "rate" if exponent > 0 else "speed")
                parts.append((sign * letter) ** exponent)
            else:
                parts.append(self.of(factor, within=within))
        if _size_of_rational(number) > self._largest:
            number = self._of_number(number, "rate" if has_v else "coefficient")
        return sp.Mul(number, *parts)

    def _of_number(self, number: Expr, role: str) -> Expr:
        """Return a letter, or one over it where that is the shorter number, with the sign of the number."""
        sign, size = (-1, -number) if number < 0 else (1, number)
        if role != "exponent" and (_is_over_decimal(size) or 1 / size in self._given):
            if role == "rate":
                role = "speed"
            return sign / self._named(1 / size, role)
        return sign * self._named(size, role)

    def _named(self, meaning: Expr, role: str) -> Expr:
        if meaning not in self._given:
            symbol = sp.Symbol(self._name(role), positive=True)
            self._given[meaning], self.meanings[symbol] = symbol, meaning
        return self._given[meaning]

    def _name(self, role: str) -> str:
        if role not in self._prefix:
            self._prefix[role] = _free(_NAMES[role], self._taken)
        prefix = self._prefix[role]
        count = 1 + sum(symbol.name.startswith(f"{prefix}_") for symbol in self.meanings)
        return f"{prefix}_{count}"


def _free(names: Iterable[str], taken: Iterable[str]) -> str:
    """Return the first name that begins no other."""
    return next((name for name in names if not any(other.startswith(name) for other in taken)), "number")


def _is_over_decimal(number: Expr) -> bool:
    """Whether a number is no decimal but one over a decimal, as that of v/0.34."""
    return not decimal(number, least=2) and bool(decimal(1 / number, least=2))


def _size_of_rational(number: Expr) -> int:
    return max(abs(int(number.p)), int(number.q))
