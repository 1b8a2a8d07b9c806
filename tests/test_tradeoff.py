"""Speed against accuracy: every way is there, and its error is what is known of it."""

import subprocess
import sys
from itertools import combinations

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym.comparison import threshold_tradeoff, tradeoff
from stickslip_sym.output import drawing

DOUBLE = 4 * 2.0**-52


@pytest.fixture(scope="module")
def ways():
    form = ss.derive(ss.laws.exponential.typical())
    return {way.name: way for way in tradeoff.tradeoff(form, {"V": "0.001", "N": "9.81"})}


def test_errors_are_what_they_should_be(ways):
    assert ways["plain lambdify, array"].error > 1e-8  # (17) cancels four orders here
    assert ways["stable function, array"].error < DOUBLE
    assert ways["stable function, one value"].error < DOUBLE
    assert ways["Gauss rule, 2 nodes"].error > 1e-3
    assert ways["Gauss rule, 32 nodes"].error < DOUBLE
    assert ways["scipy.integrate.quad"].error < 4 * DOUBLE
    for digits in tradeoff.DIGITS:
        assert ways[f"mpmath, {digits} digits"].error < 10.0 ** (1 - digits)


def test_times_are_measured(ways):
    assert all(way.seconds > 0 for way in ways.values())
    assert ways["stable function, array"].seconds < ways["stable function, one value"].seconds


def test_refusals():
    with pytest.raises(ss.InputError, match="no value for mu_s, mu_m, alpha"):
        tradeoff.tradeoff(ss.derive(ss.laws.exponential), {"V": "1", "N": "1"})
    with pytest.raises(ss.InputError, match="the criterion is 0"):
        tradeoff.tradeoff(ss.derive(ss.laws.exponential.typical(mu_s="0.2")), {"V": "1", "N": "1"})


def test_picture(ways, tmp_path):
    pytest.importorskip("matplotlib")
    tradeoff.plot(list(ways.values()), tmp_path / "trade.svg", "title")
    assert "mpmath, 50 digits" in (tmp_path / "trade.svg").read_text()
    for name in ("trade.xyz", "missing/trade.svg"):
        with pytest.raises(ss.InputError, match=r"cannot draw to 'trade\..*; try a name such as trade\.png"):
            tradeoff.plot(list(ways.values()), tmp_path / name, "title")


def test_command():
    command = [
        sys.executable,
        "-c",
        "from stickslip_sym.cli.program import main; main()",
        "tradeoff",
        "hyperbolic",
        "-V",
        "0.1",
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    assert "stable function, one value" in done.stdout


def test_thresholds_of_every_rung_and_of_the_paper_s_procedure(monkeypatch):
    monkeypatch.setattr(threshold_tradeoff, "SPEEDS", np.array([0.2, 0.5, 0.95]))  # the last has no threshold
    scene = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}
    found = {way.name: way for way in threshold_tradeoff.threshold_tradeoff(ss.laws.polynomial.typical(), scene)}
    errors = [found[name].error for name in ("equilibrium", "least_squares", "harmonic", "second_order", "orbit")]
    assert errors == sorted(errors, reverse=True)
    assert errors[0] > 0.05
    assert errors[-1] < 1e-12
    assert found["simulation"].error < 1e-9
    assert 1e-4 < found["Newmark scan"].error < 1e-3  # the paper's 3.038 for 3.036477
    assert all(way.seconds > 0 for way in found.values())
    assert "not measured" in threshold_tradeoff.threshold_report(list(found.values()))
    with pytest.raises(ss.NoThreshold, match="nothing has a relative error"):
        threshold_tradeoff.threshold_tradeoff(ss.laws.polynomial.typical(), scene | {"V": 0.95})


def test_no_label_covers_another_or_a_point():
    figure_module = pytest.importorskip("matplotlib.figure")
    axes = figure_module.Figure(figsize=(7, 4)).add_subplot()
    points = [(1.0, 1.0), (1.0, 1.01), (1.02, 1.0), (2.0, 1.0), (2.0, 1.0)]
    axes.plot(*zip(*points, strict=True), "o")
    axes.set(xlim=(0, 3), ylim=(0, 2))
    drawing.label(axes, [(f"point {i}", place, "k") for i, place in enumerate(points)])
    canvas = axes.figure.canvas
    boxes = [text.get_window_extent(canvas.get_renderer()) for text in axes.texts]
    assert len(boxes) == len(points)
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))
    assert not any(box.contains(*axes.transData.transform(place)) for box in boxes for place in points)
