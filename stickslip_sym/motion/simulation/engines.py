"""What integrates a slip phase, by name."""

from collections.abc import Callable

from stickslip_sym.core.numbers import lookup
from stickslip_sym.motion.simulation import slip, taylor
from stickslip_sym.motion.simulation.slip_phase import SlipPhase

__all__ = ["ENGINES", "follower"]

ENGINES: dict[str, Callable[..., SlipPhase]] = {"scipy": slip.follow, "heyoka": taylor.follow}
"""Functions of one contract, that of `slip.follow`."""


def follower(engine: str) -> Callable[..., SlipPhase]:
    """Return the function that follows slip phases.

    Raises
    ------
    InputError
        If there is none by this name.
    """
    return lookup("engine", engine, ENGINES)
