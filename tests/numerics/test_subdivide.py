"""The loop over intervals: whatever is not accepted is listed, whatever ended the search."""

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from flint import arb

import stickslip_sym as ss
from stickslip_sym.core.deadline import time_limit
from stickslip_sym.numerics.known import Unknown
from stickslip_sym.numerics.subdivide import (
    CROWDED,
    HALVE,
    NARROW,
    WORK,
    Accept,
    DivisionLimits,
    Halve,
    WorkBudget,
    exact_middle,
    joined,
    locate_boundary,
    shown,
    subdivide,
)

EDGES = [(0.0, 1.0), (1.0, 3.0)]
STUCK = Unknown("no value there")


def at_most(width):
    def look(intervals):
        return [Accept(one.halvings) if one.high - one.low <= width else Halve(one.low) for one in intervals]

    return look


def covered(found):
    """Whether accepted and open intervals are the whole, each part once."""
    parts = sorted([*(one[:2] for one in found.accepted), *(one[:2] for one in found.open)])
    return parts[0][0] == 0 and parts[-1][1] == 3 and all(a[1] == b[0] for a, b in pairwise(parts))


@pytest.mark.parametrize("at_once", [1, 3, 100])
def test_all_is_accepted_in_order(at_once):
    found = subdivide(EDGES, at_most(0.25), limits=DivisionLimits(), at_once=at_once)
    assert found.complete() == [2] * 4 + [3] * 8
    assert covered(found)


@pytest.mark.parametrize(
    ("limits", "why"),
    [
        (DivisionLimits(WorkBudget(10), cost=3), WORK),
        (DivisionLimits(halvings=2), NARROW),
        (DivisionLimits(narrowest=0.5), NARROW),
        (DivisionLimits(parts=2), CROWDED),
    ],
)
@pytest.mark.parametrize("at_once", [1, 100])
def test_what_a_limit_leaves_is_open_with_its_reason(limits, why, at_once):
    found = subdivide(EDGES, at_most(0.25), limits=limits, at_once=at_once)
    assert covered(found)
    assert {one.why for one in found.open} == {why}
    assert found.complete() is why


def test_the_note_of_what_is_open_is_the_last_one():
    found = subdivide(EDGES, at_most(0.25), limits=DivisionLimits(halvings=1))
    assert [one.note for one in found.open] == [0.0, 0.5, 1.0, 2.0]
    found = subdivide(EDGES, at_most(0.25), limits=DivisionLimits(WorkBudget(2)))
    assert [one[:3] for one in found.open] == [(0, 0.25, 0.0), (0.25, 0.5, 0.0), (0.5, 1, 0.0), (1, 3, None)]


def test_a_look_may_not_know_and_the_lowest_open_one_ends_the_search():
    def look(intervals):
        for one in intervals:
            if one.low <= 0.6 < one.high:
                yield HALVE if one.high - one.low > 0.1 else STUCK
            else:
                yield Accept(one.first)

    found = subdivide(EDGES, look, limits=DivisionLimits())
    ((low, high, _, why),) = found.open
    assert (low <= 0.6 < high, why is STUCK, covered(found)) == (True, True, True)
    below = subdivide(EDGES, look, limits=DivisionLimits(), to_first_open=True)
    assert below.accepted == [one for one in found.accepted if one.high <= low]
    assert below.open == found.open


def test_fractions_and_balls_are_divided_exactly():
    found = subdivide([(Fraction(0), Fraction(1, 3))], at_most(Fraction(1, 12)), limits=DivisionLimits())
    assert [one.low for one in found.accepted] == [Fraction(k, 12) for k in range(4)]
    balls = subdivide([(arb(0), arb(1))], at_most(0.3), limits=DivisionLimits(), cut=exact_middle)
    assert [float(one.high) for one in balls.accepted] == [0.25, 0.5, 0.75, 1.0]
    assert all(one.high.is_exact() for one in balls.accepted)


def test_shown_looks_at_every_part_and_false_is_no_answer():
    def narrow_at(place, width):
        return lambda low, high, _: not low <= place <= high or high - low < width

    looked = []

    def noted(low, high, depth):
        looked.append((low, high))
        return high - low < 0.3

    assert shown(noted, [(0.0, 1.0)], halvings=2)
    assert {(0.0, 0.25), (0.25, 0.5), (0.5, 0.75), (0.75, 1.0)} <= set(looked)
    assert shown(narrow_at(0.77, 0.01), [(0.0, 1.0)], halvings=8)
    assert not shown(narrow_at(0.77, 0.01), [(0.0, 1.0)], halvings=5)
    assert not shown(narrow_at(0.77, 0.01), [(0.0, 1.0)], halvings=8, most=8)


def test_boundaries_and_joined_intervals():
    inside, outside = locate_boundary(lambda x: x < 2 / 3, 0.0, 1.0, 1e-9)
    assert (inside < 2 / 3 <= outside, outside - inside <= 1e-9) == (True, True)
    inside, outside = locate_boundary(lambda x: x < 2 / 3, 0.0, 1.0, 0.0)
    assert np.nextafter(inside, 1) == outside
    assert joined([(2, 3), (0, 1), (1, 1.5), (0.2, 0.5)]) == [(0, 1.5), (2, 3)]


def test_a_time_limit_ends_it():
    with time_limit(0), pytest.raises(ss.OutOfTime):
        subdivide([(0.0, 1.0)], lambda intervals: [HALVE for _ in intervals], limits=DivisionLimits())
