"""Results that are one quantity: they take part in arithmetic, comparisons and formats as their values do."""

from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.equality import say_the_same
from stickslip_sym.core.errors import InputError


class QuantityResult(NDArrayOperatorsMixin):
    """A result whose attribute `value` is a float or an array.

    Sums, products, comparisons and functions of NumPy take the value; ``f"{result:.3f}"`` formats it. Two results
    are equal where all that they say is equal, as of every other result; a number is equal to the value.
    """

    value: Any

    def __eq__(self, other: object) -> Any:
        if isinstance(other, QuantityResult):
            return say_the_same(self, other)
        return self.value == other

    def __ne__(self, other: object) -> Any:
        if isinstance(other, QuantityResult):
            return not self == other
        return self.value != other

    def __hash__(self) -> int:
        return hash(self.value)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        numbers = [each.value if isinstance(each, QuantityResult) else each for each in inputs]
        return getattr(ufunc, method)(*numbers, **options)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> FloatArray:
        return np.array(self.value, dtype=dtype)

    def __float__(self) -> float:
        """The value of one quantity; several are refused."""
        if np.ndim(self.value):
            raise InputError(f"{np.size(self.value)} values are no single number; take value, an array of them")
        return float(self.value)

    def __format__(self, specification: str) -> str:
        if specification:
            return format(float(self), specification)
        return str(self)
