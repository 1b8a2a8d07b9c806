"""A law as text of python-flint, for scripts that prove something of it without this package.

What is written takes balls and power series alike. `in_flint.txt` has the functions that a law may call.
"""

import re
from collections.abc import Iterable, Mapping, Sequence, Set
from functools import cached_property
from pathlib import Path

import sympy as sp
from sympy.printing.str import StrPrinter

from stickslip_sym.certificates.python_printer import WIDTH
from stickslip_sym.certificates.script import SafeNames
from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.balls import number_at
from stickslip_sym.core.errors import InputError
from stickslip_sym.model.bound import BoundLaw
from stickslip_sym.model.expression.pieces import places
from stickslip_sym.output.sections import sections

_VARIABLES = {symbols.v: "v", symbols.s: "s"}
_METHODS = {"exp", "sin", "cos", "tan", "erf"}  # of balls, and of power series


_RULES = sections(Path(__file__).with_suffix(".txt"))
FUNCTIONS = "\n\n\n".join(map(str.strip, _RULES.values())) + "\n\n"
"""The functions that a law may call, as text; they take balls and power series."""


class LawInFlint:
    """A law for a script none of whose names is taken."""

    def __init__(self, law: BoundLaw, script: str) -> None:
        self._law = law
        names = SafeNames(f"{script} {FUNCTIONS}")
        self._names = {symbol: names.new(symbol.name) for symbol, _ in law.values}
        self._printer = _Flint(self._names, _METHODS)
        self.starts = [start for start, _ in law.segments]

    @property
    def parameters(self) -> str:
        """The law's parameters, exact, by their names."""
        items = [f'"{self._names[symbol]}": {flint_rational(value)}' for symbol, value in self._law.values]
        line = f"{{{', '.join(items)}}}"
        if len(line) <= WIDTH - 20:
            return line
        return "\n    ".join(["{", *(f"{item}," for item in items)]) + "\n}"

    @property
    def pieces(self) -> list[Expr]:
        """The smooth pieces of mu."""
        return [formula for _, formula in self._law.segments]

    def functions_of_v(self, name: str, about: str, exprs: Iterable[Expr]) -> str:
        """Return a list of expressions of v as texts; formulas that fit no line stand as they are."""
        lines = "\n".join([f"{name} = [  # {about}", *map(self._function, exprs), "]"]).split("\n")
        if all(len(line) <= WIDTH for line in lines):
            return "\n".join(lines)
        long = [f"{line}  # noqa: E501" if len(line) > WIDTH else line for line in lines]
        return "\n".join(["# fmt: off", *long, "# fmt: on"])

    @cached_property
    def ends(self) -> list[str]:
        """The speeds where the pieces end: the kinks, and the end of what was measured."""
        law = self._law
        point = self._law.point
        written = {number_at(place, point): place for place in places(law.expr)}
        ends = [kink if kink.is_Rational else written[kink] for kink in law.exact_kinks]
        return [self.text(end) for end in [*ends, *([] if law.end is None else [law.end])]]

    def text(self, expr: Expr) -> str:
        """Return an expression of v and the parameters."""
        return self._printer.doprint(expr)

    def _function(self, expr: Expr) -> str:
        """Return a line of a list: an expression of v as text.

        Raises `InputError` for a function that has no rule.
        """
        text = self.text(expr)
        if unknown := sorted(self._printer.used - set(_RULES)):
            raise InputError(
                f"the law has {', '.join(unknown)}, for which a certificate has no rule in python-flint; "
                "what it would prove stands in the result itself, with words: print it"
            )
        return f'    "{text}",'


def flint_rational(value: Expr) -> str:
    """Return an exact rational."""
    if value.is_Integer:
        return f"fmpq({value})"
    return f"fmpq({value.p}, {value.q})"


def flint_number(value: Expr) -> str:
    """Return an exact rational as a ball."""
    if value.is_Integer:
        return f"arb({value})"
    return f"arb(fmpq({value.p}, {value.q}))"


def listed(items: Sequence[str], width: int = WIDTH) -> str:
    """Return a list, on one line where that is short enough."""
    line = f"[{', '.join(items)}]"
    if len(line) <= width:
        return line
    return "\n    ".join(["[", *(f"{item}," for item in items)]) + "\n]"


class _Flint(StrPrinter):
    """Expressions of balls; `used` are the functions of the page that they call."""

    def __init__(self, names: Mapping[Expr, str], methods: Set[str]) -> None:
        super().__init__()
        self.names = names
        self.methods = methods
        self.used = set[str]()

    def doprint(self, expr: Expr) -> str:
        """Return an expression with its operators parted by blanks."""
        return re.sub(r" ?([*/]) ?", r" \1 ", super().doprint(expr))

    def _print_Symbol(self, expr: Expr) -> str:
        return _VARIABLES.get(expr) or self.names[expr]

    _print_Dummy = _print_Symbol

    def _print_Rational(self, expr: Expr) -> str:
        return f"fmpq({expr.p}, {expr.q})"

    def _print_Pi(self, expr: Expr) -> str:
        del expr
        return "arb.pi()"

    def _print_Exp1(self, expr: Expr) -> str:
        del expr
        return "arb(1).exp()"

    def _print_Function(self, expr: Expr) -> str:
        arguments = [flint_number(part) if part.is_Rational else self.doprint(part) for part in expr.args]
        if (name := type(expr).__name__) in self.methods:
            return f"{arguments[0] if expr.args[0].is_Atom else f'({arguments[0]})'}.{name}()"
        return self._call(name, *arguments)

    def _print_Pow(self, expr: Expr, rational: bool = False) -> str:
        del rational
        exponent = expr.exp
        if expr.base is sp.E:
            return self._print_Function(sp.Function("exp")(exponent))
        if exponent == -1:
            return f"1/({self.doprint(expr.base)})"
        base = flint_number(expr.base) if expr.base.is_Rational else self.doprint(expr.base)
        if expr.base.is_Symbol and exponent == 2:
            return f"({base} * {base})"
        return self._call("whole" if exponent.is_Integer else "power", base, self.doprint(exponent))

    def _print_NumberPower(self, expr: Expr) -> str:
        return self._call("power", flint_number(expr.args[0]), self.doprint(expr.args[1]))

    def _call(self, name: str, *arguments: str) -> str:
        self.used.add(name)
        return f"{name}({', '.join(arguments)})"
