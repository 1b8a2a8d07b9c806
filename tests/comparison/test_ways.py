"""Which ways are dominated, over random ways; and what text, JSON and picture say of them is what was measured."""

import json
import math
import re

import numpy as np
import pytest

from stickslip_sym.cli.output import as_json
from stickslip_sym.comparison import tradeoff_picture
from stickslip_sym.comparison.basin_tradeoff import ShareWay
from stickslip_sym.comparison.threshold_tradeoff import ThresholdWay
from stickslip_sym.comparison.ways import Trade, Way, dominators

SIZES = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}


def random_ways(rng, count):
    """Return ways of few different times and errors, so that some are equal, and some without a number."""
    kind = rng.choice([Way, ThresholdWay, ShareWay])
    found = []
    for number in range(count):
        name = f"{rng.choice(['stable', 'plain', 'mpmath'])}, {number}"
        if rng.random() < 0.1:
            found.append(kind(name))
            continue
        seconds, error = 10.0 ** rng.integers(-8, 2), float(rng.choice([0.0, 1e-16, 2.5e-9, 1e-3, 0.2]))
        further = {"status": "PROVED"} if kind is ThresholdWay else {"share": 0.25} if kind is ShareWay else {}
        found.append(kind(name, float(seconds), error, **further))
    return tuple(found)


def is_dominated(way, other):
    """By the definition in words."""
    if math.isnan(way.seconds) or math.isnan(other.seconds):
        return False
    if other.seconds > way.seconds or other.error > way.error:
        return False
    return (other.seconds, other.error) != (way.seconds, way.error)


@pytest.mark.parametrize("seed", range(30))
def test_what_is_dominated_is_dominated_by_a_way_that_is_not(seed):
    rng = np.random.default_rng(seed)
    ways = random_ways(rng, int(rng.integers(1, 14)))
    by = dominators(ways)
    assert list(by) == [way.name for way in ways]
    at_all = {way.name: {other.name for other in ways if is_dominated(way, other)} for way in ways}
    front = {name for name, others in at_all.items() if not others}
    for way in ways:
        assert set(by[way.name]) == at_all[way.name] & front
        assert bool(by[way.name]) == bool(at_all[way.name])
    # The fastest and the most accurate are dominated by none; one more, worse in both, changes nothing.
    found = [way for way in ways if way.found]
    if found:
        worst = Way("worst", 2 * max(way.seconds for way in found), 1 + max(way.error for way in found))
        more = dominators([*ways, worst])
        assert more.pop("worst")
        assert more == by
        for best in (Way("best", 1e-10, 5.0), Way("best", 1e3, -1.0)):
            assert dominators([*ways, best])["best"] == ()


@pytest.mark.parametrize("seed", range(4))
def test_text_json_and_picture_say_what_was_measured(seed, monkeypatch):
    """Read back from each; exchanged times and errors would be noticed, since they are of other sizes."""
    rng = np.random.default_rng(seed)
    ways = random_ways(rng, 9)
    trade = Trade("value", "of some kind", ways, {"V": 0.5})
    by_text = {cells[0]: cells for cells in (re.split(r" {2,}", line) for line in str(trade).splitlines()[3:])}
    content = json.loads(json.dumps(as_json(trade), allow_nan=False))
    by_json = {way["name"]: way for way in content["ways"]}
    for way in ways:
        cells, said = by_text[way.name], by_json[way.name]
        if not way.found:
            assert cells[1] == "no number"
            assert (said["seconds"], said["error"], content["dominators"][way.name]) == (None, None, [])
            continue
        number, unit = cells[1].split()
        assert float(number) * SIZES[unit] == pytest.approx(way.seconds, rel=5e-3)
        assert float(cells[2]) == pytest.approx(way.error, rel=0.05)
        assert (said["seconds"], said["error"]) == (way.seconds, way.error)
        assert tuple(content["dominators"][way.name]) == trade.dominators[way.name]
        last = cells[-1].split("; ") if trade.dominators[way.name] else []
        assert tuple(last) == trade.dominators[way.name]
    pytest.importorskip("matplotlib")
    (axes,) = tradeoff_picture.draw([trade]).axes
    drawn = sorted(
        (float(line.get_xdata()[0]), float(line.get_ydata()[0]), line.get_markerfacecolor() == "white")
        for line in axes.lines if line.get_marker() == "o"
    )  # fmt: skip
    expected = [
        (way.seconds, max(way.error, 1e-51), bool(trade.dominators[way.name])) for way in ways if way.found
    ]
    assert drawn == sorted(expected)
