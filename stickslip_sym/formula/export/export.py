"""Closed forms as files for others: LaTeX, Python, C and Octave. JSON is `keeping`'s."""

import re
from collections.abc import Mapping, Sequence

from stickslip_sym.core.errors import InputError
from stickslip_sym.formula.code import writer
from stickslip_sym.formula.derivation.closed_form import ClosedForm
from stickslip_sym.formula.evaluation.averages import SlopeAverage
from stickslip_sym.formula.evaluation.stable import StableFunction
from stickslip_sym.formula.export.document import chapters, document
from stickslip_sym.model.law import FrictionLaw

__all__ = ["export_c", "export_code", "export_latex", "export_octave", "export_python"]


def export_latex(
    forms: ClosedForm | Sequence[ClosedForm],
    *,
    symbols: Mapping[str, str] | None = None,
    fragment: bool = False,
    steps: bool = False,
    missing: Sequence[tuple[FrictionLaw, str, str]] = (),
    time_limit: float = 5.0,
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
    time_limit : float
        Seconds that SymPy may take for the limits of one criterion, where rules do not serve.

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
    return document(
        listed, given=symbols or {}, fragment=fragment, steps=steps, missing=missing, time_limit=time_limit
    )


Written = ClosedForm | SlopeAverage
"""What can be written as code: a closed form, or the fast function of a criterion that has none."""


def export_code(forms: Written | Sequence[Written], language: str) -> str:
    """Return text of a language: one form as ``damping``, several as ``damping_<law>_<criterion>``.

    Parameters
    ----------
    forms : ClosedForm, SlopeAverage, or a sequence of them
    language : str
        "python", "c", "octave", or the name of one that was registered.

    Raises
    ------
    InputError
        If there is no such language, nothing to write, or two functions would have one name.
    """
    return writer.code(*_named(forms), language)


def export_python(forms: Written | Sequence[Written]) -> str:
    """Return a NumPy module, as `export_code` does."""
    return export_code(forms, "python")


def export_c(forms: Written | Sequence[Written]) -> str:
    """Return C99 that needs libm only, as `export_code` does."""
    return export_code(forms, "c")


def export_octave(forms: Written | Sequence[Written]) -> str:
    """Return an Octave script that defines functions, as `export_code` does."""
    return export_code(forms, "octave")


_NOTHING = "there is nothing to export; give at least one closed form"


def _named(forms: Written | Sequence[Written]) -> tuple[dict[str, StableFunction], str]:
    """Return the functions by the names that they shall have, and a title."""
    listed = [forms] if isinstance(forms, Written) else list(forms)
    if not listed:
        raise InputError(_NOTHING)
    if len(listed) == 1:
        return {"damping": listed[0].function}, repr(listed[0])
    found = {}
    for number, (law, group) in enumerate(chapters(listed), 1):
        for form in group:
            label = re.sub(r"\W+", "_", law.name or "", flags=re.ASCII).strip("_") or f"law_{number}"
            name = f"damping_{label}_{form.criterion.label}"
            if name in found:
                raise InputError(f"two of the forms would both be called {name}; give the laws different names")
            found[name] = form.function
    return found, f"{len(found)} damping criteria"
