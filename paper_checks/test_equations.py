"""Checks E1 to E18: the paper's equations."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

from derivations import chapter, paper
from paper_checks.conftest import Find, oscillator
from stickslip_sym import Derivation, FrictionLaw, Phase, Status, Trajectory, simulate
from stickslip_sym.normal_form import normal_form
from stickslip_sym.proving import prove_positive
from stickslip_sym.symbols import u

DAMPINGS = (0.0, 1.0, 2.0)
FORCE_TOLERANCE = 1e-9  # of the friction force, relative to mu_s N; the integration runs at 1e-12


def motions(law: FrictionLaw) -> list[tuple[float, Trajectory]]:
    """Simulate ten periods at three dampings, from the paper's start and from the far side of the belt."""
    starts = ((0.0, None), (-0.2, 1.5))
    return [
        (c, simulate(law, oscillator(c), t_end=6.3, rtol=1e-12, x0=x0, v0=v0))
        for c in DAMPINGS
        for x0, v0 in starts
    ]


@pytest.mark.claim("E1")
def test_E1_stick(find: Find, exponential: FrictionLaw, polynomial: FrictionLaw) -> None:
    """In stick the velocity is the belt's, static friction holds, and stick ends where it cannot."""
    worst_speed, worst_force, worst_onset, sticks = 0.0, 0.0, 0.0, 0
    for law in (exponential, polynomial):
        limit = law.mu(0.0) * oscillator().N
        for c, motion in motions(law):
            held = motion.phase == Phase.STICK
            sticks += int(held.sum())
            force = np.abs(c * motion.v + oscillator().k * motion.x) / limit
            worst_speed = max(worst_speed, float(np.max(np.abs(motion.v[held] - oscillator().V))))
            worst_force = max(worst_force, float(np.max(force[held])))
            onsets = [new for old, new in pairwise(motion.events) if old.begins is Phase.STICK]
            worst_onset = max([worst_onset, *(abs((c * e.v + oscillator().k * e.x) / limit - 1) for e in onsets)])
    find(
        ours=f"|f| <= {worst_force:.10f} mu_s N",
        evidence=f"over {sticks} samples of stick |x' - V| = {worst_speed:g} m/s, "
        f"|f| at most {worst_force:.12f} mu_s N, and at every onset of slip f = mu_s N to {worst_onset:.1e}",
        reproduced=sticks > 0
        and worst_speed == 0
        and worst_force <= 1 + FORCE_TOLERANCE
        and worst_onset < FORCE_TOLERANCE,
    )


@pytest.mark.claim("E2")
def test_E2_slip(find: Find, exponential: FrictionLaw, polynomial: FrictionLaw) -> None:
    """Between events the simulated motion solves (2), as an integrator that knows no events solves it."""
    worst, pieces, sides = 0.0, 0, set()
    for law in (exponential, polynomial):
        for c, motion in motions(law):
            for start, stop in pairwise(motion.events[:12]):
                if start.begins is Phase.STICK:
                    continue
                side = -1.0 if start.begins is Phase.SLIP_BACK else 1.0
                sides.add(side)
                end = slip_by_equation_2(law, c, side, start.t, stop.t, (start.x, start.v))
                error = max(abs(end[0] - stop.x) / 0.1, abs(end[1] - stop.v) / oscillator().V)
                worst, pieces = max(worst, float(error)), pieces + 1
    find(
        ours=f"same motion to {worst:.0e}",
        evidence=f"{pieces} slip phases, v_r of both signs, end where LSODA takes the same onset, to {worst:.1e}",
        reproduced=worst < 1e-8 and sides == {-1.0, 1.0},
    )


def slip_by_equation_2(
    law: FrictionLaw, c: float, side: float, start: float, stop: float, state: tuple[float, float]
) -> Any:
    """Integrate (2) for one sign of v_r, f = -sgn(v_r) mu(v_r) N, by a multistep method."""
    scene = oscillator(c)

    def rates(_: float, y: Any) -> list[float]:
        relative = y[1] - scene.V
        friction = -side * law.mu(max(side * relative, 0.0)) * scene.N
        return [y[1], (friction - c * y[1] - scene.k * y[0]) / scene.m]

    return solve_ivp(rates, (start, stop), state, method="LSODA", rtol=1e-11, atol=1e-13).y[:, -1]


@pytest.mark.claim("E3")
def test_E3_exponential_law(find: Find) -> None:
    """The law (3) starts at mu_s, falls everywhere and tends to mu_m."""
    mu = paper.equations()["(3)"]
    mu_s, mu_m = (paper.exponential[name] for name in ("mu_s", "mu_m"))
    start, end = mu.subs(u, 0), sp.limit(mu, u, sp.oo)
    difference = sp.Symbol("D", positive=True)
    falls = prove_positive(-sp.diff(mu, u).subs(mu_s, mu_m + difference))
    find(
        ours=f"{start} to {end}",
        evidence=f"mu(0) = {start}, mu(oo) = {end}; -mu' > 0 with mu_s = mu_m + D, D > 0: {falls}",
        reproduced=normal_form(start - mu_s) == 0
        and normal_form(end - mu_m) == 0
        and falls.status is Status.PROVED,
    )


@pytest.mark.claim("E4")
def test_E4_polynomial_law(find: Find) -> None:
    """The law (4) starts at mu_s, falls to mu_m at v_m, and rises beyond."""
    mu = paper.equations()["(4)"]
    mu_s, mu_m, v_m = (paper.polynomial[name] for name in ("mu_s", "mu_m", "v_m"))
    start, lowest = mu.subs(u, 0), mu.subs(u, v_m)
    difference, p = sp.symbols("D p", positive=True)
    slope = sp.diff(mu, u).subs(mu_s, mu_m + difference)
    before = prove_positive(sp.factor(-slope.subs(u, v_m / (1 + p))))
    after = prove_positive(sp.factor(slope.subs(u, v_m * (1 + p))))
    find(
        ours=f"{sp.simplify(lowest)} at v_m",
        evidence=f"mu(0) = {start}, mu(v_m) = {sp.simplify(lowest)}; falls at v_m/(1 + p): {before}; "
        f"rises at v_m (1 + p), p > 0: {after}",
        reproduced=normal_form(start - mu_s) == 0
        and normal_form(lowest - mu_m) == 0
        and before.status is after.status is Status.PROVED,
    )


CHAPTER_OF = {
    "E5": ("energy_balance", "(5)", "(6)"),
    "E7": ("energy_balance", "(7)"),
    "E9": ("linearised_force", "(9)"),
    "E10": ("linearised_force", "(10)"),
    "E11": ("linearised_force", "(11)"),
    "E13": ("least_squares", "(13)"),
    "E15": ("least_squares", "(15) a", "(15) b"),
    "E16": ("least_squares", "(16)"),
    "E17": ("exponential_law", "(17)"),
    "E18": ("polynomial_law", "(18)"),
}


@pytest.mark.parametrize(
    "where", [pytest.param(where, id=id, marks=pytest.mark.claim(id)) for id, where in CHAPTER_OF.items()]
)
def test_equation(find: Find, where: tuple[str, ...]) -> None:
    """The steps that lead to a printed equation, and their whole chapter, are PROVED."""
    name, *labels = where
    derivation: Derivation = chapter(name)({})
    verdicts = [derivation[label].verdict for label in labels]
    find(
        ours=f"{', '.join(labels)} {derivation.status.value}",
        evidence=f"{len(derivation.steps)} steps of {name}; " + "; ".join(map(str, verdicts)),
        reproduced=derivation.status is Status.PROVED and all(v.status is Status.PROVED for v in verdicts),
    )
