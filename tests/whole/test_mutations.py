"""A suite about the checks of the paper: a datum that is altered, or a package that is wrong, changes a verdict.

A mutation is a line: the claim, the datum, and what is printed instead of it; words and equations also get
others by one rule. No other check can see it, as
a check is given the data of its own claim only.
"""

import re
import sys
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import pytest
import sympy as sp

from derivations import paper
from paper_checks import check_figures, check_numbers, computed, proved
from paper_checks.claims import CLAIMS
from paper_checks.printed import PRINTED, acceleration, displacement, kinetic, relative
from paper_checks.test_claims import CHECKS
from stickslip_sym.core.symbols import N, V, a, b, c, k, m, mu, u
from stickslip_sym.criteria.enclosure import Enclosure
from support.sweeps import sample, sweep

OVER_SPEEDS = ("F6", "F7")
"""Claims that take a proof at each of a hundred belt speeds, which is done elsewhere."""
BY_DEFAULT = ("E1", "E3", "E7", "N1", "F5", "F8", "S3", "S9")
"""Some of each kind of claim; the others take a minute together."""

EQ = paper.equations()
mu_s, mu_m, alpha = (paper.exponential[name] for name in ("mu_s", "mu_m", "alpha"))
v_m, xdot = paper.polynomial["v_m"], paper.velocity
aV = alpha * V
COSH, SINH = sp.cosh(aV), sp.sinh(aV)
EQUILIBRIUM = PRINTED["S10"]["equilibrium"]
THOMSEN = PRINTED["F7"]["Thomsen & Fidlin"]


def moment(kernel, *, lower=0, upper=2 * V):
    return sp.Integral(mu(u) * kernel, (u, lower, upper))


def square(kernel, weight, *, upper=2 * V):
    return sp.Integral((mu(u) + kernel) ** 2 * weight, (u, 0, upper))


def law_17(bracket, *, volume=V**5 * alpha**4):
    return 5 * N * (mu_s - mu_m) * sp.exp(-aV) * bracket / volume


def law_18(bracket, *, volume=14 * v_m**3):
    return (mu_s - mu_m) * N * bracket / volume


BRACKET_17 = (6 * aV + aV**3) * COSH - (6 + 3 * aV**2) * SINH


def put(printed, place, value):
    """Return printed values with another one at a place."""
    return (*printed[:place], value, *printed[place + 1 :])


MUTATIONS = [
    ("E1", "force", c * xdot - k * displacement),
    ("E1", "force", k * displacement - c * xdot),
    ("E2", "left", m * acceleration - c * xdot + k * displacement),
    ("E2", "right", sp.sign(relative) * kinetic * N),
    ("E3", "(3)", mu_m - (mu_s - mu_m) * sp.exp(-alpha * u)),
    ("E3", "(3)", mu_m + (mu_s - mu_m) * sp.exp(alpha * u)),
    ("E5", "(6)", sp.S.One),
    ("E4", "(4)", EQ["(4)"].subs(v_m, 2 * v_m)),
    ("E9", "(8)", a * u + b),
    ("E9", "(9)", N * (a * (xdot + V) + b)),
    ("E10", "(10)", EQ["(10)"].subs(c, -c)),
    ("E13", "(12)", sp.Integral(EQ["(12)"].function / xdot, (xdot, -V, V))),
    ("E13", "(13)", square(a * u - b, (V - u) ** 2, upper=V)),
    ("E13", "(13)", square(a * u - b, (V + u) ** 2)),
    ("E15", "(15) a", 5 / (2 * V**5) * moment((V - u) ** 3, upper=V)),
    ("E15", "(15) b", moment((V - u) ** 2 * (8 * V + 5 * u)) / (2 * V**4)),
    ("E16", "(16)", 5 * N / (2 * V**5) * moment((u - V) ** 3)),
    ("E16", "(16)", 5 * N / (2 * V**5) * moment((V - u) ** 3, lower=V)),
    ("E17", "(17)", law_17((6 * aV - aV**3) * COSH - (6 + 3 * aV**2) * SINH)),
    ("E17", "(17)", law_17((6 * aV + aV**3) * COSH - (6 + 2 * aV**2) * SINH)),
    ("E18", "(18)", law_18(21 * v_m**2 + 26 * V**2)),
    ("N1", "dampings", put(PRINTED["N1"]["dampings"], 3, "2.754")),
    ("N1", "ratios", ("0", "0.05", "0.1", "0.1278", "0.175")),
    ("N2", "c", "2.573"),
    ("N3", "c", "3.037"),
    ("N4", "ratio", "26/21"),
    ("N4", "rounded", "0.8"),
    ("F3", "dampings", put(PRINTED["F3"]["dampings"], 3, "2.4")),
    ("F3", "motions", put(PRINTED["F3"]["motions"], 2, "pure slip")),
    ("F4", "dampings", put(PRINTED["F4"]["dampings"], 3, "3.03")),
    ("F4", "motions", put(PRINTED["F4"]["motions"], 3, "stick-slip")),
    ("F5", "coincide", {"2": True, "2.574": True, "3.5": True}),
    ("F6", "(17)", law_17((6 * aV + aV**3) * COSH - (6 + 2 * aV**2) * SINH)),
    ("F6", "equilibrium", EQUILIBRIUM["exponential"] * sp.exp(aV / 2)),
    ("F7", "(18)", law_18(21 * v_m**2 + 26 * V**2)),
    ("F7", "equilibrium", law_18(21 * v_m**2 - 26 * V**2)),
    ("F7", "Thomsen & Fidlin", law_18(21 * v_m**2 - 26 * V**2)),
    ("F8", "c", "1"),
    ("F8", "A", ("0.8", "stick-slip")),
    ("F8", "B", ("0.8", "stick-slip")),
    ("F9", "c", "0.5"),
    ("F9", "C", ("0.5", "damped slip")),
    ("F9", "D", ("0.6", "damped slip")),
    ("F10", "mu_m", ("0.4", "0.3", "0.2")),
    ("S1", "(16)", EQ["(16)"] * sp.sqrt(k * m) / N),
    ("S1", "(17)", EQ["(17)"] * k),
    ("S1", "(18)", EQ["(18)"].subs(V, V * m)),
    ("S2", "power of the frequency", sp.Rational(1, 2)),
    ("S2", "power of k", sp.Rational(1, 2)),
    ("S3", "lowest", -2 * V),
    ("S4", "(17)", law_17((6 * aV + aV**3) * SINH - (6 + 3 * aV**2) * COSH)),
    ("S4", "(18)", law_18(21 * v_m**2 + 26 * V**2)),
    ("S5", "(17)", EQ["(17)"] - N * mu_m * alpha),
    ("S5", "transition speed", sp.S.One),
    ("S5", "without damping", "no stick-slip"),
    ("S6", "(18)", law_18(21 * v_m**2 - 20 * V**2)),
    ("S6", "speed", "0.8"),
    ("S7", "width of pure slip", 0.1),
    ("S8", "c", "2.4"),
    ("S8", "change in a period", 0.05),
    ("S9", "(17)", law_17(BRACKET_17) * (mu_s - mu_m)),
    ("S9", "(18)", (mu_s + mu_m) * N * (21 * v_m**2 - 26 * V**2) / (14 * v_m**3)),
    ("S10", "equilibrium", {**EQUILIBRIUM, "exponential": 2 * EQUILIBRIUM["exponential"]}),
]  # fmt: skip


OPPOSITE = {
    "falls": "rises", "rises": "falls", "fall": "rise", "negative": "positive", "minimum": "maximum",
    "stick-slip": "slip", "slip": "stick-slip", "no stick-slip": "stick-slip", "harmonic": "far from harmonic",
    "constant": "decaying", "(17)": "equilibrium", "(18)": "Thomsen & Fidlin",
    "no closed form": "closed form",
}  # fmt: skip
"""What is said in a word, and instead of it."""


def test_a_check_sees_its_own_data_only():
    for path in Path(proved.__file__).parent.glob("check_*.py"):
        assert not {"PRINTED", "CLAIMS"} & set(path.read_text().replace(".", " ").split())


def test_claims_have_checks_and_data_have_mutations():
    assert CHECKS.keys() == CLAIMS.keys() == PRINTED.keys()
    data = {(claim, key) for claim, printed in PRINTED.items() for key in printed}
    assert {(claim, key) for claim in CLAIMS for key, _ in mutated(claim)} == data


def mutated(claim):
    """Return the mutations of a claim; a word becomes its opposite, an equation is negated and doubled."""
    found = [(key, altered) for mutant, key, altered in MUTATIONS if mutant == claim]
    for key, datum in PRINTED[claim].items():
        if isinstance(datum, str) and datum in OPPOSITE:
            found.append((key, OPPOSITE[datum]))
        elif claim.startswith("E") and isinstance(datum, sp.Expr) and datum != 0:
            found += [(key, factor * datum) for factor in (-1, 2)]
    return found


README = (Path(proved.__file__).parent / "README.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| ([A-Z]\d[^|]*) \|.*\| ([a-z, ]+) \|$", README, re.M)
KINDS = {claim: kinds for claims, kinds in ROWS for claim in claims.split(", ")}
"""The kinds of evidence in the table of claims, by claim."""


def by_collocation(point, guess, error, rtol):
    """Return what stands for a theorem: the paper's data are altered here, and not how thresholds are found."""
    del point, error
    return SimpleNamespace(enclosure=Enclosure.of(guess * (1 - rtol / 2), guess * (1 + rtol / 2)))


@sample(4)
@sweep("claim", CLAIMS, *BY_DEFAULT)
def test_a_mutation_changes_the_verdict(claim, monkeypatch):
    if claim in OVER_SPEEDS:
        monkeypatch.setattr(proved, "prove_threshold", by_collocation)
        monkeypatch.setattr(check_figures, "enclosed_over_speeds", proved.enclosed_over_speeds.__wrapped__)
    finding = CHECKS[claim](PRINTED[claim])
    assert finding.outcome is CLAIMS[claim].outcome
    assert finding.kinds == KINDS[claim]
    for key, altered in mutated(claim):
        found = CHECKS[claim](PRINTED[claim] | {key: altered})
        assert found.outcome is not CLAIMS[claim].outcome, (key, altered)


MODULES = {computed, proved, *(sys.modules[check.func.__module__] for check in CHECKS.values())}

SCANNED = 2.574
"""What the scan gives for the exponential law, in kg/s; it takes long, and is run elsewhere."""


def altered(found, changes):
    return replace(found, **{name: change(getattr(found, name)) for name, change in changes.items()})


def changed(**changes):
    """Return a function that alters attributes of another's result."""
    return lambda function: lambda *args, **kwargs: altered(function(*args, **kwargs), changes)


def other_oscillator(**changes):
    """Return a function that gives a simulation an oscillator with other numbers."""
    return lambda function: lambda law, osc, **kwargs: function(law, altered(osc, changes), **kwargs)


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


IN_A_SECOND = ("limit_cycles", "pure_slip_damping", "peak_velocity", "pure_slip_by_scan")
"""The mutants whose claims are checked so fast."""


@pytest.fixture
def _fresh(monkeypatch):
    """Let nothing be remembered from before, nor what is wrong be remembered afterwards; what is right is kept."""
    empty = {}
    for module in MODULES:
        for name, value in list(vars(module).items()):
            if hasattr(value, "cache_clear"):
                fresh = empty.setdefault(value, cache(value.__wrapped__))
                monkeypatch.setattr(module, name, fresh)


@pytest.mark.usefixtures("_fresh")
def test_stand_in_for_the_scan_changes_nothing(monkeypatch):
    monkeypatch.setattr(check_numbers, "pure_slip_by_scan", lambda *_: SCANNED)
    assert CHECKS["N2"](PRINTED["N2"]).outcome is CLAIMS["N2"].outcome


@sample(2)
@pytest.mark.usefixtures("_fresh")
@sweep(("name", "wrap", "claims"), MUTANTS, *(one for one in MUTANTS if one[0] in IN_A_SECOND))
def test_a_wrong_package_changes_verdicts(monkeypatch, name, wrap, claims):
    monkeypatch.setattr(check_numbers, "pure_slip_by_scan", lambda *_: SCANNED)
    for module in MODULES:
        if name in vars(module):
            monkeypatch.setattr(module, name, wrap(vars(module)[name]))
    assert [id for id in claims if CHECKS[id](PRINTED[id]).outcome is CLAIMS[id].outcome] == []
