"""The explorer, moved in a real browser: what it shows is what Python computes there."""

import json
import re
from html import unescape

import numpy as np
import pytest
from pages import browse, require_browser

import stickslip_sym as ss
from stickslip_sym.comparison.explorer import explorer

POINT = {"V": 0.5, "N": 9.81, "m": 1, "k": 100}
_MOVED = """<script>
const moved = %s;
for (const name in moved) {
  const bar = document.getElementById("slider-" + name);
  bar.value = moved[name];
  bar.dispatchEvent(new Event("input"));
}
const run = motion(), result = {state, mu: mu(state.V, values_of_parameters()), x: run.x, y: run.y, h: run.t[1]};
for (const node of document.querySelectorAll("#thresholds data")) result[node.id] = node.value;
result.overflow = document.documentElement.scrollWidth - innerWidth;
const pre = document.createElement("pre");
pre.textContent = JSON.stringify(result);
document.body.append(pre);
</script></body>"""


def moved(page, shares, tmp_path):
    """Return what the page computes when sliders, by their names, have been moved to shares of their lengths."""
    (tmp_path / "page.html").write_text(page.replace("</body>", _MOVED % json.dumps(shares)), encoding="utf-8")
    done = browse((tmp_path / "page.html").as_uri(), tmp_path)
    assert (done.returncode, ":CONSOLE" in done.stderr) == (0, False), done.stderr
    return json.loads(unescape(re.search(r"<pre>(.*?)</pre>", done.stdout)[1]))


@pytest.fixture(scope="module")
def page():
    return explorer(ss.laws.exponential.typical(), ss.Oscillator(c=2, **POINT))


def test_a_slider_moved_shows_what_python_computes(page, tmp_path):
    require_browser(tmp_path)
    assert len(page) < 500_000
    assert not re.findall(r"(?:src|href)=\"(?!data:)|url\(|https?://|@import|fetch\(", page)
    found = moved(page, {"V": 0.31, "alpha": 0.72, "mu_s": 0.6, "c": 0.5}, tmp_path)
    state = found["state"]
    assert state["V"] == pytest.approx(0.5 * 5 ** (2 * 0.31 - 1), rel=1e-9)
    law = ss.laws.exponential.bind(**{name: state[name] for name in ("mu_s", "mu_m", "alpha")})
    for name in ("equilibrium", "least_squares", "harmonic"):
        value = ss.slope_average(law, name)(V=state["V"], N=state["N"])
        assert float(found[f"c-{name}"]) == pytest.approx(float(value), rel=1e-6)
    assert found["mu"] == pytest.approx(float(law.mu(state["V"])), rel=1e-12)
    assert found["c-exact"] == "NaN"  # of other parameters it has no table
    assert found["overflow"] <= 0
    at_own = moved(page, {"V": 0.4, "N": 0.7}, tmp_path)
    osc = ss.Oscillator(**{name: at_own["state"][name] for name in "VNmkc"})
    exact = ss.pure_slip_damping(ss.laws.exponential.typical(), osc, rtol=1e-9)
    assert float(at_own["c-exact"]) == pytest.approx(exact.value, rel=3e-5)
    motion = ss.simulate(ss.laws.exponential.typical(), osc, t_end=2)
    t = np.linspace(0.1, 1.9, 40)
    rows = np.round(t / at_own["h"]).astype(int)
    x, y, _ = motion.at(rows * at_own["h"])
    assert np.max(np.abs(np.array(at_own["x"])[rows] - x)) < 2e-3 * np.ptp(x)
    assert np.max(np.abs(np.array(at_own["y"])[rows] - y)) < 2e-2 * np.ptp(y)


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
        found = moved(page, {"V": 0.4}, tmp_path)
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
