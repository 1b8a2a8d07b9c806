"""Planes whose cells are scenes of their own, against simulation."""

import numpy as np
import pytest
from scenes import laws_in_pieces
from test_maps import agree, some_cells

import stickslip_sym as ss
from stickslip_sym.motion.maps.cells import Reason

V, N, K = ("V", np.linspace(0.15, 0.8, 6)), ("N", np.linspace(2, 20, 5)), ("k", np.geomspace(20, 600, 5))
ALONE = (Reason.SIMULATED, Reason.FAILED)
PLANES = {
    "exponential": {"x": V, "y": N, "c": 2, "m": 1, "k": 100},
    "logarithmic": {"x": V, "y": K, "c": 0.8, "m": 1, "N": 9.81},
    "arcsinh": {"x": V, "y": N, "c": 1, "m": 1, "k": 100},
    "gaussian": {"x": N, "y": V, "c": 3, "m": 1, "k": 100},
    "polynomial": {"x": ("m", [0.5, 1, 2]), "y": V, "c": 3, "N": 9.81, "k": 100},
    "brown_mcphee": {"x": ("V", [0.3, 0.6]), "y": ("N", [4, 9]), "c": 2, "m": 1, "k": 100},
}

FEW = ("exponential", "brown_mcphee")


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name in FEW else pytest.mark.thorough) for name in PLANES]
)
def test_cells_are_what_simulation_gives(name):
    found = ss.motion_map(ss.laws.catalogue[name].typical(), **PLANES[name])
    assert np.isin(found.reason, ALONE).mean() < 0.1
    assert len(found.count()) > 1
    agree(found.law, found, some_cells(found, 2, seed=51))


@pytest.mark.parametrize("count", [2, pytest.param(4, marks=pytest.mark.thorough)])
def test_cells_of_laws_in_pieces_are_what_simulation_gives(count):
    rng = np.random.default_rng(52)
    for law in laws_in_pieces(rng, count):
        found = ss.motion_map(law, x=("V", V[1][::2]), y=("N", N[1][::2]), c=rng.uniform(0.5, 3), m=1, k=100)
        assert np.isin(found.reason, ALONE).mean() < 0.2
        agree(law, found, some_cells(found, 1, seed=53))


def test_parameters_of_the_law_may_differ_from_cell_to_cell():
    law = ss.laws.exponential.typical()
    found = ss.motion_map(law, x=("alpha", [1, 3, 5]), y=("mu_s", [0.3, 0.5, 0.7]), c=2, V=0.5, N=9.81, m=1, k=100)
    for row, column in np.ndindex(3, 3):
        bound = law.bind(alpha=found.x.values[column], mu_s=found.y.values[row])
        expected = ss.pure_slip_damping(bound, V=0.5, N=9.81, m=1, k=100, method="orbit", rtol=1e-9)
        assert found.thresholds["exact"][row, column] == pytest.approx(expected.value, rel=1e-8)
    assert len(found.count()) > 1
    agree(law, found, [(0, 0), (0, 2), (2, 1)])


def test_a_static_parameter_is_no_parameter_of_the_slip():
    law = ss.laws.exponential.typical().with_static("mu_p", parameters=[ss.Parameter("mu_p", "breakaway", "1")])
    found = ss.motion_map(law, x=("mu_p", [0.5, 0.7]), y=("N", [5, 9.81]), c=2, V=0.5, m=1, k=100)
    for row, column in np.ndindex(2, 2):
        bound, osc = law.bind(mu_p=found.x.values[column]), {"V": 0.5, "N": found.y.values[row], "m": 1, "k": 100}
        expected = ss.pure_slip_damping(bound, **osc, method="simulation", rtol=1e-8).value
        assert found.thresholds["exact"][row, column] == pytest.approx(expected, rel=1e-7)


def test_a_cell_beside_a_threshold_is_not_decided():
    law, scene = ss.laws.exponential.typical(), {"V": 0.5, "m": 1, "k": 100}
    exact = ss.pure_slip_damping(law, **scene, N=9.81, method="orbit", rtol=1e-10).value
    beside = exact * (1 + np.array([-1e-6, 1e-10, 1e-6]))
    motions = [
        ss.motion_map(law, x=("N", [9.81]), y=("V", [0.5]), c=c, m=1, k=100).motion[0, 0].value for c in beside
    ]
    assert motions == ["stick-slip", "undecided", "rest"]


def test_the_least_squares_curve_of_measured_points_is_the_criterion():
    rng = np.random.default_rng(5)
    (law,) = laws_in_pieces(rng, 1)
    V, N = np.sort(rng.uniform(0.05, 1.5, 2)), np.array([3.0, 9.81])
    found = ss.motion_map(law, x=("V", V), y=("N", N), c=50, m=1, k=100)
    expected = ss.pure_slip_damping(law, V=V, N=N[:, None], method="least_squares").value
    assert found.thresholds["least_squares"] == pytest.approx(expected, rel=1e-11)
