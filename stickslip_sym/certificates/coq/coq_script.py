"""A closed form as a script for the proof assistant Coq: `coq_script(form)`."""

from collections.abc import Sequence

from stickslip_sym.certificates.coq.equilibrium import Slope
from stickslip_sym.certificates.coq.harmonic import Harmonic
from stickslip_sym.certificates.coq.integral import Integral
from stickslip_sym.certificates.coq.printer import Unsupported
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.remedies import Name
from stickslip_sym.formula.closed_form import ClosedForm


def coq_script(form: ClosedForm) -> str:
    """Return a script that proves a closed form, and needs Coq and Coquelicot only.

    Raises
    ------
    InputError
        If it needs a construct that the scripts do not have; the message names it.
    """
    criterion = form.criterion
    if form.law.curve is not None:
        raise Unsupported(
            "a script in Coq is for laws with a formula, and not for a curve through measured points"
        )
    if form.origin is not None:
        raise Unsupported("a script in Coq is for a criterion of a law, and not for its derivative by a parameter")
    if criterion.weight is None:
        return Slope(form).text()
    if not criterion.is_polynomial:
        return Harmonic(form).text()
    return Integral(form).text()


def coq_script_of_one(forms: Sequence[ClosedForm]) -> str:
    """Return the script of one closed form; refuse more, each of which needs a file of its own."""
    if len(forms) != 1:
        listed = ", ".join(f"{form.law.name or form.law.text} {form.criterion.name}" for form in forms)
        raise InputError(
            f"a file in Coq holds one proof, and this would be {len(forms)}: {listed}; name one law and one ",
            Name("criterion"),
        )
    return coq_script(forms[0])
