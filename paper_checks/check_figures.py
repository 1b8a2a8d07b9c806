"""Checks F3 to F10: the paper's figures."""

from bisect import bisect_left
from fractions import Fraction
from typing import Any

import numpy as np

from paper_checks.computed import (
    AT_05,
    LAWS,
    SPEEDS,
    is_criterion,
    law,
    oscillator,
    over_speeds,
    response,
    thresholds,
)
from paper_checks.findings import Find, Finding, Printed, check
from paper_checks.proved import (
    agrees,
    apart,
    enclosed,
    enclosed_over_speeds,
    formula_over_speeds,
    nearer,
    proved_places,
    sizes,
)
from paper_checks.wording import by_law, listed, percent
from stickslip_sym import Motion, classify, limit_cycles

CONSTANT = 1e-3  # change of an amplitude or a period, relative, that counts as none
WELL = 0.05  # relative deviation that counts as good agreement
LARGE = 0.10  # relative deviation that counts as a large difference
READABLE = 0.06  # kg/s, a hundredth of the height of Figs. 6 and 7
THOMSEN = "Thomsen & Fidlin"
STIFFNESSES = np.geomspace(100, 1e6, 161).tolist()  # N/m
LEAP = 20  # of them, between which the last one is sought at which a formula is closer
FALLS = {"falls": True, "fall": True, "rises": False, "rise": False}
ENDS = {motion: motion.value for motion in Motion} | {Motion.REST: "damped slip"}
"""The paper's words for how a motion from the belt's speed ends."""


@check("F3", name="exponential")
@check("F4", name="polynomial")
def motions(find: Find, printed: Printed, *, name: str) -> Finding:
    """Simulate the five motions of a figure, and compare their kinds, stick intervals, periods and peaks."""
    runs = [response(name, float(c)) for c in printed["dampings"]]
    cycles = [run for run in runs if run.kind == "stick-slip"]
    sticks = [float(run.sticks[-1]) for run in cycles] + [0.0]
    periods = [run.period for run in cycles] + [float(np.diff(runs[3].times)[0])]
    steady = all(np.ptp(np.diff(run.times)) < CONSTANT * run.period for run in cycles)
    slip = runs[3]
    ends = tuple(ENDS[classify(law(name), oscillator(float(c)))] for c in printed["dampings"])
    lasting = [c for c in limit_cycles(law(name), oscillator(float(printed["dampings"][3]))) if c.stable]
    end = f"a limit cycle of {lasting[0].amplitude:.4f} m/s" if lasting else "rest, as no limit cycle is stable"
    kinds = [run.kind for run in runs]
    consistent = ends == (*kinds[:3], "pure slip" if lasting else "damped slip", kinds[4])
    as_shown = (
        tuple(kinds) == printed["motions"]
        and steady == (printed["amplitude"] == "constant")
        and bool((np.diff(sticks) < 0).all()) == FALLS[printed["stick"]]
        and bool((np.diff(periods) < 0).all()) == FALLS[printed["period"]]
    )
    return find(
        ours=", ".join(
            kind if kind == end else f"{kind} for a while, then {end}"
            for kind, end in zip(kinds, ends, strict=True)
        ),
        holds="the motions look as drawn"
        + (", and stay so" if ends == tuple(kinds) else "; at the fourth damping pure slip does not last"),
        estimated=f"for c = {', '.join(printed['dampings'][:4])} kg/s stick lasts {listed(sticks)} s and the "
        f"period is {listed(periods)} s; at {printed['dampings'][3]} the peaks of the velocity are "
        f"{listed(slip.peaks[:6])} m/s, and the motion tends to {end}; at {printed['dampings'][4]} they are "
        f"{listed(runs[4].peaks[:6])} m/s",
        difference=f"peak after {slip.times[-1]:.0f} s: {slip.peaks[-1]:.3f} m/s",
        reproduced=as_shown and consistent and ends == printed["motions"],
        qualified=as_shown and consistent,
    )


@check("F5")
def phase_plots(find: Find, printed: Printed) -> Finding:
    """Q has the place of P one cycle later; its velocity is V or it is not."""
    runs = {c: response("exponential", float(c)) for c in printed["coincide"]}
    V = oscillator().V
    lack = {c: 1 - run.after_a_cycle / V for c, run in runs.items()}
    swings = np.array([run.swing for run in runs.values()])
    return find(
        ours="V_Q/V = " + ", ".join(f"{1 - value:.4f}" for value in lack.values()),
        holds="after a cycle the mass is back at P with the belt's speed in stick-slip and pure slip only",
        estimated="; ".join(
            f"c = {c}: V_Q = {run.after_a_cycle:.5f} m/s, x and x' swing by {listed(run.swing)} m and m/s"
            for c, run in runs.items()
        ),
        difference=f"{lack['2.574']:.1e} of V at c = 2.574",
        reproduced={c: value < CONSTANT for c, value in lack.items()} == printed["coincide"]
        and bool((np.diff(swings, axis=0) < 0).all()) == FALLS[printed["amplitudes"]],
    )


@check("F6")
def exponential_law(find: Find, printed: Printed) -> Finding:
    """(17) and the criterion of the equilibrium against the exact threshold, V from 0.01 to 1 m/s."""
    places = proved_places()
    proved = [threshold for threshold in enclosed_over_speeds("exponential") if threshold is not None]
    everywhere = len(proved) == len(places) and agrees(proved, thresholds("exponential")[places])
    off = {
        name: [
            apart(*pair) for pair in zip(formula_over_speeds(printed[name], "exponential"), proved, strict=False)
        ]
        for name in ("(17)", "equilibrium")
    }
    lower = {name: [float(sizes(one)[0]) for one in values] for name, values in off.items()}
    worst = {name: int(np.argmax(values)) for name, values in lower.items()}
    least = {name: max(values) for name, values in lower.items()}
    most = {name: max(float(sizes(one)[1]) for one in off[name]) for name in off}
    closer = min(most, key=lambda name: most[name])
    decided = max(least.values()) > min(most.values())
    here = percent(*(float(values[min(places.index(AT_05), len(values) - 1)]) for values in off.values()))
    return find(
        ours=f"(17) within {most['(17)']:.1%}, equilibrium {most['equilibrium']:.0%}",
        holds="(17) agrees well with the threshold at every belt speed; the criterion of the equilibrium does not",
        proved=f"at each of {len(proved)} belt speeds (17) is off the threshold by less than {most['(17)']:.2%}; "
        + "; ".join(
            f"{name} is off by {100 * float(off[name][i]):+.2f} % at V = {SPEEDS[places[i]]:g} m/s"
            for name, i in worst.items()
        )
        + f", the most; at V = 0.5 m/s they are {here}",
        checked="collocation of the grazing orbit lies in each of the enclosures",
        difference=f"{100 * float(off['(17)'][worst['(17)']]):+.2f} % at most",
        reproduced=everywhere
        and decided
        and closer == printed["closer"]
        and is_criterion(printed["equilibrium"], "exponential", "equilibrium")
        and most["(17)"] < WELL
        and least["equilibrium"] > LARGE,
    )


@check("F7")
def polynomial_law(find: Find, printed: Printed) -> Finding:
    """Where (18) is closer to the exact threshold than Thomsen & Fidlin, at this stiffness and at others."""
    values = {name: over_speeds(printed[name], "polynomial") for name in ("(18)", "equilibrium", THOMSEN)}
    off = {name: abs(value - thresholds("polynomial")) for name, value in values.items()}
    largest = {name: float(value.max()) for name, value in off.items()}
    theirs = is_criterion(printed["equilibrium"], "polynomial", "equilibrium") and is_criterion(
        printed[THOMSEN], "polynomial", "harmonic"
    )
    places, proved = proved_places(), enclosed_over_speeds("polynomial")
    balls = {name: formula_over_speeds(printed[name], "polynomial") for name in values}
    # Where no c >= 0 is a threshold, collocation gives a negative one.
    positive = [i for i, threshold in enumerate(proved) if threshold is not None]
    everywhere = len(proved) == len(places) and agrees(proved, thresholds("polynomial")[places])
    beats = {
        name: [nearer(balls["(18)"][i], balls[name][i], one) for i, one in enumerate(proved) if one is not None]
        for name in (THOMSEN, "equilibrium")
    }
    decided = everywhere and None not in beats[THOMSEN] + beats["equilibrium"]
    wins = [SPEEDS[places[i]] for i, beaten in zip(positive, beats[THOMSEN], strict=True) if beaten]
    beats_equilibrium = all(beats["equilibrium"]) and bool((off["(18)"] < off["equilibrium"]).all())
    decided = decided and beats[THOMSEN] == (off["(18)"] < off[THOMSEN])[places][positive].tolist()

    def closer(k: float) -> Any:
        exact = thresholds("polynomial", k=k)
        return abs(values["(18)"] - exact) < abs(values[THOMSEN] - exact)

    def is_further(k: float) -> bool:
        return not closer(k).any()

    here = closer(100.0)
    first = f"V >= {SPEEDS[np.argmax(here)]:g} m/s"
    negative = all(ball.high < 0 for name in ("(18)", THOMSEN) for ball in balls[name][len(positive) :])
    some = [k for k in STIFFNESSES[::LEAP] if not is_further(k)]
    stiff = "at no k from 100 N/m on"
    if some:
        between = [k for k in STIFFNESSES if some[-1] <= k <= some[-1] * STIFFNESSES[LEAP] / STIFFNESSES[0]]
        stiff = f"up to k = {between[bisect_left(between, True, key=is_further) - 1]:.0f} N/m; stiffer, at none"
    return find(
        ours=f"closer than Thomsen & Fidlin for {first} only",
        holds=f"(18) is {'' if beats_equilibrium else 'not '}closer than Galvanetto & Bishop at every belt speed, "
        f"and than Thomsen & Fidlin {'everywhere' if here.all() else 'for fast belts only'}",
        proved=f"of the {len(positive)} belt speeds with a threshold (18) is closer than Galvanetto & Bishop at "
        f"{sum(map(bool, beats['equilibrium']))}, and than Thomsen & Fidlin at {len(wins)}"
        + (f", from V = {wins[0]:g} to {wins[-1]:g} m/s" if wins else "")
        + f"; at the other {len(proved) - len(positive)} no c >= 0 lets the slip from P return"
        + (", as both formulas have it, which are negative there" if negative else ""),
        estimated="the largest deviations are "
        f"{', '.join(f'{size:.4f} kg/s ({name})' for name, size in largest.items())}; "
        f"with negative thresholds (18) is closer than Thomsen & Fidlin at {here.sum()} of {here.size} speeds, "
        f"{first}; as k grows, it is closer at some V <= 1 m/s {stiff} (tried to 1e6 N/m): theirs is the limit of "
        "weak friction",
        difference=f"{100 * (values['(18)'] / thresholds('polynomial') - 1)[AT_05]:+.2f} % at V = 0.5 m/s, "
        f"Thomsen & Fidlin {100 * (values[THOMSEN] / thresholds('polynomial') - 1)[AT_05]:+.2f} %",
        reproduced=decided and theirs and bool(here.all()) and beats_equilibrium,
        qualified=decided
        and theirs
        and min(largest, key=lambda name: largest[name]) == printed["closest"]
        and beats_equilibrium
        and bool(here.any())
        and largest["(18)"] < READABLE,
    )


@check("F8", name="exponential")
@check("F9", name="polynomial")
def points_beside_the_threshold(find: Find, printed: Printed, *, name: str) -> Finding:
    """Simulate the motions at two points, and decide on which side of the exact threshold they lie."""
    c = float(printed["c"])
    points = {point: stated for point, stated in printed.items() if point != "c"}
    runs = {point: response(name, c, float(V)) for point, (V, _) in points.items()}
    exact = {point: enclosed(name, V=V) for point, (V, _) in points.items()}
    sticks = {point: Fraction(c) < bounds.low for point, bounds in exact.items()}
    decided = all(sticks[point] or Fraction(c) > bounds.high for point, bounds in exact.items())
    return find(
        ours=", ".join(run.kind for run in runs.values()),
        holds="the motions at both points are as stated, one below its threshold and one above",
        proved="; ".join(
            f"at V = {V} m/s the threshold is {exact[point]} kg/s, and c = {c:g} kg/s is "
            + ("below" if sticks[point] else "above")
            for point, (V, _) in points.items()
        ),
        estimated="simulated, " + "; ".join(f"the motion at {point} is {runs[point].kind}" for point in points),
        reproduced=all(run.kind == points[point][1] for point, run in runs.items())
        and decided
        and all(sticks[point] == (motion == "stick-slip") for point, (_, motion) in points.items()),
    )


@check("F10")
def friction_parameters(find: Find, printed: Printed) -> Finding:
    """The exact threshold for three mu_m: at every belt speed where it is positive, and as an area."""
    regions = {
        name: np.array([np.maximum(thresholds(name, mu_m), 0) for mu_m in printed["mu_m"]]) for name in LAWS
    }
    areas = {name: [float(area) for area in region.mean(axis=1)] for name, region in regions.items()}
    shrinks = [bool((np.diff(region[:, region.max(axis=0) > 0], axis=0) < 0).all()) for region in regions.values()]
    grows = [bool((np.diff(region[:, region.max(axis=0) > 0], axis=0) > 0).all()) for region in regions.values()]
    return find(
        ours=by_law(" > ".join(f"{area:.3f}" for area in areas[name]) + " kg m/s^2" for name in LAWS),
        holds=f"the region of stick-slip {'shrinks' if all(shrinks) else 'does not shrink'} as mu_m grows",
        estimated="the area under the exact threshold for V up to 1 m/s is, for mu_m = "
        f"{', '.join(printed['mu_m'])}: "
        + "; ".join(f"{name} {' '.join(f'{area:.4f}' for area in areas[name])} kg m/s^2" for name in LAWS)
        + f"; it {'falls' if all(shrinks) else 'does not fall'} at every single V",
        reproduced=all(shrinks if FALLS[printed["region"]] else grows),
    )
