"""What everything stands on: errors, time limits, numbers as users give them, symbols, the table of functions,
balls.

Imports nothing of the package. One more error is a class in `errors`, with what its message must say.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, ["symbols"])
