r"""SymPy's printer for LaTeX, with sums, products and functions as a person writes them.

Long sums stand beside their fraction, not on it, exponents and arguments have slashes, and brackets grow from ( )
to [ ] to { }. A formula has one reading only: after a slash stands one factor, and nothing after it.
What stands in a product, over or under a slash, or behind a minus gets brackets by how it was printed, not by what
kind of expression it is: a power may have become a quotient, and a sum may be one factor alone.
"""

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from enum import IntEnum
from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef
from sympy.printing.conventions import requires_partial
from sympy.printing.latex import LatexPrinter

from stickslip_sym.core.aliases import Condition, Expr, Notation
from stickslip_sym.core.functions import CONSTANTS, Constant, Function, elementary, row
from stickslip_sym.output.notation import distinct_notation, latex_name, look
from stickslip_sym.output.text_printer import Readable, decimal, is_over_decimal, spellings

_SHORT_SUM = 30  # characters of LaTeX without braces and styles, of a sum that may stand on a fraction
_SHORT_CHARACTERS = 48  # of one that may stand there alone, and that one pair of brackets holds in a line
_NAMED = CONSTANTS.keys() - {sp.E, sp.I}  # E and I are printed by methods of their own
_NUMBER, _FORCE, _SYMBOL, _SPEED, _SUM, _EXP, _FUNCTION, _OTHER = range(8)
_TOKEN = re.compile(r"\\[A-Za-z]+|\\.|\s+|.", re.S)
_OPENING = frozenset({"{", "(", "[", r"\{", r"\left", r"\begin"})
_CLOSING = frozenset({"}", ")", "]", r"\}", r"\right", r"\end"})
_TALL = re.compile(r"\\frac|\\int|\\sum|\\left|\\bigg|\\begin")
_OPERATORS = (r"{\mathrm{d}", r"{\partial")  # what stands on the fraction of a derivative


class Binding(IntEnum):
    """What a text is read as, from the loosest to the tightest."""

    CASES = 0
    """A choice, whose brace on the left nothing closes on the right."""
    SUM = 1
    OPEN = 2
    """An integral or a derivative, whose end is where its term ends."""
    QUOTIENT = 3
    """With a slash: what follows would be taken for a part of the denominator."""
    PRODUCT = 4
    FACTOR = 5


_KINDS = {
    r"\begin": Binding.CASES, **dict.fromkeys("+-=<>,;", Binding.SUM), r"\int": Binding.OPEN,
    "/": Binding.QUOTIENT, r"\,": Binding.PRODUCT, r"\cdot": Binding.PRODUCT,
}  # fmt: skip


def binding(latex: str) -> Binding:
    """Return what a text is read as."""
    weakest = Binding.FACTOR
    depth = 0
    for token in _TOKEN.finditer(latex):
        text = token[0]
        if depth == 0:
            kind = Binding.PRODUCT if text.isspace() else _KINDS.get(text, Binding.FACTOR)
            if text == r"\frac" and latex.startswith(_OPERATORS, token.end()):
                kind = Binding.OPEN
            weakest = min(weakest, kind)
        depth += (text in _OPENING) - (text in _CLOSING)
    return weakest


def held(latex: str, least: Binding) -> str:
    """Return a text, in brackets if it holds together less tightly than is needed."""
    return bracketed(latex) if binding(latex) < least else latex


def bracketed(inner: str) -> str:
    """Return a formula in brackets that differ from those inside, as high as it is."""
    opening, closing = (r"\{", r"\}") if "[" in inner else ("[", "]") if "(" in inner else ("(", ")")
    if _TALL.search(inner):
        # Lines may break between brackets of a given size, not between \left and \right.
        sizes = (r"\left", r"\right") if _length(inner) < _SHORT_CHARACTERS else (r"\biggl", r"\biggr")
    elif opening != "(" or r"\sqrt" in inner:
        sizes = (r"\bigl", r"\bigr")
    else:
        sizes = ("", "")
    return f"{sizes[0]}{opening}{inner}{sizes[1]}{closing}"


def _length(latex: str) -> int:
    """Return about how many characters a formula shows."""
    return len(re.sub(r"\\(mathrm|operatorname|left|right|[bB]igg?[lr])|[{}_^ ]", "", latex))


class _Latex(Readable, LatexPrinter):
    printmethod = None  # SymPy's constants would print themselves, Catalan's as G beside any G

    def __init__(self, names: Notation, dummies: Mapping[Expr, str], *, slashes: bool) -> None:
        super().__init__({"diff_operator": "rd"})
        self.dummies = dummies
        self._names_of = names
        self._slashes = slashes
        self._taken = frozenset(map(look, names.values()))

    @contextmanager
    def _flat(self) -> Iterator[None]:
        """Print fractions with slashes."""
        before = self._slashes
        self._slashes = True
        try:
            yield
        finally:
            self._slashes = before

    # -- names ---------------------------------------------------------------------------------------

    def _print_Symbol(self, expr: Expr, style: str = "plain") -> str:
        del style
        return self._names_of.get(expr.name) or latex_name(expr.name)

    def _print_Dummy(self, expr: Expr) -> str:
        return self._names_of[self.dummies[expr]]

    def _print(self, expr: Expr, **options: Any) -> str:
        if expr in _NAMED:
            return self._called(CONSTANTS[expr])
        function = row(expr) if isinstance(expr, sp.Function) else None
        if function is not None and function.latex is not None:
            return self._print_function(function, *expr.args)
        return super()._print(expr, **options)

    def _called(self, head: Function | Constant) -> str:
        r"""Return the name of a function or a constant, another one where a symbol looks like it.

        Beside a parameter ``eta``, ``\eta (1 + v)`` could be Dirichlet's function of 1 + v as well as a product.
        """
        # K_1 is not K, but a symbol K_1 looks like the function with the index 1.
        indexed = isinstance(head, Function) and head.indexed
        others = {other.partition("_")[0] for other in self._taken} if indexed else self._taken
        word = head.name.replace("_", "")
        choices = (head.latex or f"\\operatorname{{{word}}}", f"\\operatorname{{{word}}}")
        return next(
            (choice for choice in choices if look(choice) not in others), f"\\operatorname{{sympy.{word}}}"
        )

    def _print_Exp1(self, _: Expr) -> str:
        return r"\exp(1)" if "e" in self._taken else r"\mathrm{e}"

    def _print_ImaginaryUnit(self, _: Expr) -> str:
        return r"\sqrt{-1}" if "i" in self._taken else r"\mathrm{i}"

    def _print_Infinity(self, _: Expr) -> str:
        return r"\infty"

    def _print_NegativeInfinity(self, _: Expr) -> str:
        return r"-\infty"

    # -- sums and products -----------------------------------------------------------------------------

    def _print_Add(self, expr: Expr, order: str | None = None) -> str:
        # Polynomials first; what decays comes after them.
        terms = sorted(
            self._as_ordered_terms(expr, order=order), key=lambda term: bool(term.atoms(sp.Function, sp.exp))
        )
        first = next((term for term in terms if not term.could_extract_minus_sign()), terms[0])
        if len(terms) == 2:  # 1 + v/v_s
            first = next((term for term in terms if term.is_Rational and term > 0), first)
        terms.remove(first)
        # The brace of a choice would take in the terms after it.
        text, *others = (held(self._print(term), Binding.SUM) for term in [first, *terms])
        for printed in others:
            text += f" - {printed[1:]}" if printed.startswith("-") else f" + {printed}"
        return text

    def _print_Mul(self, expr: Expr) -> str:
        number: Expr = sp.Integer(1)
        parts = []
        for factor in expr.args:
            content, primitive = factor.primitive() if factor.is_Add else (factor, sp.S.One)
            if content.is_Rational and (content.is_Integer or not factor.is_Add):  # 2 (a - b), not 2 a - 2 b
                number *= content
                factor = primitive
            if factor is not sp.S.One:
                parts.append(factor)
        for position, factor in enumerate(parts):
            if number < 0 and factor.is_Add and factor.has(sp.Function) and -1 in factor.args:
                number, parts[position] = -number, -factor  # not -(tanh(x) - 1)
        product = self._product(abs(number), parts)
        if number < 0:
            return f"-{held(product, Binding.OPEN)}"
        return product

    def _print_Rational(self, expr: Expr) -> str:
        if text := decimal(expr, shortest=True):
            return text
        if self._slashes:
            fraction = f"{abs(expr.p)}/{expr.q}"
        else:
            fraction = f"\\frac{{{abs(expr.p)}}}{{{expr.q}}}"
        return f"-{fraction}" if expr < 0 else fraction

    def _product(self, number: Expr, parts: list[Expr]) -> str:
        top = sorted((factor for factor in parts if not _is_below(factor)), key=self._place)
        below = [
            sp.Pow(factor.base, -factor.exp, evaluate=False) if factor.exp != -1 else factor.base
            for factor in parts
            if _is_below(factor)
        ]
        above: Expr = sp.Integer(number.p)
        under: Expr = sp.Integer(number.q)
        if decimal(number, shortest=True):
            above = number
            under = sp.S.One
        elif is_over_decimal(number):
            above = sp.S.One
            under = 1 / number
        if not below and under == 1:
            return self._row(above, top)
        with self._flat():
            denominator = self._row(under, sorted(below, key=self._place))
        if self._slashes:
            numerator = held(self._row(above, top), Binding.PRODUCT)
            return f"{numerator}/{held(denominator, Binding.FACTOR)}"
        head = [factor for factor in top if self._place(factor)[0] <= _SPEED or self._is_short(factor)]
        tail = [factor for factor in top if factor not in head]
        if not head and above == 1 and len(tail) == 1 and _length(self._print(tail[0])) < _SHORT_CHARACTERS:
            head = tail
            tail = []
        with self._flat():
            fraction = f"\\frac{{{self._row(above, head)}}}{{{denominator}}}"
        if tail:
            return self._row(sp.S.One, tail, fraction)
        return fraction

    def _is_short(self, factor: Expr) -> bool:
        return bool(factor.is_Add) and len(factor.args) <= 2 and _length(self._print(factor)) < _SHORT_SUM

    def _row(self, number: Expr, parts: list[Expr], fraction: str = "") -> str:
        """Return factors beside each other, after a fraction; what stands alone has no brackets."""
        first = [] if number == 1 and (fraction or parts) else [sp.sympify(number)]
        if not fraction and len(first) + len(parts) == 1:
            return self._print([*first, *parts][0])
        if fraction:
            texts = [fraction]
        else:
            texts = [self._print(factor) for factor in first]
        for position, factor in enumerate(parts):
            printed = self._print(factor)
            is_last = position == len(parts) - 1
            if (kind := binding(printed)) < Binding.PRODUCT and not (kind is Binding.OPEN and is_last):
                printed = bracketed(printed)
            if printed.startswith((r"\mathrm{e}^", "{}_")) and texts:
                printed = f"\\,{printed}"
            elif texts and (printed[0].isdigit() or printed.startswith(r"\frac")):
                printed = f"\\cdot {printed}"  # 2 3^x would be a power of 23, and 2 1/3 a mixed number
            texts.append(printed)
        return " ".join(texts)

    def _place(self, factor: Expr) -> tuple[int, str]:
        """Return where a factor stands in a product: 5 N alpha V (mu_s - mu_m) e^x f(x)."""
        base = factor.base if factor.is_Pow else factor
        if base.is_number:
            return (_NUMBER, "")
        if base.is_Symbol:
            name = base.name
            if name == "N":
                kind = _FORCE
            elif name in "Vvx":
                kind = _SPEED
            else:
                kind = _SYMBOL
            greek = latex_name(name).startswith("\\") and not latex_name(name).startswith("\\mathit")
            return (kind, f"{not greek}{name}")
        if base.is_Add:
            return (_SUM, f"{len(base.args):04}{base.has(sp.Pow)}{base}")
        kinds = {sp.exp: _EXP, sp.Piecewise: _SUM, sp.Function: _FUNCTION, sp.Integral: _OTHER, sp.Expr: _SUM}
        return (next(kind for cls, kind in kinds.items() if isinstance(base, cls)), str(base))

    # -- powers and functions ------------------------------------------------------------------------

    def _print_Pow(self, expr: Expr) -> str:
        base = expr.base
        exponent = expr.exp
        if base is sp.E:
            return self._print_exp(sp.exp(exponent, evaluate=False))
        if _is_below(expr):
            return self._product(sp.Integer(1), [expr])
        if exponent == sp.Rational(1, 2):
            return f"\\sqrt{{{self._print(base)}}}"
        with self._flat():
            raised = f"^{{{self._print(exponent)}}}"
        function = row(base)
        if function is not None and function.squared and exponent.is_Integer:
            return self._applied(f"{self._called(function)}{raised}", base.args[0])
        printed = self._print(base)
        if "^" not in printed and (base.is_Symbol or base.is_NumberSymbol):
            if "'" in printed:
                return f"{{{printed}}}{raised}"
            return f"{held(printed, Binding.FACTOR)}{raised}"
        return f"{printed if base.is_Integer and base >= 0 else bracketed(printed)}{raised}"

    def _print_NumberPower(self, expr: Expr) -> str:
        return self._print_Pow(sp.Pow(*expr.args, evaluate=False))

    def _print_exp(self, expr: Expr) -> str:
        argument = expr.args[0]
        with self._flat():
            printed = self._print(argument)
        # Beside a symbol e, an upright e is not distinct enough.
        powers = any(not power.exp.is_number for power in argument.atoms(sp.Pow))
        deep = "e" in self._taken or argument.has(sp.Add) or powers
        return f"\\exp{bracketed(printed)}" if deep else f"\\mathrm{{e}}^{{{printed}}}"

    def _print_function(self, function: Function, *arguments: Expr) -> str:
        name = self._called(function)
        if function.indexed:
            index, *rest = arguments
            with self._flat():
                return self._applied(f"{name}_{{{self._print(index)}}}", *rest)
        return self._applied(name, *arguments)

    def _print_Function(self, expr: Expr, exp: str | None = None) -> str:
        if not isinstance(expr, AppliedUndef):
            return super()._print_Function(expr, exp)
        return self._applied(self._print(sp.Symbol(type(expr).__name__)), *expr.args)

    def _applied(self, name: str, *arguments: Expr) -> str:
        with self._flat():
            return name + bracketed(", ".join(self._print(argument) for argument in arguments))

    def _print_Derivative(self, expr: sp.Derivative) -> str:
        if primed := self._primed(expr):
            return primed
        sign = r"\partial" if requires_partial(expr.expr) else r"\mathrm{d}"

        def power(count: int) -> str:
            return f"^{{{count}}}" if count != 1 else ""

        over = sign + power(sum(count for _, count in expr.variable_count))
        below = " ".join(f"{sign} {self._print(symbol)}{power(count)}" for symbol, count in expr.variable_count)
        return f"\\frac{{{over}}}{{{below}}} {held(self._print(expr.expr), Binding.FACTOR)}"

    def _print_Integral(self, expr: sp.Integral) -> str:
        if len(expr.limits) != 1 or len(expr.limits[0]) != 3:
            return super()._print_Integral(expr)
        variable, *ends = expr.limits[0]
        printed = self._print(expr.function)
        sign = ""
        if printed.startswith("-") and not expr.function.is_Add:
            sign = "-"
        printed = bracketed(printed) if expr.function.is_Add else printed.removeprefix(sign)
        with self._flat():
            low, high = map(self._print, ends)
        return f"{sign}\\int_{{{low}}}^{{{high}}} {printed} \\,\\mathrm{{d}}{self._print(variable)}"

    def _print_hyper(self, expr: sp.hyper) -> str:
        with self._flat():
            rows = [", ".join(self._print(argument) for argument in group) for group in expr.args[:2]]
            inside = "; ".join([*rows, self._print(expr.args[2])])
            return f"{{}}_{{{len(expr.ap)}}}F_{{{len(expr.bq)}}}{bracketed(inside)}"


def _is_below(factor: Expr) -> bool:
    """Whether a factor belongs under the fraction bar."""
    return bool(factor.is_Pow and factor.base is not sp.E and factor.exp.could_extract_minus_sign())


def latex(expr: Expr | Condition, names: Notation | None = None, *, inline: bool = False) -> str:
    r"""Return an expression or a relation as LaTeX, e.g. ``N (\mu_{\mathrm{s}} - \mu_{\mathrm{m}})``.

    - `names`: LaTeX of symbols that shall not be written as usual (`notation`).
    - `inline`: for a line of text: fractions have slashes.
    """
    dummies = spellings(expr, names or ())
    written = [dummies.get(symbol, symbol.name) for symbol in expr.atoms(sp.Symbol)]
    printer = _Latex(distinct_notation(written, names or {}), dummies, slashes=inline)
    return printer.doprint(elementary(expr))  # type: ignore[type-var]  # one or the other


def latex_value(number: Expr) -> str:
    """Return the value of a letter in a line of text: a number that has a decimal as that, 1/10 as 0.1."""
    return (decimal(number, least=0) if number.is_Rational else "") or latex(number, inline=True)
