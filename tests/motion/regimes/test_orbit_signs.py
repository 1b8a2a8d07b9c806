"""Where a function of amplitude lies above levels, against its roots, and against motions."""

import numpy as np
import pytest
from numpy.polynomial import Chebyshev
from operating_points import TWO, paper_oscillator

import stickslip_sym as ss
from stickslip_sym.motion.roots import orbit_signs

A = np.linspace(0, 1, 20_001)
MARGIN = 1e-4  # of a level from an extremum, from which on it is decided by values


def signs_of(curves, levels):
    at_rest = np.array([curve(0.0) for curve in curves])[:, None] > levels
    asked = []

    def value(rows, amplitudes):
        asked.append(amplitudes.size)
        return np.array([curves[row](amplitude) for row, amplitude in zip(rows, amplitudes, strict=True)])

    return orbit_signs(value, levels, at_rest), sum(asked)


def test_roots_of_random_curves_are_found():
    rng = np.random.default_rng(61)
    curves = [Chebyshev(rng.normal(size=5) / (1 + np.arange(5)) ** 2, domain=[0, 1]) for _ in range(60)]
    levels = rng.uniform(-1, 1, (60, 7))
    found, _ = signs_of(curves, levels)
    left = {(row, level) for row, level, _, _ in found.open}
    decided = stable = 0
    for row, curve in enumerate(curves):
        d = curve(A)
        for i, level in enumerate(levels[row]):
            above = d > level
            if (row, i) in left:
                turns = curve.deriv().roots()
                turns = turns[(abs(turns.imag) < 1e-9) & (turns.real > 0) & (turns.real < 1)].real
                assert np.abs(curve(turns) - level).min() < 1e-2
                continue
            decided += 1
            assert found.cycle[row, i] == (above[1:] != above[:-1]).any()
            assert found.stable[row, i] == (above[:-1] & ~above[1:]).any()
            assert found.grows[row, i] == above[-1]
            stable += found.stable[row, i]
    assert decided > 400
    assert 50 < stable < 350


@pytest.mark.parametrize("gap", [1e-1, 1e-2, 1e-3, 0.0])
def test_what_touches_a_level_stays_open(gap):
    """A parabola whose top is below a level: by much it is decided, at once or after halvings."""
    found, work = signs_of([lambda a: -((a - 0.4) ** 2)], np.array([[gap]]))
    assert bool(found.open) == (gap == 0)
    assert not found.cycle.any()
    assert work < 20 or gap < 1e-2
    for row, level, low, high in found.open:
        assert (row, level) == (0, 0)
        assert low - 1e-2 < 0.4 < high + 1e-2


def test_what_is_not_known_stays_open():
    found, _ = signs_of([lambda a: np.nan if a > 0.5 else 1.0], np.zeros((1, 1)))
    assert found.open


@pytest.mark.thorough
def test_folds_part_the_cells_beside_them():
    """Columns by needed damping and lone cells by growth alike, down to 1e-6 of the fold."""
    fold = ss.basin_sweep(TWO, paper_oscillator(2.5), ("c", [3.9, 4.2]), x0=(-0.2, 0.2), v0=(-1, 1)).changes[0]
    assert fold.kind == "fold"
    beside = fold.value * (1 + np.array([-1e-3, -1e-6, 1e-6, 1e-3]))
    plane = {"m": 1, "k": 100}
    column = ss.motion_map(TWO, x=("V", [0.5]), y=("c", beside), N=9.81, **plane)
    lone = [ss.motion_map(TWO, x=("V", [0.5]), y=("N", [9.81]), c=c, **plane).motion[0, 0] for c in beside]
    assert column.motion[:, 0].tolist() == lone
    assert [motion.value for motion in lone] == ["pure slip", "pure slip", "rest", "rest"]
    at_fold = ss.motion_map(TWO, x=("V", [0.5]), y=("c", [3.9, fold.value]), N=9.81, **plane)
    assert at_fold.motion[1, 0] is ss.Motion.UNDECIDED
    assert "within" in at_fold.notes[1, 0]
