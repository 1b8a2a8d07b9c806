"""A criterion of a law as a sum: its terms, each a function of the same arguments."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.evaluation.term_function import TermFunction
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.terms import Term


@dataclass(frozen=True, eq=False)
class TermSum:
    """The terms of a law under a criterion, which a call adds up and code writes down."""

    law: FrictionLaw
    criterion: Criterion
    terms: tuple[Term, ...]

    @cached_property
    def arguments(self) -> dict[str, Expr]:
        """The symbols that a call takes by name: V, N, then the law's parameters."""
        used = self.law.expr.free_symbols
        parameters = {name: p.symbol for name, p in self.law.parameters.items() if p.symbol in used}
        return {"V": symbols.V, "N": symbols.N, **parameters}

    @cached_property
    def functions(self) -> list[TermFunction]:
        """The terms that vary with v, each by its branches: what is added up here, and written as code."""
        arguments = list(self.arguments.values())
        varying = [term for term in self.terms if term.profile.has(symbols.v)]
        return [TermFunction(term, self.criterion, arguments) for term in _join_terms(varying)]


def _join_terms(terms: Sequence[Term]) -> list[Term]:
    """Write terms of one scale whose slopes cancel at rest, as of (1 + v) exp(-v), as one: it keeps its digits."""
    joined: list[Term] = []
    groups: dict[tuple[Expr, Term | Expr], list[Term]] = {}
    for term in terms:
        amplitude = term.amplitude.as_coeff_Mul()[1]
        groups.setdefault((term.scale, term if term.shapes else amplitude), []).append(term)
    for (scale, _), group in groups.items():
        unit = group[0].amplitude.as_coeff_Mul()[1]
        profiles = [term.amplitude / unit * term.profile for term in group]
        slopes = [sp.diff(profile, symbols.v).subs(symbols.v, 0) for profile in profiles]
        if len(group) > 1 and sp.Add(*slopes) == 0 and all(slope.is_finite for slope in slopes):
            joined.append(Term(unit, scale, sp.Add(*profiles)))
        else:
            joined += group
    return joined
