"""A law is the sum of its terms, each an amplitude times a profile over a scale."""

import random
from dataclasses import replace

import mpmath
import sympy as sp

import stickslip_sym as ss
from stickslip_sym import symbols
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.model.terms import shapes_of
from support.sweeps import sweep

LAWS = {name: ss.laws.catalogue[name] for name in ss.laws.catalogue} | {
    text: ss.FrictionLaw(text)
    for text in (
        "mu_1*(v/v_1)^(-n)", "a - b*Min(v, v_1) + d*Max(v - v_2, 0)", "a - b*Abs(v - v_1)",
        "Piecewise((a*((v - v_s)/(v_d - v_s))^2, v < v_d), (b, True))", "mu_0 + a*tanh((v + v_1)/w)",
        "exp(-h^2*log(v/v_m)^2)", "(1 + a*v)/(1 + b*v + d*v^2)", "mu_0 + a*v*log(1 + v/v_0)",
        "a*exp(-p*v)*cos(q*v + f)", "mu_s - d*atan((v - v_0)/w)",
        "mu_0 - b*v*sqrt(v + w)", "a*exp(-p*v^d)",
        "a/(1 + (v/v_s)^d)", "a*v^p*exp(-v/q)", "0.2 + 0.3*exp(-(v/0.5)^1.5)*cos(v/9)",
        "(a + b*v)^3*exp(-p*(v + q))",
        "Piecewise((f_0, v < v_w), (f_w + (f_0 - f_w)*v_w/v, True))",
    )
}  # fmt: skip
KINDS = (
    "exponential", "polynomial", "rational", "stribeck", "a - b*Abs(v - v_1)", "mu_0 + a*tanh((v + v_1)/w)",
    "a*exp(-p*v)*cos(q*v + f)", "Piecewise((a*((v - v_s)/(v_d - v_s))^2, v < v_d), (b, True))",
)  # fmt: skip


def values(law, expr):
    """An expression in v and the parameters of a law, to 30 digits at random points."""
    rng = random.Random(str(law.expr))
    arguments = sorted(law.expr.free_symbols, key=str)
    function = function_of(arguments, expr, "mpmath")
    with mpmath.workdps(40):
        points = [[mpmath.mpf(rng.randint(3, 60)) / 13 for _ in arguments] for _ in range(6)]
        return [mpmath.mpmathify(function(*point)) for point in points]


def difference(law, terms):
    """The law less the sum of terms, the largest at random points."""
    columns = [values(law, term.expr) for term in terms]
    with mpmath.workdps(40):
        rows = zip(values(law, law.expr), *columns, strict=True)
        return max(abs(total - mpmath.fsum(row)) for total, *row in rows)


@sweep("name", list(LAWS), *KINDS)
def test_a_law_is_the_sum_of_its_terms(name):
    law = LAWS[name]
    assert difference(law, law.terms) < 1e-25
    for term in law.terms:
        assert term.scale.is_positive
        assert set(shapes_of(term.profile)) == set(term.shapes)
        parameters = {parameter.symbol for parameter in law.parameters.values()}
        assert term.profile.free_symbols - set(term.shapes) <= {symbols.v}
        for meaning in term.shapes.values():
            assert meaning.free_symbols <= parameters
            if law.name == "andersson":  # a ratio of speeds
                in_mm = {symbol: 1000 * symbol for symbol in parameters if symbol.name.startswith("v_")}
                assert sp.simplify(meaning.xreplace(in_mm) - meaning) == 0
        for tampered in (replace(term, amplitude=2 * term.amplitude), replace(term, scale=3 * term.scale)):
            if tampered.expr != term.expr:
                others = [other for other in law.terms if other is not term]
                assert difference(law, [*others, tampered]) > 1e-6


def test_laws_share_their_profiles():
    profiles = {term.profile for law in ss.laws.catalogue.values() for term in law.terms}
    assert len(profiles) <= 21
    first, second = (ss.FrictionLaw(f"mu_0 + a*exp(-(v/{w})^2)*tanh(v/q)").terms[1] for w in ("w_1", "w_2"))
    assert first.profile == second.profile
