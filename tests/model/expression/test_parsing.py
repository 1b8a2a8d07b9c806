"""Text to expressions: what is read, what is refused, and that nothing is ever run."""

from contextlib import suppress

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st
from sweeps import sweep

import stickslip_sym as ss
from stickslip_sym.model.expression.parsing import parse_expression

a, b, v = sp.symbols("a b v")


def parse(text):
    return parse_expression(text, sp.Symbol)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a*v^2", a * v**2),
        ("a*v**2", a * v**2),
        ("-v^2", -(v**2)),
        ("2^-v", sp.Integer(2) ** -v),
        ("v^a^2", v ** (a**2)),
        ("0.1 + 1e-3", sp.Rational(101, 1000)),
        ("a +\n v", a + v),
        ("exp(-a*v)/(1 + v)", sp.exp(-a * v) / (1 + v)),
        ("  +a", a),
        ("sech(v) - tanh(v)", sp.sech(v) - sp.tanh(v)),
    ],
)
def test_what_is_read(text, expected):
    assert parse(text) == expected


@pytest.mark.parametrize(
    ("text", "position", "message"),
    [
        ("v + os.system", 7, "attribute is not allowed"),
        ("v^2 + __class__", 7, "'__class__' is not a usable name"),
        ("a^2*(lambda: v)", 6, "write the formula alone, in v"),
        ("a^2*(v if a else v)", 8, "write Piecewise"),
        ("v := 2", 3, "the character ':'"),
        ("f'{v}'", 2, 'the character "\'"'),
        ("expp(v)", 1, "there is no function 'expp' .did you mean 'exp'"),
        ("exp(v, a)", 1, "exp takes one argument"),
        ("exp", 1, "exp is a function"),
        ("v % 2", 3, "the character '%'"),
        ("v // 2", 4, "a number, a name or a parenthesis is missing"),
        ("v\x00", 2, "the character '.x00'"),
        ("аlpha*v", 1, "the character 'а'"),  # a Cyrillic letter
        ("v^2 + 1/0", 9, "division by zero"),
        ("v^65", 3, "at most 64"),
        ("0x10*v", 1, "'0x10' is not a decimal"),
        ("1_0*v", 1, "'1_0' is not a decimal"),
        ("2j*v", 1, "'2j' is not a decimal"),
        ("(v", 1, "cannot be read"),
        ("v == 2", 3, "a comparison is no number"),
        ("0.3 - 0,2*v", 8, "write 0.2"),
        ("exp(0,2*v)", 1, "as in 0.2"),
        ("3 4*v", 3, "two numbers side by side"),
        ("a (1 + v)", 1, r"a product is written a\*"),
        ("True*v", 1, "'True' is not a usable name"),
    ],
)
def test_what_is_refused_points_at_its_character(text, position, message):
    with pytest.raises(ss.InputError, match=message) as caught:
        parse(text)
    assert f"(character {position})" in str(caught.value)


ESCAPES = [
    "().__class__.__bases__[0].__subclasses__()", "__import__('os').system('id')", "exec('x=1')", "eval('1')",
    "(lambda: 0)()", "[x for x in (1,2)]", "{1: 2}", "f'{1}'", "(x := 1)", "10**10**10", "9**9**9**9",
    "((9^64)^64)^64", "2^(2^(2^(2^(2^2))))", "9^64^64", "1e999", "9" * 2000, "-" * 1900 + "v",
    "(" * 500 + "v" + ")" * 500,
    "v" + "^v" * 900, "v" + "+v" * 900, "exp(" * 59 + "v" + ")" * 59, "v if v else v", "v and v", "not v", "~v",
    "v[0]", "v.real", "*v", "print(v)", "open(v)", "getattr(v, v)", "\u212f(v)", "v\u200b", "\uff45xp(v)",
    "...", "v;v",
    "Piecewise((exec, v < 1), 0)", "Piecewise((exec('x'), v < 1), 0)", "Piecewise((1, v < exec), 0)",
    "Piecewise((1, v < 1), 0).args", "Piecewise(*v)", "Piecewise(((1, v < 1)), 0)", "Piecewise(((),), 0)",
    "Piecewise((1, v < 1 < 2), 0)", "v < a < b", "a < eval", "(v, v < 1)", "()", "((),)", "v == v", "v <= 1",
    "Abs(__import__)", "Max(*v)", "Min(key=v, v)", "Max((1, 2), 3)", "Min(eval, exec)", "v, v", "<", "v <",
    "1or v", "v > 1", "v >> 1", "Piecewise((1, v > 1), 0)",
    "exp(*v)", "exp(**v)", "exp(v=1)", "'a'*9", "b'a'", "1e308*1e308", "await v", "yield v", "", " ", "\n",
]  # fmt: skip


@pytest.mark.parametrize("text", ESCAPES, ids=range(len(ESCAPES)))
def test_known_escapes_are_harmless(text, monkeypatch):
    def forbidden(*_, **__):
        raise AssertionError("text was evaluated")

    for imported in ("Piecewise((a, v < 1), Max(v, b))", "a^v*Abs(v - sqrt(2))"):  # modules are run when they are
        ss.FrictionLaw(imported)
    monkeypatch.setattr("builtins.eval", forbidden)
    monkeypatch.setattr("builtins.exec", forbidden)
    with suppress(ss.InputError):
        assert isinstance(parse(text), sp.Expr)


def test_pi_is_exact():
    assert parse("sin(pi/6)") == sp.Rational(1, 2)
    (kink,) = ss.FrictionLaw("Piecewise((1, v < pi), 2)").kinks()
    assert abs(kink - sp.pi).evalf(50) < 1e-49


LETTERS = [x + y for x in "defghlpqw" for y in "abcdehjklmopqrtuvwxyz0123456789"]
WORST = {
    "a long sum in Abs": "Abs(v*("
    + "+".join("(" + "+".join(LETTERS[i : i + 40]) + ")" for i in range(0, 240, 40))
    + ")-1)",
    "a Max of sums": "Max(" + ",".join("+".join(LETTERS[i : i + 15]) for i in range(0, 240, 15)) + ")",
    "nested sines of numbers": "sin(1+" * 59 + "pi" + ")" * 59,
    "nested Abs": "Abs(sin(" * 29 + "a" + "))" * 29,
    "roots of long numbers": "+".join(f"(1e7{i % 10}-{i})^(1/{i + 2})" for i in range(1, 90)),
    "equal pieces": "Piecewise(" + "".join(f"(v, v < {x})," for x in LETTERS[:40]) + "1)",
    "many pieces": "Piecewise(" + "".join(f"({x}*v, v < {x}*{i})," for i, x in enumerate(LETTERS[:40], 1)) + "1)",
    "many pieces from above": "Piecewise("
    + "".join(f"({x}*v, v > {40 - i}),({i} + v, v <= {i}*a)," for i, x in enumerate(LETTERS[:20]))
    + "1)",
    "unordered pieces from above": "Piecewise(" + "".join(f"({x}*v, v > {x})," for x in LETTERS[:40]) + "1)",
    "a high power in Abs": "Abs(" + "*".join(f"(v+{x})^64" for x in LETTERS[:150]) + ")",
    "a product of sums": "*".join("(" + "+".join(LETTERS[i : i + 30]) + ")" for i in range(0, 270, 30)),
    "a tower": "exp(" * 59 + "9" + ")" * 59,
}


@sweep(
    "name",
    list(WORST),
    "a long sum in Abs",
    "nested Abs",
    "many pieces from above",
    "a tower",
    "a product of sums",
)
def test_the_worst_texts_do_not_hang(name):
    assert len(WORST[name]) <= 2000
    with suppress(ss.InputError):
        ss.FrictionLaw(WORST[name])


ALPHABET = "vab0123456789.+-*/^() e,_xplog<=>\n"
TOKENS = st.sampled_from(
    [*"vab102+-*/^(),<| ", "0.5", "1e3", "pi", "**", "<=", "·", "np."]
    + [f"{name}(" for name in ("exp", "log", "sqrt", "sech", "Abs", "Min", "Max", "Piecewise", "Piecewise(")]
)


@given(st.one_of(st.text(ALPHABET, max_size=40), st.text(max_size=30), st.lists(TOKENS, max_size=25).map("".join)))
def test_any_text_gives_an_expression_or_an_input_error(text):
    try:
        expr = parse(text)
    except ss.InputError:
        return
    assert isinstance(expr, sp.Expr)


def _larger_formulas(parts):
    pair = st.tuples(parts, parts)
    return st.one_of(
        st.tuples(parts, st.sampled_from("+-*/^"), parts).map(lambda t: f"({t[0]}){t[1]}({t[2]})"),
        st.tuples(st.sampled_from(["-", "+", "exp", "log", "sqrt", "sin", "tanh", "Abs"]), parts).map(
            lambda t: f"{t[0]}({t[1]})"
        ),
        st.tuples(st.sampled_from(["Min", "Max"]), pair).map(lambda t: f"{t[0]}({t[1][0]}, {t[1][1]})"),
        st.tuples(parts, st.sampled_from(["a", "1", "b/2", "log(a)", "v"]), parts).map(
            lambda t: f"Piecewise(({t[0]}, v < {t[1]}), {t[2]})"
        ),
    )


FORMULAS = st.recursive(
    st.sampled_from(["v", "v", "a", "b", "2", "0", "0.3", "pi"]), _larger_formulas, max_leaves=8
)


@given(FORMULAS)
def test_any_formula_gives_a_law_with_values_or_an_input_error(text):
    try:
        law = ss.FrictionLaw(f"{text} + 0*v")
        law = law.bind(**dict.fromkeys(law.parameters, "0.5"))
        values = law.mu([0.0, 0.25, 1.5])
    except ss.InputError:
        return
    assert values.shape == (3,)
    assert not np.isnan(values).any()
