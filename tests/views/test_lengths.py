"""How much is shown: for each limit something short that is whole, and something long that is not."""

import json
import math
import re
from types import SimpleNamespace

import numpy as np
import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym.cli import arguments
from stickslip_sym.cli import map as map_command
from stickslip_sym.cli import output as cli_output
from stickslip_sym.cli import simulate as simulate_command
from stickslip_sym.core import symbols
from stickslip_sym.core.progress import StepOfWork
from stickslip_sym.formula.derivation import Step
from stickslip_sym.model.measured.measurements import Measurements
from stickslip_sym.motion.maps.cells import Reason
from stickslip_sym.motion.simulation.trajectory import EventKind, Phase
from stickslip_sym.motion.thresholds.averages import resolved_gauss_average
from stickslip_sym.output.files import read_bytes
from stickslip_sym.output.notation import notation_of
from stickslip_sym.output.tables import TERMINAL_WIDTH
from stickslip_sym.views import dispatch, drawing, maps, markup
from stickslip_sym.views.pages import browser, explorer, render, study_page


def sum_of_length(length):
    """A sum that is about so many characters long as text."""
    return sp.Add(*sp.symbols(f"a100:{100 + length // 7}", positive=True))


@pytest.mark.parametrize(("length", "is_whole"), [(40, True), (150, False)])
def test_a_long_step_of_work_is_cut(length, is_whole):
    said = cli_output._progress_text(StepOfWork("x" * length, 0, 0))
    assert (said == "x" * length) == is_whole
    assert len(said) < TERMINAL_WIDTH


@pytest.mark.parametrize(("length", "is_whole"), [(2500, True), (8000, False)])
def test_a_formula_of_a_screen(length, is_whole):
    assert ("characters" in markup.inline_formula("x" * length)) != is_whole


@pytest.mark.parametrize(("length", "is_whole"), [(140, True), (500, False)])
def test_a_step_in_a_line(length, is_whole):
    verdict = SimpleNamespace(status=ss.Status.PROVED)
    step = Step("add", "of nothing", sp.Eq(symbols.c, sum_of_length(length)), verdict)
    assert ("..." in repr(step)) != is_whole


def test_a_formula_of_a_page_is_set_or_text_or_its_length():
    elements = [study_page._formula(symbols.c, sum_of_length(length))[:5] for length in (180, 700, 4000)]
    assert elements == ["<math", "<code", "<p cl"]


@pytest.mark.parametrize(("count", "is_whole"), [(8, True), (28, False)])
def test_the_middle_of_a_long_list_is_left_out(count, is_whole):
    assert (None not in markup.shortened(range(count))) == is_whole
    v = np.linspace(0.1, 1, count)
    rows = dispatch.parts(Measurements(v, v))[1][1]
    assert (rows[-1][0] == "...") or count < 10
    assert 3 < len(rows) < 12


def test_many_points_are_thinned():
    for count in (1500, 50_000):
        shown, _ = explorer._points(Measurements(np.linspace(0, 1, count), np.ones(count)))
        assert len(shown) == count or 1500 < len(shown) < 8000 < count


@pytest.mark.parametrize(
    ("value", "error", "has_power"), [(5e6, 1e5, False), (2e7, 1e5, True), (1.0, 1e-6, False), (1.0, 1e-14, True)]
)
def test_numbers_with_errors_are_written_out_where_they_are_short(value, error, has_power):
    assert ("<sup>" in render.number_with_error(value, error)) == has_power


@pytest.mark.parametrize(("ratio", "is_logarithmic"), [(14, False), (70, True)])
def test_axes_of_equal_ratios_are_logarithmic_where_they_are_long(ratio, is_logarithmic):
    assert maps._is_logarithmic(np.geomspace(1, ratio, 9)) == is_logarithmic
    assert not maps._is_logarithmic(np.linspace(1, ratio, 9))


def test_figures_are_as_wide_as_text_and_two_stand_on_a_page():
    width, height = drawing.empty_figure().get_size_inches()
    assert 5 < width < 9
    assert 1.2 < width / height < 1.8
    assert width < 2 * study_page._SCALE * width < 2 * width


@pytest.mark.parametrize(("sheets", "is_small"), [(1, False), (2, False), (3, True), (9, True)])
def test_a_study_that_fills_more_than_two_sheets_has_small_letters(tmp_path, monkeypatch, sheets, is_small):
    printed = []

    def as_pdf(page):
        printed.append(page)
        return b"/Type /Page " * sheets

    monkeypatch.setattr(browser, "_as_pdf", as_pdf)
    study_page.print_page_of_study(SimpleNamespace(page="<head></head>"), tmp_path / "study.pdf")
    sizes = [float(size) for size in re.findall(r"font-size: ([\d.]+)pt", "".join(printed))]
    assert len(sizes) == is_small
    assert all(6 <= size < 8 for size in sizes), "smaller than those of the page, and not too small to be read"


def test_a_table_of_averages_over_speed_is_fine_and_short():
    """Between its rows nine digits by the cubic of the page, which is not made longer by more."""
    law = ss.FrictionLaw("0.2 + 0.3*exp(-3*v)")
    slider = explorer._slider("V", 0.3, "m/s", "belt speed", "positive")
    rows = np.array(explorer._table(law, ss.criteria.least_squares, slider))
    low, high = np.log(slider["low"]), np.log(slider["high"])
    between = np.exp(low + (high - low) * (np.arange(1, len(rows) - 2) + 0.5) / (len(rows) - 1))
    right = resolved_gauss_average(law.kinetic, ss.criteria.least_squares, between)
    cubic = (9 * (rows[1:-2] + rows[2:-1]) - rows[:-3] - rows[3:]) / 16
    assert np.max(np.abs(cubic - right)) < 1e-9 * np.max(np.abs(right))
    assert len(json.dumps(rows.tolist())) < 20_000


def test_a_slider_reaches_some_times_its_value():
    slider = explorer._slider("V", 0.5, "m/s", "belt speed", "positive")
    assert 1.5 < slider["high"] < 5 == pytest.approx(0.5 * 0.5 / slider["low"] / slider["high"] * 5)


@pytest.mark.parametrize(("events", "is_whole"), [(25, True), (100, False)])
def test_a_table_of_many_events_is_cut(events, is_whole):
    event = SimpleNamespace(t=1.0, x=0.0, v=0.5, kind=EventKind.SLIPS, begins=Phase.SLIP_BACK)
    motion = SimpleNamespace(
        events=[event] * events, summary="", outcome=SimpleNamespace(value=""), t=[0.0, 1.0], note=""
    )
    said = simulate_command._report(motion, None, [])
    assert ("more events" not in said) == is_whole


def test_a_map_in_letters_fits_a_terminal():
    kinds = [SimpleNamespace(letter="s", name="rest")]
    axis = SimpleNamespace(name="V", values=np.linspace(0.1, 1, 200))
    motions = SimpleNamespace(
        regions=lambda: (np.zeros((200, 200), dtype=int), kinds), x=axis, y=axis, note="", notes={},
        count=dict, reason=np.full((200, 200), Reason.SIMULATED),
    )  # fmt: skip
    picture = [line for line in map_command.report(motions).splitlines() if set(line) == {"s"}]
    assert 30 < len(picture[0]) < TERMINAL_WIDTH
    assert 10 < len(picture) < 40


def test_a_fraction_that_is_short_stays_as_it_was_typed():
    assert arguments._shorten_fraction("981/100") == "981/100"
    assert arguments._shorten_fraction("127/50000000") == "2.54e-06"


@pytest.mark.parametrize(("length", "is_taken"), [(40, True), (120, False)])
def test_a_symbol_is_no_longer_than_a_word_or_two(length, is_taken):
    latex = f"x_{{{'a' * length}}}"
    if is_taken:
        assert notation_of(["x"], {"x": latex})["x"] == latex
    else:
        with pytest.raises(ss.InputError, match="is not one symbol"):
            notation_of(["x"], {"x": latex})


def test_files_of_people_are_no_longer_than_some_megabytes(tmp_path):
    path = tmp_path / "law.json"
    for size, is_read in ((9_000_000, True), (45_000_000, False)):
        with path.open("wb") as file:
            file.truncate(size)
        if is_read:
            assert len(read_bytes(path)) == size
        else:
            with pytest.raises(ss.InputError, match="nothing that is read here is as long"):
                read_bytes(path)


def test_the_motion_of_a_page_is_some_periods_long():
    from stickslip_sym.comparison import study

    osc = ss.Oscillator(m=1, k=100, c=2, V=0.5, N=9.81)
    motion = study._motion(SimpleNamespace(law=ss.laws.linear.typical(), oscillator=osc))
    assert 3 < motion.t[-1] * osc.omega / (2 * math.pi) < 20
