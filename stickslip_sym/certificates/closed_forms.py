"""Closed forms as a script in plain SymPy that proves them, for readers who trust nothing of this package.

The script is printed from the steps that were carried out, each with the theorem that proved it and the data by
which its hypotheses were checked: nothing is sought here. Its functions are those of `closed_forms.txt`.
"""

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from textwrap import shorten

import sympy as sp

from stickslip_sym.certificates.python_printer import WIDTH, assignment, code, formatted, imports, line
from stickslip_sym.certificates.script import SafeNames, chosen
from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.functions import FUNCTIONS, elementary, row
from stickslip_sym.core.status import Status
from stickslip_sym.formula.average import Average, Differentiated
from stickslip_sym.formula.closed_form import ClosedForm
from stickslip_sym.formula.derivation import Step
from stickslip_sym.formula.proof.algebra import Expansion, Generator
from stickslip_sym.formula.proof.recurrence import AverageSeries, SeriesProof, moment_ratio
from stickslip_sym.formula.proof.theorems import PieceByPiece, value_at
from stickslip_sym.model.expression.pieces import places
from stickslip_sym.output import printing
from stickslip_sym.output.sections import sections

_OWN = """V N n v s theta mu law w K b c ratio equation functions roots q y total moment like at_rest far I O
sp mpmath random Symbol Rational Pow pi cos sin sqrt asin"""
"""Names that a script uses itself, beside those of its functions."""
_NUMBERED = r"[gFA]\d\w*"  # profiles, averages and antiderivatives
_PAGE = Path(__file__).with_suffix(".txt")  # its functions, which a script has as far as it needs them
_KINDS = ("positive", "nonnegative", "real")


def certificate_of_forms(forms: Sequence[ClosedForm]) -> str:
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
            helpers.insert(0, chosen(text.rstrip(), named))
            needed |= set(re.findall(r"\w+", helpers[0]))
    body = "\n\n\n".join([*helpers, "\n\n".join(texts)])
    return f"{_title(forms)}\n{imports(body)}\n\n{body}\n"


def _title(forms: Sequence[ClosedForm]) -> str:
    names = list(dict.fromkeys(map(_where, forms)))
    unproved = dict.fromkeys(printing.text(average.profile) for form in forms for average in _unproved(form))
    which = names[0] if len(names) == 1 else "some laws"
    first = f"The damping coefficient c of {which}, proved for all parameters."
    if unproved:
        first = f"Not proved here, and compared at points only: the average of {', '.join(unproved)}."
    listed = [] if len(names) == 1 and not unproved else ["", *(f"- {name}" for name in names)]
    lines = [shorten(line.replace("\\", "/").replace('"', "'"), WIDTH - 10) for line in (first, *listed)]
    return "\n".join([f'"""{lines[0]}', *lines[1:], "", _INTRODUCTION, '"""'])


_INTRODUCTION = """\
A mass is pressed by the force N on a belt of speed V; mu(v) is the coefficient of friction at the slip speed v. A
criterion averages the falling slope over the slip speeds V (1 + s) from 0 to 2 V with a weight w(s):
c = -N int_-1^1 w(s) mu'(V (1 + s)) ds. SymPy and mpmath suffice; an AssertionError names the step that fails."""


def _where(form: ClosedForm) -> str:
    return " ".join(f"{form.law.name or form.law.text}, {form.criterion.name}".split())


def _unproved(form: ClosedForm) -> list[Average]:
    averages = dict.fromkeys(average for _, average in form.averages)
    return [a for a in averages if any(step.verdict.status is not Status.PROVED for step in a.steps)]


class _Section:
    """What a script says of one closed form."""

    def __init__(self, form: ClosedForm) -> None:
        self.form, self.criterion = form, form.criterion
        self.numbers = {average: str(i) for i, average in enumerate(dict.fromkeys(a for _, a in form.averages), 1)}
        used = form.law.expr.free_symbols
        self.parameters = [p.symbol for p in form.law.parameters.values() if p.symbol in used]
        self.functions: dict[Expr, str] = {}  # of V, by what they mean, the names of their generators
        self.names: dict[Expr, str] = {symbols.s: "s", symbols.theta: "theta"}
        self.n = sp.Dummy("n", positive=True)
        self.names |= {x: x.name for x in (symbols.V, symbols.N, symbols.v, self.n)}
        self.series = list(_series(self.numbers))
        proofs = [by.proof for by in self.series if by.proof is not None]
        poles = [max(map(_pole, proof.product.polynomial.coeffs())) for proof in proofs]
        self.terms = max((proof.count + pole + 2 for proof, pole in zip(proofs, poles, strict=True)), default=0)
        self.known = self.terms  # of all of `functions` at least
        every = [form.law.expr, form.expr, *(step.statement for a in self.numbers for step in a.steps)]
        called = {node.func.__name__ for expr in every for node in expr.atoms(sp.Function)}
        called |= {function.name for function in FUNCTIONS.values()} if self.series else set()
        self._safe = SafeNames(" ".join([_OWN, *called, *sections(_PAGE)]), _NUMBERED)
        for x in self.parameters:
            self._name(x)

    def _name(self, symbol: Expr) -> str:
        """Return the name of a symbol in the script, that of no function, keyword or other symbol."""
        if symbol not in self.names:
            self.names[symbol] = self._safe.new(symbol.name)
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
            names = [self._name(x) for x in group]
            maker = "sp.symbols" if len(group) > 1 else "Symbol"
            yield line(f'{", ".join(names)} = {maker}("{" ".join(names)}", {kind}=True)')

    # -- the law, the criterion, the formula ---------------------------------------------------------

    def lines(self) -> Iterator[str]:
        form, criterion = self.form, self.criterion
        yield f"# -- {shorten(_where(form), 90)} ".ljust(100, "-")
        variables = [] if criterion.weight is None else [symbols.s]
        variables += [] if criterion.weight is None or criterion.is_polynomial else [symbols.theta]
        variables += [self.n] if self.series else []
        yield from self.declare(symbols.V, symbols.N, symbols.v, *variables, *self.parameters)
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
            yield self.let("w", criterion.weight)
        yield self.let("c", form.expr if form.expr != 0 else "sp.Integer(0)")
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
            yield from self._said("K", criterion.kernel, "by parts, with v = V (1 + s): c = N int_0^2V mu K dv")
            yield 'assert vanishes(K - sp.diff(w, s).subs(s, v / V - 1) / V**2), "the kernel"'
            yield 'assert sp.integrate(w, (s, -1, 1)) == 1, "the weight is an average"'
        else:
            by_parts = "by parts, with v = V (1 - cos(theta)): c = N int_0^pi mu K dtheta"
            yield from self._said("K", criterion.angle_kernel, by_parts)
            slope = "sp.diff(w, s).subs(s, -cos(theta))"
            yield f'assert abs(at(0, K - {slope} * sin(theta) / V)) < 1e-25, "the kernel"'
        if self.series:
            yield "# The moments b_n = n <(1 + s)^(n - 1)>, as integrals of powers: DLMF 5.12"
            yield self.let("b", self.n * criterion.mean_power(self.n - 1))
            yield self.let("ratio", sp.factor(moment_ratio(criterion, self.n)))
            yield 'assert vanishes(sp.expand_func(b.subs(n, n + 1) / b) - ratio), "the ratio of the moments"'

    # -- the average of a profile --------------------------------------------------------------------

    def average(self, average: Average, label: str) -> Iterator[str]:
        g = f"g{label}"
        yield from self.declare(*(x for x in average.shapes if x not in self.names))
        yield from self._said(g, average.profile, f"in units of its scale; F{label}(V) = -<g'(V (1 + s))>")
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
            A, piece, inside = f"A{label}_{i}", f"g{label}", average._in_shapes(primitive)
            if len(parts) > 1:
                piece = f"sp.piecewise_fold({piece}).args[{i}].expr"
            yield self.let(A, f"sp.sympify({self.code(inside)})" if inside.is_number else inside)
            yield f'assert vanishes(sp.diff({A}, v) - {piece} * K), "{A}: the derivative of the antiderivative"'
            terms.append(self._rise(A, inside, low, high))
        ends = f" + {self.code(boundary)}" if boundary != 0 else ""
        yield self.let(f"F{label}", f"{' + '.join(terms)}{ends}")

    def _rise(self, name: str, primitive: Expr, low: Expr, high: Expr) -> str:
        """Return what an antiderivative rises by in code, from its limit at 0: powers outweigh logarithms."""
        if not primitive.subs(symbols.v, low).has(sp.zoo, sp.oo, sp.nan):
            return f"rise({name}, {self.code(low)}, {self.code(high)})"
        return f"{name}.subs(v, {self.code(high)}) - ({self.code(value_at(primitive, symbols.v, low))})"

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
            moments = f"sum(a * b.subs(n, j) * V ** (j - 1) for (j,), a in sp.Poly(g{label}, v).terms() if j)"
            yield line(f'assert vanishes(F{label} + {moments}), "F{label}: the moments"')
            return
        proof = by.proof
        if proof is None:
            (p,) = (node.exp for node in by.term.atoms(sp.Pow))
            yield self.let(f"F{label}", average._in_shapes(by.constant * by.value))
            moment = self.code(average._in_shapes(by.constant * symbols.V ** (p - 1)))
            ratio = f"sp.gammasimp(sp.powsimp(F{label} / (b.subs(n, {self.code(p)}) * {moment})))"
            yield line(f'assert {ratio} == -1, "F{label}: the moment"')
            return
        yield from self._by_series(average, by, proof, label)

    def _by_series(self, average: Average, by: AverageSeries, proof: SeriesProof, label: str) -> Iterator[str]:
        def in_code(expr: Expr) -> str:
            return self.code(average._in_shapes(expr))

        yield from self._functions(average, proof)
        (n,) = proof.operator[0].gens
        self.names[n] = "n"
        equation = [in_code(a.as_expr()) for a in proof.equation]
        positive = f"  # {equation[-1]} has no zero for v > 0" if proof.equation[-1].degree() > 0 else ""
        yield self.let("equation", f"[{', '.join(equation)}], {in_code(proof.rest.as_expr())}") + positive
        yield self.let("q", f"[{', '.join(in_code(q.as_expr()) for q in proof.operator)}]")
        yield self.let("y", in_code(proof.product.algebra.by_names(proof.product)))
        constant = in_code(by.constant)
        profile = f"g{label}" if constant == "1" else in_code(by.term)
        numbers = f"{proof.count}, y, functions, roots, {self.known}"
        yield f'F{label} = by_series("F{label}", {profile}, *equation, q, {numbers})'
        if constant != "1":
            yield self.let(f"F{label}", f"{constant} * F{label}")

    def _functions(self, average: Average, proof: SeriesProof) -> Iterator[str]:
        """State those functions of V in an average that no other had: their derivatives, and first terms."""
        algebra, V = proof.product.algebra, symbols.V
        rows = algebra.table([proof.product])
        expansion = Expansion(algebra, V, self.terms)
        series = {made.symbol: expansion.of(made.meaning) for made in rows if made.slope is not None}
        rows = algebra.table([proof.product, *(c for terms in series.values() for c in terms.coefficients)])
        fresh = dict[Expr, Generator]()
        for made in rows:
            meaning = average._in_shapes(made.meaning)
            if meaning not in self.functions:
                self.functions[meaning] = self._safe.new(_generator(meaning))
                fresh[sp.Symbol(self.functions[meaning])] = made
            self.names[made.symbol] = self.functions[meaning]
        self.names |= {x: x.name for x in fresh}
        if len(fresh) == len(self.functions):
            yield "functions, roots = {}, {}  # of V: what each is, its derivative, its first terms at V = 0"
        yield from self.declare(*fresh)
        symbols_of = series.keys() & {made.symbol for made in fresh.values()}
        self.known = min([self.known, *(series[symbol].known for symbol in symbols_of)])
        for x, (symbol, meaning, slope, square) in fresh.items():
            start = meaning
            if (own := series.get(symbol)) is not None:
                powers = enumerate(own.coefficients, own.order)
                start = sp.Add(*[algebra.by_names(c) * V**i for i, c in powers if i < self.known])
            entry = [average._in_shapes(part) for part in (meaning, slope or sp.S.Zero, start)]
            yield self.let(f"functions[{x}]", ", ".join(map(self.code, entry))) + _source(meaning)
            if square is not None:
                yield self.let(f"roots[{x}]", average._in_shapes(square))

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
        yield "# The law is a sum of terms a g(v/b), which add N a/b F(V/b) each: criteria are linear, and scale"
        for term in self.form.terms:
            if term not in numbers:
                law.append(self.code(term.amplitude))
                continue
            label, scale = self.numbers[numbers[term]], term.scale
            law.append(
                f"({self.code(term.amplitude)}) * {self._scaled(f'g{label}', symbols.v / scale, term.shapes)}"
            )
            weight, average = (
                self.code(term.amplitude / scale),
                self._scaled(f"F{label}", symbols.V / scale, term.shapes),
            )
            total.append(f"({weight}) * {average}")
        yield self.let("law", " + ".join(law) or "0")
        yield 'assert vanishes(mu - law), "the split of the law into terms"'
        yield self.let("total", f"N * ({' + '.join(total) or '0'})")
        yield 'assert vanishes(c - total), "the sum of the averages"'

    def _scaled(self, function: str, speed: Expr, shapes: Mapping[Expr, Expr]) -> str:
        """Return a profile or an average at a speed in units of the scale, with the law's shapes."""
        (unit,) = {symbols.v, symbols.V} & speed.free_symbols
        if not shapes:
            return function if speed == unit else f"{function}.subs({self.code(unit)}, {self.code(speed)})"
        values = ", ".join(f"{self.names[x]}: {self.code(to)}" for x, to in {unit: speed, **shapes}.items())
        return f"{function}.subs({{{values}}}, simultaneous=True)"

    def _points(self) -> Iterator[str]:
        """Compare with the definition by quadrature."""
        V, mu = symbols.V, self.form.law.expr
        kinks = places(mu)
        if self.criterion.weight is None:
            yield "compare_slope(c, -N * mu)"
        elif self.criterion.is_polynomial:
            rest = self.criterion.boundary(mu)
            value = "c" if rest == 0 else formatted(f"c - N * ({self.code(rest)})")
            integrand = "N * mu * K"
            if elementary(mu) != mu:  # all digits of coth(v) - 1/v cancel close to 0
                integrand = f"sp.Piecewise((0, v < Rational(1, 10**40)), ({integrand}, True))"
                integrand += ".rewrite(sp.coth, sp.tanh)"
            yield line(f"compare({value}, {integrand}, v, 2 * V, [{', '.join(map(self.code, kinks))}])")
        else:
            angles = ", ".join(self.code(2 * sp.asin(sp.sqrt(place / (2 * V)))) for place in kinks)
            yield line(f"compare(c, N * mu.subs(v, 2 * V * sin(theta / 2) ** 2) * K, theta, pi, [{angles}])")

    # -- the limits ----------------------------------------------------------------------------------

    def _limits(self) -> Iterator[str]:
        """State the limits for low and for high belt speeds by the slope there."""
        low, high, slope = self.form.limits.at_rest, self.form.limits.far, elementary(self.form.law.slope_expr)
        removable, at_rest = slope != self.form.law.slope_expr, slope.subs(symbols.v, 0)
        singular = (
            low is None or low.has(symbols.V, sp.oo, -sp.oo) or at_rest.has(sp.nan, sp.zoo, sp.oo, sp.Piecewise)
        )
        if not singular:
            yield from self._said("at_rest", low, "as V and all slip speeds fall to 0, c tends to -N mu'(0)")
            yield 'assert vanishes(at_rest + N * sp.diff(mu, v).subs(v, 0)), "the limit for low belt speeds"'
        elif low is not None and not (removable and low.has(symbols.V)):
            # Of a slope such as that of coth(v) - 1/v twice as many digits cancel; SymPy takes a hundred at most.
            speed = f"Rational(1, 10**{25 if removable else 200})"
            yield from self._limit("at_rest", low, speed, "V and all slip speeds fall to 0", "low")
        if high is not None:
            yield from self._limit("far", high, "10**200", "V grows, and slow slip loses its weight", "high")

    def _limit(self, name: str, limit: Expr, speed: str, moves: str, where: str) -> Iterator[str]:
        """State a limit, or the power of V that c is like, by the slope close to the end."""
        slope, message = f"N * sp.diff(mu, v).subs(v, {speed})", f'"the limit for {where} belt speeds"'
        power = limit.as_coeff_exponent(symbols.V)[1]
        if limit.has(sp.oo, -sp.oo):
            ends = "-N mu' grows beyond bounds, and c too: w > 0"
            yield from self._said(name, f"{'-' * (limit == -sp.oo)}sp.oo", f"as {moves}, {ends}")
            nearer = slope.replace("200", "100")
            yield f"assert at(0, {slope} / ({nearer})) > 1.5, {message}"
            yield f"assert at(0, {slope}) * {name} < 0, {message}"
        elif power == 0:
            yield from self._said(name, limit, f"as {moves}, c tends to -N mu', compared at one v")
            # Apart: SymPy would look for digits of a sum that cancels, as far as those of exp(-10**200).
            number = f"at(0, {name})" if limit.free_symbols else name
            yield f"assert abs({number} + at(0, {slope})) < 1e-25, {message}"
        else:
            p, mean = self.code(power), ""
            if self.criterion.weight is not None:
                mean = f"sp.Integral(w * (1 + s) ** ({p}), (s, -1, 1)) * "
            yield from self._said(name, limit, f"as {moves}, mu' is like v^p, its average like V^p <(1 + s)^p>")
            yield self.let("like", f"-{mean}{slope} * (V / {speed}) ** ({p})")
            yield f"assert abs(at(0, {name} / like) - 1) < 1e-25, {message}"

    def _said(self, name: str, value: Expr | str, comment: str) -> Iterator[str]:
        """State a value with a comment behind it, or above where that is too long."""
        text = self.let(name, value)
        if len(text) + len(comment) + 4 <= WIDTH:
            yield f"{text}  # {comment}"
        else:
            yield from (f"# {comment}", text)


def _series(averages: Iterable[Average]) -> Iterator[AverageSeries]:
    """Return the averages that are proved as power series, those that others are the derivatives of too."""
    for average in averages:
        for step in average.steps:
            if isinstance(step.by, Differentiated):
                yield from _series([step.by.source])
            elif isinstance(step.by, AverageSeries) and step.verdict.status is Status.PROVED:
                yield step.by


def _generator(meaning: Expr) -> str:
    """Return a name for a function of V, such as besseli_1 or exp_V."""
    orders = [str(argument) for argument in meaning.args[:-1] if argument.is_Integer]
    if meaning.is_Pow and not isinstance(meaning, sp.exp):
        return "root"
    if meaning.is_Mul:
        return "theta"  # of a hypergeometric function, theta = V d/dV
    return "_".join([meaning.func.__name__ if meaning.args else "constant", *(orders or "V")])


def _pole(coefficient: Expr) -> int:
    """Return the order of the pole at 0 of a rational function whose first variable is that of an algebra."""
    return int(min(monomial[0] for monomial in coefficient.denom.monoms()))


def _source(function: Expr) -> str:
    """Return a comment with the section of the Digital Library of Mathematical Functions on a function."""
    known = row(function)
    return f"  # DLMF {known.dlmf}" if known is not None and known.dlmf else ""
