"""Criteria as text for others: LaTeX, Python, C and Octave."""

import re
from collections.abc import Mapping, Sequence

from stickslip_sym.core.errors import InputError
from stickslip_sym.formula.closed_form import ClosedForm
from stickslip_sym.formula.code import writer
from stickslip_sym.formula.export.document import chapters, document
from stickslip_sym.formula.slope_average import SlopeAverage
from stickslip_sym.model.law import FrictionLaw

__all__ = ["export_code", "export_latex"]


def export_latex(
    forms: ClosedForm | Sequence[ClosedForm],
    *,
    symbols: Mapping[str, str] | None = None,
    fragment: bool = False,
    steps: bool = False,
    missing: Sequence[tuple[FrictionLaw, str, str]] = (),
) -> str:
    r"""Return a LaTeX document about closed forms, or a fragment for ``\input``.

    For each law: its formula, a table of symbols with units, and for each criterion the formula, numbered and
    labelled ``eq:<law>-<criterion>``, its limits for low and high belt speeds, where it vanishes, and how it was
    verified. Formulas are broken to fit a text of 120 mm; each stands as exact text in a comment beside it.

    Parameters
    ----------
    forms : ClosedForm or sequence of ClosedForm
    symbols : mapping of str to str, optional
        Names and the LaTeX that they shall be printed as, e.g. ``{"V": "v_b", "alpha": r"\beta"}``.
    fragment : bool
        Leave out the preamble and the headings.
    steps : bool
        Print every step of the derivations.
    missing : sequence of (FrictionLaw, str, str)
        Laws, criteria that have no closed form for them, and why; the document says so.

    Returns
    -------
    str

    Raises
    ------
    InputError
        For symbols that cannot be used, or a law of measured points, which has no formula to print.
    """
    listed = [forms] if isinstance(forms, ClosedForm) else list(forms)
    if not listed:
        raise InputError(_NOTHING)
    return document(listed, given=symbols or {}, fragment=fragment, steps=steps, missing=missing)


Written = ClosedForm | SlopeAverage
"""What can be written as code: a closed form, or the fast function of a criterion that has none."""


def export_code(forms: Written | Sequence[Written], language: str) -> str:
    """Return text of a language: one form as ``damping``, several as ``damping_<law>_<criterion>``.

    The text holds the branches of a call and needs nothing of this package. It gives NaN where a call refuses.

    Parameters
    ----------
    forms : ClosedForm, SlopeAverage, or a sequence of them
    language : str
        "python", "c" (C99 with libm) or "octave" (MATLAB reads it too).

    Returns
    -------
    str

    Raises
    ------
    InputError
        If there is no such language, nothing to write, two functions would have one name, or a profile has a shape
        without a value: bind it first.

    Examples
    --------
    >>> from stickslip_sym import derive
    >>> export_code(derive("0.4 - 0.1*v"), "c").splitlines()[-2]
    '    return checked(damping_term_0(a), a, "111", HUGE_VAL);'
    """
    listed = [forms] if isinstance(forms, Written) else list(forms)
    if not listed:
        raise InputError(_NOTHING)
    if len(listed) == 1:
        return listed[0].code(language)
    named: dict[str, Written] = {}
    for number, (law, group) in enumerate(chapters(listed), 1):
        for form in group:
            label = re.sub(r"\W+", "_", law.name or "", flags=re.ASCII).strip("_") or f"law_{number}"
            name = f"damping_{label}_{form.criterion.label}"
            if name in named:
                raise InputError(f"two of the forms would both be called {name}; give the laws different names")
            named[name] = form
    functions = {
        name: (form.average if isinstance(form, ClosedForm) else form, repr(form)) for name, form in named.items()
    }
    return writer.code(functions, language)


_NOTHING = "there is nothing to export; give at least one closed form"
