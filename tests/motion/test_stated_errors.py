"""What is said of a number bounds what it is off, and what is refused is refused at the very edge."""

import math

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym import Motion, Phase
from stickslip_sym.motion.orbits.damping import needed_damping
from stickslip_sym.motion.orbits.orbit import orbits
from stickslip_sym.motion.regimes.regime import Regime
from stickslip_sym.motion.thresholds.methods import methods
from stickslip_sym.motion.thresholds.operating_points import OperatingPoints
from support.operating_points import paper_oscillator
from support.sweeps import sweep

POINT = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}


OVERTAKING = [
    (ss.laws.exponential.typical(), {"c": 1.0, "k": 1e6}),
    (ss.laws.polynomial.typical(), {"c": 0.5, "k": 4e6, "m": 2.0}),
    (ss.FrictionLaw("tanh(20*v)*(0.2 + 0.3*exp(-3*v))"), {"c": 0.2}),  # it never sticks
]


@pytest.mark.parametrize(("law", "changes"), OVERTAKING)
def test_overtaking_cycles_are_those_of_simulations(law, changes):
    """Two motions that come close to it, from inside and from outside."""
    osc = paper_oscillator(**changes)
    (cycle,) = Regime(law, osc, 1e-11).overtaking
    x0 = osc.N * float(law.mu(osc.V)) / osc.k
    settled = min(12 / abs(cycle.floquet), 300 * cycle.period)
    left = math.exp(cycle.floquet * settled)  # of what a start is off
    for part in (0.99, 1.01):
        v0, t_end = part * cycle.amplitude, settled + 5 * cycle.period
        motion = ss.simulate(law, osc, t_end=t_end, x0=x0, v0=v0, rtol=1e-10)
        late = [event.t for event in motion.events if event.begins is Phase.SLIP_FORWARD and event.t > settled]
        assert np.diff(late[-3:]) == pytest.approx(cycle.period, rel=1e-8 + left)
        times = np.linspace(late[-2], late[-1], 4001)
        assert motion.at(times).v.max() == pytest.approx(cycle.amplitude, rel=1e-6 + 0.1 * left)


SLOPED = [
    *(ss.laws.exponential.typical().bind(alpha=alpha) for alpha in np.geomspace(0.3, 40, 2).tolist()),
    *(ss.laws.catalogue["gaussian"].typical().bind(v_s=v_s) for v_s in np.geomspace(0.2, 3, 2).tolist()),
]


@pytest.mark.parametrize("law", SLOPED)
def test_needed_damping_is_that_of_collocation(law):
    osc = paper_oscillator()
    need = needed_damping(law, osc)
    A = np.random.default_rng(4).uniform(0.01, 1, 12)
    direct = orbits(law.bound, osc.V, osc.N / osc.impedance, A)
    known = np.isfinite(direct.d)  # a steep law asks for more phases than collocation takes
    assert known.sum() >= 11
    variation = np.ptp(need.at(np.linspace(0, 1, 50)))
    off = np.abs(need.at(A) - direct.d)[known]
    assert off.max() <= 1e-9 * variation + (direct.relative_error * np.abs(direct.d))[known].max()


@pytest.mark.parametrize("measured", [True, False])
def test_the_least_negative_damping_frees_motions(measured):
    law = ss.FrictionLaw.from_samples([0, 0.2, 1, 3], [0.5, 0.4, 0.3, 0.3], extrapolate=not measured)
    for c in (0.0, *np.logspace(-9, 2, 6)):
        assert Regime(law, paper_oscillator(-c), 1e-10).unbounded == (c > 0)
        assert not Regime(law, paper_oscillator(c), 1e-10).unbounded
    for crossing in np.logspace(1, 11, 3):  # far out the sign of mu = 0.3 -+ b v +- d v^2 is that of the last term
        for sign in (-1, 1):
            law = ss.FrictionLaw("0.3 + s*(v^2/p - v)", parameters=[ss.Parameter("s", positive=False)])
            law = law.bind(s=sign * 10.0, p=float(crossing))
            assert Regime(law, paper_oscillator(1.0), 1e-10).unbounded is (sign < 0)


OUTER = ss.FrictionLaw("0.3 + 1e-6*v^3", static="0.35")


def test_stable_cycles_far_out_attract_both_sides():
    """A negative damping outdoes dry friction above 7 m/s, and mu, rising as v^3, outdoes it above 260 m/s."""
    osc = paper_oscillator(-0.5)
    end = math.sqrt(0.5 / (9.81 * 1e-6 * 0.75))  # the balance over a harmonic motion far out
    for v0 in (-1000.0, -100.0):
        motion = ss.simulate(OUTER, osc, t_end=40.0, v0=v0, rtol=1e-7)
        assert np.abs(motion.v[motion.t > 35]).max() == pytest.approx(end, rel=0.1)
        assert ss.classify(OUTER, osc, v0=v0) is Motion.PURE_SLIP
    assert ss.classify(OUTER, osc, v0=-2.0) is Motion.STICK_SLIP


@pytest.mark.parametrize("zeta", [0.0, 1e-8, 1e-1])
def test_without_friction_the_least_damping_decides(zeta):
    law = ss.laws.exponential.typical()
    for x0, v0 in ((0.3, -0.4), (-1.0, 2.0)):  # beyond the belt's speed
        osc = paper_oscillator(20 * zeta, N=0.0)
        assert ss.classify(law, osc, x0=x0, v0=v0) is (Motion.REST if zeta else Motion.PURE_SLIP)
        if zeta:
            found = ss.classify(law, paper_oscillator(-20 * zeta, N=0.0), x0=x0, v0=v0)
            assert found is Motion.UNBOUNDED


def slopes_that_cancel(rng):
    """Yield laws with random slopes of both signs, from v = 0 to 2 m/s."""
    for number in range(8):
        a, b = rng.uniform(-0.3, 0.3, 2)
        if number % 2:
            terms = enumerate(rng.normal(size=6) * 0.3, 1)
            yield ss.FrictionLaw("0.5" + "".join(f" + ({x:.6f})*(v - 1)^{n}" for n, x in terms))
        else:
            fast, slow = 10 ** rng.uniform(-0.5, 1.2, 2)
            yield ss.FrictionLaw(f"0.5 + ({a:.6f})*exp(-{fast:.6f}*v) + ({b:.6f})*exp(-{slow:.6f}*v)")


def test_next_order_bounds_the_second_orders_error():
    total = 0
    for law in slopes_that_cancel(np.random.default_rng(5)):
        points = OperatingPoints.of(law, V=1.0, N=np.geomspace(0.01, 1, 5), m=1.0, k=1.0)
        found = methods()["second_order"].compute(points, 1.0)
        rows = np.flatnonzero(found.relative_error < 0.5)
        exact = methods()["orbit"].compute(points.rows(rows), 1e-12)
        off = np.abs(found.value[rows] / exact.value - 1)
        assert (off <= found.relative_error[rows] + exact.relative_error).all()
        # And is no empty phrase: the order is right, so it falls with it.
        total += rows.size
        assert found.relative_error[0] < 1e-6 * found.relative_error[-1]
    assert total >= 24


LAYERS = [(1e-9, 1e-7), (1e-9, 1e-5), (1e-7, 1e-7), (1e-7, 1e-3), (1e-5, 1e-3)]


@pytest.mark.parametrize(("width", "part"), LAYERS)
def test_stated_errors_count_an_unseen_layer(width, part):
    """A thin layer a exp(-v/w) adds N a sqrt(2 w/pi) V^(-3/2) where it does not bend the orbit."""
    alone = "0.2 + 0.3*exp(-3*v)"
    point = POINT | {"k": 1e8}  # of weak friction, so that the layer is all there is to tell
    exact = ss.pure_slip_damping(ss.FrictionLaw(alone), **point, method="orbit", rtol=1e-11).value
    height = part * exact / (9.81 * math.sqrt(2 * width / math.pi) * 0.5**-1.5)
    law = ss.FrictionLaw(f"{alone} + a*exp(-v/w)").bind(a=height, w=width)
    exact *= 1 + part
    found = methods()["second_order"].compute(OperatingPoints.of(law, **point), 1.0)
    assert abs(found.value[0] / exact - 1) <= found.relative_error[0] + 0.1 * part
    for rtol in (0.3, 1e-2, 3e-4):
        try:
            found = ss.pure_slip_damping(law, **point, rtol=rtol)
        except ss.NotConverged:
            continue
        assert abs(found.value / exact - 1) <= found.relative_error + 0.1 * part


def test_orbits_are_as_asked_or_refused():
    """Towards the belt speed v_m sqrt(4/5), where weak friction needs no damping, digits are lost."""
    law, outcomes = ss.laws.polynomial.bind(mu_s=0.5, mu_m=0.2, v_m=1.0), set()
    for rtol in (1e-12, 1e-6):
        for below in np.geomspace(1e-10, 1e-1, 10):
            point = {"V": math.sqrt(0.8 * (1 - below)), "N": 1.0, "m": 1.0, "k": 1e8}
            try:
                found = ss.pure_slip_damping(law, **point, method="orbit", rtol=rtol)
            except ss.NotConverged:
                outcomes.add("refused")
                continue
            assert found.relative_error <= rtol
            outcomes.add("as asked")
            # (18) for the harmonic weight, and the next order from derivations/d8.
            weak = 9.0 / 8 * 0.3 * (4 / 3 - 5 / 3 * point["V"] ** 2)
            second = 31149 / 81920 * 0.3**3 * point["V"] ** 6 / 1e8
            assert found.value == pytest.approx(weak + second, rel=found.relative_error, abs=3e-16)
    assert outcomes == {"as asked", "refused"}


@sweep("m", [1e-12, 1e-8, 1e-4], 1e-8, 1e-4)
def test_thresholds_of_light_masses_within_their_errors(m):
    """As m tends to 0 the threshold tends to a limit; the phase is stiff, with rates up to 2e6 a unit of time."""
    law = ss.laws.exponential.typical()
    rough = ss.pure_slip_damping(law, **POINT | {"m": m}, method="simulation", time_limit=60)
    fine = ss.pure_slip_damping(law, **POINT | {"m": m}, method="simulation", rtol=1e-7, time_limit=60)
    assert fine.relative_error < 1e-7
    assert abs(rough.value / fine.value - 1) <= rough.relative_error + fine.relative_error
    if m <= 1e-8:
        limit = -9.81 * law.slope(0.5)  # from which it departs by 50/eta^2
        assert fine.value == pytest.approx(limit, rel=fine.relative_error + 60 * m / (9.81 / 5) ** 2)


def test_cycles_too_small_to_find_are_named():
    """mu' = -a + 3 b (v - V)^2 about rest: a cycle of amplitude A needs N (a - 3/4 b A^2); a kink is in reach."""
    rng = np.random.default_rng(7)
    for amplitude in 10 ** rng.uniform(-5, -3.5, 1):
        for bend in rng.choice([-1, 1]) * np.array([1, -1]) * rng.uniform(0.2, 0.6):
            law = ss.FrictionLaw(f"0.4 - 0.3*(v - 0.5) + ({bend:.6f})*(v - 0.5)^3 + 0.1*Max(0, v - 0.95)")
            found = ss.regime(law, paper_oscillator(9.81 * (0.3 - 0.75 * round(bend, 6) * amplitude**2)))
            assert found.rest.stable == (bend < 0)
            kind = "a stable" if bend > 0 else "an unstable"
            assert f"{kind} limit cycle about rest is too small to find" in found.undecided
