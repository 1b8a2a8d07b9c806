"""A new function is one row of the table: everything else looks it up."""

from dataclasses import replace

import mpmath
import numpy as np
import pytest
import sympy as sp
from flint import acb, arb, arb_series

import stickslip_sym as ss
from stickslip_sym.core import balls, functions
from stickslip_sym.core.functions import FUNCTIONS, Function
from stickslip_sym.core.lambdify import function_of, power_of
from stickslip_sym.core.numbers import read_rtol
from stickslip_sym.core.precision import working_precision
from stickslip_sym.core.special import Langevin, Removable
from stickslip_sym.model.at_rest import stable_difference
from stickslip_sym.model.lipschitz import lipschitz_evidence
from stickslip_sym.output import printing
from support.sweeps import sample

x = sp.Symbol("x", positive=True)
POINT = sp.Rational(37, 29)

NEW = {
    "fresnels": (
        Function(sp.fresnels, acb.fresnel_s, analytic=True, bounded=True, in_laws=True, latex="S"),
        mpmath.fresnels,
    ),
    "acosh": (
        Function(sp.acosh, acb.acosh, in_laws=True, latex=r"\operatorname{arcosh}",
                 domain=lambda z: (z - 1,)),
        mpmath.acosh,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", NEW)
@mpmath.workdps(15)
def test_a_new_function_is_one_row(name, monkeypatch):
    row, value = NEW[name]
    law = "1 + a*{}(2 + v)"
    if not FUNCTIONS.get(row.kind, row).in_laws or row.kind not in FUNCTIONS:
        with pytest.raises(ss.InputError, match=f"no function {name!r}"):
            ss.FrictionLaw(law.format(name))
    monkeypatch.setitem(FUNCTIONS, row.kind, row)
    bound = ss.FrictionLaw(law.format(name)).bind(a=0.3)
    speeds = np.array([0.1, 0.7])
    assert bound.mu(speeds) == pytest.approx([1 + 0.3 * float(value(2 + v)) for v in speeds], rel=1e-14)
    slopes = [0.3 * float(mpmath.diff(value, 2 + v)) for v in speeds]
    assert bound.slope(speeds) == pytest.approx(slopes, rel=1e-9)
    assert ss.FrictionLaw(bound.text).expr == bound.expr
    assert (row.latex or f"\\operatorname{{{name}}}") in printing.latex(bound.expr)
    enclosed, exact = ss.enclose(bound, V=1, N=1, digits=20), ss.quadrature.damping(bound, V=1, N=1, digits=20)
    assert float(enclosed) == pytest.approx(float(exact), rel=1e-15)
    with working_precision(200, 6):
        series = balls.series_function(row.kind(x), x, {})(arb_series([float(POINT), 1]))
        taylor = mpmath.taylor(value, float(POINT), 5)
        assert [float(series[n]) for n in range(6)] == pytest.approx(list(map(float, taylor)), rel=1e-9, abs=1e-12)
    assert lipschitz_evidence(bound.bound)[0]  # so thresholds of such laws are proved
    monkeypatch.setitem(FUNCTIONS, row.kind, replace(row, analytic=False, domain=lambda z: None))
    assert not lipschitz_evidence(bound.bound)[0]


@pytest.mark.parametrize("kind", list(FUNCTIONS), ids=lambda kind: kind.__name__)
def test_every_row_is_what_sympy_computes(kind):
    """The ball, its cut and the series of a function against SymPy's value and derivative."""
    row, name = FUNCTIONS[kind], kind.__name__
    if row.ball is None or name in ("lowergamma", "uppergamma", "NumberPower"):
        pytest.skip("of several arguments, or without a ball")
    third, seventh = sp.Rational(1, 3), sp.Rational(5, 7)
    others = {"Lerch": [-third, sp.Integer(2), seventh], "elliptic_pi": [third, sp.Integer(2)],
              "acosh": [sp.Rational(7, 3)], "zeta": [sp.Rational(7, 3)],
              "Langevin": [third, sp.Integer(1)]}  # fmt: skip
    numbers = others.get(name, [sp.Integer(2), third] if row.indexed else [third])
    expected = complex(kind(*numbers, evaluate=False).evalf(30))
    with working_precision(120, 4):
        assert complex(row.ball(*map(balls.ball, numbers))) == pytest.approx(expected, rel=1e-14)
        if row.in_laws:
            series = balls.series_function(kind(x), x, {})(arb_series([0.25, 1]))
            assert float(series[1]) == pytest.approx(float(kind(x).diff(x).subs(x, 0.25)), rel=1e-13)
    if row.stable_difference is not None:
        close = sp.Float("0.3000000000000000000000001", 40)
        got = stable_difference(kind(x), x, sp.Rational(3, 10)).subs(x, close).evalf(20)
        with mpmath.workdps(60):
            direct = (kind(close.n(60)) - kind(sp.Float("0.3", 60))).evalf(50)
        assert abs(got / direct - 1) < 1e-10


class Sinc(Removable):
    """Another such function, to show that its form and its series are all that is needed."""

    form = staticmethod(lambda x: sp.sin(x) / x)
    power_series = staticmethod(lambda x: x.sin() / x)


@sample(3)
@pytest.mark.parametrize("kind", [Langevin, Sinc])
@pytest.mark.parametrize("order", range(4))
def test_removable_singularities_keep_digits(kind, order):
    """In doubles, balls and mpmath against the form in many digits: where its parts cancel, and far out."""
    u = sp.Dummy()
    plain = function_of([u], kind(u, order).elementary(), "mpmath")
    for number in (1e-12, 1e-3, 0.7, 1.4999, 1.5001, 4.0, 50.0, 1e9):
        with mpmath.workdps(120):
            expected = plain(mpmath.mpf(number))
        assert kind.floats(number, order) == pytest.approx(float(expected), rel=3e-14)
        with mpmath.workdps(30):
            assert kind.mpf(mpmath.mp, mpmath.mpf(number), order) == pytest.approx(expected, rel=1e-28)
        with working_precision(140, 4):
            value = kind.ball(acb(number), acb(order)).real
            assert value.overlaps(arb(mpmath.nstr(expected, 60)))
            assert value.rel_accuracy_bits() > 100
            wide = kind.ball(acb(arb(number, 0.2), arb(0, 0.1)), acb(order))
            assert wide.contains(kind.ball(acb(number + 0.1, 0.05), acb(order))) or not wide.is_finite()
            slope = kind.series(arb_series([number, 1]), arb(order))[1]
            assert slope.overlaps(kind.ball(acb(number), acb(order + 1)).real)


@sample(1)
@pytest.mark.parametrize("kind", [Langevin, Sinc])
def test_the_bound_on_removable_functions_holds(kind):
    """By Cauchy's estimate the power series is cut off: from its size on a circle, here on each arc, in balls."""
    with working_precision(80):
        for k in range(1000):
            z = 3 * acb(arb((k + 0.5) / 500, 1 / 1000)).exp_pi_i()
            assert balls.ball_value(kind(x, 0).elementary(), {x: z}).abs_upper() < 8


CUTS = {sp.log: [-2, 0], sp.atan: [2j, -3j], sp.asinh: [2j, -3j], sp.acosh: [0, -2], sp.asin: [2, -3],
        sp.acos: [2], sp.atanh: [2, -3], sp.exp: [], sp.tanh: [], sp.erf: []}  # fmt: skip


@pytest.mark.parametrize("kind", list(CUTS), ids=lambda kind: kind.__name__)
def test_cuts_lie_where_values_jump(kind):
    row = FUNCTIONS[kind]
    for place in CUTS[kind]:
        assert row.cut(acb(complex(place).real, complex(place).imag))
    rng = np.random.default_rng(3)
    for _ in range(40):  # away from a cut the values on both sides of a small disc agree
        z = complex(*rng.normal(size=2) * 2)
        if not row.cut(acb(z.real, z.imag)):
            near = complex(row.ball(acb(z.real + 1e-9, z.imag - 1e-9)))
            assert abs(near - complex(row.ball(acb(z.real, z.imag)))) < 1e-5 * (1 + abs(near))


@pytest.mark.parametrize("outer", [lambda p: p**2, lambda p: 1 / p, lambda p: 3 - p**x, lambda p: -(p**-2) * x])
def test_powers_of_long_numbers_keep_brackets(outer):
    """(a^b)^2 as text, as LaTeX and as code: a^b^2 would be a^(b^2)."""
    expr = outer(functions.power(sp.Rational("0.0788816"), sp.Rational("1.4144337")))
    value = float(sp.sympify(outer(sp.Float(0.0788816**1.4144337))).subs(x, 1.3))
    assert value == pytest.approx(float(expr.subs(x, 1.3)), rel=1e-14)
    assert value == pytest.approx(function_of([x], expr, "numpy")(1.3), rel=1e-14)
    assert value == pytest.approx(float(sp.sympify(printing.text(expr).replace("x", "1.3"))), rel=1e-14)
    assert "}^{2}" not in printing.latex(expr)


def test_fold_visits_each_distinct_node_once():
    seen = []
    expr = sp.exp(x) + x * sp.exp(x) ** 2 + sp.hyper([1, x], [2], x)
    functions.fold(expr, lambda node, parts: seen.append(node))
    assert len(seen) == len(set(seen))
    assert functions.fold(expr, lambda node, parts: 1 + max(parts, default=0)) >= 4


def test_exact_numbers_of_any_length_are_computed_with():
    x, number = sp.Symbol("x"), sp.Rational(-(10**5000) - 1, 3)
    (value,) = function_of([x], [number * x], "mpmath")(mpmath.mpf(3))
    assert mpmath.almosteq(value, -(mpmath.mpf(10) ** 5000), rel_eps=1e-14)


@pytest.mark.parametrize("exponent", [12.0, 20.0, 24.0])
def test_a_high_power_is_rounded_once(exponent):
    """By products it would be off by some units."""
    x = np.random.default_rng(3).uniform(0.5, 3, 300)
    with mpmath.workdps(30):
        exact = np.array([float(mpmath.mpf(one) ** exponent) for one in x.tolist()])
    assert power_of(x, exponent) == pytest.approx(exact, rel=2.5e-16, abs=0)


def test_a_tolerance_below_what_doubles_hold_is_refused():
    assert read_rtol(5e-13) == 5e-13
    with pytest.raises(ss.InputError, match="outside 1e-13 to"):
        read_rtol(5e-14)
