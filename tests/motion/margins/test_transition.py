"""The search for transition speeds, on thresholds that are known functions of the belt's speed."""

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym.motion.margins import transition
from stickslip_sym.motion.thresholds.rungs import rungs
from stickslip_sym.motion.thresholds.scenes import Scenes

SCENE = {"N": 9.81, "m": 1.0, "k": 100.0}
GRID = 10.0 ** np.linspace(-12, 12, 385)


def search_of(threshold, c, law=None):
    """Return the search for the roots of threshold(V) - c."""
    search = transition.Search(law or ss.laws.exponential.typical(), c, Scenes.of(None, V=1.0, N=1.0))
    search.excess = lambda rung, V, *_: threshold(V) - c
    return search


def test_the_finer_grid_encloses_every_root():
    """In every interval of the coarse one, the first and the last too."""
    ends = np.random.default_rng(7).uniform(0, 1, GRID.size - 1)
    for root in (GRID[:-1] * (GRID[1:] / GRID[:-1]) ** ends)[[0, 1, 57, 200, -2, -1]]:
        near = search_of(lambda V: V, root).near(GRID)
        assert near[0] < root < near[-1]
        assert np.diff(np.log10(near)) == pytest.approx(1 / 64)


def test_crossings_are_changes_of_sign_and_lone_zeros():
    """Of lines through -1, 0 and 1; a zero at an end or beside another is a threshold too small for its digits."""
    rng = np.random.default_rng(8)
    for n in (*rng.integers(2, 9, 60), 3):
        V, off = np.exp(np.arange(float(n))), rng.integers(-1, 2, n).astype(float)
        search = search_of(lambda given, V=V, off=off: np.interp(given, V, off), 0.0)
        expected = [(V[i] + V[i + 1]) / 2 for i in range(n - 1) if off[i] * off[i + 1] < 0]
        expected += [V[i] for i in range(1, n - 1) if off[i] == 0 and off[i - 1] != 0 and off[i + 1] != 0]
        found = search.crossings(rungs()["orbit"], V)
        assert sorted(found) == pytest.approx(sorted(expected), rel=1e-12)


def test_two_crossings_between_neighbours_of_a_grid_are_found():
    """At each inner point, the one before the last too, and nothing of the other dip beside it."""
    x = np.arange(6.0)
    for i in range(1, 5):
        for sign in (-1, 1):

            def threshold(V, i=i, sign=sign):
                return 1.0 + sign * ((np.log(V) - i - 0.2) ** 2 - 0.01)

            found = np.log(search_of(threshold, 1.0).crossings(rungs()["orbit"], np.exp(x)))
            assert sorted(found) == pytest.approx([i + 0.1, i + 0.3], abs=1e-12)


def test_the_error_of_a_speed_is_known_where_the_threshold_is_zero():
    """The relative error of the threshold is nothing there, and that beside it serves."""
    (found,) = ss.transition_speed(ss.laws.polynomial.typical(), c=0.0, **SCENE, method="orbit")
    assert 0 < found.error < 1e-9


def test_how_far_a_speed_is_from_the_exact_one_is_told_by_a_step():
    law, c = ss.laws.polynomial.typical(), 2.0
    search = transition.Search(law, c, Scenes.of(law, V=1.0, **SCENE))
    (exact,) = search.roots(rungs()["orbit"])
    for off in (-1e-2, 1e-3, 1e-4):
        assert search.distance(np.array([exact * (1 + off)]), 1e-6) == pytest.approx(abs(off), rel=0.1)
    assert search.distance(np.empty(0), 1e-6).size == 0
