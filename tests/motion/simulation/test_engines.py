"""The engines: heyoka against many digits, and both against each other."""

import random
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import mpmath
import numpy as np
import pytest
from many_digits import exact_return
from scenes import paper_oscillator
from systems import needs_heyoka

import stickslip_sym as ss
from stickslip_sym.model.expression.parsing import FUNCTIONS
from stickslip_sym.model.oscillator import Scene
from stickslip_sym.motion.simulation import engines, heyoka, taylor
from stickslip_sym.motion.simulation.slip import follow
from stickslip_sym.motion.simulation.slip_phase import End, passage
from stickslip_sym.motion.simulation.steppers import Point
from stickslip_sym.motion.thresholds.grazing import grazing_damping

HEYOKA = engines.find("heyoka")
EXACT = 2e-14  # relative, of heyoka's events: 100 roundings
AGREES = 1e-12  # of a period or an event time that SciPy found at rtol = 1e-13
AT_THE_START = 3e-12  # and of an event less than 1/omega after the start, where SciPy's first steps still count
ROUGH = {
    "arcsinh": 3e-11,
    "logarithmic": 1e-11,
}  # laws that bend within 1e-3 m/s of rest, where SciPy's errors add up
NO_MORE_SECONDS = 10  # on a loaded machine; alone less than 1


P = Point(0.0, 0.0, 0.0)
RETURNS = {
    "exponential": (ss.laws.exponential.typical(), {}, P, 1),
    "polynomial": (ss.laws.polynomial.typical(), {"c": 1.0}, P, 1),
    "arcsinh": (ss.laws.catalogue["arcsinh"].typical(), {"c": 0.5}, P, 1),
    "layer ahead of a return": (ss.laws.catalogue["simscape"].typical(), {"V": 2.0}, Point(0.0, -1.0, 1.0), 1),
    "layer as thin as 1e-4": (ss.FrictionLaw("0.2 + 0.1*exp(-v/1e-4)", static="0.4"), {}, P, 1),
    "faster than the belt": (ss.laws.exponential.typical(), {}, Point(0.0, 2.0, 5.0), -1),
}


@needs_heyoka
@pytest.mark.parametrize("name", RETURNS)
def test_returns_are_exact(name):
    law, changes, start, side = RETURNS[name]
    scene = Scene.of(law, paper_oscillator(**changes))
    slip = follow(scene, start, side, horizon=100.0, rtol=1e-13, engine=HEYOKA)
    with mpmath.workdps(25):
        tau, q = exact_return(scene, start, side)
        assert abs(slip.last.tau - tau) < EXACT * tau
        assert abs(slip.last.q - q) < EXACT * max(1, abs(q), start.w)
    assert slip.end is End.RETURN
    assert slip.last.w == 0


@needs_heyoka
def test_a_layer_ahead_is_missed_unless_it_is_looked_for(monkeypatch):
    law, changes, start, side = RETURNS["layer ahead of a return"]
    scene = Scene.of(law, paper_oscillator(**changes))
    right = follow(scene, start, side, horizon=100.0, rtol=1e-13, engine=HEYOKA).last.tau
    monkeypatch.setattr(taylor, "_holds", lambda *_: True)
    blind = follow(scene, start, side, horizon=100.0, rtol=1e-13, engine=HEYOKA).last.tau
    assert abs(blind - right) > 0.01 * right


@needs_heyoka
def test_a_layer_behind_an_extremum_is_reached():
    """The step from a maximum is tried again, shorter, and the maximum then is no new one."""
    law = ss.laws.catalogue["gaussian"].typical(v_s=0.23)
    osc = ss.Oscillator(m=0.126, k=2472.0, c=1.36, V=2.516, N=1.892)
    motion = ss.simulate(law, osc, t_end=0.15, x0=-0.0454, v0=-5.245, engine="heyoka")
    assert motion.t[-1] == 0.15
    assert len(motion.t) < 1000


def scenes(name, count):
    """Draw oscillators and starts on both sides of the belt's speed."""
    rng = random.Random(f"{name} 6")
    for _ in range(count):
        V = 10 ** rng.uniform(-1.3, 0.3)
        osc = paper_oscillator(rng.uniform(0, 6), V=V, N=10 ** rng.uniform(-0.5, 1.5))
        yield osc, rng.uniform(-0.5, 0.5), rng.choice([None, rng.uniform(-3, V), rng.uniform(V, 3)])


SEEN = ["exponential", "polynomial", "hyperbolic", "tanh", "gaussian_viscous", "arcsinh", "simscape", "coulomb"]


@needs_heyoka
@pytest.mark.parametrize("name", SEEN)
def test_engines_find_the_same_events(name):
    law = ss.laws.catalogue[name].typical()
    for osc, x0, v0 in scenes(name, 5):
        ours, theirs = (
            ss.simulate(law, osc, t_end=2.0, x0=x0, v0=v0, rtol=1e-13, engine=engine).events
            for engine in ("scipy", "heyoka")
        )
        assert [event.begins for event in ours] == [event.begins for event in theirs]
        size = osc.length + max(abs(event.x) for event in theirs)
        for a, b in zip(ours, theirs, strict=True):
            agrees = max(AGREES if a.t > 1 / osc.omega else AT_THE_START, ROUGH.get(name, 0))
            assert a.t == pytest.approx(b.t, rel=agrees)
            assert a.x == pytest.approx(b.x, abs=10 * agrees * size)


@needs_heyoka
@pytest.mark.parametrize("name", ["exponential", "polynomial", "tanh"])
def test_near_the_threshold_engines_agree(name):
    law = ss.laws.catalogue[name].typical()
    threshold, _ = grazing_damping(law, paper_oscillator(), rtol=1e-12, engine="heyoka")
    assert threshold == pytest.approx(grazing_damping(law, paper_oscillator(), rtol=1e-12)[0], rel=1e-11)
    for distance in (1e-3, 1e-5, 1e-7, 1e-9):
        below, above = (paper_oscillator(threshold * factor) for factor in (1 - distance, 1 + distance))
        for engine in ("scipy", "heyoka"):
            assert ss.stick_slip_cycle(law, above, rtol=1e-13, engine=engine) is None
        ours, theirs = (ss.stick_slip_cycle(law, below, rtol=1e-13, engine=e) for e in ("scipy", "heyoka"))
        flat = distance**0.5  # a return at w' = -a has its time to within an error of w over a, and a ~ sqrt
        assert ours.slip_time == pytest.approx(theirs.slip_time, rel=AGREES / flat)
        assert ours.v_min == pytest.approx(theirs.v_min, rel=AGREES)
        peaks = [ss.peak_velocity(law, osc, rtol=1e-13, engine="heyoka") - 0.5 for osc in (below, above)]
        assert peaks[0] > 0 > peaks[1]


@needs_heyoka
def test_every_function_of_a_formula_is_translated():
    terms = "+".join(f"{name}(v + 1)/{len(FUNCTIONS)}" for name in FUNCTIONS if name != "tan")
    law = ss.FrictionLaw(f"0.02*({terms} + tan(v/5) + (v + 1)^(-3/2) + v^5 + pi*v)")
    osc = paper_oscillator(0.0, V=0.3)
    assert ss.peak_velocity(law, osc, rtol=1e-13, engine="heyoka") == pytest.approx(
        ss.peak_velocity(law, osc, rtol=1e-13), rel=AGREES
    )


@needs_heyoka
def test_a_whole_exponent_is_taken_as_such():
    gaussian = ss.laws.catalogue["gaussian"].typical()
    stribeck = ss.laws.stribeck.typical(delta=2)
    one, other = (ss.stick_slip_cycle(law, paper_oscillator(), engine="heyoka") for law in (gaussian, stribeck))
    assert one.period == pytest.approx(other.period, rel=EXACT)


@needs_heyoka
def test_one_compilation_serves_all_scenes_of_a_law():
    before = heyoka._compiled.of.cache_info().misses
    for alpha in (1.0, 2.5):
        law = ss.FrictionLaw("0.2 + 0.3*exp(-alpha*v) - 0*v").bind(alpha=alpha)
        for c in (0.0, 1.0):
            for rtol in (1e-6, 1e-12):
                ss.simulate(law, paper_oscillator(c), t_end=1.0, v0=1.0, rtol=rtol, engine="heyoka")
    assert heyoka._compiled.of.cache_info().misses <= before + 1


@needs_heyoka
def test_threads_do_not_mix_their_motions(law):
    dampings = [0.1 * i for i in range(20)]

    def period(c):
        return ss.stick_slip_cycle(law, paper_oscillator(c), engine="heyoka").period

    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(period, dampings)) == [period(c) for c in dampings]


@needs_heyoka
def test_dense_output_is_continuous_and_extrema_end_steps(law):
    scene = Scene.of(law, paper_oscillator(1.0))
    slip = follow(scene, P, 1, horizon=100.0, rtol=1e-13, engine=HEYOKA)
    for left, right in pairwise(slip.interpolants):
        assert left.t == right.t_old
        assert left(left.t) == pytest.approx(right(right.t_old), abs=1e-14)
    (maximum,) = slip.extrema
    assert maximum.tau in [piece.t for piece in slip.interpolants]
    assert scene.acceleration(maximum.q, maximum.w, 1) == pytest.approx(0.0, abs=1e-14)
    times = [0.0, 0.3, maximum.tau, slip.last.tau]
    assert slip.at(times)[1, [2, 3]] == pytest.approx([maximum.w, 0.0], abs=1e-14)


def motion(formula, engine="heyoka", static=None, c=0.0, **values):
    law = ss.FrictionLaw(formula, static=static).bind(**values)
    return ss.simulate(law, paper_oscillator(c), t_end=30.0, engine=engine)


@needs_heyoka
@pytest.mark.parametrize(
    ("error", "message", "arguments"),
    [
        (ss.InputError, "got Piecewise; use engine=.scipy", {"formula": "Piecewise((0.3, v < 0.2), 0.5)"}),
        (ss.InputError, "got Piecewise", {"formula": "0.3 + 0.1*Abs(v - 0.3)"}),
        (ss.InputError, "got Max", {"formula": "Max(a, b) + 0*v", "a": 0.2, "b": 0.3}),
        (ss.InputError, "no Taylor series at the slip speed 0; use engine=.scipy", {"formula": "0.5-0.1*sqrt(v)"}),
        (ss.InputError, "no Taylor series", {"formula": "0.5 - 0.1*v^p", "p": 1.5}),
        (ss.NotConverged, "a fast decay.*use engine=.scipy", {"formula": "0.5 - 0.1*v", "c": 1e4}),
        (ss.NotConverged, "use engine=.scipy", {"formula": "0.5*sqrt(1 - v)"}),
    ],
)
def test_what_the_taylor_engine_refuses(error, message, arguments, capfd):
    begin = time.process_time()
    with pytest.raises(error, match=message):
        motion(**arguments)
    assert time.process_time() - begin < NO_MORE_SECONDS
    assert capfd.readouterr() == ("", "")  # heyoka's own log keeps silent


@needs_heyoka
@pytest.mark.parametrize("c", [4.5, 60.0])
def test_rest_is_found(law, c):
    ended = ss.simulate(law, paper_oscillator(c), t_end=1e6, engine="heyoka")
    assert (ended.t[-1], ended.v[-1]) == (1e6, 0.0)


def test_without_heyoka_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "heyoka", None)
    with pytest.raises(ss.InputError, match=r"pip install 'stickslip_sym\[fast\]'"):
        motion("0.4321 - 0.1*v")
    assert motion("0.4321 - 0.1*v", engine="scipy").t[-1] == 30.0


def test_engines_have_names(law):
    osc = paper_oscillator()
    for call in (ss.stick_slip_cycle, ss.peak_velocity):
        with pytest.raises(
            ss.InputError, match=r"no engine 'heyoke' \(did you mean 'heyoka'\?\); known: scipy, heyoka"
        ):
            call(law, osc, engine="heyoke")
    with pytest.raises(ss.InputError, match="no engine 'rk4'"):
        ss.simulate(law, osc, t_end=1.0, engine="rk4")


class Cubic:
    """The cubic through the states and rates at both ends of a step."""

    def __init__(self, start, last, rates):
        self.start, self.t = start, last.tau
        h = last.tau - start.tau
        ends = [np.array((point.q, point.w)) for point in (start, last)]
        slopes = [h * np.array(rates(point.q, point.w)) for point in (start, last)]
        rise = ends[1] - ends[0]
        self.rows = ends[0], slopes[0], 3 * rise - 2 * slopes[0] - slopes[1], slopes[0] + slopes[1] - 2 * rise
        self.h = h

    def __call__(self, tau):
        s = (np.asarray(tau) - self.start.tau) / self.h
        return sum(np.multiply.outer(row, s**i) for i, row in enumerate(self.rows))


class RungeKutta:
    """The classical method of order 4, in small steps: an engine from outside."""

    def __init__(self, scene, phase, *, horizon, rtol, until):
        self.phase, self.horizon, self.until, self.rising = phase, horizon, until, True
        self.rates = lambda q, w: (1 - phase.side * w, scene.acceleration(q, w, phase.side))

    def check_work(self, *, bounded):
        pass

    def advance(self):
        phase, before = self.phase, self.phase.last
        h, y = min(0.01, self.horizon - before.tau), np.array((before.q, before.w))
        a = np.array(self.rates(*y))
        b = np.array(self.rates(*(y + h / 2 * a)))
        c = np.array(self.rates(*(y + h / 2 * b)))
        d = np.array(self.rates(*(y + h * c)))
        last = Point(before.tau + h, *(y + h / 6 * (a + 2 * b + 2 * c + d)).tolist())
        piece = Cubic(before, last, self.rates)
        phase.interpolants.append(piece)
        phase.last = last
        if (d[1] > 0) != self.rising:
            self.rising = not self.rising
            if phase.turns(last, self.rising, self.until):
                return
        if last.w <= 0 and not self.rising:
            tau = passage(piece, 0.0, before.tau, last.tau)
            phase.last, phase.end = Point(tau, float(piece(tau)[0]), 0.0), End.RETURN


def test_an_engine_from_outside_is_one_class_and_one_entry(law, monkeypatch):
    osc = paper_oscillator()
    monkeypatch.setitem(engines.ENGINES, "rk4", RungeKutta)
    one, other = (ss.stick_slip_cycle(law, osc, engine=engine) for engine in ("rk4", "scipy"))
    assert one.period == pytest.approx(other.period, rel=1e-7)
    motions = [ss.simulate(law, osc, t_end=3.0, engine=engine) for engine in ("rk4", "scipy")]
    times = [[event.t for event in motion.events] for motion in motions]
    assert times[0] == pytest.approx(times[1], rel=1e-7)
    assert [event.kind for event in motions[0].events] == [event.kind for event in motions[1].events]
