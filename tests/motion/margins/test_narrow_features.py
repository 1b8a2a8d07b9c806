"""Critical values where the orbit that grazes comes to slip speeds near which the law varies quickly."""

import numpy as np
import pytest

import stickslip_sym as ss
from support.random_questions import NoAnswer, asked
from support.sweeps import sweep

POINT = {"N": 9.81, "m": 1.0, "k": 100.0}
BUMP = "0.2 + 0.3*exp(-3*v) - 0.1*exp(-((v - {})/0.001)^2)"
C = 2.6257


def returns(law, V):
    """Whether the slip from P comes back to the belt's speed."""
    return ss.peak_velocity(law, ss.Oscillator(c=C, V=V, **POINT)) > V


def test_a_belt_speed_at_which_slip_just_comes_to_a_bump():
    """The bump lies at twice the belt speed, and is a thousandth as wide: a range not parted there shows one."""
    law = ss.FrictionLaw(BUMP.format(1))
    found = ss.critical(law, "V", c=C, within=(0.48, 0.52), **POINT)
    assert [one.value for one in found] == pytest.approx([0.4897857395, 0.4999008353, 0.5034741617], rel=1e-6)
    for one in found:
        assert returns(law, one.value * (1 - 1e-6)) != returns(law, one.value * (1 + 1e-6))


@pytest.mark.thorough
def test_the_place_of_a_bump_as_the_unknown():
    law = ss.FrictionLaw(BUMP.format("a")).bind(a=1)
    found = ss.critical(law, "a", c=C, V=0.5, within=(0.95, 1.05), **POINT)
    assert len(found) == 2
    for one in found:
        assert returns(law.bind(a=one.value * (1 - 1e-6)), 0.5) != returns(law.bind(a=one.value * (1 + 1e-6)), 0.5)


def test_an_average_over_a_bump():
    """By the mean over the equilibrium's one speed: at the belt speeds at which that is within the bump."""
    law = ss.FrictionLaw("0.4 - 0.01*v + 0.001*exp(-((v - 1)/1e-5)^2)")
    found = ss.critical(law, "V", c=0.0, N=9.81, method="equilibrium", within=(0.01, 100))
    assert len(found) == 2
    assert all(abs(one.value - 1) < 1e-4 for one in found)


@sweep("name", ["exponential", "hyperbolic", "tanh", "gaussian", "stribeck", "sech", "lorentzian"], "exponential")
def test_a_slope_that_underflows_is_no_zero(name):
    """The equilibrium of these loses stability at no belt speed without damping."""
    found = ss.critical(ss.laws[name].typical(), "V", c=0.0, N=9.81, method="equilibrium")
    assert found == ()


def test_values_that_errors_hide_are_open():
    """The threshold changes by 10^-13 of itself over ten decades of m: no value is known to be one, nor none."""
    law, point = ss.laws.exponential.typical(), {"V": 0.0007, "N": 9.81, "k": 100.0}
    c = ss.pure_slip_damping(law, m=1.2, **point).value
    found = asked(ss.critical, law, "m", c=c, **point)
    if isinstance(found, NoAnswer):
        assert "the threshold is c, within its error" in found
    else:
        assert any(low <= 1.2 <= high for low, high in found.unresolved)


@pytest.mark.parametrize("gap", [1, 1e-1, 1e-2, 3e-3, 0])
def test_speeds_at_which_a_criterion_vanishes(gap):
    """Two as close as 3e-3, of exponentials; one at which it touches 0 is found, or open."""
    low, rate = 0.7, 2.0
    p, q = (f"{np.exp(-rate * root):.12g}" for root in (low, low * (1 + gap)))
    law = ss.FrictionLaw(f"1 - exp(-4*v)/4 + ({p} + {q})*exp(-2*v)/2 + {p}*{q}*v")
    found = ss.critical(law, "V", c=0.0, N=9.81, method="equilibrium", within=(0.01, 100))
    if gap:
        assert [one.value for one in found] == pytest.approx([low, low * (1 + gap)], rel=1e-5)
        assert not any(start < low < end for start, end in found.unresolved)
    else:
        assert found or any(start < low < end for start, end in found.unresolved)
