"""What an element gives does not depend on its neighbours, nor on the branch that is taken for its block."""

import tracemalloc
from math import inf

import numpy as np
import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym.core.symbols import v
from stickslip_sym.formula.evaluation.profile import profile_of

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
        assert together[part] == pytest.approx(alone, rel=SAME, abs=0)
    exchanged = average(V=V[:9], N=9.81, mu_s=0.5, mu_m=0.2, alpha=alpha[9:18])
    assert not np.allclose(exchanged, together[:9], rtol=1e-3)


def test_no_negative_zero_comes_out():
    average = ss.slope_average(ss.FrictionLaw("0.3"))
    assert not np.signbit(average(V=[0.1, 0.2], N=1.0)).any()
    assert not np.signbit(average(V=0.1, N=1.0))


PROFILES = [
    (sp.exp(-v), "least_squares"),
    (v * sp.exp(-v), "least_squares"),
    (sp.tanh(v), "harmonic"),
    (v**3 + v, "harmonic"),
]


@pytest.mark.parametrize(("mu", "criterion"), PROFILES)
def test_a_block_takes_the_fewest_branches_that_serve_it(mu, criterion):
    profile = profile_of(mu, getattr(ss.criteria, criterion))
    assert profile.ends[-1] == inf
    rng = np.random.default_rng(5)
    places = np.concatenate([2 ** rng.uniform(-40, 70, 60), profile.starts, profile.ends[:-1]])
    for low, high in np.sort(rng.choice(places, (200, 2))):
        branches, edges = profile.cover(low, high)
        bounds = [low, *edges, high]
        for branch, first, last in zip(branches, bounds[:-1], bounds[1:], strict=True):
            which = profile.branches.index(branch)
            assert profile.starts[which] <= first <= last <= profile.ends[which]
        assert all(low < edge <= high for edge in edges)
        assert len(branches) == fewest(profile, low, high)


def fewest(profile, low, high):
    """Count the branches of a cover: from each place on, the one that reaches furthest."""
    count, place = 0, low
    while True:
        count += 1
        place = max(end for start, end in zip(profile.starts, profile.ends, strict=True) if start <= place)
        if place > high:
            return count


def test_far_out_no_exponential_is_computed():
    """A block of large r takes the polynomial in 1/r alone, beside which exp(-2 r) is nothing."""
    profile = profile_of(sp.exp(-v), ss.criteria.least_squares)
    (branch,), edges = profile.cover(25.0, 1e9)
    assert branch.decay == 0
    assert branch.variable == -1
    assert not edges
    (branch,), edges = profile.cover(3.0, 1e9)
    assert profile.ends[profile.branches.index(branch)] > 1e9


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
