"""Files of pictures need no font of the machine that shows them, and none that journals refuse."""

import re

import pytest

import stickslip_sym as ss

LAW = ss.laws.exponential.typical()


@pytest.fixture(scope="module")
def motion():
    pytest.importorskip("matplotlib")
    return ss.simulate(LAW, ss.Oscillator(m=1, k=100, c=2.3, V=0.5, N=9.81), t_end=2, x0=0)


def test_texts_of_svg_are_paths(motion, tmp_path):
    motion.plot(tmp_path / "motion.svg")
    svg = (tmp_path / "motion.svg").read_text(encoding="utf-8")
    assert "<text" not in svg
    assert "time $t$ (s)" in re.findall(r"<!-- (.*?) -->", svg)  # they can still be searched for


def test_pdf_has_no_font_of_type_3(motion, tmp_path):
    motion.plot(tmp_path / "motion.pdf")
    pdf = (tmp_path / "motion.pdf").read_bytes()
    assert b"/Type3" not in pdf
    assert b"/FontFile2" in pdf  # TrueType, embedded


def test_a_motion_is_drawn_into_axes_of_one_s_own(motion):
    from matplotlib.figure import Figure

    figure = Figure()
    ax = figure.subplots()
    assert motion.plot(ax=ax) is figure
    assert ax.get_xlabel().startswith("time")
    assert len(figure.axes) == 1
