"""Quadrature of the definition: against integrals known by hand, and its refusals."""

import mpmath
import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym.criteria import quadrature
from support.sweeps import sample, sweep


def beta_integral(V):
    """(5/2) * integral of sqrt(u) (1 - u)^3 over [0, 2], by powers."""
    moments = [mpmath.mpf(2) ** (n + 1.5) / (n + 1.5) for n in range(4)]
    return 2.5 * (moments[0] - 3 * moments[1] + 3 * moments[2] - moments[3]) * V**-0.5


def of_bessel(V):
    return mpmath.mpf(2) / 5 * mpmath.exp(-3 * V) * mpmath.besseli(1, 3 * V) / V


KNOWN = [
    *(("0.5 - v/7", criterion, "0.3", lambda V: mpmath.mpf(1) / 7) for criterion in ss.criteria.catalogue),
    ("1 + v^3", "least_squares", "1.5", lambda V: -mpmath.mpf(26) / 7 * V**2),  # <(1 + s)^2> = 1 + 5/21
    ("sqrt(v)", "least_squares", "1", beta_integral),
    ("1 - tanh(100*v)", "equilibrium", "0.5", lambda V: 100 / mpmath.cosh(100 * V) ** 2),
    *(("0.2*exp(-3*v)", "harmonic", V, of_bessel)
      for V in ("1e-6", "1", "50")),
]  # fmt: skip


@sample(4)
@pytest.mark.parametrize(("text", "criterion", "V", "exact"), KNOWN)
def test_values_that_are_known_by_hand(text, criterion, V, exact):
    for digits in (15, 40):
        got = ss.quadrature.damping(text, criterion, V=V, N=2, digits=digits)
        with mpmath.workdps(60):
            expected = 2 * exact(mpmath.mpf(V))
            assert abs(got - expected) <= abs(expected) * mpmath.mpf(10) ** (1 - digits)


@pytest.mark.parametrize("V", ["1e-30", "1e-8", "1e3", "1e6"])
def test_extremes_of_the_exponential_law(V):
    """Small speeds cancel, large ones hide all of the integrand in a layer; both limits are known."""
    got = ss.quadrature.damping(ss.laws.exponential.typical(), V=V, N=1, digits=20)
    expected = 0.9 if float(V) < 1 else 2.5 * 0.3 / (3 * float(V) ** 2)
    assert float(got) == pytest.approx(expected, rel=max(3 * float(V), 1e-15) if float(V) < 1 else 2 / float(V))


def test_constant_law_and_no_load():
    assert ss.quadrature.damping(ss.FrictionLaw("mu_k").bind(mu_k=0.3), V=1, N=1) == 0
    assert ss.quadrature.damping(ss.laws.exponential.typical(), V=1, N=0) == 0


@pytest.mark.parametrize(("orders", "is_followed"), [(380, True), (420, False)])
def test_digits_that_cancel_are_followed_as_far_as_is_said(orders, is_followed):
    """A slope of 1e-380 below a coefficient of 1 is found; one of over 400 orders counts as 0."""
    law = ss.FrictionLaw("1 - a*v").bind(a=f"1e-{orders}")
    found = ss.quadrature.damping(law, V=1, N=1, digits=5)
    if is_followed:
        assert abs(found * mpmath.mpf(10) ** orders - 1) < 1e-4
    else:
        assert found == 0


def test_as_many_digits_as_is_said():
    law = ss.FrictionLaw("0.3")
    assert ss.quadrature.damping(law, V=1, N=1, digits=10_000) == 0
    with pytest.raises(ss.InputError, match="outside 1 to 10000"):
        ss.quadrature.damping(law, V=1, N=1, digits=10_001)


@sweep("text", ["0.3 + log(v - 0.2)", "0.3/(v - 0.3)", "sqrt(v - 0.1)"], "0.3 + log(v - 0.2)", "sqrt(v - 0.1)")
def test_a_law_without_real_values_is_refused(text):
    with pytest.raises(ss.InputError, match="not a finite real number at v = "):
        ss.quadrature.damping(ss.FrictionLaw(text), V="0.5", N=1, digits=15)


def test_refusals():
    law = ss.laws.exponential
    for message, arguments in {
        "no value for mu_s, mu_m, alpha": {"law": law},
        "V = 0 must be positive": {"V": 0},
        "N = -1 must not be negative": {"N": -1},
        "V = nan is not a finite": {"V": float("nan")},
        "digits = 0": {"digits": 0},
    }.items():
        for value_of in (ss.quadrature.damping, ss.enclose):
            with pytest.raises(ss.InputError, match=message):
                value_of(**{"law": law.typical(), "V": 1, "N": 1} | arguments)


def test_too_irregular_an_integrand_is_an_error(monkeypatch):
    monkeypatch.setattr(ss.quadrature, "MOST_INTERVALS", 2)
    with pytest.raises(ss.NotConverged, match="did not reach"):
        ss.quadrature.damping(ss.FrictionLaw("sin(1000000*v)*exp(-v)"), V=1000, N=1, digits=15)


@pytest.mark.parametrize("digits", [5, 10, 30])
@pytest.mark.parametrize("enough", [0, 60, 100, 300])
def test_a_second_look_confirms_a_slope(digits, enough):
    """Of a formula that loses digits inside: below so many its slope at v = 0.5 is wrong, unseen."""

    def mu(v):
        digits_now = v.context.dps  # quadrature computes in a context of its own
        return 1 - v + ((v - 0.5) / digits_now if digits_now < enough else 0)

    found = quadrature.average(mu, [], ss.criteria.equilibrium, sp.Rational(1, 2), digits)
    assert abs(found - 1) <= mpmath.mpf(10) ** -digits


@sweep(("height", "width", "place"), [(3.1e-7, 5.5e-3, 1.39), (9e-8, 4e-3, 1.18)], (9e-8, 4e-3, 1.18))
def test_low_narrow_bumps_have_all_digits(height, width, place):
    """Nearly all of mu cancels, and the rule must still see the bump: tolerance and work follow what is lost."""
    speeds = []

    def mu(v):
        speeds.append(v)
        return 0.5 + height / (1 + ((v - place) / width) ** 2)

    def damping(digits):
        return quadrature.average(mu, [], ss.criteria.least_squares, sp.Integer(1), digits)

    law = f"0.5 + {height!r}/(1 + ((v - {place!r})/{width!r})^2)"
    exact = float(ss.enclose(law, "least_squares", V=1, N=1, digits=12))
    assert abs(damping(8) / exact - 1) <= 1e-8
    assert len(speeds) < 20_000  # ten times as many where no digits are in hand


@sample(1)
@sweep(
    ("sharpness", "V", "digits"),
    [("54", "8.12", 8), ("54", "8.12", 25), ("200", "0.6", 8), ("200", "0.6", 25)],
    ("54", "8.12", 8), ("200", "0.6", 25),
)  # fmt: skip
def test_a_narrow_peak_is_not_stepped_over(sharpness, V, digits):
    """All degrees of a tanh-sinh rule may miss it, and agree; the reference integrates over log(v)."""
    law = ss.FrictionLaw(f"exp(-({sharpness}*log(v))^2)")
    with mpmath.workdps(40):
        h, speed = mpmath.mpf(sharpness), mpmath.mpf(V)

        def integrand(t):
            u = mpmath.exp(t)
            return mpmath.exp(-((h * t) ** 2)) * 5 * (speed - u) ** 3 / (2 * speed**5) * u

        wanted = mpmath.quad(integrand, [k / h for k in range(-10, 11)])
    assert abs(ss.quadrature.damping(law, V=V, N=1, digits=digits) / wanted - 1) < 10 ** (1 - digits)


@pytest.mark.parametrize("n", ["0.3", "0.9", "0.97", "0.99"])
def test_powers_just_integrable_at_rest(n):
    """The closer the exponent is to -1, the more of the integral lies next to v = 0."""
    value = ss.quadrature.damping(ss.FrictionLaw(f"v^(-{n})"), V=3, N=1, digits=25)
    with mpmath.workdps(30):
        n = mpmath.mpf(n)
        bracket = (n**2 - 3 * n + 8) / ((n - 4) * (n - 3) * (n - 2) * (n - 1))
        assert mpmath.almosteq(value, 5 * n * bracket / (6**n * 3), rel_eps=mpmath.mpf(10) ** -24)


@pytest.mark.parametrize("formula", ["log(1 + v)", "sqrt(v)", "log((1e-30 + v)/(1 + v))", "v^0.3 - v^0.2"])
@mpmath.workdps(30)
def test_the_slope_at_one_speed_at_every_scale(formula):
    """Steps in proportion to the speed; what is below all digits at first is no slope of 0."""
    for exponent in (-200, -40, -32, -9, 0, 9, 30):
        at = {"V": f"1e{exponent}", "N": 1}
        slope = ss.quadrature.damping(formula, "equilibrium", **at, digits=20)
        assert slope == pytest.approx(mpmath.mpf(float(ss.enclose(formula, "equilibrium", **at))), rel=1e-15)
