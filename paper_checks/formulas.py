"""The paper's equations by their numbers, as a reader of the paper sees them."""

from dataclasses import dataclass
from typing import Any

import sympy as sp
from sympy.printing.latex import LatexPrinter
from sympy.printing.precedence import PRECEDENCE

from derivations import paper
from stickslip_sym.core.symbols import N, V, a, b, c, k, m, mu, t, u
from stickslip_sym.views.markup import Markup
from stickslip_sym.views.pages.render import math_element

_VELOCITY, _ACCELERATION = sp.symbols("xdot xddot", real=True)
_X_P, _X_Q, _V_P, _V_Q, _F, _X, _S = sp.symbols("x_P x_Q V_P V_Q f x S", real=True)
_MU_S, _V_R, _CYCLE, _TO = sp.symbols("mu_s v_r T P→Q", real=True)
_SPELLED = {u: r"\left|v_{r}\right|", _VELOCITY: r"\dot{x}", _ACCELERATION: r"\ddot{x}", _TO: r"P \to Q"}


Relation = tuple[Any, str, Any]


@dataclass(frozen=True)
class PrintedEquation:
    """An equation of the paper; a text in a relation stands for an entry of `paper.equations`."""

    number: str  # as printed, with parentheses
    about: str
    claims: tuple[str, ...]  # the checks that decide about it
    relations: list[Relation]

    def mathml(self) -> Markup:
        """Return its relations as MathML, one element ``math`` each."""
        printer, printed = _Printer({"symbol_names": _SPELLED}), paper.equations()
        texts = []
        for left, sign, right in self.relations:
            sides = [_as_printed(printed[side]) if isinstance(side, str) else side for side in (left, right)]
            texts.append(math_element(f" {sign} ".join(map(printer.doprint, sides))))
        return Markup(" ".join(texts))


_WORK = sp.Integral((_F - c * _VELOCITY) * _VELOCITY, (t, _CYCLE, _CYCLE))
_MU = mu(_V_R)
_GRADIENT = [(sp.Derivative(sp.Function("S")(a, b), over), "=", sp.S.Zero) for over in (a, b)]
_SLIP = sp.Mul(-1, sp.Function("sgn")(_V_R), _MU, N, evaluate=False)
_LEFT = sp.Integral(_F - c * _VELOCITY - k * _X, (_X, _TO, _TO))

_EQUATIONS: list[tuple[str, tuple[str, ...], list[Relation]]] = [
    ("stick", ("E1",),
     [(_VELOCITY, "=", V), (_F, "=", c * _VELOCITY + k * _X), (sp.Abs(_F), r"\leq", _MU_S * N)]),
    ("slip", ("E2",), [(m * _ACCELERATION + c * _VELOCITY + k * _X, "=", _F), (_F, "=", _SLIP)]),
    ("exponential friction law", ("E3",), [(_MU, "=", "(3)")]),
    ("polynomial friction law", ("E4",), [(_MU, "=", "(4)")]),
    ("work and energy from P to Q", ("E5",), [(_LEFT, "=", "(5)")]),
    ("balance over a cycle, for stick–slip and pure slip", ("E5",), [(_WORK, "=", sp.S.Zero)]),
    ("balance over a cycle, for damped slip", ("E7",), [(_WORK, "<", sp.S.Zero)]),
    ("linear friction coefficient", ("E9",), [(sp.Function("mu_L")(_V_R), "=", "(8)")]),
    ("its force", ("E9",), [(_F, "=", "(9)")]),
    ("the balance (6) with it", ("E10",), [("(10)", "=", sp.S.Zero)]),
    ("pure slip", ("E11",), [(c, "=", "(11)")]),
    ("what the least squares minimise", ("E13",), [(_S, "=", "(12)")]),
    ("the same over the relative velocity", ("E13",), [(_S, "=", "(13)")]),
    ("conditions of the minimum", ("E15",), _GRADIENT),
    ("coefficients at the minimum", ("E15",), [(a, "=", "(15) a"), (b, "=", "(15) b")]),
    ("the criterion: pure-slip damping of any law", ("E16", "S1"), [(c, "=", "(16)")]),
    ("the criterion for the exponential law", ("E17", "F6"), [(c, "=", "(17)")]),
    ("the criterion for the polynomial law", ("E18", "F7"), [(c, "=", "(18)")]),
]  # fmt: skip
EQUATIONS = tuple(PrintedEquation(f"({number})", *one) for number, one in enumerate(_EQUATIONS, 1))


def _as_printed(expr: Any) -> Any:
    """Write x(t_P) as x_P, its derivative there as V_P, and x'(t) as x with a dot."""
    speed = sp.diff(paper.motion, t)
    cycle = {sp.Integral(speed**2, (t, paper.t_P, paper.t_Q)): sp.Integral(_VELOCITY**2, (t, _CYCLE, _CYCLE))}
    places = {paper.t_P: (_X_P, _V_P), paper.t_Q: (_X_Q, _V_Q)}
    expr = expr.xreplace(cycle)
    for time, (place, velocity) in places.items():
        expr = expr.xreplace({speed.subs(t, time): velocity}).xreplace({paper.motion.subs(t, time): place})
    return expr


class _Printer(LatexPrinter):
    """With positive terms first, and one mark below the integral of a cycle."""

    def _as_ordered_terms(self, expr: Any, order: str | None = None) -> list[Any]:
        terms = super()._as_ordered_terms(expr, order=order)
        return sorted(terms, key=lambda t: (t.could_extract_minus_sign(), not t.has(_ACCELERATION), t.has(u)))

    def _print_Integral(self, expr: Any) -> str:
        ((variable, low, high),) = expr.limits
        limits = f"_{{{self._print(low)}}}" + ("" if low == high else f"^{{{self._print(high)}}}")
        return rf"\int{limits} {self.parenthesize(expr.function, PRECEDENCE['Mul'])} \, d{self._print(variable)}"

    def _print_Derivative(self, expr: Any) -> str:
        return rf"\frac{{\partial {expr.expr.func.__name__}}}{{\partial {self._print(expr.variables[0])}}}"
