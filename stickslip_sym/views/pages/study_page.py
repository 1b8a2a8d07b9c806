"""The page of a study: HTML that is XML too, and its pictures, which hold no text of the user's."""

import math
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import sympy as sp

from stickslip_sym.comparison.decision import chance_in_words
from stickslip_sym.comparison.plane import Plane
from stickslip_sym.comparison.study import DERIVATIVES, REACH, Study
from stickslip_sym.core import symbols
from stickslip_sym.core.probabilities import NORMAL
from stickslip_sym.core.symbols import QUANTITIES
from stickslip_sym.model.error_band import error_band
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.regimes.regime import Regime
from stickslip_sym.motion.simulation.trajectory import Phase, Trajectory
from stickslip_sym.motion.thresholds.threshold import Threshold
from stickslip_sym.output import printing
from stickslip_sym.output.tables import duration
from stickslip_sym.views.drawing import (
    FIGURE_HEIGHT,
    FIGURE_WIDTH,
    MOST_DRAWN,
    finish,
    new_figure,
    styled,
    svg_uri,
)
from stickslip_sym.views.markup import Markup, element
from stickslip_sym.views.model import draw_law
from stickslip_sym.views.pages.browser import print_to_pdf
from stickslip_sym.views.pages.render import MOST_SHOWN_DIGITS, heading, mathml_equation, number_with_error, render
from stickslip_sym.views.threshold_plane import ABOVE, Look, draw_plane

_TEMPLATE = Path(__file__).with_name("study_page.html")
_SHEETS = 2  # of paper
_WIDEST = 260  # characters of a formula as text, up to which it fits a sheet when it is set
_MOST_PAGE_CHARACTERS = 1500  # characters that are shown at all
_SCALE = 2 / 3  # of a figure of its own: two stand beside each other on a screen and on paper


def page_of_study(study: Study) -> str:
    """Return the page; matplotlib, jinja2 and latex2mathml are needed."""
    return render(
        _TEMPLATE,
        title=f"Stick–slip study: {heading(study.title)}",
        study=study,
        value=lambda name: number_with_error(study.value(name), study.standard_error(name)),
        units=QUANTITIES,
        digits=_digits,
        duration=duration,
        reach=REACH,
        chance=_chance,
        derivatives=DERIVATIVES,
        figures=list(pictures(study)),
        remarks=remarks(study),
        formula=_formula,
        c=symbols.c,
        mu=sp.Function("mu")(symbols.v),
        time=f"{study.time} in {study.seconds:.1f} s",
    )


def print_page_of_study(study: Study, path: Path) -> None:
    """Print the page to a PDF file."""
    print_to_pdf(study.page, path, sheets=_SHEETS)


def remarks(study: Study) -> dict[str, str]:
    """Return what the caption of a figure says of what is not in every one of them."""
    said = dict[str, str]()
    regions = study.plane
    motion = study.motion
    motions = study.regime
    if regions is not None and np.nanmax(np.abs(regions["exact"] - regions["equilibrium"]), initial=0.0) > 0:
        said["plane"] = (
            "Hatched: between the threshold and the stability of the equilibrium (dashed) the initial "
            "condition decides, or a limit cycle in pure slip attracts."
        )
    if motion is not None and Phase.STICK in motion.phase:
        said["time"] = "Thick lines are stick."
    if motions is not None and (motions.separatrices or not all(cycle.stable for cycle in motions.cycles)):
        said["phase"] = (
            "A separatrix, or an unstable cycle, separates the initial conditions of different motions."
        )
    return said


def _chance(chance: float, least: float) -> Markup:
    """Return a probability as it is shown everywhere, with all its digits beside."""
    return element("data", chance_in_words(chance, least), value=repr(float(chance)))


def _digits(threshold: Threshold[float]) -> int:
    """Return the digits of a threshold that its own error leaves."""
    error = threshold.relative_error
    if not error:
        return MOST_SHOWN_DIGITS
    return min(max(1 - math.floor(math.log10(error)), 2), MOST_SHOWN_DIGITS)


def _formula(left: sp.Expr, expr: sp.Expr) -> Markup:
    """Return a formula as it fits a page: set, as text, or its length."""
    text = printing.text(expr)
    if len(text) <= _WIDEST:
        return mathml_equation(left, expr)
    if len(text) <= _MOST_PAGE_CHARACTERS:
        return element("code", f"{printing.text(left)} = {text}")
    return element("p", f"A formula of {len(text)} characters; derive gives it.", class_="note")


def pictures(study: Study) -> Iterator[tuple[str, str]]:
    """Yield name and data URI of each figure whose part could be computed; its words are in the template."""
    figures: dict[str, tuple[Callable[[Any, Study, Any], None], Any]] = {
        "law": (_law, study.law),
        "plane": (_plane, study.plane),
        "time": (_time, study.motion),
        "phase": (_phase_plane, study.regime),
    }
    for name, (draw, part) in figures.items():
        if part is not None:
            with styled():
                figure, axes = new_figure(_SCALE * FIGURE_WIDTH, _SCALE * FIGURE_HEIGHT)
                draw(axes[0, 0], study, part)
                yield name, svg_uri(figure)


def _law(ax: Any, study: Study, law: FrictionLaw) -> None:
    V = study.oscillator.V
    fit = study.fit
    measured = study.measured
    top = max(2.2 * V, 0.0 if measured is None else float(measured.v[-1]))
    if law.v_max is not None:
        top = min(top, float(law.v_max))
    span: Look = {"facecolor": "0.93", "edgecolor": "0.8", "linewidth": 0.6, "zorder": 0}
    ax.axvspan(0, min(2 * V, top), label="0 to $2V$", **span)
    ax.axvline(V, color="black", linestyle=":", linewidth=1, label="belt speed $V$")
    if fit is not None:
        bounds = fit.band
    elif law.uncertain:
        bounds = partial(error_band, law)
    else:
        bounds = None
    draw_law(ax, law, top, measured, bounds, r"$\mu(v)$")


def _plane(ax: Any, study: Study, thresholds: Plane) -> None:
    spread = {name: NORMAL * (study.standard_error(name) or 0.0) for name in "Vc"}
    draw_plane(ax, thresholds, study.oscillator, spread)


def _time(ax: Any, study: Study, motion: Trajectory) -> None:
    end = motion.stretches[-1].end
    motion.draw(ax)
    ax.axhline(study.oscillator.V, color="black", linestyle=":", linewidth=0.8, zorder=0, label="belt speed")
    ax.legend(loc="lower right", ncols=2)
    finish(ax, xlabel="time $t$ (s)", ylabel=r"velocity $\dot x$ (m/s)", xlim=(0, end))
    low, high = ax.get_ylim()
    ax.set_ylim(low - 0.22 * (high - low), high)  # for the legend


def _phase_plane(ax: Any, study: Study, motions: Regime) -> None:
    handles = motions.draw(ax)
    if study.motion is not None:
        state = study.motion.at(np.linspace(0, study.motion.stretches[-1].end, MOST_DRAWN))
        reach = max([REACH * study.oscillator.V, *(1.2 * cycle.amplitude for cycle in motions.cycles)])
        shown = np.logical_and.accumulate(np.abs(state.v) <= reach)
        line = {"color": "0.7", "linewidth": 0.7, "zorder": 0, "label": "motion over time"}
        handles += ax.plot(state.x[shown], state.v[shown], **line)
    finish(ax)
    ax.legend(handles=handles, **ABOVE)
