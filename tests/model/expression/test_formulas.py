"""What a formula means, in whatever spelling: against Python's own functions, and against other spellings."""

import math

import mpmath
import numpy as np
import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym import symbols
from stickslip_sym.core.functions import fold

SEED = 20160428
VALUES = {"a": "0.7", "b": "0.8", "d": "0.35", "w": "1.3", "mu_s": "0.4", "mu_m": "0.15", "p": "0.6", "v_b": "0.9",
          "alpha": "1.7"}  # fmt: skip
SPEEDS = np.array([1e-6, 0.0137, 0.213, 0.31, 0.53, 0.93, 1.21, 1.6, 2.9, 40.0])
a, b, d, w, mu_s, mu_m, p, v_b, alpha = map(float, VALUES.values())


def law_of(formula):
    law = ss.FrictionLaw(formula)
    return law.bind(**{name: VALUES[name] for name in law.parameters})


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
    ("a*e^(-v/w) + 2e^-v + b**2", lambda v: a * math.exp(-v / w) + 2 * math.exp(-v) + b**2),
    ("√v + a√(1 + v) - √2/2", lambda v: math.sqrt(v) + a * math.sqrt(1 + v) - math.sqrt(2) / 2),
    ("a + a(1 + v)exp(-v)", lambda v: a + a * (1 + v) * math.exp(-v)),
    ("mu_m + b|v - a|^2 - 2|v|∣-v∣", lambda v: mu_m + b * (v - a) ** 2 - 2 * v * v),
    ("-v^2 + 2^-v", lambda v: -(v**2) + 2**-v),
    ("v^a^2/3/b*a", lambda v: v ** (a**2) / 3 / b * a),
    ("a - -v**2*-b", lambda v: a - -(v**2) * -b),
    ("  +a*\n v", lambda v: a * v),
    ("mu_m + 1/(1 + exp((v - a)/w))", lambda v: mu_m + 1 / (1 + math.exp((v - a) / w))),
    ("1/(b + a*exp(v/w))^2", lambda v: (b + a * math.exp(v / w)) ** -2),
    ("1/(exp(v/a) + exp(-v/a))", lambda v: 1 / (math.exp(v / a) + math.exp(-v / a))),
    ("a/cosh(v/w)^2", lambda v: a / math.cosh(v / w) ** 2),
    ("v*exp(-b*v)*sinh(a*v)^2", lambda v: v * math.exp(-b * v) * math.sinh(a * v) ** 2),
    ("mu_s*exp(-p*log(1 + v/w))", lambda v: mu_s * (1 + v / w) ** -p),
    ("b*log(1 + v_b/v)", lambda v: b * math.log(1 + v_b / v)),
    ("a*cosh(p*log(1 + v))", lambda v: a * math.cosh(p * math.log(1 + v))),
    ("mu_s + a*erfc(v/w)", lambda v: mu_s + a * math.erfc(v / w)),
    ("0.12 + 0.3*exp(-(v/0.0788816)^1.4144337)", lambda v: 0.12 + 0.3 * math.exp(-((v / 0.0788816) ** 1.4144337))),
]
"""A formula as it is typed, and its function; the later ones were refused or had no closed form."""


@pytest.mark.parametrize("divisor", ["2", "v", "-2", "(1 + v)", "exp(v)", "b^2", "√(v)", "|v|"])
@pytest.mark.parametrize("factor", ["v", "(b + v)", "exp(-v)", "|v - 3|", "√v"])
def test_a_product_after_a_quotient_is_refused_with_both_readings(divisor, factor):
    """Without its sign; with it, and in parentheses, the two differ."""
    both = [law_of(text).mu(0.8) for text in (f"a/({divisor}*{factor})", f"a/{divisor}*{factor}")]
    assert both[0] != pytest.approx(both[1])
    for blank in ("", " "):
        joined = not blank and (divisor[-1] + factor[0]).isalnum() and not divisor.isdigit()
        if not joined:
            with pytest.raises(ss.InputError, match="a product after a quotient") as caught:
                ss.FrictionLaw(f"a/{divisor}{blank}{factor}")
            assert f"/({divisor}*" in str(caught.value)


def test_what_is_no_function_is_a_product_where_it_is_a_parameter():
    assert ss.FrictionLaw("a(1 + v/w)", units={"a": "1"}).expr == ss.FrictionLaw("a*(1 + v/w)").expr
    assert ss.FrictionLaw("e^(v/w)", units={"e": "1"}).expr != ss.FrictionLaw("exp(v/w)").expr
    with pytest.raises(ss.InputError, match="there is no function 'a'; a product is written a"):
        ss.FrictionLaw("b + a(1 + v)")


KINKED = [
    ("a*Abs(0.2 - 2*v)", lambda v: a * abs(0.2 - 2 * v), ["0.1"]),
    ("Abs(v)", lambda v: v, []),
    ("Abs(a - b)*v*Abs(-3)", lambda v: 3 * (b - a) * v, []),
    ("Min(v, a)", lambda v: min(v, a), ["0.7"]),
    ("Min(a, b)*v + Max(a, b, 0.1)", lambda v: a * v + b, []),
    ("Max(v + a, v)", lambda v: v + a, []),
    ("Max(exp(-v), -1)", lambda v: math.exp(-v), []),
    ("Abs(v - 1)^2 + Max(v, 0.5)", lambda v: (v - 1) ** 2 + max(v, 0.5), ["0.5", "1"]),
    ("exp(-Abs(v - a))*Max(v, b)", lambda v: math.exp(-abs(v - a)) * max(v, b), ["0.7", "0.8"]),
    ("Abs(Abs(v - 1) - 0.5)", lambda v: abs(abs(v - 1) - 0.5), ["0.5", "1", "1.5"]),
    ("||v| - w|*|a|", lambda v: a * abs(v - w), ["1.3"]),
    ("mu_s*sign(v - a)*sign(-3) + v", lambda v: v - math.copysign(mu_s, v - a), ["0.7"]),
    ("Min(1, v_b/v)", lambda v: min(1, v_b / v), ["0.9"]),
    ("Min(Max(a - b*v, 0), mu_s)", lambda v: min(max(a - b * v, 0), mu_s), None),
    ("Min(a*v, b, mu_s + 0.1*b)", lambda v: min(a * v, b, mu_s + 0.1 * b), None),
    ("Max(mu_m, mu_s*exp(-v/w))", lambda v: max(mu_m, mu_s * math.exp(-v / w)), None),
    ("Max(mu_m, mu_s - b*log(1 + v/w))", lambda v: max(mu_m, mu_s - b * math.log(1 + v / w)), None),
    ("Min(a*v**(1/3), mu_s)", lambda v: min(a * v ** (1 / 3), mu_s), None),
    ("Max(b - a*v^p, mu_m)", lambda v: max(b - a * v**p, mu_m), None),
    ("Max(a*v^2 - b, mu_s - b)", lambda v: max(a * v**2 - b, mu_s - b), None),
    ("Max(a*v^2, mu_m - b)", lambda v: a * v**2, []),
    ("|v^2 - w|", lambda v: abs(v**2 - w), None),
    ("Piecewise((1, v < 0.5), (v, v < 2*a), exp(-v))",
     lambda v: 1 if v < 0.5 else v if v < 2 * a else math.exp(-v), ["0.5", "1.4"]),
    ("Piecewise((1, v < b), (5, v < a), v)", lambda v: 1 if v < b else v, ["0.7", "0.8"]),
    ("Piecewise((v, v < a), (v, v < b), 2)", lambda v: v if v < b else 2, ["0.8"]),
    ("Piecewise((v, v < b), (v, v < a), 2)", lambda v: v if v < b else 2, ["0.8"]),
    ("Piecewise((9, v < -1), (9, v < 0), v)", lambda v: v, []),
    ("Piecewise((a*v, v >= b), (Piecewise((mu_m, v < w), mu_s), v < w), mu_m)",
     lambda v: a * v if v >= b else mu_m, ["0.8"]),
    ("Piecewise((v, v < 1), log(v - 0.99))", lambda v: v if v < 1 else math.log(v - 0.99), ["1"]),
    ("Piecewise((sin(pi*v), v < pi/3), v)", lambda v: math.sin(math.pi * v) if v < math.pi / 3 else v, None),
    ("Piecewise((a*(1 - exp(-3)), v < 0.5), (b*Abs(v - 1), True))",
     lambda v: a * (1 - math.exp(-3)) if v < 0.5 else b * abs(v - 1), ["0.5", "1"]),
]  # fmt: skip
"""A formula with kinks or jumps, its function, and where its kinks are."""


@pytest.mark.parametrize(("text", "function", "kinks"), [*((*one, None) for one in TYPED), *KINKED])
def test_a_formula_means_its_function(text, function, kinks):
    law = law_of(text)
    assert law.mu(SPEEDS) == pytest.approx(list(map(function, SPEEDS)), rel=3e-12, abs=1e-15)
    assert law.mu(0.3) == pytest.approx(function(0.3), rel=1e-14)
    for tampered in (1.001 * SPEEDS, SPEEDS + 1e-3):
        assert law.mu(SPEEDS) != pytest.approx(list(map(function, tampered)), rel=3e-12, abs=1e-15)
    inner, step = SPEEDS[1:-1], 1e-7
    numerical = [(function(v + step) - function(v - step)) / (2 * step) for v in inner]
    assert law.slope(inner) == pytest.approx(numerical, rel=1e-6, abs=1e-6)
    assert kinks is None or law.kinks() == [sp.Rational(place) for place in kinks]
    for term in sp.Add.make_args(law.expr):  # what later algebra may rely on
        assert len([node for node in term.atoms(sp.Piecewise) if node.has(symbols.v)]) <= 1
    for node in law.expr.atoms(sp.Piecewise):
        assert all(condition.lts == symbols.v for _, condition in node.args[:-1])
        assert not any(branch.has(sp.Piecewise) for branch, _ in node.args)


SAME = [
    ("1/(1 + exp(v/w))", "(1 - tanh(v/(2*w)))/2"),
    ("1/cosh(v)", "sech(v)"),
    ("a*(1/tanh(2*v) - 1/(2*v))", "a*coth(2*v) - a/(2*v)"),
    ("1/cosh(v)^2", "1 - tanh(v)^2"),
    ("exp(-p*log(1 + v))", "(1 + v)^(-p)"),
    ("2^(-v/w)", "exp(-v*log(2)/w)"),
    ("exp(-2*v)*cosh(v)", "(exp(-v) + exp(-3*v))/2"),
    ("log(1 + w/v)", "log(1 + v/w) - log(v) + log(w)"),
    ("tanh(log(v))", "(v^2 - 1)/(v^2 + 1)"),
    ("Min(1, w/v)", "Piecewise((1, v < w), w/v)"),
    ("1/(5*v + 5)", "0.2/(1 + v)"),
    ("1/tanh(v + a)", "coth(v + a)"),
    ("sin(pi/6)*v", "v/2"),
    ("ln(1 + v)*arctan(v) + arcsinh(v)", "log(1 + v)*atan(v) + asinh(v)"),
    ("|v - a|*min(v, b)", "Abs(v - a)*Min(v, b)"),
    ("abs(v - a) + max(v, b) - sgn(v - w)", "Abs(v - a) + Max(v, b) - sign(v - w)"),
    ("Piecewise((1/cosh(v), v < a), exp(-p*log(1 + v)))", "Piecewise((sech(v), v < a), (1 + v)^(-p))"),
]


@pytest.mark.parametrize(("spelling", "other"), SAME)
def test_spellings_have_one_normal_form(spelling, other):
    first, second = (ss.FrictionLaw(text).expr for text in (spelling, other))
    assert first == second or sp.expand(first - second) == 0


@pytest.mark.parametrize("formula", ["1/cosh(v)^4", "tanh(v)", "1/(1 + exp(v))", "v*(1 - tanh(v)^2)"])
def test_a_slope_keeps_its_digits_far_out(formula):
    law = ss.FrictionLaw(formula)
    with mpmath.workdps(120):
        for speed in (0.3, 10.0, 40.0):
            assert law.slope(speed) == pytest.approx(float(mpmath.diff(law.function("mpmath"), speed)), rel=1e-13)


def test_chains_of_conditions_hold_in_the_order_in_which_they_stand():
    """Pieces of random bounds, either way round, against the first condition that is true."""
    rng = np.random.default_rng(SEED)
    relations = {"<": np.less, "<=": np.less_equal, ">": np.greater, ">=": np.greater_equal}
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
            i = next((i for i, sign in enumerate(signs) if relations[sign](v, float(places[i]))), count)
            assert mu == pytest.approx(i + 1 + i * v, rel=1e-14), (inner, v)


def test_a_law_at_its_jump_is_the_piece_above_it_however_the_condition_reads():
    laws = [ss.FrictionLaw(f"Piecewise((0.5, v {relation} 1), (0.3, True))") for relation in ("<", "<=")]
    assert laws[0] == laws[1]
    assert laws[0].mu([np.nextafter(1, 0), 1, np.nextafter(1, 2)]).tolist() == [0.5, 0.3, 0.3]


def test_sympy_gives_the_law_of_the_text():
    a, b, v = sp.symbols("a b v", positive=True)
    for expr, text in (
        (sp.erfc(v / a) + 0.5, "erfc(v/a) + 1/2"), (b * sp.sign(v - a), "b*sign(v - a)"),
        (sp.Abs(v - a) * sp.E, "Abs(v - a)*exp(1)"), (sp.Max(a, b) - sp.Min(v, a), "Max(a, b) - Min(v, a)"),
        (sp.Piecewise((v, a >= v), (b, True)), "Piecewise((v, v <= a), b)"),
        (sp.Piecewise((a, v < 1), (b, v < 2), (v * sp.pi, True)), "Piecewise((a, v < 1), (b, v < 2), v*pi)"),
    ):  # fmt: skip
        assert ss.FrictionLaw(expr).expr == ss.FrictionLaw(text).expr


@mpmath.workdps(15)
def test_numbers_under_roots_are_not_expanded():
    law = ss.FrictionLaw("0.12 + 0.3*exp(-(v/0.0788816)^1.4144337)")
    sizes = fold(law.expr, lambda node, parts: max(parts, default=0) if parts else len(str(node)))
    assert sizes < 20
    assert ss.FrictionLaw(law.text).expr == law.expr
    assert "0.0788816" in ss.FrictionLaw("0.5 - 0.0788816*v").text
    assert ss.FrictionLaw("0.5 - 0.3*exp(-v/0.0788816)").text == "1/2 - 3*exp(-v/0.0788816)/10"
    fitted = ss.FrictionLaw("0.2 + 0.3*exp(-(v/2.1674688334945524)^2.46)")  # 401 digits under a root of 50
    assert len(fitted.text) < 90
    for backend in ("math", "numpy", "mpmath"):
        expected = 0.2 + 0.3 * math.exp(-((0.1 / 2.1674688334945524) ** 2.46))
        assert fitted.function(backend)(0.1) == pytest.approx(expected)
