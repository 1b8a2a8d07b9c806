"""The report of the paper's checks: complete, well-formed, and right in a real browser."""

import json
import os
import re
import subprocess
import sys
from base64 import b64decode
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import sympy as sp
from rich.console import Console

from paper_checks import wording
from paper_checks.claims import CLAIMS, Outcome
from paper_checks.figures import FIGURES
from paper_checks.findings import Finding
from paper_checks.proved import theorem
from paper_checks.report import Report, as_json, certificates
from paper_checks.report import page as page_of
from paper_checks.terminal import verdicts
from stickslip_sym import Status
from stickslip_sym.comparison.compare import Row
from stickslip_sym.views.drawing import svg_uri
from stickslip_sym.views.markup import element, marked_prose
from stickslip_sym.views.pages.render import versions
from support.web_pages import XHTML, check_well_formed, look_at

ROOT = Path(__file__).parents[2]
CHECKED = ("E3", "N1")  # cheap ones; the report tells of the others that they were not checked


SHORTER = """
import sys
from functools import partial
import pytest
from paper_checks import figure_thresholds, report
from stickslip_sym.comparison import tradeoff
# The report's measurements at fewer places, which changes none of its parts.
figure_thresholds._SCANNED = ()
report.SPEEDS = tradeoff.SPEEDS = tradeoff.SPEEDS[[10]]
report.LAWS = report.LAWS[:1]
tradeoff.SCAN_STEP = 0.01
tradeoff.pure_slip_by_scan = partial(tradeoff.pure_slip_by_scan, step=1e-3, band=1e-3)
sys.exit(pytest.main(sys.argv[1:]))
"""


def run_checks(*arguments, **environment):
    command = [sys.executable, "-c", SHORTER, "paper_checks", "-n", "0", "-q", "-p", "no:cacheprovider"]
    given = {"capture_output": True, "text": True, "cwd": ROOT, "timeout": 120, "check": False}
    return subprocess.run([*command, *arguments], env=os.environ | environment, **given)


@pytest.mark.thorough
def test_a_report_of_a_run(tmp_path):
    """One report, drawn once, is looked at from all sides."""
    pytest.importorskip("matplotlib")
    chosen = " or ".join(CHECKED)
    folder = tmp_path / "new"
    done = run_checks("-k", chosen, "--report", str(folder), "--color=yes", COLUMNS="80", TERM="xterm")
    assert done.returncode == 0, done.stdout + done.stderr
    page = (folder / "report.html").read_text(encoding="utf-8")
    check_terminal(done.stdout)
    check_json(json.loads((folder / "claims.json").read_text(encoding="utf-8")))
    assert len(page) < 3_000_000
    check_well_formed(page)
    check_complete(page)
    for probe in look_at(page, tmp_path):
        assert probe["rows"] == probe["shown"] == len(CLAIMS)
        assert len(probe["formulas"]) >= 18
        assert min(probe["formulas"]) > 8
        assert len(probe["pictures"]) == 9


def test_the_page_and_the_numbers_of_a_report():
    """Of findings as a run would make them, without its figures."""
    findings = {id: Finding(id, "0 0.05 0.1 0.1287", Outcome.REPRODUCED, "it holds", "so") for id in CHECKED}
    names = ("equilibrium", "least_squares", "harmonic", "second_order", "proof")
    stated = [(10.0**-place, Status.ESTIMATED) for place in range(4)] + [(1e-12, Status.PROVED)]
    rows = [Row(name, 2.5, *one, 1e-3, further={"largest": 0.1}) for name, one in zip(names, stated, strict=True)]
    rows.append(Row("Newmark scan", 2.5, 1e-3, Status.ESTIMATED, 2.0))
    pictures = {figure.number: "data:," for figure in FIGURES}
    report = Report(findings, pictures, {"exponential": tuple(rows)}, versions(), "now")
    check_json(json.loads(json.dumps(as_json(report), allow_nan=False)))
    theorem("polynomial", V="1", rtol=1e-3)  # as a claim would take it
    page = page_of(report)
    linked = set(re.findall(r'href="(certificates/[^"]*)"', page))
    assert {"certificates/least_squares.py", "certificates/exponential_V0.5_k100.py"} < linked
    assert "certificates/polynomial_V1_k100.py" in linked
    assert {
        "certificates/least_squares.v",
        "certificates/exponential_law.v",
        "certificates/polynomial_law.v",
    } < linked
    ends = {".py": "proved: ", ".v": "Print Assumptions"}
    assert all(ends[Path(name).suffix] in certificates()[name] for name in linked)
    check_well_formed(page)
    check_complete(page)
    assert "not measured" in page


def check_complete(page):
    """Every claim, equation and figure is found by its number."""
    root = ElementTree.fromstring(page.removeprefix("<!DOCTYPE html>\n"))
    by_id = {node.get("id"): node for node in root.iter() if node.get("id")}
    for number in range(1, 19):
        assert by_id[f"equation-{number}"].find(".//m:math", XHTML) is not None
    for number in range(2, 11):
        picture = by_id[f"figure-{number}"].find("img")
        assert len(picture.get("alt")) > 100
    for id in CLAIMS:
        words = "".join(by_id[f"claim-{id}"].itertext())
        assert ("✓ reproduced" in words) == (id in CHECKED)
        assert ("not checked" in words) == (id not in CHECKED)
        assert ("by proof" in words) == ("PROVED: " in words) == (id in CHECKED)
    assert "proof" in (methods := "".join(by_id["methods"].itertext()))
    assert "PROVED" in methods


def check_json(content):
    assert content["format"] == 3
    assert set(content) == {"format", "time", "versions", "summary", "claims", "equations", "figures", "methods"}
    counts = {"reproduced": len(CHECKED), "not checked": len(CLAIMS) - len(CHECKED)}
    assert content["summary"] == {"qualified": 0, "not reproduced": 0} | counts
    claims = {claim["id"]: claim for claim in content["claims"]}
    assert list(claims) == list(CLAIMS)
    for id, claim in claims.items():
        assert set(claim) == {
            "id", "where", "says", "paper", "ours", "difference", "verdict", "on_record", "holds", "evidence",
        }  # fmt: skip
        assert (claim["verdict"] is not None) == (id in CHECKED)
        assert claim["on_record"] == CLAIMS[id].outcome.value
        assert (claim["evidence"] is None) == (claim["holds"] is None) == (id not in CHECKED)
    assert claims["N1"]["ours"].startswith("0 0.05 0.1 0.1287")
    assert all(set(claims[id]["evidence"]) == {"PROVED"} for id in CHECKED)
    assert [equation["number"] for equation in content["equations"]] == [f"({n})" for n in range(1, 19)]
    assert [figure["number"] for figure in content["figures"]] == list(range(2, 11))
    assert {"python", "sympy", "numpy", "stickslip_sym"} <= set(content["versions"])
    for methods in content["methods"]["laws"].values():
        error = {one["method"]: one["relative_error"] for one in methods}
        assert error["equilibrium"] > error["least_squares"] > error["harmonic"] > error["second_order"] > 0
        assert all(one["seconds"] > 0 for one in methods)
        assert {one["status"] for one in methods if one["method"] == "proof"} == {"PROVED"}
        assert {one["status"] for one in methods if one["method"] != "proof"} == {"ESTIMATED"}


def check_terminal(printed):
    assert "\x1b[32mreproduced\x1b[0m" in printed
    lines = re.sub(r"\x1b\[[\d;]*m", "", printed).splitlines()
    assert max(len(line) for line in lines if not line.startswith("report: ")) <= 80  # a path stays whole
    assert "2 reproduced, 0 qualified, 0 not reproduced" in lines
    assert sum(line.split()[1:3] == ["reproduced", "proof"] for line in lines) == len(CHECKED)


@pytest.mark.parametrize("width", [40, 60, 80, 120, 300])
def test_no_line_is_wider_than_the_terminal(width):
    findings = [Finding(id, "some value", claim.outcome, "", "a", "b", "c") for id, claim in CLAIMS.items()]
    console = Console(width=width - 1, color_system=None)
    with console.capture() as captured:
        console.print(verdicts(findings))
    lines = captured.get().splitlines()
    assert max(map(len, lines)) < width
    squeezed = "".join("".join(lines).split())
    assert all(id in squeezed for id in CLAIMS)


def test_the_same_figure_is_the_same_file():
    pytest.importorskip("matplotlib")
    (figure,) = (figure for figure in FIGURES if figure.number == 10)
    first, again = (b64decode(svg_uri(figure.draw()).partition(",")[2]).decode() for _ in range(2))
    assert first == again
    hatched = re.findall(r'style="(fill: url\(#h[^"]*)"', first)
    assert len(hatched) >= 6  # three regions in two panels, and their legends
    assert not any("opacity" in style for style in hatched)  # else the hatch is as pale as its face


@pytest.mark.thorough
def test_figures_say_what_becomes_of_the_motions():
    pytest.importorskip("matplotlib")
    drawn = {figure.number: figure.draw() for figure in FIGURES if figure.number in (4, 5)}
    fates = [ax.texts[0].get_text() for ax in drawn[4].axes[1::2]]
    assert fates[:3] == ["sticks and slips for ever"] * 3
    assert fates[3] == "tends to a slip cycle, 0.4986 m/s"
    assert fates[4].startswith("comes to rest")
    words = [" ".join(text.get_text() for text in ax.texts) for ax in drawn[5].axes]
    assert ["by the initial condition" in said for said in words] == [True, False, False]
    assert ["$P$, $Q$" in said for said in words] == [True, True, False]


def test_a_verdict_other_than_on_record_is_marked():
    claim = CLAIMS["E3"]
    assert claim.outcome is Outcome.REPRODUCED
    pictures = {figure.number: "data:," for figure in FIGURES}

    def row(*findings):
        text = page_of(Report({finding.id: finding for finding in findings}, pictures, {}, {}, ""))
        return re.search(r'<tbody class="claim" id="claim-E3">.*?</tbody>', text, re.S)[0]

    rows = [row(Finding("E3", "ours", outcome, "it holds", checked="so")) for outcome in Outcome]
    assert ["on record: reproduced" in row for row in rows] == [False, True, True]
    assert all("it holds" in row.lower() and "by check" in row and "CHECKED" in row for row in rows)
    assert "not checked" in row()


def test_text_is_escaped():
    assert element("p", "a < b & <b>", title='"') == '<p title="&quot;">a &lt; b &amp; &lt;b&gt;</p>'
    assert marked_prose("mu_s <= 1 & <i>") == "<i>μ</i><sub>s</sub> ≤ 1 &amp; &lt;i&gt;"
    typeset = "−2\u2009V<sup>2</sup> to V<sup>−1.5</sup>, stick-slip at 1e-3"
    assert marked_prose("-2*V**2 to V^-1.5, stick-slip at 1e-3") == typeset


def test_indices_and_bessel_functions_are_typeset():
    """Seeded orders, arguments and letters: no name of SymPy's and no underscore reaches the page."""
    rng = np.random.default_rng(11)
    x, y = sp.symbols("alpha V", positive=True)
    for _ in range(40):
        order = int(rng.integers(0, 30))
        bessel, letter = [(sp.besseli, "I"), (sp.besselj, "J"), (sp.besselk, "K"), (sp.bessely, "Y")][order % 4]
        expr = int(rng.integers(2, 9)) * bessel(order, x * y) * sp.exp(-x * y) / y
        text = wording.formula(expr)
        assert f"{letter}_{order}(" in text
        value = sp.sympify(re.sub(r"([IJKY])_(\d+)\(", lambda f: f"bessel{f[1].lower()}({f[2]},", text))
        assert sp.simplify(value.subs({"alpha": x, "V": y}) - expr) == 0
        page = marked_prose(text)
        assert f"<i>{letter}</i><sub>{order}</sub>(" in page
        assert "_" not in page
    assert wording.formula(sp.Symbol("b") - sp.Symbol("a")) == "b - a"


@pytest.mark.thorough
def test_a_report_that_cannot_be_written_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    done = run_checks("--report", str(tmp_path / "file"), "-k", "N1")
    assert done.returncode == pytest.ExitCode.USAGE_ERROR
    assert "give a folder that can be made" in done.stderr
