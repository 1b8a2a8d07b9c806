"""Basins of attraction by the sides of their boundaries, against motions that are followed, and known areas."""

from copy import copy

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

import stickslip_sym as ss
from stickslip_sym import Motion
from stickslip_sym.motion.maps import basins
from stickslip_sym.motion.regimes.classification import followed
from stickslip_sym.motion.regimes.regime import kept_regime
from support.operating_points import paper_oscillator

BISTABLE = ss.laws.exponential.bind(mu_s=1, mu_m=0.5, alpha=2), ss.Oscillator(m=1, k=1, c=0.1, V=1.5, N=1)


def between_thresholds(rng, static):
    """Return a law with a static coefficient above mu(0+) or not, and an oscillator that rests or sticks."""
    mu_s = rng.uniform(0.3, 1.0)
    law = ss.laws.exponential.bind(mu_s=mu_s, mu_m=mu_s * rng.uniform(0.3, 0.9), alpha=rng.uniform(0.5, 4.0))
    if static:
        law = law.with_static(mu_s * rng.uniform(1.1, 2.0))
    point = {"V": rng.uniform(0.3, 2.0), "N": rng.uniform(0.3, 3.0), "m": 1.0, "k": 1.0}
    grazes, loses = (ss.pure_slip_damping(law, **point, method=one).value for one in ("simulation", "equilibrium"))
    return law, ss.Oscillator(c=loses + (grazes - loses) * rng.uniform(0.3, 0.9), **point)


@pytest.mark.parametrize("seed", [0, 1])
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
    assert all(many[i] is ss.classify(law, osc, x0=x[i], v0=v[i]) for i in rng.choice(2000, 50, replace=False))


def test_shares_are_areas_that_add_up():
    """The known one of a box, and that of a million cells."""
    law, osc = BISTABLE
    found = ss.basin_map(law, osc, x0=np.linspace(-2, 2, 1000), v0=np.linspace(0, 2, 1000))
    assert (found.simulated, found.disagreements) == (200, 0)
    rest = found.share[Motion.REST]
    assert rest.value == pytest.approx(0.307126137780, abs=2e-12)
    assert abs(found.count()[Motion.REST] / 1e6 - rest.value) < 2e-3  # cells along the boundary
    assert rest.error < 1e-8
    assert rest.value + found.share[Motion.STICK_SLIP].value == pytest.approx(1.0, abs=1e-14)
    assert abs(rest.value - 0.3165) < 0.02  # published, from 5,000 simulated initial conditions


@pytest.mark.parametrize("seed", range(3))
def test_shares_are_areas_within_the_unstable_cycle(seed):
    """Of random boxes, by Green's integral along the cycle that another integrator closes."""
    rng = np.random.default_rng(seed)
    law, osc = BISTABLE if seed == 0 else between_thresholds(rng, static=False)
    rest, mu = osc.N * law.mu(osc.V) / osc.k, law.function("math")

    def rates(_, y):
        return [y[1], (osc.N * mu(max(osc.V - y[1], 0.0)) - osc.c * y[1] - osc.k * y[0]) / osc.m]

    def turns(t, y):
        return y[1] if t > 0 else -1.0

    turns.terminal, turns.direction = True, -1

    def round_from(x, **options):
        return solve_ivp(rates, (0, 99), [x, 0], method="LSODA", events=turns, rtol=1e-12, atol=1e-13, **options)

    closed = brentq(lambda x: round_from(x).y[0, -1] - x, rest + 1e-3 * osc.V, rest + 1.5 * osc.V, xtol=1e-12)
    period = round_from(closed).t[-1]
    t = np.linspace(0, period, 4001)
    curve = CubicSpline(
        t, solve_ivp(rates, (0, period), [closed, 0], "LSODA", t, rtol=1e-12, atol=1e-13).y, axis=1
    )
    x, v = curve(np.linspace(0, period, 200_001))
    for _ in range(4):
        box = rest + np.sort(rng.uniform(-1.2, 1.2, 2)) * osc.V, np.sort(rng.uniform(-1.2, 1.2, 2)) * osc.V
        in_x, in_v = np.clip(x, *box[0]), np.clip(v, *box[1])
        area = abs(np.sum((in_x[1:] + in_x[:-1]) / 2 * np.diff(in_v)))
        found = ss.basin_map(law, osc, x0=tuple(box[0]), v0=tuple(box[1])).share
        value = found[Motion.REST].value if Motion.REST in found else 0.0
        assert value == pytest.approx(area / np.prod(np.ptp(box, axis=1)), abs=1e-7)
    places, off = rng.integers(x.size, size=400), rng.choice([-1e-3, 1e-3], 400)
    places[::2] = (np.argmax(v), np.argmin(v))[seed % 2] + rng.integers(-5000, 5000, 200)  # where the curve turns
    x0, v0 = rest + (x[places % x.size] - rest) * (1 + off), v[places % x.size] * (1 + off)
    assert ((ss.classify(law, osc, x0=x0, v0=v0) == Motion.REST) == (off < 0)).all()


def test_wrong_sides_are_noticed(monkeypatch):
    """Where geometry is wrong the sample that is followed says so; then all are followed that time allows."""
    law, osc = BISTABLE
    box = {"x0": np.linspace(-2, 2, 32), "v0": np.linspace(0.1, 1.0, 8)}
    right = ss.basin_map(law, osc, **box)
    assert not any(share.counted for share in right.share.values())

    def swapped(*arguments, **options):
        found = copy(kept_regime(*arguments, **options))
        vars(found)["basins"] = found.basins[::-1]
        return found

    monkeypatch.setattr(basins, "kept_regime", swapped)
    wrong = ss.basin_map(law, osc, **box)
    assert (wrong.simulated, wrong.disagreements) == (256, 256)
    assert "; 256 of 256 simulated ones disagree with geometry; " in repr(wrong)
    assert wrong.notes[0, 0] == "geometry says rest"
    assert (wrong.motion == right.motion).all()
    for motion, share in wrong.share.items():
        at = (right.motion == motion).astype(float)
        assert (share.counted, share.value) == (True, at.mean())
        assert share.error == pytest.approx(at.std() / 16)  # of the mean of as many

    def in_time(*arguments):
        fates = followed(*arguments)
        return fates if fates.size > 60 else np.full(fates.shape, ss.OutOfTime("late"), dtype=object)

    monkeypatch.setattr(basins, "followed", in_time)
    late = ss.basin_map(law, osc, **box)
    assert (late.disagreements, late.count()[Motion.UNDECIDED]) == (200, 56)
    assert "time limit" in late.notes[tuple(np.argwhere(late.motion == Motion.UNDECIDED)[0].tolist())]


def test_pure_slip_draws_every_motion():
    law, osc = ss.laws.polynomial.typical(), paper_oscillator(3.1)
    assert ss.basin_map(law, osc, x0=[-0.1, 0.0, 0.1], v0=[0.0, 0.5]).count() == {Motion.PURE_SLIP: 6}
    with pytest.raises(ss.InputError, match="x0 holds a value that is not finite: inf"):
        ss.basin_map(law, osc, x0=[float("inf")], v0=[0.0])


RISING = ss.FrictionLaw("Piecewise((0.5 - 0.1*v, v < 0.2), (0.7 - 0.1*v, v < 0.6), (0.4, True))")
OVERTAKING = ss.laws.exponential.typical(alpha=0.8), ss.Oscillator(m=1, k=1, c=0.01, V=1, N=0.2)


@pytest.mark.parametrize(("law", "osc"), [(RISING, paper_oscillator(1.0)), OVERTAKING])
def test_what_geometry_does_not_settle_is_followed(law, osc):
    x0, v0 = np.linspace(-5, 5, 20) * osc.length, np.array([0.4, 1.8]) * osc.V
    found = ss.basin_map(law, osc, x0=x0, v0=v0)
    assert found.simulated == found.motion.size
    assert [share.counted for share in found.share.values()] == [found.regime.basins is None] * len(found.share)
    assert not found.notes
    for row, column in np.random.default_rng(4).integers((2, 20), size=(3, 2)):
        assert found.motion[row, column] is ss.classify(law, osc, x0=x0[column], v0=v0[row])
