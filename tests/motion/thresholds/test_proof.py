"""Thresholds as theorems: boxes that hold the motion, decisions that agree with simulation, checked hypotheses."""

import random
from dataclasses import replace
from functools import cache

import mpmath
import numpy as np
import pytest
import sympy as sp
from flint import arb
from scipy.integrate import solve_ivp

import stickslip_sym as ss
from stickslip_sym.core.precision import working_precision
from stickslip_sym.model.lipschitz import lipschitz_evidence
from stickslip_sym.motion.thresholds import boxes, theorem
from stickslip_sym.motion.thresholds.boxes import ExactPoint, flow, transit
from stickslip_sym.motion.thresholds.theorem import checked_hypotheses, prove_threshold
from support.strategies import nested
from support.sweeps import sample, sweep

R = sp.Rational
POINTS = [
    (0, 0.5), (0.05, 0.46), (0.1, 0.43), (0.2, 0.38), (0.3, 0.34), (0.4, 0.315), (0.5, 0.295), (0.6, 0.28),
    (0.75, 0.265), (0.9, 0.255), (1.2, 0.25), (2, 0.25),
]  # fmt: skip
FALLING = "mu_m + (mu_s - mu_m)*exp(-alpha*v)"
LAWS = {
    "exponential": ss.laws.exponential.typical(),
    "polynomial": ss.laws.polynomial.typical(),
    "lorentzian": ss.laws.lorentzian.typical(),
    "steep": ss.laws.exponential.typical(alpha=100),
    "root": ss.laws.stribeck.typical(delta="0.7"),
    "static": ss.laws.exponential.typical().with_static("0.55"),
    "kink": ss.FrictionLaw("Max(mu_s - a*v, mu_m)").bind(mu_s="0.5", a="0.5", mu_m="0.2"),
    "points": ss.FrictionLaw.from_samples(*zip(*POINTS, strict=True)),
}


def point(law, V="1/2", N="981/100", m="1", k="100"):
    return ExactPoint(law, R(V), R(N), R(m), R(k))


def simulated(law, rtol=1e-8, **values):
    numbers = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0} | values
    return ss.pure_slip_damping(law, **numbers, method="simulation", rtol=rtol)


@sweep("name", list(LAWS), "exponential", "static", "kink")
def test_decisions_agree_with_simulation(name):
    c = R(*float(simulated(LAWS[name]).value).as_integer_ratio())
    below, above = (transit(point(LAWS[name]), c * (1 + side * R(1, 10**7)), 90) for side in (-1, 1))
    assert (below.returns, above.returns) == (True, False)
    assert above.lowest > 0


@sweep(
    ("name", "digits"),
    [("exponential", "2.5730788789793615906"), ("polynomial", "3.0364772435578037767")],
    ("exponential", "2.5730788789793615906"),
)
def test_the_paper_s_point_to_forty_digits(name, digits):
    found = simulated(LAWS[name])
    theorem = prove_threshold(point(LAWS[name]), float(found.value), float(found.relative_error), 1e-40)
    assert str(theorem.enclosure).startswith(digits)
    assert theorem.enclosure.digits >= 40
    assert theorem.undamped.returns
    with mpmath.workdps(45):  # a threshold that is shifted in the twelfth digit lies outside
        assert mpmath.mpf(digits) * (1 + mpmath.mpf("1e-12")) not in theorem.enclosure


MP = mpmath.mpf
BY_MPMATH = [
    # law, c in kg/s, digits, mu(0) - mu over w with V = 1/2
    ("exponential", "2.6", 25, lambda w: MP("0.3") * (1 - mpmath.exp(MP("-1.5") * w))),
    ("polynomial", "3.1", 22, lambda w: MP("0.3") * (MP("0.75") * w - w**3 / 16)),
    ("lorentzian", "3.1", 30, lambda w: MP("0.3") * (1 - 1 / (1 + w**2))),
]
BELOW_STATIC = [(name, friction) for name, _, _, friction in BY_MPMATH]


@cache
def by_mpmath(friction, c, digits):
    """Return the lowest slip speed by mpmath's solver, which shares no code with the boxes."""
    with mpmath.workdps(digits + 2):
        eta, damping = MP("9.81") / 5, MP(c) / 10

        def field(t, state):
            q, w = state
            return [1 - w, eta * friction(w) + q - damping * w]

        motion = mpmath.odefun(field, 0, [MP(0), MP(0)])
        tolerance = MP(10) ** (-digits)
        turn = mpmath.findroot(lambda t: field(t, motion(t))[1], (6.2, 6.4), solver="anderson", tol=tolerance)
        return motion(turn)[1]


@sweep(("name", "c", "digits", "friction"), BY_MPMATH, BY_MPMATH[1])
def test_the_lowest_slip_speed_is_mpmath_s(name, c, digits, friction):
    lowest = transit(point(LAWS[name]), R(c), 4 * digits + 20).lowest
    truth = by_mpmath(friction, c, digits)
    with mpmath.workdps(digits + 10):
        middle = MP(lowest.mid().str(digits + 8, radius=False))
        assert lowest.rad() < 10.0 ** (2 - digits)
        assert abs(middle - truth) < MP(10) ** (3 - digits)


@sweep(("name", "friction"), BELOW_STATIC, BELOW_STATIC[1])
def test_the_orbit_grazes_by_mpmath(name, friction):
    """Newton's step from its threshold, over two of mpmath's motions, is as small as its error."""
    found = ss.pure_slip_damping(LAWS[name], V=0.5, N=9.81, m=1, k=100, method="orbit", rtol=1e-12).value
    lowest, off = (by_mpmath(friction, repr(found * factor), 20) for factor in (1, 1 + 1e-6))
    assert abs(off) > 1e-7
    assert abs(lowest / (off - lowest)) * 1e-6 < 1e-12


def random_box(rng, law):
    with working_precision(200):
        (segment, *_) = point(law).segments(R(rng.randint(1, 400), 100))
        return segment, arb(rng.uniform(-1, 2)), arb(rng.uniform(0.05, 2.5))


@pytest.mark.parametrize("name", ["exponential", "lorentzian", "root"])
def test_a_step_holds_the_motion(name):
    """Whatever its number of terms; the negative control is that of three terms without what they leave over."""
    rng = random.Random(name)
    for _ in range(20):
        field, q, w = random_box(rng, LAWS[name])
        with working_precision(160):
            bare, rough, fine = (flow(field, q, w, terms) for terms in (3, 6, 60))
            time = rough.time * rng.uniform(0.2, 1)
            assert all(one.overlaps(other) for one, other in zip(rough.at(time), fine.at(time), strict=True))
            assert max(part.rad() for part in fine.at(time)) < 1e-25
            bare = boxes.Flow(bare.q, bare.w, bare.time, arb(0), arb(0))
            assert not bare.at(bare.time)[1].overlaps(fine.at(bare.time)[1])


def by_chebyshev(rate, q, w, time, nodes=40):
    """Return w after a time, by mpmath: w' as a polynomial through Chebyshev points, iterated until it stays."""
    angles = [mpmath.pi * (k + MP(0.5)) / nodes for k in range(nodes)]

    def rise(k, angle):  # the integral of T_k from -1
        if k == 0:
            return mpmath.cos(angle) + 1
        if k == 1:
            return (mpmath.cos(angle) ** 2 - 1) / 2
        top, low = (mpmath.cos((k + one) * angle) / (k + one) for one in (1, -1))
        return (top - low) / 2 - MP(-1) ** k / (k * k - 1)

    table = [[rise(k, angle) * time / 2 for k in range(nodes)] for angle in (*angles, MP(0))]
    series = [[mpmath.cos(k * angle) * (2 - (k == 0)) / nodes for angle in angles] for k in range(nodes)]
    all_q, all_w = [q] * nodes, [w] * nodes
    for _ in range(80):
        before = all_w[-1]
        rates = [1 - x for x in all_w[:nodes]], [rate(*state) for state in zip(all_q, all_w[:nodes], strict=False)]
        series_of = [[mpmath.fdot(line, values) for line in series] for values in rates]
        all_q, all_w = (
            [start + mpmath.fdot(row, terms) for row in table]
            for start, terms in zip((q, w), series_of, strict=True)
        )
        if abs(all_w[-1] - before) < MP("1e-42"):
            return all_w[-1]
    raise AssertionError("the iteration has not settled")


@sweep("count", [2, 300], 2)
def test_a_step_of_a_random_law_is_mpmath_s(count):
    """To 35 digits, for functions within functions; six terms without what they leave over are another motion."""
    rng = random.Random(9)
    for _ in range(count):
        law, c = nested(rng), rng.randint(1, 400)
        with working_precision(200), mpmath.workdps(45):
            (field, *_) = point(law).segments(R(c, 100))
            q, w = arb(rng.uniform(-1, 2)), arb(rng.uniform(0.05, 2.5))
            fine, rough = flow(field, q, w, 90), flow(field, q, w, 6)
            bare = boxes.Flow(rough.q, rough.w, rough.time, arb(0), arb(0))
            friction = law.function("mpmath")
            push = MP("1.962") * friction(MP("1e-60"))

            def rate(q, w, push=push, friction=friction, c=c):
                return push - MP("1.962") * friction(w / 2) - MP(c) / 1000 * w + q

            truth = by_chebyshev(rate, MP(float(q)), MP(float(w)), MP(float(fine.time)))
            truth = arb(mpmath.nstr(truth, 42)) + arb(0, 1e-36)
            assert (fine.at(fine.time)[1] - truth).abs_upper() < 1e-35, law
            assert rough.at(fine.time)[1].overlaps(truth), law
            assert not bare.at(fine.time)[1].overlaps(truth), law


def test_the_remainder_bound_is_sharp():
    """In a field that is nearly constant what no terms leave over is all of the way: a part of the bound fails."""
    rng = random.Random(5)
    for _ in range(20):
        with working_precision(160):
            (segment, *_) = point(LAWS["exponential"]).segments(R(rng.randint(1, 400), 100))
            q, w = arb(rng.uniform(1e3, 1e5)), arb(rng.uniform(0.05, 2.5))
            none, one, fine = (flow(segment, q, w, terms) for terms in (1, 2, 60))
            way = abs(fine.at(none.time)[1] - w)
            assert none.rest_w.abs_upper() > way > none.rest_w.abs_upper() / 2
            assert abs(none.rest_w.abs_upper() / one.rest_w.abs_upper() - 4) < 1e-6
            fast = arb(rng.uniform(1e2, 1e4))
            none, fine = (flow(segment, w, fast, terms) for terms in (1, 60))
            way = abs(fine.at(none.time)[0] - w)
            assert none.rest_q.abs_upper() > way > none.rest_q.abs_upper() / 4


def test_without_the_remainder_bound_mpmath_tells(monkeypatch):
    """The negative control of the comparison with mpmath: twenty terms a step, with their bound and without."""
    name, c, digits, friction = BY_MPMATH[1]
    truth = mpmath.nstr(by_mpmath(friction, c, digits), digits)
    for part, holds in ((0, False), (1, True)):

        def step(field, q, w, terms, part=part, **how):
            found = flow(field, q, w, 20, **how)
            return boxes.Flow(found.q, found.w, found.time, found.rest_q * part, found.rest_w * part)

        monkeypatch.setattr(boxes, "flow", step)
        with working_precision(160):
            assert transit(point(LAWS[name]), R(c), 120).lowest.overlaps(arb(truth)) == holds


@sweep("name", ["exponential", "root", "kink"], "exponential", "kink")
def test_the_highest_slip_speed_is_bounded(name):
    law, c = LAWS[name], 3.6

    def rates(_, state):
        q, w = state
        return [1 - w, 1.962 * float(law.mu(0.0) - law.mu(0.5 * max(w, 0.0))) + q - c / 10 * w]

    motion = solve_ivp(rates, (0, 6), (0.0, 0.0), rtol=1e-10, atol=1e-12, dense_output=True)
    seen = motion.sol(np.linspace(0, 6, 4001))[1].max()
    highest = transit(point(law), R(c), 64).highest
    assert highest.lower() - 1e-6 < seen < highest.upper() + 1e-6
    assert highest.rad() < 1e-3


@pytest.mark.parametrize("formula", ["0.4472 + 0.1397*v*log(v)", "0.5 - 0.2*exp(-g/v)"])
def test_a_coefficient_with_a_limit_at_rest_only_is_refused_in_words(formula):
    law = ss.FrictionLaw(formula)
    law = law.bind(g="0.1") if law.parameters else law
    with pytest.raises(ss.StickSlipError, match="mu changes too fast at v = 0"):
        ss.pure_slip_damping(law, V=0.5, N=9.81, m=1, k=100, method="proof")


CONTINUOUS = ("0.6 - 0.1*Min(v, {0})", "Max(0.2, 1 - v/{0})", "0.3 + Abs(v - {0})", "Max(exp(-v/{0}), 0.3)")


@sample(3)
@pytest.mark.parametrize("seed", range(8))
def test_kinks_in_several_factors_are_no_jumps(seed):
    """Whichever comes first, and where they come at one speed; a jump among them is seen."""
    rng = random.Random(seed)
    factors = zip(rng.sample(CONTINUOUS, 2), "uw", strict=True)
    formula = "*".join(f"({factor.format(name)})" for factor, name in factors)
    values = {name: rng.choice((R(4, 5), 1, R(5, 4), 2)) for name in "uw"}
    assert lipschitz_evidence(ss.FrictionLaw(formula).bind(**values).bound)[0]
    jumping = ss.FrictionLaw(f"{formula}*Piecewise((1, v < d), (b, True))").bind(
        **values, d=rng.choice((1, 3)), b=2
    )
    assert lipschitz_evidence(jumping.bound) == (False, "mu jumps at v = d")


@pytest.mark.parametrize(
    ("law", "complaint"),
    [
        (ss.FrictionLaw("Piecewise((a, v < d), (b, True))").bind(a="0.5", d="0.2", b="0.3"), "jumps at v = d"),
        (ss.FrictionLaw("a + b*sqrt(v - d)").bind(a="0.5", d="0.2", b="0.3"), "not shown to be positive"),
        (ss.laws.exponential.typical().with_static("0.45"), "the static coefficient was not shown"),
    ],
)
def test_a_hypothesis_that_fails_is_named(law, complaint):
    with pytest.raises(ss.InputError, match=complaint):
        checked_hypotheses(point(law))


@pytest.mark.parametrize("name", ss.laws.catalogue)
def test_every_law_of_the_catalogue_meets_the_hypotheses(name):
    assert checked_hypotheses(point(ss.laws.catalogue[name].typical()))[0][1].startswith("mu is analytic")


def test_a_proof_by_name():
    given = {"V": "0.5", "N": "9.81", "m": 1, "k": 100}

    def by(method, **more):
        return ss.pure_slip_damping(LAWS["exponential"], **given | {"method": method} | more)

    found, estimated = by("proof", rtol=1e-25), by("orbit")
    assert (found.status, found.method) == (ss.Status.PROVED, "proof")
    assert found.relative_error <= 1e-25
    assert found.enclosure.digits >= 25
    assert float(found.enclosure) == found.value
    assert str(found).startswith("2.573078878979361590655649[...] kg/s (proof")
    assert not by("proof", N=9.81, rtol=1e-18).enclosure.overlaps(found.enclosure)  # 9.81 as a binary number
    several = by("proof", V=[0.4, 0.5], rtol=1e-6)
    assert several.value.shape == (2,)
    assert len(several.theorems) == 2
    assert several.theorem is None
    assert (estimated.status, estimated.enclosure) == (ss.Status.ESTIMATED, None)
    assert abs(estimated.value - found.value) <= estimated.relative_error * found.value + 1e-15


def test_no_theorem_without_a_return_undamped(monkeypatch):
    """A hypothesis of the lemma that no law is known to fail: a decision is turned round."""

    def undamped_turned(point, c, bits):
        found = transit(point, c, bits)
        return replace(found, returns=False) if c == 0 else found

    monkeypatch.setattr(theorem, "transit", undamped_turned)
    with pytest.raises(ss.NoThreshold, match="not without any"):
        prove_threshold(point(LAWS["polynomial"]), simulated(LAWS["polynomial"]).value, 1e-8, 1e-4)


def test_several_changes_in_one_bracket_are_refused():
    """As a critical value may have beside it, where a threshold has none: the ends would be turned round."""

    def decision(x, bits):
        return boxes.Transit(x < 0.99 or 1 < x < 1.01, arb(0), False, arb(0), 0, bits, 0.0)

    with pytest.raises(ss.NotConverged, match="several changes are near the guess a = 1"):
        theorem.Search(decision, "a").around(1.0, 1e-3, 1e-6)


def test_a_negative_threshold_is_proved_too():
    law, point = ss.laws.polynomial.typical(), {"V": 1.5, "N": 9.81, "m": 1, "k": 100}
    found = ss.pure_slip_damping(law, **point, method="proof", rtol=1e-9)
    orbit = ss.pure_slip_damping(law, **point, method="orbit", rtol=1e-11)
    assert found.value == pytest.approx(orbit.value, rel=1e-9)
    assert "no damping is needed" in str(found)
    with pytest.raises(ss.NoThreshold):
        ss.pure_slip_damping(ss.laws.coulomb.typical(), V=0.5, N=9.81, m=1, k=100, method="proof")


def test_the_first_step_from_where_mu_is_not_analytic():
    """It costs no digits, and hundreds of steps at most, each as long as the way from rest allows."""
    point = ExactPoint(ss.laws.stribeck.typical(delta="1.5"), R(1, 2), R(981, 100), R(1), R(100))
    decided = transit(point, R(1, 2), 48)
    assert decided.returns
    assert decided.width < 1e-10
    assert decided.steps < 1000


def decisions(value, error, bits):
    """Return how many decisions enclose 1, by a lowest speed of known form, if each needs some bits."""

    def decision(x, given):
        if given < bits:
            raise boxes.Undecided("too few bits")
        off = arb(str(float(x - 1)))
        return boxes.Transit(x < 1, off + off**2, True, arb(2), 1, given, 0.0)

    search = theorem.Search(decision, "c")
    enclosure = search.around(value, error, 1e-9)
    assert enclosure.low < 1 < enclosure.high
    return len(search.decided)


def test_what_is_known_to_a_half_is_enclosed_in_few_decisions():
    """Where it is off by less than a hundredth, as guesses are."""
    assert decisions(1.009, 0.5, 0) <= 8


def test_a_proof_takes_some_hundred_bits_beyond_the_distance_and_no_thousand():
    assert decisions(1.004, 0.005, 500) < 20
    with pytest.raises(ss.NotConverged, match=r"undecided at c = .* too few bits"):
        decisions(1.004, 0.005, 1000)
