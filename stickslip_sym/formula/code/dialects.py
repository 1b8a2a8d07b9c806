"""How C, Python and Octave write the same formulas."""

import builtins
import keyword
import re
from collections.abc import Mapping
from typing import Any, ClassVar

import sympy as sp
from sympy.codegen.cfunctions import expm1, log1p
from sympy.functions.elementary.piecewise import ExprCondPair
from sympy.logic.boolalg import BooleanTrue
from sympy.printing.c import C99CodePrinter
from sympy.printing.numpy import NumPyPrinter

from stickslip_sym.core.errors import NoClosedForm

__all__ = ["Dialect", "c99", "numeric_list", "octave", "python"]

_C_WORDS = frozenset(
    {
        "auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else", "enum",
        "extern", "float", "for", "goto", "if", "inline", "int", "long", "main", "register", "restrict",
        "return", "short", "signed", "sizeof", "static", "struct", "switch", "typedef", "union",
        "unsigned", "void", "volatile", "while",
        "alignas", "alignof", "asm", "bool", "constexpr", "false", "nullptr", "static_assert", "thread_local",
        "true", "typeof", "typeof_unqual",
        "HUGE_VAL", "HUGE_VALF", "HUGE_VALL", "INFINITY", "MATH_ERREXCEPT", "MATH_ERRNO", "NAN", "linux",
        "math_errhandling", "unix",
        "asin", "exp2", "fabs", "floor", "fmax", "fmin", "fmod", "frexp", "ldexp", "pow",
    }
)  # fmt: skip
_OCTAVE_WORDS = frozenset(
    {
        "break", "case", "catch", "classdef", "continue", "do", "else", "elseif", "end", "end_try_catch",
        "end_unwind_protect", "endarguments", "endclassdef", "endenumeration", "endevents", "endfor",
        "endfunction", "endif", "endmethods", "endparfor", "endproperties", "endspmd", "endswitch", "endwhile",
        "for", "function", "global", "if", "otherwise", "parfor", "persistent", "return", "spmd", "switch",
        "try", "unwind_protect", "unwind_protect_cleanup", "until", "while",
        "abs", "arrayfun", "asin", "common_size", "differ", "error", "expm1", "fix", "floor", "half",
        "isempty", "kept", "largest", "log1p", "log2", "max", "merge", "min", "mod", "numel",
        "rows", "sort", "true",
    }
)  # fmt: skip


_LOCALS = frozenset(
    {
        "a", "added", "angle", "b", "base", "cancelled", "carry", "coarse", "columns", "count", "ends",
        "exponent", "factors", "fine", "first", "g", "half_pi", "halvings", "height", "here", "i", "j",
        "left", "m", "mantissa", "math", "np", "off", "panels", "part", "parts", "place", "power", "r", "ratio",
        "rest", "result", "right", "row", "scale", "scales", "shape", "shift", "sine", "size", "sum", "swap", "t",
        "total", "try_", "upper", "v", "value", "w", "whole", "x", "z",
    }
)  # fmt: skip
"""Names that the functions inside the text use for themselves."""


_WRITTEN = (
    sp.Add, sp.Mul, sp.Pow, sp.Rational, sp.Float, sp.NumberSymbol, sp.Symbol, sp.Max, sp.Min, sp.Abs, sp.sign,
    sp.Piecewise, ExprCondPair, sp.StrictLessThan, sp.StrictGreaterThan, BooleanTrue,
    sp.exp, sp.log, sp.sin, sp.cos, sp.tan, sp.asin, sp.acos, sp.atan, sp.sinh, sp.cosh, sp.tanh, sp.sech, sp.coth,
    sp.asinh, sp.acosh, sp.atanh, sp.erf, expm1, log1p,
)  # fmt: skip
"""What every language here can compute; SymPy's printers would write other functions as if they existed."""


class _Reciprocal:
    """Functions that are one over another one; SymPy would rewrite all that stands in their argument too."""

    def _print_sech(self, expr: Any) -> str:
        return f"(1.0/{self._print(sp.cosh(expr.args[0], evaluate=False))})"  # type: ignore[attr-defined]  # a printer's

    def _print_coth(self, expr: Any) -> str:
        return f"(1.0/{self._print(sp.tanh(expr.args[0], evaluate=False))})"  # type: ignore[attr-defined]  # a printer's


class _C(_Reciprocal, C99CodePrinter):  # type: ignore[misc]  # SymPy is untyped
    math_macros: ClassVar[dict[Any, str]] = {}  # M_SQRT2 and the like are neither C99's nor Octave's

    def _print_Float(self, expr: Any) -> str:
        return repr(float(expr))

    def _print_Rational(self, expr: Any) -> str:
        return f"({float(expr)!r})"

    def _print_NumberSymbol(self, expr: Any) -> str:
        return repr(float(expr))

    def _print_Symbol(self, expr: Any) -> str:
        return str(expr.name)  # `Dialect.name` has seen to the words of the language, which C's are not in Octave


class _Octave(_C):
    """One number at a time, so Octave's operators are those of C but for powers and choices."""

    def _print_Pow(self, expr: Any) -> str:
        base, exponent = (self._print(part) for part in expr.args)
        if expr.exp == sp.Rational(1, 2):
            return f"sqrt({base})"
        return f"1.0/({base})" if expr.exp == -1 else f"(({base})^({exponent}))"

    def _print_Max(self, expr: Any) -> str:
        return self._nested("max", expr)

    def _print_Min(self, expr: Any) -> str:
        return self._nested("min", expr)

    def _nested(self, name: str, expr: Any) -> str:
        first, *others = (self._print(argument) for argument in expr.args)
        for other in others:
            first = f"{name}({first}, {other})"
        return str(first)

    def _print_Abs(self, expr: Any) -> str:
        return f"abs({self._print(expr.args[0])})"

    def _print_Piecewise(self, expr: Any) -> str:
        *branches, (last, _) = expr.args
        text = self._print(last)
        for branch, condition in reversed(branches):
            text = f"merge({self._print(condition)}, {self._print(branch)}, {text})"
        return str(text)


class _Python(_Reciprocal, NumPyPrinter):  # type: ignore[misc]  # SymPy is untyped
    def _print_erf(self, expr: Any) -> str:
        return f"_erf({self._print(expr.args[0])})"

    def _print_NumberSymbol(self, expr: Any) -> str:
        return repr(float(expr))

    def _print_Exp1(self, expr: Any) -> str:
        return self._print_NumberSymbol(expr)

    def _print_Pi(self, expr: Any) -> str:
        return self._print_NumberSymbol(expr)

    def _print_Max(self, expr: Any) -> str:
        return self._nested("maximum", expr)

    def _print_Min(self, expr: Any) -> str:
        return self._nested("minimum", expr)

    def _nested(self, name: str, expr: Any) -> str:
        first, *others = (self._print(argument) for argument in expr.args)
        for other in others:
            first = f"numpy.{name}({first}, {other})"
        return str(first)

    def doprint(self, expr: Any, assign_to: Any = None) -> str:
        return str(super().doprint(expr, assign_to)).replace("numpy.", "np.")


class Dialect:
    """One language: how it prints an expression, and which names it keeps for itself."""

    def __init__(self, printer: Any, words: frozenset[str], kept: str = "(?!)") -> None:
        self._printer, self._words, self._kept = printer, words, re.compile(kept)

    def name(self, symbol: Any) -> str:
        """Return the name of an argument, with an underscore after a word of the language, or after another."""
        text = str(symbol)
        return f"{text}_" if text in self._words or text.endswith("_") or self._kept.fullmatch(text) else text

    def text(self, expr: Any, names: Mapping[Any, str]) -> str:
        """Return an expression in this language.

        Raises
        ------
        NoClosedForm
            For a function that not every language here has.
        """
        for node in sp.preorder_traversal(sp.sympify(expr)):
            if not isinstance(node, _WRITTEN):
                raise NoClosedForm(
                    f"{str(node)[:60]} cannot be written as code: C, Python and Octave do not all have "
                    f"{type(node).__name__}; what needs no such function, like the slope of a law, can be written"
                )
        renamed = {symbol: sp.Symbol(name, positive=True) for symbol, name in names.items()}
        return str(self._printer.doprint(sp.sympify(expr).xreplace(renamed)))


def numeric_list(values: Any, brackets: str, indent: str = "    ") -> str:
    """Return numbers as the text of a list, a few on each line, exact when read back."""
    numbers = [repr(float(value)) for value in values]
    lines = [", ".join(numbers[i : i + 4]) for i in range(0, len(numbers), 4)]
    return brackets[0] + f",\n{indent}".join(lines) + brackets[1]


c99 = Dialect(_C(), _C_WORDS | _LOCALS, "(M|FP)_[A-Z0-9_]+")  # M_PI and the like are macros
octave = Dialect(_Octave(), _OCTAVE_WORDS | _LOCALS)
python = Dialect(
    _Python({"fully_qualified_modules": True, "allow_unknown_functions": True}),
    frozenset(keyword.kwlist) | frozenset(dir(builtins)) | _LOCALS,
)
