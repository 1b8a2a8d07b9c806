"""SymPy's integrator in a process of its own: what became of it is said."""

import sys
from types import SimpleNamespace

import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym.formula.finding import search

HOPELESS = "mu_0 + d*cos(exp(v))"


@pytest.mark.parametrize(
    ("outcome", "message"),
    [
        (SimpleNamespace(returncode=1, stderr=b"Traceback\nImportError: no resource", stdout=b""),
         "SymPy's integrator failed without a look at it: its process ended with 1: ImportError: no resource"),
        (SimpleNamespace(returncode=-9, stderr=b"", stdout=b""), "its process ended with -9"),
    ],
)  # fmt: skip
def test_a_process_that_fails_is_no_missing_closed_form(fresh_averages, monkeypatch, outcome, message):
    monkeypatch.setattr(search.subprocess, "run", lambda *_, **__: outcome)
    with pytest.raises(ss.NoClosedForm, match=message) as caught:
        ss.derive(ss.FrictionLaw(HOPELESS))
    assert "found nothing" not in str(caught.value)


def test_what_sympy_raises_is_said():
    class Broken:
        def doit(self):
            raise NotImplementedError("not today")

    assert search.carried_out(Broken()) == "gave up with NotImplementedError: not today"


def test_a_platform_without_limits_of_memory_integrates_all_the_same(monkeypatch):
    monkeypatch.setitem(sys.modules, "resource", None)
    search.confine(0.0)  # would end this process within a second where there are limits


def test_the_time_that_is_said_is_the_time_that_was_spent(fresh_averages):
    with pytest.raises(ss.NoClosedForm, match="was not asked"):
        ss.derive(ss.FrictionLaw(HOPELESS), search=False)
    x = sp.Symbol("x", positive=True)
    assert search.antiderivative(sp.cos(x), sp.Integer(1), x, 30.0, lambda _: None) == sp.sin(x)
