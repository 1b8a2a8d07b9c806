"""The paper's equations by their numbers, as a reader of the paper sees them."""

from dataclasses import dataclass
from typing import Any

import sympy as sp
from sympy.printing.latex import LatexPrinter
from sympy.printing.precedence import PRECEDENCE

from derivations import paper
from stickslip_sym.core.symbols import N, V, a, b, c, k, m, mu, t, u
from stickslip_sym.output.markup import Markup
from stickslip_sym.output.page.render import formula

__all__ = ["EQUATIONS", "PrintedEquation"]

_VELOCITY, _ACCELERATION = sp.symbols("xdot xddot", real=True)
_X_P, _X_Q, _V_P, _V_Q, _F, _X, _S = sp.symbols("x_P x_Q V_P V_Q f x S", real=True)
_MU_S, _V_R, _CYCLE, _TO = sp.symbols("mu_s v_r T P→Q", real=True)
_SPELLED = {u: r"\left|v_{r}\right|", _VELOCITY: r"\dot{x}", _ACCELERATION: r"\ddot{x}", _TO: r"P \to Q"}


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

    def mathml(self) -> Markup:
        """Return its relations as MathML, one element ``math`` each."""
        printer = _Printer({"symbol_names": _SPELLED})
        sides = [
            (printer.doprint(left), sign, printer.doprint(right)) for left, sign, right in _relations(self.number)
        ]
        return Markup(" ".join(formula(" ".join(relation)) for relation in sides))


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
        "(1)": [(_VELOCITY, "=", V), (_F, "=", c * _VELOCITY + k * _X), (sp.Abs(_F), r"\leq", _MU_S * N)],
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


class _Printer(LatexPrinter):  # type: ignore[misc]  # SymPy is untyped
    """With positive terms first, and one mark below the integral of a cycle."""

    def _as_ordered_terms(self, expr: Any, order: str | None = None) -> list[Any]:
        terms: list[Any] = super()._as_ordered_terms(expr, order=order)
        return sorted(terms, key=lambda t: (t.could_extract_minus_sign(), not t.has(_ACCELERATION), t.has(u)))

    def _print_Integral(self, expr: Any) -> str:
        ((variable, low, high),) = expr.limits
        limits = f"_{{{self._print(low)}}}" + ("" if low == high else f"^{{{self._print(high)}}}")
        return rf"\int{limits} {self.parenthesize(expr.function, PRECEDENCE['Mul'])} \, d{self._print(variable)}"

    def _print_Derivative(self, expr: Any) -> str:
        return rf"\frac{{\partial {expr.expr.func.__name__}}}{{\partial {self._print(expr.variables[0])}}}"
