"""SymPy's printers, with sums, products and derivatives as a person writes them.

A sum starts with a positive term, and the derivative of a function of one variable is x'(t), also at a
given place, where SymPy prints ``Subs(Derivative(x(t), t), t, t_P)``. In LaTeX long sums stand beside their
fraction, not on it, exponents and arguments have slashes, and brackets grow from ( ) to [ ] to { }.
"""

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import sympy as sp
from sympy.printing.latex import LatexPrinter
from sympy.printing.str import StrPrinter

from stickslip_sym.notation import latex_name

__all__ = ["latex", "text"]


class _Readable:
    """What the printers for text and LaTeX have in common."""

    def _as_ordered_terms(self, expr: Any, order: str | None = None) -> list[Any]:
        terms: list[Any] = super()._as_ordered_terms(expr, order=order)  # type: ignore[misc]  # a printer's
        for position, term in enumerate(terms):
            if not term.could_extract_minus_sign():
                return [term, *terms[:position], *terms[position + 1 :]]
        return terms

    def _print_Derivative(self, expr: Any) -> str:
        return self._primed(expr, expr.expr.args[0]) or str(super()._print_Derivative(expr))  # type: ignore[misc]  # a printer's

    def _print_Subs(self, expr: Any) -> str:
        if isinstance(expr.expr, sp.Derivative) and len(expr.point) == 1:
            primed = self._primed(expr.expr, expr.point[0])
            if primed:
                return primed
        return str(super()._print_Subs(expr))  # type: ignore[misc]  # a printer's

    def _primed(self, derivative: Any, argument: Any) -> str:
        function = derivative.expr
        if not isinstance(function, sp.core.function.AppliedUndef) or len(function.args) != 1:
            return ""
        mark = "'" * sum(count for _, count in derivative.variable_count)
        name = self._print(sp.Symbol(function.func.__name__))  # type: ignore[attr-defined]  # a printer's
        return self._applied(f"{name}{mark}", argument)

    def _applied(self, name: str, argument: Any) -> str:
        return f"{name}({self._print(argument)})"  # type: ignore[attr-defined]  # a printer's


class _Text(_Readable, StrPrinter):  # type: ignore[misc]  # SymPy is untyped
    def _print_Dummy(self, expr: Any) -> str:
        return str(expr.name)


def text(expr: Any) -> str:
    """Return an expression or a relation as one line of text, e.g. ``N*(mu_s - mu_m)``."""
    if getattr(expr, "is_Relational", False):
        return f"{text(expr.lhs)} {expr.rel_op.replace('==', '=')} {text(expr.rhs)}"
    return str(_Text().doprint(expr))


_NAMES = {
    sp.log: r"\ln", sp.sin: r"\sin", sp.cos: r"\cos", sp.tan: r"\tan", sp.atan: r"\arctan",
    sp.sinh: r"\sinh", sp.cosh: r"\cosh", sp.tanh: r"\tanh", sp.coth: r"\coth",
    **{function: f"\\operatorname{{{name}}}" for function, name in (
        (sp.sech, "sech"), (sp.asinh, "arsinh"), (sp.acosh, "arcosh"), (sp.atanh, "artanh"), (sp.erf, "erf"),
        (sp.erfc, "erfc"), (sp.erfi, "erfi"), (sp.im, "Im"), (sp.re, "Re"), (sp.sign, "sgn"),
    )},
    sp.lowergamma: r"\gamma", sp.uppergamma: r"\Gamma", sp.gamma: r"\Gamma", sp.dirichlet_eta: r"\eta",
    sp.elliptic_k: "K", sp.elliptic_e: "E",
}  # fmt: skip
"""What an applied function is called; its arguments follow in parentheses."""
_INDEXED = {
    sp.besseli: "I", sp.besselj: "J", sp.besselk: "K", sp.bessely: "Y", sp.polylog: r"\operatorname{Li}",
}  # fmt: skip
"""Functions whose first argument is an index."""
_SQUARED = (sp.sin, sp.cos, sp.tan, sp.sinh, sp.cosh, sp.tanh, sp.coth, sp.sech)
_TALL = re.compile(r"\\frac|\\int|\\sum|\\left|\\bigg|\\begin")
_SHORT_SUM = 30  # characters of LaTeX without braces and styles, of a sum that may stand on a fraction
_SHORT = 48  # of one that may stand there alone
_NUMBER, _FORCE, _SYMBOL, _SPEED, _SUM, _EXP, _FUNCTION, _OTHER = range(8)


def _length(text: str) -> int:
    return len(re.sub(r"\\(mathrm|operatorname|left|right|[bB]igg?[lr])|[{}_^ ]", "", text))


class _Latex(_Readable, LatexPrinter):  # type: ignore[misc]  # SymPy is untyped
    def __init__(self, names: Mapping[str, str], *, slashes: bool = False) -> None:
        super().__init__({"diff_operator": "rd", "imaginary_unit": "ri"})
        self._names_of = names
        self._slashes = slashes

    @contextmanager
    def _flat(self) -> Iterator[None]:
        """Print fractions with slashes."""
        before, self._slashes = self._slashes, True
        try:
            yield
        finally:
            self._slashes = before

    # -- names ---------------------------------------------------------------------------------------

    def _print_Symbol(self, expr: Any, style: str = "plain") -> str:
        del style
        return self._names_of.get(expr.name) or latex_name(expr.name)

    def _print_Dummy(self, expr: Any) -> str:
        return latex_name(expr.name)

    def _print_Exp1(self, expr: Any, exp: Any = None) -> str:
        del expr, exp
        return r"\mathrm{e}"

    def _print_Catalan(self, expr: Any, exp: Any = None) -> str:
        del expr, exp
        return "G"

    # -- sums ----------------------------------------------------------------------------------------

    def _print_Add(self, expr: Any, order: str | None = None) -> str:
        terms = self._as_ordered_terms(expr, order=order)
        # Polynomials first; what decays comes after them.
        terms = sorted(terms, key=lambda term: bool(term.atoms(sp.Function, sp.exp)))
        first = next((term for term in terms if not term.could_extract_minus_sign()), terms[0])
        if len(terms) == 2:  # 1 + v/v_s
            first = next((term for term in terms if term.is_Rational and term > 0), first)
        terms.remove(first)
        parts = [self._print(first)]
        for term in terms:
            printed = self._print(term)
            parts += ["-", printed[1:]] if printed.startswith("-") else ["+", printed]
        return " ".join(parts)

    def _bracketed(self, expr: Any) -> str:
        return self._bracket(self._print(expr))

    def _bracket(self, inner: str) -> str:
        opening, closing = (r"\{", r"\}") if "[" in inner else ("[", "]") if "(" in inner else ("(", ")")
        if _TALL.search(inner):
            # Lines may break between brackets of a given size, not between \left and \right.
            sizes = (r"\left", r"\right") if _length(inner) < _SHORT else (r"\biggl", r"\biggr")
        elif opening != "(" or r"\sqrt" in inner:
            sizes = (r"\bigl", r"\bigr")
        else:
            sizes = ("", "")
        return f"{sizes[0]}{opening}{inner}{sizes[1]}{closing}"

    # -- products ------------------------------------------------------------------------------------

    def _print_Mul(self, expr: Any) -> str:
        number, factors = sp.Integer(1), []
        for factor in sp.Mul.make_args(expr):
            if factor.is_Rational:
                number *= factor
                continue
            if factor.is_Add:
                content, primitive = factor.primitive()
                if content.is_Integer:  # 2 (a - b), where SymPy multiplies out
                    number, factor = number * content, primitive
            factors.append(factor)
        for position, factor in enumerate(factors):
            if number < 0 and factor.is_Add and factor.has(sp.Function) and -1 in factor.args:
                number, factors[position] = -number, -factor  # not -(tanh(x) - 1)
        product = self._product(abs(number), factors)
        return f"-{product}" if number < 0 else product

    def _print_Rational(self, expr: Any) -> str:
        if expr.q == 1:
            return str(expr.p)
        fraction = f"{abs(expr.p)}/{expr.q}" if self._slashes else f"\\frac{{{abs(expr.p)}}}{{{expr.q}}}"
        return f"-{fraction}" if expr < 0 else fraction

    def _product(self, number: Any, factors: list[Any]) -> str:
        top = [factor for factor in factors if not _is_below(factor)]
        below = [sp.Pow(factor.base, -factor.exp, evaluate=False) if factor.exp != -1 else factor.base
                 for factor in factors if _is_below(factor)]  # fmt: skip
        top, below = (sorted(part, key=self._place) for part in (top, below))
        if not below and number.q == 1:
            return self._row(number.p, top)
        with self._flat():
            denominator = self._row(number.q, below)
        if self._slashes:
            if len(below) + (number.q != 1) > 1 or any(factor.is_Add for factor in below):
                denominator = self._bracket(denominator)
            return f"{self._row(number.p, top)}/{denominator}"
        head = [factor for factor in top if self._place(factor)[0] <= _SPEED or self._is_short(factor)]
        tail = [factor for factor in top if factor not in head]
        if not head and number.p == 1 and len(tail) == 1 and _length(self._print(tail[0])) < _SHORT:
            head, tail = tail, []
        with self._flat():
            fraction = f"\\frac{{{self._row(number.p, head)}}}{{{denominator}}}"
        return self._row(1, tail, fraction) if tail else fraction

    def _is_short(self, factor: Any) -> bool:
        return bool(factor.is_Add) and len(factor.args) <= 2 and _length(self._print(factor)) < _SHORT_SUM

    def _row(self, number: Any, factors: list[Any], fraction: str = "") -> str:
        """Return factors beside each other, after a fraction; a sum that stands alone has no brackets."""
        if not fraction and not factors:
            return str(self._print(sp.sympify(number)))
        if not fraction and number == 1 and len(factors) == 1:
            return str(self._print(factors[0]))
        texts = [fraction] if fraction else [] if number == 1 else [self._print(sp.sympify(number))]
        for position, factor in enumerate(factors):
            printed = self._print(factor)
            last = position == len(factors) - 1
            if factor.is_Add or printed.startswith("-") or (isinstance(factor, sp.Integral) and not last):
                printed = self._bracket(printed)
            if printed.startswith(r"\mathrm{e}^") and texts:
                printed = f"\\,{printed}"
            texts.append(printed)
        return " ".join(texts)

    def _place(self, factor: Any) -> tuple[int, str]:
        """Return where a factor stands in a product: 5 N alpha V (mu_s - mu_m) e^x f(x)."""
        base = factor.base if factor.is_Pow else factor
        if base.is_number:
            return (_NUMBER, "")
        if base.is_Symbol:
            name = base.name
            kind = _FORCE if name == "N" else _SPEED if name in "Vvx" else _SYMBOL
            greek = latex_name(name).startswith("\\") and not latex_name(name).startswith("\\mathit")
            return (kind, f"{not greek}{name}")
        if base.is_Add:
            return (_SUM, f"{len(base.args):04}{base.has(sp.Pow)}{base}")
        if isinstance(base, sp.exp):
            return (_EXP, str(base))
        if isinstance(base, sp.Function) and not isinstance(base, sp.Piecewise):
            return (_FUNCTION, str(base))
        return (_OTHER if isinstance(base, sp.Integral) else _SUM, str(base))

    # -- powers and functions ------------------------------------------------------------------------

    def _print_Pow(self, expr: Any) -> str:
        base, exponent = expr.base, expr.exp
        if base is sp.E:
            return self._print_exp(sp.exp(exponent, evaluate=False))
        if _is_below(expr):
            return self._product(sp.Integer(1), [expr])
        if exponent == sp.Rational(1, 2):
            return f"\\sqrt{{{self._print(base)}}}"
        with self._flat():
            raised = f"^{{{self._print(exponent)}}}"
        if isinstance(base, _SQUARED) and exponent.is_Integer:
            return self._applied(f"{_NAMES[type(base)]}{raised}", base.args[0])
        printed = self._print(base)
        if base.is_Symbol or base.is_NumberSymbol:
            return f"{{{printed}}}{raised}" if "^" in printed or "'" in printed else f"{printed}{raised}"
        if base.is_Integer and base >= 0:
            return f"{printed}{raised}"
        return f"{self._bracket(printed)}{raised}"

    def _print_exp(self, expr: Any, exp: Any = None) -> str:
        argument = expr.args[0]
        with self._flat():
            printed = self._print(argument)
        deep = argument.has(sp.Add) or any(not power.exp.is_number for power in argument.atoms(sp.Pow))
        result = f"\\exp{self._bracket(printed)}" if deep else f"\\mathrm{{e}}^{{{printed}}}"
        return result if exp is None else f"{self._bracket(result)}^{{{exp}}}"

    def _print_Function(self, expr: Any, exp: Any = None) -> str:
        kind = type(expr)
        if kind in _INDEXED:
            index, *arguments = expr.args
            with self._flat():
                name = f"{_INDEXED[kind]}_{{{self._print(index)}}}"
        elif kind.__name__ == "Lerch":
            name, arguments = r"\Phi", expr.args
        elif kind in _NAMES:
            name, arguments = _NAMES[kind], expr.args
        elif isinstance(expr, sp.core.function.AppliedUndef):
            name, arguments = self._print(sp.Symbol(kind.__name__)), expr.args
        else:
            return str(super()._print_Function(expr, exp))
        result = self._applied(name, *arguments)
        return result if exp is None else f"{self._bracket(result)}^{{{exp}}}"

    def _applied(self, name: str, *arguments: Any) -> str:
        with self._flat():
            return name + self._bracket(", ".join(self._print(argument) for argument in arguments))

    def _print_Integral(self, expr: Any) -> str:
        if len(expr.limits) != 1 or len(expr.limits[0]) != 3:
            return str(super()._print_Integral(expr))
        variable, *ends = expr.limits[0]
        printed = self._print(expr.function)
        sign = "-" if printed.startswith("-") and not expr.function.is_Add else ""
        if expr.function.is_Add:
            printed = self._bracket(printed)
        with self._flat():
            low, high = map(self._print, ends)
        differential = f"\\,\\mathrm{{d}}{self._print(variable)}"
        return f"{sign}\\int_{{{low}}}^{{{high}}} {printed.removeprefix(sign)} {differential}"

    def _print_elliptic_pi(self, expr: Any, exp: Any = None) -> str:
        del exp
        return self._applied(r"\Pi", *expr.args)

    def _print_hyper(self, expr: Any, exp: Any = None) -> str:
        del exp
        with self._flat():
            rows = [", ".join(self._print(argument) for argument in group) for group in expr.args[:2]]
            inside = "; ".join([*rows, self._print(expr.args[2])])
            return f"{{}}_{{{len(expr.ap)}}}F_{{{len(expr.bq)}}}{self._bracket(inside)}"


def _special(name: str) -> Any:
    return lambda self, expr, exp=None: self._print_Function(expr, exp)


for _kind in [*_NAMES, *_INDEXED]:
    # SymPy's printer has a method of its own for some of them.
    setattr(_Latex, f"_print_{_kind.__name__}", _special(_kind.__name__))


def _is_below(factor: Any) -> bool:
    """Whether a factor belongs under the fraction bar."""
    return bool(factor.is_Pow and factor.base is not sp.E and factor.exp.could_extract_minus_sign())


def latex(expr: Any, names: Mapping[str, str] | None = None, *, inline: bool = False) -> str:
    r"""Return an expression or a relation as LaTeX, e.g. ``N (\mu_{\mathrm{s}} - \mu_{\mathrm{m}})``.

    Parameters
    ----------
    expr : sympy.Expr or sympy.Rel
    names : mapping of str to str, optional
        LaTeX of symbols that shall not be written as usual (`notation`).
    inline : bool
        For a line of text: fractions have slashes.
    """
    return str(_Latex(names or {}, slashes=inline).doprint(expr))
