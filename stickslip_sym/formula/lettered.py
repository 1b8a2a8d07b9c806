"""The form of a law in letters, and when it is what a reader is shown."""

from collections.abc import Mapping

import sympy as sp

from stickslip_sym.core.aliases import Expr
from stickslip_sym.formula.closed_form import ClosedForm
from stickslip_sym.output.text_printer import is_decimal

_READABLE = 10**5
"""An integer, or a denominator, that is larger was multiplied together from the numbers of a law."""


def readable(form: ClosedForm) -> tuple[ClosedForm, Mapping[Expr, Expr]]:
    """Return the form to print, and what its letters stand for: that in letters, where numbers make a long mix."""
    if form.general is None or not _is_mixed(form.expr):
        return form, {}
    return form.general, form.meanings


def _is_mixed(expr: Expr) -> bool:
    numbers = [number for number in expr.atoms(sp.Rational) if not is_decimal(number)]
    return any(max(abs(int(number.p)), int(number.q)) > _READABLE for number in numbers)
