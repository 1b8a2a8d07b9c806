"""One number three ways: the closed form, quadrature of the definition, and the oscillator itself."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import mpmath

from stickslip_sym import quadrature
from stickslip_sym.closed_form import ClosedForm
from stickslip_sym.errors import StickSlipError
from stickslip_sym.tables import duration, table
from stickslip_sym.threshold import pure_slip_damping
from stickslip_sym.values import Number, exact

__all__ = ["SCENE", "Check", "crosscheck", "report"]

SCENE = {"V": "0.5", "N": "9.81", "m": "1", "k": "100"}
"""The scene of the paper's section 3, in SI units."""


@dataclass(frozen=True)
class Check:
    """One way to the number.

    Attributes
    ----------
    method : str
    value : str
        In kg/s, as many digits as the method gives; or why there is none.
    difference : float or None
        Relative to the closed form; None where there is no value.
    seconds : float
    """

    method: str
    value: str
    difference: float | None
    seconds: float


def crosscheck(form: ClosedForm, scene: Mapping[str, Number], digits: int = 50) -> list[Check]:
    """Compute a closed form, the quadrature of its definition, and the event-driven threshold.

    Parameters
    ----------
    form : ClosedForm
        Of a law with all parameters bound.
    scene : mapping
        Values of V, N, m and k in SI units.
    digits : int
        Of the closed form and of the quadrature.

    Returns
    -------
    list of Check
        A method that has no value in this scene says why in its place.
    """
    V, N = scene["V"], scene["N"]
    reference, seconds = _timed(lambda: form.evaluate(digits, V=V, N=N))
    checks = [Check("closed form", mpmath.nstr(reference, digits), 0.0, seconds)]

    def add(
        method: str, compute: Callable[[], Any], show: Callable[[Any], str], value: Callable[[Any], Any]
    ) -> None:
        try:
            result, seconds = _timed(compute)
        except StickSlipError as error:
            checks.append(Check(method, f"none: {error}", None, 0.0))
            return
        with mpmath.workdps(digits):
            difference = abs(value(result) - reference)
            relative = float(difference / abs(reference)) if reference else float(difference)
        checks.append(Check(method, show(result), relative, seconds))

    add(
        f"quadrature, {digits} digits",
        lambda: quadrature.damping(form.law, form.criterion, V=V, N=N, digits=digits),
        lambda result: str(mpmath.nstr(result, digits)),
        lambda result: result,
    )
    numbers = {name: float(exact(value, name)) for name, value in scene.items()}
    add(
        "event-driven threshold",
        lambda: pure_slip_damping(form.law, **numbers, method="simulation", rtol=1e-12),
        lambda result: f"{result.value:.12g}",
        lambda result: mpmath.mpf(result.value),
    )
    return checks


def _timed(compute: Callable[[], Any]) -> tuple[Any, float]:
    start = time.perf_counter()
    result = compute()
    return result, time.perf_counter() - start


def report(checks: list[Check]) -> str:
    """Return the checks as a table."""
    rows = [
        [
            check.method,
            check.value,
            "" if check.difference is None else f"{check.difference:.2g}",
            duration(check.seconds) if check.difference is not None else "",
        ]
        for check in checks
    ]
    return table(["method", "c in kg/s", "difference", "time"], rows)
