"""The law of a command: its description, measured points, doubts, and messages that name options."""

import ast
import re
from pathlib import Path

import pytest
from commands import read_json, run

import stickslip_sym as ss
from stickslip_sym.cli.shared.words import in_options

POINTS = "v [m/s],mu\n0,0.5\n0.1,0.4\n0.3,0.3\n1.2,0.25\n"
FORMULA = "a - b*v + d*v^2"
DESCRIBED = ["--static", "0.6", "--name", "pin", "--unit", "b=s/m", "--source", "bench 4", "-p", "a=0.5", "-p",
             "b=0.3", "-p", "d=0.1"]  # fmt: skip
TAKES_A_LAW = ("derive", "damping", "simulate", "map", "tradeoff")
WITH_JSON = {
    "derive": ["--criterion", "equilibrium"],
    "damping": ["--method", "equilibrium"],
    "simulate": ["--t-end", "0.1"],
    "map": ["--x", "V=0.5:0.5:1", "--y", "c=9:9:1"],
    "tradeoff": ["--criterion", "equilibrium"],
}


@pytest.mark.parametrize("name", TAKES_A_LAW)
def test_a_formula_is_described_wherever_it_is_a_law(name, monkeypatch, capsys):
    code, out, err = run(monkeypatch, capsys, name, FORMULA, *DESCRIBED, *WITH_JSON[name], "--json")
    assert (code, err) == (0, "")
    law = read_json(out)["law"]
    assert (law["name"], law["source"], law["parameters"]["b"]["unit"]) == ("pin", "bench 4", "s/m")
    assert law["static"] == "3/5"


@pytest.mark.parametrize("name", ["derive", "damping", "simulate", "map"])
def test_every_command_reads_measured_points(name, monkeypatch, capsys, tmp_path):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "disc.csv").write_text(POINTS)
    line = [name, "--from-csv", "disc.csv", "--static", "0.6", *WITH_JSON[name], "--json"]
    understood = "4 rows, v in m/s, mu from column 2\n"
    code, out, err = run(monkeypatch, capsys, *line)
    assert (code, err) == (0, understood)
    assert (read_json(out)["law"]["name"], read_json(out)["law"]["static"]) == ("disc", "3/5")
    (tmp_path / "disc.csv").write_text(POINTS.replace("m/s", "furlong/s"))
    code, out, err = run(monkeypatch, capsys, *line)
    assert (code, out) == (2, "")
    assert "line 1, column 1, 'v [furlong/s]': the unit 'furlong/s' is not known" in err
    (tmp_path / "disc.csv").write_text(POINTS.replace("\n0,", "\n0.01,"))
    code, out, err = run(monkeypatch, capsys, *line)
    assert (code, out) == (2, "")
    assert "add a point there, or give --extrapolate" in err
    code, out, err = run(monkeypatch, capsys, *line, "--extrapolate")
    said = "warning: nothing was measured below v = 0.01 m/s; mu is held there at 0.5, without slope, and mu(0+)"
    assert (code, err) == (0, f"{understood}{said} is this value\n")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("damping exponential --name q", "--name belongs to a formula or to --from-csv: exponential has its own"),
        ("damping exponential --unit alpha=s/m", "--unit belongs to the parameters of a formula or of --static"),
        ("damping exponential --static mu_0 --unit alpha=1", "the parameter 'alpha' has its description already"),
        ("damping a-b*v --unit b", "write for example --unit alpha=s/m"),
        ("damping a-b*v --unit b=furlong", "'furlong' is not a unit"),
        ("damping a-b*v --static 0.6+v", "the static coefficient is one number"),
        ("export exponential linear --static 0.6 --latex f", "--static belongs to one law; give one LAW"),
        ("simulate", "no law: give a name"),
        ("map a-b*v --x V=1:1:1 --y c=1:1:1 --extrapolate", "--extrapolate belongs to --from-csv"),
        # what Python's users are told otherwise
        ("damping a-b*v", "the law has no value for a, b; give -p a=... -p b=..."),
        ("map a-b*v --x V=1:1:1 --y c=1:1:1", "give each by -p NAME=VALUE, or make one an axis"),
        ("derive a+b*v -p b=-1", "write the formula with -b, and give a positive value, if any sign is meant"),
        ("derive mu_s-a*vr", "which is v; write v. If it is a parameter, say its unit: --unit vr=..."),
        ("damping linear --method orbit", "--method orbit needs the mass m"),
        ("damping Abs(v-0.3) -m 1 -k 100 --method orbit", "try --method simulation"),
        ("derive e^(-v)", "write exp(x) for a power of Euler's number"),
    ],
)
def test_options_of_a_law_and_messages_name_options(arguments, words, monkeypatch, capsys):
    code, out, err = run(monkeypatch, capsys, *arguments.split())
    assert code != 0
    assert out == ""
    assert words in err


def test_a_doubt_is_a_line(monkeypatch, capsys):
    line = "damping a-b*v -p a=0.1 -p b=0.5 -m 1 -k 100 --all"
    code, _, err = run(monkeypatch, capsys, *line.split())
    assert code == 0
    assert err.startswith("warning: mu = -0.4 is negative at the slip speed v = 1 m/s; ")
    assert len(err.splitlines()) == 1
    axes = ["--x", "b=0.01:0.5:2", "--y", "c=9:9:1", "-p", "a=0.1"]
    code, _, err = run(monkeypatch, capsys, "map", "a - b*v", *axes)
    assert (code, err.count("warning: mu = ")) == (0, 1)


@pytest.mark.parametrize("name", ["simulate", "map"])
def test_csv_replaces_nothing_in_silence(name, monkeypatch, capsys, tmp_path):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "points.csv"
    path.write_text(POINTS)
    line = [name, "coulomb", *WITH_JSON[name], "--csv", "points.csv"]
    code, out, err = run(monkeypatch, capsys, *line)
    assert (code, out, path.read_text()) == (2, "", POINTS)
    assert "'points.csv' exists, and --csv writes: name another file, or add --overwrite" in err
    assert run(monkeypatch, capsys, *line, "--overwrite")[0] == 0
    assert path.read_text() != POINTS
    assert run(monkeypatch, capsys, *line[:-1], "new.csv")[0] == 0


NEVER = {"positive", "alpha"}  # an argument of Parameter, which no command takes, and an option's NAME=UNIT


def test_messages_of_python_are_turned_into_options():
    """No error's text names an argument of Python's once it has been turned."""
    python = re.compile(r"(?<!-p )(?<!--unit )\b([a-z_]{3,})=(?!=)|law\.bind|Parameter\(|\bsimulate\(\)")
    turned = 0
    for path in Path(ss.__file__).parent.rglob("*.py"):
        raised = [node.exc for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Raise)]
        for call in (node for node in raised if isinstance(node, ast.Call) and node.args):
            message = _shown(call.args[0])
            turned += message != in_options(message)
            left = [match for match in python.finditer(in_options(message)) if match[1] not in NEVER]
            assert left == [], (path.name, in_options(message))
    assert turned > 10


def _shown(node):
    """Return the text of a message, with something in each gap."""
    if isinstance(node, ast.Constant):
        return str(node.value)
    if isinstance(node, ast.JoinedStr):
        return "".join(map(_shown, node.values))
    return "'x'" if isinstance(node, ast.FormattedValue) and node.conversion == ord("r") else "x"
