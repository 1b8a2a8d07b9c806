"""Ball functions hold what they enclose, and tell where they are not analytic."""

import random
import threading

import mpmath
import pytest
import sympy as sp
from flint import acb, arb, arb_series, ctx

import stickslip_sym as ss
from stickslip_sym.core import balls
from stickslip_sym.core.precision import ball_of_mpmath

x = sp.Symbol("x")


def test_constants_of_closed_forms():
    mu = sp.Rational(3, 7)
    for expr in (
        sp.besseli(1, mu), sp.lowergamma(sp.Rational(4, 3), mu), sp.uppergamma(2, mu), sp.polylog(3, -mu),
        sp.hyper((sp.Rational(5, 4), 1), (2,), -mu), sp.elliptic_k(mu), sp.elliptic_e(mu), sp.elliptic_pi(-mu, mu),
        sp.acos(mu), sp.asin(mu), sp.expint(1, mu), sp.besselj(1, mu),
        sp.dirichlet_eta(3), sp.zeta(3), sp.Catalan, sp.gamma(mu), sp.im(sp.polylog(2, sp.I * mu)),
    ):  # fmt: skip
        with balls.working_precision(150), mpmath.workdps(35):
            truth = mpmath.mpf(sp.N(expr, 35))
            value = balls.ball_value(expr, {}).real
            assert value.rad() < 1e-35
            assert value.overlaps(ball_of_mpmath(truth, abs(truth) * mpmath.mpf("1e-30")).real), expr


@pytest.mark.parametrize("function", [sp.log, sp.sqrt, lambda a: a ** sp.Rational(3, 10), sp.atan, sp.asinh])
def test_a_cut_is_seen_by_a_ball(function):
    rng = random.Random(3)
    across = {sp.atan: True, sp.asinh: True}.get(function, False)
    ball_function = balls.ball_function(function(x), x, {})
    for _ in range(200):
        along, beside, radius = 10 ** rng.uniform(-1, 2), rng.uniform(-1, 1), 10 ** rng.uniform(-3, 0)
        along = (1 + along) * rng.choice([-1, 1]) if across else -along
        center = acb(beside, along) if across else acb(along, beside)
        touches = abs(beside) <= radius
        wide = center + acb(arb(0, radius), arb(0, radius / 10) if across else arb(0, radius))
        if touches:
            assert not ball_function(wide, True).is_finite()
        elif abs(beside) > 1.5 * radius:
            narrow = center + acb(arb(0, 1e-9), arb(0, 1e-9))
            assert ball_function(narrow, True).is_finite()


def test_a_careless_integrand_is_tight_and_wrong():
    """Why the cuts are looked for: the negative control."""
    with balls.working_precision(80):
        careless = acb.integral(lambda z, analytic: z.sqrt(), 1, 4)
        asked = acb.integral(balls.ball_function(sp.sqrt(x), x, {}), 1, 4)
        truth = arb(14) / 3
        assert asked.real.overlaps(truth)
        assert max(asked.real.rad(), careless.real.rad()) < 1e-20
        assert not careless.real.overlaps(truth)


def test_the_precision_is_always_put_back():
    before, wrong = ctx.prec, []

    def work(bits):
        for _ in range(30):
            with pytest.raises(ZeroDivisionError), balls.working_precision(99):
                _ = 1 / 0
            with balls.working_precision(bits):
                if ctx.prec != bits or acb(1).exp().real.rel_accuracy_bits() < bits - 5:
                    wrong.append(bits)

    threads = [threading.Thread(target=work, args=(bits,)) for bits in (64, 150, 400)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert (wrong, ctx.prec) == ([], before)


def test_what_is_not_in_the_list_is_refused():
    with pytest.raises(ss.InputError, match="LambertW is not among the functions"):
        balls.ball_function(sp.LambertW(x), x, {})
    with pytest.raises(ss.InputError, match="hyper is not among the functions"):
        balls.ball_function(sp.hyper([1], [2], x), x, {})


def test_pieces_are_chosen_exactly():
    """Choices within choices."""
    a, b, c = sp.symbols("a b c", positive=True)
    rng = random.Random(5)
    expr = sp.Min(2 * a, sp.Max(b, c)) + sp.Max(a, sp.Min(b, sp.Piecewise((a, a < c), (2 * c, True))))
    for _ in range(20):
        point = {name: sp.Rational(rng.randint(1, 9), 7) for name in (a, b, c)}
        assert (7 * balls.ball_value(expr, point).real).contains(int(7 * expr.xreplace(point)))
        assert balls.number_at(expr, point) == expr.xreplace(point)


def test_a_series_has_the_terms_asked_for():
    """Also where its function was made while fewer were."""
    w, a = sp.symbols("w a")
    for expr in (a + sp.exp(-a * w), a * sp.exp(w) - w**2 / a, (w + a) / (1 + w), a + sp.tanh(w + a)):
        found = []
        for terms in (3, 12):
            with balls.working_precision(100, terms):
                function = balls.series_function(expr, w, {a: sp.Rational(1, 3)})
            with balls.working_precision(100, 12):
                found.append(function(arb_series([arb(1) / 7, 1])).coeffs())
        assert len(found[0]) == len(found[1]) == 12
        assert all(one.overlaps(other) for one, other in zip(*found, strict=True))
