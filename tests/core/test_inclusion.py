"""Inclusion: what a ball function gives on a ball holds its value at every point of the ball, or is not finite.

Random nested expressions of every function of the table, on balls of all kinds: narrow, wide, around 0, without
bound, not a number, real and complex. Where analyticity is asked for, a finite ball is that of a function whose
mean on a circle is its value in the middle.
"""

import math
import random

import mpmath
import sympy as sp
from flint import acb, arb, arb_series

from stickslip_sym.core import balls
from stickslip_sym.core.functions import FUNCTIONS, fold
from stickslip_sym.core.precision import ball_of_mpmath, middle_in_mpmath, mp, working_precision
from stickslip_sym.core.special import Ein, Langevin, Lerch, NumberPower
from support.random_formulas import KNOWN
from support.sweeps import sweep

x = sp.Symbol("x")
R = sp.Rational
KINDS = [kind for kind, row in FUNCTIONS.items() if row.ball is not None]
IN_LAWS = [kind for kind in KINDS if FUNCTIONS[kind].in_laws]
OTHERS = {
    **dict.fromkeys((sp.besseli, sp.besselj, sp.besselk, sp.bessely), lambda kind, z: kind(R(1, 2) + 1, z)),
    **dict.fromkeys((sp.lowergamma, sp.uppergamma, sp.expint), lambda kind, z: kind(R(4, 3), z)),
    sp.polylog: lambda kind, z: kind(2, z),
    sp.elliptic_pi: lambda kind, z: kind(R(1, 3), z),
    Lerch: lambda kind, z: kind(z, 2, R(5, 7)),
    NumberPower: lambda kind, z: kind(R(3, 7), R(1, 3)) * z,
    Langevin: lambda kind, z: kind(z, 1),
    # Far up the imaginary axis one value takes minutes.
    **dict.fromkeys((sp.zeta, sp.dirichlet_eta), lambda kind, z: kind(3 + sp.atan(z))),
}
"""Functions of several arguments, as functions of the last or the only one that varies."""
MPMATH = KNOWN | {
    sp.besselj: mpmath.besselj, sp.besselk: mpmath.besselk, sp.bessely: mpmath.bessely, sp.csch: mpmath.csch,
    sp.uppergamma: mpmath.gammainc, sp.expint: mpmath.expint, sp.Ei: mpmath.ei, sp.Si: mpmath.si,
    sp.Ci: mpmath.ci, sp.Shi: mpmath.shi, sp.Chi: mpmath.chi, sp.fresnels: mpmath.fresnels,
    sp.fresnelc: mpmath.fresnelc, sp.re: mpmath.re, sp.im: mpmath.im, sp.arg: mpmath.arg,
    Ein: lambda z: z * mpmath.hyp2f2(1, 1, 2, 2, -z),
    NumberPower: mpmath.power, Lerch: mpmath.lerchphi,
    Langevin: lambda z, n: mpmath.mpf(1) / 3 if z == 0 else 1 / z**2 - mpmath.csch(z) ** 2,
}  # fmt: skip


def expression(rng, depth, kinds):
    if depth == 0:
        return rng.choice([x, x, x, R(rng.randint(-9, 9), rng.randint(1, 9)), sp.pi])
    inner, kind = expression(rng, depth - 1, kinds), rng.randrange(8)
    if kind < 4:
        return (sp.Add, sp.Mul)[kind % 2](inner, expression(rng, depth - 1, kinds))
    if not inner.has(x):
        return inner  # SymPy expands numbers, at length
    if kind < 6:
        exponent = rng.choice([2, 3, -1, -2, R(1, 2), R(-1, 2), R(7, 10), R(3, 2), 65, -66, None])
        return inner ** (R(rng.randint(-9, 9), 4) * inner if exponent is None else exponent)
    function = rng.choice(rng.choice([kinds, IN_LAWS]))
    return OTHERS.get(function, lambda kind, z: kind(z))(function, inner)


def functions(rng, count, kinds=KINDS):
    """Draw expressions of x that have balls."""
    while count:
        expr = expression(rng, rng.choice([1, 1, 2, 2, 3]), kinds)
        if expr.has(x) and not expr.has(sp.nan, sp.zoo, sp.oo, sp.Integral, sp.atan2):
            yield expr
            count -= 1


def random_ball(rng):
    def real():
        middle = rng.choice([0.0, rng.uniform(-3, 3), rng.choice([1, -1]) * 10 ** rng.uniform(-6, 3)])
        radius = rng.choice([0.0, abs(middle) * 10 ** rng.uniform(-6, 1), 10 ** rng.uniform(-3, 1), math.inf])
        return arb.nan() if rng.random() < 0.03 else arb(middle, radius)

    return acb(real(), real() if rng.random() < 0.4 else 0)


def points(rng, ball):
    """Three numbers in a real ball; of one without bound any."""
    if not ball.is_finite():
        return [arb(rng.choice([-1, 1]) * 10 ** rng.uniform(-9, 9)) for _ in range(3)]
    return [(ball.mid() + ball.rad() * rng.choice([rng.uniform(-1, 1), 1, -1, 0])).mid() for _ in range(3)]


@sweep("draws", [100, 3000], 100)
def test_a_ball_holds_every_value_on_its_argument(draws):
    rng, finite = random.Random(1), 0
    for expr in functions(rng, draws):
        function = balls.ball_function(expr, x, {})
        for _ in range(4):
            ball = random_ball(rng)
            with working_precision(rng.choice([53, 120])):
                results = [function(ball, False), function(ball, True), balls.ball_value(expr, {x: ball})]
                for point in map(acb, points(rng, ball.real), points(rng, ball.imag)):
                    value = function(point, False)
                    finite += results[0].is_finite() and value.is_finite()
                    for result in results:
                        assert not (result.is_finite() and value.is_finite()) or result.overlaps(value), expr
    assert finite > 4 * draws


@sweep("draws", [60, 1500], 60)
def test_a_series_holds_every_coefficient_on_its_argument(draws):
    rng, finite = random.Random(4), 0
    for expr in functions(rng, draws, IN_LAWS):
        ball = arb(rng.uniform(0.1, 3), 10 ** rng.uniform(-9, 0.5))
        with working_precision(80, 6):
            function = balls.series_function(expr, x, {})
            try:
                wide, *exact = (function(arb_series([start, 1])) for start in (ball, *points(rng, ball)))
            except (ValueError, ZeroDivisionError):  # by a series whose first ball holds 0
                continue
            for series in exact:
                for k in range(6):
                    finite += wide[k].is_finite()
                    assert not (wide[k].is_finite() and series[k].is_finite()) or wide[k].overlaps(series[k]), expr
    assert finite > draws


@sweep("draws", [60, 1500], 60)
def test_a_narrow_ball_holds_the_value_by_mpmath(draws):
    rng, looked = random.Random(2), 0

    def at(point):
        def value(node, parts):
            if node == x:
                return point
            if node.is_Rational:
                return mpmath.mpf(int(node.p)) / int(node.q)
            if node.is_Add or node.is_Mul:
                return (mpmath.fsum if node.is_Add else mpmath.fprod)(parts)
            if node.is_Pow and len(parts) == 2:
                return mpmath.power(*parts)
            return mpmath.pi if node == sp.pi else MPMATH[sp.exp if node.is_Pow else node.func](*parts)

        return value

    quick = [kind for kind in KINDS if kind is not sp.elliptic_pi]  # mpmath takes minutes for some
    for expr in functions(rng, draws, quick):
        # Off the axis: on a cut either side may be meant.
        point = acb(*(arb(rng.choice([-1, 1]) * rng.uniform(0.1, 3)) for _ in range(2)))
        with working_precision(200), mpmath.workdps(60), mp.workdps(60):
            ball = balls.ball_function(expr, x, {})(point, False)
            if ball.is_finite() and ball.abs_upper() < 1e6 and ball.rad() < 1e-30:
                try:
                    truth = fold(expr, at(mpmath.mpc(middle_in_mpmath(point))))
                except (mpmath.mp.NoConvergence, ValueError):
                    continue
                looked += 1
                assert ball.overlaps(ball_of_mpmath(mpmath.mpc(truth), mpmath.mpf("1e-25"))), expr
    assert looked > draws / 2


@sweep("draws", [150, 3000], 150)
def test_what_is_called_analytic_has_its_mean_in_the_middle(draws):
    rng, looked = random.Random(3), 0
    turns = [acb(arb(k) / 16).exp_pi_i() for k in range(32)]
    for expr in functions(rng, draws):
        function = balls.ball_function(expr, x, {})
        middle, radius = acb(rng.uniform(-2, 2), rng.choice([0, rng.uniform(-2, 2)])), 10 ** rng.uniform(-2, 0.5)
        with working_precision(100):
            whole = function(middle + acb(arb(0, radius), arb(0, radius)), True)
            if whole.is_finite():
                mean = sum(function(middle + radius / 4 * turn, False) for turn in turns) / 32
                gap = (mean - function(middle, False)).abs_lower()
                looked += 1
                assert not gap > whole.abs_upper() * 1e-15, expr
    assert looked > draws / 4
