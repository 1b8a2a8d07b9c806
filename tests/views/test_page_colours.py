"""Colours of pages: every text can be read on the paper, by day and by night."""

import re
from pathlib import Path

import pytest

from stickslip_sym.views.pages import render

LEAST = 4.5
"""Contrast of text that WCAG 2.2 asks for (level AA)."""
TEXTS = "ink", "faint", "good", "part", "bad"


def luminance(colour):
    """Return the relative luminance of a colour such as #fff, by the definition of WCAG."""
    digits = colour[1:] if len(colour) == 7 else "".join(2 * digit for digit in colour[1:])
    parts = [int(digits[i : i + 2], 16) / 255 for i in (0, 2, 4)]
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one, other):
    """Return the contrast of two colours, from 1 to 21."""
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def test_the_contrast_of_known_colours():
    assert contrast("#000", "#ffffff") == pytest.approx(21)
    assert contrast("#777", "#fff") == pytest.approx(4.478, abs=1e-3)  # an example of WebAIM's


def test_every_text_can_be_read_by_day_and_by_night():
    style = Path(render.__file__).with_name("page.css").read_text(encoding="utf-8")
    themes = [dict(re.findall(r"--(\w+): (#\w+)", block)) for block in re.findall(r":root \{(.*?)\}", style, re.S)]
    assert len(themes) == 2
    for theme in themes:
        papers = theme["paper"], theme["mark"]
        assert {name: contrast(theme[name], paper) for name in TEXTS for paper in papers
                if contrast(theme[name], paper) < LEAST} == {}  # fmt: skip
    day, night = themes
    assert luminance(day["paper"]) > 0.9 > 0.05 > luminance(night["paper"])
    assert "#" not in re.sub(r"--\w+: #\w+|#fff", "", re.sub(r"/\*.*?\*/", "", style)), "a colour without a name"
