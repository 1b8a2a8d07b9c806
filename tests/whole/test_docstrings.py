"""Examples and formulas in docstrings are held against what the code computes: a docstring that drifts fails."""

import ast
import doctest
import importlib
import inspect
import pkgutil
import re
from pathlib import Path

import mpmath
import numpy as np
import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym import symbols
from stickslip_sym.core.precision import working_precision
from stickslip_sym.model.formula_algebra import NotAnalytic
from stickslip_sym.model.leading_terms import ask_leading_terms
from stickslip_sym.model.taylor_model import taylor_model
from stickslip_sym.motion.slip import NondimensionalOscillator
from support.operating_points import paper_oscillator

PACKAGE = Path(ss.__file__).parent
LAW = ss.laws.exponential.typical()
SECTION = re.compile(r"^(?:Parameters|Attributes|Returns|Raises)\n-+", re.M)


def examples():
    """Docstrings of the package that hold examples."""
    for module in pkgutil.walk_packages(ss.__path__, "stickslip_sym."):
        for example in doctest.DocTestFinder().find(importlib.import_module(module.name)):
            if example.examples:
                yield pytest.param(example, id=example.name.removeprefix("stickslip_sym."))


def run_example(example):
    """Return what a docstring prints otherwise than it says; empty if nothing."""
    said = []
    doctest.DocTestRunner(verbose=False).run(example, out=said.append)
    return "".join(said)


@pytest.mark.parametrize("example", list(examples()))
def test_examples_print_what_they_say(example):
    assert run_example(example) == ""


@pytest.mark.parametrize("name", [name for name in ss.__all__ if inspect.isfunction(getattr(ss, name))])
def test_public_functions_have_an_example(name):
    assert re.search(r"^Examples\n-+\n(.+\n)*>>> ", inspect.getdoc(getattr(ss, name)), re.M)


def test_a_wrong_example_is_noticed():
    wrong = doctest.DocTestParser().get_doctest(">>> 1 + 1\n3\n", {}, "wrong", None, 0)
    assert "Expected:\n    3\nGot:\n    2\n" in run_example(wrong)


def displayed():
    """Lines of a docstring's text that are set apart and hold an equation."""
    for path in sorted(PACKAGE.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
                text = SECTION.split(ast.get_docstring(node) or "")[0]
                yield from (line.strip() for line in text.splitlines() if re.match(r"    .*=", line))


def check_slope_average():
    """The criterion least_squares of a law of unknown form, from the average and from (16)."""
    s, u, V, N = symbols.s, symbols.u, symbols.V, symbols.N
    for mu in (u, u**3, sp.exp(-u), 1 / (1 + u)):
        slope = sp.diff(mu, u).subs(u, V * (1 + s))
        average = -N * sp.integrate(ss.criteria.least_squares.weight * slope, (s, -1, 1))
        moment = 5 * N / (2 * V**5) * sp.integrate(mu * (V - u) ** 3, (u, 0, 2 * V))
        values = {V: sp.Rational(7, 10), N: 3}
        assert sp.N((average - moment).subs(values), 30, chop=True) == 0
    for criterion in (ss.criteria.least_squares, ss.criteria.harmonic):
        assert sp.integrate(criterion.weight, (s, -1, 1)) == 1


def check_lienard():
    """Differentiate the equation of motion once; time in 1/omega, z = x'/V."""
    m, k, c, N, V, tau = sp.symbols("m k c N V tau", positive=True)
    z, mu = sp.Function("z")(tau), sp.Function("mu")
    omega = sp.sqrt(k / m)
    # x' = V z; every further derivative by time brings omega.
    motion = m * V * omega**2 * z.diff(tau, 2) + c * V * omega * z.diff(tau) + k * V * z
    friction = N * omega * mu(V * (1 - z)).diff(tau)
    d, slip = c / sp.sqrt(k * m), sp.Symbol("slip")
    g = -N * mu(slip).diff(slip).subs(slip, V * (1 - z)) / sp.sqrt(k * m)
    lienard = z.diff(tau, 2) + (d - g) * z.diff(tau) + z
    assert sp.simplify(((motion - friction) / (k * V) - lienard).doit()) == 0


def check_rates():
    """The rates of q and w are those of the equation of motion, in units."""
    osc, rng = paper_oscillator(1.3), np.random.default_rng(8)
    system = NondimensionalOscillator.of(LAW.bound, osc)
    for q, w, side in zip(rng.normal(size=9), rng.uniform(0.1, 3, 9), (1, -1, 1) * 3, strict=True):
        x, v = osc.onset(LAW) + osc.length * q, osc.V * (1 - side * w)
        force = side * osc.N * LAW.mu(osc.V * w)
        acceleration = (force - osc.c * v - osc.k * x) / osc.m
        expected = -side * acceleration / (osc.V * osc.omega)
        assert system.acceleration(q, w, side) == pytest.approx(expected, rel=1e-12)
        assert 1 - side * w == pytest.approx(v / (osc.length * osc.omega), rel=1e-12)


@mpmath.workdps(15)
def check_terms():
    """A criterion as the sum of the averages of the law's profiles, each by its definition."""
    law, V, N = ss.laws.exponential_viscous.typical(), mpmath.mpf("0.4"), 3
    for criterion in (ss.criteria.least_squares, ss.criteria.harmonic):
        weight, total = sp.lambdify(symbols.s, criterion.weight, "mpmath"), 0
        for term in law.terms:
            values = [sp.N(part.subs(law.point), 20) for part in (term.amplitude, term.scale)]
            amplitude, scale = map(mpmath.mpmathify, values)
            meaning = {shape: value.subs(law.point) for shape, value in term.shapes.items()}
            slope = sp.lambdify(symbols.v, sp.diff(term.profile.subs(meaning), symbols.v), "mpmath")

            def weighed(s, slope=slope, weight=weight, r=V / scale):
                return -weight(s) * slope(r * (1 + s))

            total += N * amplitude / scale * mpmath.quad(weighed, [-1, 0, 1])
        exact = ss.quadrature.damping(law, criterion, V="0.4", N=N, digits=15)
        assert float(total) == pytest.approx(float(exact), rel=1e-9)


def wedge_of(first, second):
    return first[0] * second[1] - first[1] * second[0]


def check_wedge():
    """The wedge of the field with a derivative of the motion, from the variational equation."""
    q, w, eta, zeta, V, mu_s = sp.symbols("q w eta zeta V mu_s")
    b = sp.Symbol("b")  # dw'/dp
    mu, state = sp.Function("mu"), sp.Matrix([q, w])
    for side in (1, -1):
        field = sp.Matrix([1 - side * w, eta * (side * mu_s - mu(V * w)) + side * q - 2 * zeta * w])
        jacobian, along = field.jacobian(state), sp.Matrix(sp.symbols("q_p w_p"))
        rate = wedge_of(jacobian * field, along) + wedge_of(field, jacobian * along + sp.Matrix([0, b]))
        divergence = -eta * V * mu(sp.Symbol("x")).diff().subs(sp.Symbol("x"), V * w) - 2 * zeta
        stated = divergence * wedge_of(field, along) + (1 - side * w) * b
        assert sp.simplify((rate - stated).doit()) == 0


def check_gap():
    """At w = 1, where q' = 0, a derivative of the rate r = w' follows from the wedge."""
    r, q_p, w_p, b, p = sp.symbols("r q_p w_p b p", positive=True)
    wedge = wedge_of(sp.Matrix([0, r]), sp.Matrix([q_p, w_p]))
    assert sp.simplify((b + q_p) - (b - wedge / r)) == 0  # w' grows with q at the rate 1
    r_f, r_b = sp.Function("r_f")(p), sp.Function("r_b")(p)
    assert sp.simplify(sp.log(r_f / r_b).diff(p) - (r_f.diff(p) / r_f - r_b.diff(p) / r_b)) == 0


def check_creeping():
    """How a state moves off the line q = s x, from q' = -x and x' = q - K x."""
    x, s, beyond = sp.symbols("x s beyond", positive=True)
    K = s + 1 / s + beyond
    rate = -x - s * (s * x - K * x)
    assert sp.expand(rate - (-x - s * (s - K) * x)) == 0
    assert sp.expand(rate - s * beyond * x) == 0


def check_taylor_model():
    """What the series leaves out of (1 - exp(-v))/v, all around the circle."""
    v = symbols.v
    with working_precision(100), mpmath.workdps(40):
        model = taylor_model((1 - sp.exp(-v)) / v, {})
        coefficients = [mpmath.mpf(c.mid().str(35, radius=False)) for c in model.polynomial]
        radius, rest = float(model.radius), float(model.rest.abs_upper())
        for turn in np.linspace(0, 1, 12):
            x = mpmath.mpf(radius) * mpmath.expjpi(2 * turn)
            series = x**model.low * mpmath.polyval(coefficients[::-1], x)
            off = abs((1 - mpmath.exp(-x)) / x - series)
            assert off <= radius**model.top * rest * (1 + 1e-9) + 1e-30


def check_leading_terms():
    """What the terms of a function with a root and a logarithm leave out falls as the orders left out say."""
    v = symbols.v
    f = sp.sqrt(v) * sp.exp(-v) / (1 - v * sp.log(v))

    def three_terms(found):
        if len(found.terms) < 3:
            raise NotAnalytic("too few")
        return found

    known = ask_leading_terms(f, three_terms)
    exact = sp.lambdify(v, f, "mpmath")
    with mpmath.workdps(60):
        ratios = []
        for x in (mpmath.mpf(10) ** -8, mpmath.mpf(10) ** -10):
            root, L = mpmath.sqrt(x), -mpmath.log(x)
            values = {(e, n): root ** int(2 * e) * L ** int(n) for e, n in known.orders}
            series = sum(float(c) * values[order] for order, c in known.terms.items())
            ratios.append(abs(exact(x) - series) / max(values[order] for order in known.left_out))
    assert 0 < ratios[1] < 2 * ratios[0] < 20


CHECKS = {
    "f = sum of c x^e L^n  +  O(x^p L^q)": check_leading_terms,
    "f = x^low (c_0 + c_1 x + ...) + x^top g(x),    |g(x)| <= rest    for complex |x| <= radius.":
        check_taylor_model,
    "(q - s x)' = -x - s (s - K) x >= 0    where    K >= s + 1/s.": check_creeping,
    "c = N sum_i amplitude_i/scale_i F_i(V/scale_i).": check_terms,
    "D' = (div f) D + (1 - side w) dw'/dp,    div f = -eta V mu'(V w) - 2 zeta.": check_wedge,
    "dr/dp = dw'/dp - D/r,    dg/dp = (dr_f/dp)/r_f - (dr_b/dp)/r_b.": check_gap,
    "c = N <-mu'(V(1 + s))>_w = -N * integral_{-1}^{1} w(s) mu'(V(1 + s)) ds,    integral of w = 1.":
        check_slope_average,
    "z'' + (d - g(z)) z' + z = 0,    g(z) = -N mu'(V(1 - z))/sqrt(k m),    d = c/sqrt(k m).": check_lienard,
    "z'' + (d - g(z)) z' + z = 0,    d = c/sqrt(k m).": check_lienard,
    "q' = 1 - side w,    w' = eta (side mu_static - mu(V w)) + side q - 2 zeta w.": check_rates,
}  # fmt: skip


def test_every_displayed_formula_has_its_check():
    assert set(displayed()) == set(CHECKS)


@pytest.mark.parametrize("check", dict.fromkeys(CHECKS.values()), ids=lambda check: check.__name__)
def test_a_displayed_formula_holds(check):
    check()
