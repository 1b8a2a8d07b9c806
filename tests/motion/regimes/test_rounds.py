"""Slips of many oscillators at once, against motions followed one by one."""

import numpy as np
import pytest
from families import family_of
from scenes import laws_in_pieces

import stickslip_sym as ss
from stickslip_sym.model.oscillator import Scene
from stickslip_sym.motion.regimes.rounds import CREEPS, RETURN, TURN, arrive
from stickslip_sym.motion.simulation.slip import follow
from stickslip_sym.motion.simulation.slip_phase import End
from stickslip_sym.motion.simulation.steppers import Point

ENDS = {RETURN: End.RETURN, TURN: End.MINIMUM}
CLOSE = 20  # tolerances by which ends may differ
NAMES = ("exponential", "logarithmic", "stribeck", "simscape", "two_exponentials")


def scenes(law, rng, count):
    """Return a family, its oscillators with damping ratios, and orbits by their amplitudes."""
    V, eta, zeta, A = rng.uniform((0.2, 0.2, 0.0, 1e-3), (0.9, 4.0, 0.5, 1.0), (count, 4)).T
    family = family_of(law, V, eta)
    oscillators = [ss.Oscillator(m=1, k=1, V=v, N=e * v, c=2 * z) for v, e, z in zip(V, eta, zeta, strict=True)]
    w = 1 - A
    return family, oscillators, zeta, 2 * zeta * w - family.friction(w, family.piece(w)), w


@pytest.mark.parametrize("rtol", [1e-7, 1e-10])
def test_rounds_end_where_motions_followed_one_by_one_do(rtol):
    rng = np.random.default_rng(21)
    laws = [ss.laws.catalogue[name].typical() for name in NAMES] + laws_in_pieces(rng, 8)
    ends = []
    for law in laws:
        family, oscillators, zeta, q, w = scenes(law, rng, 8)
        found = arrive(family, zeta, q, w, (1 - w) * rtol)
        for i, osc in enumerate(oscillators):
            slip = follow(
                Scene.of(law, osc),
                Point(0.0, float(q[i]), float(w[i])),
                1,
                horizon=100.0,
                rtol=1e-12,
                until=End.MINIMUM,
            )
            ends.append(found.end[i])
            if found.end[i] == CREEPS:
                assert 1 - slip.last.w < 1e-3
                continue
            assert ENDS[found.end[i]] is slip.end, (law, osc)
            assert abs(found.w[i] - slip.last.w) <= CLOSE * rtol * (1 - w[i]), (law, osc)
            if slip.end is End.RETURN:
                # How deep it would come: beside a graze the place itself says little.
                speeds = np.array([found.slope[i], Scene.of(law, osc).acceleration(slip.last.q, 0.0, 1)])
                assert abs(np.diff(speeds**2 / 2)) <= 10 * CLOSE * rtol, (law, osc)
    assert set(ends) >= {TURN, RETURN}


def test_a_round_that_turns_just_beyond_a_kink_is_followed_there():
    """The step in which w turns begins and ends on this side of the kink, or of the one before."""
    law = ss.FrictionLaw("0.4 - 0.2*Min(v, 0.9) + 3*Max(v - 0.9, 0)")
    for height in (1e-5, 1e-4, 1e-3, 1e-2):
        # From rest to the kink at w = 1.8 and a little further, without damping.
        V, eta = np.array([0.5]), np.array([0.5])
        family = family_of(law, V, eta)
        osc = ss.Oscillator(m=1, k=1, V=0.5, N=0.25)
        w = np.array([0.2 - 0.0785 - height])
        q = -family.friction(w, family.piece(w))
        found = arrive(family, np.zeros(1), q, w, np.full(1, 1e-11))
        slip = follow(
            Scene.of(law, osc),
            Point(0.0, float(q[0]), float(w[0])),
            1,
            horizon=100.0,
            rtol=1e-13,
            until=End.MINIMUM,
        )
        assert found.w[0] == pytest.approx(slip.last.w, abs=1e-9)


def test_the_way_to_where_the_mass_stands_still_is_the_same_backward():
    """What leads down from w = 1 to a touch, followed back, is where it came from."""
    rng = np.random.default_rng(22)
    for law in [ss.laws.exponential.typical(), *laws_in_pieces(rng, 4)]:
        family, _, zeta, _, _ = scenes(law, rng, 6)
        touch = -family.friction(np.zeros(6), family.piece(np.zeros(6)))
        size, ways = np.full(6, 1e-11), np.ones(6, int)
        back = arrive(family.backward, -zeta, -touch, np.zeros(6), size, ways)
        assert (back.end == RETURN).all()
        for i in range(6):
            osc = ss.Oscillator(m=1, k=1, V=family.V[i], N=family.eta[i] * family.V[i], c=2 * zeta[i])
            slip = follow(Scene.of(law, osc), Point(0.0, -float(back.q[i]), 1.0), 1, horizon=20.0, rtol=1e-12)
            assert abs(min(point.w for point in [*slip.extrema, slip.last])) < 1e-8
