"""Criteria with polynomial weights in Coq: c is the integral of N mu K over the slip speeds from 0 to 2 V.

The package supplies an antiderivative of each profile between its kinks; Coq checks its derivative, and its rise.
A law is a sum of profiles at scales: one lemma a profile, in speeds in units of its scale, and one a term.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import sympy as sp

from stickslip_sym.certificates.coq.printer import CoqPrinter, Unsupported
from stickslip_sym.certificates.coq.tactics import ROOT_OF_PRODUCT, Script, solved, unfolded
from stickslip_sym.certificates.coq.words import (
    Generators,
    bounds_of,
    denominators,
    factor_out_range,
    functions_of,
    places_of,
    reduce_squared_roots,
    require_regular,
    roots_of,
    solve_conditions_for_speed,
    square_free,
)
from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Condition, Expr, Substitution
from stickslip_sym.formula.average import Average
from stickslip_sym.formula.closed_form import ClosedForm
from stickslip_sym.formula.derivation import Step
from stickslip_sym.formula.proof.theorems import PieceByPiece
from stickslip_sym.model.expression.pieces import pieces_of
from stickslip_sym.model.terms import Term
from stickslip_sym.output import printing

N, V = symbols.N, symbols.V


@dataclass(frozen=True)
class Profile:
    """The integral of a profile times K, in speeds in units of its scale, in the words of a script."""

    label: int
    shapes: tuple[Expr, ...]
    relations: tuple[Condition, ...]
    expr: Expr
    pieces: tuple[Expr, ...]
    primitives: tuple[Expr, ...]
    ends: tuple[Expr, ...]
    value: Expr

    @cached_property
    def generators(self) -> Generators:
        """The exponentials that stand in its formulas."""
        return Generators([self.expr, *self.pieces, *self.primitives, self.value])


@dataclass(frozen=True)
class LawTerm:
    """A term of the law: a profile with its amplitude, its scale, and what its shapes are."""

    label: int
    term: Term
    profile: Profile
    amplitude: Expr
    scale: Expr
    shapes: dict[Expr, Expr]


class Integral(Script):
    """A script on a criterion with a polynomial weight."""

    def __init__(self, form: ClosedForm) -> None:
        super().__init__(form)
        self.criterion = self.form.criterion
        self.u, self.r = (sp.Dummy(name, positive=True) for name in "ur")
        self.names |= {self.u: "u", self.r: "r"}
        self.rows = list(self._rows())
        self.profiles = list(dict.fromkeys(row.profile for row in self.rows))

    # -- the terms -----------------------------------------------------------------------------------

    def _rows(self) -> Iterator[LawTerm]:
        averages = dict(self.form.averages)
        number = 0
        profiles = dict[Average | None, list[Profile]]()
        for term in self.form.terms:
            average = averages.get(term)
            if average not in profiles:
                profiles[average] = list(self._profiles(average, sum(map(len, profiles.values()))))
            for profile in profiles[average]:
                number += 1
                yield self._row(number, profile, term)

    def _profiles(self, average: Average | None, count: int) -> Iterator[Profile]:
        """Yield the parts of a profile, averaged one by one, or the profile 1; `count` are there before."""
        if average is None:
            yield self._one(count + 1)
            return
        for label, step in enumerate(average.steps, count + 1):
            yield self._profile(label, average, step)

    def _row(self, number: int, profile: Profile, term: Term) -> LawTerm:
        shapes = {shape: self.words(value, self.v) for shape, value in term.shapes.items()}
        return LawTerm(
            number, term, profile, self.words(term.amplitude, self.v), self.words(term.scale, self.v), shapes
        )

    def _one(self, label: int) -> Profile:
        """Return the profile 1, of which K has to be integrated alone."""
        kernel = self.criterion.kernel.xreplace({V: self.r, symbols.v: self.u})
        primitive = sp.integrate(sp.expand(kernel), self.u)
        value = sp.simplify(primitive.subs(self.u, 2 * self.r) - primitive.subs(self.u, 0))
        return Profile(label, (), (), sp.S.One, (sp.S.One,), (primitive,), (sp.S.Zero, 2 * self.r), value)

    def _profile(self, label: int, average: Average, step: Step) -> Profile:
        """Return what a step of the package says of the average of a profile."""
        if not isinstance(step.by, PieceByPiece):
            raise Unsupported(
                f"a script in Coq needs an antiderivative, and the average of {printing.text(average.profile)} is "
                f"proved without one, by {type(step.by).__name__}"
            )
        for shape in average.shapes:
            self.name(shape)

        def words(expr: Expr) -> Expr:
            return self.words(average.in_shapes(expr).xreplace({V: self.r}), self.u)

        (integral,) = step.statement.lhs.atoms(sp.Integral)
        kernel = self.criterion.kernel
        boundary = step.statement.lhs - integral
        expr = average.in_shapes(_divided(integral.function, kernel))
        parts = step.by.parts(average.in_shapes(integral.function), sp.S.Zero, 2 * V)
        primitives, _, lows, highs = zip(*parts, strict=True)
        if any(end.has(sp.Max) for end in (*lows, *highs)):
            raise Unsupported(
                "a script in Coq has no kinks whose places may be negative, or whose order is unknown"
            )
        require_regular(self.u, *map(words, (*primitives, *pieces_of(expr)[0])), at_rest=True)
        return Profile(
            label,
            average.shapes,
            average.conditions,
            solve_conditions_for_speed(words(expr), self.u),
            tuple(map(words, pieces_of(expr)[0])),
            tuple(map(words, primitives)),
            tuple(map(words, (*lows, highs[-1]))),
            words(step.statement.rhs - boundary),
        )

    # -- texts of terms ------------------------------------------------------------------------------

    def _function(self, row: LawTerm) -> str:
        """Return the profile of a term as a function of speeds in units of its scale."""
        shapes = [self.whole(value) for shape, value in row.shapes.items() if row.profile.expr.has(shape)]
        return " ".join([f"g{row.profile.label}", *shapes])

    def _value(self, row: LawTerm) -> str:
        """Return the integral of the profile of a term."""
        value = row.profile.generators.of(row.profile.value)
        given: list[tuple[Expr, str]] = [(self.r, f"(V / {self.whole(row.scale)})")]
        given += [(shape, self.whole(meaning)) for shape, meaning in row.shapes.items()]
        texts = [text for letter, text in given if value.has(letter)]
        return f"{' '.join([f'I{row.profile.label}', *texts])} / {self.whole(row.scale)}"

    def _at(self, row: LawTerm) -> str:
        return f"{self._function(row)} (v / {self.whole(row.scale)})"

    # -- one profile ---------------------------------------------------------------------------------

    def average(self, profile: Profile) -> str:
        """State and prove the integral of a profile."""
        of = profile.generators.of
        label = profile.label
        pieces = [*map(of, profile.pieces)]
        primitives = [*map(of, profile.primitives)]
        value = of(profile.value)
        names = [f"{label}_{i}" for i in range(len(pieces))]
        ends = ["0", *(f"e{name}" for name in names[1:]), "(2 * r)"]
        limits = list(pairwise(ends))
        definitions = [
            f"Definition {end} : R := {self.code(at)}."
            for end, at in zip(ends[1:-1], profile.ends[1:-1], strict=True)
        ]
        definitions += [
            f"Definition A{name} (u : R) : R := {self.code(primitive)}."
            for name, primitive in zip(names, primitives, strict=True)
        ]
        proofs = list[str]()
        joined = ""
        for i, name in enumerate(names):
            proofs.append(self._piece(name, pieces[i], primitives[i], *limits[i]))
            proofs.append(self._within(profile, i, name, *limits[i]))
            joined = f"(integral_chain _ _ _ _ _ _ {joined} within{name})" if joined else f"within{name}"
        rises = [f"(A{name} {high} - A{name} {low})" for name, (low, high) in zip(names, limits, strict=True)]
        excluded = denominators(value, *primitives, *pieces, without=(self.u,))
        return self.part(
            "average",
            label=label,
            variables=" ".join(map(self.name, (self.r, *profile.shapes))),
            hypotheses=self.hypotheses((self.r, *profile.shapes), excluded, profile.relations, f"{label}_"),
            profile=self.code(profile.expr),
            value=self.code(value),
            definitions="\n".join(definitions),
            pieces="\n".join(proofs),
            rises=" + ".join(rises),
            joined=joined,
            unfolded=", ".join([f"I{label}", *(f"A{name}" for name in names), *ends[1:-1]])
            + unfolded(*primitives),
            equality=self._rise(value, primitives, profile.ends),
        )

    def _order(self, *limits: str) -> str:
        """Return a tactic that proves the order of the ends of a piece."""
        inner = [end for end in limits if end.startswith("e")]
        if not inner:
            return "lra"
        return f"(unfold {', '.join(inner)}, Rmin, Rmax; repeat destruct Rle_dec; lra)"

    def _piece(self, name: str, piece: Expr, primitive: Expr, low: str, high: str) -> str:
        """Prove the integral of the formula of one piece, by the derivative of its antiderivative."""
        roots = roots_of(primitive, piece)
        facts, using = self.facts(roots)
        moves = ["rewrite ?Ropp_involutive"] if "polylog" in self.code(primitive) else []
        moves += self.one_roots(square_free(node.args[0] ** 2 + 1) for node in primitive.atoms(sp.asinh))
        moves += [f"value sqrt {self.whole(root.args[0])} by equal" for root in roots if root.has(self.u)]
        moves += [head for head in self.unified(using, piece, primitive) if head != "split_powers"]
        is_open = any(self._vanishes_at_rest(node) for node in functions_of(primitive, piece))
        return self.part(
            "open" if is_open else "closed",
            label=name,
            piece=self.code(piece),
            low=low,
            high=high,
            order=self._order(low, high),
            derivative=f"{facts}unfold A{name}, K{unfolded(primitive, piece)}. "
            f"auto_derive; [positive | {'; '.join([*moves, solved(using)])}].",
            unfolded=unfolded(piece),
        )

    def _vanishes_at_rest(self, node: Expr) -> bool:
        """Tell whether a function has no derivative where the slip speed is 0."""
        name = node.func.__name__
        return name in ("power", "lower_gamma") or (name == "sqrt" and node.args[0].subs(self.u, 0) == 0)

    def _within(self, profile: Profile, i: int, name: str, low: str, high: str) -> str:
        """Prove the integral of the profile between the ends of one piece."""
        piece = profile.pieces[i]
        cases = ""
        if len(profile.pieces) > 1:
            names = ", ".join([end for end in (low, high) if end.startswith("e")] + ["Rmin", "Rmax"])
            cases = f"revert range. unfold {names}. repeat destruct Rlt_dec; repeat destruct Rle_dec; intro; "
            cases += "try (exfalso; lra). all: "
        same = "first [reflexivity | field; positive]."
        if profile.generators.of(piece) != piece:
            same = self.equation(profile.generators, piece, values=False)
        same = f"unfold g{profile.label}. {cases}{same}"
        return self.part(
            "within",
            label=name,
            profile=profile.label,
            low=low,
            high=high,
            order=self._order(low, high),
            same=same,
        )

    def _rise(self, value: Expr, primitives: Sequence[Expr], ends: Sequence[Expr]) -> str:
        """Prove that antiderivatives rise by the value."""
        moving = [root for root in roots_of(*primitives) if root.has(self.u)]
        at: list[Substitution] = [{self.u: end} for end in ends]
        radicands = [root.args[0].subs(letters) for root in moving for letters in at]
        made = [square_free(y) for y in radicands if y != 0]
        factors = list[Expr]()
        for y, _ in made:
            if y != 1:
                factors += sp.Mul.make_args(y)
        fixed = [root for root in roots_of(*primitives) if not root.has(self.u)]
        facts, using = self.facts(roots_of(value, *fixed, *map(sp.Function("sqrt"), factors)))
        moves = ["value sqrt 0 by equal", "rewrite ?sqrt_0"] if 0 in radicands else []
        moves += self.one_roots(made)
        if any(y.is_Mul for y, _ in made):
            moves.append(ROOT_OF_PRODUCT)
        moves += [*self.valued(using, value, *primitives, at=at), *self.unified(using, value, *primitives)]
        moves.append(solved(using))
        cases = ""
        if not bounds_of(value) <= bounds_of(*ends):
            cases = "unfold Rmin, Rmax; repeat destruct Rle_dec; try (exfalso; nra). all: "
        return f"{facts}{cases}{'; '.join(moves)}."

    # -- the law -------------------------------------------------------------------------------------

    def text(self) -> str:
        """Return the script."""
        mu = solve_conditions_for_speed(self.words(self.form.law.expr, self.v), self.v)
        c = self.words(self.form.expr, self.v)
        shares = {term: self.words(share, self.v) for term, share in self.form.shares}
        if self._boundary():
            shares = {}
        values = [self._value_of(row) for row in self.rows]
        inner = [expr.xreplace(row.shapes) for row in self.rows for expr in self._excluded(row.profile)]
        excluded = dict.fromkeys([*denominators(c, mu, *values, *self._letters(), without=(self.v,)), *inner])
        kernel = self.criterion.kernel.xreplace({symbols.v: self.v}).replace(
            _is_odd, lambda node: -((-node.base) ** node.exp)
        )
        in_code = " + ".join(f"({self.code(share)})" for share in shares.values()) or self.code(c)
        law = self.law(mu, in_code, excluded, self.part("kernel", kernel=self.code(kernel)))
        total = self._sum(mu, c, shares)
        return self.assembled(
            law, "\n".join([*map(self.average, self.profiles), *map(self._term, self.rows), total])
        )

    def _excluded(self, profile: Profile) -> list[Expr]:
        of = profile.generators.of
        exprs = map(of, (profile.value, *profile.primitives, *profile.pieces))
        return denominators(*exprs, without=(self.u, self.r))

    def _value_of(self, row: LawTerm) -> Expr:
        return reduce_squared_roots(row.profile.value.xreplace({**row.shapes, self.r: V / row.scale}))

    def _letters(self) -> list[Expr]:
        """Return the amplitudes, scales and shapes of the terms."""
        return [expr for row in self.rows for expr in (row.amplitude, row.scale, *row.shapes.values())]

    def _term(self, row: LawTerm) -> str:
        return self.part(
            "term",
            label=row.label,
            profile=self._function(row),
            scale=self.whole(row.scale),
            value=self._value(row),
            average=row.profile.label,
        )

    def _sum(self, mu: Expr, c: Expr, shares: Mapping[Term, Expr]) -> str:
        """State and prove the theorem, by the sum of the terms."""
        amplitudes = [self.whole(row.amplitude) for row in self.rows]
        joined = ""
        for amplitude, row in zip(amplitudes, self.rows, strict=True):
            integral = f"(integral_times {amplitude} _ _ _ _ term{row.label})"
            joined = f"(integral_plus _ _ _ _ _ _ {joined} {integral})" if joined else integral
        paired = list(zip(amplitudes, self.rows, strict=True))
        boundary = self._boundary()
        proof = self._by_shares(shares) if shares else self._at_once(c, boundary)
        return self.part(
            "sum",
            terms=" + ".join(f"{amplitude} * {self._at(row)}" for amplitude, row in paired),
            values=" + ".join(f"{amplitude} * ({self._value(row)})" for amplitude, row in paired),
            integrand=" + ".join(f"{amplitude} * ({self._at(row)} * K V v)" for amplitude, row in paired),
            integrals=joined,
            boundary=boundary,
            mu_equality=self._same_law(mu),
            shares="\n".join(self._share(term, share) for term, share in shares.items()),
            c_equality=proof,
        )

    def _at_once(self, c: Expr, boundary: str) -> str:
        """Prove that c is the sum of the terms, by one equation."""
        integrals = ", ".join(f"I{profile.label}" for profile in self.profiles)
        total = [self._value_of(row) for row in self.rows]
        written = Generators([c, *total, *self._letters()])
        start = f"unfold c, {integrals}{', mu' * bool(boundary)}{unfolded(c, *total)}. "
        return start + self.equation(written, c, *total, *self._letters(), moves=self._bounds(c, self.rows))

    def _rows_of(self, term: Term) -> list[LawTerm]:
        return [row for row in self.rows if row.term is term]

    def _share(self, term: Term, share: Expr) -> str:
        """State and prove what a term adds to c."""
        rows = self._rows_of(term)
        values = [self._value_of(row) for row in rows]
        letters = [expr for row in rows for expr in (row.amplitude, row.scale, *row.shapes.values())]
        integrals = ", ".join(f"I{row.profile.label}" for row in rows)
        start = f"unfold {integrals}{unfolded(share, *values)}. "
        written = Generators([share, *values, *letters])
        return self.part(
            "share",
            label=rows[0].label,
            share=self.code(share),
            values=" + ".join(f"{self.whole(row.amplitude)} * ({self._value(row)})" for row in rows),
            equality=start + self.equation(written, share, *values, *letters, moves=self._bounds(share, rows)),
        )

    def _by_shares(self, shares: Mapping[Term, Expr]) -> str:
        """Prove that c is the sum of the terms, by what each of them adds."""
        joined = ""
        for label in (self._rows_of(term)[0].label for term in shares):
            joined = f"(f_equal2 Rplus {joined} share{label})" if joined else f"share{label}"
        constants = [f"I{profile.label}" for profile in self.profiles if profile.expr == 1]
        start = ""
        if constants:
            start = f"unfold {', '.join(constants)}. "
        return f"{start}refine (eq_trans {joined} _). field; positive."

    def _bounds(self, c: Expr, terms: Sequence[LawTerm]) -> Iterator[str]:
        """Yield tactics that write the ends of pieces in c, and in its terms, by the smaller of 2 V."""
        rows = [(row, node) for row in terms for node in row.profile.value.atoms(sp.Min)]
        bounds: list[tuple[str, Expr]] = [(self.code(node), node) for node in c.atoms(sp.Min)]
        for row, node in rows:
            given: dict[Expr, str] = {self.r: f"(V / {self.whole(row.scale)})"}
            given |= {shape: self.whole(meaning) for shape, meaning in row.shapes.items()}
            text = CoqPrinter(self.names | given).doprint(node)
            bounds.append((text, node.xreplace({**row.shapes, self.r: V / row.scale})))
        for text, bound in sorted(dict(bounds).items()):
            if (scaled := factor_out_range(bound, V)) is not None and self.code(scaled[1]) != text:
                factor, rest = scaled
                yield f"replace ({text}) with ({self.whole(factor)} * {self.whole(rest)}) by (symmetry; scaled)"

    def _boundary(self) -> str:
        """Return what a weight that does not vanish at the ends adds to c."""
        low, high = self.criterion.ends
        ends = [(low / V, "0"), (-high / V, "(2 * V)")]
        terms = [f"{self.whole(weight)} * mu {place}" for weight, place in ends if weight != 0]
        if terms:
            return f" - N * ({' + '.join(terms)})"
        return ""

    def _same_law(self, mu: Expr) -> str:
        """Prove that the law is the sum of its terms, whichever of their pieces hold."""
        profiles = ", ".join(f"g{profile.label}" for profile in self.profiles)
        shown = [
            reduce_squared_roots(row.profile.expr.xreplace({**row.shapes, self.u: self.v / row.scale}))
            for row in self.rows
        ]
        equality = self.equation(
            Generators([mu, *shown, *self._letters()]), mu, *shown, *self._letters(), values=False
        )
        start = f"unfold mu, {profiles}{unfolded(mu, *shown)}. "
        places = places_of(mu, self.v)
        if not places:
            return start + equality
        facts = list[str]()
        for row in self.rows:
            for own in places_of(row.profile.expr, self.u):
                at = own.xreplace(row.shapes)
                same = [place for place in places if sp.simplify(place - row.scale * at) == 0]
                facts += [
                    f"pose proof (less_at_scale {self.whole(row.scale)} v {self.whole(place)} {self.whole(at)} "
                    "ltac:(positive) ltac:(field; positive))."
                    for place in same
                ]
        cases = "repeat destruct Rlt_dec; try (exfalso; solve [tauto | lra]). all: "
        return " ".join([*dict.fromkeys(facts), start]) + cases + equality


def _divided(function: Expr, kernel: Expr) -> Expr:
    """Return a function over a factor that its pieces have."""
    if not isinstance(function, sp.Piecewise):
        return function / kernel
    return function.func(*((piece / kernel, holds) for piece, holds in function.args))


def _is_odd(node: Expr) -> bool:
    return bool(node.is_Pow and node.base.is_Add and node.exp.is_odd and node.exp.is_positive)
