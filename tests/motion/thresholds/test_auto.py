"""What "auto" gives: the first value that is known to be good enough, and what it costs to know it."""

from collections import Counter

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym.motion.thresholds.methods import methods
from stickslip_sym.motion.thresholds.operating_points import OperatingPoints
from support.operating_points import laws_in_pieces, smooth_points
from support.sweeps import sweep

POINT = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}


def points_of_every_kind(count):
    """Yield laws of the catalogue, kinked, measured and held ones, and operating points from weak friction on."""
    rng = np.random.default_rng(5)
    names = sorted(ss.laws.catalogue)
    for number in range(count):
        law = ss.laws.catalogue[names[rng.integers(len(names))]].typical()
        if number % 2:
            law = laws_in_pieces(rng, 4)[number // 2 % 4]
        V, m, k, eta = (10 ** rng.uniform(*ends) for ends in ((-1.5, 0.3), (-1, 1), (1, 4), (-3, 1.3)))
        yield law, {"V": V, "m": m, "k": k, "N": eta * V * (k * m) ** 0.5}, 10 ** rng.uniform(-11, -3)


@sweep("count", [3, 300], 3)
def test_stated_errors_hold_against_enclosures(count):
    """Of 300 points the errors of all 515 values bound the true ones; what cannot be bounded is refused."""
    held, total = 0, 0
    for law, numbers, rtol in points_of_every_kind(count):
        try:
            exact = ss.pure_slip_damping(law, **numbers, method="proof", rtol=1e-11, time_limit=30)
        except (ss.OutOfTime, ss.NoThreshold):
            continue
        for method in ("simulation", "auto"):
            try:
                found = ss.pure_slip_damping(law, **numbers, method=method, rtol=rtol)
            except ss.NotConverged:
                continue
            total += 1
            held += abs(found.value / exact.value - 1) <= found.relative_error + 1e-11
    assert total >= count
    assert held >= 0.99 * total


def test_the_error_of_the_last_secant_is_stated():
    """Of a threshold in which the slope and the static coefficient nearly cancel."""
    law = ss.FrictionLaw("0.4 - 0.1293*Abs(v - 0.1602)", static="0.6")
    numbers = {"V": 0.1336495032912768, "m": 0.14125713215413027, "k": 16.08678954758913, "N": 0.12214360477004338}
    exact = 0.00031066852145688104  # by a proof, and by Taylor series of 30 digits
    for rtol in (1e-3, 1e-8, 1e-10):
        found = ss.pure_slip_damping(law, **numbers, method="simulation", rtol=rtol)
        assert abs(found.value / exact - 1) <= found.relative_error <= rtol


@pytest.mark.thorough
def test_what_has_no_digits_left_is_proved():
    """Weak friction, of which time stepping has too few digits: nothing is refused that a proof answers."""
    law, point = ss.laws.brown_mcphee.typical(), {"V": 0.977222, "N": 0.0100304, "m": 1.0, "k": 100.0}
    found = ss.pure_slip_damping(law, **point, rtol=2e-11)
    sure = ss.pure_slip_damping(law, **point, method="proof", rtol=1e-13)
    assert (found.method, found.status) == ("proof", ss.Status.PROVED)
    assert abs(found.value / sure.value - 1) <= found.relative_error + 1e-13 < 3e-11


def test_auto_gives_the_first_good_value():
    """Asked one by one in the order of their costs, no method before it knows its error to be within rtol."""
    last, rng = Counter(), np.random.default_rng(20160428)
    for law, numbers in smooth_points(rng, 24, V=(-1.5, 0), N=(-1, 2), m=(-2, 2), k=(1, 5)):
        rtol = 10 ** rng.uniform(-10, -0.3)
        points = OperatingPoints.of(law, **numbers)
        found = ss.pure_slip_damping(law, **numbers, rtol=rtol)

        def cost(method, points=points, rtol=rtol):
            return method.cost(points, rtol) if callable(method.cost) else method.cost

        for method in sorted(methods().values(), key=cost):
            alone = method.compute(points, min(rtol, method.loosest))
            if method.name == found.method:
                assert (found.value, found.relative_error) == (alone.value[0], alone.relative_error[0])
                break
            assert not alone.relative_error[0] <= rtol
        last[found.method] += 1
    assert last["second_order"] >= 10  # what is cheap suffices as far as it can
    assert last["simulation"] >= 1
    assert last["orbit"] >= 1


@pytest.mark.parametrize(
    ("rate", "rtol", "method"),
    [(300, 1e-3, "orbit"), (500, 1e-3, "simulation"), (180, 1e-8, "orbit"), (207, 1e-8, "simulation")],
)
def test_an_orbit_is_sought_by_collocation_where_few_phases_resolve_the_law(rate, rtol, method):
    """Of a fall near rest 64 phases of half a period leave 1e-5, 1e-4, 2e-7 and 7e-7 over."""
    law = ss.FrictionLaw("0.3 + 0.2*exp(-a*v)").bind(a=rate)
    assert ss.pure_slip_damping(law, **POINT | {"N": 40}, rtol=rtol).method == method


@pytest.mark.parametrize(("beyond", "method"), [(3e-7, "simulation"), (3e-6, "second_order")])
def test_a_kink_just_beyond_the_highest_slip_speed(beyond, method):
    """At 3e-7 of the belt's speed the orbit may pass it, at 3e-6 it does not."""
    law = ss.FrictionLaw("0.4 - 0.1*v + 0.1*Max(v - b, 0)").bind(b=1 + 0.5 * beyond)
    assert ss.pure_slip_damping(law, **POINT | {"N": 1e-6}).method == method
