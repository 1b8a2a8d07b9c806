"""Pure-slip limit cycles against simulation from both sides, and their number."""

import math
from dataclasses import replace

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym.criteria.rule import gauss_average
from stickslip_sym.motion.kernel.slip_data import SlipEnd
from stickslip_sym.motion.orbits.damping import needed_damping
from stickslip_sym.motion.slip import NondimensionalOscillator
from support.operating_points import TWO, WAVY, WAVY_POINT, paper_oscillator
from support.sweeps import sweep


def test_every_cycle_of_a_balance_not_monotone():
    harmonic = [9.81 * (0.3 + 6 * a**2 / 4 - 40 * a**4 / 8) for a in (0.0, 0.5)]
    assert harmonic == pytest.approx([2.943, 3.556125])
    numbers = {
        c: [cycle.stable for cycle in ss.limit_cycles(TWO, paper_oscillator(c))] for c in (2.9, 3.3, 3.8, 4.1)
    }
    assert numbers == {2.9: [], 3.3: [False], 3.8: [False, True], 4.1: []}
    inner, outer = ss.limit_cycles(TWO, paper_oscillator(3.8))
    assert inner.amplitude < outer.amplitude
    # A motion between them grows, and one inside the inner one shrinks.
    for v0, change in ((0.95 * outer.amplitude, 1), (0.9 * inner.amplitude, -1)):
        motion = ss.simulate(TWO, paper_oscillator(3.8), t_end=10.0, x0=9.81 * 0.4 / 100, v0=v0)
        assert np.sign(motion.change) == change


@sweep("name", ["exponential", "polynomial"], "exponential")
def test_cycles_live_between_hopf_point_and_threshold(name):
    law = ss.laws.catalogue[name].typical()
    hopf = ss.pure_slip_damping(law, V=0.5, N=9.81, method="equilibrium").value
    graze = ss.pure_slip_damping(law, V=0.5, N=9.81, m=1, k=100, method="orbit", rtol=1e-12).value
    for part in (1e-3, 0.5, 1 - 1e-6):
        (cycle,) = ss.limit_cycles(law, paper_oscillator(hopf + part * (graze - hopf)))
        assert cycle.amplitude == pytest.approx(0.5, rel=1e-5) if part > 0.9 else cycle.amplitude < 0.49
    for part in (-1e-3, 1 + 1e-6):
        assert ss.limit_cycles(law, paper_oscillator(hopf + part * (graze - hopf))) == ()


def test_amplitude_for_weak_friction_is_closed():
    law, point = ss.laws.polynomial.typical(), {"N": 0.01, "k": 100.0, "V": 0.5}
    for part in (0.92, 0.96, 0.99):
        c = part * 0.01 * 0.45 * (1 - 0.25)
        (cycle,) = ss.limit_cycles(law, paper_oscillator(c, **point))
        square = 4 * (1 - 0.25) - 8 * c / (3 * 0.01 * 0.3)
        assert cycle.amplitude == pytest.approx(math.sqrt(square), rel=1e-5)


def test_no_cycle_is_isolated_without_friction_and_damping():
    assert ss.limit_cycles(ss.laws.coulomb.typical(), paper_oscillator(0.0)) == ()
    assert ss.limit_cycles(ss.laws.exponential.typical(), paper_oscillator(0.0, N=0.0)) == ()


def test_floquet_exponent_is_slope_of_needed_damping():
    """By the averaged equation dA/dt = A (need(A) - c)/(2 m), whose exponent at a cycle is A need'(A)/(2 m)."""
    law, h = ss.laws.polynomial.typical(), 1e-5
    low, cycle, high = (ss.limit_cycles(law, paper_oscillator(c))[0] for c in (3.25 - h, 3.25, 3.25 + h))
    slope = 2 * h / (high.amplitude - low.amplitude)
    assert cycle.floquet == pytest.approx(cycle.amplitude * slope / 2, rel=0.02)


GRID = np.linspace(0.005, 0.999, 100)


def growth(law, osc, amplitudes):
    """Return the sign of the growth of a motion in one round, from peaks over V: 0 within rounding."""
    system = NondimensionalOscillator.of(law.bound, osc)
    system = replace(system, table=replace(system.table, static=system.table.onset))
    q = np.array([system.turn(w) for w in (1 - amplitudes).tolist()])
    slips = system.slips(q, 1 - amplitudes, until=SlipEnd.MINIMUM, rtol=1e-12)
    out = np.isin(slips.end, (SlipEnd.RETURN, SlipEnd.OUTSIDE))
    off = np.select([slips.end == SlipEnd.MINIMUM, out], [1 - slips.w, math.inf], 0.0) - amplitudes
    return np.sign(off) * (np.abs(off) > 1e-11)


def contradictions(law, osc, cycles):
    """Return where simulated rounds contradict cycles: from 100 amplitudes, and from both sides of each cycle."""
    A = np.array([cycle.amplitude for cycle in cycles]) / osc.V
    signs = growth(law, osc, GRID)
    sure = np.flatnonzero(signs)
    odd = np.diff(np.searchsorted(A, GRID[sure])) % 2 == 1
    wrong = GRID[sure][1:][odd != (np.diff(signs[sure]) != 0)].tolist()
    if not cycles:
        return wrong
    gaps = np.diff([0.0, *A, 1.0])
    step = np.minimum(1e-6 * A, np.minimum(gaps[:-1], gaps[1:]) / 3)
    way = np.where([cycle.stable for cycle in cycles], 1, -1)
    sides = (growth(law, osc, A - step) == -way) | (growth(law, osc, A + step) == way)
    return [*wrong, *A[sides].tolist()]


def random_law(u, V, waves):
    """Return a law with waves on a fall, or of three lines that meet in kinks and jumps."""
    if waves:
        wave = f"{10 ** u(-3, -1.7):.5f}*cos({u(10, 60) / V:.4f}*v+{u(0, 6):.3f})*exp(-(v/{u(0.5, 3) * V:.4f})^2)"
        return ss.FrictionLaw(f"{u(0.2, 0.4):.4f}+{u(0.05, 0.3):.4f}*exp(-v/{u(0.3, 2):.4f})+{wave}")
    first, second = np.sort(u(0.1, 2, 2)) * V
    levels, slopes = u(0.3, 0.6, 3), u(-0.3, 0.3, 2) / V
    if u() < 0.5:  # a kink
        levels[1] = levels[0] + slopes[0] * first
    lines = [
        f"{level:.6f}+({slope:.4f})*(v-{v:.4f})"
        for level, slope, v in zip(levels[:2], slopes, (0, first), strict=True)
    ]
    return ss.FrictionLaw(
        f"Piecewise(({lines[0]}, v<{first:.4f}), ({lines[1]}, v<{second:.4f}), ({levels[2]:.4f}, True))"
    )


def random_point(seed):
    """Return a law and an oscillator at the damping of one of its orbits, or beside."""
    rng = np.random.default_rng([39, seed])
    u, V = rng.uniform, rng.uniform(0.2, 1)
    law, (m, k) = random_law(u, V, seed % 2 == 0), 10 ** u(-1, 1, 2)
    osc = ss.Oscillator(m=m, k=k, c=0.0, V=V, N=10 ** u(-1.3, 0.5) * V * math.sqrt(m * k))
    c = float(needed_damping(law, osc).at(u(0.05, 0.95))) * osc.impedance
    return law, replace(osc, c=c * (1 + rng.choice([0.0, 1e-4, -1e-4, 0.01, -0.01])))


@sweep("seed", range(200), 0, 1, 2, 3, 5)
def test_cycles_of_waves_and_jumps_are_those_of_simulated_rounds(seed):
    law, osc = random_point(seed)
    assert contradictions(law, osc, ss.limit_cycles(law, osc)) == []


def test_waves_have_two_cycles_between_amplitudes_that_shrink():
    inner, outer = ss.limit_cycles(WAVY, WAVY_POINT)
    assert (inner.stable, outer.stable) == (False, True)
    assert contradictions(WAVY, WAVY_POINT, (inner, outer)) == []
    assert contradictions(WAVY, WAVY_POINT, ()) != []  # the simulation sees the two of them
    assert contradictions(WAVY, WAVY_POINT, (inner,)) != []
    assert [str(one).split(" of")[0] for one in ss.regime(WAVY, WAVY_POINT).attractors] == [
        "rest at x = 0.0366193 m", "pure slip with a highest velocity",
    ]  # fmt: skip


def test_two_cycles_as_close_as_a_thousandth():
    """Beside each fold of the damping that orbits need, on the side where it has two cycles."""
    need = needed_damping(WAVY, WAVY_POINT)
    inside = need.turns[1:-1]
    assert len(inside) == 6
    for i, turn in enumerate(inside):
        way = 1 if turn.value > need.turns[i].value else -1  # a maximum: cycles below it
        bend = abs(sum(need.at([turn.x - 1e-3, turn.x + 1e-3])) - 2 * turn.value) / 1e-6
        for side, number in ((1, 2), (-1, 0)):
            damping = turn.value - way * side * bend * 4e-4**2 / 2
            osc = replace(WAVY_POINT, c=damping * WAVY_POINT.impedance)
            near = [one for one in ss.limit_cycles(WAVY, osc) if abs(one.amplitude / osc.V - turn.x) < 2e-3]
            assert len(near) == number
            assert sum(one.stable for one in near) == number // 2
            if near:
                assert near[1].amplitude - near[0].amplitude == pytest.approx(8e-4 * osc.V, rel=0.1)


def test_what_is_not_resolved_is_named(monkeypatch):
    """With too few orbits; not where a motion goes through all amplitudes, so that no cycle is there."""
    law = WAVY.bind(w=55.3)
    monkeypatch.setattr("stickslip_sym.motion.orbits.damping.MOST_ORBITS", 16)
    with pytest.raises(ss.NotConverged, match=r"amplitudes from 0\.0004468 to 0\.4468 m/s are not resolved"):
        ss.limit_cycles(law, WAVY_POINT)
    assert ss.limit_cycles(law, replace(WAVY_POINT, c=10.0)) == ()


KINKED = ss.FrictionLaw("Piecewise((0.5 - 0.2*v, v < 0.7), 0.36)")
JUMPING = ss.FrictionLaw("Piecewise((0.5 - 0.2*v, v < 0.7), 0.38)")
AT_BELT_SPEED = ss.FrictionLaw("Piecewise((0.5 - 0.2*v, v < 0.5), 0.38)")
MEASURED = ss.FrictionLaw.from_samples([0, 0.2, 0.4, 0.6, 0.8, 1.2], [0.5, 0.47, 0.43, 0.4, 0.39, 0.39])


@pytest.mark.parametrize(
    "law", [KINKED, JUMPING, AT_BELT_SPEED, MEASURED, ss.FrictionLaw("0.5 - 0.4*v + 0.2*v^3", static="0.6")]
)
def test_cycles_are_fixed_points_of_their_rounds(law):
    """Kinked, jumping, measured and static; rounds beside it part as its exponent says, or merge by sliding."""
    c = float(needed_damping(law, paper_oscillator()).at(0.6)) * paper_oscillator().impedance
    for cycle in ss.limit_cycles(law, paper_oscillator(c)):
        system = NondimensionalOscillator.of(law.bound, paper_oscillator(c))
        A = cycle.amplitude / 0.5
        slip = system.slip(
            system.turn(1 - A), 1 - A, until=SlipEnd.MINIMUM, rtol=1e-12, wedge=(system.difference, -A)
        )
        growth = slip.wedge / (slip.w - 1)
        assert 1 - slip.w == pytest.approx(A, rel=1e-9)
        assert slip.tau / 10 == pytest.approx(cycle.period, rel=1e-9)
        assert math.log(max(growth, 1e-300)) / cycle.period == pytest.approx(cycle.floquet, rel=1e-6)


def test_orbit_that_touches_a_jump_parts_basins():
    """Motions just inside it shrink; those outside pass the jump, and grow: it attracts none, in maps too."""
    law = ss.FrictionLaw("Piecewise((0.23 + 0.32*exp(-v), v < 0.84), (0.116 + 0.16*v, True))")
    osc = ss.Oscillator(V=0.56, N=25.9, m=6.2, k=88, c=4.9)
    (cycle,) = ss.limit_cycles(law, osc)
    x0 = (osc.N * float(law.mu(osc.V - cycle.amplitude)) - osc.c * cycle.amplitude) / osc.k
    ends = [ss.classify(law, osc, x0=x0, v0=part * cycle.amplitude) for part in (0.999, 1.001)]
    assert (cycle.stable, cycle.floquet, ends) == (False, math.inf, [ss.Motion.REST, ss.Motion.STICK_SLIP])
    assert [str(one).split()[0] for one in ss.regime(law, osc).attractors] == ["rest", "stick-slip"]


STIFF = ss.Oscillator(m=10, k=1e8, c=2.3, V=0.5, N=9.81)


@sweep("name", ss.laws.catalogue, "exponential", "cubic")
def test_weak_friction_has_the_cycles_of_averaging(name):
    """eta = 6e-4: limit cycles are where the harmonic average of an orbit's slope is the damping, by eta^2 off."""
    law = ss.laws.catalogue[name].typical()
    cycles = ss.limit_cycles(law, STIFF)
    A = np.linspace(1e-3, 1, 400)
    mean = STIFF.N * gauss_average(law.bound, np.full(A.size, STIFF.V), A)[0]
    places = np.flatnonzero(np.diff(np.sign(mean - STIFF.c)))
    assert len(cycles) == len(places)
    for cycle, place in zip(cycles, places.tolist(), strict=True):
        assert A[place] - 1e-5 <= cycle.amplitude / STIFF.V <= A[place + 1] + 1e-5
    if name == "exponential":
        assert cycles[0].amplitude == pytest.approx(0.37578264, abs=2e-8)
