"""Stick-slip vibration of a mass on a moving belt: criteria derived, proved, evaluated and cross-checked.

The friction law mu(v) of a contact decides how much viscous damping c the oscillator
m x'' + c x' + k x = N mu(V - x') needs so that it does not stick and slip. The public names stand in the stub
beside this file, and are loaded when first used: importing the package is cheap.
"""

import lazy_loader

from stickslip_sym.core.version import __version__ as __version__

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
