"""The automaton where mu has a kink or a jump."""

import math

import mpmath
import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym import Outcome, Phase
from support.operating_points import paper_oscillator

EVENT_TIMES = 1e-11  # relative, at rtol = 1e-12


def test_piecewise_linear_laws_have_their_exact_solution():
    """Each piece has a solution in exponentials; where it ends is a root found with 30 digits."""
    law = ss.FrictionLaw("Piecewise((0.5 - 0.4*v, v < 0.3), (0.41 - 0.1*v, v < 0.8), 0.33)")
    osc = paper_oscillator(1.0)
    cycle = ss.stick_slip_cycle(law, osc)
    lines = [(0.5, 0.4), (0.41, 0.1), (0.33, 0.0)]
    with mpmath.workdps(30):
        t, x, v = (
            mpmath.mpf(0),
            mpmath.mpf("0.5") * mpmath.mpf(9.81) / 100 - mpmath.mpf("0.005"),
            mpmath.mpf("0.5"),
        )
        # The pieces in order, the slip speed at which each ends, and about how long the mass stays on it.
        for piece, end, guess in ((0, 0.3, 0.11), (1, 0.8, 0.09), (2, 0.8, 0.2), (1, 0.3, 0.1), (0, 0.0, 0.07)):
            a, b = (mpmath.mpf(str(number)) for number in lines[piece])
            N = mpmath.mpf(9.81)
            rest = N * (a - b * osc.V) / osc.k
            decay = (osc.c - N * b) / 2
            frequency = mpmath.sqrt(osc.k - decay**2)

            def state(s, x=x, v=v, rest=rest, decay=decay, frequency=frequency):
                sine, cosine = mpmath.sin(frequency * s), mpmath.cos(frequency * s)
                u = x - rest
                B = (v + decay * u) / frequency
                shrink = mpmath.exp(-decay * s)
                return rest + shrink * (u * cosine + B * sine), shrink * (
                    (B * frequency - decay * u) * cosine - (u * frequency + decay * B) * sine
                )

            length = mpmath.findroot(
                lambda s, state=state, end=end: osc.V - state(s)[1] - mpmath.mpf(str(end)), guess
            )
            t, (x, v) = t + length, state(length)
    assert cycle.slip_time == pytest.approx(float(t), rel=EVENT_TIMES)
    assert cycle.x_min < float(x) < cycle.x_max


@pytest.mark.parametrize("offset", [0.0, -1e-13, -1e-6])
def test_an_orbit_may_touch_a_kink(offset):
    """The highest slip speed is that of a kink, as closely as doubles have it."""
    osc = paper_oscillator(1.0)
    smooth = ss.laws.exponential.typical()
    cycle = ss.stick_slip_cycle(smooth, osc)
    highest = repr((osc.V - cycle.v_min) * (1 + offset))
    kinked = ss.FrictionLaw(f"0.2 + 0.3*exp(-3*v) + Max(0, v - {highest})")
    touched = ss.stick_slip_cycle(kinked, osc)
    assert touched.period == pytest.approx(cycle.period, rel=EVENT_TIMES if abs(offset) < 1e-9 else 1e-7)


def jump(first, second, place, osc, t_end, **start):
    law = ss.FrictionLaw(f"Piecewise(({first}, v < {place}), {second})")
    return ss.simulate(law, osc, t_end=t_end, rtol=1e-12, **start)


def test_the_mass_slides_at_a_jump_up():
    """The rates point at each other there: w is constant until the spring pulls the mass across, known exactly."""
    osc = paper_oscillator(0.0)
    motion = jump(0.3, 0.5, 0.02, osc, 1.2)
    assert [event.begins for event in motion.events[:2]] == [Phase.STICK, Phase.SLIP_BACK]
    # From P with a constant friction: w = 1 - cos(tau), which at the jump is 0.04, and x' = 0.48 m/s.
    onset, tau = motion.events[1].t, math.acos(0.96)
    reached, x_reached = onset + tau / osc.omega, 0.3 * osc.N / osc.k + osc.length * math.sin(tau)
    left = reached + (0.5 * osc.N / osc.k - x_reached) / 0.48
    inside = np.linspace(reached, left, 50)[1:-1]
    assert motion.at(inside).v == pytest.approx(0.48, rel=1e-14)
    assert motion.at(inside).x == pytest.approx(x_reached + 0.48 * (inside - reached), rel=1e-12)
    # Then harmonic about the equilibrium of the higher friction.
    after = left + np.linspace(0, 0.1, 20)
    assert motion.at(after).v == pytest.approx(0.48 * np.cos(osc.omega * (after - left)), rel=1e-10)
    assert motion.outcome is Outcome.FINISHED


@pytest.mark.parametrize(("first", "second", "place"), [(0.3, 0.5, 0.02), (0.5, 0.3, 0.2), (0.3, 0.6, 0.7)])
@pytest.mark.parametrize("side", [1, -1])
def test_jump_is_the_limit_of_steep_changes(first, second, place, side):
    """Crossed or slid along, on both sides of the belt's speed."""
    osc = paper_oscillator(0.3)
    start = {"x0": 0.02, "v0": osc.V - side * 1.3}
    steep = ss.FrictionLaw(f"{first} + ({second} - {first})*(1 + tanh((v - {place})/1e-5))/2")
    t = np.linspace(0, 1.0, 200)
    sharp, smooth = (
        jump(first, second, place, osc, 1.0, **start),
        ss.simulate(steep, osc, t_end=1.0, rtol=1e-8, **start),
    )
    assert sharp.at(t).x == pytest.approx(smooth.at(t).x, abs=2e-5)
    assert [event.begins for event in sharp.events] == [event.begins for event in smooth.events]


def test_jump_at_belt_speed_holds_the_mass():
    """Anywhere between its two coefficients, as friction does that sticks; with c = 50 it creeps there."""
    motion = jump(0.3, 0.5, 0.5, paper_oscillator(0.0), 3.0)
    assert motion.outcome is Outcome.AT_REST
    assert 0.3 <= (motion.x[-1] * 100 / 9.81) <= 0.5
    assert (motion.x[motion.t > 1.5] == motion.x[-1]).all()
    law = ss.FrictionLaw("Piecewise((0.3, v < 0.5), 0.5)")
    assert {ss.classify(law, paper_oscillator(c), x0=0.1, v0=0.4) for c in (0.0, 50.0)} == {ss.Motion.REST}


def test_a_mass_faster_than_the_belt_slides_at_a_jump_up():
    """Pulled ahead by the spring, at a slip speed of 0.2 m/s, until the spring balances the lower friction."""
    osc = paper_oscillator(0.0)
    lower, speed = 0.3 * osc.N / osc.k, osc.V + 0.2
    motion = jump(0.3, 0.6, 0.2, osc, 1.0, x0=-1.5 * lower, v0=osc.V + 0.19, time_limit=20)
    reached = math.asin(speed / math.hypot(speed - 0.01, osc.omega * lower / 2))
    reached = (reached - math.atan2(speed - 0.01, osc.omega * lower / 2)) / osc.omega
    x_reached = -lower - lower / 2 * math.cos(osc.omega * reached)
    x_reached += (speed - 0.01) / osc.omega * math.sin(osc.omega * reached)
    left = reached + (-lower - x_reached) / speed
    inside = np.linspace(reached, left, 50)[1:-1]
    assert motion.at(inside).v == pytest.approx(speed, rel=1e-14)
    assert motion.at(inside).x == pytest.approx(x_reached + speed * (inside - reached), rel=1e-11)
    after = left + np.linspace(0, 0.05, 20)
    assert motion.at(after).v == pytest.approx(speed * np.cos(osc.omega * (after - left)), rel=1e-10)
