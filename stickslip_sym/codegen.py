"""SymPy expressions to Python functions.

The one place that calls `lambdify`. It generates source text, so only symbols that were checked
(`friction`) reach it, and even those are replaced by dummy names.
"""

from collections.abc import Callable, Sequence
from typing import Any, Literal

import numpy as np
import sympy as sp

from stickslip_sym.special import lerch

__all__ = ["Backend", "function_of"]

Backend = Literal["numpy", "math", "mpmath"]


def function_of(arguments: Sequence[Any], expr: Any, backend: Backend) -> Callable[..., Any]:
    """Return `expr` as a function of `arguments`, computed by the given library.

    `expr` may be a list of expressions; common subexpressions are then computed once.
    """
    # SciPy's expm1 takes no extended precision, NumPy's does.
    modules = {
        "numpy": [{"expm1": np.expm1}, "scipy", "numpy"],
        "math": ["math"],
        "mpmath": [{"Lerch": lerch}, "mpmath"],
    }[backend]
    compiled: Callable[..., Any] = sp.lambdify(
        list(arguments), expr, modules=modules, dummify=True, cse=isinstance(expr, list)
    )
    return compiled
