"""A slope average, integrated term by term: by our own rules first, by SymPy's integrator last.

What comes out of here is a proposal. Antiderivatives carry the certificate by which they are proved, and
every closed form passes a numerical gate before it is returned.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import NoClosedForm
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.finding import search
from stickslip_sym.formula.finding.antiderivatives import antiderivative
from stickslip_sym.formula.finding.harmonics import harmonic_average, kinked_polynomial_average, series_average
from stickslip_sym.formula.finding.search import Found, Nothing
from stickslip_sym.formula.proof.recurrence import AverageSeries, definition
from stickslip_sym.formula.proof.theorems import By, PieceByPiece, ends_of_pieces, value_at
from stickslip_sym.model.expression.pieces import pieces_of
from stickslip_sym.model.terms import grouped

__all__ = ["Part", "Progress", "integrate_terms"]

Progress = Callable[[str], None]
"""Told in a few words what is being done."""


@dataclass(frozen=True)
class Part:
    """One term of a profile, averaged.

    Attributes
    ----------
    term : sympy.Expr
        The term, as a function of v.
    integral : sympy.Expr
        Its average, as an integral.
    value : sympy.Expr
        What it comes to.
    rule : str
        The rule that gave it.
    by : By or None
        The theorem that may prove it; None where only numbers can tell.
    """

    term: Expr
    integral: Expr
    value: Expr
    rule: str
    by: By | None


def integrate_terms(mu: Expr, criterion: Criterion, seconds: float, progress: Progress) -> list[Part]:
    """Integrate a profile term by term.

    Parameters
    ----------
    mu : sympy.Expr
        The coefficient as a function of v.
    criterion : Criterion
        With a weight.
    seconds : float
        For SymPy's integrator, each time that it is asked.
    progress : callable
        Told what is being done, in a few words.

    Raises
    ------
    NoClosedForm
        Saying what was tried.
    """
    parts = []
    for rest, constant in grouped(mu, symbols.v).items():
        split = pieces_of(rest)
        integrate = _by_antiderivatives if criterion.is_polynomial else _by_averages
        found = integrate(*split, criterion, seconds, progress)
        if isinstance(found, Nothing):
            raise NoClosedForm(f"no rule for the {criterion.name} criterion covers it, and {found.reason}")
        rule, value, primitives = found
        integral = definition(constant * rest, criterion)
        whole = constant * value + (criterion.boundary(constant * rest) if primitives else 0)
        by: By | None = None
        if primitives:
            by = PieceByPiece([constant * primitive for primitive in primitives], symbols.v, split[1])
        elif not split[1]:
            by = AverageSeries(rest, criterion, constant, value)
        parts.append(Part(constant * rest, integral, whole, rule, by))
    return parts


_Integrated = tuple[str, Any, list[Any]] | Nothing
"""The rule's name, the value, and the antiderivatives of the pieces where there are such; or why not."""


def _by_antiderivatives(
    pieces: list[Expr], places: list[Expr], criterion: Criterion, seconds: float, progress: Progress
) -> _Integrated:
    """Integrate by an antiderivative of each piece."""
    kernel = criterion.kernel
    primitives, rules = [], []
    for piece in pieces:
        by_rule = antiderivative(piece, kernel, symbols.v)
        if by_rule is not None:
            found = Found(*by_rule)
        elif not places and (average := series_average(piece, symbols.v, symbols.V, criterion)) is not None:
            return "hypergeometric series", average, []
        else:
            limit = 0.0 if _is_hopeless(piece) else seconds
            searched = search.antiderivative(piece, kernel, symbols.v, limit, progress)
            if isinstance(searched, Nothing):
                return searched
            found = searched
        rules.append(found.rule)
        primitives.append(found.value)
    ends = ends_of_pieces(places, 2 * symbols.V)
    try:
        value = sp.Add(
            *[
                value_at(primitive, symbols.v, high) - value_at(primitive, symbols.v, low)
                for primitive, low, high in zip(primitives, ends, ends[1:], strict=False)
            ]
        )
    except ValueError as failure:
        return Nothing(str(failure))
    return ", ".join(dict.fromkeys(rules)), value, primitives


def _is_hopeless(piece: Expr) -> bool:
    """Tell whether SymPy's integrator ends without a result, or not at all.

    Times v^3 it hangs on powers v^p with a free p, and takes 0.4 to 1 s for nothing on hyperbolic functions, which
    the rules integrate as far as they have integrals here.
    """
    powers = piece.atoms(sp.Pow)
    free = any(power.exp.free_symbols and power.has(symbols.v) for power in powers)
    return free or piece.has(sp.tanh, sp.sech, sp.coth, sp.sinh, sp.cosh)


def _by_averages(
    pieces: list[Expr], places: list[Expr], criterion: Criterion, seconds: float, progress: Progress
) -> _Integrated:
    """Take the harmonic average of a term by a rule that gives it at once."""
    if places:
        average = kinked_polynomial_average(pieces, ends_of_pieces(places, 2 * symbols.V), symbols.v, symbols.V)
        if average is None:
            return Nothing("of terms in pieces only polynomials have a harmonic average here")
        return "Fourier sums between kinks", average, []
    found = harmonic_average(pieces[0], symbols.v, symbols.V)
    if found is None:
        # SymPy's integrator is not asked: of these integrals it does none that has no rule, and one wrong.
        return Nothing("SymPy's integrator does no integral of this kind")
    rule, average = found
    return rule, average, []
