"""Checks E1 to E18: the paper's equations."""

from collections.abc import Callable
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import sympy as sp
from scipy.integrate import solve_ivp

from derivations import chapter, paper
from paper_checks.computed import LAWS, law, oscillator
from paper_checks.findings import Find, Finding, Printed, check
from paper_checks.printed import acceleration, displacement, kinetic, relative
from stickslip_sym import Phase, Status, simulate
from stickslip_sym.core.symbols import N, V, c, k, m, u, v
from stickslip_sym.formula.derivation import Derivation
from stickslip_sym.formula.proof.normal_form import normal_form
from stickslip_sym.formula.proof.proving import Verdict, prove_positive
from stickslip_sym.motion.simulation.trajectory import Trajectory

DAMPINGS = (0.0, 1.0, 2.0)
FORCE_TOLERANCE = 1e-9  # of the friction force, relative to mu_s N; the integration runs at 1e-12
SIZE = 0.1  # m, of the motions
SAME = 1e-8  # of a motion's size or the belt speed, between two integrations over a slip phase
FASTEST = 100.0  # m/s, beyond all slip here: a wrong equation must not run away
POINT = {m: 1.0, k: 100.0, V: 0.5, N: 9.81, paper.polynomial["mu_s"]: 0.5, paper.polynomial["mu_m"]: 0.2}
SIGN = {"falls": -1, "rises": 1}


@cache
def motions() -> list[tuple[str, float, Trajectory]]:
    """Simulate ten periods of both laws at three dampings, from two initial conditions."""
    return [
        (name, damping, simulate(law(name), oscillator(damping), t_end=6.3, rtol=1e-12, x0=x0, v0=v0))
        for name in LAWS
        for damping in DAMPINGS
        for x0, v0 in ((0.0, None), (-0.2, 1.5))
    ]


@check("E1")
def stick(find: Find, printed: Printed) -> Finding:
    """In stick the velocity is the belt's, static friction holds, and stick ends where it cannot."""
    velocity, limit = (float(printed[name].subs(POINT)) for name in ("velocity", "limit"))
    force = sp.lambdify((c, displacement, paper.velocity), printed["force"].subs(POINT) / limit)
    worst_speed, worst_force, worst_onset, sticks = 0.0, 0.0, 0.0, 0
    for _, damping, motion in motions():
        held = motion.phase == Phase.STICK
        sticks += int(held.sum())
        worst_speed = max(worst_speed, float(np.max(np.abs(motion.v[held] - velocity))))
        worst_force = max(worst_force, float(np.max(np.abs(force(damping, motion.x, motion.v)[held]))))
        onsets = [new for old, new in pairwise(motion.events) if old.begins is Phase.STICK]
        worst_onset = max([worst_onset, *(abs(force(damping, e.x, e.v) - 1) for e in onsets)])
    return find(
        ours=f"|f| <= {worst_force:.10f} mu_s N",
        holds="in stick the mass has the belt's velocity, and slip begins where static friction cannot hold it",
        checked=f"over {sticks} samples of stick |x' - V| is {worst_speed:g} m/s and |f| at most "
        f"{worst_force:.12f} mu_s N; at every onset of slip f equals mu_s N to {worst_onset:.1e}",
        difference=f"{worst_onset:.0e} of the force",
        reproduced=sticks > 0
        and worst_speed == 0
        and worst_force <= 1 + FORCE_TOLERANCE
        and worst_onset < FORCE_TOLERANCE,
    )


@check("E2")
def slip(find: Find, printed: Printed) -> Finding:
    """Between events the simulated motion solves (2), as an integrator that knows no events solves it."""
    sign = sp.Symbol("sign")
    right = printed["right"].subs(sp.sign(relative), sign)
    (solved,) = sp.solve(printed["left"] - right, acceleration)
    rate = sp.lambdify((displacement, paper.velocity, kinetic, sign, c), solved.subs(POINT))
    worst, pieces, sides = 0.0, 0, set()
    for name, damping, motion in motions():
        for start, stop in pairwise(motion.events[:8]):
            if start.begins is Phase.STICK:
                continue
            side = -1.0 if start.begins is Phase.SLIP_BACK else 1.0
            sides.add(side)
            end = integrated(rate, name, damping, side, (start.t, stop.t), (start.x, start.v))
            error = max(abs(end[0] - stop.x) / SIZE, abs(end[1] - stop.v) / oscillator().V)
            worst, pieces = max(worst, float(error)), pieces + 1
    return find(
        ours=f"same motion to {worst:.0e}",
        holds="simulated slip solves (2) for both signs of the relative velocity",
        checked=f"{pieces} slip phases, v_r of both signs, end where LSODA takes the same onset, to {worst:.1e}",
        difference=f"{worst:.0e} of the motion",
        reproduced=worst < SAME and sides == {-1.0, 1.0},
    )


def integrated(
    rate: Callable[..., float], name: str, damping: float, side: float, times: tuple[float, float], state: Any
) -> Any:
    """Integrate an acceleration for one sign of v_r by a multistep method."""
    # The law from its formula, not from `FrictionLaw.mu`, which the simulation uses.
    mu, belt = sp.lambdify(v, law(name).expr.xreplace(law(name).point), "math"), oscillator().V

    def rates(_: float, y: Any) -> list[float]:
        slip = min(max(side * (y[1] - belt), 0.0), FASTEST)
        return [y[1], rate(y[0], y[1], mu(slip), side, damping)]

    return solve_ivp(rates, times, state, method="LSODA", rtol=1e-11, atol=1e-13).y[:, -1]


def monotone(mu: Any, speed: Any, trend: str) -> Verdict:
    """Prove that mu falls or rises at a speed, where mu_s is above mu_m."""
    difference = sp.Symbol("D", positive=True)
    mu_s, mu_m = (paper.polynomial[name] for name in ("mu_s", "mu_m"))
    slope = sp.diff(mu, u).subs(u, speed).subs(mu_s, mu_m + difference)
    return prove_positive(sp.factor(SIGN[trend] * slope))


@check("E3")
def exponential_law(find: Find, printed: Printed) -> Finding:
    """The law (3) starts at mu_s, falls everywhere and tends to mu_m."""
    mu = printed["(3)"]
    start, end = mu.subs(u, 0), sp.limit(mu, u, sp.oo)
    between = monotone(mu, u, printed["between"])
    return find(
        ours=f"{start} to {end}",
        holds="the law starts, falls and ends as stated",
        proved=f"mu(0) = {start}, mu(oo) = {end}; with mu_s > mu_m it {printed['between']}: {between}",
        difference="0",
        reproduced=normal_form(start - printed["start"]) == 0
        and normal_form(end - printed["end"]) == 0
        and between.status is Status.PROVED,
    )


@check("E4")
def polynomial_law(find: Find, printed: Printed) -> Finding:
    """The law (4) starts at mu_s, falls to mu_m at v_m, and rises beyond."""
    mu, v_m = printed["(4)"], printed["at"]
    start, lowest = mu.subs(u, 0), sp.simplify(mu.subs(u, v_m))
    p = sp.Symbol("p", positive=True)
    before = monotone(mu, v_m / (1 + p), printed["before"])
    after = monotone(mu, v_m * (1 + p), printed["after"])
    return find(
        ours=f"{lowest} at {v_m}",
        holds="the law has its minimum where stated, and falls before and rises after it",
        proved=f"mu(0) = {start}, mu({v_m}) = {lowest}; {printed['before']} at {v_m}/(1 + p): {before}; "
        f"{printed['after']} at {v_m} (1 + p), p > 0: {after}",
        difference="0",
        reproduced=normal_form(start - printed["start"]) == 0
        and normal_form(lowest - printed["lowest"]) == 0
        and before.status is after.status is Status.PROVED,
    )


@cache
def original(name: str) -> Derivation:
    """Return a chapter with the paper's equations."""
    return chapter(name)({})


def by_chapter(
    find: Find, printed: Printed, *, name: str, holds: str, also: Callable[[Printed], bool] = lambda printed: True
) -> Finding:
    """Find that the steps that lead to printed equations, and their whole chapter, are PROVED."""
    equations = paper.equations()
    altered = {label: side for label, side in printed.items() if label in equations and side != equations[label]}
    derivation = chapter(name)(altered) if altered else original(name)
    labels = [step.label for step in derivation.steps if step.label in printed]
    verdicts = "; ".join(str(derivation[label].verdict) for label in labels)
    kind = "proved" if derivation.status is Status.PROVED else "checked"
    return find(
        ours=f"{', '.join(labels)} {derivation.status.value}",
        holds=holds,
        **{kind: f"the chapter {name} has {len(derivation.steps)} steps; {verdicts}"},
        difference="0" if derivation.status is Status.PROVED else derivation.status.value,
        reproduced=also(printed) and bool(labels) and derivation.status is Status.PROVED,
    )


def balance_as_printed(printed: Printed) -> bool:
    """Whether the sum of the works in (6) is the printed one."""
    return bool(original("energy_balance")["(6)"].statement.rhs == printed["(6)"])


def loss_as_printed(printed: Printed) -> bool:
    """Whether the integral of (7) has the printed sign."""
    proved = original("energy_balance")["(7)"].verdict.status is Status.PROVED
    return bool(printed["(7)"] == ("negative" if proved else "not negative"))


def extremum_as_printed(printed: Printed) -> bool:
    """Whether the Hessian of S where the gradient vanishes is that of the printed extremum."""
    steps = [step for step in original("least_squares").steps if "Hessian" in step.operation]
    definite = len(steps) == 2 and all(step.verdict.status is Status.PROVED for step in steps)
    return bool(printed["extremum"] == ("minimum" if definite else "unknown"))


for id, name, holds, more in (
    ("E5", "energy_balance", "the work of friction and damping from P to Q is the change of kinetic energy, at "
     "one place of the mass", {"also": balance_as_printed}),
    ("E7", "energy_balance", "damped slip loses kinetic energy from P to Q, so the integral of (6) is negative",
     {"also": loss_as_printed}),
    ("E9", "linearised_force", "a coefficient linear in v_r makes the friction force that of (9)", {}),
    ("E10", "linearised_force", "the balance of work rearranges to (10)", {}),
    ("E11", "linearised_force", "with the linear coefficient pure slip needs c = a N, and only that", {}),
    ("E13", "least_squares", "the change of variable takes (12) to (13), limits and weight included", {}),
    ("E15", "least_squares", "a and b are as printed, and they are the minimum", {"also": extremum_as_printed}),
    ("E16", "least_squares", "the criterion (16) follows for any mu", {}),
    ("E17", "exponential_law", "the exponential law makes (16) the closed form (17)", {}),
    ("E18", "polynomial_law", "the polynomial law makes (16) the closed form (18)", {}),
):  # fmt: skip
    check(id, name=name, holds=holds, **more)(by_chapter)
