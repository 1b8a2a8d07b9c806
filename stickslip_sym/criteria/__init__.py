"""The criteria, weights over which the falling slope of mu is averaged, and their values by quadrature.

Imports `core`, `output`, `numerics` and `model`, and never sees a closed form. One more criterion is one
`Criterion` in `criterion`; `ss.Criterion(name, weight)` is one outside the package.
"""

import lazy_loader

from stickslip_sym.criteria.criterion import Criterion, catalogue, equilibrium, find, harmonic, least_squares

__all__ = ["Criterion", "catalogue", "equilibrium", "find", "harmonic", "least_squares", "quadrature"]
__getattr__, __dir__, _ = lazy_loader.attach(__name__, ["quadrature"])
