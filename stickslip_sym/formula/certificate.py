"""Closed forms as a script in plain SymPy that proves them, for readers who trust nothing of this package.

The script is printed from the steps that were carried out, each with the theorem that proved it and the data by
which its hypotheses were checked: nothing is sought here. Its functions are those of `certificate.txt`.
"""

import builtins
import json
import keyword
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from textwrap import shorten
from typing import TYPE_CHECKING

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.functions import row
from stickslip_sym.core.status import Status
from stickslip_sym.formula.average import Average, Differentiated
from stickslip_sym.formula.derivation import Step
from stickslip_sym.formula.proof.algebra import Expansion
from stickslip_sym.formula.proof.recurrence import AverageSeries, SeriesProof, moment_ratio
from stickslip_sym.formula.proof.theorems import PieceByPiece, value_at
from stickslip_sym.model.expression.pieces import places
from stickslip_sym.output import printing
from stickslip_sym.output.python_printer import WIDTH, assignment, code, formatted, imports, line
from stickslip_sym.output.script import sections

if TYPE_CHECKING:
    from stickslip_sym.formula.closed_form import ClosedForm

_OWN = (
    "V", "N", "v", "s", "n", "b", "theta", "mu", "law", "w", "K", "c", "ratio", "q", "y", "sp", "mpmath", "random",
    "equation", "generators", "roots", "total", "moment", "moments", "angles", "integrand", "parameters",
    "at_rest", "Symbol", "Rational", "Pow", "pi", "l", "I", "O",
)  # fmt: skip
"""Names that a script uses itself, beside those of its functions, or that look like numbers."""
_PAGE = Path(__file__).with_suffix(".txt")  # its functions, which a script has as far as it needs them
_NUMBERED = re.compile(r"[gFA]\d\w*")
_KINDS = ("positive", "nonnegative", "real")


def certificate(forms: "Sequence[ClosedForm]") -> str:
    """Return a script that proves closed forms one after another, and needs SymPy and mpmath only."""
    for form in forms:
        if form.domain:
            raise InputError(
                f"the closed form of {_where(form)} holds for {printing.text(form.domain[0])} only, where the "
                "script has no rule; its derivation has the proof: print(form.derivation)"
            )
    texts = ["\n".join(_Section(form).lines()) for form in forms]
    named, helpers = set(re.findall(r"\w+", " ".join(texts))), list[str]()
    needed = set(named)
    for name, text in reversed(sections(_PAGE).items()):  # each needs those before it only
        if name in needed:
            helpers.insert(0, _chosen(text.rstrip(), named))
            needed |= set(re.findall(r"\w+", helpers[0]))
    body = "\n\n\n".join([*helpers, "\n\n".join(texts)])
    return f"{_title(forms)}\n{imports(body)}\n\n{body}\n"


def _chosen(text: str, named: set[str]) -> str:
    """Return a function without the lines for what a script has none of, which say so: ``# if Piecewise``."""
    lines = [line.partition("  # if ") for line in text.splitlines()]
    return "\n".join(line for line, _, name in lines if not name or name in named)


def _title(forms: "Sequence[ClosedForm]") -> str:
    unproved = dict.fromkeys(printing.text(average.profile) for form in forms for average in _unproved(form))
    first = "The damping coefficient c, proved for every value of its parameters."
    if unproved:
        first = f"Not proved here, and compared at points only: the average of {', '.join(unproved)}."
    names = dict.fromkeys(f"- {_where(form)}" for form in forms)
    lines = [shorten(line.replace("\\", "/").replace('"', "'"), WIDTH - 10) for line in (first, *names)]
    return "\n".join([f'"""{lines[0]}', "", *lines[1:], "", _INTRODUCTION, '"""'])


_INTRODUCTION = """\
A mass is pressed by the force N on a belt of speed V; mu(v) is the coefficient of friction at the slip speed v. A
criterion averages the falling slope over the slip speeds v = V (1 + s) from 0 to 2 V, with a weight w(s):

    c = -N integral of w(s) mu'(V (1 + s)) ds over -1 <= s <= 1.

Nothing but SymPy and mpmath is needed. An AssertionError names the step that fails."""


def _where(form: "ClosedForm") -> str:
    return " ".join(f"{form.law.name or form.law.text}, {form.criterion.name}".split())


def _unproved(form: "ClosedForm") -> list[Average]:
    averages = dict.fromkeys(average for _, average in form.averages)
    return [a for a in averages if any(step.verdict.status is not Status.PROVED for step in a.steps)]


class _Section:
    """What a script says of one closed form."""

    def __init__(self, form: "ClosedForm") -> None:
        self.form, self.criterion = form, form.criterion
        self.numbers = {average: str(i) for i, average in enumerate(dict.fromkeys(a for _, a in form.averages), 1)}
        used = form.law.expr.free_symbols
        self.parameters = [p.symbol for p in form.law.parameters.values() if p.symbol in used]
        self._taken = {*keyword.kwlist, *dir(builtins), *_OWN, *sections(_PAGE)}
        every = [form.law.expr, form.expr, *(step.statement for a in self.numbers for step in a.steps)]
        self._taken |= {node.func.__name__ for expr in every for node in expr.atoms(sp.Function)}
        self.names: dict[Expr, str] = {symbols.s: "s", symbols.theta: "theta"}
        self.names |= {x: x.name for x in (symbols.V, symbols.N, symbols.v)}
        for x in self.parameters:
            self._name(x)

    def _name(self, symbol: Expr) -> str:
        """Return the name of a symbol in the script, that of no function, keyword or other symbol."""
        if symbol not in self.names:
            name = f"p_{symbol.name}" if _NUMBERED.fullmatch(symbol.name) else symbol.name
            while name in self._taken:
                name += "_"
            self._taken.add(name)
            self.names[symbol] = name
        return self.names[symbol]

    def code(self, expr: Expr) -> str:
        for symbol in sorted(expr.free_symbols, key=str):
            self._name(symbol)
        return code(expr, self.names)

    def let(self, name: str, expr: Expr | str) -> str:
        return assignment(name, expr if isinstance(expr, str) else self.code(expr))

    def declare(self, *fresh: Expr) -> Iterator[str]:
        """Define symbols, those with the same assumption on one line."""
        kinds: dict[str, list[Expr]] = {}
        for x in fresh:
            kind = next((kind for kind in _KINDS if getattr(x, f"is_{kind}")), "complex")
            kinds.setdefault(kind, []).append(x)
        for kind, group in kinds.items():
            left, right = (" ".join(words) for words in ([self._name(x) for x in group], [x.name for x in group]))
            maker = "sp.symbols" if len(group) > 1 else "Symbol"
            yield line(f'{left.replace(" ", ", ")} = {maker}("{right}", {kind}=True)')

    # -- the law, the criterion, the formula ---------------------------------------------------------

    def lines(self) -> Iterator[str]:
        form, criterion = self.form, self.criterion
        yield f"# -- {shorten(_where(form), 90)} ".ljust(100, "-")
        yield from self.declare(symbols.V, symbols.N, symbols.v, *self.parameters)
        yield self.let("mu", form.law.expr)
        if form.origin is not None:
            source, name = form.origin
            symbol = source.law.parameters[name].symbol
            yield from self.declare(*sorted(source.law.expr.free_symbols - {symbols.v, *self.parameters}, key=str))
            yield f"# A criterion is linear in mu: this is the derivative of c by {name}, if mu is that of the law"
            yield self.let("law", source.law.expr)
            yield f'assert vanishes(sp.diff(law, {self.names[symbol]}) - mu), "the derivative of the law"'
        yield f"# {shorten(criterion.source or 'the criterion ' + criterion.name, WIDTH - 2)}"
        if criterion.weight is None:
            yield "# The weight is a unit mass at s = 0: c = -N mu'(V), above which small motions decay"
        else:
            yield 's = Symbol("s", real=True)'
            yield self.let("w", criterion.weight)
        yield self.let("c", form.expr if form.expr != 0 else "sp.Integer(0)")
        yield ""
        yield from self._kernel()
        for average in self.numbers:
            yield from self.average(average, self.numbers[average])
        yield from self._sum()
        yield from self._points()
        yield from self._limits()
        yield line(f"print({json.dumps(('compared: ' if _unproved(form) else 'proved: ') + _where(form))})")

    def _kernel(self) -> Iterator[str]:
        criterion = self.criterion
        if criterion.weight is None:
            return
        if criterion.is_polynomial:
            yield "# By parts, with v = V (1 + s): c = N integral of mu K over 0 <= v <= 2 V"
            yield self.let("K", criterion.kernel)
            yield 'assert vanishes(K - sp.diff(w, s).subs(s, v / V - 1) / V**2), "the kernel"'
            yield 'assert sp.integrate(w, (s, -1, 1)) == 1, "the weight is an average"'
        else:
            yield "# By parts, with v = V (1 - cos(theta)): c = N integral of mu K over 0 <= theta <= pi"
            yield 'theta = Symbol("theta", real=True)'
            yield self.let("K", criterion.angle_kernel)
            yield 'assert same(K, sp.diff(w, s).subs(s, -cos(theta)) * sin(theta) / V), "the kernel"'
        if any(isinstance(step.by, AverageSeries) for a in self.numbers for step in a.steps):
            yield "# The moments b_n = n <(1 + s)^(n - 1)>, as integrals of powers: DLMF 5.12"
            yield 'n = Symbol("n", positive=True)'
            n = sp.Symbol("n", positive=True)
            self.names[n] = "n"
            yield self.let("b", n * self.criterion.mean_power(n - 1))
            yield self.let("ratio", sp.factor(moment_ratio(self.criterion, n)))
            yield 'assert vanishes(sp.expand_func(b.subs(n, n + 1) / b) - ratio), "the ratio of the moments"'

    # -- the average of a profile --------------------------------------------------------------------

    def average(self, average: Average, label: str) -> Iterator[str]:
        g = f"g{label}"
        yield from self.declare(*(x for x in average.shapes if x not in self.names))
        yield f"# The profile {g}(v), speeds in units of its scale, and its average F{label}(V)"
        yield self.let(g, average.profile)
        if self.criterion.weight is None:
            yield f"F{label} = -sp.diff({g}, v).subs(v, V)"
            return
        single, parts = len(average.steps) == 1, []
        for i, step in enumerate(average.steps):
            part = label if single else f"{label}_{i}"
            parts.append(part)
            if step.verdict.status is not Status.PROVED:
                yield "# Of this average no proof is known here"
                yield self.let(f"F{part}", step.statement.rhs)
            elif isinstance(step.by, PieceByPiece):
                yield from self._pieces(average, step, part)
            elif isinstance(step.by, AverageSeries):
                yield from self._series(average, step, part)
            elif isinstance(step.by, Differentiated):
                yield from self._differentiated(average, step.by, part)
        if not single:
            profiles, averages = (" + ".join(f"{letter}{part}" for part in parts) for letter in "gF")
            yield f'assert vanishes({g} - ({profiles})), "{g} is the sum of its parts"'
            yield f"F{label} = {averages}"

    def _pieces(self, average: Average, step: Step, label: str) -> Iterator[str]:
        """State antiderivatives between kinks, and their differences at the ends."""
        assert isinstance(step.by, PieceByPiece)
        (integral,) = step.statement.lhs.atoms(sp.Integral)
        parts, terms = step.by.parts(average._in_shapes(integral.function), sp.S.Zero, 2 * symbols.V), []
        yield from self._part(label, average, integral.function / self.criterion.kernel)
        boundary = step.statement.lhs - integral
        for i, (primitive, _, low, high) in enumerate(parts):
            A = f"A{label}_{i}"
            piece = f"{'g' + label}{f'.args[{i}].expr' if len(parts) > 1 else ''}"
            yield self.let(A, average._in_shapes(primitive))
            yield f'assert vanishes(sp.diff({A}, v) - {piece} * K), "{A}: the derivative of the antiderivative"'
            upper, lower = (self._end(A, average._in_shapes(primitive), end) for end in (high, low))
            terms.append(f"{upper} - {lower}")
        ends = f" + {self.code(boundary)}" if boundary != 0 else ""
        yield self.let(f"F{label}", f"{' + '.join(terms)}{ends}")

    def _end(self, name: str, primitive: Expr, end: Expr) -> str:
        """Return an antiderivative at an end in code; at 0 its limit, where powers outweigh logarithms."""
        value = primitive.subs(symbols.v, end)
        if not value.has(sp.zoo, sp.oo, sp.nan):
            return f"{name}.subs(v, {self.code(end)})"
        return f"({self.code(value_at(primitive, symbols.v, end))})"

    def _part(self, label: str, average: Average, profile: Expr) -> Iterator[str]:
        if len(average.steps) > 1:
            yield self.let(f"g{label}", average._in_shapes(profile))

    def _series(self, average: Average, step: Step, label: str) -> Iterator[str]:
        """State the differential equations of the profile and of its average, and the generators of the latter."""
        assert isinstance(step.by, AverageSeries)
        by, v = step.by, symbols.v
        yield from self._part(label, average, by.constant * by.term)
        if by.term.is_polynomial(v):
            yield self.let(f"F{label}", f"sp.sympify({self.code(average._in_shapes(by.constant * by.value))})")
            yield f"moments = [b.subs(n, j) * a * V ** (j - 1) for (j,), a in sp.Poly(g{label}, v).terms() if j]"
            yield f'assert vanishes(F{label} + sum(moments)), "F{label}: the moments of the weight"'
            return
        proof = by.proof
        if proof is None:
            (p,) = (node.exp for node in by.term.atoms(sp.Pow))
            yield self.let(f"F{label}", average._in_shapes(by.constant * by.value))
            moment = self.code(average._in_shapes(by.constant * symbols.V ** (p - 1)))
            yield f"moment = sp.gammasimp(sp.powsimp(F{label} / (b.subs(n, {self.code(p)}) * {moment})))"
            yield f'assert moment == -1, "F{label}: the moment of the weight"'
            return
        yield from self._by_series(average, by, proof, label)

    def _by_series(self, average: Average, by: AverageSeries, proof: SeriesProof, label: str) -> Iterator[str]:
        def in_code(expr: Expr) -> str:
            return self.code(average._in_shapes(expr))

        algebra, V = proof.product.algebra, symbols.V
        rows = algebra.table([proof.product])
        poles = max(map(_pole, proof.product.polynomial.coeffs()))
        expansion = Expansion(algebra, V, proof.count + poles + 2)
        series = {one.symbol: expansion.of(one.meaning) for one in rows if one.slope is not None}
        known = min((one.known for one in series.values()), default=0)
        rows = algebra.table([proof.product, *(c for one in series.values() for c in one.coefficients)])
        yield from self.declare(*(one.symbol for one in rows if one.symbol not in self.names))
        yield "generators, roots = {}, {}  # of each function of V its derivative, and its first terms at V = 0"
        for symbol, meaning, slope, square in rows:
            start, name = symbol, self._name(symbol)
            if (one := series.get(symbol)) is not None:
                terms = [algebra.by_names(c) * V ** (one.order + i) for i, c in enumerate(one.coefficients)]
                start = sp.Add(*terms[: max(known - one.order, 0)])
            entry = (meaning, sp.S.Zero if slope is None else slope, start)
            yield self.let(f"generators[{name}]", ", ".join(map(in_code, entry))) + _source(meaning)
            if square is not None:
                yield self.let(f"roots[{name}]", in_code(square))
        self.names |= {q_k.gen: "n" for q_k in proof.weighted}
        equation = [in_code(a.as_expr()) for a in proof.equation]
        yield f"# {equation[-1]} has no zero for v > 0; g and y are analytic there"
        yield self.let("equation", f"[{', '.join(equation)}], {in_code(proof.rest.as_expr())}")
        yield self.let("q", f"[{', '.join(in_code(q_k.as_expr()) for q_k in proof.weighted)}]")
        yield self.let("y", in_code(algebra.by_names(proof.product)))
        profile, constant = in_code(by.term), in_code(by.constant)
        numbers = f"q, {proof.first}, y, generators, roots, {known}"
        yield f'F{label} = by_series("F{label}", {profile}, *equation, {numbers})'
        if constant != "1":
            yield self.let(f"F{label}", f"{constant} * F{label}")

    def _differentiated(self, average: Average, by: Differentiated, label: str) -> Iterator[str]:
        """State the average of another profile, whose derivative is that of this one."""
        source, variable = f"{label}_of", self._name(by.variable)
        yield from self.average(by.source, source)
        front, factor = ("v * ", "V * ") if by.variable == symbols.v else ("", "")
        yield "# Differentiated under the sign of the integral"
        profile = f"{front}sp.diff(g{source}, {variable})"
        yield f'assert vanishes(g{label} - {profile}), "g{label} is a derivative"'
        yield f"F{label} = sp.diff({factor}F{source}, {variable.replace('v', 'V') if factor else variable})"

    # -- the sum, and the comparison with the definition ---------------------------------------------

    def _sum(self) -> Iterator[str]:
        """State that amplitudes times profiles are the law, and amplitudes over scales times averages c."""
        law, total, numbers = list[str](), list[str](), dict(self.form.averages)
        yield "# The law is a sum of a g(v/b), which add N a/b F(V/b) each: the criterion is linear, and scales"
        for term in self.form.terms:
            if term not in numbers:
                law.append(self.code(term.amplitude))
                continue
            label, a, b = self.numbers[numbers[term]], self.code(term.amplitude), self.code(term.scale)
            shapes = "".join(f", {self.names[shape]}: {self.code(term.shapes[shape])}" for shape in term.shapes)
            law.append(f"({a}) * g{label}.subs({{v: v / ({b}){shapes}}}, simultaneous=True)")
            total.append(f"({a}) / ({b}) * F{label}.subs({{V: V / ({b}){shapes}}}, simultaneous=True)")
        yield self.let("law", " + ".join(law) or "0")
        yield 'assert vanishes(mu - law), "the split of the law into terms"'
        yield self.let("total", f"N * ({' + '.join(total) or '0'})")
        yield 'assert vanishes(c - total), "the sum of the averages"'

    def _points(self) -> Iterator[str]:
        """Compare with the definition by quadrature."""
        names = ", ".join(self.names[x] for x in (symbols.V, symbols.N, *self.parameters))
        kinks = f"[{', '.join(map(self.code, places(self.form.law.expr)))}]"
        rest = self.criterion.boundary(self.form.law.expr) if self.criterion.is_polynomial else sp.S.Zero
        yield "# By mpmath, without any of the above"
        yield line(f"parameters = ({names})")
        if self.criterion.weight is None:
            yield "compare_slope(c, -N * mu, parameters)"
        elif self.criterion.is_polynomial:
            value = "c" if rest == 0 else formatted(f"c - N * ({self.code(rest)})")
            yield f"compare({value}, N * mu * K, v, 2 * V, {kinks}, parameters)"
        else:
            yield self.let("angles", f"[2 * asin(sqrt(place / (2 * V))) for place in {kinks}]")
            yield "integrand = N * mu.subs(v, 2 * V * sin(theta / 2) ** 2) * K"
            yield "compare(c, integrand, theta, pi, angles, parameters)"

    def _limits(self) -> Iterator[str]:
        """State the limit for low belt speeds, where the slope has one."""
        low = self.form.limits.at_rest
        slope = self.form.law.slope_expr.subs(symbols.v, 0)
        if low is None or low.has(symbols.V, sp.oo) or slope.has(sp.nan, sp.zoo, sp.oo) or slope.has(sp.Piecewise):
            return
        yield "# As V falls to 0, c tends to -N mu'(0): the weight has unit integral, the slope is continuous"
        yield self.let("at_rest", low)
        yield 'assert vanishes(at_rest + N * sp.diff(mu, v).subs(v, 0)), "the limit for low belt speeds"'


def _pole(coefficient: Expr) -> int:
    """Return the order of the pole at 0 of a rational function whose first variable is that of an algebra."""
    return int(min(monomial[0] for monomial in coefficient.denom.monoms()))


def _source(function: Expr) -> str:
    """Return a comment with the section of the Digital Library of Mathematical Functions on a function."""
    known = row(function)
    return f"  # DLMF {known.dlmf}" if known is not None and known.dlmf else ""
