"""The page of a study: what its template asks for beside the study itself."""

import math
from pathlib import Path
from typing import TYPE_CHECKING

import sympy as sp

from stickslip_sym.comparison.study.pictures import ALT, CAPTIONS, pictures
from stickslip_sym.core import symbols
from stickslip_sym.core.errors import StickSlipError
from stickslip_sym.core.symbols import QUANTITIES
from stickslip_sym.formula.closed_form import ClosedForm
from stickslip_sym.motion.thresholds.threshold import Threshold
from stickslip_sym.output import printing
from stickslip_sym.output.page.elements import Html, element
from stickslip_sym.output.page.render import equation, render, with_error
from stickslip_sym.output.tables import duration

if TYPE_CHECKING:
    from stickslip_sym.comparison.study.study import Study

__all__ = ["LEAST", "REACH", "page"]

REACH = 3.0
"""Times a value, and its inverse: where margins are sought; no decision turns on those beyond."""
LEAST = 0.001
"""A probability below it is not told from 0."""
_TEMPLATE = Path(__file__).with_name("study.html")
_WIDEST = 260  # characters of a formula as text, up to which it fits a sheet when it is set
_LONGEST = 1500  # characters that are shown at all
_LONGEST_NAME = 80  # characters of a heading
_DIGITS = 10  # of a value, at most


def page(study: "Study") -> str:
    """Return the whole page."""
    title = study.title if len(study.title) <= _LONGEST_NAME else f"{study.title[: _LONGEST_NAME - 1]}…"
    return render(
        _TEMPLATE,
        title=f"Stick–slip study: {title}",
        study=study,
        state=_state(study),
        value=lambda name: with_error(study.value(name), study.standard_error(name)),
        number_of=study.value,
        error_of=study.standard_error,
        uncertain=[one.name for one in study.margins.rows if study.standard_error(one.name)]
        if study.margins
        else [],
        units=QUANTITIES,
        digits=_digits,
        duration=duration,
        reach=REACH,
        least=LEAST,
        figures=[(key, uri, ALT[key], CAPTIONS[key]) for key, uri in pictures(study).items()],
        slopes=_slopes(study),
        formulas=_formulas(study),
        time=f"{study.time} in {study.seconds:.1f} s",
    )


def _state(study: "Study") -> str:
    if study.regime is None or study.regime.coexist:
        return "either"
    return "rests" if study.regime.stick_slip is None else "sticks"


def _digits(found: Threshold) -> int:
    """Return the digits of a threshold that its own error leaves."""
    error = found.relative_error
    return _DIGITS if not error else min(max(1 - math.floor(math.log10(error)), 2), _DIGITS)


def _slopes(study: "Study") -> object:
    """Return how the threshold changes with each quantity and parameter, or why that is not known."""
    if study.threshold is None:
        return "There is no threshold here."
    try:
        return study.threshold.sensitivity
    except StickSlipError as error:
        return f"Not found: {error}"


def _formulas(study: "Study") -> list[tuple[str, str, str]]:
    law = study.law
    parts: list[tuple[str, str, str]] = (
        []
        if law.curve is not None
        else [("law", _formula(sp.Function("mu")(symbols.v), law.expr), "friction law")]
    )
    for criterion, form in study.forms.items():
        name = criterion.replace("_", " ")
        if isinstance(form, ClosedForm):
            about = f"{name}, {form.verdict.status.value}: {form.verdict.evidence}"
            parts.append((criterion, _formula(symbols.c, form.expr), about))
        else:
            parts.append((criterion, "", f"{name}: {form}"))
    return parts


def _formula(left: sp.Expr, expr: sp.Expr) -> Html:
    text = printing.text(expr)
    if len(text) <= _WIDEST:
        return equation(left, expr)
    if len(text) <= _LONGEST:
        return element("code", f"{printing.text(left)} = {text}")
    return element("p", f"A formula of {len(text)} characters; derive gives it.", class_="note")
