"""`time_limit` is one thing in every call: seconds from 0 to a day; nothing is claimed once they are over."""

import inspect
import math
import time
import warnings
from contextlib import suppress
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

import stickslip_sym as ss
from stickslip_sym.core import deadline
from support.strategies import laws, operating_points
from support.sweeps import fewer

LAW = ss.laws.exponential.typical()
OSC = ss.Oscillator(m=1, k=100, c=2.3, V=0.5, N=9.81)
LAST = 60.0  # CPU seconds in which a call with a limit of 0.2 s returns on any machine: this tells it from a hang
BOX = {"x0": [-1.0, 1.0], "v0": [0.0, 1.0]}
CALLS = {
    "derive": lambda law, osc, t: ss.derive(law, time_limit=t),
    "pure_slip_damping": lambda law, osc, t: ss.pure_slip_damping(law, osc, method="simulation", time_limit=t),
    "critical": lambda law, osc, t: ss.critical(law, "N", osc, time_limit=t),
    "margins": lambda law, osc, t: ss.margins(law, osc, time_limit=t),
    "compare": lambda law, osc, t: ss.compare(law, osc, time_limit=t),
    "simulate": lambda law, osc, t: ss.simulate(law, osc, t_end=1.0, time_limit=t),
    "classify": lambda law, osc, t: ss.classify(law, osc, x0=0.0, v0=0.0, time_limit=t),
    "regime": lambda law, osc, t: ss.regime(law, osc, time_limit=t),
    "limit_cycles": lambda law, osc, t: ss.limit_cycles(law, osc, time_limit=t),
    "stick_slip_cycle": lambda law, osc, t: ss.stick_slip_cycle(law, osc, time_limit=t),
    "motion_map": lambda law, osc, t: ss.motion_map(
        law, x=("V", [0.3]), y=("c", [1.0]), N=osc.N, m=osc.m, k=osc.k, time_limit=t
    ),
    "basin_map": lambda law, osc, t: ss.basin_map(law, osc, **BOX, time_limit=t),
    "basin_sweep": lambda law, osc, t: ss.basin_sweep(
        law, osc, ("V", [0.3, 0.4]), x0=(-1, 1), v0=(0, 1), time_limit=t
    ),
    "study": lambda law, osc, t: ss.study(law, osc, time_limit=t),
    "tradeoff": lambda law, osc, t: ss.tradeoff(law, time_limit=t),
}


def test_every_call_with_a_time_limit_is_here():
    public = {name: getattr(ss, name) for name in ss.__all__ if inspect.isroutine(getattr(ss, name))}
    limited = {name for name, call in public.items() if "time_limit" in inspect.signature(call).parameters}
    assert limited == set(CALLS)


@pytest.mark.parametrize("seconds", [-1.0, 86_401.0, 1e9, math.nan, math.inf])
@pytest.mark.parametrize("name", CALLS)
def test_what_is_no_time_is_refused(name, seconds):
    with pytest.raises(ss.InputError, match=r"time_limit = .* from 0 to 86400"):
        CALLS[name](LAW, OSC, seconds)
    with pytest.raises(ss.InputError, match=r"time_limit = .* is not a number"):
        CALLS[name](LAW, OSC, [1.0])


@pytest.mark.parametrize("name", sorted(set(CALLS) - {"compare", "simulate", "motion_map", "basin_map", "study"}))
def test_a_call_without_time_is_given_up(name):
    with pytest.raises((ss.OutOfTime, ss.NoClosedForm), match="time limit"):
        CALLS[name](LAW, OSC, 0)


def test_nothing_is_claimed_without_time():
    LAW = ss.laws.exponential.typical(alpha=3.125)  # of which nothing is kept from other tests
    study = CALLS["study"](LAW, OSC, 0)
    assert study.headline.startswith("Whether there is stick-slip")
    assert study.verdict.startswith("The motions were not found") or "Undecided" in study.verdict
    assert all(
        answer.threshold is None for answer in CALLS["compare"](LAW, OSC, 0) if answer.method in ("orbit", "proof")
    )
    assert CALLS["simulate"](LAW, OSC, 0).t[-1] < 1.0
    assert not CALLS["regime"](LAW, OSC, None).undecided


@fewer(3)
@given(laws(static=True), operating_points(), st.sampled_from(sorted(CALLS)))
def test_a_time_limit_holds_for_any_law(law, osc, name):
    """Laws with fitted numbers, with which exact powers once took hours."""
    start = time.process_time()
    with warnings.catch_warnings(action="ignore"), suppress(ss.StickSlipError):
        CALLS[name](law, replace(osc, c=0.5 * osc.impedance), 0.2)
    assert time.process_time() - start < LAST


def test_compiling_counts_in_no_limit(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(deadline._Clock, "exempted", 0.0)
    monkeypatch.setattr(deadline.time, "monotonic", lambda: now[0])
    with deadline.time_limit(10):
        with deadline.exempt_from_time_limit():
            now[0] += 100.0
        assert deadline.time_left() == 10
