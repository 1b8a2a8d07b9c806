"""The kinds of attractors, an entry each: what it is called, how it is found, and how it is drawn.

Regimes, maps, their files and their pictures read this table. A further kind is one more entry.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from stickslip_sym.core.aliases import BoolArray
from stickslip_sym.motion.motion import Motion


class Region(NamedTuple):
    """What cells have in common: how they are called and drawn, and their letter in text."""

    name: str
    color: str
    hatch: str
    letter: str


class Signs(NamedTuple):
    """What comparisons with the needed damping d(A) of slip orbits say of dampings c, as arrays.

    - `rest`: c > d(0), where small motions about rest decay.
    - `falls`: d falls through c somewhere between A = 0 and A = 1: a stable limit cycle in pure slip.
    - `returns`: c < d(1): the slip from P comes back to the belt's speed, and then does not grow without bound.
    - `held`: static friction holds the mass at the end of such a slip, or of one that overtakes the belt after it.
    """

    rest: BoolArray
    falls: BoolArray
    returns: BoolArray
    held: BoolArray


class AttractorKind(NamedTuple):
    """A kind of motion that others come to.

    - `name`: in files, and as the key of `MotionMap.attractors`.
    - `motion`: that of what comes to it.
    - `region`: of a map, where this is the only attractor.
    - `of`: returns those of this kind in a `Regime`.
    - `exists`: returns for which dampings there is one.
    """

    name: str
    motion: Motion
    region: Region
    of: Callable[[Any], tuple[Any, ...]]
    exists: Callable[[Signs], BoolArray]


# Colours of Okabe and Ito, which colour-blind people tell apart, lightened.
ATTRACTORS = [
    AttractorKind(
        "rest", Motion.REST, Region("rest", "#BFE0F5", "", "."),
        of=lambda regime: (regime.rest,) if regime.rest.stable else (),
        exists=lambda signs: signs.rest,
    ),
    AttractorKind(
        "pure_slip", Motion.PURE_SLIP, Region("pure slip", "#009E73", "....", "p"),
        of=lambda regime: tuple(cycle for cycle in regime.cycles if cycle.stable),
        exists=lambda signs: signs.falls | signs.returns & ~signs.held,
    ),
    AttractorKind(
        "stick_slip", Motion.STICK_SLIP, Region("stick-slip", "#E69F00", "", "S"),
        of=lambda regime: () if regime.stick_slip is None else (regime.stick_slip,),
        exists=lambda signs: signs.returns & signs.held,
    ),
]  # fmt: skip
"""From inside out in the phase plane."""
