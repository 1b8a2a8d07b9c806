"""The damping that slip orbits need, found at some amplitudes, against collocation and against motions."""

import numpy as np
import pytest
from scenes import TWO, laws_in_pieces, paper_oscillator

import stickslip_sym as ss
from stickslip_sym.model.oscillator import Scene
from stickslip_sym.motion.maps.cells import Reason
from stickslip_sym.motion.orbits.cycles import needed_damping
from stickslip_sym.motion.regimes.needed import NODES, needed_at_nodes
from stickslip_sym.motion.simulation.levels import Levels


def nodes_of(law, osc, zeta):
    at_rest = -osc.N * law.slope(osc.V) / (2 * osc.impedance)
    return needed_at_nodes(Levels(Scene.of(law, osc)), at_rest, np.array(zeta), at_rest)


@pytest.mark.parametrize("law", [TWO, ss.laws.exponential.typical(), ss.laws.polynomial.typical()])
def test_nodes_are_those_of_collocation(law):
    osc = paper_oscillator()
    exact = needed_damping(law, osc)
    asked = np.linspace(0.01, 0.3, 40)
    found = nodes_of(law, osc, asked)
    expected = np.r_[exact.at(0.0), exact.at(NODES)] / 2
    assert (np.abs(found.zeta - expected) <= found.error + 1e-7).all()
    # A damping is on the right side of each node, or known not to be told from it; and so of each fold.
    known = ~found.undecided(asked)
    assert known.mean() > 0.8
    assert ((asked[known, None] > found.zeta) == (asked[known, None] > expected)).all()
    for c in asked[known]:
        crossed = np.count_nonzero(np.diff(found.zeta > c))
        assert crossed == exact.amplitudes(2 * c).size, c


def test_a_fold_and_a_node_are_not_told_from_dampings_beside_them():
    osc = paper_oscillator()
    exact = needed_damping(TWO, osc)
    folds = exact.at(exact.folds) / 2
    assert folds.size == 1
    found = nodes_of(TWO, osc, folds)
    assert found.undecided(folds).all()
    assert found.undecided(found.zeta[[5, 20]]).all()
    far = np.array([found.zeta.min(), found.zeta.max()]) + np.array([-0.05, 0.05])
    assert not found.undecided(far).any()


def test_maps_of_laws_in_pieces_are_what_motions_give():
    rng = np.random.default_rng(3)
    for law in laws_in_pieces(rng, 4):
        V, c = rng.uniform(0.2, 0.7), np.sort(rng.uniform(0.1, 5, 12))
        found = ss.motion_map(law, x=("V", [V]), y=("c", c), N=9.81, m=1, k=200)
        assert (found.reason != Reason.SIMULATED).mean() > 0.6
        for row in rng.choice(12, 3, replace=False):
            osc = paper_oscillator(c[row], V=V, k=200)
            expected = ss.regime(law, osc, rtol=1e-10)
            assert found.stick_slip[row, 0] == (expected.stick_slip is not None)
            assert found.rest[row, 0] == expected.rest.stable
            assert found.pure_slip[row, 0] == any(cycle.stable for cycle in expected.cycles)
            assert found.motion[row, 0] == ss.classify(law, osc)


def test_the_least_squares_curve_of_measured_points_is_the_criterion():
    rng = np.random.default_rng(5)
    for law in laws_in_pieces(rng, 12)[::4]:
        V = rng.uniform(0.05, 1.5, 3)
        found = ss.motion_map(law, x=("V", np.sort(V)), y=("c", [50.0]), N=9.81, m=1, k=100)
        expected = ss.pure_slip_damping(law, V=np.sort(V), N=9.81, method="least_squares").value
        assert found.thresholds["least_squares"][0] == pytest.approx(expected, rel=1e-11)
