"""Stick-slip vibration of a mass on a moving belt: criteria derived, proved, evaluated and cross-checked.

The friction law mu(v) of a contact decides how much viscous damping c the oscillator
m x'' + c x' + k x = N mu(V - x') needs so that it does not stick and slip. The public names stand in the stub
beside this file, and are loaded when first used: importing the package is cheap.
"""

import sys
from typing import Any

import lazy_loader

from stickslip_sym.core.version import __version__ as __version__

_public, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    """Load a public name; for a class of results say where it is."""
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
        return _public(name)
    from sympy import evaluate

    with evaluate(True):
        return _public(name)
