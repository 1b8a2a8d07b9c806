"""Functions of v with parameters, each compiled once for all values of the parameters."""

from collections.abc import Callable, Sequence
from typing import Any

import mpmath

from stickslip_sym import symbols
from stickslip_sym.codegen import Backend, function_of
from stickslip_sym.values import to_mpf

__all__ = ["Compiled"]


class Compiled:
    """Compiled functions of v and of the same parameters.

    Parameters
    ----------
    parameters : sequence of sympy.Symbol
    """

    def __init__(self, parameters: Sequence[Any]) -> None:
        self._parameters = tuple(parameters)
        self._functions: dict[tuple[Any, Backend], Callable[..., Any]] = {}

    def __reduce__(self) -> tuple[Any, ...]:
        # Compiled functions cannot be pickled, and are made again when they are needed.
        return Compiled, (self._parameters,)

    def at(self, expr: Any, values: Sequence[Any], backend: Backend) -> Callable[[Any], Any]:
        """Return an expression as a bare function of v, at exact values of the parameters."""
        key = expr, backend
        if key not in self._functions:
            # Values go in as arguments, not into the expression: SymPy would factor powers of fractions.
            self._functions[key] = function_of([symbols.v, *self._parameters], expr, backend)
        compiled = self._functions[key]
        if backend == "mpmath":
            rounded: dict[int, list[Any]] = {}

            def at_precision(v: Any) -> Any:
                precision = mpmath.mp.prec
                if precision not in rounded:
                    rounded[precision] = [to_mpf(value) for value in values]
                return compiled(v, *rounded[precision])

            return at_precision
        floats = [float(value) for value in values]
        return lambda v: compiled(v, *floats)
