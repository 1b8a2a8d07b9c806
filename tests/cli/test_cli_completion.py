"""What a shell completes: names of laws, criteria and methods, options, and nothing slow is imported for it."""

import os
import shutil
import subprocess
import sys

import pytest
from systems import WINDOWS

import stickslip_sym as ss
from stickslip_sym.cli.shared import completion
from stickslip_sym.motion.thresholds import rungs


def test_completed_names_are_those_there_are():
    assert completion.complete_law("") == list(ss.laws.catalogue)
    assert completion.complete_criterion("") == list(ss.criteria.catalogue)
    assert completion.complete_criterion_or_all("a") == ["all"]
    assert completion.complete_method("") == [*rungs.rungs(), "auto"]


def completed(kind, line):
    """Ask for completions as a shell's script does."""
    command = [sys.executable, "-X", "importtime", "-c", "from stickslip_sym.cli.program import main; main()"]
    asked = {
        "bash": {"COMP_WORDS": line, "COMP_CWORD": str(len(line.split()) - 1)},
        "zsh": {"_TYPER_COMPLETE_ARGS": line},
        "fish": {"_TYPER_COMPLETE_ARGS": line, "_TYPER_COMPLETE_FISH_ACTION": "get-args"},
    }[kind]
    environment = os.environ | asked | {"_STICKSLIP_COMPLETE": f"complete_{kind}"}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=60, check=False)
    slow = {"sympy", "numpy", "scipy", "mpmath"}
    assert slow.isdisjoint(line.rsplit("|", 1)[-1].strip() for line in done.stderr.splitlines())
    return done.stdout


@pytest.mark.parametrize(
    ("kind", "line", "expected"),
    [
        ("bash", "stickslip da", "damping"),
        ("bash", "stickslip damping --al", "--all"),
        ("bash", "stickslip damping linear --method sec", "second_order"),
        ("bash", "stickslip derive linear --criterion har", "harmonic"),
        ("zsh", "stickslip laws exponential_v", "exponential_viscous"),
        ("fish", "stickslip damping exponential_v", "exponential_viscous"),
    ],
)
def test_a_shell_completes_and_nothing_slow_is_imported(kind, line, expected):
    out = completed(kind, line)
    assert expected in out
    assert "equilibrium" not in out


@pytest.mark.parametrize("kind", ["bash", "zsh", "fish"])
def test_the_script_of_completion_is_shown(kind):
    program = shutil.which(kind)
    command = [sys.executable, "-c", "from stickslip_sym.cli.program import main; main()"]
    environment = os.environ | {"_STICKSLIP_COMPLETE": f"source_{kind}"}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=60, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert f"complete_{kind}" in done.stdout
    if program is not None and not WINDOWS:  # Windows has a bash of its own, of another system
        checked = subprocess.run([program, "-n"], input=done.stdout, text=True, timeout=60, check=False)
        assert checked.returncode == 0
