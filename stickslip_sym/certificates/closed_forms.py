"""Closed forms as a page in plain SymPy that proves them, for readers who trust nothing of this package.

A page has three parts. STATEMENT says what mu, w and c are, DATA is what a generator supplies (antiderivatives,
equations, operators), and CHECKER, the text of `checker.py`, proves the statement and trusts no data.
What is written here are the steps that were carried out, each with the data of its theorem: nothing is sought.
"""

import re
from collections import abc
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from textwrap import shorten

import sympy as sp

from stickslip_sym.certificates.python_printer import WIDTH, assignment, imports, python_code, script_line
from stickslip_sym.certificates.script import SafeNames
from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Condition, Expr
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.functions import FUNCTIONS
from stickslip_sym.core.remedies import Call
from stickslip_sym.core.status import Status
from stickslip_sym.formula.average import Average, Differentiated
from stickslip_sym.formula.closed_form import ClosedForm
from stickslip_sym.formula.derivation import Step
from stickslip_sym.formula.proof.algebra import Generator
from stickslip_sym.formula.proof.recurrence import AverageSeries, SeriesProof
from stickslip_sym.formula.proof.theorems import PieceByPiece
from stickslip_sym.model.expression.pieces import pieces_of, piecewise
from stickslip_sym.model.terms import Term
from stickslip_sym.output import printing

_CHECKER = Path(__file__).with_name("checker.py").read_text(encoding="utf-8")
CHECKER = _CHECKER[_CHECKER.index("# == CHECKER") :]
"""The text that ends every page, but for its last line."""
_TOP_LEVEL = re.findall(r"^(?:def |class )?(\w+)", CHECKER, re.MULTILINE)
_OWN = " ".join(
    ["V N n v s mu w c terms law claims claim sp mpmath itertools random Symbol Rational Pow pi", *_TOP_LEVEL]
)
_NUMBERED = r"(g|A|y|parts|functions|roots|slack)\d\w*"
_KINDS = ("positive", "nonnegative", "real")
_VERSIONS = "It needs nothing but Python 3.11, SymPy 1.13 and its mpmath 1.3, or later ones"


def certificate_of_forms(forms: Sequence[ClosedForm]) -> str:
    """Return a page that proves closed forms one after another, and needs SymPy and mpmath only."""
    for form in forms:
        if form.domain:
            raise InputError(
                f"the closed form of {_where(form)} holds for {printing.text(form.domain[0])} only, where the "
                "script has no rule; its derivation has the proof: ",
                Call("print(form.derivation.text())", "derive LAW --steps"),
            )
    claims = "\n\n".join("\n".join(_Claim(form).lines()) for form in forms)
    body = f"claims = []\n\n{claims}\n\n\n{CHECKER}\n\nfor claim in claims:\n    prove(*claim)\n"
    return f"{_script_title(forms)}\n{imports(body)}\n{body}"


def _script_title(forms: Sequence[ClosedForm]) -> str:
    names = list(dict.fromkeys(map(_where, forms)))
    unproved = dict.fromkeys(printing.text(average.profile) for form in forms for average in _unproved(form))
    which = names[0] if len(names) == 1 else "some laws"
    first = f"The damping coefficient c of {which}: a statement, data, and a checker that trusts no data."
    if unproved:
        first = f"Not proved here, and compared at points only: the average of {', '.join(unproved)}."
    if len(names) == 1 and not unproved:
        listed = []
    else:
        listed = ["", *(f"- {name}" for name in names)]
    lines = [shorten(text.replace("\\", "/").replace('"', "'"), WIDTH - 10) for text in (first, *listed)]
    return "\n".join([f'"""{lines[0]}', *lines[1:], "", _INTRODUCTION, '"""'])


_INTRODUCTION = f"""\
A mass is pressed by the force N on a belt of speed V; mu(v) is the coefficient of friction at the slip speed v. A
criterion averages the falling slope over the slip speeds V (1 + s) from 0 to 2 V with a weight w(s):

    c = -N int_-1^1 w(s) mu'(V (1 + s)) ds.

Where mu jumps, its slope mu' holds the jump times a delta function. Run this page: it prints what it proved, or an
error, mostly NotProved, says which step fails.
{_VERSIONS}."""


def _where(form: ClosedForm) -> str:
    return " ".join(f"{form.law.name or form.law.text}, {form.criterion.name}".split())


def _unproved(form: ClosedForm) -> list[Average]:
    averages = dict.fromkeys(average for _, average in form.averages)
    return [a for a in averages if any(step.verdict.status is not Status.PROVED for step in a.steps)]


class _Claim:
    """The statement and the data of one closed form."""

    def __init__(self, form: ClosedForm) -> None:
        self.form = form
        self.criterion = form.criterion
        used = form.law.expr.free_symbols
        self.parameters = [p.symbol for p in form.law.parameters.values() if p.symbol in used]
        every = [form.law.expr, form.expr, *(step.statement for _, a in form.averages for step in a.steps)]
        called = {node.func.__name__ for expr in every for node in expr.atoms(sp.Function)}
        called |= {function.name for function in FUNCTIONS.values()}
        self._safe = SafeNames(" ".join([_OWN, *called]), _NUMBERED)
        self.names: dict[Expr, str] = {symbols.s: "s"}
        self.names |= {x: x.name for x in (symbols.V, symbols.N, symbols.v)}
        self.generators: dict[Expr, str] = {}  # functions of V by what they mean, and their names
        self.parts: dict[Average, str] = {}  # the names of what is known of an average
        self.slack: dict[Expr, tuple[Expr, Expr]] = {}  # p by a positive number d: p = bound + d or bound - d
        for x in self.parameters:
            self._name(x)

    def _name(self, symbol: Expr) -> str:
        """Return the name of a symbol in the script, that of no function, keyword or other symbol."""
        if symbol not in self.names:
            self.names[symbol] = self._safe.new(symbol.name)
        return self.names[symbol]

    def code(self, expr: Expr | int) -> str:
        """Return an expression in code."""
        expr = sp.sympify(expr)
        for symbol in sorted(expr.free_symbols, key=str):
            self._name(symbol)
        return python_code(expr, self.names)

    def exact(self, expr: Expr | int) -> str:
        """Return an expression in code that is no plain number of Python."""
        text = self.code(expr)
        return f"sp.Integer({text})" if sp.sympify(expr).is_Integer else text

    def let(self, name: str, expr: Expr | str) -> str:
        """Return an assignment."""
        return assignment(name, expr if isinstance(expr, str) else self.exact(expr))

    def declare(self, *fresh: Expr) -> Iterator[str]:
        """Define symbols, those with the same assumption on one line."""
        kinds: dict[str, list[str]] = {}
        for x in fresh:
            bound = next((p for p in self.form.conditions if p.lhs == x), None)
            if bound is not None and bound.rhs.is_number:
                yield from self._declare_above(x, bound)
                continue

            kind = next((kind for kind in _KINDS if getattr(x, f"is_{kind}")), "real")
            kinds.setdefault(kind, []).append(self._name(x))
        for kind, names in kinds.items():
            yield _symbols(names, f", {kind}=True")

    def _declare_above(self, x: Expr, bound: Condition) -> Iterator[str]:
        """Define a parameter by a positive number, the least that it may be added: a condition for an average."""
        name = self._name(x)
        slack = f"slack{len(self.slack) + 1}"
        is_above = isinstance(bound, sp.Gt)
        self.slack[x] = sp.Symbol(slack, positive=True), bound.rhs
        yield f'{slack} = Symbol("{slack}", positive=True)'
        text = f"{self.code(bound.rhs)} {'+' if is_above else '-'} {slack}"
        yield f"{assignment(name, text)}  # {bound.lhs.name} {bound.rel_op} {bound.rhs}, for an average"

    # -- the statement -------------------------------------------------------------------------------

    def lines(self) -> Iterator[str]:
        """Write the statement and the data."""
        form = self.form
        criterion = self.criterion
        yield f"# == STATEMENT: {shorten(_where(form), 80)} ".ljust(100, "=")
        yield ""
        yield from self.declare(symbols.V, symbols.N, symbols.v, symbols.s, *self.parameters)
        source = "None"
        if form.origin is not None:
            of, name = form.origin
            symbol = of.law.parameters[name].symbol
            yield from self.declare(*sorted(of.law.expr.free_symbols - {symbols.v, *self.parameters}, key=str))
            yield self.let("law", of.law.expr)
            source = f"(law, {self.names[symbol]})"
        yield self.let("mu", _solve_conditions(form.law.expr, symbols.v))
        yield f"# {shorten(criterion.source or 'the criterion ' + criterion.name, WIDTH - 2)}"
        if criterion.weight is None:
            yield "w = None  # a unit mass at s = 0: c = -N mu'(V), above which small motions decay"
        else:
            yield self.let("w", criterion.weight)
        yield self.let("c", _solve_conditions(form.expr, symbols.V))
        yield ""
        yield "# == DATA: supplied by a generator; CHECKER trusts no line of it ".ljust(100, "=")
        yield ""
        yield from self._data()
        yield f"claims.append((mu, w, c, terms, {source}))"

    # -- the data ------------------------------------------------------------------------------------

    def _data(self) -> Iterator[str]:
        """Write mu as a sum of terms a g(v/b), and what is known of the averages of each g."""
        if self.criterion.weight is None:
            yield "terms = []"
            return
        if any(
            isinstance(step.by, AverageSeries | Differentiated) for _, a in self.form.averages for step in a.steps
        ):
            yield 'n = Symbol("n", positive=True)'
        known = dict(self.form.averages)
        rows = list[str]()
        for term in self.form.terms:
            average = known.get(term)
            if average is not None and average not in self.parts:
                yield from self._average(average)
            rows.append(f"    {self._row(term, average)},")
        yield "# mu is the sum of a g(v/b): a, b, values of the shapes of g, g, and the parts of its average"
        yield "\n".join(["terms = [", *map(script_line, rows), "]"]) if rows else "terms = []"

    def _row(self, term: Term, average: Average | None) -> str:
        shapes = self._shapes(term)
        if average is None:
            return f"({self.exact(term.expr)}, sp.Integer(1), {{{shapes}}}, sp.Integer(1), [])"
        number = self.parts[average]
        return f"({self.exact(term.amplitude)}, {self.exact(term.scale)}, {{{shapes}}}, g{number}, parts{number})"

    def _shapes(self, term: Term) -> str:
        shapes = [(self.names[x], value) for x, value in term.shapes.items() if x in self.names]
        return ", ".join(f"{name}: {self.exact(value)}" for name, value in shapes)

    def _average(self, average: Average) -> Iterator[str]:
        """Write what is known of the average of one profile."""
        number = self.parts[average] = str(len(self.parts) + 1)
        yield from self.declare(*(x for x in average.shapes if x not in self.names))
        yield self.let(f"g{number}", _folded(average.profile))

        parts = []
        for i, step in enumerate(average.steps):
            label = number
            if len(average.steps) > 1:
                label = f"{number}_{i + 1}"
                yield self.let(f"g{label}", _folded(self._part_of(average, step)))
            kind, *data = yield from self._proof(average, step, label)
            parts.append(f'("{kind}", {", ".join([f"g{label}", *data])})')
        yield script_line(f"parts{number} = [{', '.join(parts)}]")

    def _proof(self, average: Average, step: Step, label: str) -> abc.Generator[str, None, list[str]]:
        """Write the data that prove the average of one part, and return its kind and the names of the data."""
        by = step.by if step.verdict.status is Status.PROVED else None
        if isinstance(by, PieceByPiece):
            names = [f"A{label}_{i}" for i in range(len(by.primitives))]
            for name, primitive in zip(names, by.primitives, strict=True):
                yield self.let(name, average.in_shapes(primitive))
            return ["antiderivatives", f"[{', '.join(names)}]"]

        if isinstance(by, Differentiated):
            yield from self._average(by.source)
            of = self.parts[by.source]
            return ["derivative", f"g{of}", f"parts{of}", self._name(by.variable)]

        if isinstance(by, AverageSeries):
            if by.proof is None or _is_power(by.term):
                return ["moments"]
            yield from self._series(average, by, by.proof, label)
            return ["series", self.exact(average.in_shapes(by.constant)), f"*proof{label}"]

        yield "# Of this average no proof is known here"
        yield self.let(f"F{label}", step.statement.rhs)
        return ["compared", f"F{label}"]

    def _part_of(self, average: Average, step: Step) -> Expr:
        """Return the part of a profile that a step is about."""
        if isinstance(step.by, AverageSeries):
            return average.in_shapes(step.by.constant * step.by.term)
        integrals = step.statement.lhs.atoms(sp.Integral)
        (integral,) = integrals
        if self.criterion.is_polynomial:
            return average.in_shapes(integral.function / self.criterion.kernel)
        speed = symbols.V * (1 - sp.cos(symbols.theta))
        return average.in_shapes((integral.function / self.criterion.angle_kernel).subs(speed, symbols.v))

    def _series(self, average: Average, by: AverageSeries, proof: SeriesProof, label: str) -> Iterator[str]:
        """Write the equations of g and of its average, and y = V F(V) in functions of V with their slopes."""

        def in_code(expr: Expr) -> str:
            return self.code(average.in_shapes(expr))

        def in_list(polynomials: Sequence[sp.Poly]) -> str:
            return f"[{', '.join(in_code(a.as_expr()) for a in polynomials)}]"

        rows = proof.product.algebra.table([proof.product])
        yield from self._declare_generators(average, rows)
        functions = list[str]()
        roots = list[str]()
        meanings = _expand_generators(rows)
        for made in rows:
            name = self.names[made.symbol]
            meaning = meanings[made.symbol]
            if isinstance(meaning, tuple):
                text = f"({self.names[meaning[0]]}, {meaning[1]})"
            else:
                text = in_code(meaning)
            functions.append(script_line(f"    {name}: ({text}, {in_code(made.slope or sp.S.Zero)}),"))
            if made.square is not None:
                roots.append(f"{name}: {in_code(made.square)}")
        (n,) = proof.operator[0].gens
        self.names[n] = "n"
        what = "functions of V, their slopes"
        if roots:
            what += ", and the squares of roots"
        if functions:
            yield "\n".join([f"functions{label} = {{  # {what}", *functions, "}"])
        else:
            yield f"functions{label} = {{}}"
        yield script_line(f"roots{label} = {{{', '.join(roots)}}}")
        yield self.let(f"y{label}", proof.product.algebra.by_names(proof.product))
        yield "# sum a_i g^(i) = rest; the q_k of V F; how many terms they leave open; V F; its functions"
        equation = f"{in_list(proof.equation)}, {in_code(proof.rest.as_expr())}"
        data = f"{equation}, {in_list(proof.operator)}, {proof.count}, y{label}, functions{label}, roots{label}"
        yield script_line(f"proof{label} = {data}")

    def _declare_generators(self, average: Average, rows: Sequence[Generator]) -> Iterator[str]:
        fresh = []
        for made in rows:
            meaning = average.in_shapes(made.meaning)
            if meaning not in self.generators:
                self.generators[meaning] = self._safe.new(_generator(meaning))
                fresh.append(self.generators[meaning])
            self.names[made.symbol] = self.generators[meaning]
        if fresh:
            yield _symbols(fresh)


def _symbols(names: Sequence[str], assumption: str = "") -> str:
    maker = "sp.symbols" if len(names) > 1 else "Symbol"
    return script_line(f'{", ".join(names)} = {maker}("{" ".join(names)}"{assumption})')


def _folded(profile: Expr) -> Expr:
    """Return a profile as one function in pieces."""
    if not profile.has(sp.Piecewise):
        return profile
    pieces, places = pieces_of(profile)
    return piecewise(list(zip(pieces, [*places, None], strict=True)))


def _solve_conditions(expr: Expr, x: Expr) -> Expr:
    """Return an expression with every condition that is linear in x solved: x < place, or x <= place."""

    def solved(holds: Condition) -> Condition:
        if isinstance(holds, sp.Or):
            return sp.Or(*map(solved, holds.args))
        if not isinstance(holds, sp.core.relational.Relational):
            return holds
        gap = holds.gts - holds.lts
        rate = sp.diff(gap, x)
        if rate.has(x) or not rate.is_negative:
            return holds
        place = sp.factor(-gap.subs(x, 0) / rate)
        if isinstance(holds, sp.StrictLessThan | sp.StrictGreaterThan):
            return x < place
        return x <= place

    def in_order(*cases: tuple[Expr, Condition]) -> Expr:
        return sp.Piecewise(*((piece, solved(holds)) for piece, holds in cases), evaluate=False)

    return expr.replace(sp.Piecewise, in_order)


def _is_power(term: Expr) -> bool:
    """Whether an average is a moment: of a polynomial, or of a power."""
    return bool(term.is_polynomial(symbols.v) or (term.is_Pow and term.base == symbols.v))


def _expand_generators(rows: Sequence[Generator]) -> Mapping[Expr, Expr | tuple[Expr, int]]:
    """Return what generators mean: (F, k) is (z d/dz)^k F of a hypergeometric function F of z."""
    meanings: dict[Expr, Expr | tuple[Expr, int]] = {}
    last = None
    k = 0
    for made in rows:
        if made.meaning.is_Mul and last is not None:
            k += 1
            meanings[made.symbol] = last, k
            continue

        meanings[made.symbol] = made.meaning
        last = made.symbol if isinstance(made.meaning, sp.hyper) else None
        k = 0
    return meanings


def _generator(meaning: Expr) -> str:
    """Return a name for a function of V, such as besseli_1 or exp_V."""
    orders = [str(argument) for argument in meaning.args[:-1] if argument.is_Integer]
    if meaning.is_Pow and not isinstance(meaning, sp.exp):
        return "root"
    if meaning.is_Mul:
        return "theta"  # of a hypergeometric function, theta = z d/dz
    return "_".join([meaning.func.__name__ if meaning.args else "constant", *(orders or "V")])
