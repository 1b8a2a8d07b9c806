"""What is shown of friction laws: a line, a formula with its parameters, and the picture of mu."""

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import real
from stickslip_sym.core.remedies import Argument
from stickslip_sym.core.uncertain import text_with_error
from stickslip_sym.model.error_band import error_band
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import Catalogue
from stickslip_sym.model.measured.measurements import Measurements
from stickslip_sym.output import printing
from stickslip_sym.output.notation import notation_of
from stickslip_sym.output.tables import SHOWN_CHARACTERS
from stickslip_sym.views import dispatch, markup
from stickslip_sym.views.drawing import BLUE, finish, new_figure, save_drawing, styled
from stickslip_sym.views.measured import draw_rows

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Band = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""From slip speeds to the lower and the upper end of mu."""


@dispatch.one_line.register(FrictionLaw)
def law_in_a_line(law: FrictionLaw) -> str:
    """Return the law's name, formula, and values with their standard errors."""
    errors = {key: f"+/-{value.std_dev:.2g}" for key, value in law.uncertain.items()}
    values = ", ".join(f"{key}={float(value):g}{errors.get(key, '')}" for key, value in law.values.items())
    return f"FrictionLaw({law.name or 'unnamed'}: {law.text}{'; ' + values if values else ''})"


@dispatch.notebook_latex.register(FrictionLaw)
def law_as_latex(law: FrictionLaw) -> str:
    """Return mu(v) as an equation; of measured points, what goes through them."""
    if law.curve is not None:
        return f"$\\mu(v)$: {law.text}"
    return f"$\\displaystyle \\mu(v) = {printing.latex(law.expr)}$"


def _formula_of(law: FrictionLaw) -> markup.Markup:
    return markup.inline_formula(f"\\mu(v) = {printing.latex(law.expr)}")


@dispatch.notebook_html.register(FrictionLaw)
def law_as_html(law: FrictionLaw) -> str:
    """Return the formula, its parameters as a table, and where it comes from."""
    static = None if law.static is None else printing.text(law.static)
    about = {"static coefficient": static, "validity": law.validity, "source": law.source}
    notes = [f"{kind}: {text}" for kind, text in about.items() if text]
    names = notation_of(law.parameters)
    values = {key: f"{float(value):g}" for key, value in law.values.items()}
    values |= {key: text_with_error(error.nominal_value, error.std_dev) for key, error in law.uncertain.items()}
    rows = [
        [markup.inline_formula(names[key]), values.get(key, ""), of.typical or "", of.unit or "", of.meaning]
        for key, of in law.parameters.items()
    ]
    table = []
    if rows:
        table = [markup.html_table(["parameter", "value", "typical", "unit", "meaning"], rows)]
    head = law.text if law.curve is not None else _formula_of(law)
    return markup.block(law.name or "friction law", head, *table, *notes)


@dispatch.notebook_html.register(Catalogue)
def catalogue_as_html(catalogue: Catalogue) -> str:
    """Return a table of the laws."""
    rows = [[name, _formula_of(law), law.source or ""] for name, law in catalogue.items()]
    return markup.block(markup.html_table(["law", "coefficient of friction", "source"], rows))


def draw_law(
    ax: Any, law: FrictionLaw, top: float, measured: Measurements | None, band: Band | None, label: str
) -> None:
    """Draw mu up to a slip speed, with the 95 % band that a function of speeds gives, and what was measured."""
    v = np.unique([*np.linspace(0, top, 300), *np.geomspace(1e-4, 1, 100) * top])[1:]
    if measured is not None:
        draw_rows(ax, measured, measured.mu)
    if band is not None:
        ax.fill_between(v, *band(v), color="#56B4E9", alpha=0.45, linewidth=0, label="95 % band")
    ax.plot(v, law.at_speeds(v), color=BLUE, linewidth=1.6, label=label[:SHOWN_CHARACTERS])
    ax.legend(loc="best")
    finish(ax, xlabel="slip speed $v$ (m/s)", ylabel=r"coefficient of friction $\mu$", xlim=(0, top))


@dispatch.plot.register(FrictionLaw)
def plot_law(law: FrictionLaw, path: str | Path | None, ax: "Axes | None", v_max: float) -> "Figure":
    """Draw a law on its own, as `FrictionLaw.plot` does."""
    law.require_values()
    top = real("v_max", v_max)
    if not 0 < top < math.inf:
        raise InputError(
            f"v_max = {top:g} is no slip speed; give the highest one in m/s, as ", Argument("v_max", 1.0)
        )
    band = partial(error_band, law) if law.uncertain else None
    with styled():
        if ax is None:
            _, axes = new_figure()
            ax = axes[0, 0]
        draw_law(ax, law, top, None, band, law.name or law.text)
        figure: Any = ax.figure
        if path is not None:
            save_drawing(figure, Path(path))
    return figure  # type: ignore[no-any-return]
