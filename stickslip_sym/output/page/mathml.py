"""Formulas as presentation MathML, which browsers set without a script, in the order in which a person writes."""

from collections.abc import Callable
from typing import Any

import sympy as sp
from sympy.printing.mathml import MathMLPresentationPrinter

from stickslip_sym.output.page.elements import Html, escaped

__all__ = ["FormulaPrinter", "relation"]


def relation(left: Any, sign: str, right: Any, printer: "Callable[[], FormulaPrinter] | None" = None) -> Html:
    """Return a relation of two expressions as a ``math`` element in block form."""
    sides = ((printer or FormulaPrinter)().doprint(side) for side in (left, right))
    inner = f"<mo>{escaped(sign)}</mo>".join(sides)
    return Html(f'<math xmlns="http://www.w3.org/1998/Math/MathML" display="block"><mrow>{inner}</mrow></math>')


class FormulaPrinter(MathMLPresentationPrinter):  # type: ignore[misc]  # SymPy is untyped
    """SymPy's printer, with the order of terms, the products and the powers of e that a person writes."""

    def doprint(self, expr: Any) -> str:
        """Return a term as MathML; SymPy's named characters are none in XML."""
        text: str = self._print(expr).toxml()
        for name, character in (("InvisibleTimes", "\u2062"), ("dd", "d"), ("ExponentialE", "e")):
            text = text.replace(f"&amp;{name};", character).replace(f"&{name};", character)
        return text.replace("&amp;#", "&#").replace("<mo>-</mo>", "<mo>−</mo>")

    def _node(self, tag: str, *children: Any) -> Any:
        node = self.dom.createElement(tag)
        for child in children:
            node.appendChild(self.dom.createTextNode(child) if isinstance(child, str) else child)
        return node

    def _as_ordered_terms(self, expr: Any, order: str | None = None) -> list[Any]:
        terms: list[Any] = super()._as_ordered_terms(expr, order=order)
        return sorted(terms, key=lambda term: bool(term.could_extract_minus_sign()))

    def _print_Dummy(self, symbol: Any) -> Any:
        return self._print_Symbol(symbol)

    def _print_AppliedUndef(self, expr: Any) -> Any:
        return self._called(self._print_Symbol(sp.Symbol(expr.func.__name__)), *expr.args)

    def _print_BesselBase(self, expr: Any) -> Any:
        head = self._node("mi", type(expr).__name__[-1].upper())
        return self._called(self._node("msub", head, self._print(expr.order)), expr.argument)

    def _print_polylog(self, expr: Any) -> Any:
        order, argument = expr.args
        return self._called(self._node("msub", self._node("mi", "Li"), self._print(order)), argument)

    def _called(self, head: Any, *arguments: Any) -> Any:
        row = self._node("mrow", head, self._node("mo", "("))
        for position, argument in enumerate(arguments):
            if position:
                row.appendChild(self._node("mo", ","))
            row.appendChild(self._print(argument))
        row.appendChild(self._node("mo", ")"))
        return row

    def _print_Mul(self, expr: Any) -> Any:
        integrals, rest = sp.sift(expr.args, lambda factor: isinstance(factor, sp.Integral), binary=True)
        above, below = sp.fraction(sp.Mul(*rest), exact=True)  # a power of e stays where it is
        if below == 1:
            return self._product(expr)
        if integrals:
            parts = [self._print(part) for part in (sp.Mul(*rest), *integrals)]
            return self._node("mrow", parts[0], self._node("mo", "\u2062"), *parts[1:])
        sign = above.could_extract_minus_sign()
        fraction = self._node("mfrac", self._product(-above if sign else above), self._print(below))
        return self._node("mrow", self._node("mo", "−"), fraction) if sign else fraction

    def _product(self, expr: Any) -> Any:
        """Print factors in a row: a sign, numbers, then symbols, sums, functions and integrals."""
        factors: list[Any] = []
        for factor in sp.Mul.make_args(expr):
            factors += _undistributed(factor)
        factors = [sp.Mul(*[f for f in factors if f.is_Number]), *(f for f in factors if not f.is_Number)]
        row = self.dom.createElement("mrow")
        if factors[0].is_negative:
            row.appendChild(self._node("mo", "−"))
            factors[0] = -factors[0]
        shown = [factor for factor in factors if factor != 1] or [sp.S.One]
        for position, factor in enumerate(sorted(shown, key=_rank)):
            if position:
                row.appendChild(self._node("mo", "\u2062"))
            if isinstance(factor, sp.Add) and len(shown) > 1:
                for part in (self._node("mo", "("), self._print(factor), self._node("mo", ")")):
                    row.appendChild(part)
            else:
                row.appendChild(self._print(factor))
        return row

    def _print_Integral(self, expr: Any) -> Any:
        variable, low, high = expr.limits[0]
        sign = self._node("mo", "∫")
        if low == high:  # over a cycle, or a path
            limits = self._node("msub", sign, self._print(low))
        else:
            limits = self._node("msubsup", sign, self._print(low), self._print(high))
        body = self._product(expr.function)
        if isinstance(expr.function, sp.Add):
            body = self._node("mrow", self._node("mo", "("), body, self._node("mo", ")"))
        end = self._node("mrow", self._node("mi", "d"), self._print(variable))
        end.firstChild.setAttribute("mathvariant", "normal")
        return self._node("mrow", limits, body, end)


def _undistributed(factor: Any) -> tuple[Any, ...]:
    """Return 3 and a - b for 3 a - 3 b: SymPy multiplies numbers into sums."""
    if isinstance(factor, sp.Add):
        content, rest = factor.primitive()
        if all(abs(term.as_coeff_Mul()[0]) == 1 for term in rest.args):
            return content, rest
    return (factor,)


def _rank(factor: Any) -> tuple[Any, ...]:
    base = factor.base if isinstance(factor, sp.Pow) else factor
    kinds = (sp.Number, sp.Symbol, sp.Add, sp.exp, sp.core.function.AppliedUndef, sp.Function, sp.Integral)
    kind = next((i for i, kind in enumerate(kinds) if isinstance(base, kind)), len(kinds))
    text = str(factor)
    return (kind, len(text)) if kind == 2 else (kind, text.endswith("u"), text[0].isupper(), text)
