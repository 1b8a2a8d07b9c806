"""Expressions of SymPy as text of Coq's real numbers."""

import re
from collections.abc import Mapping

import sympy as sp
from sympy.printing.printer import Printer

from stickslip_sym.core.aliases import Condition, Expr
from stickslip_sym.core.errors import InputError

_WORDS = """at by as in on fun end let fix if then else match with for forall exists exists2 where using return mod
Prop Set Type SProp cofix Axiom Variable Theorem Definition"""
"""Words that Coq reads as its own, and not as a name."""

NAMED = {"log": "ln", "asinh": "arcsinh", "Min": "Rmin", "Max": "Rmax"}
"""What Coq calls functions that SymPy has by another name."""

ELEMENTARY = ("exp", "log", "sin", "cos", "atan", "asinh", "sinh", "cosh", "tanh", "erf")
"""Functions of one variable of a law that Coq has by one name, or that a script defines."""

MADE = (
    "sqrt",
    "Rpower",
    "power",
    "lower_gamma",
    "polylog1",
    "polylog2",
    "polylog3",
    "polylog4",
    "Ti2",
    "Ti3",
    "Ti4",
)
"""Functions that an expression is written in for a script."""


class Unsupported(InputError):
    """A construct that the scripts in Coq do not have."""


class Names:
    """Names for the letters of a law in a script: none is a word of Coq or of the script."""

    def __init__(self, script: str) -> None:
        self._taken = {*_WORDS.split(), *re.findall(r"[A-Za-z_]\w*", script)}

    def new(self, name: str) -> str:
        """Return a name like another that is not taken yet."""
        candidate = name
        while candidate in self._taken or re.fullmatch(r"[A-Za-z]\d[\d_]*", candidate):
            candidate += "_"
        self._taken.add(candidate)
        return candidate


class CoqPrinter(Printer):
    """Print an expression in the notation of Coq's real numbers; `names` are those of its symbols."""

    printmethod = "_coq"

    def __init__(self, names: Mapping[Expr, str]) -> None:
        super().__init__()
        self.names = names

    def whole(self, expr: Expr) -> str:
        """Return an expression as the argument of a function: in parentheses unless it is one word."""
        text = self._print(expr)
        return text if re.fullmatch(r"\w+", text) else f"({text})"

    def head(self, expr: Expr) -> str:
        """Return a function as it stands before its last argument."""
        name = expr.func.__name__
        return " ".join([NAMED.get(name, name), *map(self.whole, expr.args[:-1])])

    def emptyPrinter(self, expr: Expr) -> str:
        """Refuse what has no text in Coq."""
        raise Unsupported(f"a script in Coq has no {type(expr).__name__}, which stands in {str(expr)[:60]}")

    # -- letters, numbers and functions --------------------------------------------------------------

    def _print_Symbol(self, expr: Expr) -> str:
        return self.names[expr]

    _print_Dummy = _print_Symbol

    def _print_Integer(self, expr: Expr) -> str:
        if expr >= 0:
            return str(expr)
        return f"- {-expr}"

    def _print_Rational(self, expr: Expr) -> str:
        if expr.p < 0:
            return f"- {-expr.p} / {expr.q}"
        return f"{expr.p} / {expr.q}"

    def _print_Pi(self, expr: Expr) -> str:
        return "PI"

    def _print_Exp1(self, expr: Expr) -> str:
        return "exp 1"

    def _print_Function(self, expr: Expr) -> str:
        name = expr.func.__name__
        if name not in (*ELEMENTARY, *MADE):
            return self.emptyPrinter(expr)
        return f"{self.head(expr)} {self.whole(expr.args[-1])}"

    def _print_sech(self, expr: Expr) -> str:
        return f"/ cosh {self.whole(expr.args[0])}"

    def _print_csch(self, expr: Expr) -> str:
        return f"/ sinh {self.whole(expr.args[0])}"

    def _print_coth(self, expr: Expr) -> str:
        return f"cosh {self.whole(expr.args[0])} / sinh {self.whole(expr.args[0])}"

    def _print_Min(self, expr: Expr) -> str:
        return self._nested("Rmin", *sp.ordered(expr.args))

    def _print_Max(self, expr: Expr) -> str:
        return self._nested("Rmax", *sp.ordered(expr.args))

    def _nested(self, name: str, first: Expr, *rest: Expr) -> str:
        if len(rest) == 1:
            others = self.whole(rest[0])
        else:
            others = f"({self._nested(name, *rest)})"
        return f"{name} {self.whole(first)} {others}"

    # -- sums, products and powers -------------------------------------------------------------------

    def _print_Add(self, expr: Expr) -> str:
        terms = sorted(expr.as_ordered_terms(), key=lambda term: bool(term.could_extract_minus_sign()))
        text = self._print(terms[0])
        for term in terms[1:]:
            negative = term.could_extract_minus_sign()
            text += f" {'-' if negative else '+'} {self._operand(-term if negative else term)}"
        return text

    def _operand(self, expr: Expr) -> str:
        text = self._print(expr)
        is_closed = not expr.is_Add and not text.startswith(("-", "/", "if "))
        return text if is_closed else f"({text})"

    def _print_Mul(self, expr: Expr) -> str:
        if expr.could_extract_minus_sign():
            return f"- {self._operand(-expr)}"
        above = list[str]()
        below = list[str]()
        for factor in expr.as_ordered_factors():
            if factor.is_Rational:
                if factor.p != 1:
                    above += [str(factor.p)]
                if factor.q != 1:
                    below += [str(factor.q)]
            elif isinstance(factor, sp.sech | sp.csch):
                below.append(self._print(factor).removeprefix("/ "))
            elif factor.is_Pow and factor.exp.is_Integer and factor.exp < 0:
                below.append(self._operand(factor.base**-factor.exp))
            else:
                above.append(self._operand(factor))
        over = " * ".join(above) or "1"
        if len(below) == 1:
            under = below[0]
        else:
            under = f"({' * '.join(below)})"
        if below:
            return f"{over} / {under}"
        return over

    def _print_Pow(self, expr: Expr) -> str:
        base, exponent = expr.args
        if not exponent.is_Integer:
            return self.emptyPrinter(expr)
        if exponent < 0:
            return f"/ {self._operand(base**-exponent)}"
        return f"{self.whole(base)}^{exponent!s}"

    # -- functions in pieces -------------------------------------------------------------------------

    def _print_Piecewise(self, expr: sp.Piecewise) -> str:
        (value, holds), *others = expr.args
        if holds == sp.true:
            return self._print(value)
        rest = self._print(expr.func(*others))
        return f"if {self._condition(holds)} then {self._print(value)} else {rest}"

    def _condition(self, holds: Condition) -> str:
        tests = {
            sp.StrictLessThan: "Rlt_dec",
            sp.StrictGreaterThan: "Rlt_dec",
            sp.LessThan: "Rle_dec",
            sp.GreaterThan: "Rle_dec",
        }
        if not isinstance(holds, sp.core.relational.Relational) or type(holds) not in tests:
            raise Unsupported(f"a script in Coq has no condition {holds}")
        return f"{tests[type(holds)]} {self.whole(holds.lts)} {self.whole(holds.gts)}"
