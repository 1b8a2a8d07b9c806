"""Text to expressions: what is read, what is refused, and that nothing is ever run."""

import time

import pytest
import sympy as sp
from hypothesis import given, seed, settings
from hypothesis import strategies as st

import stickslip_sym as ss
from stickslip_sym.parsing import parse_expression

a, v = sp.symbols("a v")


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
        ("v == 2", 3, "the character '='"),
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
    "exp(*v)", "exp(**v)", "exp(v=1)", "'a'*9", "b'a'", "1e308*1e308", "await v", "yield v", "", " ", "\n",
]  # fmt: skip


@pytest.mark.parametrize("text", ESCAPES, ids=range(len(ESCAPES)))
def test_known_escapes_are_harmless_and_fast(text, monkeypatch):
    def forbidden(*_, **__):
        raise AssertionError("text was evaluated")

    for name in ("eval", "exec", "__import__", "open", "getattr"):
        if name in ("eval", "exec"):
            monkeypatch.setattr(f"builtins.{name}", forbidden)
    start = time.perf_counter()
    try:
        expr = parse(text)
    except ss.InputError:
        pass
    else:
        assert isinstance(expr, sp.Expr)
    assert time.perf_counter() - start < 2


ALPHABET = "vab0123456789.+-*/^() e,_xplog\n"


@seed(20160428)
@settings(max_examples=400, deadline=2000, database=None)
@given(st.one_of(st.text(ALPHABET, max_size=40), st.text(max_size=30)))
def test_any_text_gives_an_expression_or_an_input_error(text):
    try:
        expr = parse(text)
    except ss.InputError:
        return
    assert isinstance(expr, sp.Expr)
