"""Thresholds of laws that vary quickly somewhere: every method is right within its error, or refuses."""

from contextlib import suppress

import numpy as np
import pytest

import stickslip_sym as ss
from support.narrow_laws import SHAPES, narrow_law, parted
from support.sweeps import sample, sweep
from support.threshold_by_scipy import lies_between

NARROW = [("step", 1), ("bump", 1), ("sech", 5), ("layer", 2), ("nested", 3)]
METHODS = ["auto", "simulation", "orbit", "second_order"]
EACH_BY_ALL = [(*law, method) for law in NARROW for method in METHODS]
WEAK = 1e-4  # N/(V sqrt(k m)): the threshold is that of the harmonic criterion up to the square of it


@sample(6)
@sweep(
    ("shape", "seed", "method"),
    EACH_BY_ALL,
    *EACH_BY_ALL[::3],
    *EACH_BY_ALL[2::3],
)
def test_weak_friction_against_enclosures(shape, seed, method):
    """The enclosed integral knows every place; no grid, step or table may step over one."""
    law, V, _ = narrow_law(shape, seed)
    N = WEAK * V * 10
    exact = float(ss.enclose(law, "harmonic", V=V, N=N, digits=12))
    try:
        found = ss.pure_slip_damping(law, V=V, N=N, m=1, k=100, method=method, rtol=1e-6)
    except (ss.InputError, ss.NotConverged):
        assert method in ("orbit", "second_order")
    else:
        assert abs(found.value - exact) <= (found.relative_error + 1e-6) * abs(exact)


BATCHES, BATCH = 50, 6
NOISE = 3e-11, 1e-10  # of the integration: in kg/s, and relative


@sweep("batch", range(BATCHES), 1)  # this one notices widths that are compared in m/s
def test_random_laws_against_an_integration_that_knows_the_place(batch):
    """Of 300 laws every value is right within twice its error; "auto" refuses one in six of a batch at most."""
    refused, unknown = 0, 0
    for seed in range(batch * BATCH, (batch + 1) * BATCH):
        shape, draw = list(SHAPES)[seed % len(SHAPES)], 1000 + seed
        law, V, _ = narrow_law(shape, draw)
        eta = 10 ** np.random.default_rng(seed).uniform(-1.8, 1)  # N/(V sqrt(k m)), of friction that falls by 0.3
        found = {}
        for method in METHODS:
            with suppress(ss.InputError, ss.NotConverged):
                found[method] = ss.pure_slip_damping(law, V=V, N=10 * eta * V, m=1, k=100, method=method)
        refused += "auto" not in found
        known = {method: one for method, one in found.items() if one.error is not None}
        ranges = {(one.value, one.error): (shape, draw, method) for method, one in known.items()}
        for (value, error), what in ranges.items():
            off = 2 * error + NOISE[0] + NOISE[1] * abs(value)
            inside = lies_between(*parted(shape, draw), eta, (value - off) / 20, (value + off) / 20)
            assert inside is not False, what
            unknown += inside is None
    assert refused <= BATCH / 6
    assert unknown <= BATCH / 3


def test_narrow_bump_moves_the_threshold_by_its_area():
    """Steps that miss the bump say the threshold of the law without it, and an error of 1e-11."""
    point = {"V": 0.5, "N": 9.81, "m": 1, "k": 100, "method": "simulation", "rtol": 1e-11}
    plain, narrow, wide = (
        ss.pure_slip_damping(f"0.2 + 0.3*exp(-3*v) + 0.1*exp(-((v - 0.3)/{w})^2)*{on}", **point).value
        for w, on in (("1", "0"), ("0.00000001", "1"), ("0.00001", "1"))
    )
    assert (wide - plain) / (narrow - plain) == pytest.approx(1000, rel=1e-3)


@pytest.mark.parametrize("method", ["auto", "simulation", "orbit"])
def test_bump_of_a_law_that_is_flat_elsewhere(method):
    """No phase of a first guess meets it; to second order in the friction the threshold is that of the average."""
    law, point = "0.3 + 0.1*exp(-((v - 0.3)/0.00001)^2)", {"V": 0.5, "N": 0.1}
    exact = float(ss.enclose(law, "harmonic", **point, digits=12))
    found = ss.pure_slip_damping(law, **point, m=1, k=100, method=method)
    assert found.value == pytest.approx(exact, rel=1e-5)


def test_steep_step_is_seen_by_every_method():
    law, point = "0.2 + 0.3*exp(-3*v) - 0.02*tanh((v - 0.3)/0.0001)", {"V": 0.5, "N": 9.81, "m": 1, "k": 100}
    for method in ("auto", "simulation", "orbit"):
        found = ss.pure_slip_damping(law, **point, method=method)
        assert found.value == pytest.approx(3.030433391177, rel=1e-11)
    assert ss.pure_slip_damping(law, **point, method="second_order").relative_error > 0.1


@pytest.mark.parametrize(("N", "most"), [(1, 1e-9), (100, 1e-9), (1000, 1e-8)])
def test_threshold_has_its_digits_whatever_error_is_good_enough(N, most):
    law, point = "0.2 + 0.3*exp(-3*v)", {"V": 0.5, "N": N, "m": 1, "k": 100, "method": "simulation"}
    found, sure = ss.pure_slip_damping(law, **point), ss.pure_slip_damping(law, **point, rtol=1e-10)
    assert found.relative_error <= most
    assert abs(found.value - sure.value) <= found.error + sure.error


def test_orbit_that_passes_a_jump_between_its_phases():
    smooth = "0.2 + 0.3*exp(-3*v)"
    law = f"Piecewise(({smooth}, v < 1.00210804), ({smooth} + 0.1, True))"  # 3e-5 below the highest slip speed
    point = {"V": 0.5, "N": 9.81, "m": 1, "k": 100}
    with pytest.raises(ss.InputError, match=r"a kink at v = 1\.00211, which the orbit passes"):
        ss.pure_slip_damping(law, **point, method="orbit")
    assert ss.pure_slip_damping(law, **point).value == pytest.approx(2.572742, rel=1e-6)


@pytest.mark.parametrize("V", [1e-15, 1e-17, 1e-25])
def test_slowest_belts(V):
    point = {"V": V, "N": 9.81, "m": 1, "k": 100}
    for method in ("simulation", "proof"):
        found = ss.pure_slip_damping(ss.laws.exponential.typical(), **point, method=method)
        assert abs(found.value / 8.829 - 1) <= found.relative_error
