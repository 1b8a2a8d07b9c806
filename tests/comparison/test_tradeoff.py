"""Speed against accuracy: every method is there, its error is what is known of it, and what dominates it."""

import inspect
import json
import math
import re
import types
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import stickslip_sym as ss
from stickslip_sym.comparison import tradeoff
from stickslip_sym.comparison.compare import Row
from stickslip_sym.comparison.tradeoff import Trade
from stickslip_sym.core import deadline
from stickslip_sym.motion.thresholds.methods import methods
from stickslip_sym.output.content import content

DOUBLE = 4 * 2.0**-52
SIZES = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}
LAW = ss.laws.exponential.typical()
BISTABLE = ss.laws.exponential.bind(mu_s=1, mu_m=0.5, alpha=2)
BOX = {"V": 1.5, "N": 1, "m": 1, "k": 1, "c": 0.1}
SHARE = 0.30712613778  # by areas, at two tolerances


def by_name(trade):
    return {row.name: row for row in trade.rows}


def test_a_criterion_by_every_method(tmp_path):
    found = ss.tradeoff(LAW, of="criterion", V="0.001")
    rows = by_name(found.trades["criterion"])
    assert rows["plain lambdify, array"].relative_error > 1e-8  # (17) cancels four orders here
    assert rows["stable function, array"].relative_error < DOUBLE
    assert rows["stable function, one value"].relative_error < DOUBLE
    assert rows["Gauss rule, 2 nodes"].relative_error > 1e-3
    assert rows["Gauss rule, 32 nodes"].relative_error < DOUBLE
    assert rows["scipy.integrate.quad"].relative_error < 4 * DOUBLE
    for digits in (15, 30, 50):
        assert rows[f"mpmath, {digits} digits"].relative_error < 10.0 ** (1 - digits)
    assert all(row.seconds > 0 for row in rows.values())
    assert rows["stable function, array"].seconds < rows["stable function, one value"].seconds
    pytest.importorskip("matplotlib")
    found.plot(tmp_path / "trade.svg")
    assert "mpmath, 15 digits" in (tmp_path / "trade.svg").read_text()
    with pytest.raises(ss.InputError, match=r"cannot draw to 'trade\..*; try a name such as trade\.png"):
        found.plot(tmp_path / "trade.xyz")
    assert "<img" in found._repr_html_()
    assert "dominated by" in found._repr_html_()


@pytest.mark.parametrize(
    ("law", "options", "message"),
    [
        (ss.laws.exponential, {}, "no value for mu_s, mu_m, alpha"),
        (ss.laws.exponential.typical(mu_s="0.2"), {"of": "criterion"}, "the criterion is 0"),
        (LAW, {"of": ["criterion", "basins"]}, r"no trade of 'basins' \(did you mean 'basin'\?\); known"),
        (LAW, {"criterion": "harmonics"}, "no criterion 'harmonics'"),
        (LAW, {"of": "basin", "c": 1.0}, "no initial condition comes to rest near rest"),
        (ss.laws.polynomial.typical(), {"of": "basin"}, "rest and stick-slip coexist at no damping; give c"),
        (ss.laws.polynomial.typical(), {"of": "threshold", "V": 0.95}, "nothing has a relative error"),
        *((LAW, {"of": of}, "names nothing to measure; known: criterion, threshold") for of in ((), None, 3)),
        (LAW, {"of": "threshold", "time_limit": 0}, "time"),
        (LAW, {"of": ["criterion", "threshold"], "c": 1.0}, "c belongs to the basins of attraction"),
    ],
)  # fmt: skip
def test_refusals(law, options, message):
    with pytest.raises(ss.StickSlipError, match=message):
        ss.tradeoff(law, **options)


def test_what_cannot_be_measured_says_why():
    kinked = ss.FrictionLaw("Piecewise((0.5 - 0.2*v, v < 0.7), 0.36)")
    found = ss.tradeoff(kinked, of=["criterion", "threshold"], criterion="equilibrium")
    assert list(found.trades) == ["criterion"]
    assert "needs a law that is smooth" in found.refused["threshold"]
    assert "threshold: none: method=" in str(found)
    with pytest.raises(ss.InputError, match="needs a law that is smooth"):
        ss.tradeoff(kinked, of=["threshold"])


def test_when_time_is_up_there_is_no_number(monkeypatch):
    """Time is up with the first initial condition that SciPy takes."""
    over = []
    monkeypatch.setattr(deadline, "time_left", lambda: -1.0 if over else 100.0)
    monkeypatch.setattr(tradeoff, "SIMULATED", (5,))
    monkeypatch.setattr(tradeoff, "comes_to_rest", lambda *_, **__: over.append(True) or True)
    trade = ss.tradeoff(BISTABLE, of="basin", **BOX).trades["basin"]
    assert [row.value is not None for row in trade.rows] == [True, True, False, False, False, False]
    assert all(trade.dominators[row.name] == () for row in trade.rows if row.value is None)
    assert str(trade).count("none: the t") == 4
    assert "x0 = -2 to 2 m, v0 = 0 to 2 m/s" in trade.title
    assert trade.rows[0].value == pytest.approx(SHARE, abs=1e-10)


@pytest.fixture
def asked(monkeypatch):
    """Asks for a table, of which nothing is run: its title, and by its name what each row would compute."""
    rows = {}

    def measured(method, compute, judge, *, setting="", count=1, **repeated):
        row = Row(method, setting=setting)
        rows[row.name] = compute, count
        return row

    def ask(law, kind, **point):
        rows.clear()
        return ss.tradeoff(law, of=kind, **point).trades[kind].title, rows

    monkeypatch.setattr(tradeoff, "measured", measured)
    return ask


def test_rows_of_a_criterion(asked):
    """Users pick them by name; an array of about a megabyte is in the cache of a processor."""
    _, rows = asked(ss.laws.linear.typical(), "criterion")
    assert list(rows) == [
        "plain lambdify, array", "stable function, array", "stable function, one value",
        *(f"Gauss rule, {nodes} nodes" for nodes in (2, 4, 8, 16, 32)), "scipy.integrate.quad",
        *(f"mpmath, {digits} digits" for digits in (15, 30, 50)),
    ]  # fmt: skip
    for name in ("plain lambdify, array", "stable function, array"):
        compute, count = rows[name]
        assert 0.5e6 < np.broadcast_to(compute(), count).size * 8 < 2e6


def test_rows_of_a_threshold(asked):
    """The paper's scan, section 5, and its step and band at rest, section 3; SciPy's own tolerance, and less."""
    _, rows = asked(ss.laws.linear.typical(), "threshold")
    others = ["Newmark scan", *(f"solve_ivp and bisection, rtol 1e-0{digits}" for digits in (3, 6, 9))]
    assert list(rows) == [*methods(), *others]
    scan, _ = rows["Newmark scan"]
    assert np.diff(scan.args[2]) == pytest.approx(0.001)
    assert inspect.getfullargspec(scan.func).defaults == (1e-4, 1e-4)


def test_rows_of_a_basin(asked):
    """Numbers of samples that make errors half as large; all begin in a box that is the whole of the basin."""
    title, rows = asked(BISTABLE, "basin", **BOX)
    assert title.endswith("x0 = -2 to 2 m, v0 = 0 to 2 m/s")
    scipy = [f"solve_ivp {how}, rtol 1e-0{n}, 50 samples" for how in ("with events", "smoothed") for n in (3, 6)]
    assert list(rows) == ["geometry", *(f"simulation, {count} samples" for count in (50, 200, 800)), *scipy]


def test_the_sign_of_the_slip_speed_is_smoothed_over_a_hundredth_of_the_belt_speed(monkeypatch):
    rates = []

    def solve_ivp(function, span, y, **how):
        rates.append(function)
        return types.SimpleNamespace(t=np.linspace(*span), y=np.zeros((2, 50)))

    monkeypatch.setattr("scipy.integrate.solve_ivp", solve_ivp)
    osc = ss.Oscillator(**BOX)
    tradeoff.comes_to_rest_smoothed(BISTABLE, osc, 0.0, osc.V, 1e-3)
    shares = []
    for slip in (1e-2, 1e-1):
        v = osc.V * (1 - slip)
        _, acceleration = rates[0](0.0, (0.0, v))
        shares.append((osc.m * acceleration + osc.c * v) / (osc.N * BISTABLE.mu(osc.V * slip)))
    assert 0.7 < shares[0] < 0.8
    assert shares[1] == pytest.approx(1)


@pytest.mark.parametrize(("last", "rests"), [(0.05, True), (0.25, False)])
def test_a_run_is_at_rest_where_it_is_slow_to_its_end(last, rests):
    osc = ss.Oscillator(**BOX)
    t = np.linspace(0, 500, 5001)
    for before in (0.0, 2.0):
        v = osc.V * np.where(t < 450, before, last) * np.sin(t)
        assert tradeoff._is_quiet(t, v, osc) == rests


@pytest.mark.thorough
def test_thresholds_by_every_method(monkeypatch):
    monkeypatch.setattr(tradeoff, "SPEEDS", np.array([0.2, 0.5, 0.95]))  # the last has no threshold
    monkeypatch.setattr(tradeoff, "BISECTED", (1e-3, 1e-6))
    faster = partial(tradeoff.pure_slip_by_scan, step=5e-4, band=5e-4)
    monkeypatch.setattr(tradeoff, "pure_slip_by_scan", faster)
    trade = ss.tradeoff(ss.laws.polynomial.typical(), of="threshold").trades["threshold"]
    found = by_name(trade)
    names = ("equilibrium", "least_squares", "harmonic", "second_order", "orbit")
    errors = [found[name].relative_error for name in names]
    assert errors == sorted(errors, reverse=True)
    assert errors[0] > 0.05
    assert errors[-1] < 1e-12
    assert found["simulation"].relative_error < 1e-9
    assert 1e-4 < found["Newmark scan"].relative_error < 3e-3  # the paper's 3.038 for 3.036477
    assert all(row.seconds > 0 for row in found.values())
    bisected = [found[f"solve_ivp and bisection, rtol {rtol}"].relative_error for rtol in ("1e-03", "1e-06")]
    assert 1e-7 < bisected[1] < bisected[0] < 0.2
    assert "unknown" in str(trade)
    by = trade.dominators
    assert by["orbit"] == ()
    assert "orbit" in by["Newmark scan"]
    assert found["proof"].status is ss.Status.PROVED
    assert 0 < found["orbit"].further["largest error up to V = 1 m/s"] < 1e-9


@pytest.mark.parametrize("wrong", [False, True])
def test_the_error_of_a_share_has_two_parts(monkeypatch, wrong):
    """The simulation decides every sample as the areas say, so only their number is left; wrong ones count too."""
    monkeypatch.setattr(tradeoff, "SIMULATED", (10, 20) if wrong else (2, 20))
    if wrong:
        monkeypatch.setattr(tradeoff, "comes_to_rest", lambda *_, **__: False)
        monkeypatch.setattr(tradeoff, "comes_to_rest_smoothed", lambda *_, **__: True)
    trade = ss.tradeoff(BISTABLE, of="basin", **BOX).trades["basin"]
    found = by_name(trade)
    geometry = found.pop("geometry")
    assert geometry.value == pytest.approx(SHARE, abs=1e-10)
    assert geometry.relative_error < 1e-10
    assert trade.dominators["geometry"] == ()  # whatever takes less time is far less accurate
    for name, row in found.items():
        count, spread, share = int(name.split()[-2]), row.further["standard error"], row.value
        assert spread == pytest.approx(math.sqrt(SHARE * (1 - SHARE) / count))
        assert row.relative_error >= spread / SHARE * (1 - 1e-9)
        assert share * count == pytest.approx(round(share * count))
        if name.startswith("simulation"):
            assert row.relative_error == pytest.approx(spread / SHARE)
    for name, share in (("with events", 0.0), ("smoothed", 1.0)) if wrong else ():
        row, right = found[f"solve_ivp {name}, rtol 1e-03, 10 samples"], found["simulation, 10 samples"]
        assert row.value == share
        parts = (share - right.value) ** 2 + right.further["standard error"] ** 2
        assert (row.relative_error * SHARE) ** 2 == pytest.approx(parts)


def test_runs_of_scipy_decide_as_classify_does():
    """Away from the separatrix; with events and smoothed, and from both sides of the belt's speed."""
    rng = np.random.default_rng(3)
    rests, osc = 0, ss.Oscillator(**BOX)
    for x0, v0 in np.column_stack([rng.uniform(-2, 2, 3), rng.uniform(0, 2, 3)]).tolist():
        rest = ss.classify(BISTABLE, osc, x0=x0, v0=v0) is ss.Motion.REST
        rests += rest
        assert tradeoff.comes_to_rest(BISTABLE, osc, x0, v0, 1e-6) == rest
        assert tradeoff.comes_to_rest_smoothed(BISTABLE, osc, x0, v0, 1e-3) == rest
    assert 1 <= rests <= 2


# Few different times and errors, so that some are equal, and some without a number.
NUMBERS = st.tuples(st.integers(-8, 1).map(lambda n: 10.0**n), st.sampled_from([0.0, 1e-16, 2.5e-9, 1e-3, 0.2]))


@st.composite
def rows(draw):
    measured = draw(st.lists(st.none() | NUMBERS, min_size=1, max_size=13))
    families = st.sampled_from(["stable", "plain", "mpmath"])
    return [
        Row(draw(families), one and 1.0, one and one[1], None, one[0] if one else 1.0, setting=str(number))
        for number, one in enumerate(measured)
    ]


def is_dominated(row, other):
    """By the definition in words."""
    if row.value is None or other.value is None:
        return False
    if other.seconds > row.seconds or other.relative_error > row.relative_error:
        return False
    return (other.seconds, other.relative_error) != (row.seconds, row.relative_error)


@given(rows())
def test_a_method_is_dominated_by_definition(rows):
    by = Trade("", tuple(rows)).dominators
    assert list(by) == [row.name for row in rows]
    at_all = {row.name: {other.name for other in rows if is_dominated(row, other)} for row in rows}
    front = {name for name, others in at_all.items() if not others}
    for name, others in at_all.items():
        assert set(by[name]) == others & front
        assert bool(by[name]) == bool(others)


@given(rows())
def test_text_json_and_picture_say_what_was_measured(rows):
    """Read back from each; exchanged times and errors would be noticed, since they are of other sizes."""
    trade = Trade("of some kind", tuple(rows), {"V": 0.5})
    by_text = {cells[0]: cells for cells in (re.split(r" {2,}", line) for line in str(trade).splitlines()[3:])}
    found = json.loads(json.dumps(content(trade), allow_nan=False))
    for row, said in zip(rows, found["rows"], strict=True):
        cells = by_text[row.name]
        assert (said["method"], said["setting"]) == (row.method, row.setting)
        if row.value is None:
            assert cells[1].startswith("none:")
            assert (said["value"], said["relative_error"], found["dominators"][row.name]) == (None, None, [])
            continue
        number, unit = cells[3].split()
        assert float(number) * SIZES[unit] == pytest.approx(row.seconds, rel=5e-3)
        assert float(cells[2]) == pytest.approx(row.relative_error, rel=0.05)
        assert (said["seconds"], said["relative_error"]) == (row.seconds, row.relative_error)
        assert tuple(found["dominators"][row.name]) == trade.dominators[row.name]
        last = cells[-1].split("; ") if trade.dominators[row.name] else []
        assert set("".join(last).replace(" ", "")) == set("".join(trade.dominators[row.name]).replace(" ", ""))
    figure = pytest.importorskip("matplotlib.figure").Figure()
    trade.draw(axes := figure.add_subplot())
    drawn = sorted(
        (float(line.get_xdata()[0]), float(line.get_ydata()[0]), line.get_markerfacecolor() == "white")
        for line in axes.lines if line.get_label() in trade.dominators
    )  # fmt: skip
    there = [row for row in rows if row.value]
    expected = [(row.seconds, max(row.relative_error, 1e-51), bool(trade.dominators[row.name])) for row in there]
    assert drawn == sorted(expected)
