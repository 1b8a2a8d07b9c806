"""Every long call ends: stiff motions within a bound on the work, and all calls soon after their time limit."""

import math
import os
import re
import signal
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym import Motion
from stickslip_sym.core import deadline
from stickslip_sym.motion import slip
from stickslip_sym.motion.maps.cells import Reason
from stickslip_sym.motion.orbits import needed
from support.commands import started
from support.operating_points import paper_oscillator
from support.sweeps import sweep

POINT = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}
STIFF = [
    (ss.laws.bengisu_akay.typical(), paper_oscillator(1.5)),
    (ss.laws.exponential.typical(), ss.Oscillator(m=1, k=1, V=0.5, N=50, c=1.5)),
    (ss.FrictionLaw("0.6 - 0.01*log(1 + v/1e-6)"), ss.Oscillator(V=1e-3, N=1e5, m=1e3, k=1e6, c=1.5)),
]
MOTIONS = {"StickSlipCycle": Motion.STICK_SLIP, "LimitCycle": Motion.PURE_SLIP, "Rest": Motion.REST}


def agree(found, motion):
    """Whether a motion that a start leads to is one of a regime; or else it was said that this is not decided."""
    if motion is Motion.UNDECIDED:
        return True
    if motion is Motion.UNBOUNDED:
        return found.unbounded
    kinds = {MOTIONS[type(attractor).__name__] for attractor in found.attractors}
    return motion in kinds or bool(found.undecided)


@pytest.mark.parametrize(("law", "osc"), STIFF)
def test_regimes_of_stiff_operating_points_are_found_soon(law, osc):
    """By the time of the processor they took 12 to 175 s; the limit fails the test, and is not what ends them."""
    found = ss.regime(law, osc, time_limit=60)
    assert not found.undecided
    assert agree(found, ss.classify(law, osc))


@sweep("count", [2, 16], 2)
def test_regimes_and_classification_agree_over_decades(count):
    rng = np.random.default_rng(1)
    for name in rng.choice(sorted(ss.laws.catalogue), count).tolist():
        V, N, m, k, damping = 10 ** rng.uniform([-3, -1, -2, 0, -3], [1, 3, 3, 6, 1])
        law, osc = ss.laws.catalogue[name].typical(), ss.Oscillator(V=V, N=N, m=m, k=k, c=damping * np.sqrt(k * m))
        found = ss.regime(law, osc, time_limit=60)
        assert agree(found, ss.classify(law, osc, time_limit=60)), (law, osc, found)


def test_a_late_regime_is_refused():
    with pytest.raises(ss.OutOfTime):
        ss.regime(ss.laws.catalogue["simscape"].typical(), paper_oscillator(1.4321), time_limit=0)


def test_a_late_threshold_is_given_as_known():
    """A clock that stands still until so many looks at it: where it stops does not depend on the machine."""
    law, values = ss.laws.exponential.typical(), []
    exact = ss.pure_slip_damping(law, **POINT, method="simulation", rtol=1e-10).value
    for looks in range(4, 22, 3):  # a damping that is tried takes more than three
        with pytest.MonkeyPatch.context() as patch:
            clock = iter([0.0] * looks)
            patch.setattr(deadline.time, "monotonic", lambda clock=clock: next(clock, 1e9))
            patch.setattr(needed, "is_ready", lambda _: False)  # machine code of earlier tests looks less often
            with pytest.raises(ss.OutOfTime, match="the best value so far is") as caught:
                ss.pure_slip_damping(law, **POINT, method="simulation", rtol=1e-10, time_limit=100)
        said = re.search(r"c = (\S+) sqrt.* between (\S+) and (\S+)", str(caught.value))
        value, low, high = (10 * float(number) for number in said.groups())
        assert low <= exact + 5e-6  # six digits are printed
        assert high >= exact - 5e-6
        if value not in values:
            values.append(value)
    off = np.abs(np.array(values) / exact - 1)
    assert (off[:3] < [0.1, 1e-4, 1e-5]).all()  # the harmonic balance, and Newton steps
    assert (off[2:] < 1e-5).all()


@pytest.mark.parametrize("seconds_each", [1e-4, 0.3])
def test_slow_slips_are_looked_at_one_by_one_and_quick_ones_together(monkeypatch, seconds_each):
    """As if compiled, with a clock that only slips move: what is not reached within the limit stays NaN."""
    now, calls, rows = 0.0, [], np.full((1000, 1), np.nan)

    def loop(_, columns, result):
        nonlocal now
        now += seconds_each * len(result)
        calls.append(len(result))
        result[:, 0] = columns[0]

    monkeypatch.setattr(slip, "is_compiling", lambda: True)
    monkeypatch.setattr(slip, "compiled", lambda function: function)
    monkeypatch.setattr(deadline.time, "monotonic", lambda: now)
    system = slip.NondimensionalOscillator.of(ss.laws.exponential.typical().bound, paper_oscillator(1.0))
    with deadline.time_limit(1.0):
        system.spread(loop, (np.arange(1000.0),), (), rows)
    done = ~np.isnan(rows[:, 0])
    assert (rows[done, 0] == np.arange(1000)[: done.sum()]).all()
    assert done.sum() == min(1000, math.ceil(1 / seconds_each))
    assert calls[:4] == ([1, 1, 1, 1] if seconds_each == 0.3 else [1, 2, 4, 8])
    assert len(calls) < 15


@pytest.mark.parametrize("seconds", [0.0, 0.02])
def test_what_a_limited_map_decides_is_right(seconds):
    """Of a law for which collocation is tried in vain, and of starts that geometry settles if there is time."""
    law = ss.laws.logarithmic.typical()
    plane = {"x": ("V", [0.3, 0.5, 0.7]), "y": ("c", [1.0, 3.0]), "N": 9.81, "m": 1, "k": 100}
    starts = {"x0": np.linspace(-0.05, 0.1, 4), "v0": np.linspace(0, 0.4, 3)}
    limited = ss.motion_map(law, **plane, time_limit=seconds)
    decided = limited.reason != Reason.TIME
    assert (limited.motion == ss.motion_map(law, **plane).motion)[decided].all()
    assert seconds or not decided.any()
    assert all(limited.motion[place] is Motion.UNDECIDED for place in limited.notes)
    basins = ss.basin_map(law, paper_oscillator(1.0), **starts, time_limit=seconds)
    assert seconds or all("time limit" in note for note in basins.notes.values())
    assert np.isin(basins.motion, [Motion.STICK_SLIP, Motion.UNDECIDED]).all()


@pytest.mark.skipif(sys.platform == "win32", reason="no interrupt for a group of processes there")
def test_control_c_ends_a_long_map_at_once():
    """It goes to the workers too, as from a terminal."""
    ss.motion_map(ss.laws.tanh.typical(), x=("V", [0.3]), y=("N", [9.81]), c=1, m=1, k=100)  # is compiled then
    with started("map", "tanh", "--x", "V=0.1:1:300", "--y", "N=1:50:999", "-c", "1", "--workers", "2") as process:
        threads, late = Path(f"/proc/{process.pid}/task"), time.monotonic() + (30 if Path("/proc").exists() else 4)
        while time.monotonic() < late and not (threads.exists() and len(list(threads.iterdir())) > 2):
            time.sleep(0.02)  # until both workers are there
        os.killpg(process.pid, signal.SIGINT)
        _, err = process.communicate(timeout=20)
    assert process.returncode == 130, err
    assert "Traceback" not in err
