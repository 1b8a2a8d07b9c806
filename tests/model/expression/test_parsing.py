"""Text to expressions: what is read, what is refused, and that nothing is ever run."""

import math
import time
from contextlib import suppress

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, seed, settings
from hypothesis import strategies as st

import stickslip_sym as ss
from stickslip_sym import symbols
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
        ("v + os.system", 5, "attribute is not allowed"),
        ("v^2 + __class__", 7, "'__class__' is not a usable name"),
        ("a^2*(lambda: v)", 12, "the character ':'"),
        ("a^2*(v if a else v)", 6, "ifexp is not allowed"),
        ("[v for v in a]", 1, r"the character '\['"),
        ("v := 2", 3, "the character ':'"),
        ("f'{v}'", 2, 'the character "\'"'),
        ("expp(v)", 1, "there is no function 'expp' .did you mean 'exp'"),
        ("exp(v, a)", 1, "exp takes one argument"),
        ("exp", 1, "exp is a function"),
        ("v % 2", 3, "the character '%'"),
        ("v // 2", 1, "only \\+ - "),
        ("v\x00", 2, "the character '.x00'"),
        ("аlpha*v", 1, "the character 'а'"),  # a Cyrillic letter
        ("v^2 + 1/0", 9, "division by zero"),
        ("v^65", 3, "at most 64"),
        ("0x10*v", 1, "'0x10' is not a decimal"),
        ("1_0*v", 1, "'1_0' is not a decimal"),
        ("2j*v", 1, "'2j' is not a decimal"),
        ("(v", 1, "cannot be read"),
        ("v == 2", 1, "compare is not allowed"),
        ("True*v", 1, "'True' is not a decimal"),
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
def test_known_escapes_are_harmless_and_fast(text, monkeypatch):
    def forbidden(*_, **__):
        raise AssertionError("text was evaluated")

    monkeypatch.setattr("builtins.eval", forbidden)
    monkeypatch.setattr("builtins.exec", forbidden)
    start = time.perf_counter()
    try:
        expr = parse(text)
    except ss.InputError:
        pass
    else:
        assert isinstance(expr, sp.Expr)
    assert time.perf_counter() - start < 2


@pytest.mark.parametrize(
    ("text", "function", "kinks"),
    [
        ("Abs(v - 0.2)", lambda v: abs(v - 0.2), ["0.2"]),
        ("a*Abs(0.2 - 2*v)", lambda v: 0.7 * abs(0.2 - 2 * v), ["0.1"]),
        ("Abs(v)", lambda v: v, []),
        ("Abs(v + 1)", lambda v: v + 1, []),
        ("Abs(-3)", lambda v: 3, []),
        ("Abs(a - b) + 0*v", lambda v: 0.1, []),
        ("Max(v, a)", lambda v: max(v, 0.7), ["0.7"]),
        ("Min(v, a)", lambda v: min(v, 0.7), ["0.7"]),
        ("Min(a, b) + 0*v", lambda v: 0.7, []),
        ("Max(a, b, 0.1) + 0*v", lambda v: 0.8, []),
        ("Max(a - b*v, 0.1)", lambda v: max(0.7 - 0.8 * v, 0.1), ["0.75"]),
        ("Max(a - v, b - 2*v)", lambda v: max(0.7 - v, 0.8 - 2 * v), ["0.1"]),
        ("Max(v, v)", lambda v: v, []),
        ("Max(v + a, v)", lambda v: v + 0.7, []),
        ("Max(v - a, v - b)", lambda v: v - 0.7, []),
        ("Max(exp(-v), -1)", lambda v: math.exp(-v), []),
        ("Abs(v - 1)^2 + Max(v, 0.5)", lambda v: (v - 1) ** 2 + max(v, 0.5), ["0.5", "1"]),
        ("exp(-Abs(v - 1))", lambda v: math.exp(-abs(v - 1)), ["1"]),
        ("a + b*Abs(v - 1) - Abs(v - 2)", lambda v: 0.7 + 0.8 * abs(v - 1) - abs(v - 2), ["1", "2"]),
        ("Abs(v - 1)*Max(v, 0.5)", lambda v: abs(v - 1) * max(v, 0.5), ["0.5", "1"]),
        ("Piecewise((v, v < a), b)", lambda v: v if v < 0.7 else 0.8, ["0.7"]),
        (
            "Piecewise((1, v < 0.5), (v, v < 2*a), exp(-v))",
            lambda v: 1 if v < 0.5 else v if v < 1.4 else math.exp(-v),
            ["0.5", "1.4"],
        ),
        ("Piecewise((1, v < 2), (5, v < 1), v)", lambda v: 1 if v < 2 else v, ["1", "2"]),
        ("Piecewise((1, v < b), (5, v < a), v)", lambda v: 1 if v < 0.8 else v, ["0.7", "0.8"]),
        ("Piecewise((v, v < a), (v, v < b), 2)", lambda v: v if v < 0.8 else 2, ["0.8"]),
        ("Piecewise((v, v < b), (v, v < a), 2)", lambda v: v if v < 0.8 else 2, ["0.8"]),
        ("Piecewise((v, v < 1), v)", lambda v: v, []),
        ("Piecewise((9, v < -1), v)", lambda v: v, []),
        ("Piecewise((9, v < 0), v)", lambda v: v, []),
        ("Piecewise((v, v < 1), log(v - 0.99))", lambda v: v if v < 1 else math.log(v - 0.99), ["1"]),
        ("Piecewise((sin(pi*v), v < pi/3), v)", lambda v: math.sin(math.pi * v) if v < math.pi / 3 else v, None),
        ("2*pi*v", lambda v: 2 * math.pi * v, []),
    ],
)
def test_laws_with_kinks(text, function, kinks):
    law = ss.FrictionLaw(text)
    law = law.bind(**{name: value for name, value in {"a": "0.7", "b": "0.8"}.items() if name in law.parameters})
    speeds = np.linspace(0.0137, 2.3, 41)
    assert law.mu(speeds) == pytest.approx(np.vectorize(function, otypes=[float])(speeds), rel=1e-14)
    assert law.mu(0.3) == pytest.approx(function(0.3), rel=1e-14)
    step = 1e-7
    numerical = [(function(v + step) - function(v - step)) / (2 * step) for v in speeds]
    assert law.slope(speeds) == pytest.approx(numerical, rel=1e-6, abs=1e-6)
    if kinks is not None:
        assert law.kinks() == [sp.Rational(place) for place in kinks]
    for node in law.expr.atoms(sp.Piecewise):  # what later algebra may rely on
        assert all(condition.lts == symbols.v for _, condition in node.args[:-1])
        assert not any(branch.has(sp.Piecewise) for branch, _ in node.args)


def test_pi_is_exact():
    assert parse("sin(pi/6)") == sp.Rational(1, 2)
    assert ss.FrictionLaw("Piecewise((1, v < pi), 2)").kinks() == [sp.pi]


@pytest.mark.parametrize(
    ("text", "position", "message"),
    [
        ("Piecewise((1, v < v), 2)", 1, "places of a Piecewise are parameters or numbers"),
        ("1 + Piecewise((1, v < 2*v - a), 2)", 5, "places of a Piecewise are parameters or numbers"),
        ("Piecewise((1, v != a), 2)", 17, "the character '!'"),
        ("Piecewise((1, 2*v <= a), 2)", 11, "a law in pieces is written"),
        ("Piecewise((1, x < a), 2)", 11, "a law in pieces is written"),
        ("Piecewise((1, v == a), 2)", 11, "a law in pieces is written"),
        ("Piecewise((1, v < a), (2, v > b))", 23, "the last one may end in True"),
        ("Piecewise((1, True), (2, v < b))", 11, "only the last one may end in True"),
        ("Piecewise((1, v <= 0), 2)", 1, "a piece holds at v = 0 alone.*static="),
        ("1 - Piecewise((1, v > 0), 2)", 5, "a piece holds at v = 0 alone.*static="),
        ("a + |v - b", 5, "a bar without its partner"),
        ("a + v|", 6, "a bar without its partner"),
        ("|(v - a|)", 8, "a bar without its partner"),
        ("a + v*|v - Q|^x", 15, "'x' is taken"),
        ("1 + log10(v)", 5, r"write log\(x\)/log\(10\)"),
        ("sign(a - b)", 1, "sign.* of parameters alone"),
        ("Piecewise((1, 0 < v < a), 2)", 11, "a law in pieces is written"),
        ("Piecewise((1, v < a, 3), 2)", 11, "a law in pieces is written"),
        ("Piecewise((1, v < a))", 11, "a law in pieces is written"),
        ("Piecewise((1, v < a), (2, v < b))", 23, "a law in pieces is written"),
        ("Piecewise((1, v < a), 1, 2)", 23, "a law in pieces is written"),
        ("Piecewise()", 1, "a law in pieces is written"),
        ("Piecewise(v)", 11, "a law in pieces is written"),
        ("Piecewise", 1, "Piecewise is a function"),
        ("Piecewise((1, v < sqrt(-2)), 2)", 1, "places of a Piecewise are real"),
        ("Piecewise((1, v < log(0)), 2)", 19, "no finite value"),
        ("Piecewise((Abs(v - a), v < 2), 2)", 1, "a kink inside a kink"),
        ("Piecewise((1, v < a), Piecewise((2, v < b), 3))", 1, "a kink inside a kink"),
        ("Abs(Abs(v - 1) - 2)", 1, "a kink inside a kink"),
        ("Max(v, a, b)", 1, "a kink inside a kink"),
        ("Abs(sin(Abs(a - b)))", 1, "a kink inside a kink"),
        ("Min(v)", 1, "Min takes two arguments or more"),
        ("Max()", 1, "Max takes two arguments or more"),
        ("Abs(v, a)", 1, "Abs takes one argument"),
        ("Abs", 1, "Abs is a function"),
        ("2*Abs(v^2 - v)", 3, "differ by a linear function of v"),
        ("Max(a*v, b*v - 1)", 1, "differ by a linear function of v"),
        ("Max(a, b, d, i, f, g, h)", 1, "more than 6 parameters of unknown order"),
        ("+".join(f"Abs(v - {i})" for i in range(1, 60)), None, "more than 40 arguments in all"),
        ("(v < a)", 2, "compare is not allowed"),
        ("v < a", 1, "compare is not allowed"),
        ("(v, a)", 1, "tuple is not allowed"),
        ("absv(v)", 1, "did you mean 'abs'"),
        ("log(v - v)", 1, "no finite value"),
        ("2^exp(exp(exp(exp(2))))", 3, "a number in exp"),
        ("2^log(-2)", 3, "a numeric exponent is real"),
        ("sqrt(1e99 + 1)", 1, "a root is taken of a number with too many digits"),
    ],
)
def test_refused_kinks_point_at_their_character(text, position, message):
    with pytest.raises(ss.InputError, match=message) as caught:
        ss.FrictionLaw(text)
    assert position is None or f"(character {position})" in str(caught.value)


@pytest.mark.parametrize(
    ("text", "expr"),
    [
        ("Abs(v - a)", sp.Abs(v - a)),
        ("Max(v, a)", sp.Max(v, a)),
        ("b*Min(v, a)", b * sp.Min(v, a)),
        ("Max(a, b) - v", sp.Max(a, b) - v),
        ("Piecewise((a, v < 1), (b, v < 2), v*pi)", sp.Piecewise((a, v < 1), (b, v < 2), (v * sp.pi, True))),
        ("Piecewise((a, v < a), b)", sp.Piecewise((a, a > v), (b, True))),
    ],
)
def test_sympy_kinks_give_the_law_of_the_text(text, expr):
    assert ss.FrictionLaw(expr).expr == ss.FrictionLaw(text).expr


@pytest.mark.parametrize(
    "expr",
    [
        sp.Piecewise((a, v > 0), (b, True)),
        sp.Piecewise((a, v <= 0), (b, True)),
        sp.Piecewise((a, v < 1)),
        sp.Piecewise((a, a < 1), (b, True)),
        sp.Piecewise((a, (v < 1) | (a < 2)), (b, True)),
        sp.Piecewise((a, v < 2 * v - b), (b, True)),
        sp.Abs(v**2 - v),
        sp.Abs(sp.Abs(v - 1) - 2),
        sp.Heaviside(v - 1),
        sp.sign(a - b) + v,
    ],
)
def test_sympy_kinks_that_are_no_laws(expr):
    with pytest.raises(ss.InputError):
        ss.FrictionLaw(expr)


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


@pytest.mark.parametrize("name", WORST)
def test_the_worst_texts_are_read_fast(name):
    assert len(WORST[name]) <= 2000
    start = time.process_time()  # not the clock on the wall: this is about the work
    with suppress(ss.InputError):
        ss.FrictionLaw(WORST[name])
    assert time.process_time() - start < 2


ALPHABET = "vab0123456789.+-*/^() e,_xplog<=>\n"
TOKENS = st.sampled_from(
    [
        "v",
        "a",
        "b",
        "1",
        "0",
        "2",
        "0.5",
        "1e3",
        "pi",
        "+",
        "-",
        "*",
        "/",
        "^",
        "**",
        "(",
        ")",
        ",",
        "<",
        "<=",
        " ",
    ]
    + [f"{name}(" for name in ("exp", "log", "sqrt", "sech", "Abs", "Min", "Max", "Piecewise", "Piecewise(")]
)


@seed(20160428)
@settings(max_examples=600, deadline=2000, database=None)
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


@seed(20160428)
@settings(max_examples=400, deadline=2000, database=None)
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
