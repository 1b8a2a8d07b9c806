"""`Oscillator`: the mass on the belt."""

import math
from dataclasses import dataclass, fields

from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import real, require_type
from stickslip_sym.core.remedies import Argument, Name
from stickslip_sym.core.symbols import require_sign
from stickslip_sym.core.units import has_error, si_number
from stickslip_sym.model.law import FrictionLaw


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
            given = getattr(self, name)
            if has_error(si_number(given, name) if isinstance(given, str) else str(given)):
                raise InputError(
                    Name(name),
                    f" = {given} has a standard error, and an Oscillator holds numbers alone; give it beside, as ",
                    Argument("errors", {name: str(given)}),
                    " of study or margins, or give V, N, m and k with theirs to pure_slip_damping",
                )
            value = real(name, given)
            object.__setattr__(self, name, value)
            if name != "c":
                require_sign(name, value)

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
