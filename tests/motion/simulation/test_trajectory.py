"""`Trajectory`: its course between samples, its file, its picture."""

import csv
import math

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym import Phase
from stickslip_sym.motion.simulation.trajectory import EventKind, State
from support.operating_points import paper_oscillator


@pytest.fixture(scope="module")
def motion():
    """A start faster than the belt, that overtakes, sticks and slips."""
    osc = paper_oscillator(-1.0)
    return ss.simulate(ss.laws.exponential.typical(), osc, t_end=3.0, x0=-0.1, v0=1.0, rtol=1e-12)


def test_at_is_as_accurate_between_samples():
    """A constant law without damping: x is a sine about its rest."""
    osc, law = paper_oscillator(0.0), ss.FrictionLaw("0.3")
    motion = ss.simulate(law, osc, t_end=0.7, x0=0.02, v0=0.0, rtol=1e-12)
    t = np.linspace(0, 0.7, 999)
    rest = 0.3 * osc.N / osc.k
    found = motion.at(t)
    assert found.x == pytest.approx(rest + (0.02 - rest) * np.cos(10 * t), abs=1e-12)
    assert found.v == pytest.approx(-(0.02 - rest) * 10 * np.sin(10 * t), abs=1e-11)


def test_at_takes_any_shape_and_stick_is_exact(motion):
    state = motion.at(np.linspace(0, 3, 12).reshape(3, 4))
    assert isinstance(state, State)
    assert {part.shape for part in state} == {(3, 4)}
    assert motion.at(1.0).x.shape == ()
    stick = next(stretch for stretch in motion.stretches if stretch.phase is Phase.STICK)
    t = np.linspace(stretch_start := stick.start, stick.end, 101)[1:-1]
    found = motion.at(t)
    assert np.all(found.v == 0.5)
    assert np.all(found.phase == Phase.STICK)
    assert np.diff(found.x) == pytest.approx(0.5 * np.diff(t), rel=1e-10)
    assert found.x[0] == pytest.approx(motion.at(stretch_start).x + 0.5 * (t[0] - stretch_start), rel=1e-13)


@pytest.mark.parametrize("t", [-1e-3, 3.001, math.nan, math.inf, [0.5, 9.0], "soon"])
def test_at_refuses_other_times(motion, t):
    outside = r"outside the motion, which was computed from 0 s to 3 s \(finished\)"
    with pytest.raises(ss.InputError, match="t = 'soon' is not a number" if t == "soon" else outside):
        motion.at(t)
    assert motion.at(3.0) == motion.at(np.nextafter(3.0, 4))


def test_events_say_what_happens(motion):
    kinds = [event.kind for event in motion.events]
    assert kinds[0] is EventKind.START
    assert {EventKind.STICKS, EventKind.SLIPS, EventKind.CROSSES} <= set(kinds)
    for before, event in zip(motion.events, motion.events[1:], strict=False):
        expected = EventKind.SLIPS if before.begins is Phase.STICK else EventKind.CROSSES
        assert event.kind is (EventKind.STICKS if event.begins is Phase.STICK else expected)
    assert repr(motion).endswith(", 14 changes of phase, finished")


def test_the_file_has_units_and_every_digit(motion, tmp_path):
    motion.to_csv(tmp_path / "all.csv")
    with (tmp_path / "all.csv").open(newline="") as stream:
        header, *rows = csv.reader(stream)
    assert header == ["t (s)", "x (m)", "v (m/s)", "phase"]
    assert (
        pytest.approx(np.array([motion.t, motion.x, motion.v]), abs=0)
        == np.array([row[:3] for row in rows], dtype=float).T
    )
    assert [row[3] for row in rows] == [phase.name.lower() for phase in motion.phase]
    motion.to_csv(str(tmp_path / "even.csv"), t=np.linspace(0, 3, 31))
    assert len((tmp_path / "even.csv").read_text().splitlines()) == 32
    with pytest.raises(ss.InputError, match="outside the motion"):
        motion.to_csv(tmp_path / "none.csv", t=[4.0])
    with pytest.raises(ss.InputError, match="cannot write"):
        motion.to_csv(tmp_path / "missing" / "a.csv")


def test_picture_tells_stick_from_slip(motion, tmp_path):
    pytest.importorskip("matplotlib")
    figure = motion.plot(tmp_path / "motion.svg")
    text = (tmp_path / "motion.svg").read_text()
    assert all(phase.value in text for phase in Phase)
    motion.plot(tmp_path / "again.svg")
    assert (tmp_path / "again.svg").read_text() == text
    labels = {panel.get_xlabel() for panel in figure.axes} | {panel.get_ylabel() for panel in figure.axes}
    assert labels - {""} == {"time $t$ (s)", "displacement $x$ (m)", "velocity $\\dot x$ (m/s)"}
    # Stick, slip slower and slip faster differ in weight or in dashes, not in colour alone.
    styles = {(line.get_linewidth(), line.get_linestyle()) for line in figure.axes[0].lines}
    assert len(styles) == 3
    drawn = figure.axes[-1].lines[1]
    inside = np.isfinite(drawn.get_ydata())
    assert np.all(drawn.get_ydata()[inside] <= 0.5 + 1e-9)
    assert motion.plot() is not figure
