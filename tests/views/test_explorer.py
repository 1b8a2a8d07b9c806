"""The explorer, moved in a real browser: what it shows is what Python computes there."""

import json
import math
import re
import shutil
import subprocess
from html import unescape

import numpy as np
import pytest
from uncertainties import ufloat

import stickslip_sym as ss
from stickslip_sym.views.pages.explorer import explorer
from support.sweeps import sample, sweep
from support.web_pages import require_browser, sent_by

POINT = {"V": 0.5, "N": 9.81, "m": 1, "k": 100}
_MOVED = """<script>
const moved = %s;
for (const name in moved) {
  const bar = document.getElementById("slider-" + name);
  bar.value = moved[name];
  bar.dispatchEvent(new Event("input"));
}
const written = %s;
for (const name in written) {
  const box = document.getElementById("value-" + name);
  box.value = written[name];
  box.dispatchEvent(new Event("input"));
}
const run = motion(), result = {state, mu: mu(state.V, values_of_parameters()), x: run.x, y: run.y, h: run.t[1]};
for (const node of document.querySelectorAll("#thresholds data")) result[node.id] = node.value;
result.headline = document.getElementById("headline").textContent;
result.text = document.getElementById("c-threshold").textContent;
result.invalid = [...document.querySelectorAll("[aria-invalid=true]")].map(node => node.id);
result.told = document.getElementById("slider-V").getAttribute("aria-valuetext");
result.overflow = document.documentElement.scrollWidth - innerWidth;
result.number = %d;
parent.postMessage(JSON.stringify(result), "*");
</script></body>"""


def moved(page, tmp_path, *moves):
    """Return what the page computes after each move: sliders at shares of their lengths, and fields written in."""
    frames = []
    for number, (shares, written) in enumerate(moves):
        script = _MOVED % (json.dumps(shares), json.dumps(written), number)
        (tmp_path / f"{number}.html").write_text(page.replace("</body>", script), encoding="utf-8")
        frames.append(f'<iframe src="{number}.html" width="1300" height="900"></iframe>')
    found = [json.loads(unescape(text)) for text in sent_by(frames, tmp_path)]
    assert len(found) == len(moves)
    return sorted(found, key=lambda one: one["number"])


@pytest.fixture(scope="module")
def page():
    return explorer(ss.laws.exponential.typical(), ss.Oscillator(c=2, **POINT))


def test_a_slider_moved_shows_what_python_computes(page, answers):
    assert len(page) < 500_000
    assert not re.findall(r"(?:src|href)=\"(?!data:)|url\(|https?://|@import|fetch\(", page)
    found, at_own = answers[: len(MOVES)]
    state = found["state"]
    assert state["V"] == pytest.approx(0.5 * 5 ** (2 * 0.31 - 1), rel=1e-9)
    law = ss.laws.exponential.bind(**{name: state[name] for name in ("mu_s", "mu_m", "alpha")})
    for name in ("equilibrium", "least_squares", "harmonic"):
        value = ss.slope_average(law, name)(V=state["V"], N=state["N"])
        assert float(found[f"c-{name}"]) == pytest.approx(float(value), rel=1e-6)
    assert found["mu"] == pytest.approx(float(law.mu(state["V"])), rel=1e-12)
    threshold = ss.pure_slip_damping(law, **{name: state[name] for name in "VNmk"}, rtol=1e-9)
    assert float(found["c-threshold"]) == pytest.approx(threshold.value, rel=1e-6)
    assert found["told"] == f"{state['V']:.6g} m/s"
    assert found["overflow"] <= 0
    osc = ss.Oscillator(**{name: at_own["state"][name] for name in "VNmkc"})
    motion = ss.simulate(ss.laws.exponential.typical(), osc, t_end=2)
    t = np.linspace(0.1, 1.9, 40)
    rows = np.round(t / at_own["h"]).astype(int)
    x, y, _ = motion.at(rows * at_own["h"])
    assert np.max(np.abs(np.array(at_own["x"])[rows] - x)) < 2e-3 * np.ptp(x)
    assert np.max(np.abs(np.array(at_own["y"])[rows] - y)) < 2e-2 * np.ptp(y)


def test_what_python_refuses_the_page_refuses_and_a_comma_is_a_decimal_sign(answers):
    comma, *refused = answers[len(MOVES) :]
    assert (comma["state"]["V"], comma["invalid"]) == (0.3, [])
    for name, found in zip(WRONG, refused, strict=True):
        assert found["invalid"] == [f"value-{name}"]
        assert found["headline"].startswith(f"{name} ")
        assert found["state"] == {
            "V": 0.5,
            "N": 9.81,
            "m": 1,
            "k": 100,
            "c": 2,
            "mu_s": 0.5,
            "mu_m": 0.2,
            "alpha": 3,
        }


MOVES = {"V": 0.31, "alpha": 0.72, "mu_s": 0.6, "c": 0.5}, {"V": 0.4, "N": 0.7}
WRONG = {"V": "-1", "N": "-5", "m": "0", "k": "1e", "alpha": "x"}


@pytest.fixture(scope="module")
def answers(page, tmp_path_factory):
    """What the page computes after `MOVES`, after a comma and after each of `WRONG`: one start of the browser."""
    folder = tmp_path_factory.mktemp("moved")
    require_browser(folder)
    written = [{"V": "0,3"}, *({name: text} for name, text in WRONG.items())]
    return moved(page, folder, *((shares, {}) for shares in MOVES), *(({}, fields) for fields in written))


def own_script(page):
    """Return the page's script up to its part that needs a browser."""
    script = re.search(r"<script>(.*)</script>", page, re.S)[1]
    return script[: script.index("/* The page's own part")]


def thresholds_of_the_page(page, points, folder):
    """Return what the page knows of the threshold at points: rows of V, N, m, k and the values of parameters."""
    calls = [[dict(zip("VNmk", row[:4], strict=True)), row[4:]] for row in points]
    lines = (
        f"for (const [point, p] of {json.dumps(calls)}) {{ console.log(JSON.stringify(threshold(point, p, 0))); }}"
    )
    (folder / "calls.js").write_text(f"{own_script(page)}\n{lines}\n", encoding="utf-8")
    command = ["node", "calls.js"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300, check=True)
    return [json.loads(line) for line in done.stdout.splitlines()]


def check_thresholds(law, count, rng, folder):
    """Hold the page's thresholds against Python's at random values; return how many it does not know."""
    page = explorer(law.typical() if law.parameters else law, ss.Oscillator(c=1, **POINT))
    points, values = [], []
    for _ in range(count):
        V, N, m, k = np.exp(rng.uniform(np.log([0.05, 1, 0.2, 10]), np.log([2, 50, 5, 1000])))
        own = {
            name: float(value) * math.exp(rng.uniform(-0.3, 0.3)) for name, value in law.typical().values.items()
        }
        try:
            bound = law.bind(**own)
            threshold = ss.pure_slip_damping(bound, V=V, N=N, m=m, k=k, rtol=1e-9)
        except ss.InputError:  # values that the law does not take
            continue
        points.append([V, N, m, k, *own.values()])
        values.append((threshold.value, 1e-8 * N / V))
    answers = thresholds_of_the_page(page, points, folder)
    assert len(answers) == len(points)
    for (value, floor), answer in zip(values, answers, strict=True):
        if answer is not None:
            assert abs(answer["value"] - value) <= 1e-6 * abs(value) + floor
            assert abs(answer["value"] - value) <= 10 * answer["error"] + 1e-9 * abs(value)
    return sum(answer is None for answer in answers), len(answers)


def require_node():
    if shutil.which("node") is None:
        pytest.skip("all that needs a JavaScript of its own: no node on this machine")


@sample(2)
@pytest.mark.filterwarnings("ignore::stickslip_sym.core.errors.InputWarning")
@sweep(
    "name", ["exponential", "stribeck", "popp_stelter", "arcsinh", "tanh"], "exponential", "popp_stelter", "tanh"
)
def test_thresholds_of_the_page_are_those_of_python(name, tmp_path):
    require_node()
    law = ss.laws[name]
    unknown, asked = check_thresholds(law, 4, np.random.default_rng(5), tmp_path)
    assert unknown < asked


@pytest.mark.thorough
@pytest.mark.filterwarnings("ignore::stickslip_sym.core.errors.InputWarning")
def test_two_hundred_settings_of_the_catalogue(tmp_path):
    require_node()
    rng = np.random.default_rng(17)
    counts = [check_thresholds(law, 7, rng, tmp_path) for law in ss.laws.values()]
    unknown, asked = np.sum(counts, axis=0)
    assert asked > 180
    assert unknown <= 0.05 * asked


def test_a_kink_just_below_the_belt_s_speed_is_followed(tmp_path):
    """A table over V and N was 40 % off here."""
    require_node()
    law = ss.FrictionLaw("Piecewise((0.5 - v, v < 0.2), (0.3, True))")
    osc = ss.Oscillator(m=1, k=100, c=1, V=0.1955, N=49.05)
    (answer,) = thresholds_of_the_page(explorer(law, osc), [[osc.V, osc.N, osc.m, osc.k]], tmp_path)
    assert answer["value"] == pytest.approx(ss.pure_slip_damping(law, osc).value, rel=1e-8)
    narrow = ss.FrictionLaw("0.2 + 0.3*exp(-3*v) - 0.1*exp(-((v - 0.3)/0.0001)^2)")
    (answer,) = thresholds_of_the_page(explorer(narrow, osc), [[osc.V, osc.N, osc.m, osc.k]], tmp_path)
    threshold = ss.pure_slip_damping(narrow, osc)
    assert answer["value"] == pytest.approx(threshold.value, rel=1e-6 + threshold.relative_error)


def test_uncertain_values_and_measured_points_are_on_the_page(tmp_path):
    v = np.linspace(0.01, 1.2, 40)
    noise = np.random.default_rng(2).normal(0, 0.004, v.size)
    best = ss.fit(v, 0.2 + 0.3 * np.exp(-3 * v) + noise, laws=["exponential"]).best
    law = best.law.bind(**best.uncertain)
    osc = ss.Oscillator(c=2, **POINT)
    page = explorer(law, osc, errors={"N": ufloat(9.81, 0.1)}, measured=best.measured)
    assert "what was measured" in page
    assert "95 % band" in page
    require_browser(tmp_path)
    (found,) = moved(page, tmp_path, ({}, {}))
    shown = found["text"]  # before the slow part
    assert float(shown.split()[0]) == pytest.approx(ss.pure_slip_damping(law, osc).value, rel=1e-3)


def test_a_criterion_of_zero_has_a_page():
    assert "Stick–slip explorer: coulomb" in explorer(ss.laws.coulomb.typical(), ss.Oscillator(c=0, **POINT))


@pytest.mark.thorough
def test_kinked_and_measured_laws_have_a_page_and_user_s_words_are_no_code(tmp_path):
    require_browser(tmp_path)
    evil = "</script><script>alert(1)</script><!--"
    law = ss.FrictionLaw("Piecewise((mu_0 - a*v, v <= b), (mu_0 - a*b, True))", name=evil)
    law = law.bind(mu_0=0.5, a=0.3, b=0.6)
    v = np.linspace(0, 2, 13)
    for one in (law, ss.FrictionLaw.from_samples(v, 0.2 + 0.3 * np.exp(-3 * v))):
        page = explorer(one, ss.Oscillator(c=1, **POINT), time_limit=2)
        assert page.count("<script>") == page.count("</script>") == 1
        assert len(page) < 500_000
        (found,) = moved(page, tmp_path, ({"V": 0.4}, {}))
        V = found["state"]["V"]
        assert float(found["c-equilibrium"]) == pytest.approx(-9.81 * float(one.slope(V)), rel=1e-9)
        for name in ("least_squares", "harmonic"):
            enclosure = ss.enclose(one, name, V=V, N=9.81)
            assert float(found[f"c-{name}"]) == pytest.approx(float(enclosure.mid), rel=1e-6)
        assert found["mu"] == pytest.approx(float(one.mu(V)), rel=1e-9)


def test_the_command_writes_it(tmp_path, run):
    line = ["study", "linear", "-V", "0.4", "-c", "1", "--explore", "sliders.html", "--name", "bench"]
    code, out, err = run(*line)
    assert (code, err) == (0, "")
    assert re.search(r"sliders.html: \d\d kB, with sliders$", out.strip())
    assert [file.name for file in tmp_path.iterdir()] == ["sliders.html"]
    text = (tmp_path / "sliders.html").read_text(encoding="utf-8")
    assert "Stick–slip explorer: bench" in text
    assert run(*line)[2].startswith("error: 'sliders.html' exists")
