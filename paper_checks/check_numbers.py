"""Checks N1 to N4: the paper's numbers."""

from decimal import Decimal
from functools import cache
from typing import Any

import numpy as np
import sympy as sp
from scipy.optimize import brentq

from derivations import chapter
from paper_checks.computed import law, oscillator, threshold
from paper_checks.findings import Find, Finding, Printed, check
from stickslip_sym import Status, peak_velocity, pure_slip_damping
from stickslip_sym.comparison.tradeoff import BAND_ABOVE_REST, pure_slip_by_scan
from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.motion.thresholds.threshold import Threshold

SCAN_STEP = 0.001  # kg/s
AGREE = 1e-8  # kg/s between thresholds by simulation and by collocation, which share no code
MOST_SCANNED = 6.0  # kg/s
NEAR = 0.05  # kg/s: beyond, some dampings show that the mass comes back below and nowhere above


@check("N1")
def damping_ratios(find: Find, printed: Printed) -> Finding:
    """c/(2 sqrt(k m)), rounded to the digits that the paper prints."""
    stated = [Decimal(text) for text in printed["ratios"]]
    ratios = [oscillator(float(c)).zeta for c in printed["dampings"]]
    return find(
        ours=" ".join(f"{ratio:.6g}" for ratio in ratios),
        holds="the damping ratios are those printed",
        proved=f"c/(2 sqrt(k m)) has the printed digits for c = {', '.join(printed['dampings'])} kg/s",
        difference="0 in the digits printed",
        reproduced=[Decimal(ratio).quantize(p) for ratio, p in zip(ratios, stated, strict=True)] == stated,
    )


def near_and_far(exact: float) -> FloatArray:
    """Return the dampings of the scan: each multiple of `SCAN_STEP` near the exact one, and some far from it."""
    near = np.arange(exact - NEAR, exact + NEAR, SCAN_STEP)
    far = np.arange(0.0, MOST_SCANNED + NEAR, NEAR)
    return np.unique(np.round(np.append(near, far), 3))


@cache
def pure_slip(name: str) -> tuple[float, Threshold[float], float]:
    """Return the damping of the scan, the proved one of the graze, and that of a peak at the band's edge."""
    osc = oscillator()
    quantities = {"V": osc.V, "N": osc.N, "m": osc.m, "k": osc.k}
    given: dict[str, Any] = {quantity: repr(value) for quantity, value in quantities.items()}
    proved = pure_slip_damping(law(name), **given, method="proof", rtol=1e-15)
    scan = pure_slip_by_scan(law(name), osc, near_and_far(float(proved.value)))
    return scan, proved, peaks_at(name, osc.V - BAND_ABOVE_REST)


def peaks_at(name: str, velocity: float) -> float:
    """Return the damping in kg/s at which the slip from P next peaks at a velocity near the belt's."""
    return float(brentq(lambda c: peak_velocity(law(name), oscillator(c)) - velocity, 2.0, 4.0, xtol=1e-11))


@check("N2", name="exponential")
@check("N3", name="polynomial")
def pure_slip_damping_of(find: Find, printed: Printed, *, name: str) -> Finding:
    """Hold a printed threshold against the paper's procedure, the exact threshold and the band's effect.

    The procedure takes |v_r| <= 1e-4 m/s for stick, so it finds the damping at which the velocity peaks
    that much below the belt speed; and it reports the next multiple of 0.001 kg/s.
    """
    stated = float(printed["c"])
    scanned, proved, banded = pure_slip(name)
    exact, enclosure = float(proved.value), proved.enclosure
    assert enclosure is not None
    side = "above" if stated > enclosure.high else "below" if stated < enclosure.low else "at"
    apart = max(abs(exact - threshold(name)), abs(peaks_at(name, oscillator().V) - exact))
    agree = apart < AGREE and exact in enclosure
    return find(
        ours=f"scan {scanned:.3f}, exact {exact:.6f}",
        holds=f"{stated:g} kg/s is what the paper's procedure gives, and it is {side} the threshold"
        + (", to its last digit" if 0 <= stated - exact <= SCAN_STEP else " by more than its last digit"),
        proved=f"{stated:g} kg/s is {side} the threshold, which is {enclosure} kg/s",
        checked=f"the scan gives {scanned:.3f} kg/s; simulated peaks and collocation of the grazing orbit give "
        f"thresholds {apart:.0e} kg/s apart",
        estimated=f"the orbit that peaks {BAND_ABOVE_REST:g} m/s below the belt's speed has c = {banded:.6f}, "
        f"{banded - exact:.6f} kg/s higher; the scan reports the next multiple of {SCAN_STEP:g} kg/s",
        difference=f"{stated - exact:+.6f} kg/s from the exact threshold",
        reproduced=agree and scanned == stated and 0 <= stated - exact <= SCAN_STEP,
        qualified=agree and scanned == stated and 0 <= stated - banded <= SCAN_STEP,
    )


@check("N4")
def transition_speed(find: Find, printed: Printed) -> Finding:
    """(18) vanishes at sqrt(21/26) v_m and nowhere else, and that is 0.9 v_m to one digit."""
    ratio = sp.sqrt(sp.Rational(printed["ratio"]))
    rounded = Decimal(printed["rounded"])
    derivation = chapter("polynomial_law")({"transition speed": ratio * sp.Symbol("v_m", positive=True)})
    step = derivation["transition speed"]
    return find(
        ours=f"{float(ratio):.6f}",
        holds="(18) vanishes at this speed and at no other, and its rounded value is right to one digit",
        proved=f"{step.operation}: {step.verdict}; sqrt({printed['ratio']}) = {float(ratio):.8f}",
        difference=f"{float(ratio) - float(rounded):+.4f} from the rounded value",
        reproduced=derivation.status is Status.PROVED and Decimal(float(ratio)).quantize(rounded) == rounded,
    )
