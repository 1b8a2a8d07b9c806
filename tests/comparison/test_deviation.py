"""What is said about a difference from the threshold is computed; measured points get the digits they deserve."""

import math
import random
from types import SimpleNamespace

import pytest

import stickslip_sym as ss
from stickslip_sym.comparison import crosscheck, deviation
from stickslip_sym.formula.code.writer import code

SCENE = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}


def test_a_static_coefficient_is_named_as_the_reason():
    law = ss.FrictionLaw("0.2 + 0.3*exp(-3*v)", static="0.9")
    value = ss.slope_average(law)(V=0.5, N=9.81)
    found = deviation.reasons(law, ss.criteria.least_squares, SCENE, value, 2 * value)
    assert any(reason.startswith("the static coefficient") for reason in found)
    plain = deviation.reasons(ss.FrictionLaw(law.expr), ss.criteria.least_squares, SCENE, value, 1.01 * value)
    assert plain == []


def test_another_weight_is_named_as_the_reason():
    law = ss.laws.exponential.typical()
    scene = SCENE | {"V": 2.0}
    value = ss.slope_average(law, "equilibrium")(V=2.0, N=9.81)
    found = deviation.reasons(law, ss.criteria.equilibrium, scene, value, 0.9)
    weak = ss.slope_average(law, "harmonic")(V=2.0, N=9.81)
    assert found
    assert f"the harmonic average, {weak:.4g} kg/s" in found[0]


def test_scattered_points_do_not_get_fifty_digits(monkeypatch):
    rng = random.Random(6)
    v = [0, 0.1, 0.3, 0.6, 1.2]
    mu = [round((0.2 + 0.3 * math.exp(-3 * speed)) * (1 + rng.uniform(-0.06, 0.06)), 6) for speed in v]
    law = ss.FrictionLaw.from_samples(v, mu)
    # The threshold has its own tests, and is slow.
    monkeypatch.setattr(crosscheck, "pure_slip_damping", lambda *_, **__: SimpleNamespace(value=2.2))
    checks = crosscheck.crosscheck(law, ss.criteria.least_squares, {k: str(x) for k, x in SCENE.items()}, None)
    quadrature = next(check for check in checks if check.method.startswith("quadrature"))
    assert len(quadrature.value) < 7
    assert max(map(len, crosscheck.report(checks).splitlines())) <= 110


def test_without_a_closed_form_there_is_code():
    average = ss.slope_average(ss.laws.catalogue["andersson"].typical())
    namespace = {}
    exec(code({"damping": average.function}, "andersson", "python"), namespace)
    values = [float(value) for value in average.law.values.values()]
    assert namespace["damping"](0.5, 9.81, *values) == pytest.approx(average(V=0.5, N=9.81), rel=1e-12)


def test_zero_has_no_sign():
    assert str(ss.slope_average(ss.FrictionLaw("0.3 + 0*v"))(V=0.5, N=9.81)) == "0.0"


def test_eta_of_a_number_is_written_by_zeta():
    form = ss.derive(ss.FrictionLaw("a*tanh(v/w)"), search=False)
    assert "eta(" not in str(form.expr).replace("zeta(", "")
