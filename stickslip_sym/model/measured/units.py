"""Units of speed and force as instruments write them, and what one of them is in SI units, exactly."""

import re
from dataclasses import dataclass
from fractions import Fraction

__all__ = ["Unit", "read_unit"]


@dataclass(frozen=True)
class Unit:
    """A unit: what it measures, and its size in SI units.

    Attributes
    ----------
    kind : str
        "speed", "force" or "number".
    size : Fraction
        In m/s, N or 1.
    """

    kind: str
    size: Fraction


_LENGTHS = {
    "m": Fraction(1), "dm": Fraction(1, 10), "cm": Fraction(1, 100), "mm": Fraction(1, 10**3),
    "um": Fraction(1, 10**6), "μm": Fraction(1, 10**6), "micron": Fraction(1, 10**6), "nm": Fraction(1, 10**9),
    "km": Fraction(1000), "in": Fraction(254, 10**4), "inch": Fraction(254, 10**4), "ft": Fraction(3048, 10**4),
    "mi": Fraction(1609344, 1000),
}  # fmt: skip
_TIMES = {
    "s": Fraction(1), "sec": Fraction(1), "second": Fraction(1), "ms": Fraction(1, 1000), "min": Fraction(60),
    "minute": Fraction(60), "h": Fraction(3600), "hr": Fraction(3600), "hour": Fraction(3600),
}  # fmt: skip
_SPEEDS = {
    "mps": Fraction(1), "kph": Fraction(5, 18), "kmh": Fraction(5, 18), "mph": Fraction(1609344, 3600000),
    "ips": _LENGTHS["in"], "fps": _LENGTHS["ft"], "fpm": _LENGTHS["ft"] / 60, "knot": Fraction(1852, 3600),
}  # fmt: skip
_GRAVITY = Fraction(980665, 10**5)  # m/s^2, standard
_FORCES = {
    "N": Fraction(1), "newton": Fraction(1), "daN": Fraction(10), "kN": Fraction(1000), "MN": Fraction(10**6),
    "cN": Fraction(1, 100), "mN": Fraction(1, 1000), "uN": Fraction(1, 10**6), "μN": Fraction(1, 10**6),
    "nN": Fraction(1, 10**9), "kgf": _GRAVITY, "kp": _GRAVITY, "gf": _GRAVITY / 1000,
    "lbf": Fraction(45359237, 10**8) * _GRAVITY, "ozf": Fraction(45359237, 16 * 10**8) * _GRAVITY,
    "dyn": Fraction(1, 10**5),
}  # fmt: skip
_NUMBERS = frozenset({"1", "-", "–", "—", "--", "dimensionless", "none", "N/N"})
_INVERSE = re.compile(r"[ *.·]?(\w+?)(?:\^|\*\*)?[-−]1$")


def read_unit(text: str) -> Unit | None:
    """Return the unit that a text names; None for one that is not known.

    Capitals count, as they tell mN from MN. A speed is a length over a time in any of the usual ways:
    ``mm/s``, ``mm s^-1``, ``mm*s**-1``, ``mm·s⁻¹``.
    """
    text = " ".join(text.replace("\N{MICRO SIGN}", "μ").replace("⁻¹", "^-1").split())
    if text in _NUMBERS:
        return Unit("number", Fraction(1))
    if text in _FORCES:
        return Unit("force", _FORCES[text])
    if text in _SPEEDS:
        return Unit("speed", _SPEEDS[text])
    above, over, below = (part.strip() for part in text.partition("/"))
    if not over and (inverse := _INVERSE.search(text)):
        above, below = text[: inverse.start()].strip(), inverse[1]
    if above in _LENGTHS and below in _TIMES:
        return Unit("speed", _LENGTHS[above] / _TIMES[below])
    return None
