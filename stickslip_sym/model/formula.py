"""The formula of a law, shared by all its copies: an expression, and what computes it.

That of a law of the catalogue is text until an expression is asked for, and has its functions of NumPy from
`compiled`: most numbers need no SymPy.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

from stickslip_sym.core.aliases import Expr, FloatArray
from stickslip_sym.model.coefficient import Coefficient
from stickslip_sym.model.expression.parameters import Parameter

__all__ = ["Formula", "Given", "Ready", "Written", "read_formula", "read_static"]

Compiled = Callable[..., FloatArray]


@dataclass(frozen=True)
class Ready:
    """mu and its slope as functions of an array of v and of the parameters in order; both are smooth for v > 0."""

    parameters: tuple[str, ...]
    mu: Compiled
    slope: Compiled


class Formula(Protocol):
    """A formula, and what computes it."""

    @property
    def expr(self) -> Expr: ...  # noqa: D102

    @property
    def coefficient(self) -> Coefficient: ...  # noqa: D102

    @property
    def ready(self) -> Ready | None: ...  # noqa: D102


@dataclass(frozen=True)
class Given:
    """A formula that is an expression."""

    expr: Expr
    coefficient: Coefficient
    ready: Ready | None = None


@dataclass(frozen=True)
class Written:
    """A formula that is text, with a description of each of its parameters, and ready functions."""

    text: str
    parameters: Sequence[Parameter]
    ready: Ready | None

    @cached_property
    def expr(self) -> Expr:
        """The formula as an expression."""
        return read_formula(self.text, {parameter.name: parameter for parameter in self.parameters})

    @cached_property
    def coefficient(self) -> Coefficient:
        """What computes it where the ready functions do not serve."""
        return Coefficient(self.expr, [parameter.symbol for parameter in self.parameters])


def read_formula(formula: str | Any, table: dict[str, Parameter], *, constant: bool = False) -> Expr:
    """Read a formula as `expression.reading` does, which is imported here: it holds much of SymPy."""
    from stickslip_sym.model.expression import reading

    return reading.read_formula(formula, table, constant=constant)


def read_static(static: Any, table: dict[str, Parameter]) -> Expr:
    """Read a static coefficient, as `expression.reading` does."""
    from stickslip_sym.model.expression import reading

    return reading.read_static(static, table)
