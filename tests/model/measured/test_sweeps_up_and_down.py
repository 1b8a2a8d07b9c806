"""Sweeps up and down and in both directions, held against what they were made of: curve, hysteresis, offset."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import stickslip_sym as ss
from stickslip_sym.model.measured.measurements import Measurements
from support.sweeps import sweep

TRUE = {"mu_s": 0.5, "mu_m": 0.2, "alpha": 3.0}
NOISE = 0.004
GAPS = {
    "constant": lambda v: 0.02 + 0 * v,
    "at low speeds": lambda v: -0.04 * np.exp(-v / 0.3),
    "closed": lambda v: 0.03 * v * (1.5 - v),
}


def mean(v):
    return 0.2 + 0.3 * np.exp(-3 * v)


def swept(rng, *, sweeps=1, dwell=1, speeds=None):
    """Speeds up and down, each held for some rows and jittering where it is, and 1 or -1 for each row."""
    speeds = np.linspace(0.02, 1.5, 30) if speeds is None else speeds
    up = np.repeat(speeds, rng.integers(1, dwell, len(speeds), endpoint=True))
    once, way = np.r_[up, up[::-1]], np.r_[np.ones(len(up)), -np.ones(len(up))]
    v = np.tile(once, sweeps)
    return (v * (1 + 0.003 * rng.normal(size=len(v))) if dwell > 1 else v), np.tile(way, sweeps)


SHAPES = ({}, {"sweeps": 3, "speeds": np.geomspace(0.005, 1.5, 12)}, {"dwell": 20})


@sweep(("gap", "shape"), product(GAPS, SHAPES), *zip(GAPS, SHAPES, strict=True))
def test_a_law_between_branches_has_the_errors_of_the_noise_alone(gap, shape):
    """Fitted as they stand, these rows have standard errors 3 to 10 times as wide."""
    held, wide = [], []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        v, way = swept(rng, **shape)
        plain = mean(v) + NOISE * rng.normal(size=len(v))
        measured = Measurements.of(v, plain + way / 2 * GAPS[gap](v))
        branches, sweeps = measured.branches, shape.get("sweeps", 1)
        assert (branches.rising, branches.falling) == (sweeps, sweeps)
        assert np.sum(branches.sweep != way[measured.order]) <= 0.05 * len(v)  # a dwell at the turn is halved
        error = branches.hysteresis * 2 * branches.sweep - GAPS[gap](measured.v)
        assert np.sqrt(np.mean(error**2)) < 2 * NOISE
        fit, without = (
            ss.fit(measured, laws="exponential").best,
            ss.fit(np.sort(v), plain[np.argsort(v)], laws="exponential").best,
        )
        held += [low <= TRUE[name] <= high for name, (low, high) in fit.confidence().items()]
        wide += [fit.standard_errors[name] / without.standard_errors[name] for name in TRUE]
    assert sum(held) >= 9
    assert 0.6 < np.median(wide) < 1.5


@given(st.integers(0, 2**32 - 1), st.floats(0.03, 0.3), st.booleans())
def test_an_offset_between_directions_is_removed_and_said(tmp_path_factory, seed, offset, signed):
    rng = np.random.default_rng(seed)
    one_way, _ = swept(rng)
    v = np.r_[one_way, -one_way]
    direction = np.sign(v)
    force = direction * (mean(abs(v)) + 0.002 * rng.normal(size=len(v))) + offset / 10
    rows = zip(v, force if signed else force * direction, strict=True)
    path = tmp_path_factory.mktemp("directions") / "disc.csv"
    path.write_text("v [m/s],mu\n" + "".join(f"{a:.9f},{b:.9f}\n" for a, b in rows))
    measured = ss.read_measurements(path)
    assert measured.branches.offset == pytest.approx(offset / 10, abs=5 * 0.002 / np.sqrt(len(v)))
    assert "both signs of speed folded, an offset of mu between the directions" in measured.understood
    assert np.std(measured.mu - mean(measured.v)) < 1.3 * 0.002


@given(st.integers(0, 2**32 - 1))
def test_single_sweeps_repeats_and_random_orders_stay_as_they_are(seed):
    rng = np.random.default_rng(seed)
    up = np.sort(rng.uniform(0.01, 1.5, 40))
    for v in (up, up[::-1], np.r_[up, up], np.r_[up, up][::-1], rng.permutation(np.r_[up, up])):
        measured = Measurements.of(v, mean(v) + 0.01 * rng.normal(size=len(v)))
        assert measured.branches is None
        assert measured.understood == f"{len(v)} rows"
        assert measured.project_out_branches(measured.mu) is measured.mu


def test_branches_that_are_alike_are_named_and_take_no_part_in_a_fit():
    rng = np.random.default_rng(3)
    v, _ = swept(rng)
    mu = mean(v) + NOISE * rng.normal(size=len(v))
    measured = Measurements.of(v, mu)
    assert measured.understood == "60 rows, 1 rising and 1 falling branch, alike"
    turned = np.argsort(v, kind="stable")
    assert measured.differences == 0
    assert (
        ss.fit(measured, laws="exponential").best.values
        == ss.fit(v[turned], mu[turned], laws="exponential").best.values
    )


def test_where_one_branch_was_measured_alone_is_warned_of():
    rng = np.random.default_rng(5)
    v, way = swept(rng)
    v, way = v[:45], way[:45]
    measured = Measurements.of(v, mean(v) + way * 0.01 + 0.002 * rng.normal(size=45))
    assert "below 0.786 m/s rising branches only" in measured.understood
    (warning,) = (text for text in ss.fit(measured, laws="exponential").best.warnings if "only" in text)
    assert warning.startswith("below 0.786 m/s rising branches only: elsewhere they differ")


def test_a_law_through_points_goes_through_the_mean_of_both_branches():
    v = np.linspace(0, 1.5, 31)
    up, down = v, v[::-1][1:] - 0.02
    speeds = np.r_[up, down[down > 0]]
    way = np.r_[np.ones(31), -np.ones(len(speeds) - 31)]
    law = ss.FrictionLaw.from_csv(Measurements.of(speeds, mean(speeds) + 0.01 * way))
    middle = np.linspace(0.1, 1.3, 200)
    assert np.max(np.abs(law.mu(middle) - mean(middle))) < 1e-3


def test_clean_columns_keep_the_branches(tmp_path, run):
    rng = np.random.default_rng(2)
    v, way = swept(rng)
    mu = mean(v) + 0.01 * way + 0.002 * rng.normal(size=len(v))
    (tmp_path / "raw.csv").write_text("v [m/s],mu\n" + "".join(f"{a},{b}\n" for a, b in zip(v, mu, strict=True)))
    code, out, err = run("read", "raw.csv", "--csv", "clean.csv", "--plot", "raw.svg")
    assert (code, err) == (0, "")
    assert "1 rising and 1 falling branch, rising above by 0.0" in " ".join(out.split())
    assert "rising speed" in (tmp_path / "raw.svg").read_text(encoding="utf-8")
    assert ss.read_measurements("clean.csv").branches.gap == ss.read_measurements("raw.csv").branches.gap


@given(st.integers(0, 2**32 - 1))
def test_rows_that_alternate_in_direction_lose_the_offset(seed):
    """No sweep is in them, and the offset of a load cell is known exactly without noise."""
    from pathlib import Path
    from tempfile import TemporaryDirectory

    rng = np.random.default_rng(seed)
    v, offset = np.sort(rng.uniform(0.05, 1.5, 6)), float(rng.uniform(0.005, 0.04))
    rows = [f"{way * a:.6f},{way * b + offset:.6f}\n" for a, b in zip(v, mean(v), strict=True) for way in (1, -1)]
    with TemporaryDirectory() as folder:
        file = Path(folder, "both.csv")
        file.write_text("v [m/s],mu\n" + "".join(rows))
        found = ss.read_measurements(file)
    assert found.branches.offset == pytest.approx(offset, abs=1e-5)
    np.testing.assert_allclose(found.mu, np.repeat(mean(v), 2), atol=2e-5)
