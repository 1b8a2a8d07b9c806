"""What the paper prints, as data: formulas, numbers, and what it says of them.

A check takes its own entry and holds it against what we compute. Any datum replaced by another must make
that check come to another verdict; `tests/whole/test_mutations.py` sees to it, for every one.
"""

from typing import Any

import sympy as sp

from derivations import paper
from stickslip_sym.core.symbols import N, V, c, k, m

displacement, acceleration, relative = sp.symbols("x xddot v_r", real=True)
kinetic = sp.Symbol("mu", positive=True)
"""The coefficient mu(v_r) of (2); the velocity is `paper.velocity`."""

_equations = paper.equations()
_mu_s, _mu_m, _v_m = (paper.polynomial[name] for name in ("mu_s", "mu_m", "v_m"))
_equilibrium = {
    "exponential": N * (_mu_s - _mu_m) * paper.exponential["alpha"] * sp.exp(-paper.exponential["alpha"] * V),
    "polynomial": 3 * N * (_mu_s - _mu_m) * (_v_m**2 - V**2) / (2 * _v_m**3),
}
_thomsen_fidlin = 3 * N * (_mu_s - _mu_m) * (4 * _v_m**2 - 5 * V**2) / (8 * _v_m**3)


def _of(*labels: str) -> dict[str, Any]:
    """Return equations by their numbers."""
    return {label: _equations[label] for label in labels}


def _motions(pure_slip: str) -> dict[str, Any]:
    """Return what Fig. 3 or 4 shows."""
    return {
        "dampings": ("0", "1", "2", pure_slip, "3.5"),
        "motions": (*["stick-slip"] * 3, "pure slip", "damped slip"),
        "stick": "falls",
        "period": "falls",
        "amplitude": "constant",
    }


PRINTED: dict[str, dict[str, Any]] = {
    "E1": {"velocity": V, "force": c * paper.velocity + k * displacement, "limit": _mu_s * N},
    "E2": {
        "left": m * acceleration + c * paper.velocity + k * displacement,
        "right": -sp.sign(relative) * kinetic * N,
    },
    "E3": {**_of("(3)"), "start": _mu_s, "end": _mu_m, "between": "falls"},
    "E4": {**_of("(4)"), "start": _mu_s, "lowest": _mu_m, "at": _v_m, "before": "falls", "after": "rises"},
    "E5": {**_of("(5)"), "(6)": sp.S.Zero},
    "E7": {"(7)": "negative"},
    "E9": _of("(8)", "(9)"),
    "E10": _of("(10)"),
    "E11": _of("(11)"),
    "E13": _of("(12)", "(13)"),
    "E15": {**_of("(15) a", "(15) b"), "extremum": "minimum"},
    "E16": _of("(16)"),
    "E17": _of("(17)"),
    "E18": _of("(18)"),
    "N1": {"dampings": ("0", "1", "2", "2.574", "3.5"), "ratios": ("0", "0.05", "0.1", "0.1287", "0.175")},
    "N2": {"c": "2.574"},
    "N3": {"c": "3.038"},
    "N4": {"ratio": "21/26", "rounded": "0.9"},
    "F3": _motions("2.574"),
    "F4": _motions("3.038"),
    "F5": {"coincide": {"2": True, "2.574": True, "3.5": False}, "amplitudes": "fall"},
    "F6": {**_of("(17)"), "equilibrium": _equilibrium["exponential"], "closer": "(17)"},
    "F7": {
        **_of("(18)"),
        "equilibrium": _equilibrium["polynomial"],
        "Thomsen & Fidlin": _thomsen_fidlin,
        "closest": "(18)",
    },
    "F8": {"c": "2", "A": ("0.5", "stick-slip"), "B": ("0.8", "damped slip")},
    "F9": {"c": "2", "C": ("0.5", "stick-slip"), "D": ("0.8", "damped slip")},
    "F10": {"mu_m": ("0.2", "0.3", "0.4"), "region": "falls"},
    "S1": _of("(16)", "(17)", "(18)"),
    "S2": {"power of the frequency": 0, "power of k": 0},
    "S3": {"lowest": -V, "motion": "harmonic"},
    "S4": {**_of("(17)", "(18)"), "with V": "falls"},
    "S5": {**_of("(17)"), "transition speed": sp.oo, "without damping": "stick-slip"},
    "S6": {**_of("(18)"), "speed": "0.9", "faster": "no stick-slip"},
    "S7": {"below": "stick-slip", "above": "slip", "width of pure slip": 0},
    "S8": {"c": "2.574", "change in a period": 0},
    "S9": {**_of("(17)", "(18)"), "with mu_s - mu_m": "rises"},
    "S10": {"equilibrium": _equilibrium, "error with amplitude": "rises"},
    "S11": {"nonlinear coefficient": "no closed form"},
}
"""Claim to what it says, by the name of each datum."""
