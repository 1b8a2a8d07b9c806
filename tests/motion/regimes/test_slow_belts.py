"""On a slow belt every law is a straight line, however many digits mu(0+) and mu(V) have in common."""

import pytest

import stickslip_sym as ss

FALLING = [name for name, law in ss.laws.catalogue.items() if law.typical().slope(0.0) < 0]
SLOW = (1e-8, 1e-12)  # m/s
CASES = [pytest.param(name, marks=() if name == "exponential" else pytest.mark.thorough) for name in FALLING]


def oscillator(c, V):
    return ss.Oscillator(m=1.0, k=100.0, c=c, V=V, N=9.81)


@pytest.mark.parametrize("name", CASES)
def test_a_slow_belt_sees_the_slope_at_rest(name):
    """What a cycle differs from that of the straight line falls with V, as the curvature of mu does."""
    law = ss.laws.catalogue[name].typical()
    slope = law.slope(0.0)
    line = ss.FrictionLaw("mu_0 - a*v").bind(mu_0=law.mu(0.0), a=-slope)
    least = -9.81 * slope

    def deviation(V):
        cycle, expected = (ss.stick_slip_cycle(one, oscillator(0.95 * least, V)) for one in (law, line))
        return abs(cycle.slip_time / expected.slip_time - 1)

    curved = deviation(SLOW[0]) / SLOW[0]
    assert curved * SLOW[0] < 0.01
    for V in SLOW:
        assert deviation(V) <= 1.5 * curved * V + 1e-11
        assert ss.pure_slip_damping(law, V=V, m=1.0, k=100.0, N=9.81).value == pytest.approx(least, rel=1e4 * V)
        for c, motion in ((0.95 * least, ss.Motion.STICK_SLIP), (1.05 * least, ss.Motion.REST)):
            assert ss.classify(law, oscillator(c, V)) is motion
            regime = ss.regime(law, oscillator(c, V), time_limit=20)
            assert not regime.undecided
            assert (regime.stick_slip is not None) == (motion is ss.Motion.STICK_SLIP)
