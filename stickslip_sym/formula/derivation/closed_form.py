"""`derive`: from a friction law and a criterion to a proved closed form."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import sympy as sp

from stickslip_sym.core.aliases import Expr, Mpf
from stickslip_sym.core.deadline import time_left
from stickslip_sym.core.errors import InputError, NoClosedForm, OutOfTime
from stickslip_sym.core.interruption import within
from stickslip_sym.core.numbers import Number, exact
from stickslip_sym.core.symbols import N, V, c, mu, v
from stickslip_sym.criteria.criterion import Criterion, find
from stickslip_sym.formula.derivation.gate import GATE_POINTS, verify
from stickslip_sym.formula.derivation.proving import Status, Verdict, prove_equal
from stickslip_sym.formula.derivation.steps import Derivation
from stickslip_sym.formula.derivation.tidy import tidy
from stickslip_sym.formula.evaluation.exact import exact_value
from stickslip_sym.formula.integration.harmonic_proofs import AVERAGES_AGREE
from stickslip_sym.formula.integration.integrals import Part, Progress, Told, integrate_terms
from stickslip_sym.model.coefficient import symbolic_limit_at_rest
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.output import markup, printing
from stickslip_sym.output.notation import check_known, notation_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from stickslip_sym.formula.evaluation.arguments import OnInvalid
    from stickslip_sym.formula.evaluation.averages import SlopeAverage
    from stickslip_sym.formula.evaluation.stable import StableFunction

__all__ = ["ClosedForm", "derive"]

_SEARCHING = 20.0  # seconds for SymPy's integrator, or half of the time: later it seldom finds anything


@dataclass(frozen=True, eq=False)
class ClosedForm:
    """The damping coefficient of a criterion as a formula.

    Attributes
    ----------
    law : FrictionLaw
    criterion : Criterion
    expr : sympy.Expr
        c as a function of V, N and the law's parameters, in kg/s.
    derivation : Derivation
        The steps that lead to it.
    gate : Verdict
        Its agreement with quadrature of the definition, which shares no step with the derivation.
    """

    law: FrictionLaw
    criterion: Criterion
    expr: Expr
    derivation: Derivation
    gate: Verdict

    @property
    def verdict(self) -> Verdict:
        """What is established: the status of the derivation, and the gate's evidence."""
        count = len(self.derivation.steps)
        steps = f"{count} steps" if count != 1 else "1 step"
        return Verdict(self.derivation.status, f"{steps}; {self.gate.evidence}")

    @property
    def arguments(self) -> dict[str, Expr]:
        """The symbols that a call takes by name: V, N, then the law's parameters."""
        return self._average.arguments

    @cached_property
    def _average(self) -> "SlopeAverage":
        from stickslip_sym.formula.evaluation.averages import SlopeAverage

        exactly = partial(exact_value, self._uncancelled, self.law.slope_expr, digits=17)
        return SlopeAverage(self.law, self.criterion, exactly)

    @cached_property
    def _uncancelled(self) -> Expr:
        """The formula; the slope itself where it is the criterion, for there 1 - tanh^2 is still to be seen."""
        if self.criterion.weight is None and self.expr.has(sp.tanh):
            return -N * self.law.slope_expr.subs(v, V)
        return self.expr

    def __call__(self, *, on_invalid: "OnInvalid" = "raise", **values: "ArrayLike") -> Any:
        """Return the damping coefficient in kg/s, broadcast over all arguments, as a `SlopeAverage` does.

        Parameters
        ----------
        on_invalid : {"raise", "nan"}
        **values : float or array_like
            V (m/s), N (N) and the law's parameters; those that the law has bound may be left out.

        Returns
        -------
        float, numpy.ndarray or numpy.ma.MaskedArray

        Raises
        ------
        InputError
        """
        return self._average(on_invalid=on_invalid, **values)

    def evaluate(self, digits: int = 50, **values: Number) -> Mpf:
        """Return the damping coefficient in kg/s to any number of digits.

        Parameters
        ----------
        digits : int
        **values : number
            As for a call; floats count as exact binary numbers, text as exact decimals.

        Returns
        -------
        mpmath.mpf
        """
        from stickslip_sym.formula.evaluation.arguments import check_names, check_reach

        if not 1 <= digits <= 10_000:
            raise InputError(f"digits = {digits} is outside 1 to 10000")
        given = dict(self.law.values) | values
        check_names(self.arguments, given)
        point = {symbol: exact(given[name], name) for name, symbol in self.arguments.items()}
        for name, symbol in self.arguments.items():
            if symbol.is_nonnegative and point[symbol] < 0:
                raise InputError(f"{name} = {float(point[symbol]):g} must not be negative")
        check_reach(self.law, self.criterion, point[V])
        return exact_value(self._uncancelled, self.law.slope_expr, point, digits)

    @property
    def function(self) -> "StableFunction":
        """The criterion over arrays, with its branches; what is written as code."""
        return self._average.function

    def latex(self, symbols: Mapping[str, str] | None = None) -> str:
        r"""Return the criterion as a LaTeX equation, ``c = ...``.

        Parameters
        ----------
        symbols : mapping of str to str, optional
            Names and what they shall be printed as, e.g. ``{"V": "v_b", "alpha": r"\beta"}``.
        """
        given = symbols or {}
        check_known(given, ["c", *self.arguments])
        names = notation_of(["c", *self.arguments], given)
        return f"{names['c']} = {printing.latex(self.expr, names)}"

    def code(self, language: str) -> str:
        """Return text of a language, such as "python", that defines a function ``damping`` of V, N, ...

        It has the branches of a call. Where a call would turn to arbitrary precision, it averages by Gauss rules.
        """
        from stickslip_sym.formula.code import writer

        return writer.code({"damping": self.function}, repr(self), language)

    def python(self) -> str:
        """Return a self-contained NumPy module with a function ``damping(V, N, ...)``, as `code` does."""
        return self.code("python")

    def c(self) -> str:
        """Return C99 with a function ``double damping(double V, double N, ...)`` that needs libm only."""
        return self.code("c")

    def octave(self) -> str:
        """Return an Octave script that defines a function ``damping(V, N, ...)`` of numbers, or of arrays."""
        return self.code("octave")

    def __getstate__(self) -> dict[str, object]:
        # What is compiled cannot be pickled, and is made again when it is needed.
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def _repr_html_(self) -> str:
        where = f"{self.law.name or self.law.text}, {self.criterion.name}: damping coefficient in kg/s"
        return markup.block(where, markup.formula(f"\\displaystyle {self.latex()}"), str(self.verdict))

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"

    def __repr__(self) -> str:
        name = self.law.name or self.law.text
        return f"ClosedForm: {name}, {self.criterion.name}, {self.derivation.status.value}"


def derive(
    law: FrictionLaw,
    criterion: str | Criterion = "least_squares",
    *,
    time_limit: float = 120.0,
    search: bool = True,
    progress: Progress | None = None,
) -> ClosedForm:
    """Derive the closed form of a criterion for a law, prove it, and check it against quadrature.

    The law is integrated term by term: by rules of this package first, by SymPy's integrator last, in a
    process that is killed when its time is up. Antiderivatives are proved by differentiation, harmonic averages
    by the differential equation that both sides satisfy. Every result, proved or not, is compared with the
    definition at 12 seeded points over six decades.

    Parameters
    ----------
    law : FrictionLaw
        Bound values become the defaults of a call; the formula stays symbolic.
    criterion : str or Criterion
    time_limit : float
        Seconds that all of this may take.
    search : bool
        Let SymPy's integrator try what no rule covers, for 20 s or half of the time.
    progress : callable, optional
        Called with a few words whenever another piece of work begins.

    Returns
    -------
    ClosedForm
        PROVED, or CHECKED where a hypothesis of the proof is not known to hold; the step says which.

    Raises
    ------
    NoClosedForm
        If a term resists, or the result does not pass every check, or the time is up. The message names the term,
        or what was under way and what was found until then.
    """
    criterion = find(criterion)
    told = Told(progress or (lambda _: None))
    try:
        return within(time_limit, lambda: _derived(law, criterion, search, told))
    except OutOfTime:
        raise NoClosedForm(
            f"the time limit of {time_limit:g} s was reached while {told.stage}; until then {told.found}. Give it "
            "more time with time_limit=..., or take the criterion by stickslip_sym.slope_average"
        ) from None


def _derived(law: FrictionLaw, criterion: Criterion, search: bool, told: Told) -> ClosedForm:
    """Derive, check and prove a closed form, without a look at the time."""
    _require_integrable(law, criterion)
    name = f"{law.name or 'law'}/{criterion.name}"
    derivation = Derivation(name, f"The {criterion.name} criterion for mu(v) = {law.text}")
    if criterion.weight is None:
        parts = []
        raw = -N * law.slope_expr.subs(v, V)
    else:
        parts = integrate_terms(law.expr, criterion, min(time_left() / 2, _SEARCHING) if search else 0.0, told)
        raw = sp.Add(*[part.value for part in parts])
    told.found = "a formula was found, but not checked"
    told("simplifying")
    expr = tidy(raw, law.expr, V)
    told(f"comparing with quadrature at {GATE_POINTS} points")
    gate = verify(law, criterion, expr)
    _require(gate)
    told.found = "a formula was found that agrees with its definition, but its proof was not finished"
    told("proving")
    if criterion.weight is not None:
        _state(derivation, law, criterion, parts, gate)
    derivation.equal(
        "collect" if parts else "take the slope at the belt speed",
        "both sides are the same expression" if parts else "a small motion about it decays if c + N mu'(V) > 0",
        raw,
        expr,
        shown=c,
    )
    for step in derivation.steps:
        _require(step.verdict)
    return ClosedForm(law, criterion, expr, derivation, gate)


def _require(verdict: Verdict) -> None:
    """Refuse a formula that was refuted, or that could be neither proved nor checked."""
    if verdict.status is Status.REFUTED:
        raise NoClosedForm(f"a formula was found but refuted, so it is not returned: {verdict.evidence}")
    if verdict.status is Status.UNDECIDED:
        raise NoClosedForm(
            f"a formula was found but could not be checked, so it is not returned: {verdict.evidence}"
        )


def _require_integrable(law: FrictionLaw, criterion: Criterion) -> None:
    """Refuse a law whose mu is infinite at v = 0+, faster than the weight vanishes there."""
    if criterion.weight is None or law.expr.subs(v, 0).is_finite is not False:
        return
    order = criterion.order_at_rest
    strength = symbolic_limit_at_rest(v**order * law.expr)
    if strength.is_infinite or (order > 0 and strength is not sp.nan and sp.simplify(strength) != 0):
        raise NoClosedForm(
            f"mu is not integrable at v = 0+ with the weight of the criterion {criterion.name!r}, so it has no "
            "value; cut mu off there"
        )


def _state(
    derivation: Derivation, law: FrictionLaw, criterion: Criterion, parts: list[Part], gate: Verdict
) -> None:
    """Add the steps from the criterion of the law to the values of its terms."""
    derivation.equal(
        f"split the law; its {criterion.name} criterion is the sum of those of its terms",
        "an integral is linear in its integrand",
        law.expr,
        sp.Add(*[part.term for part in parts]),
        shown=mu(v),
    )
    for part in parts:
        if not criterion.is_polynomial:
            statement = sp.Eq(part.integral, part.value, evaluate=False)
            verdict = Verdict(gate.status, f"{gate.evidence}; of a term in pieces no proof is known here")
            if part.by is not None:
                verdict = prove_equal(part.integral, part.value, part.by, checked=gate)
            why = f"; {AVERAGES_AGREE}" if verdict.status is Status.PROVED else ""
            derivation.judged("average a term", f"by the rule: {part.rule}{why}", statement, verdict)
        else:
            derivation.equal(
                "integrate a term",
                f"the antiderivative is found by the rule: {part.rule}",
                part.integral,
                part.value,
                by=part.by,
            )
