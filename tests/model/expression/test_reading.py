"""What people type, and different spellings of one function: values against Python's own functions."""

import math

import numpy as np
import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym.core.functions import fold

VALUES = {"a": 0.7, "b": 0.8, "d": 0.35, "w": 1.3, "mu_s": 0.4, "mu_m": 0.15, "p": 0.6, "v_b": 0.9, "alpha": 1.7}
SPEEDS = np.array([1e-6, 0.0137, 0.2, 0.31, 0.55, 0.93, 1.21, 1.7, 2.9, 40.0])
a, b, d, w, mu_s, mu_m, p, v_b, alpha = VALUES.values()

TYPED = [
    ("μ_s·exp(−α v²)", lambda v: mu_s * math.exp(-alpha * v * v)),
    ("\\mu_s - 2a v", lambda v: mu_s - 2 * a * v),
    ("2mu_s - (a)exp(-v)(b + v)", lambda v: 2 * mu_s - a * math.exp(-v) * (b + v)),
    ("mu(v) = mu_s - a*v", lambda v: mu_s - a * v),
    ("mu = [a - b*{1 + v}]", lambda v: a - b * (1 + v)),
    ("a*EXP(-v) + Tanh(v)", lambda v: a * math.exp(-v) + math.tanh(v)),
    ("a*np.exp(-v) + math.log(1 + v)", lambda v: a * math.exp(-v) + math.log(1 + v)),
    ("1e-3v + 2.5e0 alpha - 3 v^2 a", lambda v: 1e-3 * v + 2.5 * alpha - 3 * v**2 * a),
    ("|v - a| b", lambda v: abs(v - a) * b),
]
"""A formula as it is typed, and its function."""

SPELLED = [
    ("mu_m + 1/(1 + exp((v - a)/w))", lambda v: mu_m + 1 / (1 + math.exp((v - a) / w))),
    ("1/(b + a*exp(v/w))^2", lambda v: (b + a * math.exp(v / w)) ** -2),
    ("1/(exp(v/a) + exp(-v/a))", lambda v: 1 / (math.exp(v / a) + math.exp(-v / a))),
    ("a/cosh(v/w)", lambda v: a / math.cosh(v / w)),
    ("a*coth(v + w) + b/tanh(v + w)", lambda v: (a + b) / math.tanh(v + w)),
    ("a/cosh(v/w)^2", lambda v: a / math.cosh(v / w) ** 2),
    ("exp(-2*b*v)*cosh(b*v)", lambda v: math.exp(-2 * b * v) * math.cosh(b * v)),
    ("v*exp(-b*v)*sinh(a*v)^2", lambda v: v * math.exp(-b * v) * math.sinh(a * v) ** 2),
    ("mu_s*exp(-p*log(1 + v/w))", lambda v: mu_s * (1 + v / w) ** -p),
    ("a*2^(-v/w)", lambda v: a * 2 ** (-v / w)),
    ("b*log(1 + v_b/v)", lambda v: b * math.log(1 + v_b / v)),
    ("tanh(log(1 + v/w))", lambda v: math.tanh(math.log(1 + v / w))),
    ("a*cosh(p*log(1 + v))", lambda v: a * math.cosh(p * math.log(1 + v))),
    ("Min(1, v_b/v)", lambda v: min(1, v_b / v)),
    ("Min(Max(a - b*v, 0), mu_s)", lambda v: min(max(a - b * v, 0), mu_s)),
    ("Max(mu_m, mu_s*exp(-v/w))", lambda v: max(mu_m, mu_s * math.exp(-v / w))),
    ("Max(mu_m, mu_s - b*log(1 + v/w))", lambda v: max(mu_m, mu_s - b * math.log(1 + v / w))),
    ("Min(a*v, b, mu_s + 0.1*b)", lambda v: min(a * v, b, mu_s + 0.1 * b)),
    ("Abs(v - a)*Abs(v - b)", lambda v: abs(v - a) * abs(v - b)),
    ("exp(-Abs(v - a))*Max(v, b)", lambda v: math.exp(-abs(v - a)) * max(v, b)),
    ("Abs(Abs(v - 1) - 0.5)", lambda v: abs(abs(v - 1) - 0.5)),
    ("Piecewise((a*(1 - exp(-3)), v < 0.5), (b*Abs(v - 1), True))",
     lambda v: a * (1 - math.exp(-3)) if v < 0.5 else b * abs(v - 1)),
    ("0.12 + 0.3*exp(-(v/0.0788816)^1.4144337)", lambda v: 0.12 + 0.3 * math.exp(-((v / 0.0788816) ** 1.4144337))),
    ("a*(1 + v/0.3333337)^(-0.7717171)", lambda v: a * (1 + v / 0.3333337) ** -0.7717171),
]  # fmt: skip
"""A spelling that was refused or had no closed form, and its function."""


@pytest.mark.parametrize(("text", "function"), [*TYPED, *SPELLED])
def test_a_spelling_means_its_function(text, function):
    law = ss.FrictionLaw(text)
    law = law.bind(**{name: VALUES[name] for name in law.parameters})
    with np.errstate(all="ignore"):
        expected = [function(float(v)) for v in SPEEDS]
    assert law.mu(SPEEDS) == pytest.approx(expected, rel=3e-12, abs=1e-15)
    assert law.mu(SPEEDS * 1.001) != pytest.approx(expected, rel=3e-12, abs=1e-15)


SAME = [
    ("1/(1 + exp(v/w))", "(1 - tanh(v/(2*w)))/2"), ("1/cosh(v)", "sech(v)"), ("1/cosh(v)^2", "1 - tanh(v)^2"),
    ("exp(-p*log(1 + v))", "(1 + v)^(-p)"), ("2^(-v/w)", "exp(-v*log(2)/w)"), ("erfc(v)", "1 - erf(v)"),
    ("exp(-2*v)*cosh(v)", "(exp(-v) + exp(-3*v))/2"), ("log(1 + w/v)", "log(1 + v/w) - log(v) + log(w)"),
    ("tanh(log(v))", "(v^2 - 1)/(v^2 + 1)"), ("Min(1, w/v)", "Piecewise((1, v < w), w/v)"),
    ("1/(5*v + 5)", "0.2/(1 + v)"), ("1/tanh(v + a)", "coth(v + a)"),
    ("1/cosh(v) + Abs(v - a)", "sech(v) + Abs(v - a)"),
    ("Piecewise((1/cosh(v), v < a), exp(-p*log(1 + v)))", "Piecewise((sech(v), v < a), (1 + v)^(-p))"),
]  # fmt: skip


@pytest.mark.parametrize(("spelling", "other"), SAME)
def test_spellings_have_one_normal_form(spelling, other):
    first, second = (ss.FrictionLaw(text).expr for text in (spelling, other))
    assert first == second or sp.expand(first - second) == 0


def test_no_two_kinks_stand_in_one_term():
    law = ss.FrictionLaw("Abs(v - a)*Max(v, b)*Min(v, d) + Abs(v - w)")
    for term in law.expr.args:
        assert len([node for node in term.atoms(sp.Piecewise) if node.has(ss.symbols.v)]) == 1


def test_numbers_under_roots_are_not_expanded():
    law = ss.FrictionLaw("0.12 + 0.3*exp(-(v/0.0788816)^1.4144337)")
    sizes = fold(law.expr, lambda node, parts: max(parts, default=0) if parts else len(str(node)))
    assert sizes < 20
    assert ss.FrictionLaw(law.text).expr == law.expr
    assert "0.0788816" in ss.FrictionLaw("0.5 - 0.0788816*v").text


UNITS = [
    ("mu_m + (mu_s - mu_m)*exp(-v/v_s)", {"v_s": "m/s"}, {"v_s": "s/m"}),
    ("mu_m + (mu_s - mu_m)*exp(-(v/v_s)^p)", {"v_s": "m/s"}, {"v_s": "s/m"}),
    ("mu_s - b*v", {"b": "s/m"}, {"b": "m/s"}),
    ("mu_s - a*v^p/w^p", {"a": "1", "w": "m/s"}, {"a": "1", "w": "m"}),
    ("mu_s + b*Abs(v - v_0)", {"b": "s/m", "v_0": "m/s"}, {"v_0": "s/m"}),
    ("Piecewise((mu_s, v < v_0), mu_s - b*(v - v_0))", {"b": "s/m"}, {"mu_s": "m"}),
    ("0.5 - 0.3*v + a*log(1 + v/v_0)", {"v_0": "m/s"}, {"v_0": "1"}),
    ("a*sqrt(v)", {"a": "s^(1/2)/m^(1/2)"}, {"a": "s/m"}),
]


@pytest.mark.parametrize(("text", "right", "wrong"), UNITS)
def test_units_of_parameters_fit_the_formula(text, right, wrong):
    assert all(ss.FrictionLaw(text, units=right).parameters[name].unit == unit for name, unit in right.items())
    with pytest.raises(ss.InputError, match="the units do not fit"):
        ss.FrictionLaw(text, units=wrong)


def test_units_of_the_catalogue_fit():
    for name, law in ss.laws.items():
        units = {key: parameter.unit for key, parameter in law.parameters.items()}
        assert ss.FrictionLaw(law.text, parameters=law.parameters.values()).expr == law.expr, name
        if name in ("rational", "brown_mcphee", "simscape"):
            continue  # their numbers may carry units
        for key in units:  # and no other does
            described = [ss.Parameter(k, unit=u if k != key else f"kg*{u}", positive=law.parameters[k].positive)
                         for k, u in units.items()]  # fmt: skip
            with pytest.raises(ss.InputError, match="the units do not fit"):
                ss.FrictionLaw(law.text, parameters=described)
