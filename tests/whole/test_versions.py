"""`.ci/versions` finds every Python, runs each, and fails where one of them does."""

import os
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest
from systems import needs_posix_shell

ROOT = Path(__file__).parents[2]
TOOLS = ("bash", "dirname", "mktemp", "rm", "sort", "awk", "mkdir", "cat", "chmod")
PYTHON = """#!/usr/bin/env bash
case $1 in
    -c) echo "{version} $0" ;;
    -m)
        mkdir -p "$3/bin"
        printf '#!/usr/bin/env bash\\necho installs "${{@: -1}}"' > "$3/bin/pip"
        printf '#!/usr/bin/env bash\\necho tests {version} "$@"; exit {code}' > "$3/bin/python"
        chmod +x "$3"/bin/*
esac
"""
"""An interpreter that knows its version, and makes an environment whose tests end as they are told."""


def versions(folder, pythons, *arguments):
    """Run the script where there are these interpreters, and nothing else."""
    commands = folder / "bin"
    commands.mkdir()
    for tool in (*TOOLS, "env"):
        (commands / tool).symlink_to(shutil.which(tool))
    for name, (version, code) in pythons.items():
        (commands / name).write_text(PYTHON.format(version=version, code=code) if version else "#!/bin/false\n")
        (commands / name).chmod(0o755)
    command = [str(commands / "bash"), str(ROOT / ".ci/versions"), *arguments]
    environment = {"PATH": str(commands), "TMPDIR": str(folder)}
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60, check=False)


@needs_posix_shell
@pytest.mark.parametrize("fails", [None, "3.11.9", "3.13.0"])
def test_each_python_is_run_once_and_one_that_fails_is_told(fails, tmp_path):
    have = {"python3": "3.12.4", "python3.10": None, "python3.11": "3.11.9", "python3.12": "3.12.4"}
    have |= {
        "python3.13": "3.13.0",
        "python3.110": "3.13.10" if fails is None else None,
        "python3-config": "9.9.9",
    }
    done = versions(tmp_path, {name: (v, int(v == fails)) for name, v in have.items()}, "-k", "some")
    newest = "3.13.10" if fails is None else "3.13.0"
    run = [line.split()[1:] for line in done.stdout.splitlines() if line.startswith("tests ")]
    assert run == [[version, "-m", "pytest", "-k", "some"] for version in ("3.11.9", "3.12.4", newest)]
    assert done.stdout.count("installs .[test]") == 3
    assert done.returncode == (fails is not None)
    well = " ".join(version for version in ("3.11.9", "3.12.4", newest) if version != fails)
    assert done.stdout.splitlines()[-1] == f"passed: {well}; failed: {fails or 'none'}"
    assert [entry.name for entry in tmp_path.iterdir()] == ["bin"]  # no environment is left


@needs_posix_shell
def test_no_python_is_a_failure(tmp_path):
    done = versions(tmp_path, {"python3": (None, 0)})
    assert (done.returncode, done.stdout) == (1, "no Python from 3.11 up, neither by pyenv nor on PATH\n")


def test_what_is_declared_is_what_is_run_on_three_systems():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    declared = [
        c.split(" :: ")[-1] for c in project["classifiers"] if c.startswith("Programming Language :: Python :: 3.")
    ]
    workflow = (ROOT / ".github/workflows/tests.yml").read_text(encoding="utf-8")
    listed = ", ".join(f'"{version}"' for version in declared)
    assert f"python: [{listed}]" in workflow
    assert project["requires-python"] == f">={declared[0]}"
    assert "system: [ubuntu-latest, macos-latest, windows-latest]" in workflow
    assert 'install -e ".[test]"' in workflow
    for path in (ROOT / ".ci").iterdir():
        assert os.name == "nt" or os.access(path, os.X_OK)
