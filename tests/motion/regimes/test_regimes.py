"""Regimes and classification, against thresholds found otherwise and against simulations that know neither."""

import itertools
import math

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym import Motion, Phase
from stickslip_sym.motion.orbits.cycles import LimitCycle
from stickslip_sym.motion.regimes.regime import Regime, Rest
from stickslip_sym.motion.simulation.cycle import StickSlipCycle
from support.operating_points import TWO, paper_oscillator
from support.sweeps import sample

KINKED = ss.FrictionLaw("Max(0.5 - 0.4*v, 0.25)")
STATIC = ss.FrictionLaw("0.2 + 0.3*exp(-3*v)", static="1")
SMOOTHED = ss.FrictionLaw("tanh(100*v)*(0.2 + 0.3*exp(-3*v))")


def names(found):
    kinds = {Rest: "rest", LimitCycle: "pure slip", StickSlipCycle: "stick-slip"}
    return [kinds[type(attractor)] for attractor in found.attractors]


@pytest.mark.parametrize(
    ("name", "c", "expected", "separatrices"),
    [
        ("exponential", 1.9, ["stick-slip"], []),  # below the Hopf bifurcation at 1.970
        ("exponential", 2.3, ["rest", "stick-slip"], ["limit cycle"]),
        ("exponential", 2.6, ["rest"], []),  # above the graze at 2.573
        ("polynomial", 3.0, ["stick-slip"], []),  # below the graze at 3.0365
        ("polynomial", 3.2, ["pure slip"], []),
        ("polynomial", 3.4, ["rest"], []),  # above the Hopf bifurcation at 3.311
    ],
)
def test_the_attractors_of_the_papers_laws(name, c, expected, separatrices):
    found = ss.regime(ss.laws.catalogue[name].typical(), paper_oscillator(c))
    assert names(found) == expected
    assert found.coexist == (len(expected) > 1)
    assert [separatrix.kind for separatrix in found.separatrices] == separatrices
    assert not found.undecided
    assert not found.unbounded
    assert str(found).count("\n") == len(expected) - 1


def test_both_sides_of_the_threshold_and_itself(law):
    threshold = ss.pure_slip_damping(law, V=0.5, N=9.81, m=1, k=100, method="orbit", rtol=1e-13).value
    above = Motion.PURE_SLIP if law.name == "polynomial" else Motion.REST
    for step in (1e-3, 1e-6, 1e-9):
        found = [ss.classify(law, paper_oscillator(threshold * (1 + off)), rtol=1e-12) for off in (-step, step)]
        assert found == [Motion.STICK_SLIP, above]
        cycles = [ss.stick_slip_cycle(law, paper_oscillator(threshold * (1 + off))) for off in (-step, step)]
        assert [cycle is None for cycle in cycles] == [False, True]
    assert ss.classify(law, paper_oscillator(threshold)) is Motion.UNDECIDED
    assert "grazes" in ss.regime(law, paper_oscillator(threshold)).undecided[0]


def test_the_published_cycle_of_a_hyperbolic_law():
    """Leine, van Campen, de Kraker & van den Steen 1998: m = k = 1, F = 1/(1 + 3 v), V = 0.2."""
    found = ss.regime(ss.FrictionLaw("1/(1 + 3*v)"), ss.Oscillator(m=1, k=1, c=0, V=0.2, N=1)).stick_slip
    assert found.x_max == pytest.approx(1.1339446764, rel=1e-10)
    assert found.period == pytest.approx(12.0010312948, rel=1e-11)


def by_simulation(law, osc, x0, v0, periods=150):
    """Name the motion after many periods, from nothing but the trajectory."""
    round_ = 2 * np.pi / osc.omega
    motion = ss.simulate(law, osc, t_end=periods * round_, x0=x0, v0=v0, rtol=1e-8)
    late = motion.t > (periods - 5) * round_
    if Phase.STICK in set(motion.phase[late]):
        return Motion.STICK_SLIP
    return Motion.REST if np.max(np.abs(motion.v[late])) < 0.02 * osc.V else Motion.PURE_SLIP


SETTLED = [
    (ss.laws.exponential.typical(), 2.2), (ss.laws.polynomial.typical(), 3.15), (KINKED, 3.0), (STATIC, 2.7),
    (SMOOTHED, 3.0),
]  # fmt: skip
"""Dampings away from the boundaries, so that 150 periods settle the motion."""


@sample(3)
@pytest.mark.parametrize(("law", "c"), SETTLED)
def test_classification_is_what_a_simulation_comes_to(law, c):
    osc = paper_oscillator(c)
    for x0, v0 in np.random.default_rng(6).uniform((-0.1, -0.6), (0.15, 1.0), (2, 2)):
        assert ss.classify(law, osc, x0=x0, v0=v0) is by_simulation(law, osc, x0, v0)


@pytest.mark.parametrize(
    ("law", "c"),
    [
        (ss.laws.exponential.typical(), 2.3), (ss.laws.polynomial.typical(), 3.2), (TWO, 3.4), (KINKED, 3.0),
        (ss.FrictionLaw("Piecewise((0.5 - 0.2*v, v < 0.7), 0.38)"), 1.0),
    ],
)  # fmt: skip
def test_orbits_between_cycles_follow_solve_ivp(law, c):
    osc = paper_oscillator(c)
    cycles = ss.limit_cycles(law, osc)

    def growth(A):
        x0 = (osc.N * float(law.mu(osc.V * (1 - A))) - c * A * osc.V) / osc.k
        motion = ss.simulate(law, osc, t_end=9 / osc.omega, x0=x0, v0=A * osc.V, rtol=1e-10, method="solve_ivp")
        return motion.at(np.linspace(4, 9, 3001) / osc.omega).v.max() / (A * osc.V) - 1

    bounds = [0.0, *(cycle.amplitude / osc.V for cycle in cycles), 1.0]
    signs = [np.sign(growth((low + high) / 2)) for low, high in itertools.pairwise(bounds)]
    assert [(one, -one) for one in signs[:-1]] == [(one, other) for one, other in itertools.pairwise(signs)]
    assert [cycle.stable for cycle in cycles] == [sign > 0 for sign in signs[:-1]]
    assert all(abs(growth(A)) < 1e-6 for A in bounds[1:-1])


def test_a_jump_of_mu_holds_orbits_that_grow():
    law, osc = ss.FrictionLaw("Piecewise((0.3 - 0.1*v, v < 0.1), 0.45)"), paper_oscillator(-0.1)
    (cycle,) = ss.regime(law, osc).attractors
    assert cycle.amplitude == pytest.approx(osc.V - 0.1, rel=1e-6)
    motion = ss.simulate(law, osc, t_end=20.0, x0=osc.N * 0.45 / osc.k, v0=0.3)
    assert motion.at(np.linspace(18, 20, 2001)).v.max() == pytest.approx(cycle.amplitude, rel=1e-4)


@pytest.mark.parametrize(
    ("law", "c", "kind"), [(ss.laws.exponential.typical(), 2.3, "limit cycle"), (STATIC, 2.7, "graze")]
)
def test_a_separatrix_parts_the_basins(law, c, kind):
    osc = paper_oscillator(c)
    found = ss.regime(law, osc)
    (curve,) = found.separatrices
    assert curve.kind == kind
    assert names(found) == ["rest", "stick-slip"]
    for place in range(20, 240, 40):
        for scale, expected in ((0.99, Motion.REST), (1.01, Motion.STICK_SLIP)):
            x, v = found.rest.x + scale * (curve.x[place] - found.rest.x), scale * curve.v[place]
            assert ss.classify(law, osc, x0=x, v0=v) is expected


def test_negative_damping_may_grow_without_bound():
    law = ss.laws.exponential.typical()
    found = ss.regime(law, paper_oscillator(-0.5))
    assert found.unbounded
    assert names(found) == ["stick-slip"]
    assert ss.classify(law, paper_oscillator(-0.5)) is Motion.STICK_SLIP
    assert ss.classify(law, paper_oscillator(-0.5), x0=-3.0, v0=-2.0) is Motion.UNBOUNDED
    assert not ss.regime(ss.laws.polynomial.typical(), paper_oscillator(-0.5)).unbounded  # mu grows as v^3


FALLING = "Piecewise((0.5 - 0.3*v, v < 0.5), 0.35 - 0.1*(v - 0.5))"


@pytest.mark.parametrize(
    ("formula", "c", "stable"),
    [
        # Small motions feel either slope for half a swing each: 0.2 on the mean, and 1.962 kg/s are needed.
        (FALLING, 1.9, False),
        (FALLING, 2.0, True),
        ("Piecewise((0.5 - 0.6*v, v < 0.5), 0.2 + 0.2*(v - 0.5))", 1.9, False),
        ("Piecewise((0.5 - 0.6*v, v < 0.5), 0.2 + 0.2*(v - 0.5))", 2.0, True),
        ("Piecewise((0.5 - 0.3*v, v < 0.5), 0.25)", 10.0, False),  # a jump down drives the mass off, a jump up
        ("Piecewise((0.3 - 0.1*v, v < 0.5), 0.4)", -1.0, True),  # holds it, whatever the damping
    ],
)
def test_rest_at_kinks_and_jumps_of_mu(formula, c, stable):
    law, osc = ss.FrictionLaw(formula), paper_oscillator(c)
    rest = ss.regime(law, osc).rest
    assert (rest.stable, rest.rate < 0) == (stable, stable)
    motion = ss.simulate(law, osc, t_end=5.0, x0=rest.x, v0=1e-4 * osc.V)
    assert (np.abs(motion.v[motion.t > 4.0]).max() < 1e-4 * osc.V) == stable
    if math.isfinite(rest.rate):  # and by so much it grows or falls in a second
        swings = [np.abs(motion.at(np.linspace(t, t + 0.63, 400)).v).max() for t in (1.0, 2.0)]
        assert np.log(swings[1] / swings[0]) == pytest.approx(rest.rate, rel=0.3)


def test_the_cycle_of_a_kinked_law_without_inertia():
    """The mass jumps from one branch of the law to the other, and the implicit steps must not skip the jump.

    From x = (4.905 - 0.5)/100 it creeps on mu = 0.29, x' = 2.8449 - 100 x, down to where the slip speed is 0.7;
    there it jumps to the belt's speed, and sticks.
    """
    law, osc = ss.FrictionLaw("Piecewise((0.5 - 0.3*v, v < 0.7), 0.29)"), paper_oscillator(1.0, m=1e-9)
    begin, end = 0.04405, 0.030449
    expected = math.log((100 * begin - 2.8449) / 0.2) / 100 + (begin - end) / 0.5
    assert ss.stick_slip_cycle(law, osc).period == pytest.approx(expected, rel=1e-5)
    assert ss.classify(law, osc) is Motion.STICK_SLIP


def test_the_rate_of_rest_is_the_eigenvalue(law):
    for c in (1.0, 2.5, 30.0, 200.0):
        osc = paper_oscillator(c)
        matrix = [[0, 1], [-osc.k / osc.m, -(osc.c + osc.N * law.slope(osc.V)) / osc.m]]
        assert ss.regime(law, osc).rest.rate == pytest.approx(np.linalg.eigvals(matrix).real.max(), rel=1e-9)


def test_a_free_oscillator_is_neutral():
    osc = paper_oscillator(0.0, N=0.0)
    assert "neither grow nor shrink" in " ".join(ss.regime(ss.laws.exponential.typical(), osc).undecided)
    assert ss.classify(ss.laws.exponential.typical(), osc, x0=0.01, v0=0.0) is Motion.PURE_SLIP


SLOW = (1e-8, 1e-12)  # m/s


@pytest.mark.parametrize("name", ["exponential", "hyperbolic"])
def test_a_slow_belt_sees_the_slope_at_rest(name):
    """A straight line there; what a cycle differs from that falls with V, as the curvature of mu does."""
    law = ss.laws.catalogue[name].typical()
    slope = law.slope(0.0)
    line = ss.FrictionLaw("mu_0 - a*v").bind(mu_0=law.mu(0.0), a=-slope)
    least = -9.81 * slope

    def deviation(V):
        cycle, expected = (ss.stick_slip_cycle(one, paper_oscillator(0.95 * least, V=V)) for one in (law, line))
        return abs(cycle.slip_time / expected.slip_time - 1)

    curved = deviation(SLOW[0]) / SLOW[0]
    assert curved * SLOW[0] < 0.01
    for V in SLOW:
        assert deviation(V) <= 1.5 * curved * V + 1e-11
        assert ss.pure_slip_damping(law, V=V, m=1.0, k=100.0, N=9.81).value == pytest.approx(least, rel=1e4 * V)
        for c, motion in ((0.95 * least, ss.Motion.STICK_SLIP), (1.05 * least, ss.Motion.REST)):
            assert ss.classify(law, paper_oscillator(c, V=V)) is motion
            regime = ss.regime(law, paper_oscillator(c, V=V), time_limit=20)
            assert not regime.undecided
            assert (regime.stick_slip is not None) == (motion is ss.Motion.STICK_SLIP)


@pytest.mark.parametrize("exponent", [0.6, 0.8, 1.0])
@pytest.mark.parametrize("height", [0.99, 1.02])
def test_a_cycle_that_overtakes_attracts(exponent, height):
    """Where mu falls without bound at rest, too: motions on both sides come to it, at its exponent."""
    law = ss.FrictionLaw(f"0.16 + 0.39*exp(-(v/0.04)^{exponent})")
    osc = ss.Oscillator(m=0.12, k=540, c=0.0155, V=0.37, N=0.118)
    (cycle,) = (one for one in ss.regime(law, osc).attractors if isinstance(one, LimitCycle))
    assert cycle.amplitude > osc.V
    run = ss.simulate(law, osc, t_end=10 * cycle.period, x0=0.0, v0=height * osc.V, rtol=1e-12)
    *_, before, last = np.diff([event.x for event in run.events][::2])  # where each round passes the belt's speed
    assert last / before == pytest.approx(math.exp(cycle.floquet * cycle.period), rel=0.01)


@pytest.mark.parametrize("factor", ["tanh(v/1e-3)", "v/sqrt(v^2 + 1e-6)"])
def test_a_regularised_law_says_that_it_holds_nothing(factor):
    law = ss.FrictionLaw(f"(0.2 + 0.3*exp(-3*v))*{factor}")
    found = ss.regime(law, paper_oscillator(1.0))
    assert "mu(0) = 0" in str(found)
    assert any(isinstance(one, LimitCycle) for one in found.attractors)
    assert "mu(0) = 0" not in str(ss.regime(ss.laws.exponential.typical(), paper_oscillator(1.0)))


def test_no_attractor_is_never_said_where_motions_lose_energy(monkeypatch):
    """With damping and friction something attracts: if nothing was found, that is what is said."""
    monkeypatch.setattr(Regime, "attractors", ())
    found = Regime(ss.laws.exponential.typical(), paper_oscillator(1.0), 1e-12)
    assert "no attractor" not in str(found)
    assert "was not found" in str(found)
    free = Regime(ss.laws.exponential.typical(), paper_oscillator(-50.0), 1e-12)
    assert "no attractor" in str(free)


LAYER = "(0.2 + 0.3*exp(-3*v))*tanh(v/{})"


@pytest.mark.parametrize(("width", "period"), [(1e-4, 6.34206), (1e-8, 6.34212)])
def test_the_relaxation_cycle_of_a_regularised_law(width, period):
    """It overtakes the belt by less than the layer, where R is all but constant; all functions know it."""
    law, osc = ss.FrictionLaw(LAYER.format(width)), ss.Oscillator(m=1, k=1, V=1, N=1, c=0.06)
    found = ss.regime(law, osc)
    (cycle,) = found.overtaking
    assert found.undecided == ()
    assert [type(one).__name__ for one in found.attractors] == ["Rest", "LimitCycle"]
    assert 0 <= cycle.amplitude - 1 < width
    assert cycle.period == pytest.approx(period, rel=1e-6)
    assert ss.classify(law, osc, x0=[-0.06, 2.0, 0.2], v0=[1.0, 1.0, 0.0]).tolist() == [
        Motion.PURE_SLIP, Motion.PURE_SLIP, Motion.REST,
    ]  # fmt: skip
    assert ss.stick_slip_cycle(law, osc) is None
    cell = ss.motion_map(law, x=("V", [1.0]), y=("c", [0.06]), N=1, m=1, k=1)
    assert {name for name, exists in cell.attractors.items() if exists[0, 0]} == {"rest", "pure_slip"}
    # Where the slip from P is not closed by the law without the layer the motion is its stick-slip cycle.
    plain = ss.stick_slip_cycle("0.2 + 0.3*exp(-3*v)", osc)
    assert cycle.period == pytest.approx(plain.period, rel=1e-4)


@sample(1)
@pytest.mark.parametrize("width", [1e-8, 1e-10])
def test_a_cycle_within_a_layer_at_rest(width):
    """Between d(1) = 0.087 and 0.1177 the cycle lies in the layer, however thin that is."""
    law, osc = ss.FrictionLaw(LAYER.format(width)), ss.Oscillator(m=1, k=1, V=1, N=1, c=0.1)
    inner, outer = ss.limit_cycles(law, osc)
    assert (inner.stable, outer.stable) == (False, True)
    assert inner.amplitude == pytest.approx(0.900421, abs=1e-6)
    assert outer.amplitude == pytest.approx(1.0, abs=10 * width)
    assert outer.period == pytest.approx(6.30532, rel=1e-5)
    assert ss.regime(law, osc).attractors[1] == outer
    high = ss.limit_cycles(law, ss.Oscillator(m=1, k=1, V=1, N=1, c=0.13))
    assert high == ()


def test_a_separatrix_obeys_the_equation_of_motion_between_its_nodes():
    law, osc = ss.laws.exponential.typical(), ss.Oscillator(m=1, k=100, c=2.3, V=0.5, N=9.81)
    for curve in ss.regime(law, osc).separatrices:
        place = np.arange(curve.w.x[0], curve.w.x[-1]) + 0.37
        x, v = curve.onset + osc.length * curve.q(place), osc.V * (1 - curve.w(place))
        dx, dv = osc.length * curve.q.derivative()(place), -osc.V * curve.w.derivative()(place)
        force = osc.N * law.at_speeds(osc.V - v) - osc.c * v - osc.k * x
        assert osc.m * v * dv == pytest.approx(force * dx, rel=0, abs=1e-12)
