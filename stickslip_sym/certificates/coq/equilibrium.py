"""The equilibrium criterion in Coq: -c/N is the derivative of mu at the belt speed, within a piece of mu."""

from collections.abc import Mapping
from itertools import product

import sympy as sp

from stickslip_sym.certificates.coq.printer import Unsupported
from stickslip_sym.certificates.coq.tactics import Script, solved, unfolded
from stickslip_sym.certificates.coq.words import (
    Generators,
    denominators,
    place_in_condition,
    places_of,
    require_regular,
    roots_of,
    solve_conditions_for_speed,
    square_free,
)
from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Condition, Expr

V = symbols.V
_MOST_PLACES = 3
"""Kinks of a law, both sides of each of which are cases."""


class Slope(Script):
    """A script on the criterion that is the slope at the belt speed."""

    def text(self) -> str:
        """Return the script."""
        mu = solve_conditions_for_speed(self.words(self.form.law.expr, self.v), self.v)
        c = solve_conditions_for_speed(self.words(self.form.expr, self.v), V)
        places = places_of(mu, self.v)
        if len(places) > _MOST_PLACES:
            raise Unsupported(
                f"a script in Coq has the slopes between {_MOST_PLACES} kinks; the law has {len(places)}"
            )
        sides = [dict(zip(places, choice, strict=True)) for choice in product((True, False), repeat=len(places))]
        slopes = [self._slope(label, mu, c, below) for label, below in enumerate(sides)]
        cases = "".join(
            f"destruct (Rdichotomy V {self.whole(place)}) as [? | ?]; [assumption | |]. all: " for place in places
        )
        applied = " | ".join(f"apply slope{label}; assumption" for label in range(len(sides)))
        conditions = "".join(f"V <> {self.whole(place)} -> " for place in places)
        note = "(* At a kink mu has no derivative: the theorem is on all other belt speeds *)\n" if places else ""
        theorem = self.part("slopes", note=note, conditions=conditions, cases=f"{cases}first [{applied}].")
        law = self.law(mu, self.code(c), denominators(c, mu, without=(self.v,)))
        return self.assembled(law, "\n".join([*slopes, theorem]))

    def _slope(self, label: int, mu: Expr, c: Expr, below: Mapping[Expr, bool]) -> str:
        """Prove the slope for a belt speed on one side of each place."""
        piece = _piece_beside(mu, below, self.v)
        value = _piece_beside(c, below, V)
        here = piece.xreplace({self.v: V})
        require_regular(self.v, piece, at_rest=False)
        generators = Generators([here, value])
        roots = [node.args[0].xreplace({self.v: V}) for node in piece.atoms(sp.asinh)]
        moves = ["rewrite ?Ropp_involutive", *self.one_roots(square_free(y**2 + 1) for y in roots)]
        facts, using = self.facts(roots_of(generators.of(here), generators.of(value)))
        moves += [
            *self.rewritten(generators, here, value),
            *self.unified(using, generators.of(here), generators.of(value)),
        ]
        nearby = ""
        for place, is_below in below.items():
            where = "below" if is_below else "above"
            p = self.whole(place)
            test = f"(fun v => v < {p})" if is_below else f"(fun v => {p} < v)"
            nearby += f"apply (nearby V {test}); [apply {where}_nearby; assumption |]. "
        cases = "reflexivity"
        if below:
            cases = (
                "repeat destruct Rlt_dec; change_to_reals; first [exfalso; lra | reflexivity | field; positive]"
            )
        return self.part(
            "slope",
            label=label,
            conditions="".join(
                f"V < {self.whole(place)} -> " if is_below else f"{self.whole(place)} < V -> "
                for place, is_below in below.items()
            ),
            piece=self.code(piece),
            nearby=f"{nearby}apply filter_forall. intros v. intros. unfold mu. {cases}.",
            c=self.code(value),
            cases="repeat destruct Rlt_dec; repeat destruct Rle_dec; try (exfalso; lra); " if below else "",
            facts=f"{facts}{f'unfold{unfolded(piece, value)[1:]}. ' if unfolded(piece, value) else ''}",
            moves="; ".join([*moves, solved(using)]),
        )


def _piece_beside(expr: Expr, below: Mapping[Expr, bool], speed: Expr) -> Expr:
    """Return the piece of an expression on one side of each place."""

    def chosen(*pairs: tuple[Expr, Condition]) -> Expr:
        return next(value for value, holds in pairs if holds == sp.true or below[place_in_condition(holds, speed)])

    return expr.replace(sp.Piecewise, chosen)
