"""Where slip orbits grow, for many oscillators at once, against collocation and against motions."""

import numpy as np
import pytest
from families import family_of
from scenes import TWO, laws_in_pieces, paper_oscillator

import stickslip_sym as ss
from stickslip_sym.motion.orbits.cycles import needed_damping
from stickslip_sym.motion.regimes.patterns import patterns
from stickslip_sym.motion.regimes.slip_orbits import by_simulation


def pattern_of(law, osc, zeta):
    family = family_of(law, np.full(len(zeta), osc.V), np.full(len(zeta), osc.eta))
    at_rest = -osc.N * law.slope(osc.V) / (2 * osc.impedance)
    return patterns(family, np.array(zeta), np.full(len(zeta), at_rest))


@pytest.mark.parametrize("law", [TWO, ss.laws.exponential.typical(), ss.laws.polynomial.typical()])
def test_cycles_are_those_of_collocation(law):
    osc = paper_oscillator()
    exact = needed_damping(law, osc)
    zeta = np.linspace(0.01, 0.3, 40)
    found = pattern_of(law, osc, zeta)
    assert found.known.all()
    roots = [exact.amplitudes(2 * z) for z in zeta]
    assert found.cycle.tolist() == [places.size > 0 for places in roots]
    assert found.stable.tolist() == [bool((exact.slope(places) < 0).any()) for places in roots]
    assert found.grows.tolist() == [bool(exact.at(1.0) > 2 * z) for z in zeta]
    assert 0 < found.cycle.sum() < 40


def test_a_fold_and_a_bifurcation_are_not_told_from_dampings_beside_them():
    osc = paper_oscillator()
    exact = needed_damping(TWO, osc)
    fold = exact.at(exact.folds).item() / 2
    shifts = np.array([-1e-2, -1e-7, 0.0, 1e-7, 1e-2])
    assert pattern_of(TWO, osc, fold + shifts).known.tolist() == [True, False, False, False, True]
    beside = pattern_of(TWO, osc, fold + np.array([-1e-2, -1e-4, 1e-4, 1e-2]))
    for cycle, known, below in zip(beside.cycle, beside.known, (True, True, False, False), strict=True):
        assert cycle == (below and exact.amplitudes(2 * fold - 2e-4).size > 0) or not known
    assert not pattern_of(TWO, osc, exact.at(np.array([0.5])) / 2 * 1e6).grows.any()


def test_laws_in_pieces_have_the_cycles_of_simulation():
    rng = np.random.default_rng(41)
    cycles = 0
    for law in laws_in_pieces(rng, 4):
        osc = paper_oscillator(V=rng.uniform(0.2, 0.7), k=200)
        at_rest = -osc.N * law.slope(osc.V) / (2 * osc.impedance)
        zeta = np.sort(rng.uniform(0.0, 1.5, 3) * max(at_rest, 0.02))
        found = pattern_of(law, osc, zeta)
        for i, z in enumerate(zeta):
            expected = by_simulation(law, paper_oscillator(2 * z * osc.impedance, V=osc.V, k=200), 1e-10)
            assert not found.known[i] or found.cycle[i] == (len(expected.cycles) > 0), (law, osc, z)
            assert not found.known[i] or found.stable[i] == any(cycle.stable for cycle in expected.cycles)
            cycles += len(expected.cycles)
        assert found.known.mean() > 0.7
    assert cycles > 1
