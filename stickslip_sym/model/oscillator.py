"""`Oscillator`: the mass on the belt, and the dimensionless form in which it is integrated."""

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields

from stickslip_sym.core import symbols
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import real
from stickslip_sym.model.law import FrictionLaw, limit_at_rest

__all__ = ["Oscillator", "Scene"]

_NO_BELT = (
    "on a belt that stands still nothing drives the mass, so take a small speed such as 1e-6 instead",
    "x counts along the belt, so where it runs backward mirror the scene: V, x0 and v0 with their signs changed",
)
_SMALL = 1e-6  # slip speed, relative, over which a slope of mu is taken


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
            meaning = symbols.QUANTITIES[name].meaning
            if name == "V" and value <= 0:
                raise InputError(f"V = {value:g} must be positive: it is the belt speed; {_NO_BELT[value < 0]}")
            if name in ("m", "k") and value <= 0:
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
        return (_static(law) * self.N - self.c * self.V) / self.k


def _onset(law: FrictionLaw) -> float:
    """Return mu(0+)."""
    onset = limit_at_rest(law.substitute(law.expr))
    if not math.isfinite(onset):
        raise InputError(
            f"mu(0+) is {onset}, not a finite number, for {law!r}: no spring could ever pull the mass off the "
            "belt; cut the law off at a small speed, as in log(1 + v/v_c) for log(v)"
        )
    return onset


def _static(law: FrictionLaw) -> float:
    """Return the coefficient that limits sticking, at least mu(0+)."""
    onset = _onset(law)
    if law.static is None:
        return onset
    static = real("the static coefficient", law.substitute(law.static))
    if static < onset - 1e-12 * abs(onset):
        raise InputError(
            f"the static coefficient {static:g} is below mu(0+) = {onset:g}: a contact that gives way would "
            "stop the mass at once; give a static coefficient of at least mu(0+), or none"
        )
    return max(static, onset)


@dataclass(frozen=True)
class Branch:
    """A smooth piece of mu, which holds from w = `low` to `high`, and its rise mu(V w) - mu(0+)."""

    low: float
    high: float
    rise: Callable[[float], float]


def _of_w(
    rise: Callable[[float], float], speed: float, low: float, high: float, *, everywhere: bool
) -> Callable[[float], float]:
    """Return a rise as a function of w that a step may try anywhere; its piece holds from `low` to `high`.

    - `everywhere`: it has a value at every w, as a polynomial has.
    """
    if everywhere:
        return lambda w: rise(speed * w)

    def value(w: float) -> float:
        try:
            return float(rise(speed * w))
        except (ArithmeticError, TypeError, ValueError):  # a TypeError is a complex coefficient
            return math.nan

    def continued(w: float) -> float:
        if low < w < high:  # as a rule; `value` written out saves a call in the innermost loop
            try:
                return float(rise(speed * w))
            except (ArithmeticError, TypeError, ValueError):
                return math.nan
        found = value(w if w > -1.0 else -1.0)
        if math.isfinite(found):
            return found
        # A piece such as sqrt(v) has no value beyond its end: it goes on with its last one.
        return value(min(max(w, low), high)) if w > 0 else 0.0

    return continued


def _joined(branches: Sequence[Branch]) -> Callable[[float], float]:
    """Return the rise of whichever piece holds."""
    if len(branches) == 1:
        return branches[0].rise
    levels = [branch.low for branch in branches[1:]]
    return lambda w: branches[bisect_right(levels, w)].rise(w)


@dataclass(frozen=True)
class Scene:
    """An oscillator with its law, free of units.

    Time is tau = omega t. The state is (q, w): q is the displacement from P, the point where every
    forward stick phase ends, and w = abs(x' - V)/V the slip speed. With `side` 1 where the mass is
    slower than the belt and -1 where it is faster,

        q' = 1 - side w,    w' = eta (side mu_static - mu(V w)) + side q - 2 zeta w.

    So w = 0 is the belt's speed exactly, and P is the origin: no digits cancel where returns are decided. Nor do
    they on a slow belt, where eta is large: mu enters by its rise mu(V w) - mu(0+), computed without cancellation.

    Attributes
    ----------
    eta, zeta : float
    static : float
        The coefficient that limits sticking.
    onset : float
        mu(0+).
    rise : callable
        mu(V w) - mu(0+) for w > 0, and NaN where it cannot be computed, so that an integrator takes a shorter
        step. For w <= 0 it continues smoothly, or is 0 where it cannot: a step that crosses w = 0 is tried with
        such values, and the crossing is then refined with those of w > 0.
    law : FrictionLaw
        The law of mu, bound.
    speed : float
        V in m/s, the unit of the law's slip speed.
    w_max : float
        The slip speed up to which the law is known.
    branches : tuple of Branch
        The smooth pieces of mu, between the slip speeds at which it has a kink.
    """

    eta: float
    zeta: float
    static: float
    onset: float
    rise: Callable[[float], float]
    law: FrictionLaw
    speed: float
    w_max: float = math.inf
    branches: tuple[Branch, ...] = ()

    @classmethod
    def of(cls, law: FrictionLaw, osc: Oscillator) -> "Scene":
        """Make an oscillator with a bound law dimensionless.

        Raises
        ------
        InputError
            If a parameter has no value, mu(0+) is not finite, or the static coefficient is below mu(0+).
        """
        static, onset = _static(law), _onset(law)
        speed = osc.V
        w_max = math.inf if law.v_max is None else float(law.v_max) / speed
        pieces = law.rises()
        levels = [start / speed for start, _ in pieces] + [math.inf]
        branches = tuple(
            Branch(low, high, _of_w(rise, speed, low, high, everywhere=law.curve is not None))
            for low, high, (_, rise) in zip(levels, levels[1:], pieces, strict=False)
        )
        return cls(osc.eta, osc.zeta, static, onset, _joined(branches), law, speed, w_max, branches)

    def friction(self, w: float, side: int) -> float:
        """Return what static and sliding friction together add to w', eta (side mu_static - mu(V w))."""
        return self.eta * (side * self.static - self.onset - self.rise(w))

    def acceleration(self, q: float, w: float, side: int) -> float:
        """Return w', the rate at which the slip speed grows."""
        return self.friction(w, side) + side * q - 2 * self.zeta * w

    def decay(self, w: float) -> float:
        """Return -dw'/dw, the rate at which a deviation of the slip speed w >= 0 decays."""
        half = _SMALL * max(w, 1.0)
        low, high = max(w - half, 0.0), w + half
        return self.eta * (self.rise(high) - self.rise(low)) / (high - low) + 2 * self.zeta

    @property
    def rest(self) -> tuple[float, float]:
        """The equilibrium (q, w): the mass stands still, and the belt slips under it."""
        return self.turn(1.0), 1.0

    def turn(self, w: float) -> float:
        """Return the displacement q at which w' = 0 for a mass slower than the belt."""
        return 2 * self.zeta * w - self.friction(w, 1)

    def sticks(self, q: float) -> bool:
        """Whether static friction holds the mass at displacement q: |c V + k x| <= mu_static N."""
        return -2 * self.eta * self.static <= q <= 0
