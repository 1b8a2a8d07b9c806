"""What an element gives does not depend on its neighbours, nor on the branch that is taken for its block."""

import tracemalloc

import numpy as np
import pytest
from forms import some

import stickslip_sym as ss

LAWS = [
    "exponential", "polynomial", "gaussian", "hyperbolic", "arctangent", "rational", "logarithmic",
    "two_exponentials",
]  # fmt: skip
SAME = 4e-15  # relative: a few roundings, of powers of numbers that are out of range
SHARES = (0.02, 0.5, 0.98)  # of low speeds in a block


@pytest.mark.parametrize("criterion", ["least_squares", "harmonic"])
@pytest.mark.parametrize("name", some(LAWS, 0, 4, 7))
def test_neighbours_change_nothing(name, criterion):
    rng = np.random.default_rng(LAWS.index(name))
    average = ss.slope_average(ss.laws.catalogue[name].typical(), criterion)
    for share in SHARES:
        low = rng.random(500) < share
        V = np.where(low, 10 ** rng.uniform(-4, -1, 500), 10 ** rng.uniform(-0.5, 3, 500))
        together = average(V=V, N=9.81)
        alone = np.concatenate([average(V=part, N=9.81) for part in np.split(V, 50)])
        assert (together == alone).all()
        assert all(average(V=float(one), N=9.81) == value for one, value in zip(V[:100], together, strict=False))


def test_blocks_join_without_a_seam():
    rng = np.random.default_rng(3)
    average = ss.slope_average(ss.laws.exponential)
    V, alpha = rng.uniform(0.01, 3, 64_001), rng.uniform(1, 6, 64_001)
    together = average(V=V, N=9.81, mu_s=0.5, mu_m=0.2, alpha=alpha)
    for part in (slice(0, 7), slice(16_382, 16_387), slice(63_999, 64_001)):
        alone = average(V=V[part], N=9.81, mu_s=0.5, mu_m=0.2, alpha=alpha[part])
        assert (together[part] == alone).all()
    exchanged = average(V=V[:9], N=9.81, mu_s=0.5, mu_m=0.2, alpha=alpha[9:18])
    assert not np.allclose(exchanged, together[:9], rtol=1e-3)


def test_no_negative_zero_comes_out():
    average = ss.slope_average(ss.FrictionLaw("0.3"))
    assert not np.signbit(average(V=[0.1, 0.2], N=1.0)).any()
    assert not np.signbit(average(V=0.1, N=1.0))


@pytest.mark.parametrize(("name", "scale"), [("exponential", "alpha"), ("polynomial", "v_m")])
def test_nothing_over_or_underflows_on_the_way(name, scale):
    """A product of three extreme numbers may be out of range where the damping is not."""
    form, rng = ss.derive(ss.laws.catalogue[name]), np.random.default_rng(7)
    columns = {key: 10 ** rng.uniform(-200, 200, 90) for key in ("V", "N", scale)} | {"mu_s": 0.5, "mu_m": 0.2}
    right = [
        form.evaluate(20, **{key: float(np.broadcast_to(x, 90)[i]) for key, x in columns.items()})
        for i in range(90)
    ]
    here = [i for i, c in enumerate(right) if 1e-290 < abs(c) < 1e290]
    assert len(here) > 20
    taken = {key: x if isinstance(x, float) else x[here] for key, x in columns.items()}
    assert form(**taken) == pytest.approx([float(right[i]) for i in here], rel=SAME, abs=0)


def test_memory_does_not_grow_with_the_length():
    """Beyond the result a call takes a few arrays of one block."""
    average = ss.slope_average(ss.laws.exponential)
    V = np.random.default_rng(6).uniform(0.01, 3, 400_000)
    beyond = []
    for size in (200_000, 400_000):
        values = {"V": V[:size], "N": 9.81, "mu_s": 0.5, "mu_m": 0.2, "alpha": 3.0}
        average(**values)
        tracemalloc.start()
        result = average(**values)
        beyond.append(tracemalloc.get_traced_memory()[1] - result.nbytes)
        tracemalloc.stop()
    assert beyond[1] < 1.1 * beyond[0] < 5e6
