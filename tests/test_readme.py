"""The README's code and commands are run, and print what it says."""

import contextlib
import io
import os
import re
import shlex
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from paper_checks.claims import CLAIMS

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text()
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```", README, re.M | re.S)
TIME = re.compile(r"\b[\d.]+ (ns|us|ms|s)\b")


def blocks(language):
    return [text for kind, text in BLOCKS if kind == language]


def without_times(text):
    """Replace measured times, the only thing that differs between runs."""
    return [TIME.sub("TIME", line).rstrip() for line in text.strip().splitlines()]


@pytest.mark.parametrize("code", blocks("python"), ids=lambda code: code.splitlines()[0][:40])
def test_python_blocks_print_what_they_say(code):
    """A comment that is a line of its own is a line of output."""
    expected = re.findall(r"^# (.*)$", code, re.M)
    stream = io.StringIO()
    with contextlib.redirect_stdout(stream):
        exec(compile(code, "README.md", "exec"), {})
    assert stream.getvalue().splitlines() == expected


SESSIONS = [
    (command, output)
    for text in blocks("console")
    for command, output in re.findall(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", text, re.M)
]


@pytest.mark.parametrize(("command", "output"), SESSIONS, ids=[command for command, _ in SESSIONS])
def test_console_blocks_print_what_they_say(command, output, tmp_path):
    program, *arguments = shlex.split(command)
    start = {
        "stickslip": [sys.executable, "-c", "from stickslip_sym.cli.program import main; main()"],
        "python": [sys.executable],
    }[program]
    # Away from the repository, for a command may write files.
    done = subprocess.run(
        [*start, *arguments],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert without_times(done.stdout) == without_times(output)


def test_the_readme_has_what_the_tests_run():
    assert blocks("python")
    assert SESSIONS
    setups = [line for text in blocks("sh") for line in text.splitlines()]
    assert len(setups) == 2
    assert setups[0].endswith("stickslip derive exponential")
    assert setups[1].endswith("pytest")


def test_the_claim_table_says_what_is_on_record():
    rows = re.findall(r"^\| ([A-Z]\d[^|]*) \| ([^|]*) \|", README, re.M)
    told = {claim: verdict for ids, verdict in rows for claim in ids.split(", ")}
    on_record = {claim.id: claim.outcome.value.split(" with a ")[-1] for claim in CLAIMS.values()}
    assert told == {claim: verdict.replace("qualification", "qualified") for claim, verdict in on_record.items()}
    counts = Counter(told.values())
    assert f"{len(told)} of them, of which {counts['reproduced']} are reproduced" in README
