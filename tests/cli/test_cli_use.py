"""The command line in use: what it suggests, and what other programs get from it."""

import dataclasses
import math
import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from commands import read_json, run, shell
from systems import needs_posix_shell

import stickslip_sym as ss
from stickslip_sym.cli import program, tradeoff
from stickslip_sym.cli.shared import json_output, options, reading
from stickslip_sym.cli.shared.law import Description, LawOptions
from stickslip_sym.comparison.ways import Way
from stickslip_sym.motion.thresholds import rungs

COMMANDS = {
    "laws": ["--json"],
    "derive": ["coulomb"],
    "fit": ["disc.csv", "linear"],
    "damping": ["linear", "--json"],
    "critical": ["mu_s", "exponential", "-c", "2"],
    "simulate": ["linear", "--t-end", "1"],
    "map": ["linear", "--x", "V=1:1:1", "--y", "c=1:1:1"],
    "study": ["linear", "-c", "1", "-o", "study.html"],
    "tradeoff": ["coulomb_viscous", "--criterion", "equilibrium"],
    "export": ["coulomb", "--python", "/dev/stdout" if Path("/dev/stdout").exists() else "coulomb.py"],
}  # what makes each command do its work, quickly
DISC = "v [mm/s],mu\n" + "".join(f"{v},{0.3 + 10 / (50 + v):.3f}\n" for v in range(5, 900, 30))
"""Measured friction, for those that read a file."""


def registered():
    return {(info.name or info.callback.__name__): info for info in program.app.registered_commands}


def test_every_command_is_tried_here():
    assert set(registered()) == set(COMMANDS)
    assert {info.cls for info in registered().values()} == {reading.Command}


def test_every_command_of_one_law_has_all_options_of_a_law_and_a_scene():
    commands = typer.main.get_command(program.app).commands
    one_law = [name for name, command in commands.items() if any("--from-csv" in p.opts for p in command.params)]
    assert one_law == ["derive", "damping", "critical", "simulate", "map", "study", "tradeoff"]
    wanted = {field.name for group in (LawOptions, options.SceneOptions) for field in dataclasses.fields(group)}
    for name in one_law:
        assert wanted <= {parameter.name for parameter in commands[name].params}
    description = {field.name for field in dataclasses.fields(Description)}
    assert description <= {parameter.name for parameter in commands["export"].params}


@pytest.mark.parametrize("name", COMMANDS)
def test_the_example_in_the_help_works(name, monkeypatch, capsys, tmp_path):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "disc.csv").write_text(DISC)
    if name == "fit":
        pytest.importorskip("matplotlib")
    _, help_text, _ = run(monkeypatch, capsys, name, "--help")
    words = shlex.split(help_text.split("Example: ")[1].split("\n\n")[0])
    assert words[:2] == ["stickslip", name]
    if name in ("map", "tradeoff"):  # seconds of work; that the line is read is enough
        monkeypatch.setattr(LawOptions, "bound", _reached)
        with pytest.raises(LookupError, match="reached"):
            run(monkeypatch, capsys, *words[1:])
    else:
        code, out, err = run(monkeypatch, capsys, *words[1:])
        assert (code, err) == (0, "")
        assert out


def _reached(*_, **__):
    raise LookupError("reached")


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("dampings linear", "Did you mean 'damping'?"),
        ("damping linear --metod orbit", "--method"),
        ("derive linear --criterium harmonic", "--criterion"),
        ("damping linear -v 1", "No such option: -v. Did you mean -V? See: stickslip damping --help"),
        ("damping linear --jsn", "--json"),
        ("damping hyperbolc", "did you mean 'hyperbolic'?"),
        ("damping exponential -p alfa=3", "did you mean 'alpha'?"),
        ("damping exponential --method harmonc", "did you mean 'harmonic'?"),
        ("tradeoff exponential --criterion least_square", "did you mean 'least_squares'?"),
        ("laws hyperbolc --json", "did you mean 'hyperbolic'?"),
    ],
)
def test_a_typo_is_told_what_was_meant(line, words, monkeypatch, capsys):
    code, out, err = run(monkeypatch, capsys, *line.split())
    assert (code, out) == (2, "")
    assert words in err
    assert len(err.splitlines()) == 1


@pytest.mark.parametrize("name", ["damping", "tradeoff", "derive", "simulate"])
def test_an_option_is_given_once(name, monkeypatch, capsys):
    code, out, err = run(monkeypatch, capsys, name, "linear", "-V", "1", "-V2")
    assert (code, out, err) == (2, "", "error: -V is given twice; give it once\n")


def test_flags_and_parameters_may_be_repeated(monkeypatch, capsys):
    line = "damping linear -p a_1=1 -p mu_s=1 --json --json -V 1"
    assert run(monkeypatch, capsys, *line.split())[0] == 0


def test_laws_as_json(monkeypatch, capsys):
    _, out, _ = run(monkeypatch, capsys, "laws", "--json")
    laws = {law["name"]: law for law in read_json(out)["laws"]}
    assert list(laws) == list(ss.laws.catalogue)
    assert laws["exponential"]["parameters"]["alpha"] == {
        "value": None,
        "text": None,
        "typical": "3",
        "unit": "s/m",
        "meaning": "decay rate of the coefficient",
    }
    _, out, _ = run(monkeypatch, capsys, "laws", "linear", "--json")
    (law,) = read_json(out)["laws"]
    assert law["criteria"]["harmonic"] == {"formula": "N*a_1", "unit": "kg/s", "status": "PROVED"}


def test_derive_as_json(monkeypatch, capsys):
    line = "derive exponential --criterion harmonic --steps --json -p alpha=7/3"
    code, out, err = run(monkeypatch, capsys, *line.split())
    assert (code, err) == (0, "")
    said = read_json(out)
    assert (said["format"], said["version"], said["command"]) == (1, ss.__version__, "derive")
    assert said["law"]["parameters"]["alpha"]["text"] == "7/3"
    assert said["scene"]["N"] == {"value": 9.81, "unit": "N", "text": "9.81"}
    (one,) = said["criteria"]
    assert (one["criterion"], one["unit"], one["status"]) == ("harmonic", "kg/s", "PROVED")
    closed, quadrature, simulated = one["checks"]
    form = ss.derive(ss.laws.exponential.typical(alpha="7/3"), "harmonic")
    assert closed["c"]["value"] == pytest.approx(form(V=0.5, N=9.81), rel=1e-14)
    assert len(closed["c"]["text"]) > 40
    assert quadrature["relative_difference"] < 1e-40
    assert simulated["seconds"] > 0
    assert {step["status"] for step in one["steps"]} == {"PROVED"}


def test_derive_without_a_closed_form_as_json(monkeypatch, capsys):
    line = "derive tanh(exp(a*v)) -p a=1 --time-limit 0 --json"
    code, out, err = run(monkeypatch, capsys, *line.split())
    (one,) = read_json(out)["criteria"]
    assert code == 1
    assert err.startswith("error: ")
    assert one["formula"] is None
    assert one["reason"] in err
    assert one["checks"][0]["method"] == "quadrature, 50 digits"


def test_damping_as_json(monkeypatch, capsys):
    line = "damping exponential -V 0.5 -N 9.81 -m 1 -k 100 --json"
    _, out, _ = run(monkeypatch, capsys, *line.split())
    (one,) = read_json(out)["thresholds"]
    law = ss.laws.exponential.typical()
    expected = ss.pure_slip_damping(law, V=0.5, N=9.81, m=1.0, k=100.0)
    assert (one["c"], one["method"]) == ({"value": expected.value, "unit": "kg/s"}, expected.method)
    _, out, _ = run(monkeypatch, capsys, "damping", "coulomb", "-m1", "-k100", "--all", "--json")
    found = read_json(out)["thresholds"]
    assert [one["method"] for one in found] == list(rungs.rungs())
    assert [("reason" in one["c"], one["c"]["value"] is None) for one in found].count((True, True)) >= 1
    assert all(("reason" in one["c"]) == (one["c"]["value"] is None) for one in found)


def test_tradeoff_as_json(monkeypatch, capsys):
    _, out, _ = run(monkeypatch, capsys, "tradeoff", "exponential", "-V", "1e-4", "--json")
    said = read_json(out)
    ways = {way["way"]: way for way in said["ways"]}
    assert ways["plain lambdify, array"]["relative_error"] > 0.1
    assert ways["stable function, one value"]["relative_error"] < 1e-14
    assert said["criterion"] == "least_squares"
    assert ways["plain lambdify, array"]["dominated_by"] == ["stable function, array"]
    assert [*tradeoff.as_json_of(Way("none")).values()] == ["none", None, None, None, []]


def test_simulate_as_json(monkeypatch, capsys):
    _, out, _ = run(monkeypatch, capsys, "simulate", "exponential", "-c", "1", "--t-end", "2", "--json")
    said = read_json(out)
    assert said["outcome"] == "finished"
    assert said["periods"][-1] == {"value": pytest.approx(0.651445008), "unit": "s"}
    assert [event["begins"] for event in said["events"][:3]] == ["stick", "slip, slower than the belt", "stick"]


def test_map_as_json(monkeypatch, capsys):
    _, out, _ = run(monkeypatch, capsys, "map", "exponential", "--x", "V=0.5:0.8:2", "--y", "c=1:3:3", "--json")
    said = read_json(out)
    assert said["y"] == {"quantity": "c", "unit": "kg/s", "values": [1.0, 2.0, 3.0]}
    assert [row[0] for row in said["motion"]] == ["stick-slip", "stick-slip", "damped slip"]
    assert [row[0] for row in said["rest"]] == [False, True, True]


def test_json_has_no_nan():
    assert [json_output.number(value) for value in (math.nan, math.inf, -math.inf, None, 1)] == [None] * 4 + [1.0]
    with pytest.raises(ValueError, match="not JSON compliant"):
        json_output.echo("laws", value=math.nan)


def test_the_version(monkeypatch, capsys):
    assert run(monkeypatch, capsys, "--version") == (0, f"stickslip_sym {ss.__version__}\n", "")


SLOW = ("model.laws.find", "model.measured.measurements.read_measurements")


@pytest.mark.parametrize("name", COMMANDS)
def test_ctrl_c_ends_every_command_quietly(name, monkeypatch, capsys, tmp_path):
    def interrupt(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.chdir(tmp_path)
    (tmp_path / "disc.csv").write_text(DISC)
    for function in ("cli.shared.json_output.echo", "core.numbers.exact", "model.law.FrictionLaw.typical", *SLOW):
        monkeypatch.setattr(f"stickslip_sym.{function}", interrupt)
    code, out, err = run(monkeypatch, capsys, name, *COMMANDS[name])
    assert (code, out, err.strip()) == (130, "", "")


WRITERS = """
import gc, os, sys, lmfit, stickslip_sym.comparison.crosscheck, stickslip_sym.comparison.study.parts
from stickslip_sym.cli.program import main
gc.freeze()  # what was imported, once for all: else the collector of each child copies it
for line in sys.argv[1:]:
    if (child := os.fork()) == 0:
        sys.argv = ["stickslip", *line.split()]
        main()
    print(line, os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), file=sys.stderr)
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_closed_pipe_ends_every_command_quietly(tmp_path):
    """The reader is gone before the command writes: it says nothing, and its exit code tells."""
    (tmp_path / "disc.csv").write_text(DISC)
    lines = [" ".join([name, *COMMANDS[name]]) for name in COMMANDS]
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-c", WRITERS, *lines]
    done = subprocess.run(
        command, stdout=writer, stderr=subprocess.PIPE, text=True, timeout=60, check=False, cwd=tmp_path
    )
    os.close(writer)
    assert done.stderr == "".join(f"{line} 1\n" for line in lines)


@needs_posix_shell
@pytest.mark.parametrize(
    ("forced", "arguments"),
    [("A=1", "laws"), ("FORCE_COLOR=1 CLICOLOR_FORCE=1", "derive coulomb")],
    ids=["nothing asked", "colours asked for"],
)
def test_files_get_no_colours(forced, arguments, tmp_path):
    """Neither help nor results, nor the progress on stderr."""
    start = f"unset NO_COLOR FORCE_COLOR CLICOLOR_FORCE; export {forced}"
    done = shell(f"{start}; $RUN {arguments} 2>&1 | cat; $RUN --help 2>&1 | cat", tmp_path)
    assert "coulomb" in done.stdout
    assert "Usage: stickslip" in done.stdout
    assert "\x1b" not in done.stdout
