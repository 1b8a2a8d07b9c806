"""A criterion of a law, integrated term by term: by our own rules first, by SymPy's integrator last.

What comes out of here is a proposal. Antiderivatives carry the certificate by which they are proved, and
every closed form passes a numerical gate before it is returned.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import NoClosedForm
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.integration import search
from stickslip_sym.formula.integration.antiderivatives import antiderivative
from stickslip_sym.formula.integration.harmonic_proofs import HarmonicSeries
from stickslip_sym.formula.integration.harmonics import harmonic_average, kinked_polynomial_average
from stickslip_sym.formula.integration.search import Found, Nothing
from stickslip_sym.formula.integration.terms import grouped
from stickslip_sym.formula.integration.theorems import By, PieceByPiece, ends_of_pieces, value_at
from stickslip_sym.model.expression.pieces import pieces_of
from stickslip_sym.output import printing

__all__ = ["Part", "Progress", "Told", "integrate_terms", "law_integral"]

Progress = Callable[[str], None]


class Told:
    """What a derivation is at, and what it has found."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress
        self.stage, self.found = "reading the law", "no formula was found"

    def __call__(self, stage: str) -> None:
        """Say what begins."""
        self.stage = stage
        self._progress(stage)


@dataclass(frozen=True)
class Part:
    """One term of a law, integrated.

    Attributes
    ----------
    term : sympy.Expr
        The term, as a function of v.
    integral : sympy.Expr
        Its criterion, as an integral.
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


def law_integral(mu: Expr, criterion: Criterion) -> Expr:
    """Return the criterion of a coefficient mu(v) as an integral."""
    v, V, theta = symbols.v, symbols.V, symbols.theta
    if criterion.is_polynomial:
        kernel = criterion.moment_kernel
        return sp.Integral(mu * kernel, (v, 0, 2 * V)) + _boundary(mu, criterion)
    return sp.Integral(mu.subs(v, V * (1 - sp.cos(theta))) * criterion.angle_kernel, (theta, 0, sp.pi))


def _boundary(mu: Expr, criterion: Criterion) -> Expr:
    """Return the boundary terms of the integration by parts."""
    found = criterion.boundary(mu)
    if found.has(sp.zoo, sp.oo, sp.nan):
        raise NoClosedForm(
            f"the weight of {criterion.name!r} is not 0 at s = -1, where {printing.text(mu)} has no value"
        )
    return found


def integrate_terms(mu: Expr, criterion: Criterion, seconds: float, progress: Progress) -> list[Part]:
    """Integrate a law term by term.

    Parameters
    ----------
    mu : sympy.Expr
        The coefficient as a function of v.
    criterion : Criterion
        With a weight.
    seconds : float
        For SymPy's integrator, all terms together.
    progress : callable
        Told what is being done, in a few words.

    Raises
    ------
    NoClosedForm
        Naming the first term that resisted, and what was tried.
    """
    deadline = time.monotonic() + seconds
    terms = grouped(mu, symbols.v)
    parts = []
    for number, (rest, constant) in enumerate(terms.items(), 1):
        name = printing.text(constant * rest)
        progress(f"term {number} of {len(terms)}: {name}")
        split = pieces_of(rest)
        if split is None:
            raise NoClosedForm(f"two kinks stand in one product, {name}; their order is not known. {_REMEDY}")
        integrate = _by_antiderivatives if criterion.is_polynomial else _by_averages
        found = integrate(*split, criterion, deadline, progress)
        if isinstance(found, Nothing):
            raise NoClosedForm(
                f"the term {name} resisted: none of our rules for the {criterion.name} criterion covers it, and "
                f"{found.reason}. {_REMEDY}"
            )
        rule, value, primitives = found
        term = constant * rest
        whole = constant * value + (_boundary(term, criterion) if criterion.is_polynomial else 0)
        integral = law_integral(term, criterion)
        by: By | None = None
        if primitives:
            by = PieceByPiece([constant * primitive for primitive in primitives], symbols.v, split[1])
        elif not split[1]:
            by = HarmonicSeries(rest, symbols.v, symbols.V, constant * symbols.N, value / symbols.N)
        parts.append(Part(term, integral, whole, rule, by))
    return parts


_REMEDY = (
    "Quadrature serves all the same: stickslip_sym.quadrature.damping; so does the fast function, slope_average, "
    "which stickslip export writes as Python and C"
)

_Integrated = tuple[str, Any, list[Any]] | Nothing
"""The rule's name, the value, and the antiderivatives of the pieces where there are such; or why not."""


def _by_antiderivatives(
    pieces: list[Expr], places: list[Expr], criterion: Criterion, deadline: float, progress: Progress
) -> _Integrated:
    """Integrate by an antiderivative of each piece."""
    kernel = criterion.moment_kernel
    primitives, rules = [], []
    for piece in pieces:
        by_rule = antiderivative(piece, kernel, symbols.v)
        if by_rule is not None:
            found = Found(*by_rule)
        else:
            searched = search.antiderivative(piece * kernel, symbols.v, deadline, progress)
            if isinstance(searched, Nothing):
                return searched
            found = searched
        rules.append(found.rule)
        primitives.append(found.value)
    ends = ends_of_pieces(places, 2 * symbols.V)
    value = sp.Add(
        *[
            value_at(primitive, symbols.v, high) - value_at(primitive, symbols.v, low)
            for primitive, low, high in zip(primitives, ends, ends[1:], strict=False)
        ]
    )
    return ", ".join(dict.fromkeys(rules)), value, primitives


def _by_averages(
    pieces: list[Expr], places: list[Expr], criterion: Criterion, deadline: float, progress: Progress
) -> _Integrated:
    """Take the harmonic average of a term by a rule that gives it at once."""
    if places:
        average = kinked_polynomial_average(pieces, ends_of_pieces(places, 2 * symbols.V), symbols.v, symbols.V)
        if average is None:
            return Nothing("of terms in pieces only polynomials have a harmonic average here")
        return "Fourier sums between kinks", symbols.N * average, []
    found = harmonic_average(pieces[0], symbols.v, symbols.V)
    if found is None:
        integral = law_integral(pieces[0], criterion)
        searched = search.definite_integral(integral, deadline, progress)
        return searched if isinstance(searched, Nothing) else (searched.rule, searched.value, [])
    rule, average = found
    return rule, symbols.N * average, []
