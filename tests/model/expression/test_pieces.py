"""Laws with kinks and jumps, in text and as SymPy has them: what is read, and what is refused."""

import math

import numpy as np
import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym import symbols

a, b, v = sp.symbols("a b v")


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


@pytest.mark.parametrize(
    ("text", "position", "message"),
    [
        ("Piecewise((1, v < v), 2)", 1, "places of a Piecewise are parameters or numbers"),
        ("1 + Piecewise((1, v < 2*v - a), 2)", 5, "places of a Piecewise are parameters or numbers"),
        ("Piecewise((1, v != a), 2)", 17, "the character '!'"),
        ("Piecewise((1, 2*v <= a), 2)", 11, "a law in pieces is written"),
        ("Piecewise((1, x < a), 2)", 15, "'x' is taken"),
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
        ("Piecewise()", 11, "a law in pieces is written"),
        ("Piecewise(v)", 11, "a law in pieces is written"),
        ("Piecewise", 1, "Piecewise is a function"),
        ("Piecewise((1, v < sqrt(-2)), 2)", 1, "places of a Piecewise are real"),
        ("Piecewise((1, v < log(0)), 2)", 19, "no finite value"),
        ("Abs(sin(Abs(a - b)))", 1, "unknown order stand in each other"),
        ("*".join(f"Abs(v - {x})" for x in "abdfghl"), None, "more than 6 parameters of unknown order"),
        ("Min(v)", 1, "Min takes two arguments or more"),
        ("Max()", 1, "Max takes two arguments or more"),
        ("Abs(v, a)", 1, "Abs takes one argument"),
        ("Abs", 1, "Abs is a function"),
        ("2*Abs(v^2 - v)", 3, "differ by a linear function of v"),
        ("Max(a*v, b*v - 1)", 1, "differ by a linear function of v"),
        ("Max(a, b, d, i, f, g, h)", 1, "more than 6 parameters of unknown order"),
        ("+".join(f"Abs(v - {i})" for i in range(1, 60)), None, "more than 40 arguments in all"),
        ("(v < a)", 4, "a comparison is no number"),
        ("v < a", 3, "a comparison is no number"),
        ("(v, a)", 3, "a comma stands between two formulas"),
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
        sp.Heaviside(v - 1),
        sp.sign(a - b) + v,
    ],
)
def test_sympy_kinks_that_are_no_laws(expr):
    with pytest.raises(ss.InputError):
        ss.FrictionLaw(expr)
