"""What surrounds a call, and what happened before, decides neither its result nor what it leaves behind.

A table of calls, one of each kind, under each state. The default run takes a sample.
"""

import asyncio
import contextlib
import decimal
import gc
import itertools
import locale
import multiprocessing
import os
import pickle
import random
import signal
import sys
import threading
import time
import warnings
from concurrent.futures import ThreadPoolExecutor

import flint
import mpmath
import numpy as np
import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym.core import deadline, progress
from stickslip_sym.motion import slip
from stickslip_sym.motion.orbits import needed
from support.platforms import WINDOWS

POINT = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}
OSC = ss.Oscillator(**POINT, c=2.3)
STRIBECK = "0.2 + 0.3*exp(-(v/0.3)^1.5) + 0.02*v"
SMOOTH = "0.3 + 0.2/(1 + v/0.3) + 0.05*tanh(v/0.7)"
SPEEDS = np.linspace(0.05, 1.5, 40)


def law():
    return ss.FrictionLaw(SMOOTH)


def raw(number):
    """Return a number of mpmath to all its bits: its text depends on the precision of the moment."""
    return number._mpf_


def closed_form():
    form = ss.derive(law(), "least_squares")
    return (
        str(form.expr),
        str(form.verdict),
        raw(form.evaluate(40, V="0.3", N="9.81")),
        form.latex(),
        form.code("c"),
    )


def measured_curve():
    curve = ss.FrictionLaw.from_samples([0.0, 0.1, 0.3, 0.7, 1.5], [0.5, 0.41, 0.34, 0.3, 0.31])
    return str(curve.curve.cubics), raw(ss.quadrature.damping(curve, V="0.4", N=10, digits=25))


def fits():
    mu = 0.25 + 0.2 * np.exp(-SPEEDS / 0.4) + 0.004 * np.sin(40 * SPEEDS)
    return [
        (fit.law.name, sorted(map(str, fit.law.values.items())))
        for fit in ss.fit(SPEEDS, mu, laws=["exponential", "stribeck"])  # their trials underflow
    ]


def threshold(method):
    found = ss.pure_slip_damping(law(), **POINT, method=method)
    return found.value, found.relative_error


CALLS = {
    "closed form": closed_form,
    "slope average": lambda: ss.slope_average(STRIBECK)(V=SPEEDS, N=9.81).tobytes(),
    "quadrature": lambda: raw(ss.quadrature.damping(STRIBECK, "harmonic", V="0.5", N=10, digits=20)),
    "enclosure": lambda: (ss.enclose(STRIBECK, V="0.5", N=10, digits=20).low,),
    "measured curve": measured_curve,
    "orbit": lambda: threshold("orbit"),
    "simulated threshold": lambda: threshold("simulation"),
    "automatic threshold": lambda: threshold("auto"),
    "limit cycles": lambda: [(cycle.amplitude, cycle.period) for cycle in ss.limit_cycles(law(), OSC)],
    "motion": lambda: ss.simulate(law(), OSC, x0=0.01, v0=0.2, t_end=3).x[-1],
    "regime": lambda: str(ss.regime(law(), OSC)),
    "fit": fits,
    "critical speeds": lambda: [found.value for found in ss.critical(law(), "V", **POINT | {"c": 2.3, "V": None})],
    "certificate": lambda: ss.derive("mu_s - a*v^3").certificate(),
}  # fmt: skip
SAMPLE = ("slope average", "quadrature", "measured curve", "orbit")
"""Calls of the default run: those that many digits, caches or compiled code lie behind."""


FORGOTTEN = "stickslip_sym.form", "stickslip_sym.motion.orbits", "stickslip_sym.motion.thresholds"


def forget():
    """Forget the averages, orbits and thresholds that the package computed before."""
    for name, module in list(sys.modules.items()):
        for value in list(vars(module).values()) if name.startswith("stickslip_sym") else ():
            if hasattr(value, "cache_clear") and getattr(value, "__module__", "").startswith(FORGOTTEN):
                value.cache_clear()


def surroundings():
    """Return what a call must leave as it is."""
    return {
        "mpmath": mpmath.mp.prec,
        "flint": (flint.ctx.prec, flint.ctx.cap),
        "numpy": (np.geterr(), pickle.dumps(np.random.get_state())),  # noqa: NPY002
        "random": random.getstate(),
        "sympy": (sp.core.parameters.global_parameters.evaluate, sys.getrecursionlimit()),
        "decimal": decimal.getcontext().prec,
        "locale": locale.setlocale(locale.LC_ALL),
        "warnings": list(map(str, warnings.filters)),
        "signal": signal.getsignal(signal.SIGINT),
        "steps": (progress._path.get(), progress._listener.get()),
        "time limit": deadline._end.get(),
        "directory": os.getcwd(),
    }  # fmt: skip


@pytest.fixture
def expected():
    """Return the result of a call, as this process gives it where nothing is unusual."""
    return lambda name: CALLS[name]()


# -- states that surround a call -------------------------------------------------------------------


@contextlib.contextmanager
def flint_precision(bits):
    before, flint.ctx.prec = flint.ctx.prec, bits
    try:
        yield
    finally:
        flint.ctx.prec = before


@contextlib.contextmanager
def strict_warnings():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


@contextlib.contextmanager
def other_locale():
    before = locale.setlocale(locale.LC_ALL)
    for name in ("de_DE.UTF-8", "fr_FR.UTF-8", "C"):
        with contextlib.suppress(locale.Error):
            locale.setlocale(locale.LC_ALL, name)
            break
    try:
        yield
    finally:
        locale.setlocale(locale.LC_ALL, before)


@contextlib.contextmanager
def decimal_precision(digits):
    with decimal.localcontext() as context:
        context.prec = digits
        yield


STATES = {
    "mpmath 4": lambda: mpmath.workdps(4),
    "mpmath 50": lambda: mpmath.workdps(50),
    "flint 20": lambda: flint_precision(20),
    "flint 500": lambda: flint_precision(500),
    "numpy raises": lambda: np.errstate(all="raise"),
    "warnings are errors": strict_warnings,
    "locale": other_locale,
    "decimal 5": lambda: decimal_precision(5),
}

PAIRS = [(state, name) for state in STATES for name in CALLS]
OF_DEFAULT = {
    ("mpmath 4", "closed form"),
    ("numpy raises", "fit"),
    *zip(STATES, itertools.cycle(SAMPLE), strict=False),
}


def those(names):
    """Return all calls as parameters, of which the default run takes some."""
    return [pytest.param(name, marks=[] if name in names else pytest.mark.thorough) for name in CALLS]


@pytest.mark.parametrize(
    ("state", "name"),
    [pytest.param(*pair, marks=[] if pair in OF_DEFAULT else pytest.mark.thorough) for pair in PAIRS],
)
def test_what_surrounds_a_call_means_nothing(state, name, expected):
    right = expected(name)
    forget()
    with STATES[state]():
        before = surroundings()
        assert CALLS[name]() == right
        assert surroundings() == before


@pytest.mark.parametrize("name", ["orbit", "simulated threshold", "limit cycles"])
def test_whether_machine_code_is_loaded_means_nothing(name, monkeypatch):
    """To the last bit, though machine code that a map has loaded serves single thresholds too."""
    pytest.importorskip("numba")
    given = []
    for is_loaded in (False, True):
        for module in (needed, slip):
            monkeypatch.setattr(module, "is_ready", lambda _, is_loaded=is_loaded: is_loaded)
        forget()
        given.append(CALLS[name]())
    assert given[0] == given[1]


@pytest.mark.parametrize("name", CALLS)
def test_where_sympy_does_not_evaluate_a_call_says_so(name):
    with sp.evaluate(False), pytest.raises(ss.InputError, match=r"within sympy\.evaluate"):
        CALLS[name]()


def test_many_threads_at_once(request, expected):
    """Each thread has the calls in another order; nothing of theirs shows in the main thread."""
    thorough = request.config.getoption("--thorough")
    names = list(CALLS) if thorough else list(SAMPLE[::2])
    count = 8 if thorough else 4
    right = {name: expected(name) for name in names}
    forget()
    before = surroundings()

    def work(turn):
        order = names[turn % len(names) :] + names[: turn % len(names)]
        return {name: CALLS[name]() for name in order}

    with ThreadPoolExecutor(count) as threads:
        for results in threads.map(work, range(count)):
            assert results == right
    assert surroundings() == before


@pytest.mark.parametrize("name", those(["slope average", "orbit"]))
def test_inside_asyncio(name, expected):
    right = expected(name)
    before = surroundings()

    async def both():
        return CALLS[name](), await asyncio.to_thread(CALLS[name])

    assert asyncio.run(both()) == (right, right)
    assert surroundings() == before


def answer(connection, name):
    connection.send_bytes(pickle.dumps(CALLS[name]()))


@pytest.mark.skipif(WINDOWS, reason="Windows has no fork")
@pytest.mark.parametrize("name", those(["slope average"]))
@pytest.mark.parametrize("method", ["fork", pytest.param("spawn", marks=pytest.mark.thorough)])
def test_in_a_child(method, name, expected):
    right = pickle.dumps(expected(name))
    forget()
    context = multiprocessing.get_context(method)
    receiving, sending = context.Pipe(duplex=False)
    child = context.Process(target=answer, args=(sending, name))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of fork beside threads
        child.start()
    sending.close()
    assert pickle.loads(receiving.recv_bytes()) == pickle.loads(right)
    child.join()
    assert child.exitcode == 0


# -- what happened before ---------------------------------------------------------------------------


@contextlib.contextmanager
def interrupted(seconds):
    """Press Ctrl-C after some seconds of a block."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(seconds, os.kill, [os.getpid(), signal.SIGINT])
    try:
        timer.start()
        yield
    finally:
        with contextlib.suppress(KeyboardInterrupt):
            timer.cancel()
            timer.join()
            time.sleep(0.001)
        signal.signal(signal.SIGINT, before)


@pytest.mark.skipif(WINDOWS, reason="Windows cannot send Ctrl-C to one process")
@pytest.mark.parametrize("name", those(["quadrature"]))
def test_after_an_interrupt_at_any_moment(name, expected, request):
    """An interrupt is a KeyboardInterrupt, whatever it comes into, and the next call knows nothing of it."""
    right, rng = expected(name), random.Random(5)
    forget()
    begin = time.perf_counter()
    CALLS[name]()
    whole = time.perf_counter() - begin
    before, kept = surroundings(), []
    for _ in range(100 if request.config.getoption("--thorough") else 2):
        forget()
        try:
            with interrupted(rng.uniform(0, whole)):
                CALLS[name]()
        except KeyboardInterrupt as error:
            kept.append(error)  # as a notebook does
    assert surroundings() == before
    forget()
    assert CALLS[name]() == right
    kept.clear()
    gc.collect()
    assert surroundings() == before


@pytest.mark.parametrize("name", those(["slope average"]))
def test_after_a_time_limit_at_any_moment(name, expected, request):
    right, rng = expected(name), random.Random(6)
    forget()
    begin = time.perf_counter()
    CALLS[name]()
    whole = time.perf_counter() - begin
    before, kept = surroundings(), []
    for _ in range(100 if request.config.getoption("--thorough") else 2):
        forget()
        try:
            with deadline.time_limit(rng.uniform(0, whole)):
                CALLS[name]()
        except (ss.OutOfTime, ss.NoClosedForm) as error:
            kept.append(error)
    assert surroundings() == before
    forget()
    assert CALLS[name]() == right
    kept.clear()
    gc.collect()
    assert surroundings() == before
