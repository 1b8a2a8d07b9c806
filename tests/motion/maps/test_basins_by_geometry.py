"""Basins by the sides of their boundaries, held against simulated starts and against areas that are known."""

from dataclasses import replace

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym import Motion
from stickslip_sym.motion.regimes.separatrix import SlipCurve

METHODS = {False: ("orbit", "equilibrium"), True: ("simulation", "equilibrium")}
BISTABLE = ss.laws.exponential.bind(mu_s=1, mu_m=0.5, alpha=2), ss.Oscillator(m=1, k=1, c=0.1, V=1.5, N=1)


def random_scene(rng, static):
    """Return a law with a static coefficient above mu(0+) or not, and an oscillator near its threshold."""
    mu_s = rng.uniform(0.3, 1.0)
    values = {"mu_s": mu_s, "mu_m": mu_s * rng.uniform(0.3, 0.9), "alpha": rng.uniform(0.5, 4.0)}
    law = ss.laws.exponential.bind(**values)
    if static:
        law = law.with_static("mu_t").bind(mu_t=mu_s * rng.uniform(1.1, 2.0))
    V, N = rng.uniform(0.3, 2.0), rng.uniform(0.3, 3.0)
    grazes, loses = (ss.pure_slip_damping(law, V=V, N=N, m=1.0, k=1.0, method=m).value for m in METHODS[static])
    c = loses + (grazes - loses) * rng.uniform(0.3, 0.9)
    return law, ss.Oscillator(m=1.0, k=1.0, c=c, V=V, N=N)


@pytest.mark.parametrize("seed", [0, 1, *(pytest.param(seed, marks=pytest.mark.thorough) for seed in range(2, 5))])
def test_sides_say_what_simulation_comes_to(seed):
    rng = np.random.default_rng(seed)
    law, osc = random_scene(rng, static=bool(seed % 2))
    centre, reach = osc.N * float(law.mu(osc.V)) / osc.k, 1.5 * osc.V
    x0 = np.sort(centre + rng.uniform(-reach, reach, 9))
    v0 = np.sort(rng.uniform(-1.2, 1.4, 8)) * osc.V
    found = ss.basin_map(law, osc, x0=x0, v0=v0)
    assert (found.simulated, found.disagreements) == (72, 0)
    assert len(found.count()) == 2


def test_a_million_starts():
    law, osc = BISTABLE
    found = ss.basin_map(law, osc, x0=np.linspace(-2, 2, 1000), v0=np.linspace(0, 2, 1000))
    assert (found.simulated, found.disagreements) == (200, 0)
    rest = found.share[Motion.REST]
    assert abs(found.count()[Motion.REST] / 1e6 - rest.value) < 2e-3  # cells along the boundary
    assert rest.error < 1e-8
    assert rest.value + found.share[Motion.STICK_SLIP].value == pytest.approx(1.0, abs=1e-14)
    assert abs(rest.value - 0.3165) < 0.02  # published, from 5,000 simulated starts


def test_wrong_sides_are_noticed(monkeypatch):
    """Where geometry is wrong the simulated sample says so, and is what stands."""
    law, osc = BISTABLE
    x0, v0 = np.linspace(-2, 2, 8), [0.1, 0.5]
    right = ss.basin_map(law, osc, x0=x0, v0=v0)

    def swapped(*arguments, **options):
        found = ss.regime(*arguments, **options)
        return replace(found, basins=found.basins[::-1])

    monkeypatch.setattr("stickslip_sym.motion.maps.basins.regime", swapped)
    wrong = ss.basin_map(law, osc, x0=x0, v0=v0)
    assert wrong.disagreements == 16
    assert "16 simulated ones disagree with geometry" in repr(wrong)
    assert wrong.notes[0, 0] == "geometry says rest"
    assert (wrong.motion == right.motion).all()


def test_areas_of_circles_in_boxes():
    """Without friction and damping orbits are circles, whose areas within boxes are known."""
    rng = np.random.default_rng(5)
    for _ in range(20):
        radius, begin = rng.uniform((0.05, 0), (0.99, 7))
        times = begin + np.cumsum([0.0, *rng.uniform(0.1, 0.4, 40)])
        times = np.append(times[times < begin + 2 * np.pi], begin + 2 * np.pi)
        middle, half = (times[1:] + times[:-1]) / 2, np.diff(times) / 2
        t = middle[:, None] + half[:, None] * -np.cos(np.pi * np.arange(13) / 12)
        curve = SlipCurve.through(radius * np.array([np.sin(t), -np.cos(t)]) + [[[0]], [[1]]])
        q, w = np.sort(rng.uniform(-1, 1, 2)), np.sort(rng.uniform(0, 2, 2))
        assert curve.area_within(q, w) == pytest.approx(disc_in_box(radius, q, w - 1), abs=1e-10)
        assert curve.area_within(*np.array([[-1, 1], [0, 2]])) == pytest.approx(np.pi * radius**2, abs=1e-10)
        level, places = curve.crossings(w)
        reached = [i for i, height in enumerate(w) if abs(1 - height) < radius]
        half = {i: np.sqrt(radius**2 - (1 - w[i]) ** 2) for i in reached}
        assert np.sort(level).tolist() == np.repeat(reached, 2).tolist()
        for i in reached:
            assert np.sort(places[level == i]) == pytest.approx([-half[i], half[i]], abs=1e-10)


def disc_in_box(radius, x, y):
    """Integrate the width of a disc about 0, cut at x, over y from its trace."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    corners = np.sqrt(np.maximum(radius**2 - np.array(x) ** 2, 0.0))
    ends = np.unique(np.clip([*y, *corners, *-corners, -radius, radius], max(y[0], -radius), min(y[1], radius)))
    total = 0.0
    for low, high in zip(np.arcsin(ends[:-1] / radius), np.arcsin(ends[1:] / radius), strict=True):
        angle = (low + high) / 2 + (high - low) / 2 * nodes
        half = radius * np.cos(angle)
        width = np.clip(half, *x) - np.clip(-half, *x)
        total += (high - low) / 2 * float(weights @ (width * half))
    return total


def test_jumps_are_left_to_simulation():
    law = ss.FrictionLaw("Piecewise((0.3, v < 0.2), (0.5, True))")
    osc = ss.Oscillator(m=1, k=100, c=0.5, V=0.5, N=9.81)
    found = ss.basin_map(law, osc, x0=np.linspace(-0.05, 0.2, 4), v0=[0.0, 0.3])
    assert found.simulated == 8
    assert all(share.counted for share in found.share.values())
