"""The paper's equations by their numbers, as a reader of the paper sees them: in MathML."""

from dataclasses import dataclass
from typing import Any

import sympy as sp
from sympy.printing.mathml import MathMLPresentationPrinter

from derivations import paper
from stickslip_sym.core.symbols import N, V, a, b, c, k, m, mu, t, u

__all__ = ["EQUATIONS", "PrintedEquation", "mathml"]

_VELOCITY, _ACCELERATION = sp.symbols("xdot xddot", real=True)
_X_P, _X_Q, _V_P, _V_Q, _F, _X, _S = sp.symbols("x_P x_Q V_P V_Q f x S", real=True)
_MU_S, _V_R, _CYCLE, _TO = sp.symbols("mu_s v_r T P→Q", real=True)
_SPELLED = {"xdot": ("x", "˙"), "xddot": ("x", "¨")}


@dataclass(frozen=True)
class PrintedEquation:
    """An equation of the paper.

    Attributes
    ----------
    number : str
        As printed, with parentheses.
    about : str
    claims : tuple of str
        The checks that decide about it.
    """

    number: str
    about: str
    claims: tuple[str, ...]

    def mathml(self) -> str:
        """Return its relations as MathML, one element ``math`` each."""
        return " ".join(mathml(*relation) for relation in _relations(self.number))


EQUATIONS = tuple(
    PrintedEquation(f"({number})", about, claims)
    for number, about, claims in (
        (1, "stick", ("E1",)),
        (2, "slip", ("E2",)),
        (3, "exponential friction law", ("E3",)),
        (4, "polynomial friction law", ("E4",)),
        (5, "work and energy from P to Q", ("E5",)),
        (6, "balance over a cycle, for stick–slip and pure slip", ("E5",)),
        (7, "balance over a cycle, for damped slip", ("E7",)),
        (8, "linear friction coefficient", ("E9",)),
        (9, "its force", ("E9",)),
        (10, "the balance (6) with it", ("E10",)),
        (11, "pure slip", ("E11",)),
        (12, "what the least squares minimise", ("E13",)),
        (13, "the same over the relative velocity", ("E13",)),
        (14, "conditions of the minimum", ("E15",)),
        (15, "coefficients at the minimum", ("E15",)),
        (16, "the criterion: pure-slip damping of any law", ("E16", "S1")),
        (17, "the criterion for the exponential law", ("E17", "F6")),
        (18, "the criterion for the polynomial law", ("E18", "F7")),
    )
)


def _relations(number: str) -> list[tuple[Any, str, Any]]:
    """Return an equation as triples of left side, sign and right side; right sides are `paper.equations`."""
    sign = sp.Function("sgn")(_V_R)
    work = sp.Integral((_F - c * _VELOCITY) * _VELOCITY, (t, _CYCLE, _CYCLE))
    printed = {name: _as_printed(expr) for name, expr in paper.equations().items()}
    mu_of = mu(_V_R)
    written: dict[str, list[tuple[Any, str, Any]]] = {
        "(1)": [(_VELOCITY, "=", V), (_F, "=", c * _VELOCITY + k * _X), (sp.Abs(_F), "≤", _MU_S * N)],
        "(2)": [
            (m * _ACCELERATION + c * _VELOCITY + k * _X, "=", _F),
            (_F, "=", sp.Mul(-1, sign, mu_of, N, evaluate=False)),
        ],
        "(3)": [(mu_of, "=", printed["(3)"])],
        "(4)": [(mu_of, "=", printed["(4)"])],
        "(5)": [(sp.Integral(_F - c * _VELOCITY - k * _X, (_X, _TO, _TO)), "=", printed["(5)"])],
        "(6)": [(work, "=", sp.S.Zero)],
        "(7)": [(work, "<", sp.S.Zero)],
        "(8)": [(sp.Function("mu_L")(_V_R), "=", printed["(8)"])],
        "(9)": [(_F, "=", printed["(9)"])],
        "(10)": [(printed["(10)"], "=", sp.S.Zero)],
        "(11)": [(c, "=", printed["(11)"])],
        "(12)": [(_S, "=", printed["(12)"])],
        "(13)": [(_S, "=", printed["(13)"])],
        "(14)": [(sp.Derivative(sp.Function("S")(a, b), over), "=", sp.S.Zero) for over in (a, b)],
        "(15)": [(a, "=", printed["(15) a"]), (b, "=", printed["(15) b"])],
        "(16)": [(c, "=", printed["(16)"])],
        "(17)": [(c, "=", printed["(17)"])],
        "(18)": [(c, "=", printed["(18)"])],
    }
    return written[number]


def _as_printed(expr: Any) -> Any:
    """Write x(t_P) as x_P, its derivative there as V_P, and x'(t) as x with a dot."""
    speed = sp.diff(paper.motion, t)
    cycle = {sp.Integral(speed**2, (t, paper.t_P, paper.t_Q)): sp.Integral(_VELOCITY**2, (t, _CYCLE, _CYCLE))}
    places = {paper.t_P: (_X_P, _V_P), paper.t_Q: (_X_Q, _V_Q)}
    expr = expr.xreplace(cycle)
    for time, (place, velocity) in places.items():
        expr = expr.xreplace({speed.subs(t, time): velocity}).xreplace({paper.motion.subs(t, time): place})
    return expr


def mathml(left: Any, sign: str, right: Any) -> str:
    """Return a relation as a ``math`` element in block form."""
    sides = (_Printer().doprint(side) for side in (left, right))
    relation = f"<mo>{sign.replace('<', '&lt;')}</mo>".join(sides)
    return f'<math xmlns="http://www.w3.org/1998/Math/MathML" display="block"><mrow>{relation}</mrow></math>'


class _Printer(MathMLPresentationPrinter):  # type: ignore[misc]  # SymPy is untyped
    """SymPy's printer, with the order of terms, the dots and the powers of e that a person writes."""

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
        return sorted(terms, key=lambda t: (t.could_extract_minus_sign(), not t.has(_ACCELERATION), t.has(u)))

    def _print_Symbol(self, symbol: Any, style: str = "plain") -> Any:
        if symbol == u:
            bar = self._node("mo", "|")
            return self._node("mrow", bar, self._print(_V_R), self._node("mo", "|"))
        if symbol.name in _SPELLED:
            letter, dots = _SPELLED[symbol.name]
            accent = self._node("mo", dots)
            accent.setAttribute("stretchy", "false")
            base = self._node("mover", self._node("mi", letter), accent)
            base.setAttribute("accent", "true")
            return base
        return super()._print_Symbol(symbol, style)

    def _print_Dummy(self, symbol: Any) -> Any:
        return self._print_Symbol(symbol)

    def _print_Function(self, expr: Any) -> Any:
        if not isinstance(expr, sp.core.function.AppliedUndef):
            return super()._print_Function(expr)
        name = expr.func.__name__
        head = self._node("mi", "sgn") if name == "sgn" else super()._print_Symbol(sp.Symbol(name))
        arguments = [self._node("mo", "("), self._print(expr.args[0]), self._node("mo", ")")]
        return self._node("mrow", head, *arguments)

    def _print_Derivative(self, expr: Any) -> Any:
        above = self._node("mrow", self._node("mo", "∂"), self._node("mi", expr.expr.func.__name__))
        below = self._node("mrow", self._node("mo", "∂"), self._print(expr.variables[0]))
        return self._node("mfrac", above, below)

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
