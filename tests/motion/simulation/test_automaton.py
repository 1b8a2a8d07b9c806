"""The automaton at its limits: kinks and jumps of mu, grazing returns, stiff scenes, bounds on the work."""

import math
import time
from dataclasses import replace

import motions
import mpmath
import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss
from scenes import paper_oscillator
from systems import needs_heyoka

import stickslip_sym as ss
from stickslip_sym import EventKind, Outcome, Phase

SAMPLE = list(motions.scenes(48, seed=6))
IMPLICIT = 1e-7  # of w between the steps of the implicit method, whose interpolant is of order 3
EVENT_TIMES = 1e-11  # relative, at rtol = 1e-12
NO_MORE_SECONDS = 10  # on a loaded machine; alone each case takes less than 2


@pytest.mark.parametrize("part", range(4))
def test_no_event_is_missed_and_none_is_spurious(part):
    """5000 scenes of the kind are measured by tests/benchmarks/measure_events.py."""
    for _, law, osc, x0, v0 in SAMPLE[12 * part : 12 * part + 12]:
        motion, _ = motions.simulated(law, osc, x0, v0)
        assert motions.violations(law, osc, motion) == []


@pytest.mark.parametrize("number", range(8))
def test_event_times_are_those_of_an_independent_integration(number):
    _, law, osc, x0, v0 = SAMPLE[number]
    motion, _ = motions.simulated(law, osc, x0, v0)
    expected = motions.reference(law, osc, x0, v0, motion.t[-1])
    assert motions.disagreement(motion.events, expected) < EVENT_TIMES


def test_the_checks_of_events_can_fail(law):
    osc = paper_oscillator(1.0)
    motion = ss.simulate(law, osc, t_end=2.0, x0=0.2, v0=0.0, rtol=1e-12)
    assert motions.violations(law, osc, motion) == []
    first, *others = motion.stretches
    for wrong in (replace(first, phase=Phase.SLIP_FORWARD), replace(first, phase=Phase.STICK)):
        assert motions.violations(law, osc, replace(motion, stretches=(wrong, *others)))
    expected = motions.reference(law, osc, 0.2, 0.0, 2.0)
    late = [(t * (1 + 1e-10), phase) for t, phase in expected]
    assert motions.disagreement(motion.events, late) > EVENT_TIMES
    assert motions.disagreement(motion.events, expected[:-1]) == math.inf


@pytest.mark.parametrize("V", [0.1, 0.5, 0.8])
def test_grazing_returns_are_classified_right(law, V):
    """On both sides of the threshold that the orbit solver gives, which integrates nothing."""
    threshold = ss.pure_slip_damping(law, V=V, N=9.81, m=1, k=100, method="orbit", rtol=1e-12).value
    for distance in (1e-3, 1e-5, 1e-7, 1e-9):
        assert ss.stick_slip_cycle(law, paper_oscillator(threshold * (1 - distance), V=V)) is not None
        assert ss.stick_slip_cycle(law, paper_oscillator(threshold * (1 + distance), V=V)) is None


@pytest.mark.parametrize("c", [0.0, 1.0, -0.5])
def test_the_energy_balance_closes_over_100_cycles(law, c):
    """Work of friction and damping, by quadrature of the dense output, against kinetic and elastic energy."""
    osc = paper_oscillator(c)
    period = ss.stick_slip_cycle(law, osc).period
    motion = ss.simulate(law, osc, t_end=100 * period, rtol=1e-12)
    nodes, weights = leggauss(10)
    work, exchanged = 0.0, 0.0
    for stretch in motion.stretches:
        inner = motion.t[(motion.t > stretch.start) & (motion.t < stretch.end)]
        edges = np.array([stretch.start, *inner, stretch.end])
        half = np.diff(edges) / 2
        t = ((edges[:-1] + edges[1:]) / 2)[:, None] + half[:, None] * nodes
        x, v = (part.reshape(t.shape) for part in stretch.course(t.ravel()))
        if stretch.phase is Phase.STICK:
            friction = osc.c * v + osc.k * x
        else:
            friction = osc.N * np.sign(osc.V - v) * law.mu(np.abs(osc.V - v))
        power = (friction - osc.c * v) * v
        work += float(np.sum(power @ weights * half))
        exchanged += float(np.sum(np.abs(power) @ weights * half))
    energy = osc.m * motion.v**2 / 2 + osc.k * motion.x**2 / 2
    assert len(motion.starts_of(Phase.STICK)) >= 100
    assert abs(work - (energy[-1] - energy[0])) < 1e-9 * exchanged
    assert np.all(motion.v[motion.phase == Phase.STICK] == osc.V)


# -- kinks and jumps -------------------------------------------------------------------------------


def test_a_piecewise_linear_law_is_integrated_as_its_exact_solution():
    """Each piece has a solution in exponentials; where it ends is a root found with 30 digits."""
    law = ss.FrictionLaw("Piecewise((0.5 - 0.4*v, v < 0.3), (0.41 - 0.1*v, v < 0.8), 0.33)")
    osc = paper_oscillator(1.0)
    cycle = ss.stick_slip_cycle(law, osc)
    lines = [(0.5, 0.4), (0.41, 0.1), (0.33, 0.0)]
    with mpmath.workdps(30):
        t, x, v = (
            mpmath.mpf(0),
            mpmath.mpf("0.5") * mpmath.mpf(9.81) / 100 - mpmath.mpf("0.005"),
            mpmath.mpf("0.5"),
        )
        # The pieces in order, the slip speed at which each ends, and about how long the mass stays on it.
        for piece, end, guess in ((0, 0.3, 0.11), (1, 0.8, 0.09), (2, 0.8, 0.2), (1, 0.3, 0.1), (0, 0.0, 0.07)):
            a, b = (mpmath.mpf(str(number)) for number in lines[piece])
            N = mpmath.mpf(9.81)
            rest = N * (a - b * osc.V) / osc.k
            decay = (osc.c - N * b) / 2
            frequency = mpmath.sqrt(osc.k - decay**2)

            def state(s, x=x, v=v, rest=rest, decay=decay, frequency=frequency):
                sine, cosine = mpmath.sin(frequency * s), mpmath.cos(frequency * s)
                u = x - rest
                B = (v + decay * u) / frequency
                shrink = mpmath.exp(-decay * s)
                return rest + shrink * (u * cosine + B * sine), shrink * (
                    (B * frequency - decay * u) * cosine - (u * frequency + decay * B) * sine
                )

            length = mpmath.findroot(
                lambda s, state=state, end=end: osc.V - state(s)[1] - mpmath.mpf(str(end)), guess
            )
            t, (x, v) = t + length, state(length)
    assert cycle.slip_time == pytest.approx(float(t), rel=EVENT_TIMES)
    assert cycle.x_min < float(x) < cycle.x_max


def test_kinks_cost_one_step_each():
    """A step that had a kink in it would be tried ever shorter, some ten times."""
    v = np.linspace(0, 1.3, 40)
    measured = ss.FrictionLaw.from_samples(v, 0.2 + 0.3 * np.exp(-3 * v))
    osc = paper_oscillator(1.0)
    smooth = ss.simulate(ss.laws.exponential.typical(), osc, t_end=0.6, rtol=1e-12)
    kinked = ss.simulate(measured, osc, t_end=0.6, rtol=1e-12)
    crossed = 2 * np.searchsorted(v, osc.V - kinked.v.min())
    assert len(kinked.t) < len(smooth.t) + 1.5 * crossed
    assert kinked.events[-1].t == pytest.approx(smooth.events[-1].t, rel=1e-3)


@pytest.mark.parametrize("offset", [0.0, 1e-15, -1e-15, 1e-13, -1e-13, 1e-10, -1e-10, 1e-6, -1e-6])
def test_an_orbit_may_touch_a_kink(offset):
    """The highest slip speed is that of a kink, as closely as doubles have it."""
    osc = paper_oscillator(1.0)
    smooth = ss.laws.exponential.typical()
    cycle = ss.stick_slip_cycle(smooth, osc)
    highest = repr((osc.V - cycle.v_min) * (1 + offset))
    kinked = ss.FrictionLaw(f"0.2 + 0.3*exp(-3*v) + Max(0, v - {highest})")
    touched = ss.stick_slip_cycle(kinked, osc)
    assert touched.period == pytest.approx(cycle.period, rel=EVENT_TIMES if abs(offset) < 1e-9 else 1e-7)


def test_a_kink_at_the_belt_speed_hides_no_turning_point():
    """The mass stands still where the slip speed is V, which is then the end of a step."""
    at, beside = (
        ss.stick_slip_cycle(ss.FrictionLaw(f"0.5 - 0.2*Min(v, {place})"), paper_oscillator(0.5))
        for place in ("0.5", "0.5000000001")
    )
    assert (at.x_min, at.x_max) == pytest.approx((beside.x_min, beside.x_max), rel=1e-8)
    assert at.x_max > 0.08


def jump(first, second, place, osc, t_end, **start):
    law = ss.FrictionLaw(f"Piecewise(({first}, v < {place}), {second})")
    return ss.simulate(law, osc, t_end=t_end, rtol=1e-12, **start)


def test_the_mass_slides_at_a_jump_up():
    """The rates point at each other there: w is constant until the spring pulls the mass across, known exactly."""
    osc = paper_oscillator(0.0)
    motion = jump(0.3, 0.5, 0.02, osc, 1.2)
    assert [event.begins for event in motion.events[:2]] == [Phase.STICK, Phase.SLIP_BACK]
    # From P with a constant friction: w = 1 - cos(tau), which at the jump is 0.04, and x' = 0.48 m/s.
    onset, tau = motion.events[1].t, math.acos(0.96)
    reached, x_reached = onset + tau / osc.omega, 0.3 * osc.N / osc.k + osc.length * math.sin(tau)
    left = reached + (0.5 * osc.N / osc.k - x_reached) / 0.48
    inside = np.linspace(reached, left, 50)[1:-1]
    assert motion.at(inside).v == pytest.approx(0.48, rel=1e-14)
    assert motion.at(inside).x == pytest.approx(x_reached + 0.48 * (inside - reached), rel=1e-12)
    # Then harmonic about the equilibrium of the higher friction.
    after = left + np.linspace(0, 0.1, 20)
    assert motion.at(after).v == pytest.approx(0.48 * np.cos(osc.omega * (after - left)), rel=1e-10)
    assert motion.outcome is Outcome.FINISHED


@pytest.mark.parametrize(
    ("first", "second", "place"), [(0.3, 0.5, 0.02), (0.5, 0.3, 0.2), (0.3, 0.6, 0.7), (0.5, 0.2, 0.9)]
)
@pytest.mark.parametrize("side", [1, -1])
def test_a_jump_is_the_limit_of_a_steep_change(first, second, place, side):
    """Crossed or slid along, on both sides of the belt's speed."""
    osc = paper_oscillator(0.3)
    start = {"x0": 0.02, "v0": osc.V - side * 1.3}
    steep = ss.FrictionLaw(f"{first} + ({second} - {first})*(1 + tanh((v - {place})/1e-5))/2")
    t = np.linspace(0, 1.0, 200)
    sharp, smooth = (
        jump(first, second, place, osc, 1.0, **start),
        ss.simulate(steep, osc, t_end=1.0, rtol=1e-8, **start),
    )
    assert sharp.at(t).x == pytest.approx(smooth.at(t).x, abs=2e-5)
    assert [event.begins for event in sharp.events] == [event.begins for event in smooth.events]


def test_a_jump_at_the_belt_speed_holds_the_mass_at_rest():
    motion = jump(0.3, 0.5, 0.5, paper_oscillator(0.0), 3.0)
    assert np.all(motion.at(np.linspace(1.5, 3, 9)).v == 0)
    assert motion.outcome is Outcome.AT_REST
    law = ss.FrictionLaw("Piecewise((0.3, v < 0.5), 0.5)")
    assert np.all(motion.x[motion.t > 1.5] == motion.x[-1])
    assert 0.3 <= motion.x[-1] * 100 / 9.81 <= 0.5  # anywhere between: by the jump, friction is what holds it
    for c in (0.0, 5.0, 50.0):  # with 50 it creeps there
        assert ss.classify(law, paper_oscillator(c), x0=0.1, v0=0.4) is ss.Motion.DAMPED_SLIP


# -- smoothed, stiff and overdamped ----------------------------------------------------------------


def test_a_smoothed_law_never_sticks_but_creeps_with_the_belt():
    """mu(0) = 0: nothing holds the mass, so it passes the belt's speed, or follows it a little slower."""
    osc = paper_oscillator(0.0)
    motion = ss.simulate(ss.FrictionLaw("(0.2 + 0.3*exp(-3*v))*tanh(v/1e-4)"), osc, t_end=3.0)
    assert not motion.starts_of(Phase.STICK).size
    assert {event.kind for event in motion.events} == {EventKind.START, EventKind.CROSSES}
    period = ss.stick_slip_cycle(ss.laws.exponential.typical(), osc).period
    slow = (motion.t > 0.2) & (np.abs(motion.v - osc.V) < 1e-3)
    arrivals = motion.t[slow][1:][np.diff(motion.t[slow]) > period / 2]
    assert np.diff(arrivals) == pytest.approx(period, rel=1e-2)


def test_a_very_steep_law_is_a_static_jump():
    """alpha V = 1e4: friction falls within 1e-4 of the belt's speed."""
    begin = time.perf_counter()
    steep, sudden = ss.laws.exponential.typical(alpha=2e4), ss.FrictionLaw("0.2", static="0.5")
    osc = paper_oscillator(0.3)
    found, limit = ss.stick_slip_cycle(steep, osc), ss.stick_slip_cycle(sudden, osc)
    assert found.period == pytest.approx(limit.period, rel=1e-3)
    assert found.x_max == pytest.approx(limit.x_max, rel=1e-3)
    assert ss.simulate(steep, osc, t_end=5.0, v0=0.0).outcome is Outcome.FINISHED
    assert time.perf_counter() - begin < NO_MORE_SECONDS


@pytest.mark.parametrize("c", [0.0, 1.0, 1e3])
def test_masses_of_all_sizes(law, c):
    begin = time.perf_counter()
    for exponent in range(-9, 10, 3):
        osc = paper_oscillator(c, m=10.0**exponent)
        cycle = ss.stick_slip_cycle(law, osc)
        t_end = 3 * (cycle.period if cycle else 2 * math.pi / osc.omega)
        motion = ss.simulate(law, osc, t_end=t_end, v0=0.0, rtol=1e-12)
        assert motion.t[-1] == pytest.approx(t_end, rel=1e-14)
        assert motions.violations(law, osc, motion, IMPLICIT) == []
        if cycle and exponent == -9:  # without inertia the mass turns back where friction gives way
            assert cycle.x_max == pytest.approx(osc.onset(law), rel=1e-6)
    assert time.perf_counter() - begin < NO_MORE_SECONDS


# -- bounds on the work ----------------------------------------------------------------------------


def test_a_step_limit_keeps_what_was_computed(law):
    osc = paper_oscillator(1.0)
    whole = ss.simulate(law, osc, t_end=5.0)
    cut = ss.simulate(law, osc, t_end=5.0, max_steps=60)
    assert (whole.outcome, cut.outcome) == (Outcome.FINISHED, Outcome.STEP_LIMIT)
    assert cut.events == whole.events[: len(cut.events)]
    assert cut.t == pytest.approx(whole.t[: len(cut.t)], rel=1e-15)
    assert 0.5 < cut.t[-1] < 4


def test_a_time_limit_keeps_what_was_computed(law):
    begin = time.monotonic()
    motion = ss.simulate(law, paper_oscillator(1.0), t_end=1e9, max_steps=10**9, time_limit=0.3)
    assert 0.3 < time.monotonic() - begin < NO_MORE_SECONDS
    assert motion.outcome is Outcome.TIME_LIMIT
    assert motion.t[-1] > 1
    assert motion.at(motion.t[-1] / 2).x < 1


def test_a_motion_that_comes_to_rest_says_so(law):
    osc = paper_oscillator(20.0)
    motion = ss.simulate(law, osc, t_end=100.0)
    assert motion.outcome is Outcome.AT_REST
    assert motion.at(99.0).v == 0
    assert motion.at(99.0).x == pytest.approx(osc.N * law.mu(osc.V) / osc.k, rel=1e-15)


@pytest.mark.parametrize("engine", ["scipy", pytest.param("heyoka", marks=needs_heyoka)])
@pytest.mark.parametrize("c", [-50.0, -5.0])
def test_a_motion_that_grows_for_ever_says_so_and_is_kept(engine, c):
    """At c = -50 it creeps away from the belt, at c = -5 it swings ever farther; both as far as numbers go."""
    law, osc = ss.FrictionLaw("0.3"), paper_oscillator(c)
    motion = ss.simulate(law, osc, t_end=1e3, engine=engine)
    assert motion.outcome is Outcome.UNBOUNDED
    assert "a larger c" in motion.note
    assert 1e90 < np.abs(motion.v).max() < 1e101
    # Friction is soon nothing beside damping, whose growth rate is the larger eigenvalue's.
    rate = max(np.roots([osc.m, c, osc.k]).real)
    late = np.abs(motion.v) > 1e50
    envelope = np.hypot(motion.v, motion.x * osc.omega)[late]
    assert np.log(envelope[-1] / envelope[0]) / np.ptp(motion.t[late]) == pytest.approx(rate, rel=0.02)
    assert ss.classify(law, osc) is ss.Motion.UNBOUNDED
    assert ss.regime(law, osc).unbounded
    with pytest.raises(ss.InputError, match=r"grows without bound.*a larger c"):
        motion.at(1e3)


def test_a_motion_that_comes_to_where_mu_has_no_value_is_kept():
    motion = ss.simulate(ss.FrictionLaw("0.5*sqrt(1 - v)"), paper_oscillator(), t_end=10.0)
    assert motion.outcome is Outcome.UNDEFINED
    assert "beyond a slip speed of 2 V" in motion.note
    assert motion.v[-1] == pytest.approx(-0.5, abs=1e-9)
    assert motion.at(motion.t[-1] / 2).v < 0.5


def test_a_start_beyond_the_static_limit_slips_at_once(law):
    osc = paper_oscillator(1.0)
    for x0, begins in ((0.2, Phase.SLIP_BACK), (-0.2, Phase.SLIP_FORWARD), (0.01, Phase.STICK)):
        first = ss.simulate(law, osc, t_end=0.1, x0=x0).events[0]
        assert (first.begins, first.kind) == (begins, EventKind.START)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"max_steps": 0}, "max_steps = 0 must be at least 1"),
        ({"max_steps": math.nan}, "max_steps = nan is not finite"),
        ({"time_limit": 0.0}, "time_limit = 0 s must be positive"),
        ({"t_end": -1.0}, "t_end = -1 must be positive"),
        ({"t_end": math.nan}, "t_end = nan is not finite"),
        ({"v0": math.inf}, "v0 = inf is not finite"),
    ],
)
def test_bounds_that_are_none(law, arguments, message):
    with pytest.raises(ss.InputError, match=message):
        ss.simulate(law, paper_oscillator(), **({"t_end": 1.0} | arguments))


def test_numbers_may_be_written_as_text(law):
    osc = paper_oscillator()
    plain = ss.simulate(law, osc, t_end=1.0, rtol=1e-8, max_steps=30, time_limit=60.0)
    assert ss.simulate(law, osc, t_end="1", rtol="1e-8", max_steps="30", time_limit="60").events == plain.events
    for call in (ss.stick_slip_cycle, ss.peak_velocity, ss.regime, ss.classify):
        assert repr(call(law, osc, rtol="1e-8")) == repr(call(law, osc, rtol=1e-8))
        with pytest.raises(ss.InputError, match="rtol = 1 is outside 1e-13"):
            call(law, osc, rtol="1")
    with pytest.raises(ss.InputError, match="time_limit = 0 s must be positive"):
        ss.simulate(law, osc, t_end=1.0, time_limit="0")


@pytest.mark.parametrize(
    ("V", "message"),
    [
        (0.0, "V = 0 must be positive: it is the belt speed; on a belt that stands still"),
        (-0.5, "V = -0.5 must be positive.*mirror the scene: V, x0 and v0 with their signs changed"),
    ],
)
def test_belts_that_stand_or_run_backward(V, message):
    with pytest.raises(ss.InputError, match=message):
        paper_oscillator(V=V)
