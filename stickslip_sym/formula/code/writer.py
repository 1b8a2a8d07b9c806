"""A criterion as text of another language: the fast function's branches, and no need of this package.

What the fast function leaves to arbitrary precision, the text averages by Gauss rules like all that has no
branch: there it is as accurate as the slope of mu in double precision.
"""

import re
from collections.abc import Mapping, Sequence

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.criteria.gauss import COARSE, FINE, FIRST_PANEL, angle_weight, gauss_legendre, weight_of
from stickslip_sym.formula.code.dialect import numeric_list
from stickslip_sym.formula.code.languages import Language, find
from stickslip_sym.formula.evaluation.branches import Branch, LogTail, Series, Table
from stickslip_sym.formula.evaluation.closed import Closed, Formula
from stickslip_sym.formula.evaluation.conditioning import conditioned, speed_scales
from stickslip_sym.formula.evaluation.stable import StableFunction
from stickslip_sym.formula.evaluation.term import TermFunction
from stickslip_sym.model.expression.pieces import jumps, places

__all__ = ["code"]

_PRIVATE = re.compile(r"\b_(?!scale\b|unscale\b|product\b|broadcast\b|erf\b)(?=[a-z])")
"""How the names of what belongs to one function begin, other than those that all share."""
_MOST_HALVINGS = 500  # of panels in a scene: where terms cancel, the rules never agree to the last digit
_PUBLIC = re.compile(r"\bdamping\b(?=[(:])")


def code(functions: Mapping[str, StableFunction], title: str, language: str) -> str:
    """Return functions of V, N, ... by their names as text of a language of the table.

    Raises
    ------
    InputError
        If there is no such language.
    NoClosedForm
        For a function that not every language here has.
    """
    written = find(language)
    parts = [written.head(title, products=any(_branched(function) for function in functions.values()))]
    for name, function in functions.items():
        text = _body(function, written)
        if len(functions) > 1:
            text = _PRIVATE.sub(f"_{name}_", text)
        parts.append(_PUBLIC.sub(name, text))
    return "\n".join(parts)


def _branched(function: StableFunction) -> list[TermFunction] | None:
    """Return the terms of a criterion that have branches; None if it is averaged by Gauss rules."""
    terms = function.terms
    if terms is None or any(term.shapes for term in terms):
        return None
    profiles = [term.profile((), 1) for term in terms]
    return terms if all(profile is not None and all(profile.branches) for profile in profiles) else None


def _body(function: StableFunction, language: Language) -> str:
    names = {symbol: language.dialect.name(symbol) for symbol in function.arguments}
    arguments = list(names.values())
    terms = _branched(function)
    parts = []
    if terms is None or len(terms) > 1:
        parts.append(_gauss(function, names, language))
    for number, term in enumerate(terms or []):
        profile = term.profile((), 1)
        assert profile is not None
        bases = [language.dialect.text(base, names) for base in term.base_exprs]
        branches = [
            (
                start,
                *_branch(branch, language, f"_table_{number}"),
                _product(term, branch.power, bases, language),
            )
            for start, branch in zip(profile.starts, profile.branches, strict=True)
            if branch is not None
        ]
        ratio = language.product(repr(1 / term.size), _factors(bases, term.ratio), language.one)
        parts.append(language.term(number, arguments, ratio, branches))
    parts.append(
        language.total([str(symbol) for symbol in names], arguments, None if terms is None else len(terms))
    )
    return "\n".join(part for part in parts if part)


def _product(term: TermFunction, power: float, bases: list[str], language: Language) -> str:
    exponents = [a + power * e for a, e in zip(term.amplitude, term.ratio, strict=True)]
    number = term.number * term.size**-power
    return str(language.product(repr(number), _factors(bases, exponents), "g"))


def _factors(bases: Sequence[str], exponents: Sequence[float]) -> list[tuple[str, float]]:
    return [(base, e) for base, e in zip(bases, exponents, strict=True) if e]


def _branch(branch: Branch, language: Language, table: str) -> tuple[str, str]:
    """Return definitions that stand before the function, and the lines that compute g from r."""

    def lines(**values: str) -> str:
        return "\n".join(language.line.format(name=name, value=value) for name, value in values.items())

    V = symbols.V
    if isinstance(branch, Series):
        z = {1.0: "r", 2.0: "r*r", -1.0: "1.0/r", -2.0: "(1.0/r)*(1.0/r)", -0.5: f"1.0/{language.sqrt}(r)"}[
            branch.variable
        ]
        if branch.shift or branch.stretch != 1:
            z = f"({z} - {branch.shift!r})*{branch.stretch!r}"
        g = _horner(branch.coefficients)
        return "", lines(z=z, g=f"({g})*{language.exp}({-branch.decay!r}*r)" if branch.decay else g)
    if isinstance(branch, Closed):
        parts = []
        for function, coefficients in branch.parts:
            factor = "" if function is None else f"*({language.dialect.text(function.expr, {V: 'r'})})"
            parts.append(f"({_horner(coefficients)}){factor}")
        return "", lines(z="1.0/r", g=" + ".join(parts))
    if isinstance(branch, Formula):
        return "", lines(g=language.dialect.text(branch.compiled.expr, {V: "r"}))
    if isinstance(branch, LogTail):
        tail = f" + {branch.slope!r}*{language.log}(r)" if branch.slope else ""
        return "", lines(g=f"{branch.constant!r}{tail} + 0.0*r")
    assert isinstance(branch, Table)
    return language.table(table, branch.rows), lines(g=f"{table}_at(r, {branch.first})")


def _horner(coefficients: Sequence[float]) -> str:
    """Return a polynomial in z, nested."""
    *rest, last = (repr(c) for c in coefficients)
    text = last if rest else f"{last} + 0.0*z"
    for coefficient in reversed(rest):
        text = f"{coefficient} + z*({text})" if text != last else f"{coefficient} + z*{last}"
    return text


def _gauss(function: StableFunction, names: dict[Expr, str], language: Language) -> str:
    """Return the slope, its scales and its kinks, and the adaptive average."""
    arguments = list(names.values())
    slope = conditioned(sp.diff(function.mu, symbols.v))
    # A slope that does not depend on v has the shape of v too.
    text = language.dialect.text(slope, names | {symbols.v: "v"}) + ("" if slope.has(symbols.v) else " + 0.0*v")
    slope_function = language.function("_slope", ["v", *arguments], text)
    if function.criterion.weight is None:
        return slope_function + language.function("_criterion", arguments, f"-N*_slope(V, {', '.join(arguments)})")
    scales = [language.dialect.text(scale, names) for scale in speed_scales(slope, symbols.v)]
    kinks = [language.dialect.text(place, names) for place in places(function.mu)]
    steps = [
        (language.dialect.text(place, names), language.dialect.text(height, names))
        for place, height in jumps(function.mu)
    ]
    m, sine, angle, place, V = sp.symbols("m sine angle place V", positive=True)
    given = {symbol: symbol.name for symbol in (m, sine, angle, place, V)}
    at_jump = language.dialect.text(weight_of(function.criterion, m, place / V, 2 - place / V), given)
    weight = language.dialect.text(
        angle_weight(function.criterion, m, 2 * sine**2, 2 * sp.cos(angle, evaluate=False) ** 2), given
    )
    rules = [
        (name, numeric_list(numbers, language.brackets))
        for n, label in ((COARSE, "coarse"), (FINE, "fine"))
        for name, numbers in zip((f"_{label}_nodes", f"_{label}_weights"), gauss_legendre(n), strict=True)
    ]
    return slope_function + language.average(
        arguments, scales, kinks, weight, rules, (COARSE, FINE), FIRST_PANEL, _MOST_HALVINGS,
        language.steps(steps, at_jump),
    )  # fmt: skip
