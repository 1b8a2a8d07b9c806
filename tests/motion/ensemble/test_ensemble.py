"""Ensembles: every motion of many starts is the one that `simulate` finds."""

import math
import tracemalloc

import numpy as np
import pytest
from scenes import laws_in_pieces, paper_oscillator

import stickslip_sym as ss
from stickslip_sym import Outcome, Phase, Tendency

AGREES = 1e-10  # of times in 1/omega and of states over the motion's size: the default tolerance of a step
BETWEEN = 1e-9  # of states between events, which are interpolated, and of extremes
DENSE = 400  # times at which the extremes of a motion are looked for
BISTABLE = ss.laws.exponential.bind(mu_s=1, mu_m=0.5, alpha=2), ss.Oscillator(m=1, k=1, c=0.1, V=1.5, N=1)
JUMPS = ss.FrictionLaw("Piecewise((0.5 - 0.1*v, v < 0.2), (0.7 - 0.1*v, v < 0.6), (0.4, True))")
SLIDES = ss.FrictionLaw("Piecewise((0.5 - 0.1*v, v < 0.8), (0.7 - 0.1*v, v < 5.2), (0.4, True))")
SCENES = {
    "bistable": (*BISTABLE, 200),
    "static coefficient": (ss.laws.exponential.typical().with_static("0.55"), paper_oscillator(1.5), 200),
    "Coulomb's jump at 0": (ss.laws.coulomb.typical().with_static("0.6"), paper_oscillator(0.3), 200),
    "overtakes": (ss.laws.exponential.typical(alpha=0.8), ss.Oscillator(m=1, k=1, c=-0.01, V=1, N=0.2), 200),
    "overtakes and sticks": (
        ss.laws.exponential.bind(mu_s=1.9, mu_m=0.25, alpha=16), ss.Oscillator(m=1, k=1, c=-0.1, V=1, N=0.95), 30,
    ),
    "cycle in pure slip": (ss.laws.polynomial.typical(), paper_oscillator(2.9), 30),
    "kinked": (ss.FrictionLaw("0.5 - 0.3*Min(v, 0.3) + 0.1*Max(v - 0.8, 0)"), paper_oscillator(2.0), 30),
    "jumps": (JUMPS, paper_oscillator(1.0), 40),
    "slides": (SLIDES, ss.Oscillator(m=0.2, k=0.92, c=0.065, V=6.16, N=1.85), 40),
    "no friction at rest": (ss.laws.simscape.typical(), paper_oscillator(0.5), 10),
    "tanh": (ss.FrictionLaw("0.4*tanh(v/0.1)"), paper_oscillator(0.5), 10),
    "held by a jump": (ss.FrictionLaw("Piecewise((0.3, v < 1/2), (0.5, True))"), paper_oscillator(1.0), 20),
}  # fmt: skip
"""A law, an oscillator, and how many starts."""


def starts(osc, count, seed):
    rng = np.random.default_rng(seed)
    x0 = rng.uniform(-3, 3, count) * (osc.length + 0.4 * osc.N / osc.k)
    return x0, np.where(rng.random(count) < 0.1, osc.V, osc.V * (1 + rng.normal(0, 1.5, count)))


def disagreement(found, number, motion, osc):
    """Return by how much a motion differs in its events, its end and its extremes, over their tolerances."""
    events = found.events_of(number)
    if [(event.begins, event.kind) for event in events] != [(event.begins, event.kind) for event in motion.events]:
        return math.inf
    t = np.linspace(0, motion.t[-1], DENSE)
    state = motion.at(t)
    size, fastest = osc.length + np.abs(motion.x).max(), osc.V + np.abs(motion.v).max()
    times = [abs(a.t - b.t) * osc.omega for a, b in zip(events, motion.events, strict=True)]
    places = [abs(a.x - b.x) / size + abs(a.v - b.v) / fastest for a, b in zip(events, motion.events, strict=True)]
    end = abs(found.x[number] - motion.x[-1]) / size, abs(found.v[number] - motion.v[-1]) / fastest
    # The lowest and highest of samples lie inside, by no more than a parabola between two of them.
    step = (motion.t[-1] * osc.omega / DENSE) ** 2
    beyond = [
        (found.x_min[number] - min(state.x.min(), motion.x.min())) / size,
        (max(state.x.max(), motion.x.max()) - found.x_max[number]) / size,
        (found.v_min[number] - min(state.v.min(), motion.v.min())) / fastest,
        (max(state.v.max(), motion.v.max()) - found.v_max[number]) / fastest,
    ]
    extremes = [max(part, -part * BETWEEN / step) for part in beyond]
    return max(max(times + places) / AGREES, max(end) / BETWEEN, max(extremes) / BETWEEN)


@pytest.mark.parametrize("name", SCENES)
def test_every_motion_is_as_simulated(name):
    law, osc, count = SCENES[name]
    x0, v0 = starts(osc, count, seed=3)
    t_end = (6 if count == 200 else 16) / osc.omega
    found = ss.ensemble(law, osc, x0=x0, v0=v0, t_end=t_end)
    assert found.alone <= 2
    for i in range(x0.size):
        motion = ss.simulate(law, osc, x0=x0[i], v0=v0[i], t_end=t_end)
        assert disagreement(found, i, motion, osc) < 1, i
        assert found.outcome[i] is motion.outcome
        assert found.phase[i] is motion.phase[-1]
        assert found.tendency[i] is motion.tendency
        assert found.change[i] == pytest.approx(motion.change or math.nan, abs=1e-8, nan_ok=True)
        sticks = motion.starts_of(Phase.STICK)
        assert (found.sticks[i], found.changes[i]) == (sticks.size, len(motion.events) - 1)
        first = sticks[0] if sticks.size else math.nan
        assert found.first_stick[i] == pytest.approx(first, abs=AGREES, nan_ok=True)


def test_a_change_in_the_tenth_digit_would_be_noticed():
    law, osc = BISTABLE
    x0, v0 = starts(osc, 12, seed=3)
    found = ss.ensemble(law, osc, x0=x0, v0=v0, t_end=16.0, rtol=1e-12)
    near = ss.Oscillator(m=1, k=1, c=0.1 * (1 + 1e-7), V=1.5, N=1)
    wrong = [
        disagreement(found, i, ss.simulate(law, near, x0=x0[i], v0=v0[i], t_end=16.0, rtol=1e-12), osc) > 1
        for i in range(12)
    ]
    assert sum(wrong) > 8


def test_laws_in_pieces():
    rng = np.random.default_rng(8)
    for number, law in enumerate(laws_in_pieces(rng, 4)):
        osc = paper_oscillator(rng.uniform(0, 3))
        x0, v0 = starts(osc, 8, seed=number)
        found = ss.ensemble(law, osc, x0=x0, v0=v0, t_end=1.5, rtol=1e-12)
        for i in range(x0.size):
            motion = ss.simulate(law, osc, x0=x0[i], v0=v0[i], t_end=1.5, rtol=1e-12)
            assert disagreement(found, i, motion, osc) < 1, (number, i)


@pytest.mark.parametrize("distance", [1e-3, 1e-6, 1e-9])
def test_a_graze_is_neither_missed_nor_invented(distance):
    """Along the orbit that leaves P, at dampings beside the threshold, at which it grazes the belt's speed."""
    law, scene = ss.laws.exponential.typical(), {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}
    threshold = ss.pure_slip_damping(law, **scene, method="simulation", rtol=1e-12).value
    for factor, returns in ((1 - distance, True), (1 + distance, False)):
        osc = paper_oscillator(threshold * factor)
        along = ss.simulate(law, osc, x0=osc.onset(law), t_end=0.2, rtol=1e-13)
        t = np.linspace(0.02, 0.2, 5)
        x0, v0, _ = along.at(t)
        found = ss.ensemble(law, osc, x0=x0, v0=v0, t_end=1.0, rtol=1e-13)
        assert (found.sticks > 0).all() == (found.sticks > 0).any() == returns
        assert found.alone == 0


def test_long_motions_are_the_cycle_again_and_again():
    law, osc = BISTABLE
    cycle = ss.stick_slip_cycle(law, osc)
    t_end = 300.4 * cycle.period
    found = ss.ensemble(law, osc, x0=[-1.8, 1.2, osc.onset(law)], v0=[0.5, 1.9, osc.V], t_end=t_end)
    for i in range(3):
        motion = ss.simulate(law, osc, x0=found.x0[i], v0=found.v0[i], t_end=t_end)
        assert found.tendency[i] is Tendency.STICK_SLIP
        assert [e.kind for e in found.events_of(i)] == [e.kind for e in motion.events]
        assert [e.t for e in found.events_of(i)] == pytest.approx([e.t for e in motion.events], rel=1e-11)
        assert (found.x[i], found.v[i]) == pytest.approx((motion.x[-1], motion.v[-1]), abs=1e-8)
    whose, t = found.starts_of(Phase.STICK)
    assert np.array_equal(np.bincount(whose), found.sticks)
    assert t[whose == 1] == pytest.approx([e.t for e in found.events_of(1) if e.begins is Phase.STICK])
    assert found.v_min[2] == pytest.approx(cycle.v_min, rel=1e-9)
    assert (found.x_min[2], found.x_max[2]) == pytest.approx((cycle.x_min, cycle.x_max), abs=1e-9)
    assert (found.x_min[:2] < cycle.x_min).all()


@pytest.mark.parametrize("rounds", [0.5, 0.99, 1.3, 1.99, 2.3])
def test_what_the_motion_from_p_has_come_to(rounds):
    """It is stick-slip once static friction has given way and the mass sticks again."""
    law, osc = BISTABLE
    t_end = rounds * ss.stick_slip_cycle(law, osc).period
    found = ss.ensemble(law, osc, x0=osc.onset(law), t_end=t_end)
    motion = ss.simulate(law, osc, x0=osc.onset(law), t_end=t_end)
    assert found.tendency.item() is motion.tendency
    assert motion.tendency is (Tendency.STICK_SLIP if rounds > 1.9 else Tendency.SHORT)
    assert found.first_stick.item() == pytest.approx(motion.events[1].t if rounds > 0.9 else math.nan, nan_ok=True)


def test_starts_do_not_depend_on_their_company():
    law, osc = BISTABLE
    x0, v0 = starts(osc, 4500, seed=5)  # more than are under way at once
    whole = ss.ensemble(law, osc, x0=x0, v0=v0, t_end=7.0)
    part = ss.ensemble(law, osc, x0=x0[4200:], v0=v0[4200:], t_end=7.0)
    assert part.x == pytest.approx(whole.x[4200:], abs=1e-11)
    assert np.array_equal(part.changes, whole.changes[4200:])
    assert part.x_max == pytest.approx(whole.x_max[4200:], abs=1e-11)


def test_memory_does_not_grow_with_the_time():
    law, osc = ss.laws.polynomial.typical(), paper_oscillator(3.1)

    def peak(t_end):
        tracemalloc.start()
        found = ss.ensemble(law, osc, x0=np.linspace(-0.01, 0.1, 500), v0=0.1, t_end=t_end, rtol=1e-4)
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert found.changes.max() <= 2  # slip, all the time
        return most

    assert peak(3.0) < 1.2 * peak(1.5)


def test_the_time_limit_ends_motions_as_they_are():
    law, osc = BISTABLE
    x0 = np.linspace(0.4, 0.6, 300)
    found = ss.ensemble(law, osc, x0=x0, v0=0.0, t_end=1e6, time_limit=0.15)
    assert set(found.outcome) == {Outcome.TIME_LIMIT}
    assert found.t.max() < 1e6
    furthest = int(found.t.argmax())
    motion = ss.simulate(law, osc, x0=x0[furthest], v0=0.0, t_end=float(found.t[furthest]))
    assert found.x[furthest] == pytest.approx(motion.x[-1], abs=1e-8)
    sticking = ss.ensemble(law, osc, x0=-1.8, v0=0.0, t_end=1e9, time_limit=5.0)
    assert sticking.outcome.item() is Outcome.FINISHED  # a motion that sticks is integrated for one round


def test_what_is_followed_one_by_one():
    x0, v0 = [0.0, 0.01, 0.2], [0.0, 0.5, -0.4]
    measured = ss.FrictionLaw.from_samples([0, 0.05, 0.1, 0.2, 0.4, 1.0], [0.5, 0.44, 0.4, 0.34, 0.29, 0.27])
    found = ss.ensemble(measured, paper_oscillator(1.0), x0=x0, v0=v0, t_end=5.0)
    assert found.alone == 1
    assert found.outcome.tolist() == [Outcome.FINISHED, Outcome.UNDEFINED, Outcome.UNDEFINED]
    assert "measured up to 2 V" in found.notes[1]
    for law, osc in (
        (measured, paper_oscillator(1.0)),
        (ss.FrictionLaw("0.5*sqrt(1 - v)"), paper_oscillator(1.0)),  # no value on the way
        (ss.laws.exponential.typical(), paper_oscillator(3e4)),  # a fast decay
        (ss.laws.exponential.typical(), paper_oscillator(6.0)),  # rest
    ):
        found = ss.ensemble(law, osc, x0=x0, v0=v0, t_end=5.0)
        for i in range(3):
            motion = ss.simulate(law, osc, x0=x0[i], v0=v0[i], t_end=5.0)
            assert found.outcome[i] is motion.outcome
            assert found.notes.get(i, "") == motion.note
            assert (found.t[i], found.x[i]) == pytest.approx((motion.t[-1], motion.x[-1]), rel=1e-8)
    lost = ss.ensemble(ss.FrictionLaw("0.5*sqrt(1 - v)"), paper_oscillator(1.0), x0=0.0, v0=-3.0, t_end=1.0)
    assert lost.outcome.item() is Outcome.UNDEFINED
    assert "where the motion starts" in lost.notes[0]


def test_motions_without_bound():
    found = ss.ensemble(ss.laws.coulomb.typical(), paper_oscillator(-20.0), x0=[0.0, 0.2], t_end=60.0, rtol=1e-6)
    assert set(found.outcome) == {Outcome.UNBOUNDED}
    assert (found.t < 60).all()


def test_shapes_and_files(tmp_path):
    law, osc = BISTABLE
    found = ss.ensemble(law, osc, x0=np.array([[-1.0], [0.5]]), v0=[0.0, 1.0, 2.0], t_end=20.0)
    assert found.x.shape == found.tendency.shape == (2, 3)
    assert found.events_of(5)[0].v == 2.0
    assert found.count()[Tendency.STICK_SLIP] == int((found.sticks > 1).sum())
    assert "6 starts to t = 20 s" in repr(found)
    assert "stick-slip</td>" in found._repr_html_()
    found.to_csv(tmp_path / "starts.csv")
    lines = (tmp_path / "starts.csv").read_text().splitlines()
    assert lines[0].startswith("x0 (m),v0 (m/s),t (s),x (m)")
    assert len(lines) == 7
    assert ss.ensemble(law, osc, x0=0.0, t_end=1.0).v0.item() == osc.V
    with pytest.raises(ss.InputError, match="start = 6 is none of the 6 starts"):
        found.events_of(6)


@pytest.mark.parametrize(
    ("message", "arguments"),
    [
        ("t_end = -1 must be positive", {"t_end": -1.0}),
        ("time_limit = 0 s must be positive", {"time_limit": 0}),
        ("rtol = 0.1 is outside", {"rtol": 0.1}),
        ("x0 holds a value that is not finite", {"x0": [0.0, np.nan]}),
        ("do not go together", {"x0": [0.0, 1.0], "v0": [0.0, 1.0, 2.0]}),
        ("hold no starts", {"x0": []}),
        ("has no value for alpha", {"law": ss.laws.exponential.bind(mu_s=1, mu_m=0.5)}),
    ],
)
def test_what_is_refused(message, arguments):
    law, osc = BISTABLE
    with pytest.raises(ss.InputError, match=message):
        ss.ensemble(**{"law": law, "osc": osc, "x0": 0.0, "t_end": 1.0} | arguments)
