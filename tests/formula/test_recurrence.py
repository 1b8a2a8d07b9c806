"""Harmonic averages are proved, and nothing false is."""

import random

import pytest
import sympy as sp
from forms import some

import stickslip_sym as ss
from stickslip_sym.formula.average import average_of
from stickslip_sym.formula.finding import rules
from stickslip_sym.formula.finding.harmonics import harmonic_average
from stickslip_sym.formula.proof import recurrence
from stickslip_sym.formula.proof.recurrence import AverageSeries, prove_average
from stickslip_sym.model.terms import grouped

u, V, HARMONIC = ss.symbols.v, ss.symbols.V, ss.criteria.harmonic
p, q = sp.symbols("p q", positive=True)
SLIGHTLY = 1 + sp.Rational(1, 10**30)

FAMILIES = {
    "a power": lambda a, b, c: u ** int(7 * a),
    "a broken power": lambda a, b, c: u ** (a + sp.Rational(1, 13)),
    "a pole": lambda a, b, c: (a + u) / (u + b) ** 3,
    "imaginary poles": lambda a, b, c: (a * u + b) / (u**2 + c**2),
    "a quadratic that dips": lambda a, b, c: (a * u + b) / (u**2 - c * u + c**2),
    "real roots": lambda a, b, c: 1 / (u**2 + (a + b) * u + a * b),
    "an exponential": lambda a, b, c: u**2 * sp.exp(-a * u + b),
    "a sine": lambda a, b, c: u * sp.sin(a * u + b),
    "a logarithm": lambda a, b, c: u * sp.log(a * u + b),
    "an arctangent": lambda a, b, c: sp.atan(a * u - b),
    "a logarithm of a quadratic": lambda a, b, c: sp.log((u + b) ** 2 + c**2),
    "an inverse hyperbolic sine": lambda a, b, c: sp.asinh(a * u),
    "a root": lambda a, b, c: sp.sqrt(a * u + b),
    "a power of a line": lambda a, b, c: (a * u + b) ** (c + sp.Rational(1, 13)),
    "an error function": lambda a, b, c: sp.erf(a * u),
    "a Gaussian": lambda a, b, c: u * sp.exp(-a * u**2),
}


def average(term):
    """Return H[term] by its rule."""
    return harmonic_average(term, u, V)[1]


@pytest.mark.parametrize("name", FAMILIES)
def test_random_members_are_proved_and_one_a_little_off_is_not(name):
    rng = random.Random(name)
    numbers = [sp.Rational(rng.randint(1, 20), 7) for _ in range(3)]
    (term,) = [rest for rest in grouped(FAMILIES[name](*numbers), u) if rest.has(u)][-1:]
    prove_average(term, average(term), HARMONIC)
    with pytest.raises(ValueError, match="not known"):
        prove_average(term, SLIGHTLY * average(term), HARMONIC)


s = ss.symbols.s
EARLY = ss.Criterion("early", sp.Rational(3, 4) * (1 - s**2) * (1 - s))
POLYNOMIAL = [
    sp.exp(-u),
    1 / (1 + u**2),
    sp.atan(u),
    sp.asinh(u),
    sp.exp(-(u**2)),
    (1 + u**8) ** sp.Rational(-1, 8),
]


@pytest.mark.parametrize("criterion", [ss.criteria.least_squares, EARLY], ids=lambda one: one.name)
@pytest.mark.parametrize("term", POLYNOMIAL, ids=str)
def test_a_polynomial_weight_is_served_too(term, criterion):
    """Also a user's, that is not symmetric; what is found by antiderivatives is proved without them."""
    value = average_of(term, criterion).find()
    prove_average(term, value, criterion)
    for wrong in (SLIGHTLY * value, value + V**30 / 10**20, value.subs(V, SLIGHTLY * V)):
        with pytest.raises(ValueError, match="not known"):
            prove_average(term, wrong, criterion)


BINOMIAL = ["a/(1 + (v/w)^4)", "a*(1 + (v/w)^8)^(-1/8)", "a/sqrt(1 + (v/w)^2)"]


@pytest.mark.parametrize(
    ("text", "criterion"), some([(text, way) for text in BINOMIAL for way in ("least_squares", "harmonic")], 0, 5)
)
def test_laws_with_a_binomial_have_closed_forms(text, criterion):
    form = ss.derive(text, criterion)
    assert form.verdict.status is ss.Status.PROVED
    law = form.law.bind(a="0.3", w="0.7")
    expected = float(ss.enclose(law, criterion, V="0.5", N=2, digits=18))
    assert form(V=0.5, N=2.0, a=0.3, w=0.7) == pytest.approx(expected, rel=1e-13)
    assert float(form.evaluate(20, V="0.5", N=2, a="0.3", w="0.7")) == pytest.approx(expected, rel=1e-14)


def test_the_step_says_why():
    form = ss.derive(ss.laws.exponential, "harmonic", search=False)
    (step,) = [step for step in form.derivation.steps if step.statement.rhs.has(sp.besseli)][:1]
    assert step.verdict.status is form.verdict.status is ss.Status.PROVED
    assert "differential equation" in step.reason


def of_bessel(order, rate, shift=1):
    return 2 / V * sp.exp(-p * V * shift) * sp.besseli(order, rate * V)


def root_of(length):
    root = sp.sqrt(p * (p + length))
    return 2 / (root * (root + p + V))


GAUSSIAN = average(sp.exp(-((u / p) ** 2)))
JUMP = sp.atan(V - 1) + sp.atan(1 / (V - 1)) + sp.pi / 2  # 0 for V < 1, and pi above
TAMPERED = {
    "another order of the Bessel function": (sp.exp(-p * u), of_bessel(0, p)),
    "another argument of it": (sp.exp(-p * u), of_bessel(1, p * SLIGHTLY)),
    "another exponent": (sp.exp(-p * u), of_bessel(1, p, SLIGHTLY)),
    "a sign": (sp.exp(-p * u), -of_bessel(1, p)),
    "a sign under a root": (1 / (u + p), root_of(-2 * V)),
    "a factor under a root": (1 / (u + p), root_of(2 * V * SLIGHTLY)),
    "a term of high order": (1 / (u + p), root_of(2 * V) + V**40 / 10**30),
    "a term of high order in the logarithm": (sp.log(u + p), average(sp.log(u + p)) + V**40 / p**41),
    "a parameter of the series": (
        sp.exp(-((u / p) ** 2)),
        GAUSSIAN.replace(sp.hyper, lambda a, b, z: sp.hyper(a, (b[0] * SLIGHTLY, b[1]), z)),
    ),
    "a width": (sp.atan(u / p), average(sp.atan(u / (p * SLIGHTLY)))),
    "a modulus": (
        sp.asinh(u / p),
        average(sp.asinh(u / p)).replace(sp.elliptic_e, lambda m: sp.elliptic_e(m * SLIGHTLY)),
    ),
    "a function that jumps": (u, -1 + JUMP),
    "a root that changes its sign": (u, -sp.sqrt(1 - 2 * V + V**2) / (1 - V)),
    "a pole in V": (u**0, 1 / V),
    "a pole on the way": (1 / (u - 1), average(1 / (u + p)).subs(p, -1)),
    "a kink on the way": (sp.sqrt(u**2 - 2 * u + 1), sp.Integer(1)),
    "a power that has no average": (u ** sp.Rational(-3, 4), average(sp.sqrt(u)) / V),
    "a parameter for another": (1 / (u + p), root_of(2 * V).subs(p, q)),
}


@pytest.mark.parametrize("name", TAMPERED)
def test_nothing_false_is_proved(name):
    with pytest.raises(ValueError, match=r"not known|not integrable|too many"):
        prove_average(*TAMPERED[name], HARMONIC)


def test_each_hypothesis_is_needed(monkeypatch):
    """Without its check, something false would be proved."""
    term = 1 / (u + p)
    first = sp.series(average(term), V, 0, 6).removeO()
    begins = (term, first)  # the same coefficients, another equation
    satisfies = (sp.exp(-p * u), SLIGHTLY * of_bessel(1, p))  # the same equation, other coefficients
    turns = (sp.exp(-p * u), of_bessel(1, p) * sp.sqrt(1 - 2 * V + V**2) / (1 - V))  # both, but false for V > 1
    for check, false in (
        ("_require_equation", begins),
        ("_require_same_start", satisfies),
        ("_require_real_analytic", turns),
    ):
        with pytest.raises(ValueError, match="not known"):
            prove_average(*false, HARMONIC)
        with monkeypatch.context() as patched:
            patched.setattr(recurrence, check, lambda *_: None)
            prove_average(*false, HARMONIC)


def test_one_coefficient_too_few_would_not_do(monkeypatch):
    """Counted one short, the equation leaves a term over that was not compared."""
    term = u**3
    right = average(term)
    prove_average(term, right, HARMONIC)
    counted = recurrence._fixed_from
    with monkeypatch.context() as patched:
        patched.setattr(recurrence, "_fixed_from", lambda *args: counted(*args) - 1)
        with pytest.raises(ValueError, match="differential equation"):
            prove_average(term, right, HARMONIC)


def test_the_integral_must_be_that_of_the_term():
    theta = ss.symbols.theta
    kernel = 2 * sp.cos(theta) / (sp.pi * V)
    term = sp.exp(-p * u)
    theorem = AverageSeries(term, HARMONIC, q, average(term))
    integrand = q * term.subs(u, V * (1 - sp.cos(theta))) * kernel
    assert theorem(sp.Integral(integrand, (theta, 0, sp.pi))) == q * average(term)
    for wrong, high in ((2 * integrand, sp.pi), (integrand, 2 * sp.pi), (integrand.subs(p, 2 * p), sp.pi)):
        with pytest.raises(ValueError, match="not the average of the term"):
            theorem(sp.Integral(wrong, (theta, 0, high)))


@pytest.mark.parametrize("off", [-1, 1 + sp.Rational(1, 10**25)])
def test_a_tampered_rule_is_refuted(off, fresh_averages, monkeypatch):
    found = rules.harmonic_average

    def tampered(*args):
        rule, value = found(*args)
        return rule, off * value

    monkeypatch.setattr(rules, "harmonic_average", tampered)
    with pytest.raises(ss.NoClosedForm, match="refuted"):
        ss.derive(ss.laws.exponential, "harmonic", search=False)


def test_what_is_not_proved_says_why():
    form = ss.derive(ss.FrictionLaw("mu_0 - b*v*sqrt(v + w)"), "harmonic", search=False)
    assert form.verdict.status is ss.Status.CHECKED
    (why,) = [step.verdict.evidence for step in form.derivation.steps if step.verdict.status is ss.Status.CHECKED]
    assert "digits at 12 seeded points; " in why
    assert "is not known to" in why
