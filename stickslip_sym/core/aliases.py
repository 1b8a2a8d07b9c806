"""Names of the types that many annotations share."""

from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    import mpmath
    import numpy as np
    import sympy as sp
    from numpy.typing import NDArray

    Expr: TypeAlias = sp.Basic
    """A SymPy expression, or a relation between two."""
    Rational: TypeAlias = sp.Rational
    Mpf: TypeAlias = mpmath.mpf
    FloatArray: TypeAlias = NDArray[np.floating[Any]]
    ComplexArray: TypeAlias = NDArray[np.complexfloating[Any]]
    BoolArray: TypeAlias = NDArray[np.bool_]
    IntArray: TypeAlias = NDArray[np.integer[Any]]
    ObjectArray: TypeAlias = NDArray[np.object_]
    """Of members of an enumeration."""
else:  # no annotation is worth the half second that these libraries take to import
    Expr = Rational = Mpf = FloatArray = ComplexArray = BoolArray = IntArray = ObjectArray = Any
Numbers: TypeAlias = float | FloatArray
"""One number, or an array of them."""
Rows: TypeAlias = IntArray | BoolArray | list[int] | slice
"""Which rows of an array."""
