"""Names of the types that annotations say again and again."""

from typing import TypeAlias

import mpmath
import numpy as np
import sympy as sp
from numpy.typing import NDArray

__all__ = ["BoolArray", "Expr", "FloatArray", "IntArray", "Mpf", "ObjectArray", "Rational"]

Expr: TypeAlias = sp.Basic
"""A SymPy expression, or a relation between two."""
Rational: TypeAlias = sp.Rational
Mpf: TypeAlias = mpmath.mpf
FloatArray: TypeAlias = NDArray[np.float64]
BoolArray: TypeAlias = NDArray[np.bool_]
IntArray: TypeAlias = NDArray[np.int_]
ObjectArray: TypeAlias = NDArray[np.object_]
"""Of members of an enumeration."""
