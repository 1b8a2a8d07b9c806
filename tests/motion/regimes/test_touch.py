"""Thresholds of many oscillators at once, against those found one by one."""

import numpy as np
import pytest
from families import family_of
from scenes import laws_in_pieces

import stickslip_sym as ss
from stickslip_sym.motion.orbits.orbit import orbits
from stickslip_sym.motion.regimes.touch import touching_dampings
from stickslip_sym.motion.thresholds.grazing import grazing_damping

ESTIMATED = 3  # errors that an estimated one stands for
SMOOTH = ("exponential", "polynomial", "cubic", "linear", "hyperbolic")


def scenes(law, rng, count):
    V, eta = rng.uniform((0.2, 0.2), (0.9, 4.0), (count, 2)).T
    return family_of(law, V, eta), V, eta


@pytest.mark.parametrize("name", SMOOTH)
def test_smooth_laws_have_those_of_collocation_whatever_the_guess(name):
    """Negative ones too."""
    rng = np.random.default_rng(31)
    law = ss.laws.catalogue[name].typical()
    family, V, eta = scenes(law, rng, 8)
    expected = orbits(law, V, eta * V).d / 2
    for guess in (expected, 0.5 * expected, expected + 0.2):
        zeta, error = touching_dampings(family, guess)
        assert (error < 1e-7).all()
        assert (np.abs(zeta - expected) <= ESTIMATED * error).all()


def test_laws_in_pieces_and_in_layers_have_those_of_the_slip_from_the_end_of_stick():
    rng = np.random.default_rng(32)
    known = 0
    for law in [*laws_in_pieces(rng, 8), ss.laws.logarithmic.typical(), ss.laws.catalogue["simscape"].typical()]:
        family, V, eta = scenes(law, rng, 2)
        zeta, error = touching_dampings(family, np.full(2, 0.1))
        for i in range(2):
            osc = ss.Oscillator(m=1, k=1, V=V[i], N=eta[i] * V[i])
            try:
                value, doubt = grazing_damping(law, osc, rtol=1e-10)
            except ss.NoThreshold:
                assert not zeta[i] > 0
                continue
            known += 1
            assert abs(zeta[i] - value / 2) <= ESTIMATED * error[i] + doubt * value, (law, osc)
    assert known > 8


def test_where_there_is_none_there_is_no_number():
    """A guess that is none, and a law that has no value on the way."""
    law = ss.FrictionLaw.from_samples([0, 0.1, 0.3, 0.5], [0.5, 0.4, 0.3, 0.25])
    family, *_ = scenes(law, np.random.default_rng(33), 4)
    zeta, error = touching_dampings(family, np.full(4, 0.1))
    assert np.isnan(zeta[family.V > 0.4]).all()
    assert np.isnan(error[family.V > 0.4]).all()
    zeta, _ = touching_dampings(family_of(ss.laws.exponential.typical(), *np.ones((2, 1))), np.full(1, np.nan))
    assert np.isnan(zeta).all()
