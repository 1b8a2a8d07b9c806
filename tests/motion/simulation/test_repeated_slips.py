"""A motion that sticks is integrated for one round, and is what it would be if every round were."""

import numpy as np
import pytest
from motions import points
from operating_points import paper_oscillator

import stickslip_sym as ss
from stickslip_sym import Outcome
from stickslip_sym.motion.simulation.trajectory import EventKind

EXACT = 1e-9  # relative to the motion's size; a hundred steps at rtol = 1e-12, and grazes


def test_a_motion_goes_on_from_any_point():
    sticking, cut = 0, 0.43
    for kind, law, osc, x0, v0 in points(18, seed=11):
        t_end = 40 / osc.omega
        whole = ss.simulate(law, osc, t_end=t_end, x0=x0, v0=v0, rtol=1e-12)
        if whole.outcome is not Outcome.FINISHED:
            continue
        sticking += sum(event.kind is EventKind.STICKS for event in whole.events) > 3
        middle = whole.at(cut * t_end)
        rest = ss.simulate(law, osc, t_end=(1 - cut) * t_end, x0=float(middle.x), v0=float(middle.v), rtol=1e-12)
        size = osc.length + np.abs(whole.x).max()
        assert rest.x[-1] == pytest.approx(whole.x[-1], abs=EXACT * size), kind
        later = [event.t for event in whole.events if event.t > cut * t_end]
        assert [event.t + cut * t_end for event in rest.events[1:]] == pytest.approx(later, abs=EXACT * t_end)
    assert sticking > 3


def test_every_round_is_the_cycle(law):
    osc = paper_oscillator(1.0)
    cycle = ss.stick_slip_cycle(law, osc)
    motion = ss.simulate(law, osc, t_end=200.2 * cycle.period, x0=0.2, v0=0.0)
    sticks = motion.starts_of(ss.Phase.STICK)
    assert len(sticks) in (199, 200, 201)
    assert np.diff(sticks)[1:] == pytest.approx(cycle.period, rel=1e-9)
    assert (np.diff(motion.t) >= 0).all()
    t = np.linspace(100 * cycle.period, 101 * cycle.period, 50)
    assert motion.at(t).x == pytest.approx(motion.at(t + 90 * cycle.period).x, abs=1e-8 * osc.length)
