"""Formulas that are refused: where, with what advice; that nothing is ever run, and nothing hangs."""

import itertools
import warnings
from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

import stickslip_sym as ss
from support.sweeps import sweep

a, b, v = sp.symbols("a b v")
SEED = 20160428
REFUSED = [
    ("v + os.system", 7, "attribute is not allowed"),
    ("v^2 + __class__", 7, "'__class__' is not a usable name"),
    ("a^2*(lambda: v)", 6, "write the formula alone, in v"),
    ("a^2*(v if a else v)", 8, "write Piecewise"),
    ("sin(" * 7 + "v" + ")" * 7, None, "more than 6 functions stand in each other"),
    ("v := 2", 3, "the character ':'"),
    ("f'{v}'", 2, 'the character "\'"'),
    ("expp(v)", 1, "there is no function 'expp' .did you mean 'exp'"),
    ("exp(v, a)", 1, "exp takes one argument"),
    ("v % 2", 3, "the character '%'"),
    ("v // 2", 4, "a number, a name or a parenthesis is missing"),
    ("exp", 1, "exp is a function"),
    ("v\x00", 2, "the character '.x00'"),
    ("аlpha*v", 1, "the character 'а'"),  # a Cyrillic letter
    ("v^2 + 1/0", 9, "division by zero"),
    ("v^65", 3, "at most 64"),
    ("0x10*v", 1, "'0x10' is not a decimal"),
    ("(v", 1, "cannot be read"),
    ("v == 2", 3, "a comparison is no number"),
    ("0.3 - 0,2*v", 8, "write 0.2"),
    ("3 4*v", 3, "two numbers side by side"),
    ("a (1 + v)", 1, r"a product is written a\*"),
    ("True*v", 1, "'True' is not a usable name"),
    ("1 + log10(v)", 5, r"write log\(x\)/log\(10\)"),
    ("Piecewise((1, v < v), 2)", 1, "places of a Piecewise are parameters or numbers"),
    ("Piecewise((1, v != a), 2)", 17, "the character '!'"),
    ("Piecewise((1, 2*v <= a), 2)", 11, "a law in pieces is written"),
    ("Piecewise((1, x < a), 2)", 15, "'x' is taken"),
    ("Piecewise((1, v < a), (2, v > b))", 23, "the last one may end in True"),
    ("Piecewise((1, True), (2, v < b))", 11, "only the last one may end in True"),
    ("Piecewise((1, v <= 0), 2)", 1, "a piece holds at v = 0 alone.*static="),
    ("Piecewise((1, v < a), (2, v < b))", 23, "a law in pieces is written"),
    ("Piecewise((1, v < sqrt(-2)), 2)", 1, "places of a Piecewise are real"),
    ("Piecewise((1, v < log(0)), 2)", 19, "no finite value"),
    ("|(v - a|)", 8, "a bar without its partner"),
    ("sign(a - b)", 1, "sign.* of parameters alone"),
    ("*".join(f"Abs(v - {x})" for x in "abdfghl"), None, "more than 6 parameters of unknown order"),
    ("mu_0/2v", 7, r"a product after a quotient: write /\(2\*v\.\.\.\) or /2\*v"),
    ("a/b^2 v", 7, r"write /\(b\^2\*v\.\.\.\) or /b\^2\*v"),
    ("a + b/v(1 + v)", 8, "a product after a quotient"),
    ("√v^2", 1, "what the root is of has two readings"),
    ("2√2v", 2, "what the root is of has two readings"),
    ("e*v", 1, "'e' looks like a constant"),
    ("2e - v^2", 1, "'2e' is not a decimal number"),
    ("Min(v)", 1, "Min takes two arguments or more"),
    ("2*Abs(v^2 - v)", 3, "differ by a linear function of v"),
    ("+".join(f"Abs(v - {i})" for i in range(1, 66)), None, "more than 64 arguments in all"),
    ("(v, a)", 3, "a comma stands between two formulas"),
    ("log(v - v)", 1, "no finite value"),
    ("2^exp(exp(exp(exp(2))))", 3, "a number in exp"),
    ("2^log(-2)", 3, "a numeric exponent is real"),
    ("sqrt(1e99 + 1)", 1, "a root is taken of a number with too many digits"),
    ("(a+b+d+q+f+g+v)^64", None, "too high a power of a sum; at most"),
    ("a*v^40*exp(p*v)", None, r"v\*\*40 is too high a power of v; at most v\^24"),
    ("(a+b+d+q+f+g+v)^16", None, "over 600 terms"),
    ("exp(25*log(v))", None, "too high a power of v"),
    ("a + v*|v - Q|^x", 15, "'x' is taken"),
    ("(-1)^(1/3)*v", None, "is not real: only whole powers"),
    ("sqrt(-v)", None, "not finite and real"),
]
"""A text, where its first wrong character is, and what the refusal says."""


@pytest.mark.parametrize(("text", "position", "message"), REFUSED)
def test_a_refusal_points_at_its_character(text, position, message):
    with pytest.raises(ss.InputError, match=message) as caught:
        ss.FrictionLaw(text)
    assert position is None or f"(character {position})" in str(caught.value)


@pytest.mark.parametrize(
    "expr",
    [
        sp.Piecewise((a, v > 0), (b, True)), sp.Piecewise((a, v <= 0), (b, True)), sp.Piecewise((a, v < 1)),
        sp.Piecewise((a, a < 1), (b, True)), sp.Piecewise((a, (v < 1) | (a < 2)), (b, True)),
        sp.Piecewise((a, v < 2 * v - b), (b, True)), sp.Abs(v**2 - v), sp.sign(a - b) + v,
        sp.Symbol("a*b") * v, sp.Symbol("pi") * v, sp.Function("f")(v), v * sp.I, sp.Symbol("a; b") + 1,
        sp.Symbol("__import__('os')") * v,
        sp.Integral(v, v), sp.zoo * v, sp.Integer(10) ** 6000 * v,
    ],
)  # fmt: skip
def test_sympy_expressions_that_are_no_laws(expr):
    with pytest.raises(ss.InputError):
        ss.FrictionLaw(expr)


# -- what could run, and what could hang -----------------------------------------------------------

ESCAPES = [
    "().__class__.__bases__[0].__subclasses__()", "__import__('os').system('id')", "exec('x=1')", "eval('1')",
    "(lambda: 0)()", "[x for x in (1,2)]", "{1: 2}", "f'{1}'", "(x := 1)", "10**10**10", "9**9**9**9",
    "((9^64)^64)^64", "1e999", "9" * 2000, "-" * 1900 + "v",
    "(" * 500 + "v" + ")" * 500, "v" + "^v" * 900,
    "v" + "+v" * 900, "exp(" * 59 + "v" + ")" * 59, "v if v else v", "v and v", "not v", "~v",
    "v[0]", "v.real", "*v", "getattr(v, v)", "\u212f(v)", "v\u200b", "\uff45xp(v)", "...", "v;v",
    "Piecewise((exec, v < 1), 0)", "Piecewise((exec('x'), v < 1), 0)", "Piecewise((1, v < exec), 0)",
    "Piecewise((1, v < 1), 0).args", "Piecewise(*v)", "Piecewise(((1, v < 1)), 0)", "Piecewise(((),), 0)",
    "Piecewise((1, v < 1 < 2), 0)", "v < a < b", "a < eval", "(v, v < 1)", "()", "((),)", "v == v", "v <= 1",
    "Abs(__import__)", "Max(*v)", "Min(key=v, v)", "Max((1, 2), 3)", "Min(eval, exec)", "v, v", "<", "v <",
    "1or v", "v > 1", "v >> 1", "Piecewise((1, v > 1), 0)",
    "exp(*v)", "exp(**v)", "exp(v=1)", "'a'*9", "b'a'", "1e308*1e308", "await v", "yield v", "", " ", "\n",
]  # fmt: skip


def test_known_escapes_are_harmless(monkeypatch):
    def forbidden(*_, **__):
        raise AssertionError("text was evaluated")

    for imported in ("Piecewise((a, v < 1), Max(v, b))", "a^v*Abs(v - sqrt(2))"):  # modules are run when they are
        ss.FrictionLaw(imported)
    monkeypatch.setattr("builtins.eval", forbidden)
    monkeypatch.setattr("builtins.exec", forbidden)
    for text in ESCAPES:
        with suppress(ss.InputError), warnings.catch_warnings(action="ignore"):
            assert isinstance(ss.FrictionLaw(text).expr, sp.Expr)


LETTERS = [x + y for x in "defghlpqw" for y in "abcdehjklmopqrtuvwxyz0123456789"]
WORST = {
    "a long sum in Abs": "Abs(v*("
    + "+".join("(" + "+".join(LETTERS[i : i + 40]) + ")" for i in range(0, 240, 40))
    + ")-1)",
    "a Max of sums": "Max(" + ",".join("+".join(LETTERS[i : i + 15]) for i in range(0, 240, 15)) + ")",
    "nested sines of numbers": "sin(1+" * 59 + "pi" + ")" * 59,
    "nested Abs": "Abs(sin(" * 29 + "a" + "))" * 29,
    "roots of long numbers": "+".join(f"(1e7{i % 10}-{i})^(1/{i + 2})" for i in range(1, 90)),
    "many pieces": "Piecewise(" + "".join(f"({x}*v, v < {x}*{i})," for i, x in enumerate(LETTERS[:40], 1)) + "1)",
    "unordered pieces from above": "Piecewise(" + "".join(f"({x}*v, v > {x})," for x in LETTERS[:40]) + "1)",
    "a high power in Abs": "Abs(" + "*".join(f"(v+{x})^64" for x in LETTERS[:150]) + ")",
    "a product of sums": "*".join("(" + "+".join(LETTERS[i : i + 30]) + ")" for i in range(0, 270, 30)),
    "a tower": "exp(" * 59 + "9" + ")" * 59,
}


@sweep("name", list(WORST), "a long sum in Abs", "nested Abs", "many pieces", "a tower",
       "a product of sums")  # fmt: skip
def test_the_worst_texts_do_not_hang(name):
    assert len(WORST[name]) <= 2000
    with suppress(ss.InputError):
        ss.FrictionLaw(WORST[name])


TOKENS = st.sampled_from(
    [*"vab102+-*/^(),<| ", "0.5", "1e3", "pi", "**", "<=", "·", "np."]
    + [f"{name}(" for name in ("exp", "log", "sqrt", "sech", "Abs", "Min", "Max", "Piecewise", "Piecewise(")]
)
SHAPES = [
    *(f"({{0}}){sign}({{1}})" for sign in "+-*/^"), "Min({0}, {1})", "Max({0}, {1})",
    *(f"{name}({{0}})" for name in ("-", "exp", "log", "tanh", "Abs")),
    *(f"Piecewise(({{0}}, v < {place}), {{1}})" for place in ("a", "1", "b/2", "log(a)", "v")),
]  # fmt: skip
FORMULAS = st.recursive(
    st.sampled_from(["v", "v", "a", "b", "2", "0", "0.3", "pi"]),
    lambda parts: st.builds(str.format, st.sampled_from(SHAPES), parts, parts),
    max_leaves=8,
).map(lambda text: f"{text} + 0*v")
TEXTS = st.one_of(st.text(max_size=30), st.lists(TOKENS, max_size=25).map("".join), FORMULAS)


@given(TEXTS)
def test_any_text_gives_a_law_with_values_or_an_input_error(text):
    try:
        with warnings.catch_warnings(action="ignore"):
            law = ss.FrictionLaw(text)
        values = law.bind(**dict.fromkeys(law.parameters, "0.5")).mu([0.0, 0.25, 1.5])
    except ss.InputError:
        return
    assert values.shape == (3,)
    assert not np.isnan(values).any()


# -- names that are no parameters ------------------------------------------------------------------

CONSTANTS = ["E", "exp1", "pI", "E_", "I", "INF", "nan", "euler"]
SPEED = ["v_r", "vel", "vrel", "Speed", "veloctiy", "sped", "vv", "v_slip", "xdot", "v_", "v1"]
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


@pytest.mark.parametrize("name", SPEED)
def test_a_misspelt_speed_is_no_parameter(name):
    for template in TEMPLATES:
        with pytest.raises(ss.InputError, match="looks like the slip speed, which is v"):
            ss.FrictionLaw(template.format(name))


def test_no_misspelling_passes_in_silence():
    """Random names for v in random formulas: all are refused or warned of; with v in its place none is."""
    rng = np.random.default_rng(SEED)
    letters = list("abdefghijlopqrsuwyz")
    for template, _ in itertools.product(TEMPLATES, range(25)):
        name = "".join(rng.choice(letters, rng.integers(1, 4))) + str(rng.choice(["", "_r", "1", "el"]))
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
        assert ss.FrictionLaw(template.format("v")).expr.has(ss.symbols.v)


def test_a_constant_law_says_that_it_is_one():
    assert ss.FrictionLaw("mu_0 - b", units={"mu_0": "1", "b": "1"}).slope_expr == 0
    with pytest.warns(ss.InputWarning, match=r"no v.*its parameters: mu_0, b\."):
        ss.FrictionLaw("mu_0 - b")


def test_reference_speeds_stand_beside_v():
    for name in ("v_0", "v_c", "v_ref", "v1", "V_0", "vs"):
        assert name in ss.FrictionLaw(f"mu_0 - b*log(1 + v/{name})").parameters
    with pytest.warns(ss.InputWarning, match="'v_r' is taken for a parameter"):
        ss.FrictionLaw("mu_0 - b*log(1 + v/v_r)")


@pytest.mark.parametrize("name", ["V", "N", "m", "k", "c", "x", "t", "self", "digits", "on_invalid"])
def test_names_of_quantities_and_arguments_are_taken(name):
    with pytest.raises(ss.InputError, match=f"'{name}' is (taken: it is (the|an argument of functions))"):
        ss.FrictionLaw(f"1 + {name}*v")
    assert ss.FrictionLaw(f"1 + {name}_1*v").missing == [f"{name}_1"]


# -- units -------------------------------------------------------------------------------------------

UNITS = [
    ("mu_m + (mu_s - mu_m)*exp(-(v/v_s)^p)", {"v_s": "m/s"}, {"v_s": "s/m"}),
    ("mu_s + b*Abs(v - v_0)", {"b": "s/m", "v_0": "m/s"}, {"v_0": "s/m"}),
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
        assert ss.FrictionLaw(law.text, parameters=law.parameters.values()).expr == law.expr, name
        if name not in ("rational", "brown_mcphee", "simscape"):  # whose numbers may carry units
            for key in law.parameters:  # and no other does
                described = [replace(known, unit=f"kg*{known.unit}" if known.name == key else known.unit)
                             for known in law.parameters.values()]  # fmt: skip
                with pytest.raises(ss.InputError, match="the units do not fit"):
                    ss.FrictionLaw(law.text, parameters=described)
