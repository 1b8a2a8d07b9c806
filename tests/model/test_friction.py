"""Friction laws: reading, binding, evaluating, and refusing."""

import copy
import math
import re
from fractions import Fraction

import mpmath
import numpy as np
import pytest
import sympy as sp
import uncertainties

import stickslip_sym as ss
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.negative import lowest

SEED = 20160428
TEXT = "mu_m + (mu_s - mu_m)*exp(-alpha*v)"


def test_speeds_broadcast(law):
    assert isinstance(law.mu(0.3), float)
    coulomb = ss.FrictionLaw("mu_k").bind(mu_k=0.3)
    assert coulomb.mu(np.zeros((2, 3))).tolist() == [[0.3] * 3] * 2
    assert coulomb.slope(np.zeros(2)).tolist() == [0.0, 0.0]


def test_bind_is_partial_and_leaves_the_law_alone():
    law = ss.FrictionLaw(TEXT)
    half = law.bind(mu_s=0.5)
    assert (half.missing, len(law.missing)) == (["mu_m", "alpha"], 3)
    full = half.bind(mu_m="0.2", alpha=Fraction(3))
    assert full.values == {"mu_s": sp.Rational(1, 2), "mu_m": sp.Rational(1, 5), "alpha": sp.Integer(3)}


LAW = ss.laws.exponential
REFUSED = [
    *((rf"alpha = {re.escape(repr(value))} is", lambda value=value: LAW.bind(alpha=value))
      for value in (math.nan, math.inf, mpmath.inf, "nan", "", None, True, 1j, [1])),
    ("alpha = '0.5 furlongs'", lambda: LAW.bind(alpha="0.5 furlongs")),
    *((f"mu_s = .*{message}", lambda text=text: LAW.bind(mu_s=text)) for text, message in (
        ("0.5+/-nan", "not finite"), ("nan+/-0.1", "not finite"), ("0.5+/-inf", "not finite"),
        ("0.5+/--0.1", "negative standard error"), ("-0.5+/-0.1", "is negative"),
        *((text, "is not a number with a standard error") for text in ("0.5+/-", "0.5(two)", "mu(3)")),
    )),
    *(("is not a finite number >= 0", lambda speed=speed: LAW.typical().mu(speed))
      for speed in (-1e-300, math.nan, math.inf, [0.1, -0.2])),
    *(("is not a number or an array of numbers", lambda speed=speed: LAW.typical().mu(speed))
      for speed in (None, 1j, [1, [2]], {1})),
    ("v = 'x' is not a number", lambda: LAW.typical().mu("x")),
    *(("has a kink at v = .* no real number at these values; give other",
       lambda place=place: ss.FrictionLaw(f"Piecewise((1, v < {place}), 2)").bind(a="0.5"))
      for place in ("log(a - 1)", "log(a - 0.5)", "1/(a - 0.5)")),
    *(("is not a unit|a formula is text|the formula is empty", lambda unit=unit: ss.Parameter("a", unit=unit))
      for unit in ("sin(m)", "exp(1)*m", "exp(0)*m", "Abs(m)", "Max (m, m)", "m^pi", "pi*m", "m + m", "0", "m^m",
                   "2", "2*s/m", "", 3)),
    *(("is (text|a mapping.*|an iterable.*|a Parameter|True or False), got", call) for call in (
        *(lambda wrong=wrong: ss.FrictionLaw("a*v", **wrong) for wrong in (
            {"name": 3}, {"source": [1]}, {"validity": b"1"}, {"units": ["a"]}, {"parameters": 3},
            {"parameters": ["a"]},
        )),
        lambda: ss.Parameter("a", meaning=3), lambda: ss.Parameter("a", positive=1), lambda: ss.Parameter(3),
    )),
    ("no limit mu.0.. was found.*static=", lambda: ss.FrictionLaw("sin(1/v)*tan(1/v)").static_expr),
    *(("digits is a whole number, got str: '3'", lambda call=call: call(LAW.typical(), V=1, N=1, digits="3"))
      for call in (ss.enclose, ss.quadrature.damping,
                   lambda law, digits, **at: ss.derive(law, "equilibrium").evaluate(digits, **at))),
    ("cannot depend on v", lambda: LAW.with_static("mu_0 + v")),
    ("'q' does not occur", lambda: LAW.with_static("mu_0", units={"q": "1"})),
    ("'mu_s' has its description already", lambda: LAW.with_static("mu_s", units={"mu_s": "1"})),
    ("'furlong' is not a unit", lambda: ss.FrictionLaw(TEXT, units={"alpha": "s/furlong"})),
    ("'beta' does not occur", lambda: ss.FrictionLaw(TEXT, units={"beta": "1"})),
    *(("function", lambda name=name: ss.Parameter(name)) for name in ("ln", "erfc", "sign", "log10", "coth")),
    ("typical value -1 of 'a' is negative", lambda: ss.Parameter("a", typical="-1")),
    ("a = 'abc' is not a number", lambda: ss.Parameter("a", typical="abc")),
    ("has no parameter 'alfa' .did you mean 'alpha'", lambda: LAW.bind(alfa=3)),
    ("alpha = -1 is negative.*positive=False", lambda: LAW.bind(alpha=-1)),
    (r"no value for mu_m, alpha; give it first: law.bind\(mu_m=..., alpha=...\)",
     lambda: LAW.bind(mu_s=0.5).mu(0.1)),
]  # fmt: skip
"""What a refusal says, and what is refused."""


@pytest.mark.parametrize(("message", "call"), REFUSED)
def test_what_is_no_value_no_speed_or_no_description_is_refused(message, call):
    with pytest.raises(ss.InputError, match=message):
        call()


def test_declared_signs_and_units_are_kept():
    free = ss.FrictionLaw("1 + b*v", parameters=[ss.Parameter("b", typical="-1", positive=False)])
    assert free.typical().mu(0.5) == 0.5
    assert ss.laws.exponential.typical(mu_m=0).mu(0.0) == 0.5
    for unit in ("1", "m", "N*s^2/m^2", "m^(1/2)", "kg/(m*s)", "m^0.5"):
        assert ss.Parameter("a", unit=unit).unit == unit


def test_what_a_law_holds_cannot_be_changed():
    law = ss.laws.exponential.bind(mu_s=0.5)
    with pytest.raises(TypeError):
        law.values["mu_s"] = 1
    with pytest.raises(TypeError):
        del law.parameters["mu_s"]
    with pytest.raises(AttributeError):
        law.values = {}
    bound = copy.deepcopy(law).bind(mu_m=0.2, alpha=3)
    assert (law.values, len(bound.values)) == ({"mu_s": sp.Rational(1, 2)}, 3)


@pytest.mark.parametrize(
    ("formula", "mu", "slope"),
    [
        ("log(v)", -np.inf, np.inf), ("1/v", np.inf, -np.inf), ("sqrt(v)", 0, np.inf), ("v*log(v)", 0, -np.inf),
        ("v^1.5", 0, 0), ("v^(p/2)*(a*v - b)*(v + d - 2)", 0, np.inf),
        ("Piecewise((v, v < 1), (log(v - 1)))", 0, 1), ("Piecewise((2, v < 0), v)", 0, 1),
    ],
)  # fmt: skip
def test_limits_at_rest(formula, mu, slope):
    law = ss.FrictionLaw(formula)
    law = law.bind(**dict.fromkeys(law.parameters, 1))
    assert (law.mu(0.0), law.slope(0.0)) == (mu, slope)
    assert law.mu(np.array([0.0, 0.5]))[0] == mu


def test_limits_at_rest_of_fitted_exponents():
    p = 1.2345678
    for formula, limit in (("0.3 + v^p/v", 0.3), ("0.3 + sin(p*v)/v", 0.3 + p), ("(1 - exp(-p*v))/v", p)):
        assert ss.FrictionLaw(formula).bind(p="1.2345678").onset == pytest.approx(limit, rel=1e-15)


@pytest.mark.parametrize(
    ("formula", "values", "speed"),
    [
        ("log(v - 0.2)", {}, 0.1), ("exp(800*v)/(1 + exp(800*v))", {}, 1.0), ("sqrt(v - 1)", {}, 0.0),
        ("v*b^0.5", {"b": -1}, 0.25), ("v + 1/b", {"b": 0}, 0.25),
    ],
)  # fmt: skip
def test_no_value_is_an_error_that_names_the_speed(formula, values, speed):
    free = [ss.Parameter(name, positive=False) for name in values]
    law = ss.FrictionLaw(formula, parameters=free).bind(**values)
    with pytest.raises(ss.InputError, match=f"the law has no value in double precision .* v = {speed}"):
        law.mu([speed, 2.0])


def test_laws_are_equal_if_formula_values_and_description_are():
    law = ss.FrictionLaw("a - b*v", name="linear").bind(a="0.5", b="0.1")
    same = ss.FrictionLaw("a - b*v", name="linear").bind(b="0.1", a="0.5")
    pairs = [uncertainties.correlated_values([0.5, 0.1], [[1e-4, r], [r, 1e-4]]) for r in (5e-5, 0.0)]
    points = [0, 1, 2, 3], [0.5, 0.4, 0.3, 0.2]
    others = [
        law.bind(b="0.2"), law.with_static("a"), ss.FrictionLaw("a - b*v").bind(a="0.5", b="0.1"),
        *(law.bind(a=a, b=b) for a, b in pairs),
        *(ss.FrictionLaw.from_samples(*points, extrapolate=held) for held in (False, True)),
    ]  # fmt: skip
    assert (law, hash(law)) == (same, hash(same))
    assert len({law, same, *others}) == 1 + len(others)


# -- negative coefficients ---------------------------------------------------------------------------


def test_the_lowest_coefficient_of_random_laws():
    """Against a fine grid: sines of random phase, which have their minima anywhere."""
    rng = np.random.default_rng(SEED)
    law = ss.FrictionLaw("1.02 + sin(q*v + s)")
    for _ in range(30):
        bound = law.bind(q=rng.uniform(0.5, 9), s=rng.uniform(0, 6))
        end = 10 ** rng.uniform(-3, 0.5)
        fine = float(np.min(bound.mu(np.linspace(0, end, 20001))))
        v, mu = lowest(bound.bound, end)
        assert 0 < v <= end * (1 + 1e-12)
        assert mu == pytest.approx(fine, abs=2e-3)


# -- the coefficient at rest -------------------------------------------------------------------------


def test_the_static_coefficient_of_random_laws_in_pieces():
    """`static_expr` at random values is the numeric limit of mu, whichever piece holds near v = 0."""
    rng = np.random.default_rng(SEED)
    pieces = ["a + b*v", "a*exp(-v)", "b/(1 + v)", "a", "sqrt(a + v)", "b*cos(v)", "a*sinh(v)/v"]
    places = ["d", "g", "d - g", "0.3", "g/2", "d*g", "-0.1"]
    for _ in range(40):
        count = int(rng.integers(1, 4))
        *chosen, last = rng.choice(pieces, count + 1, replace=False)
        inner = [f"({piece}, v < {place})" for piece, place in zip(chosen, rng.choice(places, count), strict=True)]
        text = f"Piecewise({', '.join(inner)}, {last})"
        signed = [name for name in ("d", "g") if name in ss.FrictionLaw(text).parameters and rng.random() < 0.5]
        law = ss.FrictionLaw(text, parameters=[ss.Parameter(name, positive=False) for name in signed])
        bound = law.bind(**{name: rng.uniform(-1 if name in signed else 0.1, 1) for name in law.parameters})
        expected = bound.mu(1e-9)
        assert bound.number(law.static_expr) == pytest.approx(expected, abs=1e-7), text
        assert bound.onset == pytest.approx(expected, abs=1e-7), text


def test_every_law_takes_a_static_coefficient():
    for name, plain in ss.laws.items():
        law = plain.typical().with_static("0.9")
        assert (law.static_value, plain.static) == (max(0.9, law.onset), None)
        assert (law.expr, law.values, law.name) == (plain.expr, plain.typical().values, name)
        assert law.with_static(None) == plain.typical()


def test_a_static_coefficient_brings_and_takes_its_parameters():
    law = ss.laws.exponential.with_static("mu_0*r", units={"mu_0": "1"}).bind(mu_0="0.6")
    assert law.missing == ["mu_s", "mu_m", "alpha", "r"]
    assert law.parameters["mu_0"].unit == "1"
    assert law.with_static("mu_s").values == {}
    assert law.with_static(0.7).static_expr == sp.Rational(*(0.7).as_integer_ratio())


def test_a_static_coefficient_needs_its_parameters_only_where_it_enters():
    law = ss.FrictionLaw(TEXT, static="mu_0*r").bind(mu_s=0.5, mu_m=0.2, alpha=3)
    plain = ss.FrictionLaw(TEXT).bind(mu_s=0.5, mu_m=0.2, alpha=3)
    for value in (
        lambda law: law.mu(0.3), lambda law: law.onset, lambda law: float(ss.enclose(law, V=0.5, N=1, digits=12)),
        lambda law: ss.derive(law)(V=0.5, N=1),
        lambda law: ss.pure_slip_damping(law, V=0.5, N=1, method="harmonic").value,
    ):  # fmt: skip
        assert value(law) == value(plain)
    with pytest.raises(ss.InputError, match=r"no value for mu_0, r; give it first"):
        ss.Oscillator(m=1, k=1, V=1, N=1).onset(law)


# -- laws given in any form ----------------------------------------------------------------------------


def test_a_law_is_given_by_name_or_formula():
    for given in (ss.laws.stribeck, "stribeck", " stribeck", ss.laws.stribeck.text, ss.laws.stribeck.expr):
        assert as_law(given).text == ss.laws["stribeck"].text
    assert as_law("mu_k").text == "mu_k"
    assert as_law(0.3).mu(1.0) == 0.3
    with pytest.raises(ss.InputError, match="did you mean 'exponential'"):
        as_law("exponental")
    for wrong in (None, [0.1], ss.Oscillator(m=1, k=1, V=1, N=1)):
        with pytest.raises(ss.InputError, match="a friction law is needed"):
            as_law(wrong)


OSC = ss.Oscillator(m=1, k=100, V=0.5, N=9.81, c=2.0)
CALLS = {
    "derive": lambda law: ss.derive(law)(V=0.5, N=9.81),
    "slope_average": lambda law: ss.slope_average(law)(V=0.5, N=9.81),
    "enclose": lambda law: float(ss.enclose(law, V=0.5, N=9.81, digits=15)),
    "quadrature": lambda law: float(ss.quadrature.damping(law, V=0.5, N=9.81, digits=15)),
    "pure_slip_damping": lambda law: ss.pure_slip_damping(law, OSC, method="harmonic").value,
    "simulate": lambda law: float(ss.simulate(law, OSC, t_end=0.1).x[-1]),
    "regime": lambda law: str(ss.regime(law, OSC)),
    "limit_cycles": lambda law: len(ss.limit_cycles(law, OSC)),
    "stick_slip_cycle": lambda law: ss.stick_slip_cycle(law, OSC).period,
    "critical": lambda law: [found.value for found in ss.critical(law, "V", c=2.0, N=9.81, m=1, k=100)],
    "compare": lambda law: ss.compare(law, OSC, methods=["harmonic"])["harmonic"].threshold.value,
}


@pytest.mark.parametrize("name", CALLS)
def test_functions_take_a_law_by_its_text(name):
    text = "0.2 + 0.3*exp(-3*v)"
    assert CALLS[name](text) == CALLS[name](ss.FrictionLaw(text))
    with pytest.raises(ss.InputError, match="a friction law is needed"):
        CALLS[name](OSC)


def test_the_order_in_a_formula_makes_no_other_law():
    one, other = ss.FrictionLaw("a*v + b").bind(a=1), ss.FrictionLaw("b + a*v").bind(a=1)
    assert one == other
    assert hash(one) == hash(other)
    assert one != other.bind(b=2)
