"""SymPy, imported when it is first used: numbers of the catalogue's laws need none of it, and it is slow.

``from stickslip_sym.core.algebra import sp`` serves as ``import sympy as sp`` does, in modules that name nothing
of SymPy until they are called.
"""

from typing import TYPE_CHECKING, Any

__all__ = ["sp"]

if TYPE_CHECKING:
    import sympy as sp
else:

    class _OnDemand:
        """A library whose names are looked up by importing it."""

        def __getattr__(self, name: str) -> Any:
            import sympy  # by the statement, whose lock serves threads

            value = getattr(sympy, name)
            setattr(self, name, value)
            return value

    sp = _OnDemand()
