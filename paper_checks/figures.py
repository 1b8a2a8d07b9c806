"""The paper's figures 2 to 10 redrawn from our own computation, by their numbers."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from paper_checks.figure_motions import histories, phase_plots
from paper_checks.figure_thresholds import friction_laws, plane, several_minima
from paper_checks.printed import PRINTED
from stickslip_sym.views.drawing import styled


@dataclass(frozen=True)
class PaperFigure:
    """A figure of the paper."""

    number: int
    title: str
    shown: str  # by the paper, drawn in black
    left_out: str  # by the paper, drawn in colour
    claims: tuple[str, ...]
    compute: Callable[[], Any]

    def draw(self) -> Any:
        """Compute and draw it; returns a ``matplotlib.figure.Figure``."""
        with styled():
            return self.compute()


_STICK = "Thick lines are stick."
_DAMPINGS = {id: tuple(map(float, PRINTED[id]["dampings"])) for id in ("F3", "F4")}
_LATER = (
    "The peaks of the velocity over 25 s: whether a motion sticks for ever, comes to rest, or tends "
    "to a limit cycle in slip, which five seconds do not show."
)
_STATES = (
    "The equilibrium (cross) with its stability, every limit cycle in pure slip (dash-dotted if unstable), and "
    "the exact threshold. Where rest is stable below the threshold, the initial condition decides between rest "
    "and stick–slip."
)
_DISTANCE = (
    "The exact threshold (wide line), from the orbit that grazes the belt’s speed, and the distance of everything "
    "else from it (b). "
)

_PRINTED_NUMBER = "and the paper’s numerical procedure (circles; the square is the printed number)."
_PHASES = tuple(zip(("stick–slip", "pure slip", "damped slip"), _DAMPINGS["F3"][2:], [0.5] * 3, strict=True))

FIGURES = (
    PaperFigure(
        2, "Friction coefficient over relative velocity", "The exponential law (3) and the polynomial law (4).",
        "The straight line (8) with the coefficients (15) that stands for each law in the criterion, and the "
        "speeds over which it is fitted at V = 0.5 m/s.",
        ("E3", "E4"), friction_laws,
    ),
    PaperFigure(
        3, "Velocity of the mass, exponential law", f"V = 0.5 m/s and five dampings. {_STICK}", _LATER,
        ("F3", "N2"), partial(histories, "exponential", _DAMPINGS["F3"]),
    ),
    PaperFigure(
        4, "Velocity of the mass, polynomial law", f"V = 0.5 m/s and five dampings. {_STICK}", _LATER,
        ("F4", "N3"), partial(histories, "polynomial", _DAMPINGS["F4"]),
    ),
    PaperFigure(
        5, "Phase plots, exponential law",
        f"Stick–slip, the printed threshold, and damped slip, five seconds each from x(0) = 0. {_STICK}", _STATES,
        ("F5",), partial(phase_plots, "exponential", _PHASES),
    ),
    PaperFigure(
        6, "Pure-slip damping over belt speed, exponential law",
        f"The criterion (17), the stability of the equilibrium (Galvanetto & Bishop), {_PRINTED_NUMBER}",
        f"{_DISTANCE}Hatched, from the stability of rest to the exact threshold: both can happen.",
        ("F6", "S4", "S5"), partial(plane, "exponential"),
    ),
    PaperFigure(
        7, "Pure-slip damping over belt speed, polynomial law",
        f"The criterion (18), Galvanetto & Bishop, Thomsen & Fidlin (dotted), {_PRINTED_NUMBER}",
        f"{_DISTANCE}Hatched, from the exact threshold to the stability of rest: a stable cycle in pure slip.",
        ("F7", "S4", "S6", "S7"), partial(plane, "polynomial"),
    ),
    PaperFigure(
        8, "Phase plots at the points A and B, exponential law",
        f"c = 2 kg/s at two belt speeds. {_STICK}", _STATES, ("F8",),
        partial(phase_plots, "exponential", (("point A", 2.0, 0.5), ("point B", 2.0, 0.8))),
    ),
    PaperFigure(
        9, "Phase plots at the points C and D, polynomial law",
        f"c = 2 kg/s at two belt speeds. {_STICK}", _STATES, ("F9",),
        partial(phase_plots, "polynomial", (("point C", 2.0, 0.5), ("point D", 2.0, 0.8))),
    ),
    PaperFigure(
        10, "Pure-slip damping for three values of the lowest friction coefficient", "The criteria (17) and (18).",
        "The exact thresholds (wide lines), and the regions of coexistence (a) and of stable limit cycles in "
        "pure slip (b).",
        ("F10", "S9"), several_minima,
    ),
)  # fmt: skip
