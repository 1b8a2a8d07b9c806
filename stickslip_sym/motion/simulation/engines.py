"""What integrates a slip phase, by name: one more engine is a class, and an entry in `ENGINES`.

`regime`, `classify` and the maps follow slip by "scipy" alone: they compare more than they integrate. heyoka takes
a slip in a quarter of the time, but half a second to import and 0.1 s to compile a law, as long as hundreds of
slips take, and it has none of the laws that are not smooth, which are those that maps simulate.
"""

from typing import Protocol

from stickslip_sym.core.numbers import lookup
from stickslip_sym.model.oscillator import Scene
from stickslip_sym.motion.simulation.method import Steps
from stickslip_sym.motion.simulation.slip_phase import SlipPhase, Until
from stickslip_sym.motion.simulation.taylor import TaylorSteps

__all__ = ["ENGINES", "Engine", "Method", "find"]


class Method(Protocol):
    """The integration of one slip phase, which it writes on."""

    def check_work(self, *, bounded: bool) -> None:
        """Raise `NotConverged` where steps are too many for a slip phase; `bounded`: another bound is on them."""

    def advance(self) -> None:
        """Take a step: add its interpolant, the extrema of w in it, the state after it, and the end if it is."""


class Engine(Protocol):
    """What begins the integration of a slip phase."""

    def __call__(  # noqa: D102
        self, scene: Scene, phase: SlipPhase, *, horizon: float, rtol: float, until: Until
    ) -> Method: ...


ENGINES: dict[str, Engine] = {"scipy": Steps, "heyoka": TaylorSteps}


def find(name: str) -> Engine:
    """Return the engine of a name.

    Raises `InputError` if there is none by this name.
    """
    return lookup("engine", name, ENGINES)
