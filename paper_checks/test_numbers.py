"""Checks N1 to N4: the paper's numbers."""

from decimal import Decimal

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import brentq

from derivations import chapter
from paper_checks.claims import CLAIMS
from paper_checks.conftest import Find, oscillator
from stickslip_sym import FrictionLaw, Status, peak_velocity, pure_slip_damping
from stickslip_sym.newmark import Scan, pure_slip_by_scan

SCAN_STEP = 0.001  # kg/s


@pytest.mark.claim("N1")
def test_N1_damping_ratios(find: Find) -> None:
    """c/(2 sqrt(k m)), rounded to the digits that the paper prints."""
    printed = [Decimal(text) for text in CLAIMS["N1"].paper.split()]
    ratios = [oscillator(c).zeta for c in (0.0, 1.0, 2.0, 2.574, 3.5)]
    find(
        ours=" ".join(f"{ratio:.6g}" for ratio in ratios),
        evidence="c/(2 sqrt(k m)) for c = 0, 1, 2, 2.574, 3.5 kg/s, to the digits printed",
        reproduced=[Decimal(ratio).quantize(p) for ratio, p in zip(ratios, printed, strict=True)] == printed,
    )


@pytest.mark.claim("N2")
def test_N2_exponential_law(find: Find, exponential: FrictionLaw) -> None:
    """The scan gives the paper's number, and so does the exact threshold to the scan's resolution."""
    check_pure_slip(find, exponential, float(CLAIMS["N2"].paper))


@pytest.mark.claim("N3")
def test_N3_polynomial_law(find: Find, polynomial: FrictionLaw) -> None:
    """The scan gives the paper's number; the exact threshold is lower, and the band says by how much."""
    check_pure_slip(find, polynomial, float(CLAIMS["N3"].paper))


def check_pure_slip(find: Find, law: FrictionLaw, printed: float) -> None:
    """Hold a printed threshold against the paper's procedure, the exact threshold and the band's effect.

    The procedure takes |v_r| <= 1e-4 m/s for stick, so it finds the damping at which the velocity peaks
    that much below the belt speed; and it reports the next multiple of 0.001 kg/s.
    """
    scene = oscillator()
    scan = Scan(np.round(np.arange(0.0, 6.0 + SCAN_STEP / 2, SCAN_STEP), 3))
    scanned = pure_slip_by_scan(law, scene, scan)
    exact = pure_slip_damping(law, V=scene.V, N=scene.N, m=scene.m, k=scene.k, method="simulation", rtol=1e-11)
    banded = brentq(
        lambda c: peak_velocity(law, oscillator(c)) - (scene.V - scan.band),
        exact.value,
        exact.value + 0.1,
        xtol=1e-10,
    )
    find(
        ours=f"scan {scanned:.3f}, exact {exact.value:.6f}",
        evidence=f"the scan gives {scanned:.3f} kg/s; the orbit that grazes the belt's speed has "
        f"c = {exact.value:.9f}, the one that peaks {scan.band:g} m/s below it c = {banded:.6f}, "
        f"{banded - exact.value:.6f} kg/s higher; the scan reports the next multiple of {SCAN_STEP:g} kg/s",
        reproduced=scanned == printed and 0 <= printed - exact.value <= SCAN_STEP,
        qualified=scanned == printed and 0 <= printed - banded <= SCAN_STEP,
    )


@pytest.mark.claim("N4")
def test_N4_transition_speed(find: Find) -> None:
    """(18) vanishes at sqrt(21/26) v_m and nowhere else, and that is 0.9 v_m to one digit."""
    exact, rounded = CLAIMS["N4"].paper.removeprefix("sqrt(").split(") = ")
    ratio = sp.sqrt(sp.Rational(exact))
    v_m = sp.Symbol("v_m", positive=True)
    derivation = chapter("polynomial_law")({"transition speed": ratio * v_m})
    step = derivation["transition speed"]
    find(
        ours=f"{float(ratio):.6f}",
        evidence=f"{step.operation}: {step.verdict}; sqrt(21/26) = {float(ratio):.8f}",
        reproduced=derivation.status is Status.PROVED and Decimal(f"{float(ratio):.1f}") == Decimal(rounded),
    )
