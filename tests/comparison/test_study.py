"""The study of an operating point: what stands on its page is what the functions return."""

import re
from collections import Counter
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from uncertainties import ufloat

import stickslip_sym as ss
from stickslip_sym.comparison import study as study_module
from stickslip_sym.model.measured.measurements import Measurements
from stickslip_sym.motion.margins import critical
from stickslip_sym.motion.thresholds import methods
from stickslip_sym.motion.thresholds.methods import evaluate
from stickslip_sym.motion.thresholds.threshold import Threshold
from stickslip_sym.views.pages import browser, study_page
from support.sweeps import sample
from support.web_pages import XHTML, check_well_formed, look_at

OSC = ss.Oscillator(m=1, k=100, c=2, V=0.5, N=9.81)
PARTS = ["headline", "verdict", "thresholds", "law", "sensitivities", "margins", "formulas", "assumed", "versions"]
FIGURES = ["figure-law", "figure-plane", "figure-time", "figure-phase"]
EVIL = "</style><script>alert(1)</script>\"'&<b onload=x>$\\frac{$\x00\x1b\udcff"


@cache
def point(seed):
    """A seeded law with errors, its oscillator and their errors."""
    mu_m, rise, v_m, m, k, c, V, N = np.random.default_rng(seed).uniform(
        [0.1, 0.15, 1.0, 0.5, 50, 1, 0.3, 5], [0.25, 0.3, 1.4, 2, 200, 4, 0.6, 12]
    ).round(3)  # fmt: skip
    law = ss.laws.polynomial.bind(mu_s=f"{mu_m + rise:.3f}+/-0.01", mu_m=f"{mu_m:.3f}", v_m=f"{v_m:.3f}+/-0.03")
    return law, ss.Oscillator(m=m, k=k, c=c, V=V, N=N), {"N": f"{N}+/-0.1"}


@cache
def studied(seed):
    law, osc, errors = point(seed)
    return ss.study(law, osc, errors=errors, time_limit=300)  # a slow machine finds the same


def drawn_without(study, monkeypatch):
    """The page of a study without its figures, which take a second."""
    monkeypatch.setattr(study_page, "pictures", lambda study: [])
    return replace(study).page


def numbers_on(root):
    """The numbers of a page by the row or place that they stand in, to their last digit."""
    rows = {}
    for node in root.iter():
        id = node.get("id")
        parent = next((row for row in root.iter("tr") if node in list(row)), node) if id else None
        if parent is not None:
            rows[id] = [float(data.get("value")) for data in parent.iter("data")]
    return rows


@cache
def expected(seed):
    """What the functions return at an operating point, by the same places."""
    law, osc, errors = point(seed)
    given = {name: getattr(osc, name) for name in "VNmk"}
    found = {}
    for method in ("equilibrium", "least_squares", "harmonic", "second_order", "orbit", "simulation", "proof"):
        one = ss.pure_slip_damping(law, **given, method=method, rtol=1e-10)
        found[f"threshold-{method}"] = [one.value, one.relative_error]
    exact = ss.pure_slip_damping(law, **given | errors, method="orbit", rtol=1e-10)
    budget = exact.budget
    values = given | {name: float(value) for name, value in law.values.items()}
    for name, slope in exact.sensitivity.items():
        carries = name in budget.names
        found[f"sensitivity-{name}"] = [
            values[name], *([budget.deviations[name]] if carries else []), slope,
            slope * values[name] / exact.value, *([budget.alone[name], budget.shares[name]] if carries else []),
        ]  # fmt: skip
    margins = ss.margins(law, osc, errors=errors, rtol=1e-6, reach=3, samples=200)
    for row in margins.rows:
        ends = [one.value for one in (row.below, row.above) if one is not None]
        deviation = budget.deviations.get(row.name)
        away = [row.change * row.value / deviation] if ends and deviation else []
        found[f"margin-{row.name}"] = [row.value, *ends, *([row.change] if ends else []), *away]
    sampled = margins.sampled
    found["threshold"], found["probability"] = [exact.value, budget.uncertainty], [sampled.probability]
    found["probabilities"] = [margins.probability, sampled.probability, sampled.standard_error]
    return found


def check(root, seed):
    there = numbers_on(root)
    for place, numbers in expected(seed).items():
        assert there[place] == pytest.approx(numbers, rel=1e-9, abs=1e-300), place


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.thorough)])
def test_the_page_has_the_numbers_of_functions(seed, monkeypatch):
    page = drawn_without(studied(seed), monkeypatch)
    root = check_well_formed(page)
    check(root, seed)
    for data in root.iter("data"):  # what is shown is what is stated, to the digits shown
        shown, value = "".join(data.itertext()).replace("−", "-").replace("·10", "e"), float(data.get("value"))
        scale = 0.01 if "%" in shown else 1.0
        number = float(shown.removeprefix("< ").removesuffix(" %")) * scale
        assert value < number if shown.startswith("<") else number == pytest.approx(value, rel=0.06, abs=6e-4)
    (threshold,) = (node for node in root.iter() if node.get("id") == "threshold")
    error = "".join(list(threshold.iter("data"))[1].itertext())
    assert len(error.replace(".", "").lstrip("0")) == 2  # both to two digits of the error
    below = studied(seed).oscillator.c < studied(seed).threshold.value
    assert ("As things are c is below it" in page) == below


def test_swapped_values_are_noticed(monkeypatch):
    """The agreement above would be worth nothing if numbers of other rows passed."""
    root = check_well_formed(drawn_without(studied(0), monkeypatch))
    ids = {row.find("th").get("id"): row for row in root.iter("tr")}
    rows = {id: list(row.iter("data")) for id, row in ids.items() if id}
    for one, other in (
        ("threshold-orbit", "threshold-harmonic"), ("sensitivity-V", "sensitivity-N"), ("margin-N", "margin-c"),
    ):  # fmt: skip
        for left, right in zip(rows[one][-2:], rows[other][-2:], strict=True):
            before = left.get("value"), right.get("value")
            left.set("value", before[1]), right.set("value", before[0])
            with pytest.raises(AssertionError):
                check(root, 0)
            left.set("value", before[0]), right.set("value", before[1])
    check(root, 0)


def test_the_page_prints_on_two_sheets(tmp_path):
    pytest.importorskip("matplotlib")
    study = studied(0)
    path = study.save(tmp_path / "study.html")
    page = path.read_text(encoding="utf-8")
    root = check_well_formed(page)
    by_id = {node.get("id"): node for node in root.iter() if node.get("id")}
    assert set(PARTS + FIGURES) <= set(by_id)
    assert len(page) < 600_000
    for figure in FIGURES:
        assert len(by_id[figure].find("img").get("alt")) > 50
    for formula in ("law", "equilibrium", "least_squares", "harmonic"):
        assert by_id[f"formula-{formula}"].find(".//m:math", XHTML) is not None
    formulas = "".join(by_id["formulas"].itertext())
    assert formulas.count("PROVED") == 3
    assert "μ(v)=" in formulas
    assert f"stickslip_sym {ss.__version__}" in "".join(by_id["versions"].itertext())
    assert str(study).splitlines()[0] == study.headline
    assert "".join(by_id["headline"].itertext()) == study.headline
    assert [len(probe["pictures"]) for probe in look_at(page, tmp_path)] == [4, 4]
    content = study.print(tmp_path / "study.pdf").read_bytes()
    assert content.startswith(b"%PDF")
    assert len(re.findall(rb"/Type\s*/Page\b", content)) == 2


@pytest.mark.thorough
@pytest.mark.parametrize("font", ["", "DejaVu Sans"])
def test_a_long_study_prints_on_two_sheets(font, tmp_path):
    """Every value uncertain, a law of many parameters with long meanings, and wider letters."""
    pytest.importorskip("matplotlib")
    law = ss.FrictionLaw(
        "mu_k + (mu_s - mu_k)*exp(-(v/v_s)^delta) + mu_v*v + mu_w*v^2",
        name="lining on cast iron, worn and wet",
        units={"mu_v": "s/m", "mu_w": "s^2/m^2", "v_s": "m/s"},
        source="bench 4, " + 8 * "a long report, ",
    ).bind(mu_k="0.20(1)", mu_s="0.50(2)", v_s="0.30(3)", delta="1.50(5)", mu_v="0.010(1)", mu_w="0.0010(2)")
    errors = {"V": "0.50(1)", "N": "9.81(10)", "m": "1.00(1)", "k": "100.0(5)", "c": "2.00(5)"}
    study = ss.study(law, OSC, errors=errors, time_limit=300)
    wider = f"<style>body {{ font-family: '{font}' }}</style></head>" if font else "</head>"
    page = study.page.replace("</head>", wider)
    browser.print_to_pdf(page, tmp_path / "long.pdf", sheets=2)
    assert len(re.findall(rb"/Type\s*/Page\b", (tmp_path / "long.pdf").read_bytes())) == 2


def test_what_users_write_stays_text(monkeypatch):
    """Names, sources, meanings, notes and headers of files, with markup, TeX, controls and half a character."""
    measured = Measurements.of([0.01, 0.5, 1.0], [0.5, 0.4, 0.3])
    object.__setattr__(measured, "understood", EVIL)
    described = [ss.Parameter("a", EVIL, "1", "0.5"), ss.Parameter("b", EVIL, "s/m", "0.1")]
    law = ss.FrictionLaw("a - b*v", name=EVIL, source=EVIL, validity=EVIL, parameters=described).typical()
    parts = []
    study = ss.study(law, OSC, measured=measured, name=EVIL, defaults=[EVIL], progress=parts.append)
    assert parts[0] == "thresholds by every method"
    assert {"plane of c over V", "margins"} <= set(parts)
    root = check_well_formed(study.page)
    shown = EVIL.replace("\x00", "\ufffd").replace("\x1b", "\ufffd").replace("\udcff", "\ufffd")
    text = "".join(root.itertext())
    assert text.count(shown) >= 7
    assert not list(root.iter("script"))
    assert not any(name.startswith("on") for node in root.iter() for name in node.attrib)


def measured_line(seed, *, count=60, high=1.2, noise=0.004):
    """Speeds, and coefficients that fall with a little noise."""
    v = np.linspace(0.01, high, count)
    return v, 0.5 - 0.2 * v + 0.05 * v**2 + noise * np.random.default_rng(seed).normal(size=count)


def test_a_fit_brings_its_covariance_and_its_points(monkeypatch):
    fits = ss.fit(*measured_line(5), laws=["a - b*v + d*v^2"])
    study = ss.study(fits, ss.Oscillator(m=1, k=100, c=1.2, V=0.5, N=9.81), time_limit=300)
    assert (study.fit, study.measured) == (fits.best, fits.measured)
    *pair, correlation = study.threshold.budget.correlated[0]
    i, j = (list(fits.best.values).index(name) for name in pair)
    covariance = fits.best.covariance
    assert correlation == pytest.approx(covariance[i, j] / (covariance[i, i] * covariance[j, j]) ** 0.5)
    page = drawn_without(study, monkeypatch)
    assert "It was fitted to 60 rows from 0.01 to 1.2 m/s" in page
    assert "Correlated are " in page


def test_choice_of_law_and_extrapolation_are_said(monkeypatch):
    """For laws that fit alike, at a speed beyond the measured ones."""
    laws = ["a - b*v", "a - b*v^2", "a - b*sqrt(v)"]
    fits = ss.fit(*measured_line(5, count=20, high=0.9, noise=0.02), laws=laws)
    osc = ss.Oscillator(m=1, k=100, c=1.6, V=0.5, N=9.81)
    with pytest.warns(ss.InputWarning, match="extrapolated above 0.9 m/s"):
        study = ss.study(fits, osc, errors={"c": "1.6(1)"}, time_limit=300)
    assert len(study.choice.rows) > 1
    first, bound = study.choice.rows[0], fits.best.law.bind(**fits.best.uncertain)
    alone = ss.pure_slip_damping(bound, V=0.5, N=9.81, m=1, k=100, method="simulation", rtol=1e-7)
    assert (first.weight, first.value) == (fits.best.weight, pytest.approx(alone.value, rel=2e-4))
    shares = np.array([fit.weight for fit in fits.likely])
    rows = 20 / min(fits, key=lambda fit: fit.chi_squared).inflation - 2  # less the parameters
    noise = shares @ [fit.chi_squared / rows for fit in fits.likely] / shares.sum()  # one for all laws
    wider = (noise / fits.best.variance) ** 0.5
    assert first.standard_error == pytest.approx(wider * alone.budget.uncertainty, rel=1e-3)
    value, error = study.needed
    assert error > study.threshold.budget.uncertainty
    draws = np.random.default_rng(1)
    rows = [(row.weight, row.value, row.standard_error) for row in study.choice.rows]
    weights, values, errors = np.array(rows).T
    which = draws.choice(len(values), 200_000, p=weights / weights.sum())
    normal = draws.normal(values[which], errors[which])
    assert (value, error) == (pytest.approx(normal.mean(), rel=0.01), pytest.approx(normal.std(), rel=0.02))
    samples = values[which] + errors[which] * draws.standard_t(study.choice.dof, 200_000)
    unmeasured = np.array([row.unmeasured for row in study.choice.rows])[which]
    builds_up = draws.random(200_000) < 0.03  # below the lowest speed, by any share of what hangs on that
    missing = np.where(builds_up, draws.random(200_000) * unmeasured, 0.0)
    above = samples - missing > draws.normal(1.6, 0.1, 200_000)
    assert study.probability == pytest.approx(np.mean(above), abs=0.005)
    low, high = np.quantile(samples, [0.025, 0.975])
    reached = max(low - study.choice.unmeasured, 0.0), high
    assert study.decision.range == pytest.approx(reached, abs=0.03 * (high - low))
    page = drawn_without(study, monkeypatch)
    root = check_well_formed(page)
    shown = numbers_on(root)
    assert shown["threshold"] == [pytest.approx(value), pytest.approx(error)]
    for i, row in enumerate(rows):
        assert shown[f"choice-{i}"] == pytest.approx(row)
    said = "extrapolated above 0.9 m/s: thresholds take friction from 0 to 2 V = 1 m/s"
    assert study.warnings[0].startswith(said)
    assert str(study).splitlines()[0] == f"warning: {study.warnings[0]}"
    assert said in "".join(next(node for node in root.iter() if node.get("id") == "warnings").itertext())
    assert page.index('id="warnings"') < page.index('id="threshold"')


@pytest.mark.parametrize(
    ("c", "headline"),
    [
        (1.0, "Motions far out grow without bound, and others come to stick-slip: c = 1 kg/s is 32 % below"),
        (4.0, "There is no stick-slip: c = 4 kg/s is 172 % above the threshold of 1.472 kg/s."),
    ],
)
def test_the_headline_is_a_decision(c, headline):
    study = ss.study(ss.laws.linear.typical(), ss.Oscillator(m=1, k=100, c=c, V=0.5, N=9.81), defaults=["m"])
    assert study.headline.startswith(headline)
    assert "m = 1 kg (default)" in str(study)
    assert repr(study) == f"Study: {study.headline}"
    sure = ss.study(ss.laws.linear.typical(), study.oscillator, errors={"N": "9.81(1)"}).headline
    assert f"P {'> 0.999' if c < 1.4715 else '< 0.001'} that c is below it" in sure


DECISIONS = [
    ("exponential", {"c": -5}, "sticks", "Every motion grows without bound: c = -5 kg/s is"),
    ("exponential", {"c": -0.5}, "sticks", "Motions far out grow without bound, and others come to stick-slip: c"),
    ("exponential", {"c": 0, "N": 0.05}, "sticks", "There is no stick-slip, but slip that overtakes the belt: c"),
    ("popp_stelter", {"c": -1, "V": 0.1, "N": 2}, "either", "Stick-slip is possible, depending on the initial "),
    ("exponential", {"c": 1}, "sticks", "There is stick-slip from every initial condition: c = "),
    ("exponential", {"c": 2.3}, "either", "Stick-slip is possible, depending on the initial condition: c = "),
    ("exponential", {"c": 3}, "rests", "There is no stick-slip: c = 3 kg/s is 17 % above"),
]  # fmt: skip


@sample(4)
@pytest.mark.parametrize(("name", "changes", "state", "headline"), DECISIONS)
def test_a_page_says_one_thing(name, changes, state, headline, monkeypatch):
    """What the attractors of a regime are is what the headline, its colour, verdict, notes and captions say."""
    law, osc = ss.laws.catalogue[name].typical(), replace(OSC, **changes)
    found = ss.regime(law, osc)
    limits = ss.margins(law, osc, reach=1.01, samples=0)
    threshold = ss.pure_slip_damping(law, V=osc.V, N=osc.N, m=osc.m, k=osc.k, method="orbit")
    whole = {"oscillator": osc, "regime": found, "margins": limits, "threshold": threshold, "errors": {}}
    study = replace(studied(0), law=law, sensitivity=None, nonlinearity=None, **whole)
    assert study.headline.startswith(headline)
    root = check_well_formed(drawn_without(study, monkeypatch))
    by_id = {node.get("id"): node for node in root.iter() if node.get("id")}
    assert by_id["headline"].get("class") == f"state {state}"
    text = " ".join("".join(root.itertext()).split())
    sticks = found.stick_slip is not None
    assert ("so stick–slip is possible" in text) == sticks
    assert ("There is no stick-slip" in text) == (not sticks and not found.unbounded)
    assert ("without bound" in study.verdict) == ("without bound" in study.headline) == found.unbounded
    captions = study_page.remarks(study)
    assert ("phase" in captions) == bool(found.separatrices or not all(cycle.stable for cycle in found.cycles))


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"law": ss.laws.polynomial}, "has no value for mu_s, mu_m, v_m"),
        ({"errors": {"alpha": "3(1)"}}, "it takes V, N, m, k and c"),
        ({"errors": {"N": "9.0(1)"}}, "give the same value"),
        ({"errors": {"N": "9.81+/-x"}}, "not a number with a standard error"),
        ({"time_limit": -1}, "time_limit = -1"),
        ({"errors": 3}, "errors is a mapping such as"),
        ({"measured": 3}, "measured is what read_measurements gives, got int: 3"),
        ({"name": 3}, "name is text, got int: 3"),
        ({"defaults": 4}, "defaults is an iterable of names, got int: 4"),
    ],
)
def test_what_cannot_be_studied_is_refused(change, reason):
    with pytest.raises(ss.InputError, match=re.escape(reason)):
        ss.study(**{"law": ss.laws.polynomial.typical(), "osc": OSC} | change)


def test_parts_that_take_too_long_are_named(monkeypatch):
    law, osc, _ = point(1)
    study = ss.study(law, osc, time_limit=0)
    assert study.threshold is None
    assert set(study.refused) >= {"margins", "plane of c over V"}
    page = drawn_without(study, monkeypatch)
    text = "".join(check_well_formed(page).itertext())
    assert "The margins could not be computed: the time limit was reached" in text
    assert "There is no threshold here" in text


def test_second_order_without_time_is_named(monkeypatch):
    def late(_):
        raise ss.OutOfTime("the time limit was reached")

    whole = studied(0)
    monkeypatch.setattr(Threshold, "nonlinearity", property(late))
    monkeypatch.setattr("stickslip_sym.comparison.study.margins_of", lambda *_, **__: whole.margins)
    law, osc, errors = point(0)
    study = ss.study(law, osc, errors=errors, time_limit=300)
    why = "The second order of its standard error could not be computed: the time limit was reached."
    assert why in study.findings
    assert study.needed[1] == whole.needed[1]
    text = "".join(check_well_formed(drawn_without(study, monkeypatch)).itertext())
    assert "To second order it could not be computed." in text


def test_no_threshold_is_computed_twice(monkeypatch):
    asked = Counter()

    def counted(points, method, rtol, **more):
        if method is not None:
            values = tuple(sorted(points.law.values.items()))
            for row in zip(*(column.tolist() for column in points.columns.values()), strict=True):
                asked[method.name, values, *row] += 1
        return evaluate(points, method, rtol, **more)

    for module in (methods, critical):
        monkeypatch.setattr(module, "evaluate", counted)
    ss.study(ss.laws.linear.typical(), OSC)
    assert sum(asked.values()) > 10
    assert set(asked.values()) == {1}
    ss.compare(ss.laws.linear.typical(), OSC)  # a control
    assert 2 in asked.values()


def test_the_probability_of_a_study_is_from_some_hundred_samples():
    """As many as its standard error, and the steps of their share, say."""
    osc = ss.Oscillator(m=1, k=100, c=1.47, V=0.5, N=9.81)
    subject = SimpleNamespace(
        law=ss.laws.linear.typical(), oscillator=osc, carried={"N": ufloat(9.81, 0.1)}, fits=None, threshold=None,
        each=5.0,
    )  # fmt: skip
    sampled = study_module._margins(subject).sampled
    count = sampled.probability * (1 - sampled.probability) / sampled.standard_error**2
    assert 100 < count < 400
