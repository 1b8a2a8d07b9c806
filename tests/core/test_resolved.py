"""Functions as polynomials: every root and extremum of random ones, jumps, and what the budget leaves open."""

import math

import numpy as np
import pytest
from sweeps import sweep

from stickslip_sym.core.resolved import resolve

RTOL, MOST, NOISE = 1e-12, 4000, 1e-15


def resolved(function, edges, most=MOST):
    return resolve(lambda x: (function(x), NOISE * np.abs(function(x))), edges, rtol=RTOL, most=most)


@sweep("seed", range(40), 0, 1, 2, 3)
def test_roots_and_extrema_are_those_by_construction(seed):
    """A polynomial times a wave, both of known roots, two pairs of them within 1e-3; the extrema lie between."""
    rng = np.random.default_rng(seed)
    roots = np.sort(rng.uniform(0, 1, 5))
    roots = np.sort([*roots, *(roots[[0, 3]] + rng.uniform(5e-4, 1e-3, 2))])
    wave = rng.uniform(20, 60)
    zeros = np.sort([*roots[(roots > 1e-3) & (roots < 1)], *np.arange(math.pi / wave, 1, math.pi / wave)])
    found = resolved(lambda x: np.sin(wave * x) * np.prod([x - root for root in roots], axis=0), [1e-3, 1])
    assert found.unresolved == ()
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
            return value + rng.uniform(-1, 1, x.size) * error / 4, error

        def close(x, function=function):
            return function(x), NOISE * np.abs(function(x))

        found = resolve(close, [0.0, 1.0], rtol=1e-8, most=40_000, sketch=rough)
        signs = function(np.linspace(0, 1, 200_001)[1:-1]) > 0
        assert found.unresolved == ()
        assert len(found.roots()) == np.count_nonzero(np.diff(signs))


def test_a_jump_a_kink_and_a_stretch_without_value():
    for edges in ([0, 1], [0, 0.3, 0.6, 1]):  # not known, and known
        jump = resolved(lambda x: np.where(x < 0.3, x - 1, 2 - x), edges)
        (root,) = jump.roots()
        assert (root.x, jump.unresolved) == (pytest.approx(0.3, abs=1e-10), ())
        kink = resolved(lambda x: np.abs(x - 0.6) + x / 2, edges)
        assert [turn.x for turn in kink.turns][1] == pytest.approx(0.6, abs=1e-9)
    beyond = resolved(lambda x: np.where(x < 0.4, x, math.inf), [0, 1])
    assert [root.x for root in beyond.roots(0.7)] == pytest.approx([0.4], abs=1e-10)
    ((low, high),) = resolved(lambda x: np.where((x > 0.4) & (x < 0.7), math.nan, x), [0, 1]).unresolved
    assert (low, high) == (pytest.approx(0.4, abs=1e-10), pytest.approx(0.7, abs=1e-10))


def test_what_the_budget_leaves_open_is_listed():
    """A wave behind a bump: with few values it is open, and no root of it is claimed; with many it is resolved."""

    def wave(x):
        return 1 + np.where(x > 0.5, 2 * np.sin(500 * (x - 0.5)), 0.0)

    few, many = (resolved(wave, [0, 0.5, 1], most) for most in (400, 20_000))
    assert few.unresolved == ((0.5, 1.0),)
    assert (few.roots(), many.unresolved) == ([], ())
    sign = np.sign(wave(np.linspace(0, 1, 100_001)))
    assert len(many.roots()) == np.count_nonzero(np.diff(sign))
