"""What formulas tend to at rest and far out, against their values there with hundreds of digits."""

import mpmath
import pytest
import sympy as sp
from flint import acb

import stickslip_sym as ss
from stickslip_sym.core import symbols
from stickslip_sym.core.functions import elementary
from stickslip_sym.formula.evaluation.generalised_series import expanded
from stickslip_sym.model.expression.slope import slope_of
from stickslip_sym.model.leading_terms import LeadingTerms, ask_leading_terms, symbolic_limit_at_rest
from stickslip_sym.model.taylor_model import taylor_model
from stickslip_sym.numerics.known import Unknown
from support.sweeps import sample

v = symbols.v
DIGITS = 400
NEAR = 60  # decimal orders from 1 m/s to what counts as rest, and as far out
FINITE_TOGETHER = (
    "(1-exp(-v/w))*w/v", "a+b*(1-cos(v/w))*(w/v)^2", "(v/w)/(exp(v/w)-1)", "a*(sqrt(1+v/w)-1)*w/v",
    "log(1+v/w)*w/v", "(exp(-v/w)-exp(-2*v/w))*w/v", "w/v-1/sinh(v/w)", "a*(1/tanh(v/w)-w/v)*w/v",
    "(v/sin(v)-1)/v^2", "(1-v^2/2-cos(v))/v^4", "a*(1-exp(-(v/w)^p))*(w/v)^p", "(log(1+v)-v+v^2/2)/v^3",
    "a*(sqrt(v^2+w^2)-w)/v", "(1-exp(-sqrt(v)))/sqrt(v)", "a*erf(v/w)*w/v", "a*v/(1-exp(-v/w))*exp(-v/w)",
)  # fmt: skip
OTHERS = (
    "a*v^p/(v^p+b)", "a*v*sinh(w/v)", "a+b*exp(-w/v)", "a+b*v*exp(-w/v)", "a*exp(-log(v/w)^2)", "a/(1+log(v/w)^2)",
    "a-b/log(v/w)", "a*tanh(w/v)", "a*atan(w/v)", "a*v*log(1+w/v)", "v^v", "a*(1+v)^(1/v)", "a*v*cos(w/v)",
    "exp((v/w)^2)*erfc(v/w)", "a*sqrt(v^2+w^2)-b*v", "a*log(v/w)^2", "a*asinh(w/v)", "a*exp(-(v/w)^2+v)*v",
    "a+b*log(log(2+v))", "(v-a)/(v+b)", "a*exp(-sqrt(v/w))*v^(1/3)", "log(1+exp(v/w))-v/w", "a*csch(v)*v",
    "a*v*erfc(w/v)",
)  # fmt: skip
UNKNOWN = {
    ("(v/sin(v)-1)/v^2", True, "mu"), ("(v/sin(v)-1)/v^2", True, "slope"),  # poles
    ("a*v*cos(w/v)", False, "slope"),  # it oscillates
    ("a+b*log(log(2+v))", True, "mu"),  # no rule
}  # fmt: skip


def written(text):
    """Return a formula in letters, and values for them."""
    law = ss.FrictionLaw(text.replace("csch(v)", "1/sinh(v)"))
    letters = [parameter.symbol for parameter in law.parameters.values()]
    return law.expr, {letter: sp.Rational(3 + 2 * k, 7) for k, letter in enumerate(letters)}


def value_at(expr, point, decades):
    """Return the value 10^decades m/s from rest, computed so precisely that nothing that cancels matters."""
    with mpmath.workdps(DIGITS):
        return sp.lambdify(v, elementary(expr).xreplace(point), "mpmath")(mpmath.mpf(10) ** decades)


@sample(13)
@pytest.mark.parametrize("far", [False, True])
@pytest.mark.parametrize("text", [*FINITE_TOGETHER, *OTHERS])
def test_limits_are_what_values_tend_to(text, far):
    mu, point = written(text)
    for name, expr in {"mu": mu, "slope": slope_of(mu)}.items():
        limit = ask_leading_terms(expr, LeadingTerms.limit, point, far=far)
        if (text, far, name) in UNKNOWN:
            assert isinstance(limit, Unknown)
            continue
        near, nearer = (value_at(expr, point, times * (NEAR if far else -NEAR)) for times in (1, 2))
        with mpmath.workdps(DIGITS):
            if limit.is_infinite:
                assert abs(nearer) > abs(near)
                assert (nearer > 0) == (limit > 0)
            else:
                off = abs(nearer - mpmath.mpf(str(sp.N(limit.xreplace(point), 30))))
                assert off <= 1e-15 or off < 0.8 * abs(near - nearer) * 4  # a logarithm is slow: 1/120 for 1/60


@sample(8)
@pytest.mark.parametrize("text", FINITE_TOGETHER)
def test_what_is_finite_together_has_one_value_in_all_three_series(text):
    mu, point = written(text)
    limit = symbolic_limit_at_rest(mu, point)
    assert limit.is_finite
    assert limit == symbolic_limit_at_rest(mu)  # in letters as with values
    value = float(limit.xreplace(point))
    unit = sp.Rational(1, 7) if "^p" in text else sp.Rational(1, 2)
    assert float(expanded(mu, point, int(1 / unit) ** 2, far=False).terms.get((0, 0), 0)) == pytest.approx(
        value, rel=1e-14
    )
    model = taylor_model(mu, point)
    assert model is None or float(model.ball(acb(0), False).real) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize("text", ["cos(1/v)", "a*sin(w/v)*v+cos(w/v)", "log(log(1/v))*a+v"])
def test_what_has_no_limit_or_no_rule_is_unknown(text):
    mu, point = written(text)
    assert isinstance(symbolic_limit_at_rest(mu, point), Unknown)


def test_values_of_letters_decide_what_cancels():
    mu = (sp.Symbol("a", positive=True) * sp.exp(-v) - 1) / v
    (a,) = mu.free_symbols - {v}
    limits = [symbolic_limit_at_rest(mu, {a: sp.Rational(k, 2)}).xreplace({a: 1}) for k in (1, 2, 3)]
    assert limits == [-sp.oo, -1, sp.oo]
    assert isinstance(symbolic_limit_at_rest(mu), Unknown)
