"""The package's integrator against SciPy's `solve_ivp` with events, which shares nothing with it but mu."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from motions import one_point

import stickslip_sym as ss

AGREES = 1e-6  # of the size of a motion; the reference has a tolerance of 1e-10


@given(seed=st.integers(0, 10**6))
def test_motions_are_those_of_solve_ivp(seed):
    law, osc, x0, v0 = one_point(seed)
    t_end = 8 / osc.omega
    ours = ss.simulate(law, osc, x0=x0, v0=v0, t_end=t_end, rtol=1e-10)
    other = ss.simulate(law, osc, x0=x0, v0=v0, t_end=t_end, rtol=1e-10, method="solve_ivp")
    assert ours.outcome is ss.Outcome.FINISHED
    size = osc.length + np.ptp(ours.x)
    assert [event.begins for event in ours.events] == [event.begins for event in other.events]
    t = np.linspace(0, t_end, 40)
    assert ours.at(t).x == pytest.approx(other.at(t).x, abs=AGREES * size)


def test_reference_notices_a_wrong_motion(law):
    osc = ss.Oscillator(m=1, k=100, c=1.0, V=0.5, N=9.81)
    other = ss.simulate(law, osc, t_end=3.0, method="solve_ivp", rtol=1e-10)
    for change in ({"c": 1.001}, {"N": 9.815}):
        wrong = ss.simulate(law, dataclasses.replace(osc, **change), t_end=3.0)
        assert np.abs(wrong.at(other.t[-1]).x - other.x[-1]) > 10 * AGREES * osc.length
