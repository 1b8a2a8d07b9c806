"""Basins of attraction by the sides of their boundaries, against motions that are followed, and known areas."""

from dataclasses import replace

import numpy as np
import pytest
from operating_points import paper_oscillator
from sweeps import sweep

import stickslip_sym as ss
from stickslip_sym import Motion
from stickslip_sym.motion.regimes.classification import followed
from stickslip_sym.motion.regimes.separatrix import SlipCurve
from stickslip_sym.motion.slip import Dimensionless

EXPONENTIAL = ss.laws.exponential.typical()
BISTABLE = ss.laws.exponential.bind(mu_s=1, mu_m=0.5, alpha=2), ss.Oscillator(m=1, k=1, c=0.1, V=1.5, N=1)


def between_thresholds(rng, static):
    """Return a law with a static coefficient above mu(0+) or not, and an oscillator that rests or sticks."""
    mu_s = rng.uniform(0.3, 1.0)
    values = {"mu_s": mu_s, "mu_m": mu_s * rng.uniform(0.3, 0.9), "alpha": rng.uniform(0.5, 4.0)}
    law = ss.laws.exponential.bind(**values)
    if static:
        law = law.with_static("mu_t").bind(mu_t=mu_s * rng.uniform(1.1, 2.0))
    point = {"V": rng.uniform(0.3, 2.0), "N": rng.uniform(0.3, 3.0), "m": 1.0, "k": 1.0}
    grazes, loses = (ss.pure_slip_damping(law, **point, method=one).value for one in ("simulation", "equilibrium"))
    return law, ss.Oscillator(c=loses + (grazes - loses) * rng.uniform(0.3, 0.9), **point)


@sweep("seed", [0, 1, 2, 3, 4], 0, 1)
def test_sides_say_what_motions_come_to(seed):
    """Both of a map, all of whose initial conditions are followed as a check, and of many in any order."""
    rng = np.random.default_rng(seed)
    law, osc = between_thresholds(rng, static=bool(seed % 2))
    centre, reach = osc.N * float(law.mu(osc.V)) / osc.k, 1.5 * osc.V
    x0, v0 = np.sort(centre + rng.uniform(-reach, reach, 9)), np.sort(rng.uniform(-1.2, 1.4, 8)) * osc.V
    found = ss.basin_map(law, osc, x0=x0, v0=v0)
    assert (found.simulated, found.disagreements) == (72, 0)
    assert set(found.count()) == {Motion.STICK_SLIP, Motion.REST}
    assert found.motion[3].tolist() == [ss.classify(law, osc, x0=x, v0=v0[3]) for x in x0]
    x, v = centre + rng.uniform(-reach, reach, 2000), rng.uniform(-1.2, 1.4, 2000) * osc.V
    many = ss.classify(law, osc, x0=x, v0=v)
    some = rng.choice(2000, 100, replace=False)
    assert (many[some] == followed(law, osc, x[some], v[some], rtol=1e-10)).all()


def test_a_million_initial_conditions():
    law, osc = BISTABLE
    found = ss.basin_map(law, osc, x0=np.linspace(-2, 2, 1000), v0=np.linspace(0, 2, 1000))
    assert (found.simulated, found.disagreements) == (200, 0)
    rest = found.share[Motion.REST]
    assert rest.value == pytest.approx(0.307126137780, abs=2e-12)
    assert abs(found.count()[Motion.REST] / 1e6 - rest.value) < 2e-3  # cells along the boundary
    assert rest.error < 1e-8
    assert rest.value + found.share[Motion.STICK_SLIP].value == pytest.approx(1.0, abs=1e-14)
    assert abs(rest.value - 0.3165) < 0.02  # published, from 5,000 simulated initial conditions


def test_wrong_sides_are_noticed(monkeypatch):
    """Where geometry is wrong the sample that is followed says so, and is what stands."""
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
    """Without friction and damping orbits are circles, whose areas within boxes are known, and what is inside."""
    rng = np.random.default_rng(5)
    for _ in range(20):
        radius, begin = rng.uniform((0.05, 0), (0.99, 7))
        times = begin + np.cumsum([0.0, *rng.uniform(0.1, 0.4, 40)])
        extremes = np.pi * np.ceil([begin / np.pi, begin / np.pi + 1])  # of w, where steps end
        times = np.unique([*times[times < begin + 2 * np.pi], *extremes, begin + 2 * np.pi])
        middle, half = (times[1:] + times[:-1]) / 2, np.diff(times) / 2
        t = middle[:, None] + half[:, None] * -np.cos(np.pi * np.arange(13) / 12)
        curve = SlipCurve.through(radius * np.array([np.sin(t), -np.cos(t)]) + [[[0]], [[1]]])
        q, w = np.sort(rng.uniform(-1, 1, 2)), np.sort(rng.uniform(0, 2, 2))
        assert curve.area_within(q, w) == pytest.approx(disc_in_box(radius, q, w - 1), abs=1e-10)
        assert curve.area_within(*np.array([[-1, 1], [0, 2]])) == pytest.approx(np.pi * radius**2, abs=1e-10)
        angle, off = rng.uniform(0, 7, 50), rng.choice([-1, 1], 50) * 10 ** rng.uniform(-9, -1, 50)
        points = (1 + off) * radius * np.array([np.sin(angle), np.cos(angle)])
        assert curve.surrounds(points[0], points[1] + 1, 1e-12).tolist() == (off < 0).tolist()
        on = radius * np.array([np.sin(angle), np.cos(angle)])
        assert (curve.surrounds(on[0], on[1] + 1, 1e-4) == -1)[np.abs(np.cos(angle)) < 0.99].all()


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


def test_pure_slip_draws_every_motion():
    law, osc = ss.laws.polynomial.typical(), paper_oscillator(3.1)
    assert ss.basin_map(law, osc, x0=[-0.1, 0.0, 0.1], v0=[0.0, 0.5]).count() == {Motion.PURE_SLIP: 6}
    with pytest.raises(ss.InputError, match="x0 holds a value that is not finite: inf"):
        ss.basin_map(law, osc, x0=[float("inf")], v0=[0.0])


def test_the_slip_from_P_is_integrated_once(monkeypatch):
    follow, counts = Dimensionless.slip, []

    def counted(system, q, w, *arguments, **options):
        counts[-1] += q == w == 0 and not options.get("backward")  # backward it is what leads to P
        return follow(system, q, w, *arguments, **options)

    monkeypatch.setattr(Dimensionless, "slip", counted)
    for count in (2, 20):
        counts.append(0)
        osc = paper_oscillator(2.3 + 1e-9 * count)  # nothing is known of it yet
        ss.basin_map(EXPONENTIAL, osc, x0=np.linspace(-0.05, 0.08, count), v0=np.linspace(-1, 1, 10))
    assert 0 < counts[0] == counts[1] < 6


FALLING = ss.FrictionLaw("Piecewise((0.5 - 0.1*v, v < 0.3), (0.3, True))")
RISING = ss.FrictionLaw("Piecewise((0.5 - 0.1*v, v < 0.2), (0.7 - 0.1*v, v < 0.6), (0.4, True))")
UNSETTLED = {
    "mu jumps down": (FALLING, paper_oscillator(1.0)),
    "mu jumps up, and down": (RISING, paper_oscillator(1.0)),
    "damping is negative": (EXPONENTIAL, paper_oscillator(-0.5)),
    "P's orbit overtakes the belt": (
        ss.laws.exponential.typical(alpha=0.8), ss.Oscillator(m=1, k=1, c=0.01, V=1, N=0.2),
    ),
}  # fmt: skip


@sweep("name", list(UNSETTLED), "mu jumps up, and down", "P's orbit overtakes the belt")
def test_what_geometry_does_not_settle_is_followed(name):
    law, osc = UNSETTLED[name]
    x0, v0 = np.linspace(-5, 5, 20) * osc.length, np.array([0.4, 1.8]) * osc.V
    found = ss.basin_map(law, osc, x0=x0, v0=v0)
    assert found.simulated == found.motion.size
    assert [share.counted for share in found.share.values()] == [found.regime.basins is None] * len(found.share)
    assert not found.notes
    for row, column in np.random.default_rng(4).integers((2, 20), size=(3, 2)):
        assert found.motion[row, column] is ss.classify(law, osc, x0=x0[column], v0=v0[row])
    assert len(found.count()) == (2 if name == "mu jumps down" else 1)
