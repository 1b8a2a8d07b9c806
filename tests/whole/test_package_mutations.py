"""The checks of the paper notice a package that is wrong, not only a paper that is."""

import sys
from dataclasses import replace
from fractions import Fraction
from functools import cache

import pytest
from sweeps import sweep

from paper_checks import check_numbers, computed, proved
from paper_checks.claims import CLAIMS
from paper_checks.printed import PRINTED
from paper_checks.test_claims import CHECKS

MODULES = {computed, proved, *(sys.modules[check.func.__module__] for check in CHECKS.values())}

SCANNED = 2.574
"""What the scan gives for the exponential law, in kg/s; it takes long, and is run elsewhere."""


def changed(**changes):
    """Return a function that alters attributes of another's result."""

    def wrap(function):
        def wrong(*args, **kwargs):
            found = function(*args, **kwargs)
            return replace(found, **{name: change(getattr(found, name)) for name, change in changes.items()})

        return wrong

    return wrap


def other_oscillator(**changes):
    """Return a function that gives a simulation an oscillator with other numbers."""

    def wrap(function):
        def wrong(law, osc, **kwargs):
            return function(
                law, replace(osc, **{n: change(getattr(osc, n)) for n, change in changes.items()}), **kwargs
            )

        return wrong

    return wrap


def slightly(value):
    return 1.01 * value


def higher(value):
    return value * Fraction(101, 100)


MUTANTS = [
    ("_grazing", lambda f: lambda *args: slightly(f(*args)), ("F6", "F7", "S2", "S3", "S7", "S10")),
    ("orbits", changed(exponent=lambda exponent: -exponent), ("S8",)),
    ("simulate", other_oscillator(N=slightly), ("E1", "E2", "F3", "S8")),
    ("simulate", other_oscillator(c=slightly), ("E1", "E2", "F3", "F5", "S3", "S8")),
    ("simulate", other_oscillator(m=slightly), ("E2",)),
    ("stick_slip_cycle", lambda _: lambda *_: None, ("S7",)),
    ("stick_slip_cycle", lambda _: lambda *_: True, ("S6", "S7")),
    ("limit_cycles", lambda _: lambda *_: (), ("F4",)),
    ("classify", lambda f: lambda law, osc: f(law, replace(osc, c=0.98 * osc.c)), ("F3", "F4")),
    ("needed_damping", lambda f: lambda law, osc: f(law, replace(osc, N=slightly(osc.N))), ("S7",)),
    ("slope_average", lambda f: lambda *args: lambda **at: slightly(f(*args)(**at)), ("S5",)),
    ("pure_slip_damping", changed(value=slightly), ("N2",)),
    ("prove_threshold", changed(low=higher, high=higher), ("F6", "F7", "S2", "S5", "S7", "S8")),
    ("transit", changed(returns=lambda returns: not returns), ("S6",)),
    ("peak_velocity", lambda f: lambda *args: f(*args) + 1e-4, ("N2",)),
    ("pure_slip_by_scan", lambda _: lambda *_: SCANNED + 0.001, ("N2",)),
]


BY_DEFAULT = ("limit_cycles", "pure_slip_damping", "peak_velocity", "pure_slip_by_scan")
"""The mutants whose claims are checked in a second."""


@pytest.fixture
def _fresh(monkeypatch):
    """Let nothing be remembered from before, nor what is wrong be remembered afterwards; what is right is kept."""
    places = [
        (module, *item) for module in MODULES for item in vars(module).items() if hasattr(item[1], "cache_clear")
    ]
    empty = {value: cache(value.__wrapped__) for _, _, value in places}
    for module, name, value in places:
        monkeypatch.setattr(module, name, empty[value])


@pytest.mark.usefixtures("_fresh")
def test_the_stand_in_for_the_scan_changes_no_verdict(monkeypatch):
    monkeypatch.setattr(check_numbers, "pure_slip_by_scan", lambda *_: SCANNED)
    assert CHECKS["N2"](PRINTED["N2"]).outcome is CLAIMS["N2"].outcome


@pytest.mark.usefixtures("_fresh")
@sweep(("name", "wrap", "claims"), MUTANTS, *(one for one in MUTANTS if one[0] in BY_DEFAULT))
def test_a_wrong_package_changes_verdicts(monkeypatch, name, wrap, claims):
    monkeypatch.setattr(check_numbers, "pure_slip_by_scan", lambda *_: SCANNED)
    for module in MODULES:
        if name in vars(module):
            monkeypatch.setattr(module, name, wrap(vars(module)[name]))
    assert [id for id in claims if CHECKS[id](PRINTED[id]).outcome is CLAIMS[id].outcome] == []
