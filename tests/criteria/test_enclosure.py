"""Enclosures of criteria hold what quadrature finds, for laws and operating points of all sizes."""

import random
from fractions import Fraction

import mpmath
import pytest
import sympy as sp
from flint import arb
from hypothesis import given
from hypothesis import strategies as st

import stickslip_sym as ss
from stickslip_sym.core.precision import working_precision
from stickslip_sym.criteria import enclosure
from stickslip_sym.criteria.enclosure import Enclosure, enclosure_of, rounded_outward
from support.strategies import nested
from support.sweeps import fewer, sample, sweep

s = ss.symbols.s
CRITERIA = [
    "least_squares", "harmonic", "equilibrium",
    ss.Criterion("parabola", sp.Rational(3, 4) * (1 - s**2), "the tests"),
    ss.Criterion("late", sp.Rational(3, 4) * (1 - s**2) * (1 + s), "the tests"),
    ss.Criterion("flat", sp.Rational(1, 2), "the tests"),
]  # fmt: skip


def quadrature_lies_inside(law, criterion, V, N, digits=20):
    enclosure = ss.enclose(law, criterion, V=V, N=N, digits=digits)
    found = ss.quadrature.damping(law, criterion, V=V, N=N, digits=digits + 8)
    if found == 0 and abs(enclosure.mid) < Fraction(1, 10**300):
        return enclosure  # quadrature does not follow what cancels over 400 digits
    with mpmath.workdps(digits + 8):
        room = abs(found) * mpmath.mpf(10) ** -(digits + 6)
        low, high = (mpmath.mpf(end.numerator) / end.denominator for end in (enclosure.low, enclosure.high))
        assert low - room <= found <= high + room, (law, criterion, V, N)
    return enclosure


@fewer(3)
@given(st.integers(0, 2**32 - 1))
def test_quadrature_lies_in_the_enclosure(seed):
    rng = random.Random(seed)
    law = ss.laws.catalogue[rng.choice(sorted(ss.laws.catalogue))]
    exponents = {node.exp for node in law.expr.atoms(sp.Pow)}
    values = {
        name: f"{float(p.typical) * 10 ** rng.uniform(*((-0.2, 0.2) if p.symbol in exponents else (-2, 2))):.6g}"
        for name, p in law.parameters.items()
    }
    V, N = (f"{10 ** rng.uniform(-6, 6):.6g}" for _ in range(2))
    try:
        enclosure = quadrature_lies_inside(law.bind(**values), rng.choice(CRITERIA), V, N)
    except (ss.NotConverged, ss.InputError):
        return  # quadrature has its limits, and mu may not be real at the operating point
    assert enclosure.radius == 0 or enclosure.digits >= 20 or 0 in enclosure


def by_gauss(law, criterion, V):
    """The definition over an angle, v = V (1 - cos(theta)), by Gauss's rule in 40 digits, and its own error."""
    mu, kernel = law.function("mpmath"), ss.criteria.find(criterion).angle_kernel
    factor = sp.lambdify([ss.symbols.theta, ss.symbols.V], kernel, "mpmath")
    with mpmath.workdps(50):
        speed, places = mpmath.mpf(V), [mpmath.pi * (mpmath.mpf(k) / 12) ** 2 for k in range(13)]
        return mpmath.quad(lambda t: mu(speed * (1 - mpmath.cos(t))) * factor(t, speed), places,
                           method="gauss-legendre", error=True, maxdegree=7)  # fmt: skip


@sweep("count", [4, 300], 4)
def test_functions_within_functions(count):
    rng, looked = random.Random(5), 0
    for _ in range(count):
        law, criterion, V = nested(rng), rng.choice(CRITERIA[:2]), f"{10 ** rng.uniform(-2, 0.5):.4g}"
        value, error = by_gauss(law, criterion, V)
        if error < 1e-38:
            enclosure, looked = ss.enclose(law, criterion, V=V, N=1, digits=45), looked + 1
            assert enclosure.digits >= 45
            with mpmath.workdps(50):
                assert abs(mpmath.mpf(enclosure.mid.numerator) / enclosure.mid.denominator - value) < 1e-38, law
    assert looked > count / 2


@pytest.mark.parametrize(
    ("formula", "V"), [("sqrt(v - 0.2)", "0.15"), ("log(v - 0.2)", "0.15"), ("sqrt((v - 0.1)*(v - 0.2))", "0.15")]
)
@pytest.mark.parametrize("criterion", ["least_squares", "equilibrium"])
def test_a_coefficient_that_is_not_real_is_not_enclosed(formula, V, criterion):
    """Its slope may be real all the same, and its average too."""
    with pytest.raises(ss.NotConverged, match="not enclosed"):
        ss.enclose(f"0.5 + {formula}", criterion, V=V, N=1, digits=5)


@sample(3)
@pytest.mark.parametrize("criterion", CRITERIA, ids=str)
def test_kinks_and_measured_points(criterion):
    points = ss.FrictionLaw.from_samples([0, 0.05, 0.1, 0.2, 0.4, 1.0], [0.50, 0.44, 0.40, 0.34, 0.29, 0.27])
    ramp = ss.FrictionLaw("Max(0.5 - 0.5*v, 0.2)")
    for law, V in ((points, "0.23"), (ramp, "0.45"), (ramp, "0.2")):
        quadrature_lies_inside(law, criterion, V, "9.81")


def test_an_enclosure_states_what_is_certain():
    law = ss.laws.exponential.typical()
    enclosure = ss.enclose(law, V="0.5", N="9.81", digits=40)
    exact = ss.derive(law, search=False).evaluate(digits=60, V="0.5", N="9.81")
    assert str(enclosure).startswith("2.5459496029051")
    assert enclosure.digits >= 40
    assert float(enclosure) == pytest.approx(2.5459496029051, rel=1e-13)
    for inside in (exact, enclosure.mid, enclosure.low, enclosure.high):
        assert inside in enclosure
    with mpmath.workdps(60):
        for outside in (exact * (1 + mpmath.mpf("1e-25")), -exact, enclosure.high + 1):
            assert outside not in enclosure
    assert str(ss.enclose(ss.laws.coulomb.typical(), V=1, N=1)) == "0"


def test_digits_are_those_that_both_ends_share():
    rng = random.Random(5)
    for _ in range(300):
        middle = Fraction(rng.randint(1, 10**12), 10 ** rng.randint(0, 20)) * rng.choice([-1, 1])
        radius = abs(middle) * Fraction(rng.randint(1, 999), 10 ** rng.randint(3, 30))
        enclosure = Enclosure(middle - radius, middle + radius)
        shown = str(enclosure)
        if shown.endswith("[...]"):
            text = shown.removesuffix("[...]")
            mantissa, _, exponent = text.partition("e")
            places = len(mantissa.partition(".")[2])
            unit = Fraction(10) ** (int(exponent or 0) - places)
            assert abs(Fraction(text)) <= min(abs(enclosure.low), abs(enclosure.high))
            assert max(abs(enclosure.low), abs(enclosure.high)) < abs(Fraction(text)) + unit
        assert (radius * 10**enclosure.digits <= abs(middle)) or enclosure.digits == 0


def test_no_ball_at_rest_is_refused_at_once(monkeypatch):
    """Not after hundreds of thousands of values, five seconds of them."""
    taken = []
    made = enclosure.balls_from_rest

    def counted(*arguments):
        function = made(*arguments)

        def counting(z, analytic):
            taken.append(z)
            return function(z, analytic)

        return counting

    monkeypatch.setattr(enclosure, "balls_from_rest", counted)
    texts = ("0.5 - 0.01*log(v/w)", "0.5 - v*log(v/w)", "sqrt(v)*log(v/w)", "w/sqrt(v)", "v^(-w)")
    for text in texts:
        for criterion in ("least_squares", "harmonic"):
            with pytest.raises(ss.NotConverged, match="not enclosed"):
                ss.enclose(ss.FrictionLaw(text).bind(w="0.1"), criterion, V=1, N=1)
    assert len(taken) == 2 * len(texts)
    # Infinite is the slope alone, or no more than each term.
    for text in ("1 - sqrt(v)", "1 - v^(1/3)", "sin(10*v)/v/10"):
        assert ss.enclose(ss.FrictionLaw(text), "harmonic", V=0.5, N=10).digits >= 29


def test_what_is_too_small_is_enclosed_with_zero():
    law = ss.FrictionLaw("a*exp(-(v/w)^5)").bind(a="0.3", w="1e-3")
    enclosure = ss.enclose(law, "equilibrium", V=1000, N=1)
    assert enclosure.low == 0 < enclosure.high < Fraction(1, 10**10_000)
    assert (0 in enclosure, enclosure.digits) == (True, 0)


def test_ends_are_exact_as_far_as_they_can_be_written():
    with working_precision(50):
        for power in (-60_000, 60_000):
            ends = enclosure_of(arb(3) * arb(2) ** power)
            assert ends.low == ends.high == 3 * Fraction(2) ** power
        assert enclosure_of(arb(2) ** -200_000).low == 0
        with pytest.raises(ss.NotConverged, match="too large to be written"):
            enclosure_of(arb(2) ** 200_000)


def test_fifty_digits_of_an_end_are_shown_at_most():
    text = str(ss.enclose("0.3*exp(-v)", V=1, N=1, digits=120))
    assert len(text.removesuffix("[...]").removeprefix("0.")) == 50


def test_ends_have_no_more_digits_than_their_radius_gives():
    radius = Fraction(1, 2**70)
    ends = rounded_outward(Enclosure(Fraction(1, 3) - radius, Fraction(1, 3) + radius))
    assert max(ends.low.denominator, ends.high.denominator) == 2**74


@given(st.fractions(-1, 1), st.fractions(0, 1), st.integers(-200, 200))
def test_ends_are_those_of_radii_that_nearly_agree(middle, radius, exponent):
    """As are those of an integral whose nodes were computed before, for more digits."""
    size = Fraction(2) ** exponent
    middle, radius = middle * size, (radius + Fraction(1, 10**6 + 3)) * size / 10**6
    more = radius * (1 + Fraction(1, 10**30))
    ends = [rounded_outward(Enclosure(middle - some, middle + some)) for some in (radius, more)]
    assert ends[0] == ends[1]
    assert ends[0].low <= middle - radius < middle + radius <= ends[0].high
    assert ends[0].radius <= radius * Fraction(17, 16)
    assert rounded_outward(Enclosure(middle, middle)) == Enclosure(middle, middle)
