"""`time_limit` is one thing in every call: seconds from 0 to a day; nothing is claimed once they are over."""

import inspect
import math

import pytest

import stickslip_sym as ss

LAW = ss.laws.exponential.typical()
OSC = ss.Oscillator(m=1, k=100, c=2.3, V=0.5, N=9.81)
BOX = {"x0": [-1.0, 1.0], "v0": [0.0, 1.0]}
CALLS = {
    "derive": lambda t: ss.derive(LAW, time_limit=t),
    "pure_slip_damping": lambda t: ss.pure_slip_damping(LAW, OSC, method="simulation", time_limit=t),
    "critical": lambda t: ss.critical(LAW, "N", OSC, time_limit=t),
    "margins": lambda t: ss.margins(LAW, OSC, time_limit=t),
    "compare": lambda t: ss.compare(LAW, OSC, time_limit=t),
    "simulate": lambda t: ss.simulate(LAW, OSC, t_end=1.0, time_limit=t),
    "classify": lambda t: ss.classify(LAW, OSC, x0=0.0, v0=0.0, time_limit=t),
    "regime": lambda t: ss.regime(LAW, OSC, time_limit=t),
    "limit_cycles": lambda t: ss.limit_cycles(LAW, OSC, time_limit=t),
    "stick_slip_cycle": lambda t: ss.stick_slip_cycle(LAW, OSC, time_limit=t),
    "motion_map": lambda t: ss.motion_map(LAW, x=("V", [0.3]), y=("c", [1.0]), N=9.81, m=1, k=100, time_limit=t),
    "basin_map": lambda t: ss.basin_map(LAW, OSC, **BOX, time_limit=t),
    "basin_sweep": lambda t: ss.basin_sweep(LAW, OSC, ("V", [0.3, 0.4]), x0=(-1, 1), v0=(0, 1), time_limit=t),
    "study": lambda t: ss.study(LAW, OSC, time_limit=t),
    "tradeoff": lambda t: ss.tradeoff(LAW, time_limit=t),
}


def test_every_call_with_a_time_limit_is_here():
    public = {name: getattr(ss, name) for name in ss.__all__ if inspect.isroutine(getattr(ss, name))}
    limited = {name for name, call in public.items() if "time_limit" in inspect.signature(call).parameters}
    assert limited == set(CALLS)


@pytest.mark.parametrize("seconds", [-1.0, 86_401.0, 1e9, math.nan, math.inf])
@pytest.mark.parametrize("name", CALLS)
def test_what_is_no_time_is_refused(name, seconds):
    with pytest.raises(ss.InputError, match=r"time_limit = .* from 0 to 86400"):
        CALLS[name](seconds)


GIVEN_UP = ["derive", "pure_slip_damping", "critical", "margins", "classify", "limit_cycles", "stick_slip_cycle"]


@pytest.mark.parametrize("name", [*GIVEN_UP, "basin_sweep", "tradeoff"])
def test_a_call_without_time_is_given_up(name):
    with pytest.raises((ss.OutOfTime, ss.NoClosedForm), match="time limit"):
        CALLS[name](0)


def test_nothing_is_claimed_without_time():
    study = CALLS["study"](0)
    assert study.headline.startswith("Whether there is stick-slip")
    assert study.verdict.startswith("motions not found") or "undecided" in study.verdict
    assert CALLS["regime"](0).undecided
    assert all(answer.threshold is None for answer in CALLS["compare"](0) if answer.method in ("orbit", "proof"))
    assert CALLS["simulate"](0).t[-1] < 1.0
    assert not CALLS["regime"](None).undecided
