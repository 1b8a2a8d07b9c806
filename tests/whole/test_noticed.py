"""Single functions against their definitions: where one is wrong, a slower way takes over and other tests pass."""

import importlib
import math
import pkgutil
from dataclasses import is_dataclass
from itertools import pairwise

import numpy as np
import pytest
import sympy as sp
from mpmath import mp
from scenes import paper_oscillator

import stickslip_sym as ss
from stickslip_sym import criteria, symbols
from stickslip_sym.core.symbols import v
from stickslip_sym.criteria import gauss
from stickslip_sym.formula.derivation import tidy
from stickslip_sym.formula.evaluation import fitting, profile
from stickslip_sym.formula.evaluation.arguments import check_reach
from stickslip_sym.formula.evaluation.branches import CENTERS, MIDDLE, STRETCHES
from stickslip_sym.formula.evaluation.conditioning import speed_scales
from stickslip_sym.formula.integration import antiderivatives
from stickslip_sym.formula.integration.ladders import LADDERS
from stickslip_sym.model import samples
from stickslip_sym.model.expression import pieces, reading
from stickslip_sym.model.expression.parsing import MAX_DEPTH
from stickslip_sym.model.oscillator import Scene
from stickslip_sym.motion.maps import drawing
from stickslip_sym.motion.orbits.expansion import expand
from stickslip_sym.motion.orbits.orbit import obstacle, orbits
from stickslip_sym.motion.regimes import attractors, slip_orbits
from stickslip_sym.motion.simulation import engines
from stickslip_sym.motion.simulation.slip import follow
from stickslip_sym.motion.simulation.slip_phase import End
from stickslip_sym.motion.simulation.steppers import Point
from stickslip_sym.output import layout

SMOOTH = [criteria.least_squares, criteria.harmonic]
u, a, b = sp.symbols("u a b", positive=True)


@pytest.fixture
def rng():
    return np.random.default_rng(5)


def by_name(value):
    return getattr(value, "name", None) or getattr(value, "__name__", None)


@pytest.mark.parametrize("function", [f for f in LADDERS if f not in (sp.sech, sp.tanh)], ids=by_name)
def test_a_polynomial_times_a_function_is_integrated_by_its_ladder(function, rng):
    for n in range(3):
        rate, shift = (sp.Rational(int(q), 7) for q in rng.integers(1, 20, 2))
        integrand = u**n * function(rate * u + shift)
        _, found = antiderivatives.antiderivative(integrand, sp.Integer(1), u)
        place = float(rng.uniform(0.1, 2))
        slope = sp.diff(found, u)
        assert complex(slope.subs(u, place)) == pytest.approx(complex(integrand.subs(u, place)), rel=1e-12)


def test_polynomials_through_values_at_chebyshev_nodes(rng):
    for n in range(1, 9):
        coefficients = rng.standard_normal(n)
        values = np.polynomial.polynomial.polyval(fitting.chebyshev_nodes(n), coefficients)
        found = fitting.to_monomials(fitting.chebyshev_fit(values))
        assert np.asarray(found, dtype=float) == pytest.approx(coefficients, abs=1e-13)


@pytest.mark.parametrize("criterion", SMOOTH, ids=by_name)
@pytest.mark.parametrize(("slope", "decay"), [("-3*exp(-v)", 1.0), ("-1/(1 + v)**2", 0.0), ("v**3 - v", 0.0)])
def test_the_series_of_an_average_is_the_average(criterion, slope, decay):
    slope = sp.sympify(slope, locals={"v": v})
    coefficients, radius = fitting.taylor(slope, criterion, decay)
    r = radius / 8
    with mp.workdps(25):
        weight, of_v = sp.lambdify(symbols.s, criterion.weight, "mpmath"), sp.lambdify(v, slope, "mpmath")
        mean = -mp.quad(lambda s: weight(s) * of_v(r * (1 + s)), [-1, 0, 1])
        assert mp.polyval(coefficients[::-1], r) == pytest.approx(mp.exp(decay * r) * mean, rel=1e-14)


@pytest.mark.parametrize("criterion", SMOOTH, ids=by_name)
def test_gauss_averages_of_polynomials_are_their_moments(criterion, rng):
    """With parameters, panels of any first size, and kinks anywhere, where there are none."""
    count, degree = 40, 4
    speed, scale = 10 ** rng.uniform(-3, 3, count), 10 ** rng.uniform(-9, 6, count)
    coefficients = [rng.uniform(0.1, 1, count) * speed**-k for k in range(degree)]
    kinks = [speed * rng.uniform(0.0, 2.5, count) for _ in range(2)]

    def slope(v, *given):
        value = sum(c * v**k for k, c in enumerate(given))
        return value, 2 * abs(value)

    exact = sum(c * speed**k * float(criterion.mean_power(k)) for k, c in enumerate(coefficients))
    for given in ({}, {"scale": scale}, {"scale": scale, "kinks": kinks}):
        value, size, error = gauss.average(slope, speed, coefficients, criterion, **given)
        assert value == pytest.approx(exact, rel=1e-14)
        assert size == pytest.approx(exact, rel=1e-14)
        assert (abs(value - exact) <= error + 1e-16 * exact).all()
        assert (error < 1e-14 * exact).all()


def test_gauss_averages_are_split_at_kinks(rng):
    speed, height = 10 ** rng.uniform(-3, 3, 40), rng.uniform(0.1, 1, 40)
    kink = speed * rng.uniform(0.1, 1.9, 40)

    def slope(v, height, kink):
        value = np.where(v < kink, height, 0.0)
        return value, value

    s = kink / speed - 1
    exact = height * (0.5 + 0.625 * (s - s**5 / 5))
    value, _, error = gauss.average(slope, speed, [height, kink], criteria.least_squares, kinks=[kink])
    assert value == pytest.approx(exact, rel=1e-12)
    assert (error < 1e-13).all()


def test_scales_of_sums_are_where_two_terms_balance(rng):
    for _ in range(20):
        p, q = (int(n) for n in rng.choice(np.arange(5), 2, replace=False))
        (scale,) = speed_scales(a * v**p + b * v**q, v)
        assert sp.simplify(scale - (a / b) ** sp.Rational(1, q - p)) == 0
    assert speed_scales(a * v**2 + b * sp.sqrt(v**4), v) == []


def test_jumps_are_the_differences_of_neighbours(rng):
    for n in range(2, 5):
        places = sorted(sp.Rational(int(place), 10) for place in rng.choice(100, n - 1, replace=False))
        values = [sp.Integer(int(value)) for value in rng.choice(50, n, replace=False)]
        law = sp.Piecewise(*zip(values, [*(v < place for place in places), True], strict=True))
        heights = [after - before for before, after in pairwise(values)]
        assert pieces.jumps(1 + 2 * law) == [(place, 2 * h) for place, h in zip(places, heights, strict=True)]


def test_a_measured_law_serves_up_to_its_last_speed():
    law = ss.FrictionLaw.from_samples([0, 1, 2, 3], [0.5, 0.4, 0.35, 0.33])
    for criterion, reach in ((criteria.equilibrium, 3.0), (criteria.least_squares, 1.5), (criteria.harmonic, 1.5)):
        check_reach(law, criterion, [reach / 2, reach])
        with pytest.raises(ss.InputError):
            check_reach(law, criterion, [reach / 2, 1.001 * reach])


def test_the_largest_and_smallest_speeds_of_a_curve():
    for factor, good in ((sp.Rational(99, 100), True), (sp.Rational(101, 100), False)):
        for speeds in ([0, 1, 2, samples.LARGEST * factor], [0, 1 / (samples.LARGEST * factor), 1, 2]):
            if good:
                assert ss.FrictionLaw.from_samples(speeds, [4, 3, 2, 1]).v_max == speeds[-1]
            else:
                with pytest.raises(ss.InputError):
                    ss.FrictionLaw.from_samples(speeds, [4, 3, 2, 1])
    assert samples.LARGEST == 10**20


def test_nesting_is_read_to_its_limit():
    def nested(depth):
        return "(" * depth + "v" + ")" * depth

    assert MAX_DEPTH == 60
    assert ss.FrictionLaw(nested(60)).expr == v
    with pytest.raises(ss.InputError, match="more than 60 nested"):
        ss.FrictionLaw(nested(61))


def test_edges_of_cells_lie_half_way(rng):
    steps = rng.uniform(0.98, 1.02, 6)
    values = np.cumsum(steps)
    for found in (drawing.edges(values), np.log(drawing.edges(np.exp(values)))):
        assert found[1:-1] == pytest.approx((values[1:] + values[:-1]) / 2)
        assert found[[0, -1]] == pytest.approx([values[0] - steps[1] / 2, values[-1] + steps[-1] / 2])


def test_small_motions_grow_with_the_eigenvalues(rng):
    for _ in range(200):
        c, slope = rng.uniform(-60, 60), rng.uniform(-3, 3)
        osc = paper_oscillator(c=max(c, 0.0))
        matrix = np.array([[0, 1], [-osc.k / osc.m, -(osc.c + osc.N * slope) / osc.m]])
        largest = max(np.linalg.eigvals(matrix), key=lambda root: root.real)
        rate, half = attractors.swing(osc, slope)
        assert rate == pytest.approx(largest.real, rel=1e-9)
        assert half == pytest.approx(np.pi / abs(largest.imag) if largest.imag else np.inf)


def test_only_a_static_coefficient_above_the_kinetic_one_is_in_the_way(rng):
    for share in (*rng.uniform(1.001, 2, 5), 1.0):
        law = ss.FrictionLaw("0.2 + 0.3*exp(-v)", static=0.5 * share)
        assert (obstacle(law, 0.5) is not None) is bool(share > 1)
        assert obstacle(law, 0.5, jump=False) is None


def test_a_piece_goes_on_with_its_last_value():
    law = ss.FrictionLaw("Piecewise((0.5 - 0.1*sqrt(v), v < 0.5), 0.4 + 0.1*sqrt(v - 0.5))")
    scene = Scene.of(law, paper_oscillator(V=0.5))
    before, after = scene.branches
    assert scene.onset == 0.5
    assert [before.rise(w) for w in (-1.0, 0.0)] == [0.0, 0.0]
    assert [after.rise(w) for w in (0.25, 0.5, 1.0)] == pytest.approx([-0.1, -0.1, -0.1], rel=1e-15)
    assert after.rise(3.0) == pytest.approx(0.0, abs=1e-16)
    assert scene.rise(-1.0) == 0.0


@pytest.mark.parametrize("name", ["exponential", "polynomial"])
def test_weak_friction_slows_orbits_to_second_order(name):
    law, V, e = ss.laws.catalogue[name].typical(), np.array([0.3, 0.5]), np.array([1e-2, 2e-2])
    frequency = orbits(law, V, e).frequency
    assert (1 - frequency) / e**2 == pytest.approx(expand(law, V).slowing, rel=1e-3)


def test_a_factor_has_the_sign_of_the_law():
    x, y, z, small = sp.symbols("x y z small", positive=True)
    for model in (3 * x - 3 * y, sp.exp(3 * x - 3 * y), (3 * x - 3 * y) ** 2):
        for factor in (y - x, x - y):
            assert x - y in tidy.tidy(z * factor, model, small).args


def test_quadrature_splits_at_kinks_however_it_integrates():
    law = ss.FrictionLaw("Piecewise((0.5 - 0.2*v, v < 0.7), 0.36)")
    for criterion in SMOOTH:
        weight = sp.lambdify(symbols.s, criterion.weight, "mpmath")
        with mp.workdps(30):
            exact = 2 * mp.mpf("0.2") * mp.quad(weight, [-1, mp.mpf("0.7") / mp.mpf("0.5") - 1])
        found = ss.quadrature.damping(law, criterion, V="0.5", N=2, digits=20)
        assert float(abs(found / exact - 1)) < 1e-18


def test_what_is_returned_cannot_be_changed():
    names = [module.name for module in pkgutil.walk_packages(ss.__path__, "stickslip_sym.")]
    modules = [importlib.import_module(name) for name in names]
    classes = {value for module in modules for value in vars(module).values() if isinstance(value, type)}
    results = [one for one in classes if is_dataclass(one) and not one.__name__.startswith("_")]
    assert len(results) > 40
    mutable = {result.__name__ for result in results if not result.__dataclass_params__.frozen}
    # Steps are added to a derivation, interpolants to a phase that is followed, cells to those of a map, and
    # better rows to the state of an iteration, which counts its work.
    assert mutable == {"Cells", "Derivation", "SlipPhase", "State", "Work"}


def test_what_symbols_stand_for_is_known():
    for name in "VNmk":
        assert symbols.QUANTITIES[name].symbol.is_positive
    assert symbols.QUANTITIES["v"].symbol.is_nonnegative
    assert not symbols.QUANTITIES["v"].symbol.is_positive
    for name in "cxt":
        assert symbols.QUANTITIES[name].symbol.is_real
        assert symbols.QUANTITIES[name].symbol.is_positive is None


@pytest.mark.parametrize(("name", "zero"), [("V", False), ("N", True), ("m", False), ("k", False)])
def test_quantities_of_a_threshold_have_their_signs(name, zero):
    law, scene = ss.laws.polynomial.typical(), {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0, "method": "harmonic"}
    for value in (-1.0, [0.5, -1e-300]) + (() if zero else (0.0,)):
        with pytest.raises(ss.InputError, match=rf"{name} = .* must"):
            ss.pure_slip_damping(law, **scene | {name: value})
    if zero:
        assert ss.pure_slip_damping(law, **scene | {name: 0.0}).value == 0


def test_halves_of_an_octave_have_their_middles_and_widths():
    for center, stretch, low, high in zip(CENTERS, STRETCHES, (0.5, MIDDLE), (MIDDLE, 1.0), strict=True):
        assert [center - 1 / stretch, center + 1 / stretch] == pytest.approx([low, high], abs=1e-16)


def test_terms_are_counted_before_they_are_multiplied_out(rng):
    names = sp.symbols("p:9")
    for _ in range(10):
        n, power, more = (int(i) for i in rng.integers(1, 5, 3))
        expr = sp.Add(*names[:n]) ** power * sp.Add(*names[4 : 4 + more])
        assert reading._terms(expr) == math.prod(
            len(sp.Add.make_args(sp.expand(factor))) for factor in sp.Mul.make_args(expr)
        )


def test_a_line_is_not_broken_where_hardly_anything_stands_on_it():
    inner = " + ".join(f"b_{{{i}}}" for i in range(40))
    rows = layout.broken(f"a + ({inner})", 200.0, 200.0)
    assert len(rows[0]) > 40


@pytest.mark.parametrize("power", [-1, sp.Rational(-1, 2), 0, sp.Rational(1, 2), 2])
def test_far_out_an_average_goes_by_the_power_of_the_slope(power):
    law = sp.log(1 + v) if power == -1 else (1 + v) ** (power + 1)
    assert profile._Builder(law, criteria.harmonic)._power(2.0**60) == float(power)


def test_without_friction_a_round_is_a_swing(rng):
    """x' = V - r cos: from the belt's speed and back to it, the peak of the velocity is its amplitude."""
    law = ss.laws.polynomial.typical()
    for q in rng.uniform(0.2, 5, 5):
        scene = Scene.of(law, paper_oscillator(N=0.0))
        back, tau, speed = slip_orbits.round_from(scene, q, 1e-10)
        assert back == pytest.approx(q, rel=1e-7)
        assert tau == pytest.approx(2 * math.pi, rel=1e-8)
        assert speed == pytest.approx(math.hypot(1, q) - 1, rel=1e-7)


@pytest.mark.parametrize("engine", sorted(engines.ENGINES))
def test_motions_that_move_away_for_ever_say_so(engine):
    pytest.importorskip("heyoka" if engine == "heyoka" else "scipy")
    law = ss.FrictionLaw("0.5 - 0.8*v")
    scene = Scene.of(law, paper_oscillator(N=40.0))
    slip = follow(scene, Point(0.0, 1.0, 0.0), 1, horizon=1e3, rtol=1e-8, engine=engines.find(engine))
    assert slip.end is End.UNBOUNDED


def test_a_table_of_an_average_is_the_average(rng):
    """In all its panels, for arrays and for single numbers alike."""
    builder = profile._Builder(sp.exp(-v), criteria.harmonic)
    table = builder._table(0.25, 4.0)
    r = 2 ** rng.uniform(-2, 2, 200)
    value, size, _ = builder.averages(r)
    exact = np.asarray(value, dtype=float) * r**-table.power
    allowed = 4e-16 * np.asarray(size, dtype=float) * r**-table.power
    assert (np.abs(table(r) - exact) <= allowed).all()
    assert [table(one) for one in r.tolist()] == pytest.approx(table(r), rel=4e-16)
