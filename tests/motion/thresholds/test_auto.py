"""What "auto" gives: the first value that is known to be good enough, and what it costs to know it."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym.motion.thresholds import rungs as ladder
from stickslip_sym.motion.thresholds.rungs import rungs
from stickslip_sym.motion.thresholds.scenes import Scenes

SCENE = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}
SIX = ["exponential", "polynomial", "hyperbolic", "gaussian", "lorentzian", "tanh"]
REFERENCE = 2e-12  # relative error of the orbits that estimates are judged by


@pytest.fixture(scope="module")
def exponential():
    return ss.laws.exponential.typical()


def random_scenes(count):
    """Yield seeded laws, scenes and tolerances; what friction does to the orbit runs over three decades."""
    rng = np.random.default_rng(20160428)
    for number in range(count):
        law = ss.laws.catalogue[SIX[number % len(SIX)]].typical()
        others = {name: float(value) for name, value in law.values.items() if name not in ("mu_s", "mu_m")}
        others = {name: value * 10 ** rng.uniform(-0.3, 0.3) for name, value in others.items()}
        law = law.bind(**others, mu_s=rng.uniform(0.35, 0.9), mu_m=rng.uniform(0.05, 0.3))
        ranges = {"V": (-1.5, 0), "N": (-1, 2), "m": (-2, 2), "k": (1, 5)}
        yield law, {name: 10 ** rng.uniform(*ends) for name, ends in ranges.items()}, 10 ** rng.uniform(-8, -0.3)


def test_estimates_bound_the_error():
    """60 scenes by default; wider runs change nothing but the number."""
    bounded, total = 0, 0
    for law, scene, rtol in random_scenes(60):
        try:
            exact = ss.pure_slip_damping(law, **scene, method="orbit", rtol=1e-12)
        except ss.NotConverged:
            continue
        found = ss.pure_slip_damping(law, **scene, rtol=rtol)
        total += 1
        bounded += abs(found.value / exact.value - 1) <= found.error + REFERENCE
        assert found.error <= rtol
    assert total >= 55
    assert bounded >= 0.99 * total


def test_auto_gives_the_first_value_that_is_good_enough_and_the_closest_it_has(monkeypatch):
    """No value that it computes on its way dominates the one it gives, and none is computed in vain after it."""
    asked = []

    def spied(name, compute):
        def spy(scenes, rtol):
            found = compute(scenes, rtol)
            asked.append((name, found.value[0], found.error[0]))
            return found

        return spy

    def no(*_):
        raise AssertionError("an average does not know its error")

    table = {
        name: replace(
            rung, compute=spied(name, rung.compute), quickly=rung.quickly and spied(f"quick {name}", rung.quickly)
        )
        for name, rung in ladder._table.items()
    }
    monkeypatch.setattr(ladder, "_table", table)
    monkeypatch.setattr(ladder, "average", no)
    orders, last = set(), Counter()
    for law, scene, rtol in random_scenes(40):
        asked.clear()
        found = ss.pure_slip_damping(law, **scene, rtol=rtol)
        name, *of_last = asked[-1]
        assert (found.method, [found.value, found.error]) == (name.removeprefix("quick "), of_last)
        assert found.error <= rtol < min((error for *_, error in asked[:-1]), default=np.inf)
        orders.add(tuple(dict.fromkeys(name for name, *_ in asked)))
        last[name] += 1
    cheapest_first = ("quick second_order", "quick orbit", "simulation", "orbit")
    fine = ("quick second_order", "quick orbit", "orbit", "simulation")  # finer than simulation reaches
    assert all(order in (cheapest_first[: len(order)], fine[: len(order)]) for order in orders)
    assert last["quick second_order"] >= 30  # what is cheap serves as far as it can
    assert last["quick orbit"] >= 7
    assert last["simulation"]


def test_the_name_of_a_rung_is_never_cut(exponential, monkeypatch):
    """Whatever it is called: seeded names of 1 to 60 letters."""
    rng = np.random.default_rng(13)
    second_order = ladder.rungs()["second_order"]
    for length in (1, 13, 14, *rng.integers(15, 61, 5).tolist()):
        name = "".join(rng.choice(list("abcdefghij_"), length))
        monkeypatch.setattr(ladder, "_table", {name: replace(second_order, name=name)} | ladder._table)
        assert ss.pure_slip_damping(exponential, **SCENE, rtol=0.5).method == name
        several = ss.pure_slip_damping(exponential, **SCENE | {"V": [0.5, 0.02, 1.0]}, rtol=0.1)
        assert several.method.dtype.kind == "U"
        assert name in several.method
        assert set(several.method) <= {name, *rungs()}
        monkeypatch.undo()


@pytest.mark.parametrize(
    ("rtol", "method"), [(0.5, "second_order"), (5e-3, "second_order"), (1e-4, "orbit"), (1e-9, "orbit")]
)
def test_auto_climbs_as_far_as_it_must(exponential, rtol, method):
    found = ss.pure_slip_damping(exponential, **SCENE, rtol=rtol)
    assert found.method == method
    exact = ss.pure_slip_damping(exponential, **SCENE, method="simulation", rtol=1e-12).value
    assert abs(found.value / exact - 1) <= found.error + 2e-11
    assert found.error <= rtol


@pytest.mark.parametrize("rtol", [1e-2, 1e-5, 1e-9])
def test_an_expansion_is_resolved_as_far_as_is_asked_for(rtol):
    """For weak friction of a law with a thin layer; for strong friction it would be in vain, and is not."""
    law = ss.laws.exponential.typical(alpha="60")
    weak, strong = (Scenes.of(law, V=1.0, N=N, m=1.0, k=100.0) for N in (1e-3, 1e3))
    value, resolution, next_order = ladder.second_order(weak, rtol)
    assert next_order[0] < 1e-12
    assert resolution[0] <= 0.1 * rtol
    assert value[0] == pytest.approx(ladder.second_order(weak)[0][0], rel=rtol)
    assert ladder.second_order(strong, rtol)[1][0] > 1e-6 > 1e3 * ladder.second_order(strong)[1][0]
