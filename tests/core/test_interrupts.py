"""Exceptions and Ctrl-C where a library in C calls Python."""

import signal

import pytest
from flint import acb, arb, ctx

from stickslip_sym.core.balls import integrated
from stickslip_sym.core.interrupts import held_back


@pytest.fixture
def kept_handler():
    """Python's handler, which a run in the background has not: a shell lets it ignore Ctrl-C."""
    outside = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield signal.default_int_handler
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    signal.signal(signal.SIGINT, outside)


@pytest.mark.parametrize("failure", [ValueError, KeyboardInterrupt, ZeroDivisionError, SystemExit])
@pytest.mark.parametrize("precision", [53, 600])
def test_an_exception_in_an_integrand_comes_out_as_itself_and_at_once(failure, precision, kept_handler):
    calls = []

    def integrand(z, analytic):
        calls.append(z)
        if len(calls) == 30:
            raise failure("here")
        return z.exp() / (1 + 1000 * z * z)

    before, ctx.prec = ctx.prec, precision
    try:
        with pytest.raises(failure, match="here"):
            integrated(integrand, acb(0), acb(3))
    finally:
        ctx.prec = before
    assert len(calls) == 30


def test_ctrl_c_in_an_integrand_is_a_keyboard_interrupt(kept_handler):
    calls = []

    def integrand(z, analytic):
        calls.append(z)
        if len(calls) == 30:
            signal.raise_signal(signal.SIGINT)
        return z.exp() / (1 + 1000 * z * z)

    with pytest.raises(KeyboardInterrupt):
        integrated(integrand, acb(0), acb(3))
    assert len(calls) == 30


def test_a_handler_that_goes_on_gets_the_whole_integral(monkeypatch):
    """What was left out while the signal waited is computed once it was handled."""
    heard, calls = [], []
    before = signal.signal(signal.SIGINT, lambda *_: heard.append(1))

    def integrand(z, analytic):
        calls.append(z)
        if len(calls) == 3:
            signal.raise_signal(signal.SIGINT)
        return z.exp()

    try:
        assert integrated(integrand, acb(0), acb(1)).real.overlaps(arb(1).exp() - 1)
    finally:
        signal.signal(signal.SIGINT, before)
    assert heard == [1]


def test_ctrl_c_waits_for_the_end_of_a_block(kept_handler):
    reached = []
    with pytest.raises(KeyboardInterrupt), held_back() as interrupt:  # noqa: PT012
        signal.raise_signal(signal.SIGINT)
        assert interrupt.came
        reached.append("end")
    assert reached == ["end"]
