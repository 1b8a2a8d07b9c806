"""Checks S1, S4 to S6 and S9 to S11: what the paper states of its criterion, and of others."""

from decimal import Decimal
from functools import cache

import numpy as np
import sympy as sp
from scipy.optimize import brentq

from derivations import chapter, paper
from paper_checks.computed import (
    AT_05,
    LAWS,
    SPEEDS,
    closed_form,
    is_criterion,
    law,
    oscillator,
    over_speeds,
    sticks_and_slips,
    threshold,
    thresholds,
)
from paper_checks.findings import Find, Finding, Printed, check
from paper_checks.proved import agrees, apart, enclosed, returns_undamped
from paper_checks.wording import by_law, formula, percent
from stickslip_sym import Phase, Status, laws, regime, simulate, slope_average
from stickslip_sym.core.symbols import V, k, m, v
from stickslip_sym.criteria.enclosure import Enclosure
from stickslip_sym.formula.proof.proving import prove_positive
from stickslip_sym.motion.regimes.regime import Regime
from stickslip_sym.motion.simulation.trajectory import Trajectory

NONE = 1e-6  # relative change that the error of the computation explains
SLIGHT = 0.01  # relative error of a criterion that no figure of the paper shows
ERRS = 0.05  # relative error of a criterion that matters
NEARLY = 0.03  # relative difference of the harmonic criterion and the exact threshold on a fast belt
FAST = np.array([100.0, 1000.0])  # m/s, belts so fast that friction is weak
CLOSE = 1e-5  # v_m, half of an interval in which a transition speed is proved to lie
MU_S, MU_M = (paper.polynomial[name] for name in ("mu_s", "mu_m"))
D = sp.Symbol("D", positive=True)
"""The difference of the coefficients, mu_s - mu_m."""


@check("S1")
def mass_and_stiffness(find: Find, printed: Printed) -> Finding:
    """The symbols on which (16), (17) and (18) depend."""
    symbols = {label: ", ".join(sorted(map(str, expr.free_symbols))) for label, expr in printed.items()}
    free = not any(expr.has(m, k) for expr in printed.values())
    return find(
        ours="none" if free else "m or k appears",
        holds=f"mass and stiffness are {'not ' if free else ''}in (16), (17) and (18)",
        proved="; ".join(f"the symbols of {label} are {names}" for label, names in symbols.items()),
        reproduced=free,
    )


@check("S4")
def falls_with_belt_speed(find: Find, printed: Printed) -> Finding:
    """(17) averages a falling slope with a positive weight, (18) has a negative derivative; exact thresholds."""
    curvature = sp.diff(laws.exponential.expr, v, 2).subs(MU_S, MU_M + D)
    proofs = {
        "(17) is (16) for the law (3)": chapter("exponential_law")({"(17)": printed["(17)"]}).status,
        "(16) averages -mu' with a positive weight": chapter("slope_average")({}).status,
        "-mu' of (3) falls with the speed": prove_positive(curvature).status,
        "(18) falls with V": prove_positive(-sp.diff(printed["(18)"], V).subs(MU_S, MU_M + D)).status,
    }
    falls = all(bool((np.diff(thresholds(name)) < 0).all()) for name in LAWS)
    return find(
        ours="falls" if falls else "does not fall",
        holds=f"the pure-slip damping {'falls' if falls else 'does not fall'} with the belt speed, for both laws",
        proved="; ".join(what for what, status in proofs.items() if status is Status.PROVED),
        estimated=f"the exact thresholds {'' if falls else 'do not '}fall over {SPEEDS.size} belt speeds",
        reproduced=all(status is Status.PROVED for status in proofs.values())
        and ("falls" if falls else "rises") == printed["with V"],
    )


@check("S5")
def exponential_law_without_damping(find: Find, printed: Printed) -> Finding:
    """How fast each threshold goes to 0 with V, and whether the undamped mass sticks at every belt speed."""
    name = "exponential"
    at_speed = {
        criterion: slope_average(law(name), criterion)(V=FAST, N=oscillator().N)
        for criterion in ("least_squares", "harmonic")
    }
    at_speed["exact"] = np.array([threshold(name, V=V) for V in FAST])
    proved = [enclosed(name, V=f"{V:g}", rtol=1e-6) for V in FAST]
    above = enclosed(name, V="1").low > 0 and all(one.low > 0 for one in proved)
    powers = {method: float(np.log10(found[1] / found[0])) for method, found in at_speed.items()}
    limit = sp.limit(printed["(17)"].rewrite(sp.exp), V, sp.oo)
    unbounded = limit == 0 and bool((over_speeds(printed["(17)"], name) > 0).all())
    as_stated = unbounded and printed["transition speed"] == sp.oo
    # (17) is the least-squares criterion, and the harmonic one is the limit of the exact threshold.
    agree = (
        above
        and agrees(proved, at_speed["exact"])
        and abs(at_speed["least_squares"][0] / over_speeds(printed["(17)"], name, FAST[:1])[0] - 1) < NONE
        and abs(powers["exact"] - powers["harmonic"]) < SLIGHT
        and abs(at_speed["harmonic"] / at_speed["exact"] - 1).max() < NEARLY
    )
    last = last_with_stick()
    slower, faster = undamped(0.9 * last), undamped(1.1 * last)
    # The mass slips on both sides of the belt's speed: then it crosses it without any stick.
    slips = not sticks_at_last(faster) and {e.begins for e in faster.events[-20:]} == {
        Phase.SLIP_BACK,
        Phase.SLIP_FORWARD,
    }
    agree = agree and sticks_at_last(slower) and slips
    return find(
        ours=f"infinite; but undamped no stick beyond V = {last:.1f} m/s",
        holds="no belt speed makes the threshold vanish; but it falls more slowly than (17), and fast enough the "
        "undamped mass never sticks",
        proved=f"(17) tends to {limit} as V grows; the threshold is {proved[0]} kg/s at V = {FAST[0]:g} m/s and "
        f"{proved[1]} kg/s at {FAST[1]:g} m/s",
        estimated=f"from {FAST[0]:g} to {FAST[1]:g} m/s "
        + ", ".join(f"{method.replace('_', ' ')} goes as V^{power:.3f}" for method, power in powers.items())
        + f", so (17) puts the transition speed ever further too low; undamped and beyond V = {last:.2f} "
        "m/s the mass returns with more force than static friction holds, and slips on both sides of the "
        f"belt's speed; simulated, it {'sticks' if sticks_at_last(slower) else 'does not stick'} at V = "
        f"{0.9 * last:.2f} m/s and {'never sticks' if slips else 'sticks'} at {1.1 * last:.2f} m/s, where x' "
        f"comes up to {faster.v.max():.2f} m/s",
        difference=f"(17) at V = 100 m/s: {percent(at_speed['least_squares'][0] / at_speed['exact'][0] - 1)}",
        reproduced=as_stated
        and agree
        and ("no stick-slip" if slips else "stick-slip") == printed["without damping"],
        qualified=as_stated and agree and printed["without damping"] == "stick-slip" and last > SPEEDS[-1],
    )


@cache
def undamped(V: float) -> Trajectory:
    """Return thirty seconds of the exponential law's motion at c = 0, from the paper's initial condition."""
    return simulate(law("exponential"), oscillator(0.0, V), t_end=30.0)


def sticks_at_last(motion: Trajectory) -> bool:
    """Return whether stick is among the last phases of a motion."""
    return Phase.STICK in {event.begins for event in motion.events[-20:]}


@cache
def last_with_stick() -> float:
    """Return the belt speed in m/s above which the exponential law has no stick-slip cycle at c = 0."""
    low, high = 1.0, 100.0
    while high / low > 1.001:
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if sticks_and_slips("exponential", 0.0, V=middle) else (low, middle)
    return low


@check("S6")
def polynomial_law_above_its_speed(find: Find, printed: Printed) -> Finding:
    """The exact transition speed at c = 0, over k, and the stiffness from which it stays below the paper's."""
    name, stated = "polynomial", Decimal(printed["speed"])
    roots = sp.solve(printed["(18)"].subs(paper.polynomial["v_m"], 1), V)
    by_18 = float(next(root for root in roots if root.is_positive))
    exact = {k: exact_transition_speed(k) for k in (10.0, 100.0, 1e6)}
    beyond = np.linspace(float(stated), 2.0, 12).tolist()
    returns = {V: returns_undamped(name, f"{V:.6g}") for V in beyond}
    free = not any(returns.values()) and not any(sticks_and_slips(name, 0.0, V=V) for V in beyond)
    # An interval in which the speed lies: undamped the slip returns at one end of it, and not at the other.
    ends = {k: speed_between(k) for k in exact}
    lie = all(low < exact[k] < high for k, (low, high) in ends.items())
    free = free and not any(motions_at(V, c).stick_slip for V in (float(stated), 0.95, 1.5) for c in (0.0, 1.0))
    softer = motions_at((float(stated) + exact[10.0]) / 2, 0.0, k=10.0)
    slow = motions_at(0.5 * (1 + float(stated)), 0.0)
    from_k = float(brentq(lambda k: threshold(name, V=0.9, k=k), 50.0, 200.0, rtol=1e-6))
    as_stated = lie and (
        ("no stick-slip" if free else "stick-slip") == printed["faster"]
        and Decimal(by_18).quantize(stated) == Decimal(exact[100.0]).quantize(stated) == stated
    )  # fmt: skip
    return find(
        ours=f"{exact[100.0]:.5f} v_m",
        holds=f"at k = 100 N/m no belt above {stated} v_m makes stick-slip, but with a softer spring some do",
        proved=f"at k = 100 N/m, at {sum(not one for one in returns.values())} of {len(beyond)} belt "
        f"speeds from {stated} to 2 v_m, no c >= 0 lets the slip from P return; the threshold vanishes "
        + ", ".join(f"between {low:.5f} and {high:.5f} v_m (k = {k:,.0f} N/m)" for k, (low, high) in ends.items()),
        estimated=f"(18) vanishes at {by_18:.5f} v_m, the exact threshold at "
        + ", ".join(f"{speed:.5f} v_m (k = {k:,.0f} N/m)" for k, speed in exact.items())
        + f"; {stated} v_m is enough for k >= {from_k:.0f} N/m, not for softer springs: at k = 10 N/m "
        f"and {(float(stated) + exact[10.0]) / 2:.3f} v_m, undamped, there is {softer}; and short of v_m the "
        f"undamped mass need not rest: at {0.5 * (1 + float(stated)):g} v_m there is {slow}",
        difference=f"{exact[100.0] - float(stated):+.5f} v_m",
        reproduced=as_stated and softer.stick_slip is None and max(exact.values()) <= float(stated),
        qualified=as_stated,
    )


@cache
def speed_between(k: float) -> tuple[float, float]:
    """Return belt speeds around the transition speed, proved: undamped the slip returns at the first only."""
    near = round(exact_transition_speed(k), 5)
    low, high = near - CLOSE, near + CLOSE
    proved = (
        returns_undamped("polynomial", f"{low:.5f}", f"{k:g}"),
        returns_undamped("polynomial", f"{high:.5f}", f"{k:g}"),
    )
    return (low, high) if proved == (True, False) else (np.inf, -np.inf)


@cache
def motions_at(V: float, c: float, k: float = 100.0) -> Regime:
    """Return every motion of the polynomial law at a belt speed in m/s and a damping in kg/s."""
    return regime(law("polynomial"), oscillator(c, V, k=k))


@cache
def exact_transition_speed(k: float) -> float:
    """Return the belt speed in m/s at which the exact threshold of the polynomial law is 0."""
    return float(brentq(lambda V: threshold("polynomial", V=V, k=k), 0.85, 1.0, rtol=1e-10))


@check("S9")
def difference_of_coefficients(find: Find, printed: Printed) -> Finding:
    """(17) and (18) are the difference times a factor without it; the exact threshold grows with it."""
    factors = [sp.cancel(printed[label].subs(MU_S, MU_M + D) / D) for label in ("(17)", "(18)")]
    linear = not any(factor.has(D, MU_M, MU_S) for factor in factors)
    slow = SPEEDS[:85]  # m/s, below the speed at which the polynomial law needs no damping
    rises = linear and all((over_speeds(f, name, slow) > 0).all() for f, name in zip(factors, LAWS, strict=True))
    exact = [np.array([thresholds(name, mu_m)[: slow.size] for mu_m in ("0.4", "0.3", "0.2")]) for name in LAWS]
    exactly = all(bool((np.diff(values, axis=0) > 0).all()) for values in exact)
    ratios = [values[2] / values[0] for values in exact]
    return find(
        ours="rises" if rises and exactly else "does not rise",
        holds=f"the pure-slip damping {'rises' if rises and exactly else 'does not rise'} with mu_s - mu_m",
        proved=f"(17) and (18) are {'' if linear else 'not '}proportional to mu_s - mu_m",
        estimated=f"the exact thresholds {'rise' if exactly else 'do not rise'} at every V up to {slow[-1]:g} m/s "
        "as the difference goes from 0.1 over 0.2 to 0.3, in all by "
        + by_law(f"{ratio.min():.4f} to {ratio.max():.4f} times" for ratio in ratios),
        reproduced=("rises" if rises and exactly else "falls") == printed["with mu_s - mu_m"],
    )


@check("S10")
def equilibrium_criteria(find: Find, printed: Printed) -> Finding:
    """The error of the equilibrium criterion, as the amplitude V of the pure-slip orbit grows."""
    # Faster, the polynomial law's threshold comes near 0, and relative errors lose their meaning.
    slow = SPEEDS[:80]
    formulas = printed["equilibrium"]
    error = [over_speeds(formulas[name], name, slow) / thresholds(name)[: slow.size] - 1 for name in LAWS]
    grows = all(bool((np.diff(abs(values)) > 0).all()) for values in error)
    slowest, here, fastest = (
        by_law(percent(values[place], digits=digits) for values in error)
        for place, digits in ((0, 2), (AT_05, 1), (-1, 1))
    )
    return find(
        ours=f"{here} at V = 0.5 m/s",
        holds=f"the criterion of the equilibrium errs, {'' if grows else 'not always '}more at larger amplitudes",
        estimated=f"-N mu'(V) is off by {slowest} at V = 0.01 m/s, by {here} at 0.5 m/s and by {fastest} at "
        f"{slow[-1]:g} m/s; the error {'grows' if grows else 'does not grow'} with every step of V",
        difference=here,
        reproduced=all(is_criterion(formulas[name], name, "equilibrium") for name in LAWS)
        and ("rises" if grows else "falls") == printed["error with amplitude"]
        and all(abs(values[0]) < SLIGHT and abs(values[AT_05]) > ERRS for values in error),
    )


@check("S11")
def no_closed_form(find: Find, printed: Printed) -> Finding:
    """Put x' = V cos(theta) and the nonlinear coefficient into (6), and look for a closed form of c."""
    osc = oscillator()
    velocity = osc.V * np.cos(np.linspace(0, 2 * np.pi, 400, endpoint=False))
    answers, words, errors = [], [], []
    for name in LAWS:
        form = closed_form(name, "harmonic")
        if form is None:
            answers.append("no closed form")
            continue
        c = float(over_speeds(form.expr, name, np.array([osc.V]))[0])
        work = (osc.N * law(name).mu(osc.V - velocity) - c * velocity) * velocity
        balance = float(abs(work.mean() / (c * velocity**2).mean()))
        answers.append("closed form" if balance < NONE else "no closed form")
        words.append(
            f"for the {name} law c = {formula(form.expr)} is {form.verdict.status.value}, and off the threshold "
            f"at V = 0.5 m/s by {percent(float(apart(Enclosure.of(c, c), enclosed(name))))}"
        )
        errors.append(f"for the {name} law it balances (6) to {balance:.0e}")
    agree = [answer == printed["nonlinear coefficient"] for answer in answers]
    return find(
        ours=" and ".join(sorted(set(answers))),
        holds="a nonlinear coefficient has closed forms, and they are closer to the threshold than the paper's"
        if "closed form" in answers
        else "a nonlinear coefficient has no closed form",
        proved="; ".join(words),
        estimated="; ".join(errors),
        difference=f"{answers.count('closed form')} closed forms",
        reproduced=all(agree),
        qualified=any(agree),
    )
