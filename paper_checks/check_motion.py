"""Checks S2, S3, S7 and S8: what the paper states of the motions."""

from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from derivations import chapter
from paper_checks.computed import LAWS, law, needed, orbit, oscillator, response, sticks_and_slips, threshold
from paper_checks.findings import Find, Finding, Printed, check
from paper_checks.proved import agrees, enclosed, lowest_velocity
from paper_checks.wording import by_law, listed, percent
from stickslip_sym import Oscillator, Status, enclose, simulate
from stickslip_sym.core.symbols import V
from stickslip_sym.motion.orbits.orbit import orbits

NONE = 1e-6  # relative change that the error of the computation explains
SLIGHT = 0.01  # relative change that no figure of the paper shows
HARMONIC = 0.05  # total harmonic distortion up to which a wave is commonly taken for a sine
CLOSED = 1e-6  # difference of the ends of a period of the orbit at the threshold, over V
SAME_RATE = 0.02  # relative difference of rates: the printed damping is 0.001 kg/s off the orbit's own
SCALES = np.array([0.1, 0.5, 2.0, 10.0])  # factors of the natural frequency
STIFFNESSES = 10.0 ** np.arange(7)  # N/m
SOFT, COARSE, FINE = 10.0, 1e-3, 1e-6  # N/m below which friction is strong; relative widths of enclosures
SCANNED = np.linspace(0.0, 6.0, 61)  # kg/s


@check("S2")
def natural_frequency(find: Find, printed: Printed) -> Finding:
    """The exact threshold at other frequencies with the same k m, and over k from 1 to 1e6 N/m at m = 1 kg."""
    off, with_k, proved, agree = [], {}, {}, True
    for name in LAWS:
        here = threshold(name)
        # Thresholds are computed without units, where this holds by construction; so it is integrated in SI units.
        dampings = here * SCALES ** float(printed["power of the frequency"])
        off += [
            next_peak(name, oscillator(c, m=1 / scale, k=100 * scale)) / oscillator().V - 1
            for c, scale in zip(dampings.tolist(), SCALES.tolist(), strict=True)
        ]
        found = np.array([threshold(name, k=k) for k in STIFFNESSES])
        agree = agree and here in enclosed(name)
        if agree:  # with a wrong guess, to look for all others takes long
            proved[name] = [enclosed(name, k=f"{k:.0f}", rtol=COARSE if k < SOFT else FINE) for k in STIFFNESSES]
            agree = agrees(proved[name], found)
        with_k[name] = found / (here * (STIFFNESSES / 100) ** float(printed["power of k"])) - 1
    by_frequency = float(np.abs(off).max())
    by_k = float(np.abs(list(with_k.values())).max())
    stiff = max(float(abs(change[STIFFNESSES >= 100]).max()) for change in with_k.values())
    return find(
        ours=f"none at fixed k m; {100 * by_k:.1f} % with k",
        holds="the natural frequency does not matter, but sqrt(k m) does, though little for stiff springs",
        proved=f"at m = 1 kg and k = {', '.join(f'{k:g}' for k in STIFFNESSES)} N/m the threshold is "
        + "; ".join(f"{', '.join(map(str, found))} kg/s ({name})" for name, found in proved.items()),
        checked="with k m fixed, at 0.1 to 10 times the frequency the same damping makes the slip from P graze "
        f"the belt's speed to {by_frequency:.0e} of it, integrated in SI units",
        estimated="k changes it from that at 100 N/m by "
        + "; ".join(f"{percent(*change)} ({name})" for name, change in with_k.items())
        + f"; from 100 N/m on by {100 * stiff:.2f} % at most: not sqrt(k/m) matters, but sqrt(k m), and little",
        difference=f"{100 * by_k:.1f} % for k from 1 to 1e6 N/m",
        reproduced=agree and max(by_frequency, by_k) < NONE,
        qualified=agree and by_frequency < NONE and stiff < SLIGHT,
    )


def next_peak(name: str, osc: Oscillator) -> float:
    """Return the velocity in m/s at the peak after the slip from P, from (2) integrated as it stands."""
    mu, period = law(name).mu, 2 * np.pi / osc.omega

    def acceleration(_: float, y: Any) -> float:
        return float(osc.N * mu(max(osc.V - y[1], 0.0)) - osc.c * y[1] - osc.k * y[0]) / osc.m

    start = (mu(0.0) * osc.N - osc.c * osc.V) / osc.k, osc.V
    motion = solve_ivp(
        lambda t, y: [y[1], acceleration(t, y)], (0.0, 1.3 * period), start, events=acceleration,
        method="DOP853", rtol=1e-11, atol=1e-13,
    )  # fmt: skip
    turns = zip(motion.t_events[0], motion.y_events[0], strict=True)
    return float(max(y[1] for t, y in turns if t > 0.8 * period))


@check("S3")
def pure_slip_motion(find: Find, printed: Printed) -> Finding:
    """The orbit that grazes the belt's speed: its lowest velocity, and its overtones."""
    belt = oscillator().V
    bound = float(printed["lowest"].subs(V, belt))
    lowest = np.array([orbit(name).velocity.min() for name in LAWS])
    overtones = np.array([orbit(name).distortion for name in LAWS])
    proved = [lowest_velocity(name) for name in LAWS]
    agree = agrees(proved, lowest)
    sides = ["below" if v.high < bound else "above" if v.low > bound else "at" for v in proved]
    holds = {"harmonic": overtones < HARMONIC, "far from harmonic": overtones > 1}[printed["motion"]]
    closed = max(abs(orbit(name).gap) for name in LAWS) < CLOSED * belt
    return find(
        ours=f"lowest {by_law(f'{v:.5f} m/s' for v in lowest)}",
        holds="in pure slip the velocity stays within -V and V, or nearly, and one of the motions is near a sine",
        proved=f"the lowest velocity of the orbit that reaches V = {belt:g} m/s lies in "
        + by_law(f"{v} m/s, {side} {bound:g} m/s" for v, side in zip(proved, sides, strict=True)),
        estimated=f"it is {by_law(f'{v:.5f} m/s' for v in lowest)}; the harmonic distortion of the velocity is "
        + " and ".join(
            f"{100 * part:.2f} % ({name} law: {'a' if part < HARMONIC else 'not a'} sine by the usual limit of "
            f"{HARMONIC:.0%})"
            for name, part in zip(LAWS, overtones, strict=True)
        ),
        difference=f"{by_law(percent(part) for part in (bound - lowest) / belt)} of V below -V",
        reproduced=agree and closed and bool((holds & (lowest >= bound) & (lowest < bound + SLIGHT * belt)).all()),
        qualified=agree and closed and bool(holds.any()) and bool((abs(lowest - bound) < SLIGHT * belt).all()),
    )


@check("S7")
def one_value_separates(find: Find, printed: Printed) -> Finding:
    """Stick-slip cycles over c from 0 to 6 kg/s, and the band of c in which pure slip attracts."""
    impedance = oscillator().impedance
    graze, hopf = ({name: impedance * float(needed(name).at(A)) for name in LAWS} for A in (1.0, 0.0))
    # The graze by collocation of one orbit, the Hopf point from the slope of mu: ends of one interpolation here.
    agree_at_ends = all(
        abs(graze[name] - threshold(name)) < NONE
        and abs(hopf[name] + oscillator().N * float(law(name).slope(oscillator().V))) < NONE
        for name in LAWS
    )
    proved = {name: enclosed(name) for name in LAWS}
    hopf_proved = {name: enclose(law(name), "equilibrium", V="0.5", N="9.81") for name in LAWS}
    # The lemma for any law; its hypotheses were checked for each enclosure.
    lemma = chapter("one_threshold")({})
    agree_at_ends &= lemma.status is Status.PROVED and all(graze[name] in proved[name] for name in LAWS)
    wider = {name: hopf_proved[name].low > proved[name].high for name in LAWS}
    agree_at_ends &= all(wider[name] or hopf_proved[name].high < proved[name].low for name in LAWS)
    agree_at_ends &= all(wider[name] == (hopf[name] > graze[name]) for name in LAWS)
    separates = agree_at_ends and all(
        ("stick-slip" if sticks_and_slips(name, c) else "slip") == printed["below" if c < graze[name] else "above"]
        for name in LAWS
        for c in SCANNED.tolist()
    )
    # An orbit attracts where the damping that it needs falls with its amplitude, from the Hopf point to the graze.
    widths = [max(0.0, hopf[name] - graze[name]) for name in LAWS]
    agree = [abs(width - printed["width of pure slip"]) < NONE for width in widths]
    between = (graze["exponential"] + hopf["exponential"]) / 2
    both = comes_to_rest(between) and sticks_and_slips("exponential", between)
    return find(
        ours=f"pure slip attracts over {by_law(f'{width:.3f} kg/s' for width in widths)}",
        holds=f"{'one' if separates else 'no single'} damping separates stick-slip from slip, but a range of "
        "dampings has stable pure slip, or rest beside stick-slip",
        proved=f"the chapter one_threshold proves in {len(lemma.steps)} steps: {lemma.title.lower()}; the "
        f"thresholds are {by_law(f'{proved[name]} kg/s' for name in LAWS)}, the Hopf points "
        f"{by_law(f'{hopf_proved[name]} kg/s, ' + ('above' if wider[name] else 'below') for name in LAWS)}",
        estimated="stick-slip cycles end there, for c = 0 to 6 kg/s in steps of 0.1; with the polynomial law a "
        f"stable pure-slip cycle exists for every c from {graze['polynomial']:.4f} to "
        f"{hopf['polynomial']:.4f} kg/s, so two values separate three motions; with the exponential law an "
        f"unstable one exists for every c from {hopf['exponential']:.4f} to {graze['exponential']:.4f} kg/s, "
        f"and the initial condition decides: at {between:.3f} kg/s motions from near rest and from the paper's "
        "own " + ("do not part" if not both else "part, the first comes to rest and the other sticks and slips"),
        difference=by_law(f"{width:.3f} kg/s" for width in widths),
        reproduced=separates and all(agree),
        qualified=separates and any(agree) and both,
    )


@cache
def comes_to_rest(c: float) -> bool:
    """Return whether the exponential law brings a small motion about the equilibrium to rest."""
    osc = oscillator(c)
    x_rest = osc.N * law("exponential").mu(osc.V) / osc.k
    motion = simulate(law("exponential"), osc, t_end=40.0, x0=x_rest, v0=0.01 * osc.V, rtol=1e-9)
    return bool(abs(motion.v[motion.t > 39]).max() < SLIGHT * abs(motion.v[0]))


@check("S8")
def amplitude_at_the_threshold(find: Find, printed: Printed) -> Finding:
    """The peaks of the velocity at the paper's damping, and the Floquet exponent of the grazing orbit."""
    osc = oscillator()
    run = response("exponential", float(printed["c"]))
    exponent = osc.omega * float(orbits(law("exponential").bound, osc.V, osc.N / osc.impedance).exponent[0])
    change = float(abs(np.diff(run.peaks[:6])).max()) / osc.V
    # In simulation, what the peaks lose from one period to the next grows at the rate of the orbit's exponent.
    losses = -np.diff(run.peaks[:5])
    rate = (
        float(np.mean(np.log(losses[1:] / losses[:-1]) / np.diff(run.times[1:5]))) if (losses > 0).all() else 0.0
    )
    as_drawn = run.kind == "pure slip" and abs(rate - exponent) < SAME_RATE * abs(exponent)
    proved = enclosed("exponential")
    decays = Fraction(printed["c"]) > proved.high
    half = float(run.times[np.argmax(run.peaks < osc.V / 2)])
    return find(
        ours=f"{100 * change:.2f} % of V a period, at most in five",
        holds="the amplitude looks constant for some periods, and it is not: the orbit is "
        + ("unstable" if exponent > 0 else "stable"),
        proved=f"{printed['c']} kg/s is {'above' if decays else 'not above'} the threshold, {proved} kg/s"
        + (", so the slip from P does not come back to the belt's speed" if decays else ""),
        estimated=f"the peaks of the velocity are {listed(run.peaks[:6], 5)} m/s; the grazing orbit has the "
        f"Floquet exponent {exponent:+.3f} 1/s, and what the peaks lose grows at {rate:+.3f} 1/s: the orbit is "
        f"{'unstable' if exponent > 0 else 'stable'}, and deviations change e-fold in {abs(1 / exponent):.2f} s; "
        f"the peak is below V/2 after {half:.1f} s",
        difference=f"{100 * change:.2f} % of V a period",
        reproduced=as_drawn and exponent < 0 and abs(change - printed["change in a period"]) < NONE,
        qualified=as_drawn and decays and abs(change - printed["change in a period"]) < SLIGHT,
    )
