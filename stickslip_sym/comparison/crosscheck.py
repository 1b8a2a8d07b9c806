"""One number three ways: the closed form, quadrature of the definition, and the oscillator itself."""

import textwrap
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import mpmath

from stickslip_sym.comparison.deviation import LARGE, reasons, spread
from stickslip_sym.core.aliases import Mpf
from stickslip_sym.core.errors import StickSlipError
from stickslip_sym.core.numbers import Number, exact
from stickslip_sym.criteria import quadrature
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.derivation.closed_form import ClosedForm
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.thresholds.threshold import pure_slip_damping
from stickslip_sym.output.tables import duration, table

__all__ = ["Check", "crosscheck", "report"]

_WIDTH = 100  # characters of a line of text


@dataclass(frozen=True)
class Check:
    """One way to the number."""

    method: str
    value: str  # in kg/s, as many digits as the method gives; or why there is none
    difference: float | None  # relative to the first method that has a value; None where there is none
    seconds: float


def crosscheck(
    law: FrictionLaw, criterion: Criterion, scene: Mapping[str, Number], form: ClosedForm | None, digits: int = 50
) -> list[Check]:
    """Compute a closed form, the quadrature of its definition, and the event-driven threshold.

    - `law`: with all parameters bound.
    - `scene`: values of V, N, m and k in SI units.
    - `form`: of this law and criterion; None where there is none, and quadrature is the reference.
    - `digits`: of the closed form and of the quadrature.

    A method that has no value in this scene says why in its place.
    """
    V, N = scene["V"], scene["N"]
    numbers = {name: float(exact(value, name)) for name, value in scene.items()}
    ways: dict[str, Callable[[], tuple[Mpf, int]]] = {
        f"quadrature, {digits} digits": lambda: (
            quadrature.damping(law, criterion, V=V, N=N, digits=digits),
            digits,
        ),
        "event-driven threshold": lambda: (
            mpmath.mpf(pure_slip_damping(law, **numbers, method="simulation", rtol=1e-12).value),
            12,
        ),
    }
    if form is not None:
        ways = {"closed form": lambda: (form.evaluate(digits, V=V, N=N), digits)} | ways
    checks: list[Check] = []
    values: list[Mpf] = []
    error_of_data = None
    if law.curve is not None:
        error_of_data = spread(law, criterion, numbers["V"], numbers["N"])
    reference = None
    for method, compute in ways.items():
        start = time.perf_counter()
        try:
            value, known = compute()
        except StickSlipError as error:
            checks.append(Check(method, f"none: {error}", None, 0.0))
            continue
        seconds = time.perf_counter() - start
        reference = value if reference is None else reference
        with mpmath.workdps(digits):
            difference = abs(value - reference)
            relative = float(difference / abs(reference)) if reference else float(difference)
        deserved = known if error_of_data is None else min(known, _deserved(value, error_of_data))
        checks.append(Check(method, mpmath.nstr(value, deserved), relative, seconds))
        values.append(value)
    if error_of_data:
        shown = f"the points' scatter alone makes that +-{error_of_data:.1g} kg/s, one standard error (jackknife)"
        checks.append(Check("measured points", shown, None, 0.0))
    last = checks[len(ways) - 1].difference
    if last is not None and last > LARGE and reference:
        for reason in reasons(law, criterion, numbers, float(reference), float(values[-1])):
            checks.append(Check("why the threshold differs", reason, None, 0.0))
    return checks


def _deserved(value: Mpf, error: float) -> int:
    """Return the digits of a value that its standard error leaves, and one more."""
    if not value or not error:
        return 17
    return max(2, 2 + int(mpmath.floor(mpmath.log10(abs(value) / error))))


def report(checks: list[Check]) -> str:
    """Return the checks as a table, and below it, in lines of a readable length, what has no number."""
    rows = [
        [check.method, check.value, f"{check.difference:.2g}", duration(check.seconds)]
        for check in checks
        if check.difference is not None
    ]
    words = [
        textwrap.fill(f"{check.method}: {check.value}", _WIDTH, subsequent_indent="  ", break_long_words=False)
        for check in checks
        if check.difference is None
    ]
    return "\n".join([table(["method", "c in kg/s", "difference", "time"], rows), *words])
