"""The paper's thresholds as theorems: two dampings that enclose the threshold, or that there is none."""

from collections.abc import Iterable
from fractions import Fraction
from functools import cache
from typing import Any

import sympy as sp

from paper_checks.computed import SPEEDS, law, oscillator, threshold, thresholds
from stickslip_sym import symbols
from stickslip_sym.core.balls import ball_value
from stickslip_sym.core.precision import working_precision
from stickslip_sym.criteria.enclosure import Enclosure, enclosure_of
from stickslip_sym.motion.thresholds.boxes import ExactPoint, transit
from stickslip_sym.motion.thresholds.theorem import Theorem, checked_hypotheses, prove_threshold

_BITS = 64  # precision for a slip without damping, which is far from grazing
_FORMULA_BITS = 200  # precision for (17), which cancels most of them at small V
_GUESS_ERROR = 1e-10  # relative error of collocation
_FINE = 2e-4  # relative width of an enclosure at V = 1 m/s; criteria differ by about V^2, and it does too
_BY_DEFAULT = 5  # every fifth speed: a hundred proofs a figure take a quarter of a minute
_every = [_BY_DEFAULT]


def prove_everywhere() -> None:
    """Take all of `SPEEDS` for the proofs of Figs. 6 and 7, as a report does."""
    _every[0] = 1


def proved_places() -> range:
    """Return the places in `SPEEDS` of the speeds at which thresholds are proved, from the first to 1 m/s."""
    return range(_every[0] - 1, SPEEDS.size, _every[0])


def proved_speeds() -> list[str]:
    """Return these speeds as decimals, which a proof takes exactly."""
    return [f"{SPEEDS[place]:g}" for place in proved_places()]


def exact_point(name: str, V: str, k: str = "100") -> ExactPoint:
    """Return a law and the oscillator of the paper's section 3 in decimals, exactly."""
    osc = oscillator()
    N, m = (sp.Rational(repr(value)) for value in (osc.N, osc.m))
    return ExactPoint(law(name), sp.Rational(V), N, m, sp.Rational(k))


THEOREMS: dict[tuple[str, str, str], Theorem] = {}
"""The theorems of this run, by law, belt speed and stiffness."""


@cache
def theorem(name: str, *, V: str = "0.5", k: str = "100", rtol: float = 1e-6) -> Theorem:
    """Prove the threshold at one operating point that has one; collocation says where it lies."""
    guess = threshold(name, V=float(V), k=float(k))
    THEOREMS[name, V, k] = prove_threshold(exact_point(name, V, k), guess, _GUESS_ERROR, rtol)
    return THEOREMS[name, V, k]


def enclosed(name: str, *, V: str = "0.5", k: str = "100", rtol: float = 1e-6) -> Enclosure:
    """Return what the threshold in kg/s was proved to lie in."""
    return theorem(name, V=V, k=k, rtol=rtol).enclosure


def lowest_velocity(name: str) -> Enclosure:
    """Return what the lowest velocity in m/s of the grazing orbit was proved to lie in.

    More damping moves the slip from P inwards, so that of the threshold lies between those of a theorem.
    """
    proved, V = theorem(name), oscillator().V
    reach = (1 - proved.below.highest.upper(), 1 - proved.above.highest.lower())
    return Enclosure(*(Fraction(V) * Fraction(float(end)) for end in reach))


@cache
def enclosed_over_speeds(name: str) -> list[Enclosure | None]:
    """Return the same at each of `proved_speeds`, up to the first where collocation disagrees.

    It is None where the slip from P was proved to return for no c >= 0.
    """
    found: list[Enclosure | None] = []
    for V, guess in zip(proved_speeds(), thresholds(name)[proved_places()], strict=True):
        found.append(_proved(name, V, float(guess)))
        if not _holds(found[-1], guess):
            break
    return found


def _proved(name: str, V: str, guess: float) -> Enclosure | None:
    if guess > 0:
        return prove_threshold(exact_point(name, V), guess, _GUESS_ERROR, _FINE * float(V) ** 2).enclosure
    if returns_undamped(name, V):
        raise AssertionError(f"collocation gives {guess:g} kg/s at V = {V} m/s, but undamped the slip returns")
    return None


@cache
def returns_undamped(name: str, V: str, k: str = "100") -> bool:
    """Return whether the slip from P returns at c = 0; if not, it does for no c >= 0."""
    point = exact_point(name, V, k)
    checked_hypotheses(point)
    return transit(point, sp.Integer(0), _BITS).returns


def _holds(enclosure: Enclosure | None, guess: float) -> bool:
    return guess <= 0 if enclosure is None else guess in enclosure


def agrees(enclosures: Iterable[Enclosure | None], guesses: Iterable[float]) -> bool:
    """Return whether collocation lies in all of as many enclosures."""
    return all(_holds(*pair) for pair in zip(enclosures, guesses, strict=True))


@cache
def formula_over_speeds(expr: Any, name: str) -> list[Enclosure]:
    """Return enclosures of a formula with the paper's parameters at `proved_speeds`."""
    bound = law(name)
    point: dict[Any, Any] = {bound.parameters[given].symbol: value for given, value in bound.values.items()}
    point |= {symbols.N: exact_point(name, "1").N}
    with working_precision(_FORMULA_BITS):
        return [enclosure_of(ball_value(expr, {**point, symbols.V: sp.Rational(V)}).real) for V in proved_speeds()]


def nearer(one: Enclosure, other: Enclosure, threshold: Enclosure) -> bool | None:
    """Return whether one value is nearer to a threshold than another; None where the enclosures leave it open."""
    low, high = (one.low + other.low) / 2, (one.high + other.high) / 2
    if not one.overlaps(other) and (threshold.high < low or threshold.low > high):
        return (threshold.high < low) == (one.high < other.low)
    return None


def apart(value: Enclosure, threshold: Enclosure) -> Enclosure:
    """Return by how much a value is off a threshold, relative."""
    ends = [end / bound - 1 for end in (value.low, value.high) for bound in (threshold.low, threshold.high)]
    return Enclosure(min(ends), max(ends))


def sizes(deviation: Enclosure) -> tuple[Fraction, Fraction]:
    """Return between what the absolute value of a number lies."""
    low, high = sorted((abs(deviation.low), abs(deviation.high)))
    return (Fraction(0) if deviation.low <= 0 <= deviation.high else low), high
