"""The catalogue of friction laws. To add a law, add one entry; every property test picks it up."""

from stickslip_sym.friction import FrictionLaw, Parameter
from stickslip_sym.values import lookup

__all__ = ["catalogue", "exponential", "find", "polynomial"]

_MU_S = Parameter("mu_s", "friction coefficient at v = 0+", "1", typical="0.5")
_MU_M = Parameter("mu_m", "lowest friction coefficient", "1", typical="0.2")

exponential = FrictionLaw(
    "mu_m + (mu_s - mu_m)*exp(-alpha*v)",
    name="exponential",
    parameters=(_MU_S, _MU_M, Parameter("alpha", "decay rate of the coefficient", "s/m", typical="3")),
    source="Won & Chung 2016, eq. (3)",
)

polynomial = FrictionLaw(
    "mu_s - 3*(mu_s - mu_m)/(2*v_m)*v + (mu_s - mu_m)/(2*v_m^3)*v^3",
    name="polynomial",
    parameters=(_MU_S, _MU_M, Parameter("v_m", "slip speed of the lowest coefficient", "m/s", typical="1")),
    source="Thomsen & Fidlin 2003; Won & Chung 2016, eq. (4)",
)

catalogue: dict[str, FrictionLaw] = {str(law.name): law for law in (exponential, polynomial)}
"""Every law of the catalogue by name."""


def find(name: str) -> FrictionLaw:
    """Return a law of the catalogue by its name.

    Raises
    ------
    InputError
        If there is none; the message suggests the closest name.
    """
    return lookup("law", name, catalogue)
