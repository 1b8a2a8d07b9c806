"""What the user describes: a friction law, measured points, an oscillator, the catalogue of laws.

Imports `core`, `output` and `numerics`. One more law of the catalogue is one entry in `catalogue`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, ["laws"])
