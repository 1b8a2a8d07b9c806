"""Stick-slip vibration of a mass on a moving belt: criteria derived, proved, evaluated and cross-checked.

The friction law mu(v) of a contact decides how much viscous damping c the oscillator
m x'' + c x' + k x = N mu(V - x') needs so that it does not stick and slip. The public names stand in the stub
beside this file, and are loaded when first used: importing the package is cheap. So cheap that the command can
answer to Ctrl-C at once: the stub is read when a name is asked for.
"""

from __future__ import annotations

import sys

from stickslip_sym.core.version import __version__ as __version__

TYPE_CHECKING = False  # as in typing, the import of which takes longer than all else here
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

_stub = list["tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]"]()
"""What gives a public name, what lists all, and those; once it was read."""


def _read() -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    if not _stub:
        import lazy_loader

        _stub.append(lazy_loader.attach_stub(__name__, __file__))
    return _stub[0]


def __dir__() -> list[str]:
    return _read()[1]()


def __getattr__(name: str) -> Any:
    """Load a public name; for a class of results say where it is."""
    if name == "__all__":
        return _read()[2]
    try:
        return _loaded(name)
    except AttributeError:
        if name[0].isupper():
            from stickslip_sym import results

            if name in results.__all__:
                message = f"module {__name__!r} has no attribute {name!r}; it is {__name__}.results.{name}"
                raise AttributeError(message) from None
        raise


def _loaded(name: str) -> Any:
    """Load a public name; what its modules write in SymPy is evaluated, also within sympy.evaluate(False)."""
    if "sympy" not in sys.modules:
        return _read()[0](name)
    from sympy import evaluate

    with evaluate(True):
        return _read()[0](name)
