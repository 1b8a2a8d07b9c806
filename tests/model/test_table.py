"""`FrictionTable` against enclosures of the laws it holds."""

import dataclasses
import math
from itertools import pairwise

import mpmath
import numpy as np
import pytest
import sympy as sp
from flint import acb, arb
from hypothesis import assume, example, given
from hypothesis import strategies as st

import stickslip_sym as ss
from stickslip_sym.core import balls, symbols
from stickslip_sym.model.at_rest import rises_of
from stickslip_sym.model.expression.pieces import branch_from
from stickslip_sym.model.expression.transitions import transitions
from stickslip_sym.model.table import FARTHEST, TABLE_DEGREE, FrictionTable, _Segment
from stickslip_sym.motion.kernel.forces import slope_at
from stickslip_sym.motion.kernel.slip_data import Branch
from support.narrow_laws import SHAPES, narrow_law
from support.strategies import laws
from support.sweeps import sample

SLOWEST, FASTEST = 1e-9, 1e6  # belt speeds in m/s
OFF = 1e-13  # of the rise
CHECKED, BITS = np.array([1, 3, 5]) / 6, 400  # parts of an interval, and the precision of enclosures


MEASURED = ss.FrictionLaw.from_samples([0, 0.003, 0.1, 0.5, 2], [0.5, 0.42, 0.47, 0.3, 0.35], extrapolate=True)


def deviation(law, table=None):
    """Return by how much a table is off, as enclosures of the law's rise in ball arithmetic show.

    A deviation is relative to the largest rise up to its speed, so to the rise itself where that is monotone.
    """
    table = law.bound.table if table is None else table
    ends = np.append(table.pieces[:, 0], table.end)
    worst, highest = 0.0, arb(0)
    with balls.working_precision(BITS):
        segments = [
            balls.ball_function(branch_from(law.expr, law.point, begin), symbols.v, law.point)
            for begin in (sp.Integer(0), *law.kinks())
        ]
        start = segments[0](acb(arb(2) ** -BITS), False).real  # as good as the limit, where that is 0/0
        for i, (low, high) in enumerate(pairwise(ends)):
            mu = segments[np.searchsorted(table.firsts, i, side="right") - 1]
            if high > SLOWEST * 1e-3 and low < FASTEST * 1e3:
                for v in (low + (high - low) * CHECKED).tolist():
                    exact = mu(acb(arb(v)), False).real - start
                    highest = max(highest, exact.abs_lower())
                    off = (exact - arb(table.rise(v))).abs_upper()
                    worst = max(worst, float(off / highest) if highest > 0 else float(off))
    return worst


@sample(10)
@pytest.mark.parametrize("name", list(ss.laws.catalogue))
def test_catalogue_within_enclosures(name):
    assert deviation(getattr(ss.laws, name).typical()) < OFF


@given(laws())
@example(MEASURED)
@example(ss.FrictionLaw("0.5 - 0.2*sqrt(v)/(0.3 + v)"))
@example(ss.FrictionLaw("0.5 - 0.2*v^0.6"))
def test_random_laws_within_enclosures(law):
    assert deviation(law) < OFF


@given(st.sampled_from(list(ss.laws.catalogue)), st.floats(-0.3, 0.3), st.floats(1, 8))
@example("rational", -0.19, 5.3)
def test_derivatives_by_parameters_have_tables(name, decade, reach):
    """Sensitivities follow them; far from rest they fall through 0, where products of their terms cancel."""
    law = ss.laws[name].typical()
    law = law.bind(**{key: f"{float(value) * 10**decade:.6g}" for key, value in law.values.items()})
    for partial in map(law.partial, law.parameters):
        table = partial.bound.table_up_to(reach)
        v = np.linspace(0.01, 0.99, 30) * min(reach, table.end)
        rises = partial.at_speeds(v) - table.onset
        assert np.abs(rises - [table.rise(x) for x in v]).max() <= 1e-11 * np.abs(rises).max(initial=1e-3)


def test_deviation_notices_a_wrong_coefficient():
    law = ss.laws.exponential.typical()
    table = law.bound.table
    pieces = table.pieces.copy()
    pieces[3, 4] *= 1 + 1e-11
    assert deviation(law) < OFF < deviation(law, dataclasses.replace(table, pieces=pieces))


@given(laws(), st.floats(-6, 0.5))
def test_slope_is_that_of_the_law(law, exponent):
    table, v = law.bound.table, 10.0**exponent
    assume(all(abs(v - kink) > 1e-9 for kink in table.kinks))
    scale = max(abs(law.slope(v)), abs(table.rise(v)) / v)
    found = slope_at(Branch(table.pieces, 0, len(table.pieces) - 1, 0), v)
    assert found == pytest.approx(law.slope(v), abs=1e-9 * scale)


def test_scaling_by_the_belt_speed():
    law = ss.FrictionLaw("Piecewise((0.5 - 0.2*v, v < 0.3), (0.6, True))")
    table = law.bound.table
    for V in (1e-9, 0.5, 1e6):
        rise = table.at(V)
        assert rise.levels[1] * V == pytest.approx(0.3, rel=1e-15)
        assert rise.jumps == pytest.approx([0.0, 0.16], rel=1e-14)
    assert ss.FrictionLaw("0.5 - 0.1*Min(v, 0.3)").bound.table.at(1.0).jumps == [0.0, 0.0]


def test_table_ends_where_mu_does():
    assert ss.laws.exponential.typical().bound.table.end == FARTHEST
    measured = ss.FrictionLaw.from_samples([0, 0.1, 0.5, 2], [0.5, 0.4, 0.3, 0.3])
    assert measured.bound.table.end == measured.bound.table.reach == 2.0
    root = ss.FrictionLaw("0.3 + 0.2*sqrt(1 - v)").bound.table
    assert root.end == pytest.approx(1.0, rel=1e-9)
    assert math.isinf(root.reach)
    assert ss.FrictionLaw("0.3 + 0.1/(2 - v)").bound.table.end == pytest.approx(2.0, rel=1e-6)


def test_what_cannot_be_tabulated_is_refused():
    with pytest.raises(ss.InputError, match="bind"):
        _ = ss.laws.exponential.bound.table


@sample(5)
@pytest.mark.parametrize("shape", SHAPES)
def test_narrow_laws_within_enclosures(shape):
    law, _, relative = narrow_law(shape, 1)
    assert deviation(law) < OFF + 1e-15 / relative  # a speed is rounded, which shows where mu is steep


def test_a_step_between_the_nodes_is_seen():
    """The step lies half-way between two nodes of a piece of the same law without it."""
    smooth, text = between_nodes()
    between = float(text)
    for step in ("0.001*tanh((v - {a})/0.0000001)", "0.001*tanh((exp(v) - exp({a}))/0.0000001)"):
        law = ss.FrictionLaw(f"{smooth} + {step}".format(a=text))
        table = law.bound.table
        for v in (between * 0.999, between * 1.001):
            assert table.rise(v) == pytest.approx(law.mu(v) - law.mu(0.0), rel=1e-13)
        assert np.diff(table.narrow).min() < 1e-6
        assert not table.resolved(0.0, 2 * between, 100)
        assert table.resolved(0.0, 0.5 * between, 100)


def between_nodes():
    """Return a law, and a speed half-way between two nodes of a piece of its table."""
    smooth = "0.2 + 0.3*exp(-3*v)"
    _, middle, scale, *_ = ss.FrictionLaw(smooth).bound.table.pieces[1]
    return smooth, np.format_float_positional(middle + math.cos(math.pi * 8 / 15) / scale)


def test_a_bump_of_a_derivative_is_known_from_its_formula():
    """No ball is asked about a derivative by a parameter, and the bump lies between the nodes."""
    smooth, between = between_nodes()
    law = ss.FrictionLaw(f"{smooth} + h*exp(-((v - {between})/0.00001)^2)").bind(h=0.01)
    table = law.partial("h").bound.table_up_to(1.0)
    assert table.values(float(between) + np.array([-0.001, 0, 0.001])) == pytest.approx([0.0, 1.0, 0.0], abs=1e-9)


@sample(1)
@pytest.mark.parametrize("bump", ["exp(-((exp(v) - exp({a}))/{w})^2)", "1/(1 + ((sqrt(v) - sqrt({a}))/{w})^2)"])
def test_a_bump_that_no_formula_tells_is_seen_by_bounds(bump):
    """The argument is no polynomial in v; the bump lies between the nodes."""
    smooth, between = between_nodes()
    law = ss.FrictionLaw(f"{smooth} + 0.001*" + bump.format(a=between, w="0.00001"))
    assert all(change.width > 0.1 for change in transitions(law.expr, law.point))
    at = float(between)
    assert law.bound.table.rise(at) == pytest.approx(law.mu(at) - law.mu(0.0), rel=1e-11)


def test_a_law_that_varies_for_ever_is_tabulated_up_to_where_a_motion_comes():
    law = ss.FrictionLaw("0.35 + 0.1*exp(-v/0.3) + 0.01*sin(10*v)")
    table = law.bound.table
    assert 50 < table.end == table.reach < 1000
    v = np.linspace(0.0, 0.999 * table.end, 1000)
    assert table.values(v) == pytest.approx(law.mu(v) - law.mu(0.0), abs=1e-14)
    point = {"N": 9.81, "m": 1, "k": 100}
    found = ss.pure_slip_damping(law, V=0.5, **point, method="simulation")
    assert found.value == pytest.approx(0.89473021931, rel=1e-10)
    with pytest.raises(ss.InputError, match=r"varies too often to be tabulated beyond 0\.8"):
        ss.pure_slip_damping(law, V=300, **point, method="simulation")


@sample(4)
@pytest.mark.parametrize(
    "bump", ["exp(-(log(v/{a})/{w})^2)", "sech(log(v/{a})/{w})", "exp(-((sqrt(v/{a}) - 1)/{w})^2)"]
)
@pytest.mark.parametrize("seed", range(3))
def test_a_bump_of_a_law_that_is_flat_elsewhere_is_seen(bump, seed):
    """The first piece of such a table may reach from rest to any speed: no ball towards rest is left out."""
    random = np.random.default_rng(seed)
    a, w = 10.0 ** random.uniform(-6, 2), 10.0 ** random.uniform(-8, -2)
    law = ss.FrictionLaw(f"0.2 + 0.001*{bump}".format(a=repr(a), w=repr(w)))
    table = law.bound.table
    assert table.rise(a) == pytest.approx(1e-3, rel=1e-6)
    assert table.rise(a * (1 + 100 * w)) == pytest.approx(0, abs=1e-12)
    assert law.mu(a) == pytest.approx(0.201, rel=1e-9)


def made_of(*lows):
    """Return a table whose pieces begin at some speeds, and which ends at the last."""
    *begins, end = lows
    pieces = np.zeros((len(begins), 3 + TABLE_DEGREE + 1))
    pieces[:, 0] = begins
    return FrictionTable(0.3, 0.3, (), math.inf, end, False, pieces, (0, len(begins)))


def test_pieces_within_an_eighth_of_their_speed_are_narrow():
    assert made_of(0, 1, 1.12, 1.266, 2.5).narrow.tolist() == [[1, 1.12]]


def test_steps_end_where_pieces_are_so_narrow_that_stages_may_miss_them():
    """The second piece is 3 % of its speed wide, those after it 4 % and more."""
    assert made_of(0, 1, 1.03, 1.07, 1.12, 1.2)._landings.tolist() == [1, 2]


def test_a_law_varies_gradually_whose_pieces_are_a_twentieth_of_the_belt_speed_wide():
    assert [made_of(0, 0.5, 0.5 + width, 2.5).at(1.0).gradual for width in (0.08, 0.03)] == [True, False]


def test_what_a_transition_asks_of_an_interval():
    """That it is no wider than two of its widths, beside it one more for each that it is away."""
    segment = _Segment(np.asarray, 0.3, 0.0, 2.0, False, changes=np.array([[1.0], [0.1]]))
    low = np.array([0.9, 0.9, 1.1, 1.1])
    width = np.array([0.19, 0.21, 0.39, 0.41])
    assert segment.hides(low, low + width).tolist() == [False, True, False, True]


def test_what_is_left_after_four_halvings_may_be_the_noise_of_a_difference():
    segment = _Segment(np.asarray, 0.3, 0.0, 2.0, False)
    values, low = np.full((2, 3), 1e-6), np.ones(2)
    before, after = segment.noise(values, low, low + 0.1, np.array([3, 4]))
    assert after > 100 * before


@pytest.mark.parametrize("width", ["1e-3", "1e-8", "1e-14"])
@pytest.mark.parametrize("base", ["(0.3 + 0.2*exp(-v/0.1))", "(0.2 + 0.3/(1 + v/0.1))*(1 + 0.1*tanh(v))"])
def test_a_layer_at_rest_by_a_root_is_tabulated_however_thin(base, width):
    """Two terms of its slope cancel beyond the layer, and each is multiplied by a function."""
    law = ss.FrictionLaw(f"{base}*v/sqrt(v^2 + {width}^2)")
    assert law.bound.table.end >= 10
    v = np.append(np.geomspace(1e-3 * float(width), 10, 300), float(width) * np.array([0.1, 1, 3, 1e3]))
    assert law.bound.table.values(v) == pytest.approx(law.mu(v), rel=2e-13)


@pytest.mark.parametrize(("times", "is_seen"), [(2, False), (8, True)])
def test_a_slope_several_times_as_steep_as_that_of_a_polynomial_is_seen(times, is_seen):
    """Balls hold it around a speed between two nodes, of which no transition says anything."""
    steepest = 0.9 * math.exp(-1.5)

    def slope(z, _):
        narrow = acb(arb(0, times * steepest)) if z.real.overlaps(arb(0.773)) else acb(0)
        return acb(-0.9) * (-3 * z).exp() + narrow

    segment = _Segment(lambda v: 0.3 * np.expm1(-3 * v), 0.3, 0.5, 1.0, False, slopes=[slope])
    pieces, end = segment.tabulated()
    assert (len(pieces) > 1, end) == (is_seen, 1.0)


@pytest.mark.parametrize("text", ["0.2 + 0.3*exp(-3*v)", "0.002 + 0.003/(1 + v/0.1)"])
def test_a_rise_is_off_by_some_roundings(text):
    """A difference of two coefficients would be off by more, the smaller it is."""
    law = ss.FrictionLaw(text)
    ((_, rising),) = rises_of([(sp.S.Zero, law.expr)], {})
    v = np.geomspace(1e-4, 20, 200)
    with mpmath.workdps(40):
        mu = law.function("mpmath")
        exact = np.array([float(mu(mpmath.mpf(speed)) - mu(mpmath.mpf(0))) for speed in v.tolist()])
    assert rising(v) == pytest.approx(exact, rel=16 * 2.0**-52, abs=0)


@pytest.mark.parametrize("size", [1, 0.01])
def test_far_from_rest_a_rise_is_a_difference_however_small_the_coefficient(size):
    """Products of the terms of a fraction cancel there, and a table would end."""
    law = ss.FrictionLaw(f"{size}*(0.45*v^2 + 0.3*v + 0.5)/(v^2 + v + 1)")
    assert law.bound.table.reach == math.inf
