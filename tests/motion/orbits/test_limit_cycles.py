"""Pure-slip limit cycles against simulation from both sides, and their number."""

import math

import numpy as np
import pytest
from operating_points import TWO, paper_oscillator
from sweeps import sweep

import stickslip_sym as ss
from stickslip_sym import Phase
from stickslip_sym.motion.orbits.cycles import needed_damping
from stickslip_sym.motion.slip import Dimensionless
from stickslip_sym.motion.steps import End

CASES = [("exponential", 2.3, False), ("polynomial", 3.1, True)]


def peaks(law, osc, v0, cycles):
    """Return the highest velocity of each period, the mass starting at the equilibrium's place with v0."""
    x0 = osc.N * law.mu(osc.V) / osc.k
    motion = ss.simulate(law, osc, t_end=cycles * 2 * math.pi / osc.omega, x0=x0, v0=v0, rtol=1e-12)
    top = np.flatnonzero((motion.v[1:-1] > motion.v[:-2]) & (motion.v[1:-1] >= motion.v[2:])) + 1
    found = []
    for i in top:  # the parabola through three samples of a maximum
        t = osc.omega * (motion.t[i - 1 : i + 2] - motion.t[i])
        if np.diff(t).min() > 1e-3:
            fit = np.polyfit(t, motion.v[i - 1 : i + 2], 2)
            found.append(fit[2] - fit[1] ** 2 / (4 * fit[0]))
    return np.array(found)


@pytest.mark.parametrize(("name", "c", "stable"), CASES)
def test_motions_beside_a_cycle_go_where_its_stability_says(name, c, stable):
    law, osc = ss.laws.catalogue[name].typical(), paper_oscillator(c)
    (cycle,) = ss.limit_cycles(law, osc)
    assert cycle.stable is stable
    assert (cycle.floquet < 0) is stable
    assert 0 < cycle.amplitude < osc.V
    for side in (-1, 1):
        found = peaks(law, osc, cycle.amplitude * (1 + 0.02 * side), 20 if stable else 5)
        found = found[1:]  # after the start, off the cycle's phase
        drift = float(side * (found[-1] - found[0]))
        assert (drift < 0) is stable
        # Samples of a maximum are coarse: only that it stays beside the cycle, on its side.
        assert (side * (found - cycle.amplitude) > 0).all()


def test_a_stable_cycle_is_the_end_of_a_long_simulation():
    law, osc = ss.laws.polynomial.typical(), paper_oscillator(3.1)
    (cycle,) = ss.limit_cycles(law, osc)
    enough = 20 / abs(cycle.floquet)
    motion = ss.simulate(law, osc, t_end=enough, x0=0.1, v0=0.0, rtol=1e-12)
    assert Phase.STICK not in {event.begins for event in motion.events if event.t > enough / 2}
    last = motion.t > enough - 1.5 * cycle.period
    assert motion.v[last].max() == pytest.approx(cycle.amplitude, rel=2e-3)  # of coarse samples
    # The rate at which a deviation dies, and the period, from the zeros of the velocity.
    sign = np.flatnonzero((motion.v[:-1] < 0) & (motion.v[1:] >= 0))
    share = -motion.v[sign] / (motion.v[sign + 1] - motion.v[sign])
    zeros = motion.t[sign] + share * (motion.t[sign + 1] - motion.t[sign])
    assert np.mean(np.diff(zeros)[-50:]) == pytest.approx(cycle.period, rel=1e-4)


def test_the_floquet_exponent_is_the_slope_of_the_damping():
    """By the averaged equation dA/dt = A (need(A) - c)/(2 m), whose exponent at a cycle is A need'(A)/(2 m)."""
    law, osc = ss.laws.polynomial.typical(), paper_oscillator(3.25)
    (cycle,) = ss.limit_cycles(law, osc)
    h = 1e-5
    near = [ss.limit_cycles(law, paper_oscillator(3.25 + sign * h))[0].amplitude for sign in (-1, 1)]
    slope = 2 * h / (near[1] - near[0])
    assert cycle.floquet == pytest.approx(cycle.amplitude * slope / 2, rel=0.02)


def test_every_cycle_of_a_law_whose_balance_is_not_monotone():
    harmonic = [9.81 * (0.3 + 6 * a**2 / 4 - 40 * a**4 / 8) for a in (0.0, 0.5)]
    assert harmonic == pytest.approx([2.943, 3.556125])
    numbers = {
        c: [cycle.stable for cycle in ss.limit_cycles(TWO, paper_oscillator(c))] for c in (2.9, 3.3, 3.8, 4.1)
    }
    assert numbers == {2.9: [], 3.3: [False], 3.8: [False, True], 4.1: []}
    inner, outer = ss.limit_cycles(TWO, paper_oscillator(3.8))
    assert inner.amplitude < outer.amplitude
    # A start between them comes to the outer, a start inside the inner one to rest.
    assert (
        peaks(TWO, paper_oscillator(3.8), (inner.amplitude + outer.amplitude) / 2, 60)[-1] > outer.amplitude * 0.98
    )
    assert peaks(TWO, paper_oscillator(3.8), inner.amplitude * 0.9, 60)[-1] < inner.amplitude * 0.5


@sweep("name", ["exponential", "polynomial"], "exponential")
def test_cycles_live_between_the_hopf_point_and_the_threshold(name):
    law = ss.laws.catalogue[name].typical()
    hopf = ss.pure_slip_damping(law, V=0.5, N=9.81, method="equilibrium").value
    graze = ss.pure_slip_damping(law, V=0.5, N=9.81, m=1, k=100, method="orbit", rtol=1e-12).value
    for part in (1e-3, 0.5, 1 - 1e-6):
        (cycle,) = ss.limit_cycles(law, paper_oscillator(hopf + part * (graze - hopf)))
        assert cycle.amplitude == pytest.approx(0.5, rel=1e-5) if part > 0.9 else cycle.amplitude < 0.49
    for part in (-1e-3, 1 + 1e-6):
        assert ss.limit_cycles(law, paper_oscillator(hopf + part * (graze - hopf))) == ()


def test_the_amplitude_of_the_polynomial_law_is_the_closed_one_where_friction_is_weak():
    law, point = ss.laws.polynomial.typical(), {"N": 0.01, "k": 100.0, "V": 0.5}
    for part in (0.92, 0.96, 0.99):
        c = part * 0.01 * 0.45 * (1 - 0.25)
        (cycle,) = ss.limit_cycles(law, paper_oscillator(c, **point))
        square = 4 * (1 - 0.25) - 8 * c / (3 * 0.01 * 0.3)
        assert cycle.amplitude == pytest.approx(math.sqrt(square), rel=1e-5)


def test_no_cycle_is_isolated_without_friction_and_damping():
    assert ss.limit_cycles(ss.laws.coulomb.typical(), paper_oscillator(0.0)) == ()
    assert ss.limit_cycles(ss.laws.exponential.typical(), paper_oscillator(0.0, N=0.0)) == ()


KINKED = ss.FrictionLaw("Piecewise((0.5 - 0.2*v, v < 0.7), 0.36)")
JUMPING = ss.FrictionLaw("Piecewise((0.5 - 0.2*v, v < 0.7), 0.38)")
MEASURED = ss.FrictionLaw.from_samples([0, 0.2, 0.4, 0.6, 0.8, 1.2], [0.5, 0.47, 0.43, 0.4, 0.39, 0.39])


@pytest.mark.parametrize("law", [KINKED, JUMPING, MEASURED, ss.FrictionLaw("0.5 - 0.4*v + 0.2*v^3", static="0.6")])
def test_a_cycle_of_any_law_is_a_fixed_point_of_its_rounds(law):
    """Kinked, jumping, measured and static; rounds beside it part as its exponent says, or merge by sliding."""
    c = float(needed_damping(law, paper_oscillator()).at(0.6)) * paper_oscillator().impedance
    for cycle in ss.limit_cycles(law, paper_oscillator(c)):
        system = Dimensionless.of(law, paper_oscillator(c))
        A = cycle.amplitude / 0.5
        slip = system.slip(system.turn(1 - A), 1 - A, until=End.MINIMUM, rtol=1e-12, wedge=system.no_wedge, D=-A)
        growth = slip.wedge / (slip.w - 1)
        assert 1 - slip.w == pytest.approx(A, rel=1e-9)
        assert slip.tau / 10 == pytest.approx(cycle.period, rel=1e-9)
        assert math.log(max(growth, 1e-300)) / cycle.period == pytest.approx(cycle.floquet, rel=1e-6)
