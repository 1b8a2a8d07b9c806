"""Orbits from level to level of the slip speed, against the same followed in time."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import laws_in_pieces, paper_oscillator

import stickslip_sym as ss
from stickslip_sym.model.oscillator import Scene
from stickslip_sym.motion.regimes.slip_orbits import next_peak
from stickslip_sym.motion.simulation.levels import Levels
from stickslip_sym.motion.simulation.transit import lowest_slip_speed

RTOL = 1e-11
AGREES = 1e-9  # of the belt's speed; errors of steps grow along an orbit


def scene_of(law, **changes):
    return Scene.of(law, paper_oscillator(**changes))


def test_orbits_come_to_where_time_brings_them():
    """From P, which decides thresholds, and from any peak of the velocity; some come to rest, and have no peak."""
    rng = np.random.default_rng(1)
    answered = 0
    for law in laws_in_pieces(rng, 24):
        scene = scene_of(law, V=rng.uniform(0.1, 0.9), N=10 ** rng.uniform(0, 1.3), k=10 ** rng.uniform(1.5, 3))
        levels, zeta = Levels(scene), rng.uniform(-0.02, 0.4)
        damped, amplitude = replace(scene, zeta=zeta), rng.uniform(0.05, 1)
        found = levels.lowest(zeta, RTOL)
        if found is not None:
            answered += 1
            assert found == pytest.approx(lowest_slip_speed(damped, 1e-13), rel=AGREES, abs=AGREES)
        peak = levels.next_peak(zeta, amplitude, RTOL)
        if peak is not None:
            answered += 1
            assert peak == pytest.approx(next_peak(damped, amplitude, 1e-13)[0], rel=AGREES, abs=AGREES)
    assert answered > 40


@pytest.mark.parametrize("offset", [0, 1e-15, -1e-15, 1e-12, -1e-12, 1e-9, -1e-9, 1e-6, -1e-6, 1e-3, -1e-3])
def test_an_orbit_may_turn_at_a_kink(offset):
    """The highest slip speed is that of a kink, or close to it; and so may be where it is lowest."""
    smooth, osc = ss.laws.exponential.typical(), paper_oscillator(3.0)
    cycle = ss.peak_velocity(smooth, osc)
    for place in (osc.V - cycle, 2 * osc.V - cycle):
        law = ss.FrictionLaw(f"0.2 + 0.3*exp(-3*v) + 0.1*Max(0, v - {place * (1 + offset)!r})")
        scene = Scene.of(law, osc)
        expected = lowest_slip_speed(scene, 1e-13)
        assert Levels(scene).lowest(scene.zeta, RTOL) == pytest.approx(expected, rel=AGREES)


def test_a_tighter_tolerance_is_closer():
    law = ss.FrictionLaw.from_samples([0, 0.1, 0.3, 0.5, 0.9, 1.4], [0.5, 0.41, 0.35, 0.27, 0.26, 0.2])
    scene = scene_of(law, c=2.0)
    exact = lowest_slip_speed(scene, 1e-13)
    off = [abs(Levels(scene).lowest(scene.zeta, rtol) - exact) for rtol in (1e-4, 1e-7, 1e-10, 1e-12)]
    assert off == sorted(off, reverse=True)
    assert off[0] < 1e-4
    assert off[-1] < 1e-11


@pytest.mark.parametrize(
    ("law", "changes"),
    [
        (ss.FrictionLaw("Piecewise((0.5, v < 0.3), 0.3)"), {}),
        (ss.FrictionLaw("0.5 - 0.1*sqrt(v)"), {}),
        (ss.laws.exponential.typical(), {"m": 1e-6}),
        (ss.FrictionLaw("0.5 - 0.1*tanh((v - 0.2)/1e-14)"), {}),
    ],
    ids=["jump", "vertical", "strong", "thin"],
)
def test_what_levels_are_not_made_for_is_left_to_steps_in_time(law, changes):
    scene = scene_of(law, c=2.0, **changes)
    levels = Levels(scene)
    assert levels.lowest(scene.zeta, RTOL) is None
    expected = lowest_slip_speed(scene, RTOL)
    assert lowest_slip_speed(scene, RTOL, levels=levels) == expected


def test_a_thin_layer_at_the_belt_speed_is_seen():
    """Friction falls at once, as from a static coefficient: the layer is thinner than the distance of levels."""
    for width in (1e-2, 1e-4, 1e-6):
        scene = scene_of(ss.FrictionLaw(f"0.3 + 0.1*exp(-v/{width!r})"), c=1.0)
        found = Levels(scene).lowest(scene.zeta, RTOL)
        assert found is None or found == pytest.approx(lowest_slip_speed(scene, 1e-13), rel=1e-7)
    thick = scene_of(ss.FrictionLaw("0.3 + 0.1*exp(-v/1e-2)"), c=1.0)
    assert Levels(thick).lowest(thick.zeta, RTOL) is not None


def test_a_speed_that_was_not_measured_is_refused_as_ever():
    law = ss.FrictionLaw.from_samples([0, 0.1, 0.3, 0.7], [0.5, 0.41, 0.35, 0.27])
    scene = scene_of(law, c=1.0)
    with pytest.raises(ss.InputError, match="the law is measured up to"):
        lowest_slip_speed(scene, RTOL, levels=Levels(scene))


@pytest.mark.parametrize("V", [1e3, 1e4, 1e5, 1e6])
def test_a_layer_that_is_too_thin_for_levels_is_left_to_time(V):
    """On a fast belt mu falls within a millionth of its speed; a graze then turns below the first level."""
    scene = scene_of(ss.laws.exponential.typical(), V=V)
    in_time = lowest_slip_speed(scene, RTOL)
    assert lowest_slip_speed(scene, RTOL, levels=Levels(scene)) == pytest.approx(in_time, abs=20 * RTOL)
