"""Each command: what it prints as text and as JSON is what Python gives."""

import re
import shlex

import click
import mpmath
import pytest

import stickslip_sym as ss
from stickslip_sym.cli.program import COMMANDS, program
from stickslip_sym.output.content import content as content_of
from stickslip_sym.views.pages.browser import find_browser
from support.commands import read_json
from support.sweeps import sweep

EXPONENTIAL = ss.laws.exponential.typical()
AT = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}
DISC = "v [mm/s],mu\n" + "".join(f"{v},{0.3 + 10 / (50 + v):.3f}\n" for v in range(5, 900, 30))
PIN = "v,mu\n0,0.5\n0.1,0.4\n0.3,0.3\n1.2,0.25\n"
TYPICAL = "mu_s = 0.5 (typical), mu_m = 0.2 (typical), alpha = 3 s/m (typical)\nV = 0.5 m/s"
FORMULA = re.escape("exponential: mu(v) = mu_m + (mu_s - mu_m)*exp(-alpha*v)\n" + TYPICAL)


@sweep("name", COMMANDS, *(name for name in COMMANDS if name not in ("study", "critical")))
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
        assert program.get_command(None, name).make_context(name, words[2:]).params
        return
    code, out, err = run(*words[1:])
    assert (code, err) == (0, "")
    assert out


def test_bare_command_prints_its_help(run):
    code, out, _ = run()
    assert (code, out) == (0, run("--help")[1])
    assert all(f"\n  {name}" in out for name in COMMANDS)
    assert run("--version") == (0, f"stickslip_sym {ss.__version__}\n", "")


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_json_and_described_options(name):
    command = program.get_command(click.Context(program), name)
    options = {one.name: one for one in command.params if isinstance(one, click.Option)}
    assert "json" in options
    assert all(one.help for one in options.values())
    writes = any(one.metavar == "FILE" and one.type is click.STRING for one in options.values())
    assert writes == ("overwrite" in options)


TEXTS = [
    ("laws", r"^exponential +mu_m \+ \(mu_s - +mu_s = 0.5"),
    ("laws hyperbolic", r"\Ahyperbolic: mu\(v\) = mu_m \+ \(mu_s - mu_m\)/\(v/v_s \+ 1\)\n",
     r"^equilibrium, PROVED\n  c = ", r"^least_squares, PROVED\n  c = ", r"^harmonic, PROVED\n  c = "),
    # answers begin with the operating point
    ("damping exponential -V 0.5 -N 9.81", r"V = 0\.5 m/s, N = 9\.81 N$",
     r"^c = 2\.578531669 kg/s \(harmonic, relative error unknown, ESTIMATED\)$"),
    ("damping exponential -V 0.5", rf"\A{FORMULA}, N = 9.81 N \(default\), m = 1 kg \(default\)"),
    ("critical exponential --of c", rf"\A{FORMULA} \(default\), N = 9.81 N \(default\)"),
    ("simulate exponential", rf"\A{FORMULA} \(default\),[^$]*, c = 0 kg/s \(default\)$"),
    ("damping exponential -p mu_s=0.50+/-0.02 -V 0.50(1) --method orbit",
     r"^c = 2\.57 \+/- 0\.18 kg/s \(parameters\)", r"^mu_s +0\.02 +0\.171 +91\.9 %$"),
    ("critical exponential --of alpha -c 2 --method harmonic",
     r"^alpha = 1\.168213768 s/m \(", r"^alpha = 9\.145431583 s/m \("),
    ("critical exponential --of mu_s -c 2 --within 1:5",
     r"^there is no such value of mu_s\nmu_s was looked at from 1 to 5\n\Z"),
    ("critical linear -p a_1=0.30(3) -c 3.2+/-0.1 --method orbit",
     r"no stick-slip: c = 3\.2 kg/s, pure-slip damping 2\.94 \+/- 0\.29 kg/s \(parameters\)",
     r"probability that stick-slip is possible: 0\.2"),
    ("simulate exponential -c 1 --t-end 3", r"^0 +0 +0.5 +start +stick$",
     "outcome: finished, at t = 3 s, 10 events",
     r"^0.0881 +0.04405 +0.5 +static friction +slip, slower than the\n +gives way +belt$"),
    ("simulate exponential --t-end 40", r"^and \d+ more events$"),
    ("simulate exponential -c 30 --t-end 100", "outcome: at rest, at t = 100 s", "fewer than two slips"),
    ("map exponential --x V=0.5:0.8:2 --y c=1:3:3", "c = 1 to 3 upwards, V = 0.5 to 0.8 to the right",
     r"^S +stick-slip +\d+ "),
    ("derive a-b*v --criterion all",
     r"^ClosedForm: .*, equilibrium, [^$]*^ClosedForm: .*, harmonic, ", r"c = N\*b"),
    ("derive exponential", "^ClosedForm: exponential, least_squares, PROVED", r"^closed form +2\.5459",
     r"^quadrature, 50 (?:digits)? +[-\d.]+ +(0|\d\.?\d*e-(49|5\d)) ",
     r"^event-driven (?:threshold)? +[\d.]+ +0\.0[01]\d* "),
]  # fmt: skip


@pytest.mark.parametrize(("line", "said"), [(line, said) for line, *said in TEXTS])
def test_text(line, said, run):
    code, out, _ = run(*line.split())
    assert code == 0
    assert [pattern for pattern in said if not re.search(pattern, out, re.M)] == []


def damping(content):
    expected = ss.pure_slip_damping(EXPONENTIAL, **AT)
    assert (content["threshold"]["value"], content["threshold"]["method"]) == (expected.value, expected.method)


def comparison(content):
    expected = {row.method: row.value is None for row in ss.compare(ss.laws.coulomb.typical(), **AT)}
    assert {row["method"]: row["reason"] != "" for row in content["rows"]} == expected
    assert True in expected.values()


def margins(content):
    changes = {row["name"]: row["change"] for row in content["margins"]["rows"]}
    # c = N a_1 for a straight line, whatever else
    assert changes["a_1"] == pytest.approx(changes["N"], rel=1e-12)
    assert changes["N"] == pytest.approx(3.2 / 2.943 - 1, rel=1e-6)
    assert changes["V"] is changes["m"] is changes["mu_s"] is None
    assert content["margins"]["stick_slip"] is False


def simulate(content):
    motion = ss.simulate(EXPONENTIAL, ss.Oscillator(c=1, **AT), t_end=2.0)
    assert content["motion"]["events"] == content_of(motion.events)
    assert content["periods"][-1] == pytest.approx(0.651445008)


def plane(content):
    found = ss.motion_map(EXPONENTIAL, x=("V", [0.5, 0.8]), y=("c", [1.0, 2.0, 3.0]), N=9.81, m=1.0, k=100.0)
    assert (content["y"]["name"], content["y"]["values"]) == ("c", [1.0, 2.0, 3.0])
    assert content["map"]["motion"] == [[cell.value for cell in row] for row in found.motion]


def tradeoff(content):
    rows = content["trades"]["criterion"]["rows"]
    errors = {(row["method"], row["setting"]): row["relative_error"] for row in rows}
    assert errors["plain lambdify", "array"] > 0.1 > 1e-14 > errors["stable function", "one value"]
    assert content["trades"]["criterion"]["point"]["V"] == 1e-4


def derive(content):
    at = content["operating_point"]
    assert at["law"]["values"]["alpha"] == pytest.approx(7 / 3)
    assert at["law"]["parameters"]["alpha"]["unit"] == "s/m"
    assert (at["numbers"]["N"], "N" in at["defaults"], at["typical"]) == (9.81, True, ["mu_s", "mu_m"])
    (row,) = content["criteria"]
    closed, quadrature, simulated = row["checks"]["rows"]
    form = ss.derive(ss.laws.exponential.typical(alpha="7/3"), "harmonic")
    with mpmath.workdps(50):
        for check in (closed, quadrature):  # all digits that are printed
            assert mpmath.almosteq(mpmath.mpf(check["value"]), form.evaluate(60, V="0.5", N="9.81"), rel_eps=1e-48)
    assert quadrature["relative_error"] < 1e-40
    assert simulated["seconds"] > 0
    assert {step["verdict"]["status"] for step in row["steps"]} == {"PROVED"}


def laws(content):
    assert [law["text"] for law in content["laws"]] == ["mu_s - a_1*v"]
    assert content["criteria"]["harmonic"]["expr"] == "N*a_1"
    assert content["criteria"]["harmonic"]["verdict"]["status"] == "PROVED"


JSON = {
    "laws linear": laws,
    "damping exponential": damping,
    "damping coulomb --all": comparison,
    "critical linear -p a_1=0.30(3) -c 3.2+/-0.1 --method orbit": margins,
    "simulate exponential -c 1 --t-end 2": simulate,
    "tradeoff exponential -V 1e-4": tradeoff,
    "map exponential --x V=0.5:0.8:2 --y c=1:3:3": plane,
    "derive exponential --criterion harmonic --steps -p alpha=7/3": derive,
}


@pytest.mark.parametrize("line", JSON)
def test_json(line, run):
    code, out, err = run(*line.split(), "--json")
    assert (code, err) == (0, "")
    found = read_json(out)
    assert found["format"] == 3, "programs that read it ask for the format"
    JSON[line](found)


def test_derive_without_values_or_a_closed_form(run):
    assert run("derive", "a - b*v")[2] == "\nno value for a, b: give -p a=... for a table of values\n"
    code, out, err = run("derive", "tanh(exp(a*v))", "-p", "a=1", "--time-limit", "0", "--json")
    (row,) = read_json(out)["criteria"]
    assert (code, err) == (1, f"error: {row['form']}\n")
    assert row["checks"]["rows"][0]["method"] == "quadrature, 50 digits"


@pytest.mark.thorough
def test_derive_writes_latex_of_measured_points(run, tmp_path):
    (tmp_path / "pin.csv").write_text(PIN)
    code, out, _ = run("derive", "--from-csv", "pin.csv", "--latex", "pin.tex", "--steps")
    assert code == 0
    form = ss.derive(ss.FrictionLaw.from_csv(tmp_path / "pin.csv"))
    assert f"{form(V=0.5, N=9.81):.9f}"[:8] in out
    text = (tmp_path / "pin.tex").read_text()
    assert text.count("\\begin{equation*}") == len(re.findall(r"^% (?:PROVED|CHECKED)", text, re.M)) >= 1
    code, _, err = run("derive", "--from-csv", "pin.csv", "-V", "0.7")
    assert (code, "measured up to v = 1.2 m/s, and its value at 1.4 m/s is needed" in err) == (2, True)
    assert run("derive", "--from-csv", "pin.csv", "-V", "0.7", "--extrapolate")[0] == 0


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
    expected = ss.pure_slip_damping(EXPONENTIAL, V=0.4, N=9.81, m=1, k=200, method="orbit")
    assert points[1]["threshold"]["value"] == pytest.approx(expected.value, rel=1e-12)


def test_export_of_several_criteria(run, tmp_path):
    line = "export exponential polynomial --criterion all --c a.c --json"
    content = read_json(run(*line.split())[1])
    assert [row["criterion"] for row in content["criteria"]] == list(ss.criteria.catalogue) * 2
    code, _, err = run("export", "tanh(exp(a*v))", "--latex", "b.tex", "--python", "b.py", "--time-limit", "0")
    assert (code, err[:7], (tmp_path / "b.py").exists()) == (1, "error: ", False)


def test_code_needs_the_values_of_shapes(run, tmp_path, monkeypatch):
    """One law is refused before it is derived; of the whole catalogue it is left out by name."""
    code, _, err = run("export", "stribeck", "--c", "a.c", "--latex", "a.tex")
    assert code == 2
    assert "delta of the law stribeck has no value" in err
    assert list(tmp_path.iterdir()) == []
    few = {name: ss.laws.catalogue[name] for name in ("linear", "stribeck")}
    monkeypatch.setattr(type(ss.laws), "values", lambda self: few.values(), raising=False)
    code, out, err = run("export", "--all", "--c", "a.c", "--latex", "a.tex")
    assert (code, out) == (0, "latex: 2 criteria in a.tex\nc: 1 criterion in a.c\n")
    assert err.count("no code: delta of the law stribeck") == 1
    text = (tmp_path / "a.c").read_text(encoding="utf-8")
    assert "ClosedForm: linear, least_squares, PROVED" in text
    assert "stribeck" not in text


def test_pictures_of_thresholds_and_of_a_law(run, tmp_path):
    """All methods over the belt speed, with the point where it was computed; a law with its typical values."""
    errors = ["-V", "0.50(2)", "-p", "mu_s=0.50+/-0.02"]
    code, _, err = run("damping", "exponential", *errors, "--plot", "plane.svg")
    assert (code, err) == (0, "")
    text = (tmp_path / "plane.svg").read_text(encoding="utf-8")
    for words in ("equilibrium", "least squares", "harmonic", "second order", "threshold", "95 % band", "0.5 m/s"):
        assert words in text, words
    assert "rest or stick-slip, by the initial condition" in text
    code, _, err = run("damping", "0.5 - 0.2*Min(v, 0.4)", "-V", "0.5", "--all", "--plot", "kink.svg")
    assert (code, err) == (0, "")
    assert "second order" not in (tmp_path / "kink.svg").read_text(encoding="utf-8")
    code, _, err = run("laws", "linear", "--plot", "law.svg")
    assert (code, err) == (0, "")
    assert "linear" in (tmp_path / "law.svg").read_text(encoding="utf-8")
    assert "--plot does nothing here" in run("laws", "--plot", "all.svg")[2]


@pytest.mark.parametrize(
    ("words", "command", "kind", "code"),
    [
        ("damping exponential -V 0.5 -N -1 --json", "damping", "InputError", 2),
        ("damping exponental -V 0.5 --json", "damping", "InputError", 2),
        ("derive --json --critereon x", "derive", "InputError", 2),
        ("dampng --json", "stickslip", "InputError", 2),
        ("damping exponential -V 0.5 -N 9.81 --time-limit 1e-9 --json", "damping", "OutOfTime", 1),
    ],
)
def test_an_error_is_an_object_where_json_is_asked_for(words, command, kind, code, run):
    assert run(*words.replace("--json", "").split())[:2] == (code, "")
    ended, out, err = run(*words.split())
    said = read_json(out)
    assert ended == said["error"]["exit_code"] == code
    assert (said["command"], said["error"]["type"]) == (command, kind)
    assert err.startswith(f"error: {said['error']['message'][:40]}")
