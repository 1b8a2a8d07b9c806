"""The damping that an orbit needs: no horizon, no count of steps, and no shortcut is taken for an answer."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import stickslip_sym as ss
from stickslip_sym.motion.kernel.creeping import creeps, slope_bounds
from stickslip_sym.motion.kernel.slip_data import TIGHT, SlipEnd, no_wedge
from stickslip_sym.motion.orbits import needed
from stickslip_sym.motion.orbits.needed import (
    HalfOutcome,
    SearchEnd,
    damping_ratios,
    forward_and_backward_orbit,
    orbit_damping_ratio,
    velocity_mismatch,
)
from stickslip_sym.motion.slip import NondimensionalOscillator
from stickslip_sym.numerics.known import Unknown
from support.operating_points import paper_oscillator

SLOW = ss.FrictionLaw("0.4 + 17*v*exp(-v/0.004) + 3.4*Max(v - 0.05, 0)")
HEAVY = {"V": 0.035, "N": 48000.0, "m": 25.0, "k": 4300.0}


def system_of(law, **changes):
    return NondimensionalOscillator.of(law.bound, paper_oscillator(**changes))


def test_a_half_that_returns_late_returns():
    """It takes a hundred times as long as its displacement says; a horizon took it for one that creeps."""
    found = ss.pure_slip_damping(SLOW, **HEAVY, method="simulation", rtol=1e-6)
    assert found.value == pytest.approx(84.3928, abs=1e-3)
    beside = 20 * found.value * found.relative_error
    cycles = [ss.stick_slip_cycle(SLOW, ss.Oscillator(c=found.value + off, **HEAVY)) for off in (-beside, beside)]
    assert cycles[0] is not None
    assert cycles[1] is None


@pytest.mark.parametrize("eta", [1e-4, 1e-2, 1.0, 30.0, 1e3, 1e4])
@pytest.mark.parametrize("name", ["exponential", "polynomial", "tanh"])
def test_ratios_agree_within_their_errors(name, eta):
    """Searched for with little accuracy and with more: for weak friction and for strong."""
    law = ss.laws.catalogue[name].typical()
    system = system_of(law)
    system = NondimensionalOscillator(eta, 0.0, system.table, system.V)
    rough, fine = (orbit_damping_ratio(system, rtol=rtol, fast=True) for rtol in (1e-4, 1e-9))
    assert abs(rough[0] - fine[0]) <= rough[1] + fine[1]
    assert fine[1] <= 2e-9 * abs(fine[0])


@pytest.mark.parametrize("seed", range(4))
def test_secants_alone_end_within_their_errors(seed):
    """Where a law varies gradually no second search says what the steps are off, and few mismatches are enough."""
    rng = np.random.default_rng(seed)
    a, b, c = rng.uniform([0.05, 0.5, -0.1], [0.5, 3.0, 0.1]).tolist()
    system = system_of(ss.FrictionLaw(f"0.3 + {a}*exp(-{b}*v) + {c}*v"))
    eta, A = float(np.exp(rng.uniform(-3.0, 2.0))), float(rng.uniform(0.01, 1.0))
    arguments = system.rise, eta, 0.0, A
    fine = needed.search_damping_ratio(*arguments, TIGHT)
    assert system.rise.gradual
    for rtol in (1e-3, 1e-8):
        found = needed._search_by_secants(*arguments, rtol, *needed._harmonic(system.rise, eta, A))
        assert found.end == SearchEnd.CLOSED
        assert found == needed.search_damping_ratio(*arguments, rtol)
        assert abs(found.zeta - fine.zeta) <= found.error + fine.error
        assert found.error <= rtol * abs(found.zeta)


def test_laws_that_vary_quickly_are_searched_in_a_bracket():
    """Steps may miss what they do: a bump of a thousandth, a layer at rest, a kink."""
    laws = (
        "0.3 + 0.1*exp(-v) - 0.1*exp(-((v - 0.6)/0.001)^2)",
        "(0.2 + 0.3*exp(-3*v))*tanh(v/1e-8)",
        "0.3 + 0.1*exp(-v) + 0.1*Max(v - 0.6, 0)",
    )
    assert not any(system_of(ss.FrictionLaw(law)).rise.gradual for law in laws)


def test_what_is_not_known_of_a_half_is_not_known_of_the_gap(monkeypatch):
    """A bound on steps is no sign of a mismatch; a law that ends is one."""
    system = system_of(ss.laws.exponential.typical())
    arguments = system.rise, system.eta, 0.13, 0.0, 1.0, TIGHT, no_wedge(system.rise)
    ahead, back = forward_and_backward_orbit(*arguments, 0.0)
    assert (ahead.outcome, back.outcome) == (HalfOutcome.RETURNS, HalfOutcome.RETURNS)
    assert math.isfinite(velocity_mismatch(*arguments).value)
    monkeypatch.setattr(needed, "MOST_STEPS", 3)
    assert math.isnan(velocity_mismatch(*arguments).value)
    search = needed.search_damping_ratio(system.rise, system.eta, 0.0, 1.0, 1e-9)
    assert (search.end, search.low, search.high) == (SearchEnd.FAILED, -math.inf, math.inf)


def test_a_mass_that_creeps_to_rest_says_so():
    """With much damping the half ahead comes to rest, and the one back does not: less damping is needed.

    Beside rest its steps would go on for long; bounds of the slope show where it goes before.
    """
    system = system_of(ss.laws.exponential.typical())
    for zeta in (2.0, 20.0, 2e4):
        arguments = system.rise, system.eta, zeta, 0.0, 1.0, TIGHT, no_wedge(system.rise)
        ahead, back = forward_and_backward_orbit(*arguments, 0.0)
        assert (ahead.outcome, back.outcome) == (HalfOutcome.CREEPS, HalfOutcome.RETURNS)
        assert velocity_mismatch(*arguments).value == -math.inf


def test_a_mass_on_its_way_out_is_not_shown_to_creep():
    """Up to its own slip speed the law holds it, but it goes on to where friction falls, and comes past rest."""
    law = ss.FrictionLaw("0.3 + 10*Min(v, 1.1) - 20*Max(v - 1.1, 0) + 25*Max(v - 3, 0)")
    system = system_of(law, V=1.0, N=1.0, m=1.0, k=1.0, c=0.0)
    begin = system.turn(1.0) + 10.0, 1.05
    assert system.acceleration(*begin) > 0.0
    assert not creeps(system.rise, system.field(1.0), *begin)
    assert system.slip(*begin, until=SlipEnd.LEVEL, level=1.0, rtol=1e-8).end is SlipEnd.LEVEL
    inward = system.turn(1.0) + 0.2, 1.05
    assert creeps(system.rise, system.field(1.0), *inward)
    assert system.slip(*inward, until=SlipEnd.LEVEL, level=1.0, rtol=1e-8).end is SlipEnd.REST


@pytest.mark.parametrize(("decay", "end"), [(1.0, SlipEnd.RETURN), (3.0, SlipEnd.REST)])
def test_rest_at_a_kink_is_left_in_swings_alone(decay, end):
    """Friction falls above it, so a swing leads away; below it deviations swing, or from 2 on they decay."""
    law = ss.FrictionLaw(f"9 + {decay}*Min(v - 1, 0) - 4*Max(v - 1, 0) + 6*Max(v - 5, 0)")
    system = system_of(law, V=1.0, N=1.0, m=1.0, k=1.0, c=0.0)
    slip = system.slip(system.turn(1.0) - 1e-12, 1.0 - 1e-12, horizon=30.0)
    assert slip.end is end


def test_ends_of_searches_are_translated_at_one_place():
    ends = [SearchEnd.CLOSED, SearchEnd.OUTSIDE, SearchEnd.NEVER, SearchEnd.FAILED, SearchEnd.LATE]
    rows = np.array([[end, -0.5, 0.1, -0.6, -0.3] for end in ends], dtype=float)
    column = damping_ratios(rows)
    assert [column.at(i) for i in range(3)] == [-0.5, -0.5, -math.inf]
    assert all(isinstance(column.at(i), Unknown) for i in (3, 4))
    assert column.errors[:3] == pytest.approx([0.1, 0.3, 0.0])
    assert column.perhaps(above=1e9).tolist() == [False, False, False, True, True]


@given(seed=st.integers(0, 10**6))
def test_bounds_of_slopes_hold_all_slopes(seed):
    """Of random laws with narrow features; and a state that is shown to creep does so when it is followed."""
    rng = np.random.default_rng(seed)
    a, b, place, width = rng.uniform([0.0, 0.5, 0.3, 0.02], [0.5, 8.0, 0.8, 0.3]).tolist()
    law = ss.FrictionLaw(f"0.3 + {a}*exp(-{b}*v) - 0.1*exp(-((v - {place})/{width})^2) + 0.2*v")
    system = replace(system_of(law), zeta=float(rng.uniform(1.0, 30.0)))
    low, high = np.sort(rng.uniform(0.2, 2.0, 2)).tolist()
    least, most = slope_bounds(system.rise, low, high)
    w = np.linspace(low, high, 500)
    slopes = system.V * law.bound.at_speeds(system.V * w, derivative=True)
    assert least <= slopes.min() + 1e-9
    assert slopes.max() - 1e-9 <= most
    assert most - least <= np.ptp(slopes) + 0.5 * np.abs(slopes).max()
    w0, q0 = float(rng.uniform(0.3, 1.8)), system.turn(1.0) + float(rng.normal(0.0, 2.0))
    if creeps(system.rise, system.field(1.0), q0, w0):
        run = system.slip(q0, w0, until=SlipEnd.LEVEL, level=1.0, rtol=1e-8)
        assert run.end is SlipEnd.REST


def test_errors_of_steps_are_those_of_a_steep_mismatch():
    """Twenty times as steep as where friction is weak: along this orbit a step's error is magnified as much."""
    law = ss.FrictionLaw("0.3 + 0.3567*exp(-3.9886*v) + 0.0555*v + 0.0286*sin(11.9658*v)")
    rise, eta, A = law.bound.table.at(1.979548242592538), 8.388500130903271, 0.7082091044961418
    found, exact = (needed.search_damping_ratio(rise, eta, 0.0, A, rtol) for rtol in (1e-8, 1e-13))
    assert found.end == exact.end == SearchEnd.CLOSED
    assert abs(found.zeta - exact.zeta) <= found.error + exact.error
