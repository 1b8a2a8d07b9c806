"""One question, asked of every function that answers it: the answers agree, or one says that it does not know.

The laws are of all shapes, the operating points random, eta from 10^-4 to 10^4, and the dampings beside the
threshold as a rule.
"""

import json
import math
import re
from dataclasses import asdict, replace
from html import unescape
from random import Random

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym import Motion
from stickslip_sym.views.pages.explorer import explorer
from support.commands import inside, read_json
from support.exported_code import values_of
from support.random_questions import DAMPINGS, NoAnswer, asked, drawn
from support.sweeps import sample, sweep
from support.web_pages import browse, require_browser

ERRORS = 10.0  # of a threshold, or of a critical value, on either side of which the fate of the slip is asked
RESOLVED = 1e-11, 1e-12  # of a threshold and of sqrt(k m): what its error is taken for at least
BESIDE = 1e-5  # relative, beside a critical value at least
DIGITS = 1e-10  # of N/V times the largest rise of mu, by which averages may differ
SECONDS = 20  # for an answer
AMONG = 21  # cells of a row
KINDS = {"Rest": "rest", "LimitCycle": "pure_slip", "StickSlipCycle": "stick_slip"}
SEEDS = range(400)
ALWAYS = range(16)  # those of the default run
CHEAP = [seed for seed in ALWAYS if seed not in (6, 15)]  # 14 and 7 are of their kinds


def returns(law, osc):
    """Whether the slip from P comes back to the belt's speed; None where that is not said, or not to be seen."""
    peak = asked(ss.peak_velocity, law, osc, rtol=1e-13)
    if isinstance(peak, NoAnswer):
        return {"creeps to rest": False, "falls for ever": True}.get(peak.ending)
    if peak == osc.V:
        return None  # it is the belt's speed but for rounding
    return peak > osc.V


def scene(seed):
    """Return a law, an oscillator with its damping, and its threshold or why there is none."""
    law, osc = drawn(seed)
    point = {name: getattr(osc, name) for name in "VNmk"}
    found = asked(ss.pure_slip_damping, law, **point, method="simulation", rtol=1e-9, time_limit=SECONDS)
    size = 0.1 * osc.N / osc.V if isinstance(found, NoAnswer) else found.value
    return law, replace(osc, c=size * Random(seed).choice(DAMPINGS)), found


@sample(6)
@sweep("seed", SEEDS, *ALWAYS)
def test_on_either_side_of_a_threshold_the_slip_has_another_fate(seed):
    law, osc, found = scene(seed)
    if isinstance(found, NoAnswer):
        return
    off = ERRORS * max(found.error, RESOLVED[0] * abs(found.value), RESOLVED[1] * osc.impedance)
    fates = [returns(law, replace(osc, c=found.value + side * off)) for side in (-1, 1)]
    assert None in fates or fates == [True, False]


@sample(7)
@sweep("seed", SEEDS, *CHEAP)
def test_what_the_mass_does(seed):
    """Regime, stick-slip cycle, limit cycles, the classification of P, a cell alone and among others."""
    law, osc, _ = scene(seed)
    cycle = asked(ss.stick_slip_cycle, law, osc, time_limit=SECONDS)
    motions = asked(ss.regime, law, osc, time_limit=SECONDS)
    begins = {"P": osc.onset(law), "0": 0.0}
    leads = {name: asked(ss.classify, law, osc, x0=x, time_limit=SECONDS) for name, x in begins.items()}
    cells = {count: cell(law, osc, count) for count in (1, AMONG)}
    decided = [found for found in cells.values() if not isinstance(found, NoAnswer)]
    assert len({str(found) for found in decided}) <= 1, decided
    if not isinstance(cycle, NoAnswer) and not is_open(leads["P"]):
        assert (cycle is not None) == (leads["P"] is Motion.STICK_SLIP)
    for motion, _ in decided:
        assert is_open(leads["0"]) or leads["0"] is motion
    if isinstance(motions, NoAnswer) or motions.undecided:
        return
    attractors = {KINDS[type(one).__name__] for one in motions.attractors}
    for _, found in decided:
        assert found == attractors
    assert attractors or motions.unbounded
    assert isinstance(cycle, NoAnswer) or (cycle is not None) == ("stick_slip" in attractors)
    slips = asked(ss.limit_cycles, law, osc, time_limit=SECONDS)
    assert isinstance(slips, NoAnswer) or slips == motions.slip_cycles or not motions.slip_cycles


def is_open(motion):
    return isinstance(motion, NoAnswer) or motion is Motion.UNDECIDED


def cell(law, osc, count):
    """What a map says of the oscillator, among so many that differ in c: the motion, and the attractors."""
    span = 0.5 * max(abs(osc.c), 1e-3 * osc.impedance)
    values = [osc.c] if count == 1 else osc.c + span * np.linspace(-1, 1, count)
    point = {"N": osc.N, "m": osc.m, "k": osc.k}
    found = asked(ss.motion_map, law, x=("V", [osc.V]), y=("c", values), **point, time_limit=SECONDS)
    if isinstance(found, NoAnswer):
        return found
    row = count // 2
    if found.motion[row, 0] is Motion.UNDECIDED:
        return NoAnswer(found.notes.get((row, 0), ""))
    return found.motion[row, 0], {name for name, exists in found.attractors.items() if exists[row, 0]}


@sample(2)
@sweep("seed", SEEDS, 0, 9)
def test_how_far_it_is_to_another_motion(seed):
    """Margins and the stick-slip cycle; the slip on either side of every critical value."""
    law, osc, _ = scene(seed)
    options = {"samples": 0, "method": "simulation", "time_limit": 3 * SECONDS}
    found = asked(ss.margins, law, osc, reach=1.3, each=3.0, **options)
    if isinstance(found, NoAnswer):
        return
    cycle = asked(ss.stick_slip_cycle, law, osc, time_limit=SECONDS)
    near = abs(osc.c - found.threshold.value) <= ERRORS * (found.threshold.error or 0.0)
    assert near or isinstance(cycle, NoAnswer) or found.stick_slip == (cycle is not None)
    for row in found.rows:
        for end in (row.below, row.above) if row.name != "c" else ():
            if end is not None:
                off = max(BESIDE, ERRORS * (end.relative_error or 0.0))
                fates = [changed(law, osc, row.name, end.value * (1 + side * off)) for side in (-1, 1)]
                assert None in fates or fates[0] != fates[1], (row.name, end)


def changed(law, osc, name, value):
    """Whether the slip returns with another value of a quantity or of a parameter."""
    if name in law.parameters:
        law = asked(law.bind, **{name: value})
        return None if isinstance(law, NoAnswer) else returns(law, osc)
    return returns(law, ss.Oscillator(**asdict(osc) | {name: value}))


AVERAGES = [(seed, criterion) for seed in SEEDS for criterion in ("harmonic", "least_squares")]


@sample(2)
@sweep(("seed", "criterion"), AVERAGES, (0, "harmonic"), (1, "least_squares"),
       (3, "least_squares"), (6, "harmonic"))  # fmt: skip
def test_what_an_average_is(seed, criterion):
    """Form, call, digits, enclosure, quadrature, and the command in text and JSON."""
    law, osc = drawn(seed)
    point = {"V": osc.V, "N": osc.N}
    values = {"quadrature": asked(ss.quadrature.damping, law, criterion, **point)}
    form = asked(ss.derive, law, criterion, search=False)
    if not isinstance(form, NoAnswer):
        values |= {"call": asked(form, **point), "digits": asked(form.evaluate, 20, **point)}
    average = asked(ss.slope_average, law, criterion)
    if not isinstance(average, NoAnswer):
        values["average"] = asked(average, **point)
        code = asked(ss.export_code, average, "python")
        if not isinstance(code, NoAnswer):
            names = re.search(r"def damping\((.*)\)", code)[1].split(", ")  # without exponents that it is made for
            numbers = tuple((point | law.values)[name] for name in names)
            (value,) = values_of("python", code, [("damping", numbers)], None)
            values["code"] = NoAnswer("NaN") if math.isnan(value) else value
    values["enclosure"] = asked(ss.enclose, law, criterion, **point)
    known = {name: float(value) for name, value in values.items() if not isinstance(value, NoAnswer)}
    v = np.linspace(0, 2 * osc.V, 200)
    rise = max(abs(float(law.mu(x)) - law.onset) for x in v.tolist())
    assert max(known.values()) - min(known.values()) <= DIGITS * osc.N / osc.V * rise, known


LINEAR = ss.laws.linear.typical(), ss.Oscillator(m=1, k=100, c=2, V=0.5, N=9.81)  # a study of little work


@sweep("seed", [None, *SEEDS], None)
def test_what_a_study_says(seed):
    """Its first sentence, and the stick-slip cycle; never that nothing attracts where motions lose energy."""
    law, osc = LINEAR if seed is None else scene(seed)[:2]
    cycle = asked(ss.stick_slip_cycle, law, osc, time_limit=SECONDS)
    found = ss.study(law, osc, time_limit=3)
    text = str(found)
    if not isinstance(cycle, NoAnswer):
        assert cycle is None or "There is no stick-slip" not in found.headline
        assert cycle is not None or not re.search("There is stick-slip|Stick-slip is possible", found.headline)
    assert "no attractor" not in text.lower() or osc.c <= 0 or "without bound" in text


PAGES = (0,)  # seeds whose pages are looked at always: one start of the browser for all
MORE_PAGES = range(4, 84, 8)


@pytest.mark.parametrize("seeds", [PAGES, pytest.param(MORE_PAGES, marks=pytest.mark.thorough)])
def test_what_the_page_with_sliders_says(seeds, tmp_path):
    """The threshold, computed in the browser."""
    require_browser(tmp_path)
    scripts, values = [], []
    for seed in seeds:
        law, osc, found = scene(seed)
        page = asked(explorer, law, osc, time_limit=SECONDS)
        if isinstance(found, NoAnswer) or isinstance(page, NoAnswer):
            continue
        script = re.search(r"<script>(.*)</script>", page, re.DOTALL)[1].split("/* The page's own part")[0]
        point = json.dumps({name: getattr(osc, name) for name in "VNmk"})
        own = json.dumps([float(value) for value in law.values.values()])
        scripts.append(
            f"<script>(function () {{ {script}; said.push(threshold({point}, {own}, 0)); }})();</script>"
        )
        values.append(found)
    last = "<script>document.body.textContent = 'SAID' + JSON.stringify(said) + 'END';</script>"
    page = ["<body><script>const said = [];</script>", *scripts, last, "</body>"]
    (tmp_path / "all.html").write_text("".join(page), encoding="utf-8")
    shown = unescape(browse((tmp_path / "all.html").as_uri(), tmp_path).stdout)
    said = json.loads(re.search("SAID(.*)END</body>", shown, re.DOTALL)[1])
    assert len(said) == len(values) > 0
    for answer, found in zip(said, values, strict=True):
        off = found.error + 1e-6 * abs(found.value) + 1e-8 * found.points.slope_scale[0]
        assert answer is None or abs(answer["value"] - found.value) <= off


@sweep("seed", range(0, 400, 8), 16)
def test_a_map_by_the_command_line(seed):
    """The same cells in Python and in JSON."""
    law, osc, _ = scene(seed)
    given = [word for name in "Nmk" for word in (f"-{name}", repr(getattr(osc, name)))]
    given += [word for name, value in law.values.items() for word in ("-p", f"{name}={float(value)!r}")]
    axes = ["--x", f"V={osc.V!r}:{osc.V!r}:1", "--y", f"c={0.5 * osc.c!r}:{1.5 * osc.c!r}:3"]
    done = inside("map", law.name, *given, *axes, "--json")
    cells = read_json(done.stdout)["map"]
    point = {name: getattr(osc, name) for name in "Nmk"}
    found = ss.motion_map(law, x=("V", [osc.V]), y=("c", np.linspace(0.5 * osc.c, 1.5 * osc.c, 3)), **point)
    assert cells["motion"] == [[motion.value for motion in row] for row in found.motion.tolist()]


def test_python_the_command_and_json():
    """One question in three ways: the threshold, and what the map says."""
    law, point = ss.laws.exponential.typical(), {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}
    value = ss.pure_slip_damping(law, **point, method="simulation").value
    given = "damping", "exponential", "-V", "0.5", "-N", "9.81", "-m", "1", "-k", "100", "--method", "simulation"
    assert f"{value:.9g}"[:8] in inside(*given).stdout
    (found,) = [one for one in numbers(read_json(inside(*given, "--json").stdout)) if math.isclose(one, value)]
    assert found == value


def numbers(data):
    """Every number in data that was read from JSON."""
    if isinstance(data, dict):
        data = list(data.values())
    if isinstance(data, list):
        return {number for part in data for number in numbers(part)}
    return {data} if isinstance(data, float) else set()
