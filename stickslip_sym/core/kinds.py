"""What values are, for annotations: SymPy and mpmath describe no types of their own."""

import mpmath
import numpy as np
import sympy as sp
from numpy.typing import NDArray

__all__ = ["BoolArray", "Column", "Expr", "FloatArray", "IntArray", "Mpf"]

Expr = sp.Expr
"""An expression, or a part of one; a rational number is one too."""
Mpf = mpmath.mpf
"""A number of mpmath."""
FloatArray = NDArray[np.floating]
"""An array of real numbers, in double or extended precision."""
Column = float | FloatArray
"""One number for all elements of an array, or one for each."""
IntArray = NDArray[np.integer]
BoolArray = NDArray[np.bool_]
