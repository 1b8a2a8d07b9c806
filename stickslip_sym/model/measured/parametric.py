"""A friction law as a function of its parameters: values and exact derivatives, compiled once for all fits."""

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any, Protocol, Self

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike, NDArray

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, Rational
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.core.numbers import Number
from stickslip_sym.model.expression.parameters import Parameter

__all__ = ["FittedLaw", "Parametric"]

FloatArray = NDArray[np.float64]

_AT_REST = 1e-200  # m/s, in place of 0, where a power of v has no derivative with respect to its exponent


class FittedLaw(Protocol):
    """What a fit needs of a friction law."""

    name: str | None

    @property
    def expr(self) -> Expr:
        """The coefficient as an expression."""

    @property
    def parameters(self) -> Mapping[str, Parameter]:
        """The law's parameters by name."""

    @property
    def values(self) -> Mapping[str, Rational]:
        """The bound values by name, exact."""

    @property
    def text(self) -> str:
        """The formula as plain text."""

    def bind(self, **values: Number) -> Self:
        """Return the law with values for some or all of its parameters."""

    def at_speeds(self, speeds: FloatArray) -> FloatArray:
        """Return mu at an array of slip speeds."""


class Parametric:
    """mu(v; p) of a law at given speeds, where p are the parameters without a value.

    Parameters
    ----------
    law : FittedLaw
    v : ndarray
        In m/s; 0 stands for the limit 0+.

    Attributes
    ----------
    names : tuple of str
        The free parameters.
    positive : ndarray of bool
        Whether each of them is never negative.
    linear : ndarray of bool
        Whether mu is linear in each, jointly with the others that are marked.
    """

    def __init__(self, law: FittedLaw, v: FloatArray) -> None:
        names = tuple(name for name, p in law.parameters.items() if p.symbol in law.expr.free_symbols)
        self._compiled = _compiled(law.expr, tuple(law.parameters[name].symbol for name in names))
        self._fixed = np.array([float(law.values.get(name, 0)) for name in names])
        self._free = np.array([name not in law.values for name in names], dtype=bool)
        self._v = np.maximum(v, _AT_REST)
        self.names = tuple(name for name in names if name not in law.values)
        self.positive = np.array([law.parameters[name].positive for name in self.names], dtype=bool)
        self.linear = self._compiled.linear[self._free]

    def mu(self, p: FloatArray) -> FloatArray:
        """Return the coefficients at the speeds, of shape (n,); not finite where there is none."""
        with np.errstate(all="ignore"):
            return self._real(self._compiled.value(self._v, *self._all(p)))

    def jacobian(self, p: FloatArray) -> FloatArray:
        """Return the derivatives of mu to the free parameters, of shape (n, len(names))."""
        with np.errstate(all="ignore"):
            columns = self._compiled.derivatives(self._v, *self._all(p))
        chosen = [column for column, free in zip(columns, self._free, strict=True) if free]
        return np.stack([self._real(column) for column in chosen], axis=1)

    def _all(self, p: FloatArray) -> FloatArray:
        values = self._fixed.copy()
        values[self._free] = p
        return values

    def _real(self, value: ArrayLike) -> FloatArray:
        array = np.asarray(value)
        if np.iscomplexobj(array):
            array = np.where(array.imag == 0, array.real, np.nan)
        return np.broadcast_to(array, self._v.shape).astype(np.float64)


class _Compiled:
    """A formula and its derivatives to its parameters as functions of arrays."""

    def __init__(self, expr: Expr, parameters: tuple[Expr, ...]) -> None:
        arguments = [symbols.v, *parameters]
        derivatives = [sp.diff(expr, parameter) for parameter in parameters]
        self.value: Callable[..., Any] = function_of(arguments, expr, "numpy")
        self.derivatives: Callable[..., Any] = function_of(arguments, derivatives, "numpy")
        linear: list[Expr] = []
        for parameter, derivative in zip(parameters, derivatives, strict=True):
            if not derivative.has(parameter, *linear):
                linear.append(parameter)
        self.linear = np.array([parameter in linear for parameter in parameters], dtype=bool)


@lru_cache(maxsize=128)
def _compiled(expr: Expr, parameters: tuple[Expr, ...]) -> _Compiled:
    return _Compiled(expr, parameters)
