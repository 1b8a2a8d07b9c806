"""Functions as polynomials: every root and extremum of random ones, jumps, and what the budget leaves open."""

import math
from itertools import pairwise

import numpy as np
import pytest

from stickslip_sym.numerics.chebyshev import grid, polynomial_values
from stickslip_sym.numerics.known import Column, Unknown
from stickslip_sym.numerics.resolved import NO_VALUE, NODES, nodes, resolve
from stickslip_sym.numerics.subdivide import WORK
from support.sweeps import sweep

RTOL, MOST, NOISE = 1e-12, 4000, 1e-15
LOST = Unknown("lost")


def sampled(values, noise):
    errors = np.where(np.isfinite(values), noise * np.abs(values), 0.0)
    return Column.of(values, errors, LOST)


def resolved(function, edges, most=MOST):
    return resolve(lambda x: sampled(function(x), NOISE), edges, rtol=RTOL, most=most)


@sweep("seed", range(40), 0, 1, 2, 3)
def test_roots_and_extrema_are_those_by_construction(seed):
    """A polynomial times a wave, both of known roots, two pairs of them within 1e-3; the extrema lie between."""
    rng = np.random.default_rng(seed)
    roots = np.sort(rng.uniform(0, 1, 5))
    roots = np.sort([*roots, *(roots[[0, 3]] + rng.uniform(5e-4, 1e-3, 2))])
    wave = rng.uniform(20, 60)
    zeros = np.sort([*roots[(roots > 1e-3) & (roots < 1)], *np.arange(math.pi / wave, 1, math.pi / wave)])
    found = resolved(lambda x: np.sin(wave * x) * np.prod([x - root for root in roots], axis=0), [1e-3, 1])
    assert found.open == ()
    assert [root.x for root in found.roots()] == pytest.approx(zeros, abs=1e-6)
    places = np.searchsorted(zeros, [turn.x for turn in found.turns])
    assert (np.diff(places) <= 1).all()  # an extremum, at least, between two zeros


@sweep("seed", range(40), 16, 29, 38)
def test_rough_values_hide_no_roots(seed):
    """A sketch is off by a part of each value: pairs of roots within 1e-3 of each other are there all the same.

    Ripples about a slope make rows of roots, whose polynomial of degree 16 has one.
    """
    rng = np.random.default_rng(seed)
    pairs = np.sort(rng.uniform(0.1, 0.9, 2))
    pairs = np.sort([*pairs, *(pairs + rng.uniform(2e-4, 1e-3, 2))])
    place, height, wave = rng.uniform(0.2, 0.8), 10 ** rng.uniform(-2, -1), rng.uniform(200, 2000)
    for function in (
        lambda x: np.exp(np.sin(7 * x)) * np.prod([x - root for root in pairs], axis=0),
        lambda x: x - place + height * np.sin(wave * (x - place)),
    ):

        def rough(x, function=function):
            value, error = function(x), 1e-3 * np.abs(function(x))
            return Column.of(value + rng.uniform(-1, 1, x.size) * error / 4, error, LOST)

        def close(x, function=function):
            return sampled(function(x), NOISE)

        found = resolve(close, [0.0, 1.0], rtol=1e-8, most=40_000, sketch=rough)
        signs = function(np.linspace(0, 1, 200_001)[1:-1]) > 0
        assert found.open == ()
        assert len(found.roots()) == np.count_nonzero(np.diff(signs))


def test_a_jump_a_kink_and_a_stretch_without_value():
    for edges in ([0, 1], [0, 0.3, 0.6, 1]):  # not known, and known
        jump = resolved(lambda x: np.where(x < 0.3, x - 1, 2 - x), edges)
        (root,) = jump.roots()
        assert (root.x, jump.open) == (pytest.approx(0.3, abs=1e-10), ())
        kink = resolved(lambda x: np.abs(x - 0.6) + x / 2, edges)
        assert [turn.x for turn in kink.turns][1] == pytest.approx(0.6, abs=1e-9)
    beyond = resolved(lambda x: np.where(x < 0.4, x, math.inf), [0, 1])
    assert [root.x for root in beyond.roots(0.7)] == pytest.approx([0.4], abs=1e-10)
    stretches = resolved(lambda x: np.where((x > 0.4) & (x < 0.7), math.nan, x), [0, 1]).open
    assert {one.why for one in stretches} == {NO_VALUE}
    assert (stretches[0].low, stretches[-1].high) == (pytest.approx(0.4, abs=1e-10), pytest.approx(0.7, abs=1e-10))


def test_what_the_budget_leaves_open_is_listed():
    """A wave behind a bump: with few values it is open, and no root of it is claimed; with many it is resolved."""

    def wave(x):
        return 1 + np.where(x > 0.5, 2 * np.sin(500 * (x - 0.5)), 0.0)

    few, many = (resolved(wave, [0, 0.5, 1], most) for most in (400, 20_000))
    assert few.open_at(1.0) == [(0.5, 1.0)]
    assert {one.why for one in few.open} == {WORK}
    assert (few.roots(), many.open) == ([], ())
    assert few.open_at(100.0) == []  # far beyond all samples
    sign = np.sign(wave(np.linspace(0, 1, 100_001)))
    assert len(many.roots()) == np.count_nonzero(np.diff(sign))


@sweep("seed", range(40), 0, 1)
def test_weak_noise_hides_a_level_beside_an_extremum_and_no_other(seed):
    """Values with errors of 1e-4 of what they range over, which were to be 1e-12."""
    rng = np.random.default_rng(seed)
    place, height = rng.uniform(0.3, 0.7), rng.uniform(1, 3)

    def parabola(x):
        return height * (1 - (x - place) ** 2)

    noise = 1e-4
    found = resolve(lambda x: sampled(parabola(x), noise), [0.0, 1.0], rtol=RTOL, most=MOST)
    for level in rng.uniform(parabola(np.array([0.0, 1.0])).max(), height * (1 - 100 * noise), 5):
        assert found.open_at(level) == []
        assert len(found.roots(level)) == 2
    assert found.open_at(height * (1 + noise / 2)) == found.open_at(height * (1 - noise / 2)) != []
    assert found.open_at(height * (1 + 100 * noise)) == []
    rough = resolve(lambda x: sampled(parabola(x), 0.1), [0.0, 1.0], rtol=RTOL, most=MOST)
    assert rough.open_at(height * (1 - place**2 / 2)) != []


def with_errors(function, error):
    """Return a function of values that are known to an absolute error."""

    def asked(x):
        values = np.broadcast_to(function(x), x.shape).astype(float)
        return Column.of(values, np.full(x.size, error), LOST)

    return asked


def test_the_error_of_a_piece_is_what_errors_at_its_nodes_can_do():
    """Of worst signs of the errors at each of many places between the nodes: it is a bound, and no wide one."""
    between = np.linspace(-1, 1, 2001)
    moved = np.abs([polynomial_values(row, between) for row in grid(NODES).coefficients]).sum(axis=0).max()
    (piece,) = resolve(with_errors(lambda x: x, 1e-3), [0.0, 1.0], rtol=RTOL, most=MOST).pieces
    assert moved < piece.error / 1e-3 < 2 * moved


def test_an_error_hides_roots_where_it_is_no_small_part_of_what_values_range_over():
    for error, stretches in ((0.005, []), (0.02, [(0.0, 1.0)])):
        found = resolve(with_errors(lambda x: x, error / 4), [0.0, 1.0], rtol=RTOL, most=MOST)
        assert found.open_at(0.5) == stretches


def test_an_error_hides_roots_beside_an_extremum_only_far_above_the_tolerance():
    for ratio, hidden in ((500, False), (2000, True)):
        found = resolve(with_errors(lambda x: 1 - x**2, ratio * 1e-6 / 4), [-1.0, 1.0], rtol=1e-6, most=MOST)
        assert bool(found.open_at(1.0)) == hidden


def test_beside_a_jump_pieces_come_as_close_as_arguments_are_told_apart():
    pieces = resolved(lambda x: np.where(x < 0.3, x - 1, 2 - x), [0, 1]).pieces
    (gap,) = (after.low - before.high for before, after in pairwise(pieces) if after.low > before.high)
    assert 2e-12 < gap < 2e-11


def test_an_interval_that_stays_open_may_go_beyond_its_samples_by_two_of_their_steps():
    stretch, _ = resolved(lambda x: np.abs(x - 0.3), [0, 1], most=NODES).open  # both halves, not looked at
    x = nodes(np.array([0.0]), np.array([1.0]))[0]
    beyond = 2 * np.abs(np.diff(np.abs(x - 0.3))).max()
    assert stretch.estimate.most == pytest.approx(np.abs(x - 0.3).max() + beyond)
    assert stretch.estimate.least == pytest.approx(np.abs(x - 0.3).min() - beyond)


@pytest.mark.parametrize(("error", "calls"), [(0.05, 0), (0.2, 1)])
def test_a_sketch_is_enough_where_its_errors_are_small_beside_its_values(error, calls):
    """Of 1, whose sign is certain to ten errors."""
    asked = []

    def close(x):
        asked.append(x)
        return sampled(np.ones_like(x), NOISE)

    resolve(close, [0.0, 1.0], rtol=RTOL, most=MOST, sketch=with_errors(lambda x: 1.0, error / 4))
    assert len(asked) == calls


@pytest.mark.parametrize(("error", "calls"), [(3e-4, 0), (2e-3, 1)])
def test_a_sketch_with_a_root_is_enough_where_its_errors_are_a_thousandth_of_its_values(error, calls):
    asked = []

    def close(x):
        asked.append(x)
        return sampled(x, NOISE)

    resolve(close, [-1.0, 1.0], rtol=RTOL, most=MOST, sketch=with_errors(lambda x: x, error / 4))
    assert len(asked) == calls
