"""Limits on the time of work that never asks for it.

Elapsed times are of the processor: what else the machine does must not decide.
"""

import subprocess
import sys
import threading
import time

import mpmath
import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym.core import interruption
from stickslip_sym.core.deadline import time_limit
from stickslip_sym.core.errors import OutOfTime
from stickslip_sym.formula.derivation import closed_form
from stickslip_sym.formula.integration import integrals


def spin(seconds=60.0):
    """Work that heeds no limit."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        sum(range(100))
    return "done"


def test_work_is_ended_and_nothing_is_raised_afterwards():
    start = time.process_time()
    with pytest.raises(OutOfTime):
        interruption.within(0.2, spin)
    assert time.process_time() - start < 2
    assert spin(0.3) == "done"


def test_work_within_its_time_keeps_its_result():
    for _ in range(200):
        assert interruption.within(5.0, lambda: 7) == 7
    assert interruption.within(None, lambda: 7) == 7
    with pytest.raises(ZeroDivisionError):
        interruption.within(5.0, lambda: 1 / 0)


def test_the_end_of_the_work_and_of_the_time_at_once():
    """Whatever comes first, it is one of two outcomes, and nothing comes later."""
    outcomes = set()
    for _ in range(25):
        try:
            outcomes.add(interruption.within(0.005, lambda: spin(0.005)))
        except OutOfTime:
            outcomes.add("out of time")
    assert outcomes <= {"done", "out of time"}
    assert spin(0.05) == "done"


def test_limits_nest_and_the_earliest_counts():
    def inner():
        with pytest.raises(OutOfTime):
            interruption.within(0.1, spin)
        return spin()

    start = time.process_time()
    with pytest.raises(OutOfTime):
        interruption.within(0.4, inner)
    with pytest.raises(OutOfTime), time_limit(0.1):
        interruption.within(30.0, spin)
    assert time.process_time() - start < 4


def test_what_swallows_every_exception_is_ended_too(monkeypatch):
    monkeypatch.setattr(interruption, "_AGAIN", 0.1)

    def stubborn():
        for _ in range(2):
            try:
                spin()
            except BaseException:
                continue
        return "never"

    with pytest.raises(OutOfTime):
        interruption.within(0.1, lambda: (stubborn(), spin()))


def test_each_thread_has_its_own_limit():
    found = {}

    def run(name, seconds):
        try:
            found[name] = interruption.within(seconds, lambda: spin(0.5))
        except OutOfTime:
            found[name] = "out of time"

    threads = [threading.Thread(target=run, args=pair) for pair in (("short", 0.1), ("long", 30.0))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == {"short": "out of time", "long": "done"}


def test_ctrl_c_goes_through():
    def press():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interruption.within(5.0, press)
    assert spin(0.05) == "done"


def test_nothing_half_done_remains():
    """A deduction of SymPy that was cut off, and mpmath's precision, are as they were before."""
    x = sp.Symbol("x", positive=True)
    expr = sp.exp(x) + x

    def half_way():
        assert expr.is_integer is None
        expr._assumptions["positive"] = None
        mpmath.mp.prec = 1234
        spin()

    before = mpmath.mp.prec
    with pytest.raises(OutOfTime):
        interruption.within(0.1, half_way)
    assert mpmath.mp.prec == before
    assert expr.is_positive


@pytest.mark.parametrize("stage", ["tidy", "verify", "_state", "integrate_terms", "_require_integrable"])
def test_derive_ends_in_time_whatever_it_is_at(monkeypatch, stage):
    monkeypatch.setattr(closed_form, stage, lambda *_: spin())
    start = time.process_time()
    with pytest.raises(ss.NoClosedForm, match=r"the time limit of 0\.5 s was reached while .*until then"):
        ss.derive(ss.laws.exponential, time_limit=0.5)
    assert time.process_time() - start < 2


PROFILED = """
import cProfile
from stickslip_sym.core.errors import OutOfTime
from stickslip_sym.core.interruption import within

profile = cProfile.Profile()
profile.enable()
assert within(100, lambda: sum(map(abs, range(100)))) == 4950
try:
    within(0.05, lambda: [abs(n) for n in range(10**9)])
except OutOfTime:
    print(sum(map(abs, range(100))))
"""


def test_a_limit_ends_under_a_profiler():
    """Whether it was reached or not, nothing is left that a traced call would wait for."""
    command = [sys.executable, "-c", PROFILED]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout == "4950\n"


def test_a_short_limit_names_what_was_under_way(monkeypatch):
    start = time.process_time()
    with monkeypatch.context() as patched:
        patched.setattr(integrals, "antiderivative", lambda *_: spin())
        with pytest.raises(ss.NoClosedForm, match=r"limit of 0.2 s was reached while .*no formula was found"):
            ss.derive(ss.FrictionLaw("mu_k + d*atan((v + v_0)/(w + v_1))"), time_limit=0.2)
    assert time.process_time() - start < 2
    # What was interrupted leaves nothing behind that would change a later result.
    assert ss.derive(ss.laws.polynomial).verdict.status is ss.Status.PROVED
