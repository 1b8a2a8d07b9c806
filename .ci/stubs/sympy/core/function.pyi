from typing import Any, Self

from sympy import Expr, Function

class AppliedUndef(Function):
    def __new__(cls, *args: Any) -> Self: ...

class ArgumentIndexError(ValueError):
    def __init__(self, operation: Expr, argindex: int) -> None: ...
