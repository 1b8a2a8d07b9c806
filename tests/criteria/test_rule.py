"""Averages of the slope in floats against enclosures, of laws that vary quickly somewhere too."""

import dataclasses

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym.criteria.criterion import equilibrium, harmonic, least_squares
from stickslip_sym.criteria.rule import gauss_average, gauss_average_of_slope
from support.narrow_laws import SHAPES, narrow_law
from support.sweeps import sample, some, sweep


def off(law, criterion, V, **options):
    """Return what an average is off, and its stated error."""
    (average,), (error,), _ = gauss_average(law.bound, [V], criterion=criterion, **options)
    return abs(average - float(ss.enclose(law, criterion, V=V, N=1, digits=17))), error


ENCLOSED = [shape for shape in SHAPES if not shape.startswith("logarithmic")]
"""The harmonic integral of narrow functions of log(v) is not enclosed, but refused."""


@sample(5)
@pytest.mark.parametrize("shape", ENCLOSED)
def test_narrow_laws_within_the_stated_error(shape):
    law, V, _ = narrow_law(shape, 3)
    criterion = least_squares if shape in ("step", "jump") else harmonic
    deviation, error = off(law, criterion, V)
    assert deviation <= error
    assert error <= 1e-8 / V


@sweep("shape", sorted(SHAPES.keys() - set(ENCLOSED)), "logarithmic bump")
def test_narrow_functions_of_log_v_by_quadrature(shape):
    """Of high powers of v, whose exact coefficients have thousands of digits."""
    law, V, _ = narrow_law(shape, 3)
    (average,), (error,), _ = gauss_average(law.bound, [V], criterion=harmonic)
    assert abs(average - float(ss.quadrature.damping(law, harmonic, V=V, N=1, digits=12))) <= error + 1e-11


def over_24_decades(name, count):
    """Return belt speeds of a law, another one in each of some equal ranges of the logarithm."""
    rng = np.random.default_rng([*name.encode()])
    return 10.0 ** (-12 + 24 * (np.arange(count) + rng.uniform(size=count)) / count)


@sample(10)
@pytest.mark.parametrize("name", ss.laws)
def test_the_rule_is_within_its_error_over_24_decades(name):
    law = ss.laws[name].typical()
    for V, criterion in zip(over_24_decades(name, 4).tolist(), [least_squares, harmonic] * 2, strict=True):
        deviation, error = off(law, criterion, V)
        assert deviation <= error
        assert error <= 1e-12 * gauss_average(law.bound, [V], criterion=criterion)[2][0]


@pytest.mark.thorough
@pytest.mark.parametrize("criterion", [least_squares, harmonic])
@pytest.mark.parametrize("name", ss.laws)
def test_four_ways_to_an_average_agree_over_24_decades(name, criterion):
    """The definition, the enclosure, the rule in floats and the fast function, relative to <|mu'|>."""
    law = ss.laws[name].typical()
    fast = ss.slope_average(law, criterion)
    for V in over_24_decades(name, 5).tolist():
        (rule,), (error,), (size,) = gauss_average(law.bound, [V], criterion=criterion)
        enclosed = float(ss.enclose(law, criterion, V=V, N=1, digits=17))
        assert abs(rule - enclosed) <= error
        assert abs(fast(V=V, N=1.0) - enclosed) <= 4e-15 * size
        assert abs(float(ss.quadrature.damping(law, criterion, V=V, N=1, digits=17)) - enclosed) <= 4e-16 * size


@sweep("criterion", [least_squares, harmonic], harmonic)
def test_far_out_the_slope_counts_and_not_the_rounding_of_mu(criterion):
    """There an average is 1/V or less of mu/V: differences of values of mu would know no digit of it."""
    for name in some(("exponential", "rational", "arctangent", "bengisu_akay"), 2):
        for V in (1e6, 1e9, 1e12):
            deviation, error = off(ss.laws[name].typical(), criterion, V)
            value = float(ss.enclose(ss.laws[name].typical(), criterion, V=V, N=1))
            assert deviation <= error <= 1e-9 * abs(value)


def blind(law):
    """Return the table of a law without the ends of its narrow pieces."""
    table = dataclasses.replace(law.bound.table)
    vars(table)["narrow"] = np.empty((0, 2))
    return table


def test_panels_are_cut_until_polynomials_follow_the_slope():
    law = ss.FrictionLaw("0.4 - 0.1*v^2 + 0.01*cos(40*v)")
    deviation, error = off(law, harmonic, 1.0, table=blind(law))
    assert deviation <= error < 1e-11


def test_panels_are_parted_for_a_fall_within_a_hundredth_of_its_speed_and_not_for_noise():
    def counted(slope):
        asked = []

        def slope_of(v):
            asked.append(v.size)
            return slope(v)

        _, (error,), (size,) = gauss_average_of_slope(slope_of, like, [1.0], criterion=harmonic)
        return error / size, sum(asked)

    like = ss.FrictionLaw("0.3 + 0.1*v").bound.table
    error, _ = counted(lambda v: np.exp(-(((v - 1.1) / 0.01) ** 2)))
    assert error < 1e-9
    error, asked = counted(lambda v: np.sin(1e6 * v))
    assert error > 1e-3
    assert asked < 100_000


def test_slopes_that_are_not_the_rise_are_an_error():
    """A table that does not part a bump leaves the rule to its nodes; the sum of the slopes tells a step."""
    law = ss.FrictionLaw("0.2 + 0.3*exp(-3*v) - 0.02*tanh((v - 0.3)/0.00001)")
    deviation, error = off(law, harmonic, 0.5, table=blind(law))
    assert deviation <= error
    assert error > 1e6 * off(law, harmonic, 0.5)[1]


def test_equilibrium_at_a_kink_takes_the_mean_of_both_slopes():
    law = ss.FrictionLaw("0.5 - 0.1*v^2 - 0.3*Max(v - 0.3, 0)")
    for V, exact in (("0.3", 0.21), ("0.299999", 0.0599998), ("0.300001", 0.3600002)):
        assert gauss_average(law.bound, [float(V)], criterion=equilibrium)[0][0] == pytest.approx(exact, rel=1e-13)
        assert float(ss.enclose(law, "equilibrium", V=V, N=1)) == pytest.approx(exact, rel=1e-13)
        assert float(ss.quadrature.damping(law, "equilibrium", V=V, N=1, digits=15)) == pytest.approx(
            exact, rel=1e-13
        )


def test_quadrature_is_parted_where_mu_turns():
    law = ss.FrictionLaw("0.2 + 0.3*exp(-3*v) + 0.1*exp(-((v - 0.3)/0.00001)^2)")
    exact = float(ss.enclose(law, V="0.5", N=1, digits=15))
    assert float(ss.quadrature.damping(law, V="0.5", N=1, digits=10)) == pytest.approx(exact, rel=1e-9)
