"""Checks S2, S3, S7 and S8: what the paper states of the motions."""

from functools import cache
from typing import Any

import numpy as np
import pytest

from paper_checks.conftest import Find
from paper_checks.scene import LAWS, law, needed, orbit, oscillator, response, sticks_and_slips, threshold
from paper_checks.wording import listed, percent
from stickslip_sym import simulate
from stickslip_sym.orbit import orbits
from stickslip_sym.symbols import V

NONE = 1e-6  # a relative change that may be the error of what is computed
SLIGHT = 0.01  # one that no figure of the paper shows
HARMONIC = 0.10  # overtones, over the fundamental, that "close to harmonic" allows
SCALES = np.array([0.1, 0.5, 2.0, 10.0])  # of the natural frequency
STIFFNESSES = 10.0 ** np.arange(7)  # N/m
SCANNED = np.linspace(0.0, 6.0, 61)  # kg/s


@pytest.mark.claim("S2")
def test_S2_natural_frequency(find: Find, printed: dict[str, Any]) -> None:
    """The exact threshold at other frequencies with the same k m, and over k from 1 to 1e6 N/m at m = 1 kg."""
    alone, with_k = [], {}
    for name in LAWS:
        here = threshold(name)
        found = np.array([threshold(name, m=1 / scale, k=100 * scale) for scale in SCALES])
        alone.append(found / (here * SCALES ** float(printed["power of the frequency"])) - 1)
        found = np.array([threshold(name, k=k) for k in STIFFNESSES])
        with_k[name] = found / (here * (STIFFNESSES / 100) ** float(printed["power of k"])) - 1
    by_frequency = float(np.abs(alone).max())
    by_k = float(np.abs(list(with_k.values())).max())
    stiff = max(float(abs(change[STIFFNESSES >= 100]).max()) for change in with_k.values())
    find(
        ours=f"none at fixed k m; {100 * by_k:.1f} % with k",
        evidence=f"with k m fixed, 0.1 to 10 times the frequency changes the threshold by {by_frequency:.0e} "
        "relative, as it must by the scaling of time; k alone, at 1, 10, ... 1e6 N/m, changes it from that at "
        "100 N/m by "
        + "; ".join(f"{percent(*change)} ({name})" for name, change in with_k.items())
        + f"; from 100 N/m on by {100 * stiff:.2f} % at most: not sqrt(k/m) matters, but sqrt(k m), and little",
        difference=f"{100 * by_k:.1f} % for k from 1 to 1e6 N/m",
        reproduced=max(by_frequency, by_k) < NONE,
        qualified=by_frequency < NONE and stiff < SLIGHT,
    )


@pytest.mark.claim("S3")
def test_S3_pure_slip_motion(find: Find, printed: dict[str, Any]) -> None:
    """The orbit that grazes the belt's speed: its lowest velocity, and its overtones."""
    belt = oscillator().V
    bound = float(printed["lowest"].subs(V, belt))
    lowest = np.array([orbit(name).velocity.min() for name in LAWS])
    overtones = np.array([orbit(name).distortion for name in LAWS])
    as_stated = ("harmonic" if (overtones < HARMONIC).all() else "far from harmonic") == printed["motion"]
    find(
        ours=f"lowest {listed(lowest, 5)} m/s",
        evidence=f"the orbits of the two laws that reach V = {belt:g} m/s come down to {listed(lowest, 5)} "
        f"m/s; their overtones are {percent(*overtones)} of the fundamental of the velocity",
        difference=f"{percent(*(bound - lowest) / belt)} of V below -V",
        reproduced=as_stated and bool(((lowest >= bound) & (lowest < bound + SLIGHT * belt)).all()),
        qualified=as_stated and bool((abs(lowest - bound) < SLIGHT * belt).all()),
    )


@pytest.mark.claim("S7")
def test_S7_one_value_separates(find: Find, printed: dict[str, Any]) -> None:
    """Stick-slip cycles over c from 0 to 6 kg/s, and the band of c in which pure slip attracts."""
    impedance = oscillator().impedance
    graze, hopf = ({name: impedance * float(needed(name).at(A)) for name in LAWS} for A in (1.0, 0.0))
    separates = all(
        ("stick-slip" if sticks_and_slips(name, c) else "slip") == printed["below" if c < graze[name] else "above"]
        for name in LAWS
        for c in SCANNED.tolist()
    )
    # An orbit attracts where the damping that it needs falls with its amplitude, from the Hopf point to the graze.
    widths = [max(0.0, hopf[name] - graze[name]) for name in LAWS]
    agree = [abs(width - printed["width of pure slip"]) < NONE for width in widths]
    between = (graze["exponential"] + hopf["exponential"]) / 2
    both = comes_to_rest(between) and sticks_and_slips("exponential", between)
    find(
        ours=f"pure slip attracts over {listed(widths, 3)} kg/s",
        evidence=f"one damping separates stick-slip from slip, for c = 0 to 6 kg/s in steps of 0.1: {separates}; "
        f"polynomial law: a stable pure-slip cycle for every c from {graze['polynomial']:.4f} to "
        f"{hopf['polynomial']:.4f} kg/s, so two values separate three motions; exponential law: an unstable "
        f"one for every c from {hopf['exponential']:.4f} to {graze['exponential']:.4f} kg/s, and the start "
        f"decides: at {between:.3f} kg/s a mass near rest comes to rest, and from the paper's start it sticks "
        f"and slips: {both}",
        difference=f"{listed(widths, 3)} kg/s",
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


@pytest.mark.claim("S8")
def test_S8_amplitude_at_the_threshold(find: Find, printed: dict[str, Any]) -> None:
    """The peaks of the velocity at the paper's damping, and the Floquet exponent of the grazing orbit."""
    osc = oscillator()
    run = response("exponential", float(printed["c"]))
    exponent = osc.omega * float(orbits(law("exponential"), osc.V, osc.N / osc.impedance).exponent[0])
    change = float(abs(np.diff(run.peaks[:6])).max()) / osc.V
    half = float(run.times[np.argmax(run.peaks < osc.V / 2)])
    find(
        ours=f"{100 * change:.2f} % of V a period, at most in five",
        evidence=f"the peaks of the velocity are {listed(run.peaks[:6], 5)} m/s; but the grazing orbit has the "
        f"Floquet exponent {exponent:+.3f} 1/s: it is unstable, deviations grow e-fold in {1 / exponent:.2f} "
        f"s, and the peak is below V/2 after {half:.1f} s",
        difference=f"{100 * change:.2f} % of V a period",
        reproduced=run.kind == "pure slip" and exponent < 0 and abs(change - printed["change in a period"]) < NONE,
        qualified=run.kind == "pure slip" and abs(change - printed["change in a period"]) < SLIGHT,
    )
