"""Noise with heavy tails is weighed down and said; stray rows and normal noise are not taken for it."""

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym.model.measured.heavy_tails import have_heavy_tails
from stickslip_sym.model.measured.measurements import Measurements
from support.sweeps import sweep

TRUE = {"mu_s": 0.5, "mu_m": 0.2, "alpha": 3.0}


def rows(kind, seed, count=4000):
    rng = np.random.default_rng(seed)
    v = np.sort(rng.uniform(0.002, 1.5, count))
    noise = 0.01 * (rng.standard_t(5, count) if kind == "heavy" else rng.normal(size=count))
    mu = ss.laws.exponential.typical().mu(v) + noise
    if kind == "stray":
        mu[rng.choice(count, 6, replace=False)] += 0.3
    return v, np.round(mu, 2) if kind == "coarse" else mu


@pytest.mark.parametrize(("kind", "heavy"), [("heavy", 10), ("normal", 0), ("stray", 0), ("coarse", 0)])
def test_heavy_tails_are_told_from_others(kind, heavy):
    assert sum(have_heavy_tails(*rows(kind, seed)) for seed in range(10)) == heavy


def test_a_file_with_heavy_tails_is_read_whole(tmp_path):
    v, mu = rows("heavy", 0)
    lines = "".join(f"{a:.6f},{b:.6f}\n" for a, b in zip(v, mu, strict=True))
    (tmp_path / "heavy.csv").write_text("v [m/s],mu\n" + lines)
    found = ss.read_measurements(tmp_path / "heavy.csv")
    assert len(found) == 4000
    assert "noise with heavy tails: " in str(found)
    assert found.tails.max() == 1
    assert found.tails.min() < 0.3


@sweep("sets", [8, 100], 8)
def test_weighing_tails_down_beats_least_squares(sets):
    """In the mean square error of the parameters, in units of what least squares states; intervals hold."""
    plain, weighed, held = [], [], []
    for seed in range(sets):
        found = Measurements.of(*rows("heavy", seed))
        by_squares = ss.fit(Measurements(found.v, found.mu, order=found.order), laws="exponential").best
        fit = ss.fit(found, laws="exponential").best
        for name, true in TRUE.items():
            low, high = fit.confidence()[name]
            held.append(low <= true <= high)
            for best, errors in ((fit, weighed), (by_squares, plain)):
                errors.append(((best.values[name] - true) / by_squares.standard_errors[name]) ** 2)
    assert np.mean(weighed) < np.mean(plain)
    assert np.mean(held) >= 0.9


def test_rows_at_rest_that_build_up_friction_are_set_apart(tmp_path):
    """They bound the static coefficient from below, and are no slip; rows of one coefficient may be mu(0+)."""
    v = np.linspace(0.02, 1.2, 40)
    slipping = "".join(f"{a:.3f},{b:.4f}\n" for a, b in zip(v, 0.2 + 0.3 * np.exp(-3 * v), strict=True))
    for held, bound in (([0.0, 0.1, 0.2, 0.62], 0.62), ([0.0, 0.1, 0.2], 0.2), ([0.5, 0.5], None), ([0.5], None)):
        resting = "".join(f"0,{mu}\n" for mu in held)
        (tmp_path / "ramp.csv").write_text("v [m/s],mu\n" + resting + slipping)
        found = ss.read_measurements(tmp_path / "ramp.csv")
        assert found.static_at_least == bound
        assert len(found) == 40 + (len(held) if bound is None else 0)
        assert ("rows at rest set apart" in str(found)) == (bound is not None)
        fit = ss.fit(found, laws="exponential").best
        assert fit.values["alpha"] == pytest.approx(3, rel=0.01)
        warned = [text for text in fit.warnings if "rows at rest reach mu" in text]
        assert len(warned) == (bound == 0.62)
        assert all(text.endswith('give it: static="0.62"') for text in warned)
        given = ss.fit(found, laws=ss.laws.exponential.with_static("0.62")).best
        assert not any("rows at rest" in text for text in given.warnings)
