"""`Oscillator`: the mass on the belt."""

import math
from dataclasses import dataclass, fields

from stickslip_sym.core import symbols
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import real, require_type
from stickslip_sym.model.law import FrictionLaw

_NO_BELT = (
    "on a belt that stands still nothing drives the mass, so take a small speed such as 1e-6 instead",
    "x counts along the belt, so where it runs backward change the signs of V, x0 and v0",
)


@dataclass(frozen=True, kw_only=True)
class Oscillator:
    """A damped mass on a moving belt, m x'' + c x' + k x = N mu(V - x').

    Attributes
    ----------
    m : float
        Mass in kg, positive.
    k : float
        Spring stiffness in N/m, positive.
    c : float
        Damping coefficient in kg/s. Negative values feed energy in; they are allowed.
    V : float
        Belt speed in m/s, positive.
    N : float
        Normal force in N, not negative.

    Raises
    ------
    InputError
        For a value that is not finite or has the wrong sign.
    """

    m: float
    k: float
    c: float = 0.0
    V: float
    N: float

    def __post_init__(self) -> None:
        for field in fields(self):
            name = field.name
            value = real(name, getattr(self, name))
            object.__setattr__(self, name, value)
            required = {"N": "not be negative", "c": ""}.get(name, "be positive")
            if required and (value < 0 or (value == 0 and name != "N")):
                advice = f"; {_NO_BELT[value < 0]}" if name == "V" else ""
                meaning = symbols.QUANTITIES[name].meaning
                raise InputError(f"{name} = {value:g} must {required}: it is the {meaning}{advice}")

    @property
    def omega(self) -> float:
        """Natural angular frequency sqrt(k/m) in rad/s."""
        return math.sqrt(self.k / self.m)

    @property
    def impedance(self) -> float:
        """The unit of damping, sqrt(k m) in kg/s; the critical damping is twice that."""
        return math.sqrt(self.k) * math.sqrt(self.m)

    @property
    def zeta(self) -> float:
        """Damping ratio c/(2 sqrt(k m))."""
        return self.c / (2 * self.impedance)

    @property
    def eta(self) -> float:
        """Normal force over the belt's momentum flux, N/(V sqrt(k m))."""
        return self.N / (self.V * self.impedance)

    @property
    def length(self) -> float:
        """The unit of displacement, V/omega in m."""
        return self.V / self.omega

    def onset(self, law: FrictionLaw) -> float:
        """Return the displacement x_P = (mu_static N - c V)/k in m at which every forward stick phase ends."""
        return (law.static_value * self.N - self.c * self.V) / self.k


def as_oscillator(osc: Oscillator) -> Oscillator:
    """Return an oscillator itself, or refuse what is none."""
    require_type("osc", osc, Oscillator, "an Oscillator(m=..., k=..., c=..., V=..., N=...)")
    return osc
