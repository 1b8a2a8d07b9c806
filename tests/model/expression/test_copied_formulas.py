"""Formulas are read as they stand in a paper, in MATLAB and in SymPy."""

import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym.output import printing

v, a = sp.symbols("v a")

COPIED = [
    (r"$\mu_{d} + (\mu_{s} - \mu_{d}) \mathrm{e}^{-\left(\frac{v}{v_{s}}\right)^{2}}$",
     "mu_d + (mu_s - mu_d)*exp(-(v/v_s)^2)"),
    (r"\mu(v) = \mu_{\mathrm{m}} + \frac{\mu_{\mathrm{s}} - \mu_{\mathrm{m}}}{1 + v/v_{\text{s}}}",
     "mu_m + (mu_s - mu_m)/(1 + v/v_s)"),
    ("@(v) mu_d + (mu_s - mu_d).*exp(-(v./v_s).^2);", "mu_d + (mu_s - mu_d)*exp(-(v/v_s)^2)"),
    ("lambda v: 0.2 + 0.1*exp(-v)", "0.2 + 0.1*exp(-v)"),
    (r"\mu_0 - a \left|v\right|", "mu_0 - a*v"),
    (r"\lambda v", "lambda_*v"),
    (r"\alpha (v+1) + v_{s}(v + 1)^2", "alpha*(v + 1) + v_s*(v + 1)^2"),
    (r"\tanh^{2}(v) + \sqrt[3]{v} + \sqrt{1 + v}", "tanh(v)^2 + v^(1/3) + sqrt(1 + v)"),
    (r"a \,\exp\bigl[-\alpha \times v\bigr] - \dfrac{v}{2}", "a*exp(-alpha*v) - v/2"),
    (r"\operatorname{arsinh}\left(\frac{v}{2 v_{c}}\right)", "asinh(v/(2*v_c))"),
    ("0.3 - 0.1*arcsin(v/4) + acos(v/5)", "0.3 - 0.1*asin(v/4) + acos(v/5)"),
    ("a*Heaviside(v - 1)", "Piecewise((0, v < 1), (a, True))"),
    ("1e-300 + 2.5e+10*v + 1e300*v^2", f"1/1{300 * '0'} + 25000000000*v + 1{300 * '0'}*v^2"),
    ("2.*v./3", "2*v/3"),
]  # fmt: skip
"""A text, and the same in plain names."""


@pytest.mark.parametrize(("copied", "plain"), COPIED)
def test_a_copied_formula_is_read(copied, plain):
    copied, plain = ss.FrictionLaw(copied), ss.FrictionLaw(plain)
    for speed in (sp.Rational(1, 3), sp.Rational(7, 3)):
        values = {"v": speed} | {name: sp.Rational(n + 2, 7) for n, name in enumerate(sorted(plain.parameters))}
        left, right = (
            law.expr.subs({symbol: values[symbol.name] for symbol in law.expr.free_symbols})
            for law in (copied, plain)
        )
        assert abs(sp.N(left - right, 30)) < sp.Rational(1, 10**25) * (1 + abs(sp.N(right)))


@pytest.mark.parametrize("name", list(ss.laws))
def test_the_latex_of_a_law_reads_back(name):
    law = ss.laws[name]
    read = ss.FrictionLaw(printing.latex(law.expr))
    same = {symbol: law.parameters[symbol.name].symbol for symbol in read.expr.free_symbols - {ss.symbols.v}}
    assert sp.simplify(read.expr.xreplace(same) - law.expr) == 0


@pytest.mark.parametrize(
    ("expr", "text"),
    [(sp.Abs(sp.exp(-v)), "exp(-v)"), (sp.Symbol("lambda") * v, "lambda_*v"), (sp.asin(v / 4), "asin(v/4)"),
     (sp.sinc(v), "sin(v)/v")],
)  # fmt: skip
def test_expressions_of_plain_symbols_are_read(expr, text):
    assert ss.FrictionLaw(expr).text == text


@pytest.mark.parametrize(
    ("text", "position"),
    [(r"\foo{v}", 1), (r"1 + \frac{v}", 5), (r"1 + \frac12 v", 5), (r"v + \sqrt[0]{v}", 5), (r"\tanh^2 v", 1),
     ("0.2; 0.3", 4), ("a @(v) v", 3)],
)  # fmt: skip
def test_what_is_not_read_is_pointed_at(text, position):
    with pytest.raises(ss.InputError, match=rf"\(character {position}\)"):
        ss.FrictionLaw(text)
