"""Where a function of amplitude lies above levels, against its roots, and against motions."""

import numpy as np
from numpy.polynomial import Chebyshev

from stickslip_sym.motion.roots import orbit_signs

A = np.linspace(0, 1, 20_001)
MARGIN = 1e-4  # of a level from an extremum, from which on it is decided by values


def test_roots_of_random_curves_are_found():
    rng = np.random.default_rng(61)
    curves = [Chebyshev(rng.normal(size=5) / (1 + np.arange(5)) ** 2, domain=[0, 1]) for _ in range(60)]
    levels = rng.uniform(-1, 1, (60, 7))

    def value(rows, amplitudes):
        return np.array([curves[row](amplitude) for row, amplitude in zip(rows, amplitudes, strict=True)])

    found = orbit_signs(value, levels, np.array([curve(0.0) for curve in curves])[:, None] > levels)
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
