"""What a notebook and a terminal show of every result, and that results can be copied and pickled."""

import copy
import pickle
import re
import sys
from base64 import b64decode
from xml.etree import ElementTree

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym.views import markup
from support.operating_points import paper_oscillator


def read(html):
    """Read HTML that is XML too: its tags, and its text."""
    page = ElementTree.fromstring(html)
    return [one.tag for one in page.iter()], "".join(page.itertext())


@pytest.fixture
def results(of_each_kind):
    return of_each_kind


NAMES = [
    "law", "sampled", "form", "average", "derivation", "step", "verdict", "refuted", "threshold", "thresholds",
    "unknown", "speed", "cycle", "limit_cycle", "regime", "rest", "separatrix", "trajectory", "map", "basins",
    "study",
]  # fmt: skip
SAID = {
    "law": ("exponential", "s/m", "decay rate", "source: Won & Chung 2016", r"\mu(v) = "),
    "sampled": ("piecewise cubic of 3",),
    "form": ("kg/s", "PROVED: 3 steps"), "derivation": ("split the law into terms", "the difference reduces to 0"),
    "refuted": ("REFUTED: left",), "threshold": ("c in kg/s", "2.573078879", "orbit"),
    "thresholds": ("0, 4", "...", "2, 9"), "unknown": ("unknown",), "cycle": ("stick_time", "m/s"),
    "limit_cycle": ("unstable pure-slip limit cycle", "1/s"), "speed": ("m/s",),
    "regime": ("rest at x = 0.0261867 m", "attracts", "does not attract", "stick-slip of period"),
    "trajectory": ("v in m/s", "samples from t = 0 to 5 s", "slip, slower than the belt"),
    "study": ("below the threshold", "simulation", "2.573078879"),
    "map": ("V = 0.1 to 0.9 m/s by alpha = 2 to 3 s/m", "cells"), "basins": ("initial conditions", "stick-slip"),
}  # fmt: skip
"""What a notebook's page says beside the terminal's line."""


@pytest.mark.parametrize("name", NAMES)
def test_terminal_shows_a_line_and_notebook_html(name, results):
    shown = repr(results[name])
    assert re.match(rf"{type(results[name]).__name__}(: |\()", shown)
    assert "\n" not in shown
    assert len(shown) < 240
    assert "array(" not in shown
    if name in SAID:
        _, text = read(results[name]._repr_html_())
        assert [word for word in SAID[name] if word not in text] == []


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(
    "again",
    [copy.copy, copy.deepcopy, lambda result: pickle.loads(pickle.dumps(result))],
    ids=["copy", "deep", "pickle"],
)
def test_results_can_be_copied_and_pickled(name, again, results):
    assert repr(again(results[name])) == repr(results[name])


def test_what_comes_back_computes_the_same(results):
    for name in ("form", "average"):
        back = pickle.loads(pickle.dumps(results[name]))
        assert back(V=0.3, N=9.81) == results[name](V=0.3, N=9.81)
    for name in ("law", "sampled"):
        back = pickle.loads(pickle.dumps(results[name]))
        assert back.mu(0.3) == results[name].mu(0.3)
        assert back.values == results[name].values
    trajectory = pickle.loads(pickle.dumps(results["trajectory"]))
    np.testing.assert_array_equal(trajectory.v, results["trajectory"].v)
    assert (trajectory.phase == results["trajectory"].phase).all()
    times = np.linspace(0.0, 5.0, 101)
    np.testing.assert_array_equal(trajectory.at(times).x, results["trajectory"].at(times).x)


@pytest.mark.parametrize("name", ["trajectory", "map", "basins", "regime"])
def test_a_picture_is_there_where_matplotlib_is(name, results, monkeypatch):
    """Without it the text and the table are the same."""
    pytest.importorskip("matplotlib")
    html = results[name]._repr_html_()
    ((content, alt),) = re.findall(r'<img src="data:image/png;base64,([^"]+)" alt="([^"]+)"/>', html)
    assert b64decode(content).startswith(b"\x89PNG")
    assert len(content) < 200_000
    assert alt.strip()
    assert results[name]._repr_html_() == html
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    plain = results[name]._repr_html_()
    assert "img" not in read(plain)[0]
    assert plain == re.sub(r"<img [^>]*/>", "", html)


def test_long_motion_shows_its_end():
    pytest.importorskip("matplotlib")
    long = ss.simulate(ss.FrictionLaw("0.3"), paper_oscillator(0.0), t_end=260.0, x0=0.2, v0=0.0, rtol=1e-6)
    assert len(long.t) > 3000
    since = float(re.search(r"The picture begins at t = (\S+) s\.", long._repr_html_())[1])
    assert since == pytest.approx(long.t[-3000], rel=1e-5)
    lines = long.plot(since=since).axes[0].lines
    times = np.concatenate([line.get_xdata() for line in lines])
    assert np.nanmin(times) == pytest.approx(since)
    assert np.nanmax(times) == long.t[-1]


NOTED = [
    (ss.laws.exponential.typical(), {"c": -5.0}, "no attractor"),
    (ss.laws.exponential.typical(), {"c": -0.5}, "far out grow without bound: damping and friction feed them"),
    (ss.FrictionLaw("0.3"), {"c": 0.0, "N": 0.0}, "undecided: slip orbits neither grow nor shrink"),
]


@pytest.mark.parametrize(("law", "changes", "note"), NOTED)
def test_views_of_a_regime_say_the_same(law, changes, note):
    found = ss.regime(law, paper_oscillator(**changes))
    _, text = read(found._repr_html_())
    assert note in str(found)
    assert all(line in text for line in str(found).splitlines())
    assert repr(found) == f"Regime: {'; '.join(str(found).splitlines())}"


def test_phase_plane_of_a_regime_has_every_motion(results, tmp_path):
    """Every curve is closed, and comes up to the velocity that the regime says."""
    pytest.importorskip("matplotlib")
    polynomial = ss.regime(ss.laws.polynomial.typical(), paper_oscillator(3.1))
    overtaking = ss.regime(ss.laws.exponential.typical(), paper_oscillator(0.0, V=5.0, N=0.5))
    for found in (results["regime"], polynomial, overtaking):
        periodic = [*found.cycles, *([found.stick_slip] if found.stick_slip else [])]
        top = sorted(getattr(one, "amplitude", None) or one.v_max for one in periodic)
        axes = found.plot(tmp_path / "regime.svg").axes[0]
        curves = [line.get_xydata() for line in axes.lines if len(line.get_xdata()) > 2]
        assert sorted(float(curve[:, 1].max()) for curve in curves) == pytest.approx(top, rel=1e-5)
        for curve in curves:
            assert curve[-1] == pytest.approx(curve[0], abs=1e-5)
        assert any(line.get_xydata().tolist() == [[found.rest.x, 0.0]] for line in axes.lines)
    assert "pure-slip cycle, unstable" in {text.get_text() for text in results["regime"].plot().legends[0].texts}


def test_many_thresholds_are_shortened(results):
    tags, text = read(results["thresholds"]._repr_html_())
    assert tags.count("tr") == 1 + 5 + 1 + 5
    assert "1, 5" not in text


def test_latex_stands_between_dollars(results):
    for name in ("law", "form", "step", "derivation"):
        text = results[name]._repr_latex_()
        assert text.startswith("$")
        assert text.endswith("$")
        assert text.count("{") == text.count("}")


def test_text_of_a_user_stays_text():
    evil = "<script>alert('1')</script> & $x$"
    law = ss.FrictionLaw("a - b*v", name=evil, source=evil, parameters=[ss.Parameter("a", evil)])
    form = ss.derive(law)
    for html in (law._repr_html_(), form._repr_html_(), form.derivation._repr_html_()):
        assert "script" not in read(html)[0]
    assert read(law._repr_html_())[1].count(evil) == 3
    assert markup.html_table(["<i>"], [["<b>", markup.Markup("<b></b>")]]).count("<b>") == 1
    assert '<td class="mathjax_ignore tex2jax_ignore">$x$</td>' in markup.html_table([""], [["$x$"]])


@pytest.mark.parametrize(
    ("name", "kinds"),
    [("law", "html latex"), ("form", "html latex"), ("threshold", "html"), ("trajectory", "html"), ("rest", "")],
)
def test_notebook_finds_what_it_shows(name, kinds, results):
    data, _ = pytest.importorskip("IPython.core.formatters").DisplayFormatter().format(results[name])
    assert data.keys() == {"text/plain", *(f"text/{kind}" for kind in kinds.split())}


def test_the_catalogue_has_a_table():
    _, text = read(ss.laws._repr_html_())
    assert all(name in text and law.source[:20] in text for name, law in ss.laws.items())


def test_a_notebook_shows_a_figure_without_pyplot(results):
    pytest.importorskip("matplotlib")
    figure = results["map"].plot()
    assert figure._repr_png_().startswith(b"\x89PNG")
    assert pickle.loads(pickle.dumps(figure))._repr_png_()[:4] == b"\x89PNG"


def test_laws_and_comparisons_have_pictures(tmp_path):
    pytest.importorskip("matplotlib")
    law = ss.laws.exponential.typical(mu_s="0.50(2)")
    (ax,) = law.plot(tmp_path / "law.svg", v_max=0.8).axes
    assert ax.get_xlim() == (0, 0.8)
    assert {"95 % band", "exponential"} <= {text.get_text() for text in ax.get_legend().get_texts()}
    assert law.plot(ax=ax) is ax.figure
    with pytest.raises(ss.InputError, match=r"give the highest one in m/s, as v_max=1\.0"):
        law.plot(v_max=-1)
    with pytest.raises(ss.InputError, match="alpha"):
        ss.laws.exponential.plot()
    v = np.linspace(0.02, 1, 30)
    fits = ss.fit(v, law.mu(v) + 0.003 * np.cos(40 * v), laws="exponential")
    ax.clear()
    for result in (fits, fits[0]):
        assert result.plot(ax=ax) is ax.figure
        assert {"measured", "95 % band", "exponential"} <= {
            text.get_text() for text in ax.get_legend().get_texts()
        }
        ax.clear()
    compared = ss.compare(law, V=0.5, N=9.81, m=1, k=100, methods=["harmonic", "orbit"])
    (ax,) = compared.plot(tmp_path / "c.svg").axes
    assert "orbit at $V$ = 0.5 m/s" in {text.get_text() for text in ax.get_legend().get_texts()}
    assert {path.name for path in tmp_path.iterdir()} == {"law.svg", "c.svg"}
