"""What an element gives does not depend on its neighbours, nor on the branch that is taken for its block."""

import numpy as np
import pytest

import stickslip_sym as ss

LAWS = ["exponential", "polynomial", "gaussian", "hyperbolic"]
SAME = 2e-15  # relative to the largest term: a rounding or two
SHARES = (0.02, 0.5, 0.98)  # of low speeds in a block


@pytest.mark.parametrize("criterion", ["least_squares", "harmonic"])
@pytest.mark.parametrize("name", LAWS)
def test_neighbours_change_nothing(name, criterion):
    rng = np.random.default_rng(LAWS.index(name))
    average = ss.slope_average(ss.laws.catalogue[name].typical(), criterion)
    for share in SHARES:
        low = rng.random(500) < share
        V = np.where(low, 10 ** rng.uniform(-4, -1, 500), 10 ** rng.uniform(-0.5, 3, 500))
        together = average(V=V, N=9.81)
        alone = np.concatenate([average(V=part, N=9.81) for part in np.split(V, 50)])
        scale = np.abs(together) + (np.abs(together).max() if name == "polynomial" else 0.0)
        assert (np.abs(together - alone) <= SAME * scale).all()


def test_blocks_join_without_a_seam():
    rng = np.random.default_rng(3)
    average = ss.slope_average(ss.laws.exponential)
    V, alpha = rng.uniform(0.01, 3, 64_001), rng.uniform(1, 6, 64_001)
    together = average(V=V, N=9.81, mu_s=0.5, mu_m=0.2, alpha=alpha)
    for part in (slice(0, 7), slice(31_998, 32_003), slice(63_999, 64_001)):
        alone = average(V=V[part], N=9.81, mu_s=0.5, mu_m=0.2, alpha=alpha[part])
        assert together[part] == pytest.approx(alone, rel=SAME)
    exchanged = average(V=V[:9], N=9.81, mu_s=0.5, mu_m=0.2, alpha=alpha[9:18])
    assert not np.allclose(exchanged, together[:9], rtol=1e-3)


def test_no_negative_zero_comes_out():
    average = ss.slope_average(ss.FrictionLaw("0.3"))
    assert not np.signbit(average(V=[0.1, 0.2], N=1.0)).any()
    assert not np.signbit(average(V=0.1, N=1.0))
