"""Each command: what it prints as text and as JSON is what Python gives."""

import re
import shlex

import click
import numpy as np
import pytest
from commands import read_json

import stickslip_sym as ss
from stickslip_sym.cli.output import as_json
from stickslip_sym.cli.program import COMMANDS, program
from stickslip_sym.output.browser import find_browser

EXPONENTIAL = "exponential: mu(v) = mu_m + (mu_s - mu_m)*exp(-alpha*v)"
DISC = "v [mm/s],mu\n" + "".join(f"{v},{0.3 + 10 / (50 + v):.3f}\n" for v in range(5, 900, 30))


@pytest.mark.parametrize(
    "name", [pytest.param(one, marks=[pytest.mark.thorough] * (one in ("study", "critical"))) for one in COMMANDS]
)
def test_example_in_the_help_works(name, run, tmp_path):
    (tmp_path / "disc.csv").write_text(DISC)
    if name in ("fit", "simulate", "study"):
        pytest.importorskip("matplotlib")
    code, help_text, _ = run(name, "--help")
    assert code == 0
    assert max(map(len, help_text.splitlines())) <= 80
    words = shlex.split(" ".join(help_text.split("Example: ")[1].split("\n\n")[0].split()))
    assert words[:2] == ["stickslip", name]
    if "--pdf" in words and find_browser() is None:
        pytest.skip("a PDF needs a browser, and there is none on this machine (Debian: apt-get install chromium)")
    if name in ("map", "tradeoff"):  # takes seconds; that the line is read is enough
        command = program.get_command(None, name)
        assert command.make_context(name, words[2:]).params
        return
    code, out, err = run(*words[1:])
    assert (code, err) == (0, "")
    assert out


def test_bare_command_prints_its_help(run):
    code, out, _ = run()
    assert (code, out) == (0, run("--help")[1])
    assert all(f"\n  {name}" in out for name in COMMANDS)
    assert run("--version") == (0, f"stickslip_sym {ss.__version__}\n", "")


def test_laws(run):
    _, out, err = run("laws")
    assert re.search(r"^exponential +mu_m \+ \(mu_s - mu_m\)\*exp\(-alpha\*v\) +mu_s = 0.5", out, re.M)
    assert err == ""
    _, out, _ = run("laws", "hyperbolic")
    assert out.startswith("hyperbolic: mu(v) = mu_m + (mu_s - mu_m)/(v/v_s + 1)\n")
    verdicts = re.findall(r"^(\w+), (PROVED|CHECKED)\n  c = ", out, re.M)
    assert verdicts == [("equilibrium", "PROVED"), ("least_squares", "PROVED"), ("harmonic", "PROVED")]
    content = read_json(run("laws", "--json")[1])
    assert [law["name"] for law in content["laws"]] == list(ss.laws.catalogue)
    (law,) = read_json(run("laws", "linear", "--json")[1])["laws"]
    assert law["criteria"]["harmonic"]["expr"] == "N*a_1"
    assert law["criteria"]["harmonic"]["verdict"]["status"] == "PROVED"


@pytest.mark.parametrize(
    "line", ["damping exponential -V 0.5", "critical exponential --of c", "simulate exponential"]
)
def test_answers_begin_with_the_operating_point(line, run):
    _, out, _ = run(*line.split())
    first, parameters, quantities, *_ = out.splitlines()
    assert first == EXPONENTIAL
    assert parameters == "mu_s = 0.5 (typical), mu_m = 0.2 (typical), alpha = 3 s/m (typical)"
    mark = "" if "-V" in line else " (default)"
    assert quantities.startswith(
        f"V = 0.5 m/s{mark}, N = 9.81 N (default), m = 1 kg (default), k = 100 N/m (default)"
    )


@pytest.mark.parametrize(
    ("name", "value"), [("exponential", "2.54594960290510"), ("polynomial", "3.04810714285714")]
)
def test_derive_ends_with_a_table(name, value, run):
    code, out, _ = run("derive", name)
    assert code == 0
    assert f"ClosedForm: {name}, least_squares, PROVED" in out
    *_, closed, quadrature, threshold = (re.split(r"\s{2,}", line) for line in out.splitlines())
    assert [closed[0], quadrature[0], threshold[0]] == [
        "closed form",
        "quadrature, 50 digits",
        "event-driven threshold",
    ]
    assert closed[1].startswith(value)
    assert float(quadrature[2]) < 1e-48
    assert 0.003 < float(threshold[2]) < 0.02


def test_derive_as_json(run):
    code, out, err = run(
        *["derive", "exponential", "--criterion", "harmonic", "--steps", "--json", "-p", "alpha=7/3"]
    )
    assert (code, err) == (0, "")
    content = read_json(out)
    assert content["law"]["parameters"]["alpha"]["text"] == "7/3"
    assert (content["operating_point"]["N"]["value"], content["operating_point"]["N"]["default"]) == (9.81, True)
    (row,) = content["criteria"]
    closed, quadrature, simulated = row["checks"]
    form = ss.derive(ss.laws.exponential.typical(alpha="7/3"), "harmonic")
    assert float(closed["value"]) == pytest.approx(form(V=0.5, N=9.81), rel=1e-14)
    assert quadrature["difference"] < 1e-40
    assert simulated["seconds"] > 0
    assert {step["verdict"]["status"] for step in row["steps"]} == {"PROVED"}


def test_derive_all_criteria_of_a_formula(run):
    code, out, err = run("derive", "a - b*v", "--criterion", "all")
    assert code == 0
    assert re.findall(r"ClosedForm: .*, (\w+), ", out) == ["equilibrium", "least_squares", "harmonic"]
    assert "c = N*b" in out
    assert err == "\nno value for a, b: give -p a=... for a table of values\n"


def test_derive_without_a_closed_form(run):
    code, out, err = run("derive", "tanh(exp(a*v))", "-p", "a=1", "--time-limit", "0", "--json")
    (row,) = read_json(out)["criteria"]
    assert code == 1
    assert err == f"error: {row['form']}\n"
    assert row["checks"][0]["method"] == "quadrature, 50 digits"


@pytest.mark.thorough
def test_derive_writes_latex_and_keeps_the_form(run, tmp_path):
    (tmp_path / "pin.csv").write_text("v,mu\n0,0.5\n0.1,0.4\n0.3,0.3\n1.2,0.25\n")
    code, out, _ = run("derive", "--from-csv", "pin.csv", "--save", "pin.json", "--latex", "pin.tex", "--steps")
    assert code == 0
    form = ss.load(tmp_path / "pin.json")
    assert f"{form(V=0.5, N=9.81):.9f}"[:8] in out
    text = (tmp_path / "pin.tex").read_text()
    assert text.count("\\begin{equation*}") == len(re.findall(r"^% (?:PROVED|CHECKED)", text, re.M)) >= 1
    code, _, err = run("derive", "--from-csv", "pin.csv", "-V", "0.7")
    assert (code, "measured up to v = 1.2 m/s, and its value at 1.4 m/s is needed" in err) == (2, True)
    assert run("derive", "--from-csv", "pin.csv", "-V", "0.7", "--extrapolate")[0] == 0


def test_damping(run):
    law = ss.laws.exponential.typical()
    _, out, _ = run(*["damping", "exponential", "--json"])
    (answer,) = read_json(out)["answers"]
    expected = ss.pure_slip_damping(law, V=0.5, N=9.81, m=1.0, k=100.0)
    assert (answer["threshold"]["value"], answer["threshold"]["method"]) == (expected.value, expected.method)
    _, out, _ = run(*["damping", "coulomb", "--all", "--json"])
    answers = read_json(out)["answers"]
    compared = ss.compare(ss.laws.coulomb.typical(), V=0.5, N=9.81, m=1.0, k=100.0)
    assert [answer["method"] for answer in answers] == [one.method for one in compared]
    assert all((answer["threshold"] is None) == bool(answer["reason"]) for answer in answers)
    assert any(answer["reason"] for answer in answers)


def test_damping_with_standard_errors(run):
    _, out, _ = run("damping", "exponential", "-p", "mu_s=0.50+/-0.02", "-V", "0.50(1)", "--method", "orbit")
    assert "c = 2.57 +/- 0.18 kg/s (parameters)" in out
    assert re.search(r"^mu_s +0.02 +0.171 +91.9 %$", out, re.M)


def test_several_points_in_one_call(run, tmp_path):
    (tmp_path / "a.toml").write_text('law = "polynomial"\nV = 0.3\nc = 1.5\n[parameters]\nv_m = "1.0+/-0.1"\n')
    (tmp_path / "b.toml").write_text('law = "exponential"\nV = 0.4\nN = "9.81(1)"\n')
    line = ["damping", "--point", "a.toml", "--point", "b.toml", "-k", "200", "--method", "orbit"]
    _, out, _ = run(*line)
    first, second = out.split("\n\nexponential: ")
    assert "polynomial: mu(v)" in first
    assert "v_m = 1.00+/-0.10 m/s" in first
    assert "V = 0.3 m/s, N = 9.81 N (default), m = 1 kg (default), k = 200 N/m\n" in first
    assert "V = 0.4 m/s, N = 9.81(1) N, m" in second
    points = read_json(run(*line, "--json")[1])["points"]
    expected = ss.pure_slip_damping(ss.laws.exponential.typical(), V=0.4, N=9.81, m=1, k=200, method="orbit")
    assert points[1]["answers"][0]["threshold"]["value"] == pytest.approx(expected.value, rel=1e-12)


def test_critical_values(run):
    line = ["critical", "exponential", "--of", "alpha", "-c", "2", "--method", "harmonic"]
    _, out, err = run(*line)
    values = [row for row in out.splitlines() if row.startswith("alpha = ")]
    assert [row.split(" (")[0] for row in values] == ["alpha = 1.168213768 s/m", "alpha = 9.145431583 s/m"]
    assert err == ""
    (value,) = read_json(run(*line, "--within", "5:20", "--json")[1])["values"]
    assert value["value"] == pytest.approx(9.145431583)
    assert value["sensitivity"]["c"] < 0 < value["sensitivity"]["mu_s"]
    assert run(*["critical", "exponential", "--of", "mu_s", "-c", "2", "--within", "1:5"])[1].endswith(
        "there is no such value of mu_s\n"
    )


def test_margins_and_their_probability(run):
    line = ("critical", "linear", "-p", "a_1=0.30(3)", "-c", "3.2+/-0.1", "--method", "orbit")
    _, out, _ = run(*line)
    assert "no stick-slip: c = 3.2 kg/s, pure-slip damping 2.94 +/- 0.29 kg/s (parameters)" in out
    assert "probability that stick-slip is possible: 0.2" in out
    margins = read_json(run(*line, "--json")[1])["margins"]
    changes = {row["name"]: row["change"] for row in margins["rows"]}
    # c = N a_1 for a straight line, whatever else
    assert changes["a_1"] == changes["N"] == pytest.approx(3.2 / 2.943 - 1, rel=1e-6)
    assert changes["V"] is changes["m"] is changes["mu_s"] is None
    assert margins["stick_slip"] is False


@pytest.mark.thorough
def test_one_critical_value_is_that_of_all(run):
    line = ["critical", "exponential", "-c", "2", "--rtol", "1e-6", "--json"]
    (row,) = [row for row in read_json(run(*line)[1])["margins"]["rows"] if row["name"] == "mu_s"]
    (alone,) = read_json(run(*line, "--of", "mu_s")[1])["values"]
    assert row["below"]["value"] == pytest.approx(alone["value"], rel=1e-5)


def test_simulate(run, tmp_path):
    _, out, _ = run(*["simulate", "exponential", "-c", "1", "--t-end", "3"])
    assert re.search(r"^0 +0 +0.5 +start +stick$", out, re.M)
    assert re.search(r"^0.0881 +0.04405 +0.5 +static friction gives way +slip, slower than the belt$", out, re.M)
    assert "outcome: finished, at t = 3 s, 10 events" in out
    content = read_json(run(*["simulate", "exponential", "-c", "1", "--t-end", "2", "--json"])[1])
    motion = ss.simulate(ss.laws.exponential.typical(), ss.Oscillator(m=1, k=100, c=1, V=0.5, N=9.81), t_end=2.0)
    assert content["motion"]["events"] == as_json(motion.events)
    assert content["periods"][-1] == pytest.approx(0.651445008)
    pytest.importorskip("matplotlib")
    line = "simulate mu_0-b*v -p mu_0=0.4 -p b=0.1 -V 1/4 -m 2 -k 50 -N 3 --x0 0.1 --v0=-0.5 --t-end 2"
    code, out, _ = run(*line.split(), "--rtol", "1e-8", "--csv", "a.csv", "--plot", "a.png")
    assert code == 0
    assert re.search(r"^0 +0\.1 +-0\.5 +start +slip, slower than the belt$", out, re.M)
    assert (tmp_path / "a.csv").read_text().startswith("t (s),x (m),v (m/s),phase\n0.0,0.1")
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


def test_simulate_ends_in_words(run):
    assert re.search(r"^and \d+ more events$", run("simulate", "exponential", "--t-end", "40")[1], re.M)
    _, out, _ = run(*["simulate", "exponential", "-c", "30", "--t-end", "100"])
    assert "outcome: at rest, at t = 100 s" in out
    assert "fewer than two slips" in out
    _, out, _ = run(*["simulate", "exponential", "-c", "-50", "--t-end", "100"])
    assert "outcome: grows without bound" in out
    assert "a larger c" in out


def test_map(run):
    line = ["map", "exponential", "--x", "V=0.5:0.8:2", "--y", "c=1:3:3"]
    content = read_json(run(*line, "--json")[1])
    assert (content["y"]["name"], content["y"]["values"]) == ("c", [1.0, 2.0, 3.0])
    found = ss.motion_map(
        ss.laws.exponential.typical(), x=("V", np.array([0.5, 0.8])), y=("c", np.array([1.0, 2.0, 3.0])),
        N=9.81, m=1.0, k=100.0,
    )  # fmt: skip
    assert content["map"]["motion"] == [[cell.value for cell in row] for row in found.motion]
    _, out, _ = run(*line)
    assert "c = 1 to 3 upwards, V = 0.5 to 0.8 to the right" in out
    assert re.search(r"^S +stick-slip +\d+ ", out, re.M)


def test_tradeoff(run):
    content = read_json(run(*["tradeoff", "exponential", "-V", "1e-4", "--json"])[1])["trades"]["criterion"]
    methods = {", ".join(filter(None, (row["method"], row["setting"]))): row for row in content["rows"]}
    assert methods["plain lambdify, array"]["error"] > 0.1
    assert methods["stable function, one value"]["error"] < 1e-14
    assert content["dominators"].keys() == methods.keys()
    assert content["point"]["V"] == 1e-4


def test_export_writes_all_or_nothing(run, tmp_path):
    line = "export exponential polynomial --criterion all --latex a.tex --c a.c --save a.json --symbol V=v_b"
    code, out, _ = run(*line.split())
    assert (code, out) == (0, "latex: 6 criteria in a.tex\nc: 6 criteria in a.c\nsave: 6 criteria in a.json\n")
    assert "v_b" in (tmp_path / "a.tex").read_text()
    content = read_json(run(*line.split(), "--overwrite", "--json")[1])
    assert [row["criterion"] for row in content["criteria"]] == list(ss.criteria.catalogue) * 2
    code, _, err = run("export", "tanh(exp(a*v))", "--latex", "b.tex", "--python", "b.py", "--time-limit", "0")
    assert code == 1
    assert err.startswith("error: ")
    assert not (tmp_path / "b.py").exists()


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_json_and_help_of_its_options(name):
    command = program.get_command(click.Context(program), name)
    options = [one for one in command.params if isinstance(one, click.Option)]
    assert "--json" in {text for one in options for text in one.opts}
    assert all(one.help for one in options)
    files = [one for one in options if type(one.type).__name__ == "_Written"]
    assert bool(files) == ("overwrite" in {one.name for one in options})


def test_code_needs_the_values_of_shapes(run, tmp_path, monkeypatch):
    """One law is refused before it is derived; of the whole catalogue it is left out by name."""
    code, _, err = run("export", "stribeck", "--c", "a.c", "--latex", "a.tex")
    assert code == 2
    assert "delta of the law stribeck is a shape" in err
    assert list(tmp_path.iterdir()) == []
    few = {name: ss.laws.catalogue[name] for name in ("linear", "stribeck")}
    monkeypatch.setattr(type(ss.laws), "values", lambda self: few.values(), raising=False)
    code, out, err = run("export", "--all", "--c", "a.c", "--latex", "a.tex")
    assert (code, out) == (0, "latex: 2 criteria in a.tex\nc: 1 criterion in a.c\n")
    assert err.count("no code: delta of the law stribeck") == 1
    text = (tmp_path / "a.c").read_text(encoding="utf-8")
    assert "ClosedForm: linear, least_squares, PROVED" in text
    assert "stribeck" not in text
