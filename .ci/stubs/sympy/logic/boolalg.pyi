from collections.abc import Mapping
from typing import Any

from sympy import Basic, Expr

class Boolean(Basic):
    def __new__(cls, *args: Any, **options: Any) -> Boolean: ...  # type: ignore[misc]
    @property
    def func(self) -> type[Boolean]: ...  # type: ignore[override]
    def replace(self, query: Any, value: Any) -> Boolean: ...
    # Of a relation, which most conditions are.
    lhs: Expr
    rhs: Expr
    lts: Expr
    gts: Expr
    rel_op: str
    def subs(self, *args: Any, **options: Any) -> Boolean: ...
    def xreplace(self, rule: Mapping[Any, Any]) -> Boolean: ...
    def __and__(self, other: Boolean | bool) -> Boolean: ...
    def __or__(self, other: Boolean | bool) -> Boolean: ...
    def __invert__(self) -> Boolean: ...
    def __bool__(self) -> bool: ...

class And(Boolean):
    @property
    def args(self) -> tuple[Boolean, ...]: ...  # type: ignore[override]

class Or(Boolean):
    @property
    def args(self) -> tuple[Boolean, ...]: ...  # type: ignore[override]
