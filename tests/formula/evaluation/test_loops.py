"""Loops in C give what NumPy gives, or are refused."""

import pickle
import shutil

import accuracy
import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym.formula.code import loops

LAWS = ["exponential", "exponential_viscous", "two_exponentials"]
SAME = 3e-15  # relative to the largest term: each errs by four units at most

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")


@pytest.fixture
def afresh():
    """Nothing compiled before, nothing kept after."""
    loops.loop_of.cache_clear()
    yield
    loops.loop_of.cache_clear()


@pytest.mark.parametrize("regime", accuracy.REGIMES)
def test_a_compiled_closed_form_is_as_accurate(regime):
    form = accuracy.form_of("exponential", "least_squares")
    columns = accuracy.samples(form.law, regime, 40, seed=3)
    fast = ss.compiled(form)
    assert accuracy.units(form, columns, fast(**columns)).max() <= accuracy.MOST_UNITS_OF_THE_PAPER


@pytest.mark.parametrize("name", LAWS)
def test_speeds_in_any_order_with_parameters_of_their_own_give_what_numpy_gives(name):
    average = ss.slope_average(ss.laws.catalogue[name])
    fast, rng = ss.compiled(average), np.random.default_rng(LAWS.index(name))
    V = 10 ** np.concatenate(
        [rng.uniform(-9, 6, 20_000), rng.uniform(-1, 1.5, 20_000), rng.uniform(-290, 290, 400)]
    )
    typical = {key: float(parameter.typical) for key, parameter in average.law.parameters.items()}
    drawn = {key: value * rng.uniform(0.5, 2, V.size) for key, value in typical.items()}
    for values in (typical, drawn, typical | {"mu_s": drawn["mu_s"]} if "mu_s" in typical else drawn):
        expected, got = (function(V=V, N=9.81, **values) for function in (average, fast))
        size = np.abs(expected) + (9.81 * np.abs(values["mu_v"]) if "mu_v" in values else 0.0)
        assert (np.abs(got - expected) <= SAME * size).all()
    # V = 0 and what is invalid or missing goes the way of every call.
    odd = {"V": [0.0, -1.0, np.nan, 1.0], "N": 1.0} | typical
    expected = average(on_invalid="nan", **odd)
    assert fast(on_invalid="nan", **odd) == pytest.approx(expected, rel=SAME, abs=0, nan_ok=True)


def test_it_can_be_sent_to_another_process():
    fast = ss.compiled(ss.slope_average(ss.laws.exponential.typical()))
    V = np.linspace(0.1, 3, 5)
    assert (pickle.loads(pickle.dumps(fast))(V=V, N=2.0) == fast(V=V, N=2.0)).all()


@pytest.mark.parametrize("name", ["tanh", "gaussian", "polynomial", "linear", "coulomb"])
def test_a_law_without_such_branches_is_refused(name):
    with pytest.raises(ss.InputError, match="nothing to compile; call the"):
        ss.compiled(ss.slope_average(ss.laws.catalogue[name]))


def test_without_a_compiler_it_is_said_so(monkeypatch, tmp_path, afresh):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ss.InputError, match=r"no C compiler was found \(cc, gcc, clang\)"):
        ss.compiled(ss.slope_average(ss.laws.exponential))


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        ("s/t = (x - k/t = (x + 1e-14 - k/", "not accurate"),
        ("s/r < 2[0-9.]*/r < 0.6/", "not accurate"),
        ("s/double r/nonsense r/", "failed: (?s:.*)nonsense"),
    ],
)
def test_a_compiler_that_goes_wrong_is_noticed(monkeypatch, tmp_path, afresh, edit, message):
    """The negative control: a compiler that changes the text first."""
    script = tmp_path / "cc"
    script.write_text(
        f'#!/bin/sh\nfor last in "$@"; do case $last in *.c) sed -i "{edit}" "$last";; esac; done\n'
        f'exec {shutil.which("cc")} "$@"\n'
    )
    script.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    with pytest.raises(ss.InputError, match=message):
        ss.compiled(ss.slope_average(ss.laws.exponential))


@pytest.mark.parametrize("form", [None, 1, "x", ss.laws.exponential])
def test_what_has_no_loops_is_refused(form):
    with pytest.raises(ss.InputError, match="a closed form, or a slope average, has loops to compile, got"):
        ss.compiled(form)
