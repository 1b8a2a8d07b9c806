"""Formulas in docstrings are held against what the code computes: a docstring that drifts fails."""

import ast
import re
from pathlib import Path

import mpmath
import numpy as np
import pytest
import sympy as sp
from families import family_of
from scenes import paper_oscillator
from scipy.integrate import DOP853, solve_ivp
from sympy.parsing.sympy_parser import implicit_multiplication, parse_expr, standard_transformations

import stickslip_sym as ss
from stickslip_sym import symbols
from stickslip_sym.model.oscillator import Scene
from stickslip_sym.motion.ensemble.field import Field
from stickslip_sym.motion.simulation.slip import follow
from stickslip_sym.motion.simulation.steppers import Point

PACKAGE = Path(ss.__file__).parent
LAW = ss.laws.exponential.typical()
SECTION = re.compile(r"^(?:Parameters|Attributes|Returns|Raises)\n-+", re.M)


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
        average = -N * sp.integrate(
            ss.criteria.least_squares.weight * sp.diff(mu, u).subs(u, V * (1 + s)), (s, -1, 1)
        )
        moment = 5 * N / (2 * V**5) * sp.integrate(mu * (V - u) ** 3, (u, 0, 2 * V))
        values = {V: sp.Rational(7, 10), N: 3}
        assert sp.N((average - moment).subs(values), 30, chop=True) == 0
    for criterion in (ss.criteria.least_squares, ss.criteria.harmonic):
        assert sp.integrate(criterion.weight, (s, -1, 1)) == 1


def check_gauss_substitution():
    s, phi = symbols.s, sp.Symbol("phi")
    for criterion in (ss.criteria.least_squares, ss.criteria.harmonic):
        weight, slope = (
            sp.lambdify(symbols.s, part, "mpmath") for part in (criterion.weight, sp.exp(-3 * (1 + s)))
        )

        def angle(p, weight=weight, slope=slope):
            place = -mpmath.cos(2 * p)
            return weight(place) * slope(place) * 4 * mpmath.sin(p) * mpmath.cos(p)

        plain = mpmath.quad(lambda x, w=weight, g=slope: w(x) * g(x), [-1, 0, 1])
        assert mpmath.almosteq(mpmath.quad(angle, [0, mpmath.pi / 2]), plain, 1e-10)
    assert sp.diff(-sp.cos(2 * phi), phi).equals(4 * sp.sin(phi) * sp.cos(phi))


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


def check_slip_speed():
    """Lienard's equation in w = 1 - z."""
    tau, d = sp.symbols("tau d")
    w, g = sp.Function("w")(tau), sp.Function("g")
    u, z = w.diff(tau), 1 - w
    lienard = z.diff(tau, 2) + (d - g(z)) * z.diff(tau) + z
    assert sp.simplify(lienard.doit() + u.diff(tau) - ((g(z) - d) * u + 1 - w)) == 0
    check_lienard()


def check_scene():
    """The rates of q and w are those of the equation of motion, in units."""
    osc, rng = paper_oscillator(1.3), np.random.default_rng(8)
    scene = Scene.of(LAW, osc)
    for q, w, side in zip(rng.normal(size=9), rng.uniform(0.1, 3, 9), (1, -1, 1) * 3, strict=True):
        x, v = osc.onset(LAW) + osc.length * q, osc.V * (1 - side * w)
        force = side * osc.N * LAW.mu(osc.V * w)
        acceleration = (force - osc.c * v - osc.k * x) / osc.m
        assert scene.acceleration(q, w, side) == pytest.approx(
            -side * acceleration / (osc.V * osc.omega), rel=1e-12
        )
        assert 1 - side * w == pytest.approx(v / (osc.length * osc.omega), rel=1e-12)


def check_levels():
    """The course of a slip phase that was followed in time."""
    osc = paper_oscillator(1.3)
    scene = Scene.of(LAW, osc)
    phase = follow(scene, Point(0.0, 0.0, 0.0), 1, horizon=5.0, rtol=1e-12)
    for tau in np.linspace(0.3, 4.7, 9):
        (q, w), step = phase.at(tau), 1e-5
        dq, dw = phase.at(tau + step) - phase.at(tau - step)
        rate = scene.eta * (scene.static - LAW.mu(osc.V * w)) + q - 2 * osc.zeta * w
        assert dq * rate == pytest.approx((1 - w) * dw, abs=1e-8 * step)
        assert abs(dw) > 1e-8 * step


def check_stages():
    """A step of many masses, stage by stage as the method is written down for q and w."""
    scene, rng = Scene.of(LAW, paper_oscillator(1.3)), np.random.default_rng(9)
    q, w, h = rng.normal(size=9), rng.uniform(0.5, 3, 9), rng.uniform(0.01, 0.2, 9)
    side, field = np.tile((1.0, -1.0, 1.0), 3), Field(scene)
    rise = field.rise(np.zeros(9, dtype=int))
    rates = []
    for i in range(12):
        at_q, at_w = (
            line + h * sum((a * rate[k] for a, rate in zip(DOP853.A[i], rates, strict=False)), np.zeros(9))
            for k, line in enumerate((q, w))
        )
        slopes = [scene.acceleration(*state) for state in zip(at_q, at_w, side, strict=True)]
        rates.append((1 - side * at_w, np.array(slopes)))
    expected = [line + h * (DOP853.B @ [rate[k] for rate in rates]) for k, line in enumerate((q, w))]
    found = field.step(rise, q, w, side, field.slope(rise, q, w, side), h)
    assert found[0] == pytest.approx(expected[0], rel=1e-13)
    assert found[1] == pytest.approx(expected[1], rel=1e-13)


def check_family():
    """The rate of w of several oscillators at once is that of each."""
    V, eta, zeta, q, w = np.random.default_rng(10).uniform(0.1, 2.0, (5, 9))
    family = family_of(LAW, V, eta)
    rates = family.friction(w, family.piece(w)) + q - 2 * zeta * w
    for i, rate in enumerate(rates):
        osc = ss.Oscillator(m=1, k=1, c=2 * zeta[i], V=V[i], N=eta[i] * V[i])
        assert rate == pytest.approx(Scene.of(LAW, osc).acceleration(q[i], w[i], 1), rel=1e-12)


def check_touch():
    """Half-way from P and from the touch, by SciPy: the same at the threshold; apart at the rate pi."""

    def mismatch(eta, zeta):
        def rates(_, state):
            q, w = state
            return 1 - w, eta * (LAW.mu(0.0) - LAW.mu(0.5 * abs(w))) + q - 2 * zeta * w

        def away(time):  # from rest, where w = 1
            def half(_, state):
                return state[1] - 1

            half.terminal, half.direction = True, -np.sign(time)  # after the highest w, or before it
            found = solve_ivp(rates, (0, time), (0.0, 0.0), events=half, rtol=1e-11, atol=1e-12)
            return abs(found.y_events[0][0][0] - (2 * zeta - eta * (LAW.mu(0.0) - LAW.mu(0.5))))

        forward, back = away(10.0), away(-10.0)
        return (forward - back) / (forward + back)

    threshold = ss.pure_slip_damping(LAW, V=0.5, N=0.5, m=1, k=1, method="orbit").value / 2
    assert abs(mismatch(1.0, threshold)) < 1e-9
    assert mismatch(1.0, threshold + 0.01) < -0.01 < 0.01 < mismatch(1.0, threshold - 0.01)
    assert (mismatch(1e-9, 1e-4) - mismatch(1e-9, -1e-4)) / 2e-4 == pytest.approx(-np.pi, rel=1e-5)


CHECKS = {
    "c = N <-mu'(V(1 + s))>_w = -N * integral_{-1}^{1} w(s) mu'(V(1 + s)) ds,    integral of w = 1.":
        check_slope_average,
    "c = -N * integral_0^(pi/2) w(s) mu'(v) 4 sin(phi) cos(phi) dphi,    s = -cos(2 phi),":
        check_gauss_substitution,
    "z'' + (d - g(z)) z' + z = 0,    g(z) = -N mu'(V(1 - z))/sqrt(k m),    d = c/sqrt(k m).": check_lienard,
    "z'' + (d - g(z)) z' + z = 0,    d = c/sqrt(k m).": check_lienard,
    "w' = u,    u' = (g - d) u + 1 - w,    g = -N mu'(V w)/sqrt(k m),    d = c/sqrt(k m).": check_slip_speed,
    "q' = 1 - side w,    w' = eta (side mu_static - mu(V w)) + side q - 2 zeta w.": check_scene,
    "dq/dw = (1 - w)/w',    w' = eta (mu_static - mu(V w)) + q - 2 zeta w.": check_levels,
    "w_i = w + h sum_j A_ij w'_j,    side q_i = side q + c_i h (side - w) - h^2 sum_j (A^2)_ij w'_j.":
        check_stages,
    "q' = 1 - w,    w' = eta (mu_static - mu(V w)) + q - 2 zeta w.": check_family,
    "F(zeta) = (q_f - q_b)/(q_f + q_b)": check_touch,
}  # fmt: skip


def test_every_displayed_formula_has_its_check():
    assert set(displayed()) == set(CHECKS)


@pytest.mark.parametrize("check", dict.fromkeys(CHECKS.values()), ids=lambda check: check.__name__)
def test_a_displayed_formula_holds(check):
    check()


def formula_in(text, pattern):
    """Read a formula out of a docstring, with products written as blanks."""
    found = re.search(pattern, text)
    assert found, text
    return parse_expr(
        found[1], transformations=(*standard_transformations, implicit_multiplication), local_dict=NAMES
    )


NAMES = {name: sp.Symbol(name) for name in ("mu_static", "N", "c", "V", "k", "m", "x")}


@pytest.mark.parametrize(
    ("documented", "pattern", "value"),
    [
        (ss.Oscillator.onset, r"x_P = (.*?/k)", lambda osc: osc.onset(LAW)),
        (ss.Oscillator.zeta.fget, r"ratio (.*)\.", lambda osc: osc.zeta),
        (ss.Oscillator.eta.fget, r"flux, (.*)\.", lambda osc: osc.eta),
        (ss.Oscillator.omega.fget, r"frequency (.*) in", lambda osc: osc.omega),
    ],
    ids=["onset", "zeta", "eta", "omega"],
)
def test_an_inline_formula_holds(documented, pattern, value):
    osc = paper_oscillator(1.3)
    values = {"mu_static": LAW.mu(0.0), "N": osc.N, "c": osc.c, "V": osc.V, "k": osc.k, "m": osc.m}
    formula = formula_in(documented.__doc__, pattern).subs(
        {NAMES[name]: number for name, number in values.items()}
    )
    assert float(formula) == pytest.approx(value(osc), rel=1e-14)
