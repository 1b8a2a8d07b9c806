"""Criteria as text of another language: the branches of a call, and no need of this package."""

from collections.abc import Mapping
from typing import Protocol

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import InputError
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.code.language import Language, WrittenFunction, WrittenTerm
from stickslip_sym.formula.code.languages import find
from stickslip_sym.formula.evaluation.branches import Table
from stickslip_sym.formula.evaluation.evaluator import Evaluator, TermFunction
from stickslip_sym.model.law import FrictionLaw

__all__ = ["code", "require_shapes"]


class Fast(Protocol):
    """A `SlopeAverage`, whose terms and branches are written."""

    law: FrictionLaw
    criterion: Criterion
    arguments: dict[str, Expr]
    evaluator: Evaluator


def code(criteria: Mapping[str, tuple[Fast, str]], language: str) -> str:
    """Return criteria by their names, each with words about it, as text of a language of the table.

    Raises
    ------
    InputError
        If there is no such language, or it lacks a function, or a profile's shape has no value.
    """
    written = find(language)
    functions = [_function(name, *one, written) for name, one in criteria.items()]
    texts = [_text(function, written) for function in functions]
    body = written.together(functions, texts)
    return written.head("\n   ".join(function.about for function in functions), body) + body


def require_shapes(law: FrictionLaw) -> None:
    """Refuse a law whose profiles have shapes without values, for their branches cannot be written as code.

    Raises
    ------
    InputError
    """
    missing = sorted(str(symbol) for symbol in _in_shapes(law) if str(symbol) not in law.values)
    if missing:
        raise InputError(
            f"{', '.join(missing)} of the law {law.name or law.text} is a shape of a profile, whose branches are "
            f"made when it has a value; bind it first: law.bind({missing[0]}=...)"
        )


def _in_shapes(law: FrictionLaw) -> set[Expr]:
    return {symbol for term in law.terms for meaning in term.shapes.values() for symbol in meaning.free_symbols}


def _function(name: str, average: Fast, about: str, language: Language) -> WrittenFunction:
    law = average.law
    require_shapes(law)
    fixed = _in_shapes(law)
    free = {key: symbol for key, symbol in average.arguments.items() if symbol not in fixed}
    names = {symbol: language.argument.format(index=i) for i, symbol in enumerate(free.values(), language.first)}
    names |= {symbol: language.number(float(law.values[str(symbol)])) for symbol in fixed}
    values = [float(law.values[key]) if symbol in fixed else 1.0 for key, symbol in average.arguments.items()]
    reach = (
        float("inf") if law.v_max is None else float(law.v_max) / (1 if average.criterion.weight is None else 2)
    )
    return WrittenFunction(
        name,
        tuple(language.argument_name(key) for key in free),
        tuple(bool(symbol.is_nonnegative) for symbol in free.values()),
        tuple(_term(term, values, names, language, law) for term in average.evaluator.terms),
        reach,
        f"{name}: {about}",
    )


def _term(
    term: TermFunction, values: list[float], names: Mapping[Expr, str], language: Language, law: FrictionLaw
) -> WrittenTerm:
    branches = term.branches(term.shape_values(values))
    if branches is None:
        raise InputError(
            f"the term {term.term.expr} of the law {law.name or law.text} has no branches that could be written; "
            "call the function instead"
        )
    return WrittenTerm(
        term.number,
        (names[symbols.V], names[symbols.N], language.number(term.size),
         *(language.text(sp.sympify(base), names) for base in term.bases)),
        (0.0, 1.0, 0.0, *term.amplitude),
        (1.0, 0.0, -1.0, *term.ratio),
        branches.starts,
        branches.branches,
    )  # fmt: skip


def _text(function: WrittenFunction, language: Language) -> str:
    parts, terms = [], []
    for i, term in enumerate(function.terms):
        name, bodies = f"{function.name}_term_{i}", []
        for j, branch in enumerate(term.branches):
            table = f"{function.name}_table_{i}_{j}"
            if isinstance(branch, Table):
                parts.append(language.table(table, branch))
            bodies.append(language.body(branch, table, symbols.V))
        parts.append(language.term(name, term, bodies))
        terms.append(name)
    return language.arranged(language.function(function, terms), parts)
