"""The automaton against independent integrations, round after round, and at its limits: stiff and unbounded."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from numpy.polynomial.legendre import leggauss

import stickslip_sym as ss
from stickslip_sym import Outcome, Phase
from support import reference_motions
from support.operating_points import paper_oscillator
from support.sweeps import sample

IMPLICIT = 1e-7  # of w between the steps of the implicit method, whose interpolant is of order 3
AGREES = 1e-6  # of the size of a motion
GOES_ON = 1e-9  # of the size of a motion; a hundred steps at rtol = 1e-12, and grazes
EVENT_TIMES = 1e-11  # relative, at rtol = 1e-12


@given(seed=st.integers(0, 10**6))
def test_no_event_is_missed_and_none_is_spurious(seed):
    law, osc, x0, v0 = reference_motions.one_point(seed)
    motion = reference_motions.simulated(law, osc, x0, v0)
    assert reference_motions.violations(law, osc, motion) == []


@sample(4)
@pytest.mark.parametrize(("law", "osc", "x0", "v0"), [point[1:] for point in reference_motions.points(8, seed=6)])
def test_event_times_against_an_independent_integration(law, osc, x0, v0):
    motion = reference_motions.simulated(law, osc, x0, v0)
    expected = reference_motions.reference(law, osc, x0, v0, motion.t[-1])
    assert reference_motions.disagreement(motion.events, expected) < EVENT_TIMES


def test_the_checks_of_events_can_fail():
    law, osc = ss.laws.exponential.typical(), paper_oscillator(1.0)
    motion = ss.simulate(law, osc, t_end=2.0, x0=0.2, v0=0.0, rtol=1e-12)
    assert reference_motions.violations(law, osc, motion) == []
    first, *others = motion.stretches
    for wrong in (replace(first, phase=Phase.SLIP_FORWARD), replace(first, phase=Phase.STICK)):
        assert reference_motions.violations(law, osc, replace(motion, stretches=(wrong, *others)))
    expected = reference_motions.reference(law, osc, 0.2, 0.0, 2.0)
    late = [(t * (1 + 1e-10), phase) for t, phase in expected]
    assert reference_motions.disagreement(motion.events, late) > EVENT_TIMES
    assert reference_motions.disagreement(motion.events, expected[:-1]) == math.inf


@given(seed=st.integers(0, 10**6))
def test_motions_are_those_of_solve_ivp(seed):
    """SciPy's integrator with events, which shares nothing with the package's but mu, at a tolerance of 1e-10."""
    law, osc, x0, v0 = reference_motions.one_point(seed)
    t_end = 8 / osc.omega
    ours, other = (
        ss.simulate(law, osc, x0=x0, v0=v0, t_end=t_end, rtol=1e-10, method=one) for one in ("events", "solve_ivp")
    )
    assert ours.outcome is Outcome.FINISHED
    assert [event.begins for event in ours.events] == [event.begins for event in other.events]
    t = np.linspace(0, t_end, 40)
    assert ours.at(t).x == pytest.approx(other.at(t).x, abs=AGREES * (osc.length + np.ptp(ours.x)))


@given(seed=st.integers(0, 10**6))
def test_slips_are_those_of_lsoda(seed):
    law, osc, x0, v0 = reference_motions.one_point(seed)
    motion = reference_motions.simulated(law, osc, x0, v0)
    for stretch in motion.stretches[:3]:
        if stretch.phase is not Phase.STICK:
            t = np.linspace(stretch.start, stretch.end, 9)[1:-1]
            x, v = stretch.course(t)
            size = np.array([osc.length + np.ptp(x), osc.V + np.ptp(v)])[:, None]
            off = reference_motions.lsoda(law, osc, x[0], v[0], t) - [x, v]
            assert np.abs(off / size).max() < 1e-7


def test_stiff_slips_are_those_of_lsoda(law):
    osc, t = paper_oscillator(1e4), np.array([0.0, 1e-4, 1e-2, 1.0, 50.0])
    motion = ss.simulate(law, osc, t_end=50.0, x0=0.2, v0=-3.0)
    found = motion.at(t)
    assert np.array([found.x, found.v]) == pytest.approx(
        reference_motions.lsoda(law, osc, 0.2, -3.0, t), rel=1e-5, abs=1e-8
    )


@pytest.mark.parametrize("change", [{"c": 1.001}, {"N": 9.815}])
def test_the_reference_notices_a_wrong_motion(law, change):
    other = ss.simulate(law, paper_oscillator(1.0), t_end=3.0, method="solve_ivp", rtol=1e-10)
    wrong = ss.simulate(law, paper_oscillator(**{"c": 1.0} | change), t_end=3.0)
    assert np.abs(wrong.at(other.t[-1]).x - other.x[-1]) > 10 * AGREES * paper_oscillator().length


def test_a_motion_goes_on_from_any_point():
    """A motion that sticks is integrated for one round, and is what it would be if every round were."""
    sticking, cut = 0, 0.43
    for kind, law, osc, x0, v0 in reference_motions.points(18, seed=11):
        t_end = 40 / osc.omega
        whole = ss.simulate(law, osc, t_end=t_end, x0=x0, v0=v0, rtol=1e-12)
        if whole.outcome is not Outcome.FINISHED:
            continue
        sticking += whole.starts_of(Phase.STICK).size > 3
        middle = whole.at(cut * t_end)
        rest = ss.simulate(law, osc, t_end=(1 - cut) * t_end, x0=float(middle.x), v0=float(middle.v), rtol=1e-12)
        size = osc.length + np.abs(whole.x).max()
        assert rest.x[-1] == pytest.approx(whole.x[-1], abs=GOES_ON * size), kind
        later = [event.t for event in whole.events if event.t > cut * t_end]
        assert [event.t + cut * t_end for event in rest.events[1:]] == pytest.approx(later, abs=GOES_ON * t_end)
    assert sticking > 3


def test_every_round_is_the_cycle(law):
    osc = paper_oscillator(1.0)
    period = ss.stick_slip_cycle(law, osc).period
    motion = ss.simulate(law, osc, t_end=200.2 * period, x0=0.2, v0=0.0)
    sticks = motion.starts_of(Phase.STICK)
    assert len(sticks) in (199, 200, 201)
    assert np.diff(sticks)[1:] == pytest.approx(period, rel=1e-9)
    assert (np.diff(motion.t) >= 0).all()
    t = np.linspace(100 * period, 101 * period, 50)
    assert motion.at(t).x == pytest.approx(motion.at(t + 90 * period).x, abs=1e-8 * osc.length)


@pytest.mark.parametrize("c", [1.0, -0.5])
def test_the_energy_balance_closes_over_20_cycles(law, c):
    """Work of friction and damping, by quadrature of the dense output, against kinetic and elastic energy."""
    osc = paper_oscillator(c)
    period = ss.stick_slip_cycle(law, osc).period
    motion = ss.simulate(law, osc, t_end=20 * period, rtol=1e-12)
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
    assert len(motion.starts_of(Phase.STICK)) >= 20
    assert abs(work - (energy[-1] - energy[0])) < 1e-9 * exchanged
    assert np.all(motion.v[motion.phase == Phase.STICK] == osc.V)


@given(
    name=st.sampled_from(["exponential", "polynomial"]),
    exponent=st.floats(-9, 9),
    c=st.sampled_from([0.0, 1.0, 1e3]),
)
@example("exponential", -9, 1.0)
def test_masses_of_all_sizes(name, exponent, c):
    law, osc = ss.laws.catalogue[name].typical(), paper_oscillator(c, m=10.0**exponent)
    cycle = ss.stick_slip_cycle(law, osc)
    t_end = 3 * (cycle.period if cycle else 2 * math.pi / osc.omega)
    motion = ss.simulate(law, osc, t_end=t_end, v0=0.0, rtol=1e-12)
    assert motion.t[-1] == pytest.approx(t_end, rel=1e-14)
    assert reference_motions.violations(law, osc, motion, IMPLICIT) == []
    if cycle and exponent == -9:  # without inertia the mass turns back where friction gives way
        assert cycle.x_max == pytest.approx(osc.onset(law), rel=1e-6)


def test_limits_keep_what_was_computed():
    law, osc = ss.laws.exponential.typical(), paper_oscillator(1.0)
    whole = ss.simulate(law, osc, t_end=5.0)
    cut = ss.simulate(law, osc, t_end=5.0, max_steps=20)
    assert (whole.outcome, cut.outcome) == (Outcome.FINISHED, Outcome.STEP_LIMIT)
    assert cut.events == whole.events[: len(cut.events)]
    assert cut.t == pytest.approx(whole.t[: len(cut.t)], rel=1e-15)
    assert 0.1 < cut.t[-1] < 1
    late = ss.simulate(law, osc, t_end=1e9, max_steps=10**9, time_limit=0.3)
    assert late.outcome is Outcome.TIME_LIMIT
    assert late.at(late.t[-1] / 2).x < 1


def test_many_rounds_are_no_more_work_than_one():
    """A round that is repeated takes one step: ten thousand of them end at the time that was asked for."""
    law, osc = ss.laws.exponential.typical(), paper_oscillator(1.0)
    period = ss.stick_slip_cycle(law, osc).period
    motion = ss.simulate(law, osc, t_end=1e4 * period)
    assert motion.outcome is Outcome.FINISHED
    assert len(motion.starts_of(ss.Phase.STICK)) in (10_000, 10_001)
    assert ss.simulate(law, osc, t_end=1e4 * period, max_steps=1000).outcome is Outcome.STEP_LIMIT


@pytest.mark.parametrize("c", [-50.0, -5.0])
def test_unbounded_motions_say_so_and_are_kept(c):
    """At c = -50 it creeps away from the belt, at c = -5 it swings ever farther; both as far as laws are known."""
    law, osc = ss.FrictionLaw("0.3"), paper_oscillator(c)
    motion = ss.simulate(law, osc, t_end=1e3)
    assert motion.outcome is Outcome.UNBOUNDED
    assert "a larger c" in motion.note
    assert 1e19 < np.abs(motion.v).max() < 1.1e20
    # Friction is soon nothing beside damping, whose growth rate is the larger eigenvalue's.
    rate = max(np.roots([osc.m, c, osc.k]).real)
    late = np.abs(motion.v) > 1e10
    envelope = np.hypot(motion.v, motion.x * osc.omega)[late]
    assert np.log(envelope[-1] / envelope[0]) / np.ptp(motion.t[late]) == pytest.approx(rate, rel=0.02)
    assert ss.classify(law, osc) is ss.Motion.UNBOUNDED
    assert ss.stick_slip_cycle(law, osc) is None
    assert ss.regime(law, osc).unbounded
    with pytest.raises(ss.InputError, match=r"grows without bound.*a larger c"):
        motion.at(1e3)


def test_motions_end_where_mu_has_no_value():
    motion = ss.simulate(ss.FrictionLaw("0.5*sqrt(1 - v)"), paper_oscillator(), t_end=10.0)
    assert motion.outcome is Outcome.UNDEFINED
    assert "beyond a slip speed of 2 V" in motion.note
    assert motion.v[-1] == pytest.approx(-0.5, abs=1e-9)
    assert motion.at(motion.t[-1] / 2).v < 0.5


def test_numbers_may_be_written_as_text():
    law, osc = ss.laws.exponential.typical(), paper_oscillator()
    plain = ss.simulate(law, osc, t_end=1.0, rtol=1e-8, max_steps=30, time_limit=60.0)
    assert ss.simulate(law, osc, t_end="1", rtol="1e-8", max_steps="30", time_limit="60").events == plain.events
    for call in (ss.stick_slip_cycle, ss.peak_velocity, ss.regime, ss.classify):
        assert repr(call(law, osc, rtol="1e-8")) == repr(call(law, osc, rtol=1e-8))
        with pytest.raises(ss.InputError, match="rtol = 1 is outside 1e-13"):
            call(law, osc, rtol="1")
