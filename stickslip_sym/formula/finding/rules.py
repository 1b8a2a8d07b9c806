"""A slope average, integrated term by term: by our own rules first, by SymPy's integrator last.

What comes out of here is a proposal. It carries the theorem by which it may be proved, and
every closed form passes a numerical gate before it is returned.
"""

from dataclasses import dataclass
from itertools import pairwise

import sympy as sp
from sympy.functions.elementary.hyperbolic import HyperbolicFunction

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import NoClosedForm
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.finding import search
from stickslip_sym.formula.finding.antiderivatives import antiderivative
from stickslip_sym.formula.finding.harmonic_rules import average_of_pieces, harmonic_average
from stickslip_sym.formula.finding.search import NothingFound
from stickslip_sym.formula.proof.normal_form import is_integral_of_binomial
from stickslip_sym.formula.proof.recurrence import AverageSeries, definition
from stickslip_sym.formula.proof.theorems import By, PieceByPiece, ends_of_pieces, value_at
from stickslip_sym.model.expression.pieces import pieces_of
from stickslip_sym.model.leading_terms import has_limit_at_rest
from stickslip_sym.model.terms import grouped


@dataclass(frozen=True)
class Part:
    """One term of a profile, averaged."""

    integral: Expr
    value: Expr
    rule: str
    by: By | None


def integrate_terms(mu: Expr, criterion: Criterion, *, search_too: bool, end: Expr | None = None) -> list[Part]:
    """Integrate a profile mu(v) term by term; SymPy's integrator is asked last, or not at all.

    - `end`: the speed at which mu ends, above all slip speeds.
    """
    parts = []
    for rest, constant in _split_profile(mu).items():
        pieces, places = pieces_of(rest)
        ends = ends_of_pieces(places, 2 * symbols.V)
        try:
            rule, value, primitives = _averaged(pieces, ends, criterion, search_too=search_too)
        except NothingFound as nothing:
            raise NoClosedForm(f"no rule for the {criterion.name} criterion covers it, and {nothing}") from None
        term = constant * rest
        by: By | None = None
        whole = constant * value + (criterion.boundary(term) if criterion.is_polynomial else 0)
        if primitives and all(map(is_integral_of_binomial, value.atoms(sp.hyper))):
            by = PieceByPiece([constant * primitive for primitive in primitives], symbols.v, end)
        elif not places:
            by = AverageSeries(rest, criterion, constant, whole / constant)
        parts.append(Part(definition(term, criterion), whole, rule, by))
    return parts


def _split_profile(mu: Expr) -> dict[Expr, Expr]:
    """Split a profile into functions of v and their constant factors; what is finite at 0 together is one."""
    terms = grouped(mu, symbols.v)
    infinite = [
        rest for rest in terms if rest.subs(symbols.v, 0).is_finite is not True and not rest.has(sp.Piecewise)
    ]
    if len(infinite) > 1 and has_limit_at_rest(mu):
        whole = sp.Add(*[terms.pop(rest) * rest for rest in infinite])
        terms[whole] = sp.S.One
    return terms


def _averaged(
    pieces: list[Expr], ends: list[Expr], criterion: Criterion, *, search_too: bool
) -> tuple[str, Expr, list[Expr]]:
    """Return a rule's name, the average of a term in pieces, and their antiderivatives where there are such."""
    v = symbols.v
    V = symbols.V
    average: tuple[str, Expr] | None
    if not criterion.is_polynomial:
        if len(pieces) > 1:
            of_pieces = average_of_pieces(pieces, ends, v, V)
            average = None if of_pieces is None else ("Fourier sums between kinks", of_pieces)
            reason = "of terms in pieces only polynomials, and powers of 1/v, have a harmonic average here"
        else:
            average = harmonic_average(pieces[0], v, V)
            # SymPy's integrator is not asked: of these integrals it does none that has no rule, and one wrong.
            reason = "SymPy's integrator does no integral of this kind"
        if average is None:
            raise NothingFound(reason)
        return (*average, [])
    applied = []
    for piece in pieces:
        primitive = antiderivative(piece, criterion.kernel, v)
        if primitive is None:
            if not search_too or _is_hopeless(piece):
                raise NothingFound(f"{search.RULE} was not asked")
            primitive = search.RULE, search.search_antiderivative(piece, criterion.kernel, v)
        applied.append(primitive)
    primitives = [primitive for _, primitive in applied]
    try:
        values = [
            value_at(primitive, v, high) - value_at(primitive, v, low)
            for primitive, (low, high) in zip(primitives, pairwise(ends), strict=True)
        ]
    except ValueError as failure:
        raise NothingFound(str(failure)) from None
    return ", ".join(dict.fromkeys(rule for rule, _ in applied)), sp.Add(*values), primitives


def _is_hopeless(piece: Expr) -> bool:
    """Tell whether SymPy's integrator ends without a result, or not at all.

    Times v^3 it hangs on powers v^p with a free p, and takes 0.4 to 1 s for nothing on hyperbolic functions, which
    the rules integrate as far as they have integrals here.
    """
    free = any(power.exp.free_symbols and power.has(symbols.v) for power in piece.atoms(sp.Pow))
    return free or piece.has(HyperbolicFunction)
