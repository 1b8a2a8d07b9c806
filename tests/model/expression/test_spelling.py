"""Formulas as users spell them, and names that are no parameters: what is said of them."""

import itertools
import math
import warnings

import numpy as np
import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym.model.negative import lowest

SEED = 20160428
VALUES = {"a": "0.7", "b": "0.8", "w": "1.3", "mu_0": "0.4", "p": "0.6"}
SPEEDS = np.array([0.0137, 0.2, 0.31, 0.55, 0.93, 1.21, 1.7, 2.9])


def law_of(text):
    law = ss.FrictionLaw(f"{text} + 0*v" if isinstance(text, str) else text)
    return law.bind(**{name: VALUES[name] for name in law.parameters})


SPELLINGS = [
    ("ln({0})", "log({0})"), ("|{0}|", "Abs({0})"), ("abs({0})", "Abs({0})"), ("arctan({0})", "atan({0})"),
    ("arcsinh({0})", "asinh({0})"), ("erfc({0})", "1 - erf({0})"), ("min({0}, {1})", "Min({0}, {1})"),
    ("max({0}, {1})", "Max({0}, {1})"), ("sgn({0})", "sign({0})"),
    ("Piecewise(({0}, v < {2}), ({1}, True))", "Piecewise(({0}, v < {2}), {1})"),
    ("Piecewise(({0}, {2} > v), {1})", "Piecewise(({0}, v < {2}), {1})"),
    ("Piecewise(({0}, v <= {2}), {1})", "Piecewise(({0}, v < {2}), {1})"),
    ("Piecewise(({0}, {2} >= v), ({1}, v > {2}))", "Piecewise(({0}, v < {2}), {1})"),
    ("Piecewise(({1}, v >= {2}), {0})", "Piecewise(({0}, v < {2}), {1})"),
    ("Piecewise(({1}, {2} < v), ({0}, v <= {2}))", "Piecewise(({0}, v < {2}), {1})"),
    ("Piecewise(({1}, v > 2*{2}), ({0}, v > {2}), (v, True))", "Piecewise((v, v < {2}), ({0}, v < 2*{2}), {1})"),
]  # fmt: skip
"""A spelling, and the canonical one, of parts that are linear in v, and a place."""


def test_random_formulas_mean_the_same_in_every_spelling():
    rng = np.random.default_rng(SEED)
    parts = ["v", "2*v + b", "v - a", "b - 2*v", "mu_0 + v/3", "3*v - w"]
    wraps = ["{}", "mu_0 + a*{}", "exp(-a*v)*{}", "{}/(1 + v)", "-{}", "({})^2", "b - {}*2"]
    for spelling, canonical in SPELLINGS:
        for _ in range(4):
            first, second = rng.choice(parts, 2, replace=False)
            if "log" in canonical:
                first = "1 + v/w"
            wrap, place = rng.choice(wraps), rng.choice(["a", "b", "0.5", "w/2"])
            texts = [wrap.format(f"({text.format(first, second, place)})") for text in (spelling, canonical)]
            laws = [law_of(text) for text in texts]
            assert laws[0].mu(SPEEDS) == pytest.approx(laws[1].mu(SPEEDS), rel=1e-14, nan_ok=False), texts
            assert laws[0].expr == laws[1].expr, texts


def test_chains_of_conditions_hold_in_the_order_in_which_they_stand():
    """Pieces of random bounds, either way round, against the first condition that is true."""
    rng = np.random.default_rng(SEED)
    relations = {
        "<": lambda v, d: v < d,
        "<=": lambda v, d: v <= d,
        ">": lambda v, d: v > d,
        ">=": lambda v, d: v >= d,
    }
    turned = {"<": ">", "<=": ">=", ">": "<", ">=": "<="}
    for _ in range(40):
        count = int(rng.integers(1, 5))
        signs = rng.choice(list(relations), count)
        places = [str(round(place, 2)) for place in rng.uniform(0.1, 2.5, count)]
        pieces = [f"{i + 1} + {i}*v" for i in range(count + 1)]
        conditions = [
            f"v {sign} {place}" if rng.random() < 0.5 else f"{place} {turned[sign]} v"
            for sign, place in zip(signs, places, strict=True)
        ]
        inner = ", ".join(f"({piece}, {holds})" for piece, holds in zip(pieces, conditions, strict=False))
        last = f"({pieces[-1]}, True)" if rng.random() < 0.5 else pieces[-1]
        law = ss.FrictionLaw(f"Piecewise({inner}, {last})")
        speeds = rng.uniform(0, 3, 30)
        for v, mu in zip(speeds, law.mu(speeds), strict=True):
            held = (i for i, sign in enumerate(signs) if relations[sign](v, float(places[i])))
            i = next(held, count)
            assert mu == pytest.approx(i + 1 + i * v, rel=1e-14), (inner, v)


@pytest.mark.parametrize(
    ("text", "function"),
    [
        ("Min(a*v**(1/3), mu_0)", lambda v: min(0.7 * v ** (1 / 3), 0.4)),
        ("Max(b - a*v^p, mu_0)", lambda v: max(0.8 - 0.7 * v**0.6, 0.4)),
        ("Max(a*v^2 - b, mu_0 - b)", lambda v: max(0.7 * v**2 - 0.8, -0.4)),
        ("|v^2 - w|", lambda v: abs(v**2 - 1.3)),
        ("Max(a*v^2, mu_0 - b)", lambda v: max(0.7 * v**2, -0.4)),
        ("||v| - w|*|a|", lambda v: 0.7 * abs(v - 1.3)),
        ("mu_0*sign(v - a)", lambda v: math.copysign(0.4, v - 0.7)),
        ("mu_0*sign(v)*sign(-3)", lambda v: -0.4),
        ("mu_0 + a*erfc(v/w)", lambda v: 0.4 + 0.7 * math.erfc(v / 1.3)),
    ],
)
def test_kinks_at_powers_and_other_functions(text, function):
    law = law_of(text)
    assert law.mu(SPEEDS) == pytest.approx([function(v) for v in SPEEDS], rel=1e-13)


def test_sympy_spells_the_same():
    a, b, v = sp.symbols("a b v", positive=True)
    for expr, text in [
        (sp.erfc(v / a), "erfc(v/a)"),
        (b * sp.sign(v - a), "b*sign(v - a)"),
        (sp.Piecewise((b, v > a), (v, True)), "Piecewise((v, v <= a), (b, a < v))"),
        (sp.Piecewise((v, a >= v), (b, True)), "Piecewise((v, v <= a), b)"),
    ]:
        assert ss.FrictionLaw(expr).expr == ss.FrictionLaw(text).expr


def test_a_kink_at_a_power_has_its_closed_form():
    form = ss.derive(ss.FrictionLaw("Min(a*v**(1/3), mu_0)"))
    assert form.verdict.status is ss.Status.PROVED
    scene = {"V": "0.6", "N": 2, "a": "0.7", "mu_0": "0.4"}
    law = law_of("Min(a*v**(1/3), mu_0)")
    expected = ss.quadrature.damping(law, V="0.6", N=2, digits=20)
    assert float(form.evaluate(20, **scene)) == pytest.approx(float(expected), rel=1e-15)


# -- names that are no parameters ------------------------------------------------------------------

CONSTANTS = ["e", "E", "exp1", "Pi", "PI", "pI", "E_", "I", "inf", "INF", "oo", "nan", "NaN", "euler", "pi_"]
SPEED = ["v_r", "vr", "vel", "speed", "velocity", "v_rel", "vrel", "slip_speed", "Speed", "veloctiy", "sped", "vv",
         "v_slip", "xdot", "speeed", "velocitty", "v_", "v1"]  # fmt: skip
TEMPLATES = ["mu_s - a*{0}", "mu_m + (mu_s - mu_m)*exp(-alpha*{0})", "mu_s - b*log(1 + {0}/v_c)", "a/(1 + {0}^2)",
             "Min(a*{0}, mu_s)", "a + b*{0} + d*{0}^3"]  # fmt: skip


@pytest.mark.parametrize("name", CONSTANTS)
def test_constants_are_no_parameters(name):
    for text in (f"mu_0 + {name}*v", f"{name}^(-v)"):
        with pytest.raises(ss.InputError, match=f"'{name}' looks like a constant"):
            ss.FrictionLaw(text)
    with pytest.raises(ss.InputError, match="looks like a constant"):
        ss.FrictionLaw("mu_0 - v", static=f"{name}*mu_0")
    assert ss.FrictionLaw(f"mu_0 + {name}*v", units={name: "s/m"}).parameters[name].unit == "s/m"


@pytest.mark.parametrize(("template", "name"), list(itertools.product(TEMPLATES, SPEED)))
def test_a_misspelt_speed_is_no_parameter(template, name):
    with pytest.raises(ss.InputError, match="looks like the slip speed, which is v"):
        ss.FrictionLaw(template.format(name))


def test_no_misspelling_passes_in_silence():
    """Random names for v in random formulas: all are refused or warned of; with v in its place none is."""
    rng = np.random.default_rng(SEED)
    letters = list("abdefghijlopqrsuwyz")
    for _ in range(150):
        name = "".join(rng.choice(letters, rng.integers(1, 4))) + str(rng.choice(["", "_r", "1", "el"]))
        template = str(rng.choice(TEMPLATES))
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            try:
                law = ss.FrictionLaw(template.format(name))
            except ss.InputError:
                continue
        assert name in law.parameters
        assert [warning.category for warning in said] == [ss.InputWarning]
        assert "the formula has no v" in str(said[0].message)
        assert said[0].filename == __file__
    for template in TEMPLATES:
        assert ss.FrictionLaw(template.format("v")).expr.has(ss.symbols.v)


def test_a_constant_law_says_that_it_is_one():
    for formula in ("mu_0", "0.3", 0.3, "mu_0 - b + 0*v"):
        assert ss.FrictionLaw(formula).slope_expr == 0
    assert ss.FrictionLaw("mu_0 - b", units={"mu_0": "1", "b": "1"}).slope_expr == 0
    with pytest.warns(ss.InputWarning, match=r"no v.*its parameters: mu_0, b\."):
        ss.FrictionLaw("mu_0 - b")


def test_reference_speeds_stand_beside_v():
    for name in ("v_0", "v_s", "v_c", "v_ref", "v1", "V_0", "vs", "v_w"):
        assert name in ss.FrictionLaw(f"mu_0 - b*log(1 + v/{name})").parameters
    with pytest.warns(ss.InputWarning, match="'v_r' is taken for a parameter"):
        ss.FrictionLaw("mu_0 - b*log(1 + v/v_r)")
    assert ss.FrictionLaw("mu_0 - b*log(1 + v/v_r)", units={"v_r": "m/s"}).missing == ["v_r", "mu_0", "b"]


def test_functions_are_no_parameters():
    for name in ("ln", "erfc", "sign", "abs", "log10"):
        with pytest.raises(ss.InputError, match="function"):
            ss.Parameter(name)


# -- what is negative --------------------------------------------------------------------------------


def test_a_negative_coefficient_is_said():
    law = ss.FrictionLaw("a - b*v").bind(a="0.1", b="0.5")
    with pytest.warns(ss.InputWarning, match=r"mu = -0\.4 is negative at the slip speed v = 1 m/s"):
        ss.pure_slip_damping(law, V=0.5, N=1)
    ss.pure_slip_damping(law, V=0.09, N=1)


def test_the_lowest_coefficient_of_random_laws():
    """Against a fine grid: sines of random phase, which have their minima anywhere."""
    rng = np.random.default_rng(SEED)
    law = ss.FrictionLaw("1.02 + sin(q*v + s)")
    for _ in range(30):
        bound = law.bind(q=rng.uniform(0.5, 9), s=rng.uniform(0, 6))
        end = 10 ** rng.uniform(-3, 0.5)
        fine = float(np.min(bound.mu(np.linspace(0, end, 20001))))
        v, mu = lowest(bound, end)
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


def test_a_place_that_is_bound_to_zero_parts_nothing():
    law = ss.FrictionLaw("Piecewise((a, v < d), b)")
    assert law.static_expr == law.parameters["a"].symbol
    assert law.bind(a=0.3, b=0.2, d=0).onset == 0.2


def test_a_limit_that_is_not_found_is_said():
    with pytest.raises(ss.InputError, match=r"no limit mu\(0\+\) was found.*static=\.\.\."):
        _ = ss.FrictionLaw("sin(1/v)*tan(1/v)").static_expr


# -- another static coefficient ----------------------------------------------------------------------


@pytest.mark.parametrize("name", ss.laws.catalogue)
def test_a_catalogue_law_takes_a_static_coefficient(name):
    plain = ss.laws.catalogue[name]
    law = plain.typical().with_static("0.9")
    assert law.static_expr == sp.Rational(9, 10)
    assert (law.expr, law.values, law.name) == (plain.expr, plain.typical().values, name)
    assert plain.static is None
    assert law.with_static(None) == plain.typical()


def test_a_static_coefficient_brings_and_takes_its_parameters():
    law = ss.laws.exponential.with_static("mu_0*r", units={"mu_0": "1"}).bind(mu_0="0.6")
    assert law.missing == ["mu_s", "mu_m", "alpha", "r"]
    assert law.parameters["mu_0"].unit == "1"
    assert law.with_static("mu_s").values == {}
    assert law.with_static(0.7).static_expr == sp.Rational(0.7)
    for static, units, message in (
        ("mu_0 + v", None, "cannot depend on v"),
        ("mu_0", {"q": "1"}, "'q' does not occur"),
        ("mu_s", {"mu_s": "1"}, "'mu_s' has its description already"),
    ):
        with pytest.raises(ss.InputError, match=message):
            ss.laws.exponential.with_static(static, units=units)


def test_measured_points_take_a_static_coefficient_and_keep_it(tmp_path):
    law = (
        ss.FrictionLaw.from_samples([0, 0.1, 0.2, 1.2], [0.5, 0.4, 0.35, 0.3]).with_static("mu_0").bind(mu_0="0.6")
    )
    ss.save(ss.derive(law, "equilibrium"), tmp_path / "form.json")
    assert ss.load(tmp_path / "form.json").law == law
    osc = ss.Oscillator(m=1.0, k=100.0, V=0.5, N=9.81)
    assert osc.onset(law) == pytest.approx(0.6 * 9.81 / 100)
