"""The oscillator: slip phases, the automaton, the stick-slip cycle and the threshold by simulation."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import stickslip_sym as ss
from stickslip_sym import Phase
from support import reference_motions
from support.operating_points import paper_oscillator

PERIOD_AGREES = 1e-9


@given(
    name=st.sampled_from(["exponential", "polynomial"]),
    c=st.floats(0, 1.9),
    x0=st.floats(-0.4, 0.4),
    v0=st.floats(-3, 3),
)
def test_every_initial_condition_leads_to_the_same_period(name, c, x0, v0):
    """From the second stick-slip cycle on, the period is the cycle's, to 1e-9."""
    law, osc = ss.laws.catalogue[name].typical(), paper_oscillator(c)
    motion = ss.simulate(law, osc, t_end=9.0, x0=x0, v0=v0)
    first_stick = motion.starts_of(Phase.STICK)[0]
    onsets = motion.starts_of(Phase.SLIP_BACK)
    periods = np.diff(onsets[onsets > first_stick])
    assert len(periods) >= 5
    assert periods[1:] == pytest.approx(ss.stick_slip_cycle(law, osc).period, rel=PERIOD_AGREES)


BELOW = ss.FrictionLaw("0.3", static="0.2")
REFUSED = [
    ({"k": -1.0}, "0.5", {}, "k = -1 must be positive"),
    ({"V": 0.0}, "0.5", {}, "V = 0 must be positive: it is the belt speed; on a belt that stands still"),
    ({"V": -0.5}, "0.5", {}, "V = -0.5 must be positive.*change the signs of V, x0 and v0"),
    ({"N": -2.0}, "0.5", {}, "N = -2 must not be negative"),
    ({"c": math.nan}, "0.5", {}, "c = nan is not finite"),
    ({"V": "fast"}, "0.5", {}, "V = 'fast' is not a number"),
    ({}, "0.5-0.1*log(v)", {}, r"mu\(0\+\) is inf"),
    ({}, "0.5*sqrt(1-v)", {"v0": -1.0}, "cannot be computed at a slip speed of 3 V"),
    ({}, "0.5+0.001*exp(800*v)", {"v0": -3.0}, "cannot be computed"),
    ({}, BELOW, {}, r"coefficient 0\.2 is below mu\(0\+\) = 0\.3"),
    ({}, ss.laws.exponential, {}, "no value for"),
    ({}, "0.5", {"t_end": 0.0}, "t_end = 0 must be positive"),
    ({}, "0.5", {"t_end": "long"}, "t_end = 'long' is not a number"),
    ({}, "0.5", {"x0": math.nan}, "x0 = nan is not finite"),
    ({}, "0.5", {"v0": math.inf}, "v0 = inf is not finite"),
    ({}, "0.5", {"rtol": 0.0}, "rtol = 0 is outside"),
    ({}, "0.5", {"max_steps": 0}, "max_steps = 0 must be at least 1"),
    ({}, "0.5", {"time_limit": -1.0}, "not a number of seconds"),
    ({}, "0.5", {"method": "euler"}, "no method 'euler'"),
    ({}, "0.5", {"x0": [0.0, 1.0], "v0": [1.0, 2.0, 3.0]}, "do not go together"),
    ({}, "0.5", {"x0": []}, "no initial conditions"),
    ({}, "0.5", {"x0": [0.0, np.nan]}, "x0"),
    ({}, "0.5", {"x0": [0.0, 1.0], "method": "solve_ivp"}, "one initial condition"),
    ({}, "0.5", {"x0": [0.0, 1.0], "workers": 0}, "workers = 0 must be a number of threads"),
]


@pytest.mark.parametrize(("point", "law", "arguments", "message"), REFUSED)
def test_what_is_no_simulation_is_refused(point, law, arguments, message):
    with pytest.raises(ss.InputError, match=message):
        ss.simulate(law, paper_oscillator(**point), **{"t_end": 10.0} | arguments)


@pytest.mark.parametrize("formula", ["0.5-0.1*sqrt(v)", "0.3*v^v", "0.5+0.1*v*log(v)"])
def test_laws_with_an_infinite_slope_at_rest(formula):
    law, osc = ss.FrictionLaw(formula), paper_oscillator(0.0)
    motion = ss.simulate(law, osc, t_end=3.0)
    assert [event.begins for event in motion.events[:2]] == [Phase.STICK, Phase.SLIP_BACK]
    assert motion.events[1].x == pytest.approx((0.3 if "^" in formula else 0.5) * 9.81 / 100, rel=1e-12)
    t, x, v = (part[motion.t > motion.events[1].t][3:15] for part in (motion.t, motion.x, motion.v))
    assert np.array([x, v]) == pytest.approx(reference_motions.lsoda(law, osc, x[0], v[0], t), rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("c", [30.0, 1e5])
def test_heavy_damping_creeps_to_rest_in_no_time(law, c):
    osc = paper_oscillator(c)
    assert ss.stick_slip_cycle(law, osc) is None
    with pytest.raises(ss.NotConverged, match="no peak"):
        ss.peak_velocity(law, osc)
    motion = ss.simulate(law, osc, t_end=1e5)
    assert motion.outcome is ss.Outcome.AT_REST
    assert motion.t[-1] == pytest.approx(1e5, rel=1e-15)
    assert (motion.x[-1], motion.v[-1]) == pytest.approx((osc.N * law.mu(osc.V) / osc.k, 0.0), rel=1e-12)


@pytest.mark.parametrize("static", ["0.4", "0.301"])
@pytest.mark.parametrize(("rtol", "error"), [(1e-4, 1e-9), (1e-8, 1e-9), (1e-12, 1e-12)])
def test_events_of_a_harmonic_slip_are_exact(static, rtol, error):
    """A constant law with a static jump: w = 1 - cos(tau) + A sin(tau), which returns at 2 pi - 2 atan(A)."""
    jump, osc = ss.FrictionLaw("0.3", static=static), paper_oscillator(0.0)
    A = osc.eta * (float(static) - 0.3)
    cycle = ss.stick_slip_cycle(jump, osc, rtol=rtol)
    agrees = error / A  # the flatter the return, the less certain its time
    assert cycle.slip_time * osc.omega == pytest.approx(2 * math.pi - 2 * math.atan(A), abs=agrees)
    assert cycle.stick_time * osc.omega == pytest.approx(2 * A, abs=agrees)
    assert cycle.v_min == pytest.approx(-osc.V * math.hypot(1, A), abs=agrees)
    # The acceleration at the return is -A, in units of omega V.
    assert ss.peak_velocity(jump, osc, rtol=rtol) == pytest.approx(osc.V * (1 + A**2 / 2), abs=agrees)
    # The mass stands still at w = 1, tan(tau) = 1/A.
    turn = osc.onset(jump) + osc.length * (math.hypot(1, A) - A)
    assert cycle.x_max == pytest.approx(turn, rel=1e-6)


def test_ten_natural_periods_are_followed_by_default():
    osc = ss.Oscillator(m=4.0, k=100.0, c=1.0, V=0.5, N=9.81)
    assert ss.simulate(ss.laws.exponential.typical(), osc).t[-1] == pytest.approx(10 * 2 * np.pi / 5, rel=1e-12)
