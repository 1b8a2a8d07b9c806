"""`Oscillator`: the mass on the belt, and the dimensionless form in which it is integrated."""

import math
from collections.abc import Callable
from dataclasses import dataclass, fields

from stickslip_sym import symbols
from stickslip_sym.codegen import function_of
from stickslip_sym.errors import InputError
from stickslip_sym.friction import FrictionLaw

__all__ = ["Oscillator", "Scene"]


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
            try:
                value = float(getattr(self, name))
            except (TypeError, ValueError):
                raise InputError(f"{name} = {getattr(self, name)!r} is not a number") from None
            object.__setattr__(self, name, value)
            meaning = symbols.QUANTITIES[name].meaning
            if not math.isfinite(value):
                raise InputError(f"{name} = {value} is not finite; the {meaning} is a finite number")
            if name in ("m", "k", "V") and value <= 0:
                raise InputError(f"{name} = {value:g} must be positive: it is the {meaning}")
            if name == "N" and value < 0:
                raise InputError(f"N = {value:g} must not be negative: it is the {meaning}")

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
        return (float(law.substitute(law.static_expr)) * self.N - self.c * self.V) / self.k


@dataclass(frozen=True)
class Scene:
    """An oscillator with its law, free of units.

    Time is tau = omega t. The state is (q, w): q is the displacement from P, the point where every
    forward stick phase ends, and w = abs(x' - V)/V the slip speed. With `side` 1 where the mass is
    slower than the belt and -1 where it is faster,

        q' = 1 - side w,    w' = eta (side mu_static - mu(V w)) + side q - 2 zeta w.

    So w = 0 is the belt's speed exactly, and P is the origin: nothing cancels where returns are decided.

    Attributes
    ----------
    eta, zeta : float
    static : float
        The coefficient that limits sticking.
    mu : callable
        mu(V w) for w >= 0, continued to w < 0 along its tangent: an orbit that is followed a little past
        its return (to see by how much it returns) keeps two derivatives.
    """

    eta: float
    zeta: float
    static: float
    mu: Callable[[float], float]

    @classmethod
    def of(cls, law: FrictionLaw, osc: Oscillator) -> "Scene":
        """Make an oscillator with a bound law dimensionless."""
        mu = function_of([symbols.v], law.substitute(law.expr), "math")
        at_rest = float(law.substitute(law.static_expr))
        onset = float(mu(0.0))
        tangent = float(law.substitute(law.slope_expr).subs(symbols.v, 0)) * osc.V
        speed = osc.V

        def continued(w: float) -> float:
            return float(mu(speed * w)) if w >= 0 else onset + tangent * w

        return cls(osc.eta, osc.zeta, at_rest, continued)

    def acceleration(self, q: float, w: float, side: int) -> float:
        """Return w', the rate at which the slip speed grows."""
        return self.eta * (side * self.static - self.mu(w)) + side * q - 2 * self.zeta * w

    def sticks(self, q: float) -> bool:
        """Whether static friction holds the mass at displacement q: |c V + k x| <= mu_static N."""
        return -2 * self.eta * self.static <= q <= 0
