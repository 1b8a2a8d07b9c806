"""Help and completion answer at once: they load nothing that computes."""

import json
import os
import subprocess
import sys

import pytest

import stickslip_sym as ss

_LARGE = ("sympy", "numpy", "scipy", "mpmath", "uncertainties", "matplotlib", "numba")
_PROGRAM = f"""
import json, sys
from stickslip_sym.cli.program import program
try:
    program.main(prog_name="stickslip", args=sys.argv[1:] or None)
except SystemExit:
    pass
print(json.dumps([name for name in {_LARGE} if name in sys.modules]))
"""


def run_apart(*arguments, **environment):
    """Return what a process of its own prints, and the large packages that it loaded."""
    command = [sys.executable, "-c", _PROGRAM, *arguments]
    done = subprocess.run(
        command, capture_output=True, text=True, env=os.environ | environment, timeout=60, check=True
    )
    *lines, loaded = done.stdout.splitlines()
    return lines, json.loads(loaded)


def completed(*words):
    """Return what bash is offered for the last of the words after the program's name."""
    line = " ".join(["stickslip", *words])
    asked = {"_STICKSLIP_COMPLETE": "bash_complete", "COMP_WORDS": line, "COMP_CWORD": str(len(words))}
    lines, loaded = run_apart(**asked)
    assert loaded == []
    return [text.partition(",")[2] for text in lines]


def test_help_lists_every_command_with_the_first_words_of_its_own():
    from stickslip_sym.cli.program import COMMANDS, program

    lines, loaded = run_apart("--help")
    assert loaded == []
    commands = lines[lines.index("Commands:") + 1 :]
    assert [line.split()[0] for line in commands] == list(COMMANDS)
    for name, line in zip(COMMANDS, commands, strict=True):
        own = " ".join(program.get_command(None, name).help.split())
        assert own.startswith(line.split(maxsplit=1)[1].removesuffix("..."))


def test_names_are_completed():
    assert completed("cri") == ["critical"]
    assert completed("damping", "exp") == [name for name in ss.laws if name.startswith("exp")]
    assert completed("damping", "exponential", "-p", "a") == ["alpha="]
    assert completed("critical", "tanh", "--of", "") == [*"VNmkc", *ss.laws["tanh"].parameters]
    assert "--criterion" in completed("derive", "--c")


@pytest.mark.parametrize("command", ["derive", "export"])
def test_criteria_stand_in_the_help(command, run):
    text = " ".join(run(command, "--help")[1].split())
    assert ", ".join(ss.criteria.catalogue) in text
