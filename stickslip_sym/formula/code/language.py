"""What a language supplies so that criteria are written in it: a printer of expressions and a page of text."""

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import reduce
from typing import ClassVar

from sympy.printing.printer import Printer

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.functions import row
from stickslip_sym.formula.evaluation.branches import Branch, Sum, Table

__all__ = ["Language", "WrittenFunction", "WrittenTerm"]


class _Printer(Printer):  # type: ignore[misc]  # SymPy is untyped
    """Expressions as a language writes them, with the names of the table of functions."""

    def __init__(self, language: "Language", names: Mapping[Expr, str]) -> None:
        super().__init__()
        self._language, self._names = language, names

    def _print_Symbol(self, expr: Expr) -> str:
        return self._names[expr]

    def _print_Number(self, expr: Expr) -> str:
        return self._language.number(float(expr))

    _print_NumberSymbol = _print_Number  # noqa: N815  # as SymPy calls it

    def _print_Add(self, expr: Expr) -> str:
        return " + ".join(self._print(term) for term in expr.args)

    def _print_Mul(self, expr: Expr) -> str:
        return "*".join(self._in_brackets(factor) for factor in expr.args)

    def _print_Pow(self, expr: Expr) -> str:
        if expr.exp == -1:
            return f"(1.0/{self._in_brackets(expr.base)})"
        return self._language.power(self._print(expr.base), self._print(expr.exp))

    def _print_Max(self, expr: Expr) -> str:
        return self._of_pairs(self._language.extremes[0], expr)

    def _print_Min(self, expr: Expr) -> str:
        return self._of_pairs(self._language.extremes[1], expr)

    def _of_pairs(self, function: str, expr: Expr) -> str:
        texts: list[str] = [self._print(argument) for argument in expr.args]
        return reduce(lambda left, right: f"{function}({left}, {right})", texts)

    def _in_brackets(self, expr: Expr) -> str:
        text = self._print(expr)
        return f"({text})" if expr.is_Add or expr.is_Mul else str(text)

    def emptyPrinter(self, expr: Expr) -> str:  # as SymPy calls it
        """Print a function by its row of the table."""
        known = row(expr)
        text = None if known is None else known.call(self._language.name, *[self._print(a) for a in expr.args])
        if text is None:
            raise InputError(
                f"{str(expr)[:60]} cannot be written as code: {self._language.name} has no {type(expr).__name__}"
            )
        return text


@dataclass(frozen=True)
class WrittenTerm:
    """A term of a law in numbers and texts: number * prod bases^amplitude * F(prod bases^ratio)."""

    number: float
    bases: tuple[str, ...]
    amplitude: tuple[float, ...]
    ratio: tuple[float, ...]
    starts: tuple[float, ...]
    branches: tuple[Branch, ...]


@dataclass(frozen=True)
class WrittenFunction:
    """A criterion: its name, arguments as the user knows them with what each may be, terms, and the largest V."""

    name: str
    arguments: tuple[str, ...]
    nonnegative: tuple[bool, ...]
    terms: tuple[WrittenTerm, ...]
    largest_speed: float
    about: str


class Language(ABC):
    """A language.

    Attributes
    ----------
    name : str
        Also that of its column in the table of functions.
    words : frozenset of str
        Names that an argument cannot have.
    argument : str
        An argument inside a function, with {index}.
    statement : str
        The definition of a local number, with {name} and {value}.
    """

    name: ClassVar[str]
    words: ClassVar[frozenset[str]]
    argument: ClassVar[str]
    statement: ClassVar[str]
    nan: ClassVar[str]
    extremes: ClassVar[tuple[str, str]]  # of two numbers: the larger one, the smaller one
    first: ClassVar[int] = 0  # index of an array's first element

    @abstractmethod
    def head(self, title: str, body: str) -> str:
        """Return what stands before a body: comments, and the functions that it shares."""

    @abstractmethod
    def table(self, name: str, table: Table) -> str:
        """Return the definitions of a table's arrays."""

    @abstractmethod
    def lookup(self, name: str, table: Table) -> str:
        """Return the expression for G by a table that was defined."""

    @abstractmethod
    def term(self, name: str, term: WrittenTerm, bodies: list[list[str]]) -> str:
        """Return the function of one term; a body leaves G in `g` and the power of r in `power`."""

    @abstractmethod
    def function(self, function: WrittenFunction, terms: list[str]) -> str:
        """Return the function itself: the sum of some terms, NaN where a call refuses."""

    def arranged(self, function: str, parts: list[str]) -> str:
        """Return the tables and terms of a function, and the function itself, in the order that is needed."""
        return "".join(parts) + function

    def together(self, functions: list[WrittenFunction], texts: list[str]) -> str:
        """Return the text of some functions."""
        return "\n".join(texts)

    def power(self, base: str, exponent: str) -> str:
        """Return a power."""
        return f"pow({base}, {exponent})"

    def number(self, value: float) -> str:
        """Return a number, exact when it is read back."""
        return self.nan if math.isnan(value) else repr(float(value))

    def numbers(self, values: Iterable[float], indent: str = "    ") -> str:
        """Return numbers with commas, a few on each line."""
        texts = [self.number(value) for value in values]
        return f",\n{indent}".join(", ".join(texts[i : i + 4]) for i in range(0, len(texts), 4))

    def text(self, expr: Expr, names: Mapping[Expr, str]) -> str:
        """Return an expression.

        Raises
        ------
        InputError
            For a function that the language has not.
        """
        return str(_Printer(self, names).doprint(expr))

    def argument_name(self, name: str) -> str:
        """Return an argument's name, with one more underscore after a word of the language."""
        return f"{name}_" if name.rstrip("_") in self.words else re.sub("^_+", "x_", name)

    def body(self, branch: Branch, table: str, r: Expr) -> list[str]:
        """Return the statements that compute g and the power."""

        def let(name: str, value: str) -> str:
            return self.statement.format(name=name, value=value)

        if isinstance(branch, Table):
            return [let("g", self.lookup(table, branch)), let("power", "0.0")]
        values = {"g": self._sum(branch, r), "power": self.number(branch.power)}
        if any(len(coefficients) > 1 for _, coefficients in branch.parts):
            values = {"z": self._variable(branch), **values}
        return [let(name, value) for name, value in values.items()]

    def _variable(self, branch: Sum) -> str:
        q = branch.variable
        plain = {1.0: "r", 2.0: "r*r", -1.0: "1.0/r", -2.0: "1.0/(r*r)"}
        return plain.get(q) or self.power("r", self.number(q))

    def _sum(self, branch: Sum, r: Expr) -> str:
        parts = []
        for function, coefficients in branch.parts:
            polynomial = self._horner(coefficients)
            factor = "" if function is None else f"*({self.text(function, {r: 'r'})})"
            parts.append(f"({polynomial}){factor}")
        return " + ".join(parts)

    def _horner(self, coefficients: tuple[float, ...]) -> str:
        *rest, last = (self.number(c) for c in coefficients)
        text = f"{last}*z" if rest else f"{last} + 0.0*r"
        for i, coefficient in enumerate(reversed(rest)):
            text = f"{coefficient} + {text}" if i == len(rest) - 1 else f"({coefficient} + {text})*z"
        return text
