"""The code and the commands of every README are run, and print what it says."""

import contextlib
import io
import os
import re
import shlex
import subprocess
import sys
import tomllib
from collections import Counter
from pathlib import Path

import pytest
from commands import inside

import stickslip_sym as ss
from paper_checks.claims import CLAIMS

ROOT = Path(__file__).parents[2]
READMES = {
    place: (ROOT / place / "README.md").read_text(encoding="utf-8")
    for place in (".", "derivations", "paper_checks", "stickslip_sym")
}
TIME = re.compile(r"\b[\d.]+ (ns|us|ms|s)\b")
PATH = re.compile(r"`([\w./]+(?:/|\.py|\.md|\.cff))`|\]\(([\w./]+)\)")


def blocks(language, places=READMES):
    found = {place: re.findall(rf"^```{language}\n(.*?)^```", READMES[place], re.M | re.S) for place in places}
    return [(place, text) for place, texts in found.items() for text in texts]


def without_times(text):
    """Replace measured times, the only thing that differs between runs."""
    return [TIME.sub("TIME", line).rstrip() for line in text.strip().splitlines()]


@pytest.mark.parametrize(("place", "code"), blocks("python"))
def test_python_blocks_print_what_they_say(place, code):
    """A comment that is a line of its own is a line of output."""
    expected = re.findall(r"^# (.*)$", code, re.M)
    stream = io.StringIO()
    with contextlib.redirect_stdout(stream):
        exec(compile(code, f"{place}/README.md", "exec"), {})
    assert stream.getvalue().splitlines() == expected


SESSIONS = [
    (command, output)
    for _, text in blocks("console")
    for command, output in re.findall(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", text, re.M)
]


@pytest.mark.parametrize(("command", "output"), SESSIONS, ids=[command for command, _ in SESSIONS])
def test_console_blocks_print_what_they_say(command, output, tmp_path):
    """Away from the repository, for a command may write files."""
    program, *arguments = shlex.split(command)
    assert program in ("stickslip", "python")
    if program == "stickslip":
        done = inside(*arguments, cwd=tmp_path)
    else:
        done = subprocess.run(
            [sys.executable, *arguments],
            capture_output=True,
            text=True,
            cwd=tmp_path,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
            timeout=120,
            check=False,
        )
    assert done.returncode == 0, done.stderr
    assert without_times(done.stdout) == without_times(output)


def test_the_readmes_have_what_the_tests_run():
    assert {place for place, _ in blocks("python")} == {".", "paper_checks", "stickslip_sym"}
    assert {place for place, _ in blocks("console")} == {".", "derivations", "stickslip_sym"}
    setups = [line for _, text in blocks("sh", ["."]) for line in text.splitlines()]
    assert len(setups) == 2
    assert setups[0].endswith("stickslip derive exponential")
    assert setups[1].endswith("pytest")


def test_the_top_readme_is_short():
    assert len(READMES["."].splitlines()) <= 150


@pytest.mark.parametrize("place", READMES)
def test_files_that_a_readme_names_are_there(place):
    """From its own folder, or from the top."""
    named = {code or link for code, link in PATH.findall(READMES[place])}
    assert named
    assert {name for name in named if not any((base / name).exists() for base in (ROOT / place, ROOT))} == set()


def test_the_claim_table_says_what_is_on_record():
    rows = re.findall(r"^\| ([A-Z]\d[^|]*) \| ([^|]*) \|", READMES["paper_checks"], re.M)
    told = {claim: verdict for ids, verdict in rows for claim in ids.split(", ")}
    on_record = {claim.id: claim.outcome.value.split(" with a ")[-1] for claim in CLAIMS.values()}
    assert told == {claim: verdict.replace("qualification", "qualified") for claim, verdict in on_record.items()}
    counts = Counter(told.values())
    for place in (".", "paper_checks"):
        assert f"{len(told)} of them, of which {counts['reproduced']} are reproduced" in READMES[place]


def test_the_citation_has_what_the_format_requires():
    """Its plain subset of YAML: mappings of names to scalars, and lists of those."""
    lines = (ROOT / "CITATION.cff").read_text(encoding="utf-8").splitlines()
    shape = re.compile(r"(?:  )*(?:- )?(?:[a-z-]+:(?: [^\s:#&*!|>'\"%@`{}\[\]][^:#]*)?|[\w -]+)")
    assert [line for line in lines if not shape.fullmatch(line)] == []
    told = dict(re.findall(r"^([a-z-]+):(?: (.+))?$", "\n".join(lines), re.M))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert {"cff-version", "message", "title", "authors", "references"} <= set(told)
    assert (told["cff-version"], told["type"]) == ("1.2.0", "software")
    assert (told["title"], told["license"]) == (project["name"], project["license"])
    assert (told["version"], told["abstract"]) == (ss.__version__, project["description"])
    assert [f"  - name: {author['name']}" in lines for author in project["authors"]] == [True]
    assert [f"  - {keyword}" in lines for keyword in project["keywords"]] == [True] * len(project["keywords"])
