"""``stickslip fit`` and ``study``: from a file of an instrument to ranked laws, and to a page in one command."""

import re

import numpy as np
import pytest

import stickslip_sym as ss
from support.commands import read_json
from support.web_pages import check_well_formed

pytest.importorskip("matplotlib")


V = np.repeat(np.round(np.geomspace(0.005, 1.5, 30), 4), 2)
MU = np.round(ss.laws.exponential.typical().mu(V) + 0.005 * np.random.default_rng(7).normal(size=60), 4)
TEXT = "v [m/s],mu\n" + "".join(f"{a},{b}\n" for a, b in zip(V, MU, strict=True))


def test_a_file_gives_the_fit_of_its_numbers(tmp_path, run):
    (tmp_path / "disc.csv").write_text(TEXT)
    code, out, err = run("fit", "disc.csv", "--law", "exponential", "--law", "linear", "--json")
    assert (code, err) == (0, "")
    found, fit = read_json(out)["fits"], ss.fit(V, MU, laws="exponential").best
    best = found["fits"][0]
    assert best["law"]["name"] == "exponential"
    assert found["measured"]["understood"] == "60 rows, v in m/s, mu from column 2"
    for name, value in best["values"].items():
        assert value == pytest.approx(fit.values[name], rel=1e-9)
        assert best["confidence"][name] == pytest.approx(fit.confidence()[name], rel=1e-9)


def test_a_fit_is_printed_drawn_and_fixed(tmp_path, run):
    (tmp_path / "disc.csv").write_text(TEXT)
    laws = [word for law in ("exponential", "stribeck", "a + b/(d + v)") for word in ("--law", law)]
    line = ["fit", "disc.csv", *laws, "-p", "delta=1", "--plot", "fit.svg"]
    code, out, err = run(*line)
    assert (code, err) == (0, "")
    assert out.startswith(
        "60 rows, v in m/s, mu from column 2\ncolumns parted by commas, decimal point\ndisc.csv, "
    )
    assert "delta =" not in out
    assert (tmp_path / "fit.svg").is_file()


def test_what_a_file_is_read_as_is_shown_and_written_in_clean_columns(tmp_path, run):
    (tmp_path / "raw.txt").write_text("t\tspeed [mm/s]\tµ\tstd\n1\t200\t0,3\t0,01\n2\t-100\t-0,4\t0,02\n")
    code, out, err = run("read", "raw.txt", "--csv", "clean.csv", "--plot", "raw.svg")
    assert (code, err) == (0, "")
    understood = "2 rows, v in mm/s, mu from column 3, sigma from column 4, both signs of speed folded, "
    assert " ".join(out.split()).startswith(understood)
    assert "columns parted by tabs, decimal comma\nraw.txt, " in out
    assert [line.split() for line in out.splitlines()[-2:]] == [["0.1", "0.4", "0.02"], ["0.2", "0.3", "0.01"]]
    clean, raw = ss.read_measurements("clean.csv"), ss.read_measurements("raw.txt")
    for name, column in raw.columns.items():
        np.testing.assert_array_equal(clean.columns[name], column)
    assert read_json(run("read", "clean.csv", "--json")[1])["columns"]["v"] == [0.1, 0.2]
    html = raw._repr_html_()
    assert all(words in html for words in ("decimal comma", "<td class", "0.02", "<img"))
    assert (tmp_path / "raw.svg").stat().st_size > 3000


def test_from_a_file_to_a_page(tmp_path, run):
    rng = np.random.default_rng(9)
    v = np.repeat(np.linspace(0.02, 1.2, 15), 2)
    rows = [f"{a:.4f},{b:.4f}\n" for a, b in zip(v, 0.5 - 0.2 * v + 0.004 * rng.normal(size=30), strict=True)]
    (tmp_path / "disc.csv").write_text("v [m/s],mu\n" + "".join(rows))
    code, out, err = run("study", "linear", "--fit", "disc.csv", "-c", "1.9(1)", "-V", "0.4")
    assert (code, err.splitlines()[0][:8]) == (0, "30 rows,")
    best = ss.fit(ss.read_measurements("disc.csv"), laws="linear").best
    exact = ss.pure_slip_damping(best.law.bind(**best.uncertain), V=0.4, N=9.81, m=1, k=100, method="orbit")
    shown = re.search(r"pure-slip damping by linear is ([\d.]+) \+/- ([\d.]+) kg/s", out)
    assert float(shown[1]) == pytest.approx(exact.value, abs=5e-4)
    assert float(shown[2]) == pytest.approx(exact.budget.uncertainty, rel=0.05)
    text = "".join(check_well_formed((tmp_path / "study.html").read_text(encoding="utf-8")).itertext())
    assert re.search(r"Measured \(disc.csv, \d{4}-\d\d-\d\d\): 30 rows", text)
    assert re.search(r"N = 9.81 N \(default\),\s+m = 1 kg \(default\)", text)
    assert "0.4 m/s (default)" not in text


@pytest.mark.thorough
def test_through_measured_points(tmp_path, run):
    (tmp_path / "pin.csv").write_text("v,mu\n0,0.5\n0.1,0.45\n0.3,0.4\n0.6,0.38\n1.2,0.37\n")
    line = ["study", "--from-csv", "pin.csv", "-c", "1", "-o", "pin.html", "--time-limit", "1"]
    code, out, _ = run(*line)
    assert code == 0
    assert "pin.html: " in out
    text = (tmp_path / "pin.html").read_text(encoding="utf-8")
    check_well_formed(text)
    assert re.search(r"Measured \(pin.csv, \d{4}-\d\d-\d\d\): 5 rows", text)


def test_numbers_for_a_program(tmp_path, run):
    line = ["study", "linear", "-c", "1.2", "-p", "mu_s=0.50+/-0.02", "-o", "page.html", "--json"]
    code, out, err = run(*line)
    assert (code, err) == (0, "")
    shown = read_json(out)
    law = ss.laws.linear.typical(mu_s="0.50+/-0.02")
    found = ss.study(law, ss.Oscillator(m=1, k=100, c=1.2, V=0.5, N=9.81))
    assert (shown["command"], shown["page"], shown["study"]["verdict"]) == ("study", "page.html", found.verdict)
    assert shown["study"]["headline"] == found.headline
    assert shown["study"]["probability"] == found.probability
    by_method = {one["method"]: one["value"] for one in shown["study"]["answers"]}
    assert by_method == {one.method: one.value for one in found.answers}
    changes = {row["name"]: row["change"] for row in shown["study"]["margins"]["rows"]}
    assert changes == {row.name: row.change if np.isfinite(row.change) else None for row in found.margins.rows}
    assert (tmp_path / "page.html").exists()


def test_without_a_browser_nothing_is_computed(tmp_path, run, monkeypatch):
    from stickslip_sym.views.pages import browser

    monkeypatch.setattr(browser.shutil, "which", lambda name: None)
    code, out, err = run("study", "linear", "--pdf", "study.pdf")
    assert (code, out) == (2, "")
    assert "a PDF needs chromium or chrome" in err
    assert not list(tmp_path.iterdir())
