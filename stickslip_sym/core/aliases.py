"""Names of the types that many annotations share."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

if TYPE_CHECKING:
    import mpmath
    import numpy as np
    import sympy as sp
    from numpy.typing import NDArray
    from sympy.core.function import AppliedUndef
    from sympy.core.relational import Relational
    from sympy.logic.boolalg import Boolean

    Expr: TypeAlias = sp.Expr
    """A SymPy expression."""
    Relation: TypeAlias = Relational
    """One between two expressions, such as v < v_1."""
    Condition: TypeAlias = Boolean
    """A relation, several that are joined, or a truth value."""
    UndefinedFunction: TypeAlias = type[AppliedUndef]
    """A function of which nothing is known but its name."""
    Rational: TypeAlias = sp.Rational
    Mpf: TypeAlias = mpmath.mpf
    FloatArray: TypeAlias = NDArray[np.floating[Any]]
    ComplexArray: TypeAlias = NDArray[np.complexfloating[Any]]
    BoolArray: TypeAlias = NDArray[np.bool_]
    IntArray: TypeAlias = NDArray[np.integer[Any]]
    ObjectArray: TypeAlias = NDArray[np.object_]
    """Of members of an enumeration."""
else:  # no annotation is worth the half second that these libraries take to import
    Expr = Relation = Condition = UndefinedFunction = Rational = Mpf = FloatArray = ComplexArray = BoolArray = (
        IntArray
    ) = ObjectArray = Any
ExprOrCondition = TypeVar("ExprOrCondition", Expr, Condition)
"""Of a function that gives one for one, and the other for the other."""
Substitution: TypeAlias = Mapping[Expr, Expr]
"""What stands in place of each symbol."""
Json: TypeAlias = dict[str, Any]
"""What an object of JSON holds, by name."""
Notation: TypeAlias = Mapping[str, str]
"""The LaTeX of each name."""
Span: TypeAlias = tuple[float, float]
"""Its ends, the lower one first."""
Numbers: TypeAlias = float | FloatArray
"""One number, or an array of them."""
Rows: TypeAlias = IntArray | BoolArray | list[int] | slice
"""Which rows of an array."""
