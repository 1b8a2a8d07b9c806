"""Limit cycles that overtake the belt, against rounds that are simulated one by one."""

from dataclasses import replace

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym import Motion, Phase
from stickslip_sym.motion.regimes import overtaking
from stickslip_sym.motion.slip import NondimensionalOscillator
from support.sweeps import sweep

RISING = ["popp_stelter", "cubic", "polynomial", "exponential_viscous"]
OUTSIDE = ss.laws.popp_stelter.typical(), ss.Oscillator(m=1, k=100, c=-1, V=0.1, N=2)
"""A stick-slip cycle, an unstable cycle about it, and a stable one that draws nearly every motion."""


def growth(law, osc, q):
    """The sign of what a round from a displacement outside P gains: one that sticks comes in."""
    x0 = osc.onset(law) + osc.length * q
    motion = ss.simulate(law, osc, t_end=25 / osc.omega, x0=x0, v0=osc.V, rtol=1e-10)
    begins = [event.x for event in motion.events if event.begins is Phase.SLIP_BACK]
    phases = [event.begins for event in motion.events]
    if len(begins) < 2 or Phase.STICK in phases[: phases.index(Phase.SLIP_BACK, 1)]:
        return 1 if motion.outcome is ss.Outcome.UNBOUNDED else -1
    return np.sign(begins[1] - x0) if abs(begins[1] - x0) > 1e-7 * osc.length * q else 0


def disagreements(law, osc, found, displacements):
    """How many rounds go another way than a regime says."""
    place = np.searchsorted([mark.high for mark in found.marks], displacements)
    pairs = [(growth(law, osc, q), found.growth[i]) for q, i in zip(displacements, place, strict=True)]
    return sum(simulated * said < 0 for simulated, said in pairs)


@sweep("seed", range(30), 0, 1)
def test_rounds_go_where_regimes_say(seed):
    """At random points with c < 0, and with weak friction, up to thirty times as far as cycles are sought."""
    rng = np.random.default_rng(seed)
    for _ in range(3):
        law = ss.laws.catalogue[rng.choice(RISING)].typical()
        V, N, k, damping = 10 ** rng.uniform([-1.5, -0.5, 0, -2], [0.5, 1.5, 3, 0])
        osc = ss.Oscillator(m=1, k=k, c=rng.choice([-1, -0.3, 0.3]) * damping * np.sqrt(k), V=V, N=N)
        found = ss.regime(law, osc).outside
        assert "open" not in [mark.kind for mark in found.marks]
        farthest = 30 * min(overtaking.reach(NondimensionalOscillator.of(law.bound, osc)), 1e4)
        assert disagreements(law, osc, found, farthest * 10 ** rng.uniform(-6, 0, 10)) == 0


def test_an_attractor_outside_stick_slip():
    law, osc = OUTSIDE
    found = ss.regime(law, osc)
    inner, outer = found.overtaking
    assert (inner.stable, outer.stable, found.unbounded) == (False, True, False)
    assert found.attractors == (outer, found.stick_slip)
    assert outer.amplitude == pytest.approx(11.19, abs=0.01)
    late = ss.simulate(law, osc, t_end=60.0, x0=0.3, v0=0.0)
    times = np.linspace(55, 60, 5001)
    assert late.at(times).v.max() == pytest.approx(outer.amplitude, rel=1e-5)
    assert ss.classify(law, osc, x0=[0.3, 0.0], v0=0.0).tolist() == [Motion.PURE_SLIP, Motion.STICK_SLIP]
    cells = ss.motion_map(law, x=("V", [0.1]), y=("c", [-1.0, 1.0]), N=2, m=1, k=100)
    assert cells.attractors["pure_slip"].ravel().tolist() == [True, False]
    # Without the unstable cycle rounds would be said to go out that come in.
    assert disagreements(law, osc, found.outside, np.geomspace(1, 1e3, 20)) == 0
    marks = found.outside.marks[1:]
    wrong = found.outside._replace(marks=marks, growth=(1, -1))
    assert disagreements(law, osc, wrong, np.geomspace(1, 1e3, 20)) > 3


def test_two_cycles_close_together_are_found_or_open():
    """Beside a fold at c = -0.47361844: 4e-4 apart, none, and not told apart."""
    law, osc = OUTSIDE
    low, high, fold = (replace(osc, c=c) for c in (-0.47361846, -0.47361842, -0.473618442611))
    inner, outer = ss.regime(law, low).overtaking
    assert 0 < outer.amplitude / inner.amplitude - 1 < 1e-3
    assert (inner.stable, outer.stable) == (False, True)
    assert ss.regime(law, high).outside.marks == ()
    assert "whether limit cycles overtake the belt" in ss.regime(law, fold).undecided[0]


def ends(system, q):
    """Where rounds end, with steps of a tolerance of 1e-11."""
    return system.rounds(q, 1e-11).ends.required()


@sweep("seed", range(20), 0)
def test_no_orbit_is_closed_beyond_the_reach(seed):
    """Of many random oscillators: rounds from there on only grow, or only shrink."""
    rng = np.random.default_rng(seed)
    found = inside = weakly = 0
    for _ in range(12):
        a, b, w, h, p, d = rng.uniform([0.1, 0.05, 0.03, -0.2, 0.3, 0], [0.5, 0.5, 0.5, 0.5, 4, 0.05])
        law = ss.FrictionLaw(f"{a} + {b}*exp(-v/{w}) + {d}*v^2 + {h}*v/(1 + (v/{p})^4)")
        V, eta, zeta = 10 ** rng.uniform([-1.5, -2, -3], [0.5, 1, 0])
        system = replace(NondimensionalOscillator.of(law.bound, ss.Oscillator(m=1, k=1, c=0, V=V, N=1)), eta=eta)
        way = rng.choice([-1, -1, 1])
        system = replace(system, zeta=way * zeta)
        by_losses, weak = overtaking.reaches(system, np.array([eta, eta / 10]), np.array([way * zeta, eta / 1e4]))
        for far in filter(np.isfinite, (by_losses, overtaking.reach(system))):
            q = max(far, 1e-3) * 10 ** rng.uniform(0, 2, 40)
            out, among = (ends(system, some) > some for some in (q, q * far / q.max() / 30))
            assert out.all() or not out.any()
            found += 1
            inside += among.any() and not among.all()
        (first,) = ends(replace(system, eta=eta / 10, zeta=eta / 1e4), np.zeros(1))
        assert not max(weak, 0.0) < first < np.inf  # a cycle is farther out than a round from P comes
        weakly += first > 0
    assert (found > 10, inside > 1, weakly > 1) == (True, True, True)
