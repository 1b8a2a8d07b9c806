"""The command as a process: interrupts, pipes, full disks, colours, completion."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from commands import shell, started
from systems import WINDOWS, needs_posix_shell


def _is_gone(child):
    """Whether a process is no more, or dead and not yet buried by the system."""
    try:
        return "(zombie)" in Path(f"/proc/{child}/status").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return True


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="needs /proc to see a process's children")
def test_ctrl_c_says_so_and_leaves_nothing_behind(tmp_path):
    """Interrupted while SymPy's integrator runs in its own process."""
    with started("derive", "andersson", "--save", "kept.json", "--latex", "kept.tex", cwd=tmp_path) as process:
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
        deadline = time.monotonic() + 60
        while not (integrators := children.read_text().split()) and time.monotonic() < deadline:
            time.sleep(0.05)
        assert integrators
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=30)
    assert (process.returncode, out, err.strip()) == (130, "", "interrupted")
    while not all(map(_is_gone, integrators)) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert all(map(_is_gone, integrators))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["derive", "damping", "critical", "simulate", "study"])
def test_interrupt_ends_a_command(name, run, monkeypatch):
    def interrupt(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("stickslip_sym.model.law.FrictionLaw.typical", interrupt)
    code, out, err = run(name, "linear", "-c", "1") if name in ("critical", "study") else run(name, "linear")
    assert (code, out, err.strip()) == (130, "", "interrupted")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
@pytest.mark.parametrize("arguments", ["laws", "--help"])
def test_full_disk_is_one_line(arguments, tmp_path):
    done = shell(f"$RUN {arguments} > /dev/full", tmp_path)
    assert done.returncode == 1
    assert done.stderr == "error: cannot write the output: No space left on device\n"


@needs_posix_shell
@pytest.mark.parametrize("arguments", ["laws --json", "damping linear --json"])
def test_closed_pipe_ends_quietly(arguments, tmp_path):
    done = shell(f"$RUN {arguments} | head -0", tmp_path)
    assert (done.stdout, done.stderr) == ("", "")


@needs_posix_shell
@pytest.mark.parametrize("sink", ["| cat", "> out.txt; code=$?; cat out.txt; exit $code"])
def test_latex_to_standard_output_loses_nothing(sink, tmp_path):
    done = shell(f"$RUN derive coulomb --latex /dev/stdout {sink}", tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("% ClosedForm: coulomb")
    assert "event-driven threshold" in done.stdout


@needs_posix_shell
def test_files_get_no_colours(tmp_path):
    """Neither help nor results, nor the progress on stderr."""
    start = "unset NO_COLOR; export FORCE_COLOR=1 CLICOLOR_FORCE=1"
    done = shell(f"{start}; $RUN derive coulomb 2>&1 | cat; $RUN --help 2>&1 | cat", tmp_path)
    assert "coulomb" in done.stdout
    assert "Usage: stickslip" in done.stdout
    assert "\x1b" not in done.stdout


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("stickslip da", "damping"),
        ("stickslip damping --al", "--all"),
        ("stickslip damping linear --method sec", "second_order"),
        ("stickslip derive linear --criterion har", "harmonic"),
        ("stickslip laws exponential_v", "exponential_viscous"),
    ],
)
def test_shell_completes(line, expected):
    out = completion({"COMP_WORDS": line, "COMP_CWORD": str(len(line.split()) - 1)}, "bash_complete")
    assert expected in out
    assert "equilibrium" not in out


@pytest.mark.parametrize("kind", ["bash", "zsh", "fish"])
def test_script_of_completion_is_shown(kind):
    script = completion({}, f"{kind}_source")
    program = shutil.which(kind)
    assert "_STICKSLIP_COMPLETE" in script
    if program is not None and not WINDOWS:  # Windows has a bash of its own, of another system
        checked = subprocess.run([program, "-n"], input=script, text=True, timeout=60, check=False)
        assert checked.returncode == 0


def completion(asked, what):
    """Ask for completions as a shell's script does."""
    command = [sys.executable, "-c", "from stickslip_sym.cli.program import main; main()"]
    environment = os.environ | asked | {"_STICKSLIP_COMPLETE": what}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=60, check=False)
    assert done.stderr == ""
    return done.stdout
