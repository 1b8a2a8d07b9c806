"""`ClosedForm`: a criterion of a law as a sum of averages; `derive`, which finds and proves it."""

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import count
from typing import Literal, SupportsIndex

import sympy as sp

from stickslip_sym.core.aliases import Condition, Expr, Mpf, Substitution
from stickslip_sym.core.deadline import check_time
from stickslip_sym.core.deadline import time_limit as limit
from stickslip_sym.core.errors import InputError, NoClosedForm, NotConverged, OutOfTime
from stickslip_sym.core.names import suggestion
from stickslip_sym.core.numbers import Number, exact, require_type
from stickslip_sym.core.progress import StepOfWork, report_every_step_to, stages
from stickslip_sym.core.remedies import Argument, Call
from stickslip_sym.core.special import NumberPower
from stickslip_sym.core.status import Status
from stickslip_sym.core.symbols import N, V, c, mu, v
from stickslip_sym.criteria.criterion import Criterion, CriterionName, catalogue, find
from stickslip_sym.formula.average import Average, average_of_profile
from stickslip_sym.formula.derivation import Derivation
from stickslip_sym.formula.exact import exact_value
from stickslip_sym.formula.limits import Limits, limits_of
from stickslip_sym.formula.proof.gate import GATE_POINTS
from stickslip_sym.formula.proof.normal_form import plain
from stickslip_sym.formula.proof.proving import Verdict, prove_equal
from stickslip_sym.formula.slope_average import SlopeAverage
from stickslip_sym.formula.tidy import tidy
from stickslip_sym.model.expression.letters import HIGHEST_ROOT, name_constants, substitute_numbers
from stickslip_sym.model.expression.parameters import Parameter
from stickslip_sym.model.expression.pieces import mean_slope_at_kinks
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law, laws
from stickslip_sym.model.same_shape import law_of_same_shape
from stickslip_sym.model.terms import Term, shapes_of
from stickslip_sym.output import printing
from stickslip_sym.output.notation import check_known, notation_of
from stickslip_sym.output.shown import Shown, views_of
from stickslip_sym.output.text_printer import is_decimal

_MOST_DIGITS_OF_A_LAW = 6
"""A number with more was multiplied together from the numbers of a law."""
_FEW_TERMS = 3
_FEW_OPERATIONS = 60
"""Sums of more terms, and of more operations, keep the shares of their terms apart."""
_LINEAR = "a criterion is linear in mu, and a change of the unit of speed scales it"


@dataclass(frozen=True, eq=False)
class ClosedForm(Shown, SlopeAverage):
    """The damping coefficient of a criterion as a formula.

    It holds the terms of a law, and no formula: expression, call, LaTeX, code and verdict are made from the
    terms, each with the average of its profile. So none of them can say something else than the others.

    Attributes
    ----------
    law : FrictionLaw
    criterion : Criterion
    terms : tuple of Term
    origin : tuple of ClosedForm and str, optional
        Of a sensitivity, what it is the derivative of, and by which parameter.
    general : ClosedForm, optional
        The form of the same law with letters for its long numbers, by which this one was derived.
    meanings : mapping of Symbol to sympy.Expr
        What each of these letters stands for.
    """

    origin: "tuple[ClosedForm, str] | None" = None
    general: "ClosedForm | None" = None
    meanings: Substitution = field(default_factory=dict)
    _runs: dict[str, tuple[Status, str]] = field(default_factory=dict, init=False, repr=False)
    """What certificates that were run established, by their languages."""

    @property
    def reported(self) -> tuple[str, ...]:
        """What JSON says: the formula, or the cubics of measured points, of which it is the average by pieces."""
        return ("expr" if self.law.curve is None else "cubics", "verdict")

    @property
    def cubics(self) -> dict[str, object]:
        """The curve through measured points, exact: from places[i] on sum_j cubics[i][j] (v - places[i])^j."""
        curve = self.law.curve
        if curve is None:
            return {}
        end = None if curve.end is None else str(curve.end)
        rows = [list(map(str, row)) for row in curve.cubics]
        return {"places": list(map(str, curve.places)), "cubics": rows, "end": end}

    @property
    def averages(self) -> tuple[tuple[Term, Average], ...]:
        """The terms that vary with v, each with the average of its profile."""
        varying = [term for term in self.terms if term.profile.has(v)]
        return tuple((term, average_of_profile(term.profile, self.criterion)) for term in varying)

    @cached_property
    def expr(self) -> Expr:
        """The damping coefficient c in kg/s, an expression in V, N and the law's parameters."""
        if self.general is not None:
            return plain(substitute_numbers(self.general.expr, self.meanings))
        if self._is_long:
            return sp.Add(*self._tidied)
        return tidy(self._sum, self.law.expr, V)

    @cached_property
    def _is_long(self) -> bool:
        """Whether the shares of the terms stay apart, as their sum over one denominator would be longer."""
        return len(self._shares) > _FEW_TERMS and self._sum.count_ops() > _FEW_OPERATIONS

    @property
    def shares(self) -> tuple[tuple[Term, Expr], ...]:
        """The terms whose shares the formula is the sum of, as it is printed; none where it is one quotient."""
        if not self._is_long:
            return ()
        return tuple((term, share) for (term, _), share in zip(self.averages, self._tidied, strict=True))

    @cached_property
    def _tidied(self) -> list[Expr]:
        """The share of each term as a person would print it."""
        tidied = []
        for share in self._shares:
            check_time()
            tidied.append(tidy(share, self.law.expr, V))
        return tidied

    @cached_property
    def _sum(self) -> Expr:
        """N sum_i amplitude_i/scale_i F_i(V/scale_i), as it stands."""
        return sp.Add(*self._shares)

    @cached_property
    def _shares(self) -> list[Expr]:
        """N amplitude_i/scale_i F_i(V/scale_i) of each term."""
        shares = []
        for term, average in self.averages:
            check_time()
            shares.append(N * term.amplitude / term.scale * term.in_parameters(average.find()))
        return shares

    @cached_property
    def derivation(self) -> Derivation:
        """The steps that lead to the formula, each with its verdict."""
        criterion = self.criterion
        law = self.law
        if self.general is not None:
            return self._from_letters(self.general)
        derivation = Derivation(
            f"{law.name or 'law'}/{criterion.name}",
            f"The {criterion.name} criterion for mu(v) = {law.text}",
        )
        derivation.equal(
            "split the law into terms, each an amplitude times a profile of v over a scale",
            "both sides are the same function of v",
            law.expr,
            sp.Add(*[term.expr for term in self.terms]),
            shown=mu(v),
        )
        for average in dict.fromkeys(average for _, average in self.averages):
            terms = [term for term, other in self.averages if other is average]
            meanings = tuple({v: v / term.scale, V: V / term.scale, **term.shapes} for term in terms)
            derivation.steps.extend(replace(step, meanings=meanings) for step in average.steps)
        if self._is_long:
            for share, tidied in zip(self._shares, self._tidied, strict=True):
                derivation.equal("write the share of a term in short", "algebra", share, tidied)
        local = criterion.weight is None
        derivation.equal(
            "take the slope at the belt speed" if local else "add up the averages of the terms",
            "a small motion about it decays if c + N mu'(V) > 0" if local else _LINEAR,
            sp.Add(*self._tidied) if self._is_long else self._sum,
            self.expr,
            shown=c,
        )
        return derivation

    def _from_letters(self, general: "ClosedForm") -> Derivation:
        """Return the steps for the law in letters, and that which puts its numbers in."""
        title = f"The {self.criterion.name} criterion for mu(v) = {self.law.text}"
        name = f"{self.law.name or 'law'}/{self.criterion.name}"
        derivation = Derivation(name, title, list(general.derivation.steps))
        letters = ", ".join(f"{letter} = {printing.text(value)}" for letter, value in self.meanings.items())
        in_letters = printing.text(general.law.expr)
        equations = [sp.Eq(letter, value, evaluate=False) for letter, value in self.meanings.items()]
        derivation.equal(
            f"put in {letters}",
            f"the formula holds for all positive values of the letters in mu(v) = {in_letters}",
            substitute_numbers(general.expr, self.meanings),
            self.expr,
            shown=c,
            formulas=(*equations, general.law.expr),
        )
        return derivation

    @property
    def verdict(self) -> Verdict:
        """What is established: by the steps, by comparisons with the definition, by certificates that were run.

        It is the weakest of them. Its words say which certificate has run here, or is run every night.
        """
        status = Status.weakest([self._established.status, *(status for status, _ in self._runs.values())])
        certificates = [said for _, said in self._runs.values()]
        if self._established.status is Status.PROVED and not certificates:
            certificates = [self._certified]
        return Verdict(status, "; ".join([self._established.evidence, *certificates]))

    @cached_property
    def _established(self) -> Verdict:
        """The weakest verdict of the steps and of the comparisons with the definition."""
        gates = [average.gate for average in dict.fromkeys(average for _, average in self.averages)]
        status = Status.weakest(
            [self.derivation.status, *(g.status for g in gates if g.status is not Status.CHECKED)]
        )
        count = len(self.derivation.steps)
        evidence = dict.fromkeys(gate.evidence for gate in gates)
        return Verdict(status, "; ".join([f"{count} steps" if count != 1 else "1 step", *evidence]))

    @property
    def _certified(self) -> str:
        """Which certificates of this formula, that prove it again without this package, are run by the tests."""
        law = self.law
        name = self.law.name
        is_there = name is not None and name in laws and laws[name].expr == law.expr
        if not is_there or self.criterion.name not in catalogue:
            return "no certificate was run here"
        is_in_coq = self.criterion.weight is None or self.criterion.is_polynomial or law.expr.is_polynomial(v)
        if is_in_coq:
            return "its page in SymPy and its script in Coq are run every night"
        return "its page in SymPy is run every night"

    def verify(self, language: Literal["sympy", "coq"] = "sympy", *, time_limit: float = 60.0) -> Verdict:
        """Run the certificate of this formula, in a process of its own, and return the verdict after that.

        What ran is remembered: `verdict`, and a document, say so from then on. A formula whose certificate stops
        is CHECKED at most.

        Parameters
        ----------
        language : str
            "sympy", or "coq" where the command coqc is installed.
        time_limit : float
            Seconds that this may take.

        Raises
        ------
        InputError
            If there is no certificate in this language, or nothing that runs it.
        OutOfTime
            If it does not end in time, which says nothing of the formula.

        Examples
        --------
        >>> from stickslip_sym import derive
        >>> derive("mu_s - a*v").verify().evidence.split("; ")[-1]
        'its page in SymPy has proved it here'
        """
        from stickslip_sym.certificates.running import outcome_in_coq, outcome_in_sympy

        with limit(time_limit):
            text = self.certificate(language)
            self._runs[language] = outcome_in_coq(text) if language == "coq" else outcome_in_sympy(text)
        return self.verdict

    @cached_property
    def readable(self) -> tuple["ClosedForm", Substitution]:
        """The form to print, and what its letters stand for: that in letters, where numbers make a long mix."""
        if self.general is None or not _is_mixed(self.expr, self.law.expr):
            return self, {}
        return self.general, self.meanings

    @cached_property
    def limits(self) -> Limits:
        """What the criterion tends to as V falls to 0, and as V grows."""
        if self.general is not None:
            ends = self.general.limits
            found = (ends.at_rest, ends.far)
            return Limits(*[None if end is None else substitute_numbers(end, self.meanings) for end in found])
        mu = sp.Add(*[term.expr for term in self.terms])
        return limits_of(mu, self.law.expr, self.criterion, endless=not self.domain)

    def sensitivity(self, name: str) -> "ClosedForm":
        """Return the derivative of the damping coefficient with respect to a parameter, as a closed form.

        A criterion is linear in mu, so dc/dp is the criterion of the law dmu/dp: it is proved and compared with
        its definition as that, and its LaTeX, code and calls are those of a closed form. Beyond that it is
        compared with the derivative of this formula, which differs where a place at which mu jumps moves.

        Parameters
        ----------
        name : str
            A parameter of the law.

        Raises
        ------
        InputError
            If the law has no parameter of that name.
        NoClosedForm
            If the derivative has no closed form, or is not that of mu alone.

        Examples
        --------
        >>> from stickslip_sym import derive, laws
        >>> derive(laws.linear).sensitivity("a_1").expr
        N
        """
        if name not in self.law.parameters:
            raise InputError(
                f"{name!r} is no parameter of the law{suggestion(name, self.law.parameters)}; it has: "
                f"{', '.join(self.law.parameters) or 'none'}"
            )
        symbol = self.law.parameters[name].symbol
        slope = sp.diff(self.law.expr, symbol)
        # Without units: the derivative is no pure number, as a coefficient of friction is.
        described = self.law.parameters.values()
        kept = [
            Parameter(p.name, p.meaning, positive=p.positive) for p in described if p.symbol in slope.free_symbols
        ]
        law = FrictionLaw(slope, parameters=kept, name=f"d {self.law.name or 'mu'}/d {name}")
        law = law.bind(**{key: value for key, value in self.law.values.items() if key in law.parameters})
        terms = tuple(part for term in self.terms for part in _differentiated(term, self.criterion, symbol))
        if any(term.expr.free_symbols - slope.free_symbols - {v} for term in terms):
            terms = law.terms  # a v + b v^2 is one term, whose scale holds both: it cancels out
        form = ClosedForm(law, self.criterion, terms, (self, name))
        if self.general is not None and name in self.general.law.parameters:
            form = replace(form, general=self.general.sensitivity(name), meanings=self.meanings)
        for term, average in form.averages:
            if average.closed is None:
                words = f"{printing.text(term.expr)}, a term of dmu/d{name}, has no closed form here"
                raise NoClosedForm(words, *_other_ways(self.criterion))
        _require(form.verdict, self.criterion)
        if form.general is None:
            _require(prove_equal(sp.diff(self.expr, symbol), form.expr), self.criterion)
        return form

    @cached_property
    def _formula(self) -> tuple[Expr, Expr]:
        """The formula, or the slope itself where it is the criterion: there 1 - tanh^2 is seen; and the slope."""
        slope = sp.Add(*[sp.diff(term.expr, v) for term in self.terms])
        return -N * mean_slope_at_kinks(slope).subs(v, V) if self.criterion.weight is None else self.expr, slope

    def _exactly(self, point: Substitution, digits: int) -> Mpf:
        """Return the value at exact arguments: by the formula, and where it has none, by the definition's balls.

        Where parameters meet, as both speeds of 1/((1 + v/v_1) (1 + v/v_2)), a formula divides 0 by 0.
        """
        try:
            return exact_value(*self._formula, point, digits)
        except (InputError, NotConverged, TypeError):  # SymPy compares what is not a number
            if point[V] == 0 or self.criterion.weight is None:
                raise
            return super()._exactly(point, digits)

    @cached_property
    def domain(self) -> tuple[Condition, ...]:
        """Relations without which a pole or an end of mu lies at a slip speed up to 2 V."""
        relations = [
            term.condition_in_parameters(relation)
            for term, average in self.averages
            for relation in average.domain
        ]
        return tuple(dict.fromkeys(relation for relation in relations if relation != sp.true))

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
        require_type("digits", digits, SupportsIndex, "a whole number")
        if not 1 <= digits <= 10_000:
            raise InputError(f"digits = {digits} is outside 1 to 10000")
        given = dict(self.law.values) | values
        self.require(given)
        point = {symbol: exact(given[name], name) for name, symbol in self.arguments.items()}
        for name, symbol in self.arguments.items():
            if symbol.is_nonnegative and point[symbol] < 0:
                raise InputError(f"{name} = {float(point[symbol]):g} must not be negative")
        for relation in self.domain:
            if relation.xreplace(point) == sp.false:
                raise InputError(
                    f"V = {float(point[V]):g} m/s needs mu up to v = {2 * float(point[V]):g} m/s, and the formula "
                    f"holds for {printing.text(relation)} only: mu ends, or has a pole, before; take a lower speed"
                )
        return self._exactly(point, digits)

    def latex(self, symbols: Mapping[str, str] | None = None) -> str:
        r"""Return the criterion as a LaTeX equation, ``c = ...``; behind it conditions, and values of letters.

        Parameters
        ----------
        symbols : mapping of str to str, optional
            Names and what they shall be printed as, e.g. ``{"V": "v_b", "alpha": r"\beta"}``.
        """
        given = symbols or {}
        (shown, letters) = self.readable
        check_known(given, ["c", *shown.arguments])
        names = notation_of(["c", *shown.arguments], given)
        behind = [printing.latex(relation, names) for relation in (*self.conditions, *self.domain)]
        behind += [
            f"{printing.latex(letter, names)} = {printing.latex_value(value)}"
            for letter, value in letters.items()
            if shown.expr.has(letter)
        ]
        return ", \\quad ".join([f"{names['c']} = {printing.latex(shown.expr, names)}", *behind])

    def certificate(self, language: Literal["sympy", "coq"] = "sympy") -> str:
        """Return a proof of this formula that needs nothing of this package.

        The page in plain SymPy has three parts: the statement (mu, w, c, the assumptions on parameters), the data
        of the proof, and a checker, the same on every page, which trusts no line of the data. Of a formula that is
        CHECKED its first line, and what it prints, say what it does not prove.

        The script in Coq, 8.16 or later with Coquelicot 3.2, states mu(v), the kernel K(v) of (16) or of another
        polynomial weight, and c, and proves that c is the integral of N mu(v) K(v) from 0 to 2 V, or that -c/N
        is the derivative of mu at V, or, for polynomials, that c is the integral of the harmonic criterion; for
        all parameters of the stated signs. Its last lines print the theorem and
        the axioms that it rests on, those of Coq's real numbers.

        Parameters
        ----------
        language : str
            "sympy" or "coq".

        Raises
        ------
        InputError
            If there is no such language, or the proof needs what the scripts of that language do not have; the
            message names it.

        Examples
        --------
        >>> from stickslip_sym import derive
        >>> exec(derive("mu_s - a*v").certificate())
        proved: c = N*a
        for mu(v) = -a*v + mu_s
        and c = -N int_-1^1 w(s) mu'(V (1 + s)) ds, w(s) = 5/8 - 5*s**4/8
        for all V, N, a, mu_s positive
        as V falls to 0, c tends to -N mu'(0) = N*a
        >>> print(derive("mu_s - a*v").certificate("coq").splitlines()[-1])
        Print Assumptions criterion.
        """
        if language == "coq":
            from stickslip_sym.certificates.coq.coq_script import coq_script

            return coq_script(self)
        if language != "sympy":
            raise InputError(f"there is no certificate in {language!r}; give 'sympy' or 'coq'")
        from stickslip_sym.certificates.closed_forms import certificate_of_forms

        return certificate_of_forms([self])

    @property
    def described(self) -> str:
        """What it is, of which law, and its formula, in lines for a comment."""
        return f"{super().described}\nc = {printing.text(self.expr)}"

    def _repr_latex_(self) -> str:
        return views_of(self).notebook_latex(self)

    def __repr__(self) -> str:
        return f"{super().__repr__()}, {self.verdict.status.value}"


def derive(
    law: FrictionLaw | str,
    criterion: CriterionName | Criterion = "least_squares",
    *,
    time_limit: float = 120.0,
    search: bool = True,
    progress: Callable[[str], object] | None = None,
) -> ClosedForm:
    """Derive the closed form of a criterion for a law, prove it, and check it against its definition.

    The law is split into terms, and the profile of each is averaged once: by rules first, by SymPy's integrator
    last, in a process that ends after a number of steps. Antiderivatives are proved by differentiation, harmonic
    averages and series by the differential equation that both sides satisfy. Every average is compared with
    its definition at 12 random points over six decades.

    Parameters
    ----------
    law : FrictionLaw
        Bound values become the defaults of a call; the formula stays symbolic.
    criterion : str or Criterion
    time_limit : float
        Seconds that all of this may take.
    search : bool
        Let SymPy's integrator try what no rule covers, for a million calls of functions a profile.
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
        or what was under way.

    Examples
    --------
    >>> form = derive("mu_s - a*v")
    >>> print(form.expr, form.verdict.status)
    N*a PROVED
    """
    law = as_law(law)
    criterion = find(criterion)
    stage = "reading the law"

    def hear(path: tuple[StepOfWork, ...]) -> None:
        nonlocal stage
        stage = path[-1].what
        if progress is not None:
            progress(stage)

    try:
        with limit(time_limit), report_every_step_to(hear):
            return _derived(law, criterion, search)
    except OutOfTime:
        raise NoClosedForm(
            f"the time limit of {time_limit:g} s was reached while {stage}; give it more time with ",
            Argument("time_limit"),
            *_other_ways(criterion),
        ) from None


def _is_mixed(expr: Expr, law: Expr) -> bool:
    """Whether numbers of an expression were multiplied together from those of a law, or are powers of such."""
    powers = [node for node in expr.atoms(NumberPower, sp.Pow) if node.args[0].is_Rational]
    if any(power.args[1].is_Rational and power.args[1].q > HIGHEST_ROOT for power in powers):
        return True
    own = {abs(number) for number in law.atoms(sp.Rational)}
    others = {abs(number) for number in expr.atoms(sp.Rational)} - own
    return any(_shown_digits(number) > _MOST_DIGITS_OF_A_LAW for number in others)


def _shown_digits(number: Expr) -> int:
    """Return how many digits a reader sees of a number."""
    if is_decimal(number):
        return len(printing.text(number).replace(".", "").lstrip("0"))
    return max(len(str(number.p)), len(str(number.q)))


def _differentiated(term: Term, criterion: Criterion, parameter: Expr) -> list[Term]:
    """Return the terms of the derivative of a term: of its amplitude, its scale, and its shapes."""
    amplitude = term.amplitude
    scale = term.scale
    average = average_of_profile(term.profile, criterion)
    shares = [
        (None, sp.diff(amplitude, parameter), term.profile),
        (v, -amplitude * sp.diff(scale, parameter) / scale, v * average.slope),
        *(
            (shape, amplitude * sp.diff(meaning, parameter), sp.diff(term.profile, shape))
            for shape, meaning in term.shapes.items()
        ),
    ]
    terms = []
    for variable, share, profile in shares:
        if share == 0 or profile == 0:
            continue
        if variable is not None:
            average_of_profile(profile, criterion).offer(average, variable)
        shapes = {shape: term.shapes[shape] for shape in shapes_of(profile)}
        terms.append(Term(sp.factor(share), scale, profile, shapes))
    return terms


def _derived(law: FrictionLaw, criterion: Criterion, search: bool) -> ClosedForm:
    """Derive a form by that of the law in letters, or by itself where a number was needed to decide something."""
    form = ClosedForm(law, criterion, law.terms)
    for term, average in form.averages:
        average.require_conditions(term)
    general, meanings = _name_long_numbers(law)
    if meanings:
        with suppress(NoClosedForm):
            of_letters = _completed(ClosedForm(general, criterion, general.terms), search=False)
            form = replace(form, general=of_letters, meanings=meanings)
    return _completed(form, search)


def _name_long_numbers(law: FrictionLaw) -> tuple[FrictionLaw, Substitution]:
    """Return a law with letters for its long numbers, and what they stand for; a curve through points as it is.

    The letters are those of the catalogue's law of the same shape, where there is one.
    """
    found = name_constants(law.expr)
    if law.curve is not None or not found.meanings:
        return law, {}
    if (of_catalogue := law_of_same_shape(law)) is not None:
        return of_catalogue
    kept = [p for p in law.parameters.values() if p.symbol in found.expr.free_symbols]
    letters = [Parameter(letter.name) for letter in found.meanings]
    try:
        general = FrictionLaw(found.expr, parameters=[*kept, *letters], name=law.name)
    except InputError:  # as of a formula that in letters has too many terms
        return law, {}
    return (general, found.meanings) if general.expr == found.expr else (law, {})


def _completed(form: ClosedForm, search: bool) -> ClosedForm:
    check_time()
    number = count()
    total = 3 * len(form.averages) + 1
    with stages() as say:

        def begin(what: str) -> None:
            check_time()
            say(what, next(number), total)

        return _prove_in_stages(form, search, begin)


def _prove_in_stages(form: ClosedForm, search: bool, begin: Callable[[str], None]) -> ClosedForm:
    """Find, check and prove the averages of a form; each stage is said before it begins."""
    for term, average in form.averages:
        name = printing.text(term.expr)
        begin(f"averaging {name}")
        average.require_integrable()  # no other way gives what has no value
        average.require_conditions(term)
        try:
            average.find(search=search)
        except NoClosedForm as failure:
            words = f"the term {name} has no closed form that is known here: {failure}"
            raise NoClosedForm(words, *_other_ways(form.criterion)) from None
    for term, average in form.averages:
        name = printing.text(term.profile)
        begin(f"comparing the average of {name} with its definition at {GATE_POINTS} points")
        _require(average.gate, form.criterion)
        begin(f"proving the average of {name}")
        for step in average.steps:
            _require(step.verdict, form.criterion)
    begin("adding up the averages")
    _require(form.verdict, form.criterion)
    return form


def _other_ways(criterion: Criterion) -> tuple[str | Call, ...]:
    """Return what a user can do where there is no closed form, as the end of a message."""
    return (
        ". Take the criterion as a fast function: ",
        Call("stickslip_sym.slope_average", "export LAW --python FILE"),
        "; or its value at one operating point: ",
        Call("stickslip_sym.quadrature.damping", f"damping LAW --method {criterion.name}"),
    )


def _require(verdict: Verdict, criterion: Criterion) -> None:
    """Refuse a formula that was refuted, or that could be neither proved nor checked."""
    outcomes = {Status.REFUTED: "refuted", Status.ESTIMATED: "could not be checked"}
    if verdict.status in outcomes:
        words = f"a formula was found but {outcomes[verdict.status]}, so it is not returned: {verdict.evidence}"
        raise NoClosedForm(words, *_other_ways(criterion))
