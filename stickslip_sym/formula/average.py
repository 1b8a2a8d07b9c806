"""The average of a profile under a criterion, F(V) = -<g'(V (1 + s))>_w: all that is known of it, in one object.

A law is a sum of terms amplitude * g(v/scale), so every criterion of every law is

    c = N sum_i amplitude_i/scale_i F_i(V/scale_i).

Here v and V are speeds in units of the scale, and the profile's shapes are its only parameters. What is found,
proved and checked of a profile is found, proved and checked once.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Condition, Expr, ExprOrCondition, Relation
from stickslip_sym.core.errors import NoClosedForm
from stickslip_sym.core.functions import elementary
from stickslip_sym.core.status import Status
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.derivation import Step
from stickslip_sym.formula.finding.rules import Part, integrate_terms
from stickslip_sym.formula.proof.gate import verify
from stickslip_sym.formula.proof.normal_form import normal_form
from stickslip_sym.formula.proof.proving import Verdict, prove_equal
from stickslip_sym.formula.proof.recurrence import AVERAGES_AGREE, AverageSeries, definition
from stickslip_sym.formula.proof.theorems import PieceByPiece, is_smooth
from stickslip_sym.formula.tidy import factored
from stickslip_sym.model.expression.pieces import mean_slope_at_kinks
from stickslip_sym.model.leading_terms import symbolic_limit_at_rest
from stickslip_sym.model.terms import Term, shapes_of
from stickslip_sym.numerics.known import Unknown
from stickslip_sym.output import printing


class Average:
    """F(V; shapes) = -<g'(V (1 + s); shapes)>_w of a profile g(v; shapes)."""

    def __init__(self, profile: Expr, criterion: Criterion) -> None:
        self.profile = profile
        self.criterion = criterion
        self.shapes = shapes_of(profile)
        self._parts: tuple[Part, ...] | None = None
        self._obstacle = NoClosedForm("nothing was tried")
        self._tried: bool | None = None  # whether SymPy's integrator was asked, once anything was tried

    @cached_property
    def slope(self) -> Expr:
        """The derivative g'(v)."""
        return sp.diff(self.profile, symbols.v)

    # -- the closed form -----------------------------------------------------------------------------

    def find(self, *, search: bool = False) -> Expr:
        """Return F as a formula in V and the shapes; by SymPy's integrator too where no rule applies.

        What failed once is not tried again, unless SymPy's integrator is asked now and was not before.
        """
        if self._parts is None and (self._tried is None or (search and not self._tried)):
            try:
                self._parts = self._integrated(search=search)
            except NoClosedForm as failure:
                self._obstacle = failure
                self._tried = search
        if self._parts is None:
            raise NoClosedForm(*self._obstacle.args)
        return self._formula(self._parts)

    def _integrated(self, *, search: bool) -> tuple[Part, ...]:
        self.require_integrable()
        if self.criterion.weight is None or not self.profile.has(symbols.v):
            return ()
        if self.rates:
            continued = Continued(self)
            continued.source.find(search=search)
            rule = ", ".join(part.rule for part in continued.source._parts or ())
            return (Part(definition(self.profile, self.criterion), continued.value, rule, continued),)
        # Under the conditions, which SymPy then sees in every exponent.
        profile = self.profile.xreplace({shape: bound + sign * slack for shape, bound, slack, sign in self._slack})
        end = sp.S.One if self.ends_at_scale else None
        return tuple(integrate_terms(profile, self.criterion, search_too=search, end=end))

    def _formula(self, parts: tuple[Part, ...]) -> Expr:
        if not parts:
            slope = elementary(self.slope)
            if not slope.has(sp.Function):  # (1 + v^2)^(-3/2), where a difference of two terms cancels
                slope = min(slope, factored(slope), key=sp.count_ops)
            return -mean_slope_at_kinks(slope).xreplace({symbols.v: symbols.V})
        return self.in_shapes(sp.Add(*[part.value for part in parts]))

    @cached_property
    def rates(self) -> dict[Expr, tuple[Expr, Expr]]:
        """For each sum b (1 + r v) that is divided by, or in a logarithm or root: b and r, where r may be < 0."""
        lines: dict[Expr, tuple[Expr, Expr]] = {}
        for node in self.profile.atoms(sp.Pow, sp.log):
            base = node.args[0]
            exponent = node.exp if node.is_Pow else sp.nan
            if (exponent.is_nonnegative and exponent.is_Integer) or not (
                base.is_Add and base.is_polynomial(symbols.v)
            ):
                continue
            line = sp.Poly(base, symbols.v)
            if line.degree() == 1 and line.nth(0) != 0:
                rate = line.nth(1) / line.nth(0)
            else:
                rate = sp.S.Zero
            if not rate.is_nonnegative and (exponent.is_Integer or line.nth(0).is_positive):
                lines[base] = line.nth(0), rate
        return lines

    @property
    def domain(self) -> tuple[Relation, ...]:
        """What must hold for the profile to have a value at all slip speeds up to 2 V."""
        if self.criterion.weight is None:
            return ()
        relations: list[Relation] = [sp.Gt(1 + 2 * rate * symbols.V, 0) for _, rate in self.rates.values()]
        if self.ends_at_scale:
            relations.append(sp.Gt(1 - 2 * symbols.V, 0))
        return tuple(relations)

    @cached_property
    def ends_at_scale(self) -> bool:
        """Whether the profile has a root or a logarithm's power that is real below v = 1 only.

        That is (1 - v^n)^p, n > 1, or (-log(v))^p, p no whole number.
        """
        bases = {power.base for power in self.profile.atoms(sp.Pow) if power.exp.is_integer is False}
        return any(_vanishes_at_one(base) for base in bases)

    @cached_property
    def _slack(self) -> list[tuple[Expr, Expr, Expr, int]]:
        """p, b, d, and a sign for each condition p > b or p < b: p = b + d or b - d with d > 0."""
        return [
            (p.lhs, p.rhs, sp.Dummy(positive=True), 1 if isinstance(p, sp.Gt) else -1)
            for p in self.conditions
            if isinstance(p, sp.core.relational.Relational)
        ]

    def in_shapes(self, expr: ExprOrCondition) -> ExprOrCondition:
        """Write what was found under the conditions in the shapes again."""
        return expr.xreplace({slack: sign * (shape - bound) for shape, bound, slack, sign in self._slack})

    def offer(self, source: "Average", variable: Expr) -> None:
        """Take the derivative of the average of a profile g as the closed form, where no rule gives one.

        `variable` is `symbols.v` if this profile is v g'(v), or the shape with respect to which it is dg/dp.
        """
        if self.closed is None:
            known = Differentiated(source, variable)
            value = known.value
            if not value.has(sp.Derivative, sp.Subs, sp.meijerg):
                integral = definition(self.profile, self.criterion)
                self._parts = (Part(integral, value, f"differentiate {source!r}", known),)

    @property
    def closed(self) -> Expr | None:
        """F as a formula in V and the shapes; None where the rules find none and no search did."""
        try:
            return self.find()
        except NoClosedForm:
            return None

    def require_integrable(self) -> None:
        """Refuse a profile that is infinite at v = 0+, faster than the weight vanishes there."""
        v = symbols.v
        if sp.false in self.conditions:
            raise self._diverges
        if self.criterion.weight is None or self.profile.subs(v, 0).is_finite is not False or self.conditions:
            return
        order = self.criterion.order_at_rest
        strength = symbolic_limit_at_rest(v**order * self.profile)
        if isinstance(strength, Unknown):
            return
        if strength.is_infinite or (order > 0 and strength != 0):
            raise self._diverges

    def require_conditions(self, term: Term) -> None:
        """Refuse a term with exponents that are numbers for which the average does not exist."""
        if any(term.condition_in_parameters(condition) == sp.false for condition in self.conditions):
            raise self._diverges

    @property
    def _diverges(self) -> NoClosedForm:
        return NoClosedForm(
            f"it is not integrable at v = 0+ with the weight of the criterion {self.criterion.name!r}, which "
            "has no value; cut mu off there: write Max(v, v_c) for v"
        )

    @cached_property
    def conditions(self) -> tuple[Condition, ...]:
        """Relations between the shapes without which the average does not exist; false where it never does.

        A factor v^p of the profile asks for p + q > 0, the weight vanishing like (1 + s)^q where the slip speed
        is 0.
        """
        if self.criterion.weight is None:
            return ()
        bounds: list[Relation] = []
        terms = sp.Add.make_args(sp.expand_mul(self.profile))
        for term in terms:
            powers = [factor.as_base_exp() for factor in sp.Mul.make_args(term)]
            exponent = sp.Add(*[power for base, power in powers if base == symbols.v])
            lowest = -self.criterion.order_at_rest  # of the exponents with an average, which exceed it
            if (exponent - lowest).is_positive:
                continue
            if not exponent.free_symbols:
                strength = (term / symbols.v**exponent).subs(symbols.v, 0)
                if len(terms) == 1 and exponent.is_negative and strength.is_finite and strength.is_nonzero:
                    return (sp.false,)
                continue  # another term may cancel it, or a factor outweigh it
            shape = sorted(exponent.free_symbols, key=str)[0]
            rate = sp.diff(exponent, shape)
            if rate.is_positive or rate.is_negative:
                bound = (lowest - exponent.subs(shape, 0)) / rate
                bounds.append(sp.Gt(shape, bound) if rate.is_positive else sp.Lt(shape, bound))
        return tuple(dict.fromkeys(bounds))

    # -- what is known of it -------------------------------------------------------------------------

    @cached_property
    def gate(self) -> Verdict:
        """The agreement of the closed form with its definition, which shares no step with finding or proof."""
        return verify(self.profile, self.criterion, self.find(), self.conditions + self.domain)

    @cached_property
    def steps(self) -> tuple[Step, ...]:
        """The steps from the definition to the closed form, each with its verdict."""
        self.find()
        return tuple(map(self._step, self._parts or ()))

    def _step(self, part: Part) -> Step:
        operation = f"average the profile {printing.text(self.profile)}, speeds in units of its scale"
        reason = f"by the rule: {part.rule}"
        if part.by is None:
            evidence = f"{self.gate.evidence}; of a profile in pieces no proof is known here"
            verdict = Verdict(self.gate.status, evidence)
        else:
            verdict = prove_equal(part.integral, part.value, part.by, checked=self.gate)
            if isinstance(part.by, PieceByPiece):
                reason = f"the antiderivative is found {reason}"
            elif isinstance(part.by, AverageSeries) and verdict.status is Status.PROVED:
                reason += f"; {AVERAGES_AGREE}"
        statement = self.in_shapes(sp.Eq(part.integral, part.value, evaluate=False))
        return Step(operation, reason, statement, verdict, by=part.by, formulas=(self.profile,))

    def __repr__(self) -> str:
        return f"Average: {printing.text(self.profile)}, {self.criterion.name}"


def _vanishes_at_one(base: Expr) -> bool:
    """Whether a function of v is 1 - v^n, n > 1, or -log(v), perhaps times a positive number."""
    of_speed = base
    if base.is_Mul:
        of_speed = base.as_independent(symbols.v, as_Add=False)[1]
    power = sp.expand(1 - of_speed)
    is_power = power.is_Pow and power.base == symbols.v and (power.exp - 1).is_positive
    return bool(is_power or base.as_base_exp()[0] in (-sp.log(symbols.v), -1 / sp.log(symbols.v)))


@dataclass(frozen=True)
class Differentiated:
    """Evaluate the average of v g'(v), or of dg/dp, by the average F of g: it is (V F)', or dF/dp."""

    source: Average
    variable: Expr

    @property
    def value(self) -> Expr:
        """The derivative of the closed form."""
        V = symbols.V
        F = self.source.find()
        if self.variable == symbols.v:
            return sp.diff(V * F, V)
        return sp.diff(F, self.variable)

    def __call__(self, expr: Expr) -> Expr:
        """Differentiate the integral of g under its sign."""
        g = self.source.profile
        criterion = self.source.criterion
        profile = symbols.v * self.source.slope if self.variable == symbols.v else sp.diff(g, self.variable)
        if normal_form(definition(profile, criterion) - expr) != 0:
            raise ValueError(f"the integral is not the average of the derivative of {g}")
        if g.has(sp.Piecewise):
            raise ValueError(f"{g} may jump, at a place that moves")
        if any(step.verdict.status is not Status.PROVED for step in self.source.steps):
            raise ValueError(f"the average of {g} is not proved")
        return self.value


class Continued:
    """Evaluate the average of a profile with 1 + r v by that for r > 0, continued to all r with 1 + 2 r V > 0.

    The average is analytic in r there, since the profile is in 1 + r v; so is the formula, save at r = 0, where it
    has a limit if it equals the average on one side.
    """

    def __init__(self, average: Average) -> None:
        self.average = average
        self.positive = {
            base: sp.Symbol(f"rate_{number}", positive=True) for number, base in enumerate(average.rates, 1)
        }
        bases = {base: average.rates[base][0] * (1 + r * symbols.v) for base, r in self.positive.items()}
        self.source = average_of_profile(average.profile.xreplace(bases), average.criterion)

    @property
    def _formula(self) -> Expr:
        """The formula for positive rates, each root and logarithm of a product in its factors."""
        return self.source.find().replace(
            lambda node: node.is_Pow and not node.exp.is_Integer,
            lambda node: sp.factor(node.base) ** node.exp,
        )

    @property
    def value(self) -> Expr:
        """The formula at the rates."""
        return self._formula.xreplace({r: self.average.rates[base][1] for base, r in self.positive.items()})

    def __call__(self, expr: Expr) -> Expr:
        """Apply the identity theorem, after checking its hypotheses."""
        if normal_form(definition(self.average.profile, self.average.criterion) - expr) != 0:
            raise ValueError("the integral is not the average of the profile")
        if any(step.verdict.status is not Status.PROVED for step in self.source.steps):
            raise ValueError("the average for positive rates is not proved")
        # 1 + 2 r V, and in the profile 1 + r v, which is between that and 1.
        ends = {base: sp.Dummy("w", positive=True) for base in self.positive}
        profile = self.average.profile.xreplace(
            {base: self.average.rates[base][0] * w for base, w in ends.items()}
        )
        moved = self._formula.xreplace(
            {r: (ends[base] - 1) / (2 * symbols.V) for base, r in self.positive.items()}
        )
        moved = moved.replace(lambda node: node.is_Add, sp.factor_terms)
        for w in ends.values():
            if not (is_smooth(profile, w, analytic=True) and is_smooth(moved, w, analytic=True, inside=False)):
                raise ValueError("the profile, or the formula, is not known to be analytic in the rates")
        return self.value


@lru_cache
def average_of_profile(profile: Expr, criterion: Criterion) -> Average:
    """Return the average of a profile under a criterion: the same object again, with all that is known of it."""
    return Average(profile, criterion)
