"""Reading a friction coefficient: text or a SymPy expression becomes an expression of this package's symbols.

A name that is probably no parameter, but a constant or the slip speed v misspelt, is refused or warned of. One
that is described, by its unit or as a `Parameter`, is what its description says, and never suspect.
"""

import math
import sys
import warnings
from collections.abc import Sequence
from difflib import get_close_matches

import sympy as sp
from sympy.core.parameters import global_parameters

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import InputError, InputWarning
from stickslip_sym.core.functions import fold, row
from stickslip_sym.core.numbers import exact
from stickslip_sym.core.remedies import Argument, Remedy
from stickslip_sym.model.expression.canonical_form import HIGHEST_POWER_OF_SUM, HIGHEST_POWER_OF_V, canonical_form
from stickslip_sym.model.expression.parameters import Parameter
from stickslip_sym.model.expression.parsing import parse_expression
from stickslip_sym.output.printing import text

_MAX_TERMS = 600
_MAX_FUNCTIONS = 6  # in each other: of a tower such as exp(exp(...)) no computer holds the value

_CONSTANTS = {
    "e": "write exp(x) for a power of Euler's number, and exp(1) for the number",
    **dict.fromkeys(("exp1", "exp_1", "euler", "euler_e", "e_euler"), "write exp(1)"),
    **dict.fromkeys(("pi", "pii", "ppi", "pie", "py"), "write pi"),
    **dict.fromkeys(("inf", "infinity", "infty", "oo", "zoo", "nan"), "a law has finite numbers only"),
}
"""Names of constants, in small letters, with what to do."""
_SPEEDS = (
    "speed", "velocity", "velo", "vel", "slip", "vrel", "vslip", "vsliding", "vslide", "vrelative", "relv",
    "slipspeed", "slipvelocity", "slidingspeed", "slidingvelocity", "relativespeed", "relativevelocity",
    "relspeed", "relvelocity", "xdot", "dxdt",
)  # fmt: skip
"""Words for the slip speed, in small letters and without underscores."""
_LONG_SPEEDS = [word for word in _SPEEDS if len(word) > 4]
_SIMILARITY_RATIO = 0.75
"""Difflib's ratio, of similar words: a letter wrong, missing or added in a word of four or more."""
_LIKE_V = frozenset({"vr", "vv", "v"})  # besides v: perhaps a reference speed
_DEPTH = 5  # calls from a line that makes a law to the warning
_NAMES_SHOWN = 5  # names in a message


def require_evaluation() -> None:
    """Refuse to compute where SymPy was told to leave expressions as they are."""
    if not global_parameters.evaluate:
        raise InputError(
            "SymPy does not evaluate within sympy.evaluate(False), and nothing here can be computed so; "
            "leave that block, or open one of sympy.evaluate(True)"
        )


def as_text(formula: object) -> str:
    """Return a coefficient as the text that is read: as it was typed, or of a SymPy expression or number."""
    if isinstance(formula, str):
        return formula
    if isinstance(formula, int | float) and not isinstance(formula, bool):
        return text(exact(formula, "the coefficient"))
    if not isinstance(formula, sp.Expr):
        raise InputError(f"a law is text or a SymPy expression, got {type(formula).__name__}")
    reserved = [symbol for symbol in formula.free_symbols if symbol.name == "lambda"]
    expr: Expr = formula.xreplace(dict.fromkeys(reserved, sp.Symbol("lambda_")))
    for symbol in expr.free_symbols:  # every name in it is that of a parameter, or v
        if symbol.name != "v":
            Parameter(symbol.name)
    try:
        return text(expr.xreplace({number: _shortest_decimal(number) for number in expr.atoms(sp.Float)}))
    except ValueError:  # Python prints no integer of over 4300 digits
        raise InputError("a number in the formula has too many digits") from None


def _shortest_decimal(number: Expr) -> Expr:
    """Return a SymPy Float as the shortest decimal that is read as it; a longer one than a double as it stands."""
    if number._prec <= sys.float_info.mant_dig:
        return sp.Rational(repr(float(number)))
    return sp.Rational(number)


def read_formula(formula: str, table: dict[str, Parameter], *, constant: bool = False) -> Expr:
    """Read a coefficient; parameters that it uses and `table`, of those described, does not have are added there.

    A static coefficient is `constant`: it may not depend on v.
    """
    require_evaluation()
    names: set[str] = set()
    undescribed: list[str] = []

    def symbol(name: str) -> Expr:
        names.add(name)
        if name == "v":
            return symbols.v
        if name not in table:
            _check_constant(name)
            table[name] = Parameter(name)
            undescribed.append(name)
        return table[name].symbol

    expr = parse_expression(formula, symbol, frozenset(table))
    _check_value(expr)
    expr = canonical_form(expr)
    if constant and expr.has(symbols.v):
        raise InputError("the static coefficient is one number; it cannot depend on v")
    _check_speed(undescribed, has_v=constant or "v" in names, bare=expr.is_Symbol)
    return expr


# -- what later algebra can hold -------------------------------------------------------------------


def _check_value(expr: Expr) -> None:
    """Refuse what is not real, and powers that later algebra could not expand in any reasonable time."""
    if expr.has(sp.zoo, sp.oo, sp.nan, sp.I):
        raise InputError(f"the formula is not finite and real: it reduces to {str(expr)[:60]}")
    for node in expr.atoms(sp.Pow):
        base, exponent = node.args
        if base.is_negative and exponent.is_integer is False:
            raise InputError(f"{str(node)[:60]} is not real: only whole powers of a negative number are")
        if base == symbols.v and exponent.is_number and abs(exponent) > HIGHEST_POWER_OF_V:
            raise InputError(f"{node} is too high a power of v; at most v^{HIGHEST_POWER_OF_V} is supported")
        if base.is_Add and exponent.is_Integer and abs(exponent) > HIGHEST_POWER_OF_SUM:
            raise InputError(
                f"{str(node)[:60]} is too high a power of a sum; at most (...)^{HIGHEST_POWER_OF_SUM} is supported"
            )
    if fold(expr, _nested) > _MAX_FUNCTIONS:
        raise InputError(f"more than {_MAX_FUNCTIONS} functions stand in each other; write a simpler formula")
    if fold(expr, _bound_of_terms) > _MAX_TERMS:
        raise InputError(
            f"the formula has over {_MAX_TERMS} terms when its products are multiplied out; shorten it"
        )


def _nested(node: Expr, parts: list[int]) -> int:
    """Return how many functions stand in each other."""
    return max(parts, default=0) + (row(node) is not None)


def _bound_of_terms(node: Expr, parts: list[int]) -> int:
    """Return a bound on the number of terms after expansion."""
    if node.is_Add:
        return sum(parts)
    if node.is_Mul:
        return math.prod(parts)
    if node.is_Pow and node.exp.is_Integer:
        exponent = abs(int(node.exp))
        return math.comb(parts[0] + exponent - 1, exponent)
    return max(parts, default=1)


# -- names that are no parameters ------------------------------------------------------------------


def _check_constant(name: str) -> None:
    """Refuse the name of a parameter that is meant as a number."""
    plain = name.rstrip("_")
    if advice := "a law is real" if plain == "I" else _CONSTANTS.get(plain.lower()):
        raise InputError(f"{name!r} looks like a constant; {advice}. ", *_or_declare(name))


def _check_speed(names: Sequence[str], *, has_v: bool, bare: bool) -> None:
    """Refuse parameters without a description that are meant as the slip speed, or warn of them.

    A word such as speed is refused, and in a formula without v every name that begins with v. Of vr beside v, and
    of a formula of several parts without v, it warns; a `bare` one, a single name, is meant as a constant.
    """
    for name in names:
        plain = name.replace("_", "").lower()
        # Not vel_0 nor speed1: a digit makes it one speed among others.
        similar = plain.isalpha() and get_close_matches(plain, _LONG_SPEEDS, n=1, cutoff=_SIMILARITY_RATIO)
        if plain in _SPEEDS or similar or (not has_v and name[0] in "vV"):
            missing = "" if has_v else "the formula has no v, and "
            what = f"{missing}{name!r} looks like the slip speed, which is v"
            raise InputError(f"{what}; write v. ", *_or_declare(name))
        if has_v and plain in _LIKE_V:
            _warn(f"{name!r} is taken for a parameter; the slip speed is v. ", *_or_declare(name))
    if names and not (has_v or bare):
        shown = ", ".join(names[:_NAMES_SHOWN])
        _warn(
            f"the formula has no v, so mu is the same at every slip speed; its parameters: {shown}. If one of "
            "them is the slip speed, write v; if mu is constant, add 0*v to say so"
        )


def _or_declare(name: str) -> tuple[str, Remedy]:
    return "If it is a parameter, say its unit: ", Argument("units", {name: ...})


def _warn(*parts: str | Remedy) -> None:
    warnings.warn(InputWarning(*parts), stacklevel=_DEPTH)
