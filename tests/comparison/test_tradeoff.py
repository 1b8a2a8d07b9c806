"""Speed against accuracy: every way is there, and its error is what is known of it."""

import math
import subprocess
import sys
from itertools import combinations

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym.comparison import basin_tradeoff, plain, threshold_tradeoff
from stickslip_sym.comparison.criterion_tradeoff import DIGITS
from stickslip_sym.core import deadline
from stickslip_sym.output import drawing

DOUBLE = 4 * 2.0**-52


LAW = ss.laws.exponential.typical()
BISTABLE = ss.laws.exponential.bind(mu_s=1, mu_m=0.5, alpha=2)
BISTABLE_OSC = ss.Oscillator(m=1, k=1, c=0.1, V=1.5, N=1)
SHARE = 0.30712613778  # by areas, at two tolerances


@pytest.fixture(scope="module")
def measured():
    return ss.tradeoff(LAW, of="criterion", V="0.001")


@pytest.fixture(scope="module")
def ways(measured):
    return {way.name: way for way in measured.trades["criterion"].ways}


def test_errors_are_what_they_should_be(ways):
    assert ways["plain lambdify, array"].error > 1e-8  # (17) cancels four orders here
    assert ways["stable function, array"].error < DOUBLE
    assert ways["stable function, one value"].error < DOUBLE
    assert ways["Gauss rule, 2 nodes"].error > 1e-3
    assert ways["Gauss rule, 32 nodes"].error < DOUBLE
    assert ways["scipy.integrate.quad"].error < 4 * DOUBLE
    for digits in DIGITS:
        assert ways[f"mpmath, {digits} digits"].error < 10.0 ** (1 - digits)


def test_times_are_measured(ways):
    assert all(way.seconds > 0 for way in ways.values())
    assert ways["stable function, array"].seconds < ways["stable function, one value"].seconds


def test_refusals():
    with pytest.raises(ss.InputError, match="no value for mu_s, mu_m, alpha"):
        ss.tradeoff(ss.laws.exponential)
    with pytest.raises(ss.InputError, match="the criterion is 0"):
        ss.tradeoff(ss.laws.exponential.typical(mu_s="0.2"), of="criterion")
    with pytest.raises(
        ss.InputError, match=r"no trade of 'basins' \(did you mean 'basin'\?\); there are: criterion"
    ):
        ss.tradeoff(LAW, of=["criterion", "basins"])
    with pytest.raises(ss.InputError, match="no criterion 'harmonics'"):
        ss.tradeoff(LAW, criterion="harmonics")
    with pytest.raises(ss.InputError, match="no start comes to rest in this box"):
        ss.tradeoff(LAW, of="basin", c=1.0)
    with pytest.raises(ss.NotConverged, match="rest and stick-slip coexist at no damping; give a c"):
        ss.tradeoff(ss.laws.polynomial.typical(), of="basin")


def test_what_cannot_be_measured_is_left_out_with_the_reason_unless_nothing_can():
    kinked = ss.FrictionLaw("Piecewise((0.5 - 0.2*v, v < 0.7), 0.36)")
    found = ss.tradeoff(kinked, of=["criterion", "threshold"], criterion="equilibrium")
    assert list(found.trades) == ["criterion"]
    assert "needs a law that is smooth" in found.refused["threshold"]
    assert "threshold: none: method=" in str(found)
    with pytest.raises(ss.InputError, match="needs a law that is smooth"):
        ss.tradeoff(kinked, of=["threshold"])
    with pytest.raises(ss.StickSlipError):
        ss.tradeoff(LAW, time_limit=0)


def test_ways_that_are_left_when_time_is_up_have_no_number(monkeypatch):
    """Time is up with the first start that SciPy takes."""
    over = []
    monkeypatch.setattr(deadline, "time_left", lambda: -1.0 if over else 100.0)
    monkeypatch.setattr(basin_tradeoff, "SIMULATED", (5,))
    monkeypatch.setattr(basin_tradeoff, "comes_to_rest", lambda *_, **__: over.append(True) or True)
    trade = ss.tradeoff(BISTABLE, of="basin", V=1.5, N=1, m=1, k=1, c=0.1).trades["basin"]
    assert [way.found for way in trade.ways] == [True, True, False, False, False, False]
    assert all(trade.dominators[way.name] == () for way in trade.ways if not way.found)
    assert str(trade).count("no number") == 4
    assert trade.box == {"x0": pytest.approx((-2, 2)), "v0": pytest.approx((0, 2))}
    assert trade.ways[0].share == pytest.approx(SHARE, abs=1e-10)


def test_picture(measured, tmp_path):
    pytest.importorskip("matplotlib")
    measured.plot(tmp_path / "trade.svg")
    assert "mpmath, 15 digits" in (text := (tmp_path / "trade.svg").read_text())
    assert "50 digits" in text
    with pytest.raises(ss.InputError, match=r"cannot draw to 'trade\..*; try a name such as trade\.png"):
        measured.plot(tmp_path / "trade.xyz")
    shown = measured._repr_html_()
    assert "<img" in shown
    assert "dominated by" in shown


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
    monkeypatch.setattr(threshold_tradeoff, "BISECTED", (1e-3, 1e-6))
    trade = threshold_tradeoff.threshold_tradeoff(ss.laws.polynomial.typical(), scene)
    found = {way.name: way for way in trade.ways}
    errors = [found[name].error for name in ("equilibrium", "least_squares", "harmonic", "second_order", "orbit")]
    assert errors == sorted(errors, reverse=True)
    assert errors[0] > 0.05
    assert errors[-1] < 1e-12
    assert found["simulation"].error < 1e-9
    assert 1e-4 < found["Newmark scan"].error < 1e-3  # the paper's 3.038 for 3.036477
    assert all(way.seconds > 0 for way in found.values())
    bisected = [found[f"solve_ivp and bisection, rtol {rtol}"].error for rtol in ("1e-03", "1e-06")]
    assert 1e-7 < bisected[1] < bisected[0] < 0.2
    assert "not measured" in str(trade)
    by = trade.dominators
    assert by["orbit"] == by["second_order"] == ()
    assert "orbit" in by["simulation"]
    assert "orbit" in by["Newmark scan"]
    with pytest.raises(ss.NoThreshold, match="nothing has a relative error"):
        threshold_tradeoff.threshold_tradeoff(ss.laws.polynomial.typical(), scene | {"V": 0.95})


def test_shares_by_every_way(monkeypatch):
    monkeypatch.setattr(basin_tradeoff, "SIMULATED", (10, 40))
    monkeypatch.setattr(basin_tradeoff, "WRITTEN", 4)
    trade = basin_tradeoff.basin_tradeoff(BISTABLE, BISTABLE_OSC, x0=(-2.0, 2.0), v0=(0.0, 2.0))
    found = {way.name: way for way in trade.ways}
    geometry = found.pop("geometry")
    assert geometry.share == pytest.approx(SHARE, abs=1e-10)
    assert geometry.error < 1e-10
    assert trade.dominators["geometry"] == ()  # whatever takes less time is far less accurate
    for name, way in found.items():
        count = int(name.split()[-2])
        assert way.standard_error == pytest.approx(math.sqrt(SHARE * (1 - SHARE) / count))
        assert way.error >= way.standard_error / SHARE * (1 - 1e-9)
        assert way.share * count == pytest.approx(round(way.share * count))
    # Ours decides every start as the areas say; so nothing but the number of starts is left of its error.
    for name in ("simulation, 10 starts", "simulation, 40 starts"):
        assert found[name].error == pytest.approx(found[name].standard_error / SHARE)
    assert found["simulation, 10 starts"].seconds < found["simulation, 40 starts"].seconds


def test_a_way_that_decides_starts_wrong_is_off_by_more_than_their_number_brings(monkeypatch):
    monkeypatch.setattr(basin_tradeoff, "SIMULATED", (10,))
    monkeypatch.setattr(basin_tradeoff, "WRITTEN", 10)
    monkeypatch.setattr(basin_tradeoff, "comes_to_rest", lambda *_, **__: False)
    monkeypatch.setattr(basin_tradeoff, "comes_to_rest_smoothed", lambda *_, **__: True)
    trade = basin_tradeoff.basin_tradeoff(BISTABLE, BISTABLE_OSC, x0=(-2.0, 2.0), v0=(0.0, 2.0))
    found = {way.name: way for way in trade.ways}
    right = found["simulation, 10 starts"]
    for rest, name in ((0.0, "with events"), (1.0, "smoothed")):
        way = found[f"solve_ivp {name}, rtol 1e-03, 10 starts"]
        assert way.share == rest
        assert (way.error * SHARE) ** 2 == pytest.approx((rest - right.share) ** 2 + right.standard_error**2)


def test_what_one_writes_with_scipy_decides_seeded_starts_as_we_do():
    """Away from the separatrix; both ways of writing it, and starts on both sides of the belt's speed."""
    rng = np.random.default_rng(3)
    rests = 0
    for x0, v0 in np.column_stack([rng.uniform(-2, 2, 10), rng.uniform(0, 2, 10)]).tolist():
        rest = ss.classify(BISTABLE, BISTABLE_OSC, x0=x0, v0=v0) is ss.Motion.REST
        rests += rest
        assert plain.comes_to_rest(BISTABLE, BISTABLE_OSC, x0, v0, 1e-6) == rest
        assert plain.comes_to_rest_smoothed(BISTABLE, BISTABLE_OSC, x0, v0, 1e-3) == rest
    assert 1 <= rests <= 9


def test_bisection_refuses_what_has_no_threshold():
    rising, falling = ss.FrictionLaw("0.3 + 0.2*v"), ss.FrictionLaw("0.3 - 0.2*v")
    osc = ss.Oscillator(m=1, k=1, V=0.5, N=1)
    with pytest.raises(ss.NoThreshold, match="does not come back even without damping"):
        plain.pure_slip_by_bisection(rising, osc, 1e-3)
    assert plain.pure_slip_by_bisection(falling, osc, 1e-6) == pytest.approx(0.2, rel=1e-2)


@pytest.mark.parametrize("seed", range(3))
def test_no_label_covers_another_or_a_point_or_leaves_the_panel(seed):
    """Of points in a crowd, and in a row along the upper edge; some need a line to their labels."""
    figure_module = pytest.importorskip("matplotlib.figure")
    from matplotlib.text import Text

    axes = figure_module.Figure(figsize=(7, 4)).add_subplot()
    crowd = [(1.0, 1.0), (1.0, 1.01), (1.02, 1.0), (2.0, 1.0), (2.0, 1.0)]
    row = [(float(x), 1.9) for x in np.random.default_rng(seed).uniform(0.4, 2.0, 6)]
    points = [*crowd, *row]
    axes.plot(*zip(*points, strict=True), "o")
    axes.set(xlim=(0, 3), ylim=(0, 2))
    drawing.label(axes, [(f"the point {i} of them", place, "k") for i, place in enumerate(points)])
    renderer = axes.figure.canvas.get_renderer()
    boxes = [Text.get_window_extent(text, renderer) for text in axes.texts]
    assert len(boxes) == len(points)
    assert any(text.arrow_patch is not None for text in axes.texts)
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))
    assert not any(box.contains(*axes.transData.transform(place)) for box in boxes for place in points)
    assert all(axes.bbox.contains(*corner) for box in boxes for corner in (box.min, box.max))


@pytest.mark.parametrize("of", [(), None, 3])
def test_nothing_to_measure_is_refused(of):
    with pytest.raises(ss.InputError, match="names nothing to measure; there are: criterion, threshold, basin"):
        ss.tradeoff(ss.laws.linear.typical(), of=of)


def test_a_formula_that_numpy_has_no_function_for_gives_no_number_as_it_stands():
    """Polylogarithms; the stable function has them, by its branches."""
    trade = ss.tradeoff(ss.laws.catalogue["sech"].typical(), of="criterion", time_limit=20).trades["criterion"]
    found = {way.name: way.found for way in trade.ways}
    assert not found["plain lambdify, array"]
    assert found["stable function, array"]
