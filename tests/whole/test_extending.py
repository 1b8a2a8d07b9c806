"""One law, criterion, method and language more, each added from outside and used by the public interface."""

import ctypes
import json
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym.formula.code.languages import LANGUAGES
from stickslip_sym.motion.thresholds import methods
from support.commands import inside

LAW = ss.laws.exponential.typical()
POINT = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}
s = ss.symbols.s


def command(*arguments):
    done = inside(*arguments)
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout


def test_a_law(monkeypatch):
    fall = ss.Parameter("b", "fall", "s/m", typical="0.4")
    law = ss.FrictionLaw("mu_a - b*v + d*v^3", name="mine", parameters=[fall])
    monkeypatch.setitem(ss.laws.catalogue, "mine", law)
    assert ss.laws.mine is law
    value = ss.derive(ss.laws.mine)(V=0.5, N=2, mu_a=0.5, b=0.4, d=0.1)
    assert value == pytest.approx(ss.slope_average(law)(V=0.5, N=2, mu_a=0.5, b=0.4, d=0.1), rel=1e-13)
    said = command("damping", "mine", "-p", "mu_a=0.5", "-p", "d=0.1", "-V", "0.5", "-N", "2", "--all")
    assert "harmonic" in said


def test_a_criterion_of_the_catalogue(monkeypatch):
    """It is found by its name, and is a method."""
    criterion = ss.Criterion("uniform", sp.Rational(1, 2), "of no one")
    monkeypatch.setitem(ss.criteria.catalogue, "uniform", criterion)
    right = 9.81 * float(LAW.mu(0.0) - LAW.mu(1.0))  # N (mu(0) - mu(2V))/(2V)
    assert ss.derive(LAW, "uniform")(V=0.5, N=9.81) == pytest.approx(right, rel=1e-13)
    assert ss.pure_slip_damping(LAW, **POINT, method="uniform").value == pytest.approx(right, rel=1e-13)
    said = command("damping", "exponential", "-m1", "-k100", "--all", "--json")
    found = {one["method"]: one for one in json.loads(said)["rows"]}
    assert list(found)[3] == "uniform"
    assert float(found["uniform"]["value"]) == pytest.approx(right, rel=1e-13)
    assert "least_squares" in found


def test_what_is_no_criterion_is_refused():
    for refused, message in (
        (lambda: ss.critical(LAW, "V", c=1, N=9.81, method="harmonics"), "there is no method 'harmonics'"),
        (lambda: ss.Criterion("steep", s**1000 * sp.Rational(1001, 2)), "is of degree 1000"),
        (lambda: ss.Criterion("", sp.Rational(1, 2)), "a criterion has a name"),
    ):
        with pytest.raises(ss.InputError, match=message):
            refused()


def test_a_method(monkeypatch):
    """One entry makes it known to every call: it says that its error is small, and how it changes."""
    monkeypatch.setattr(methods, "_table", dict(methods._table))
    orbit = methods.methods()["orbit"]

    def compute(points, rtol):
        found = orbit.compute(points, 1e-12)
        return methods.Computed(found.value, np.full(len(points), 1e-11))

    method = methods.Method("bracket", compute, sensitivity=orbit.sensitivity, smooth=True)
    methods.add_method(method)
    found = ss.pure_slip_damping(LAW, **POINT, method="bracket")
    assert (found.method, found.relative_error) == ("bracket", 1e-11)
    assert found.value == pytest.approx(2.57307887897936159, rel=1e-11)
    (speed,) = ss.critical(LAW, "V", c=found.value, N=9.81, m=1, k=100, method="bracket")
    assert speed.value == pytest.approx(0.5, rel=1e-9)
    assert "bracket" in command("damping", "exponential", "-m1", "-k100", "--method", "bracket")
    with pytest.raises(ss.InputError, match='method="bracket" needs the mass m'):
        ss.pure_slip_damping(LAW, V=0.5, N=9.81, method="bracket")
    with pytest.raises(ss.InputError, match="a method 'bracket' already"):
        methods.add_method(method)
    # Where no other method that comes as close is left, "auto" ends on it.
    for name in ("orbit", "simulation"):
        del methods._table[name]
    assert ss.pure_slip_damping(LAW, **POINT, rtol=1e-9).method == "bracket"


def test_a_language(monkeypatch, tmp_path):
    """C++ is C but for what stands first, and for how functions are linked."""
    c = LANGUAGES["c"]
    page = c.file.read_text().replace("@@ head\n", "@@ head\n// C++\n")
    page = page.replace("\ndouble $name", '\nextern "C" double $name')
    (tmp_path / "cpp.txt").write_text(page)
    monkeypatch.setitem(LANGUAGES, "cpp", replace(c, description="C++.", file=tmp_path / "cpp.txt"))
    average = ss.slope_average(LAW)
    text = ss.export_code(average, "cpp")
    assert text.startswith("// C++")
    assert 'extern "C" double damping(' in text
    with pytest.raises(ss.InputError, match=r"there is no language 'pyhton' .did you mean 'python'"):
        ss.export_code(average, "pyhton")
    if compiler := shutil.which("c++"):
        (tmp_path / "a.cpp").write_text(text)
        subprocess.run([compiler, "-shared", "-fPIC", "-o", "a.so", "a.cpp", "-lm"], cwd=tmp_path, check=True)
        function = ctypes.CDLL(str(tmp_path / "a.so")).damping
        function.restype, function.argtypes = ctypes.c_double, [ctypes.c_double] * 5
        values = {"V": 0.5, "N": 9.81} | {name: float(value) for name, value in LAW.values.items()}
        got = function(*(values[name] for name in average.arguments))
        assert got == pytest.approx(average(V=0.5, N=9.81), rel=1e-14)
