"""The command as a process: interrupts, pipes, full disks, colours, completion."""

import io
import re
import signal
import sys
import time
from pathlib import Path

import pytest
from click.shell_completion import get_completion_class
from rich.progress import Progress

from stickslip_sym.cli.output import show_progress
from stickslip_sym.cli.program import program
from stickslip_sym.core.progress import steps
from support.commands import shell, started
from support.platforms import needs_posix_shell


@pytest.mark.parametrize("name", ["derive", "study"])
def test_interrupt_ends_a_command(name, run, monkeypatch):
    def interrupt(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("stickslip_sym.model.law.FrictionLaw.typical", interrupt)
    code, out, err = run(name, "linear")
    assert (code, out, err.strip()) == (130, "", "interrupted")


@pytest.mark.thorough
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_full_disk_is_one_line(tmp_path):
    done = shell("$RUN laws > /dev/full", tmp_path)
    assert done.returncode == 1
    assert done.stderr == "error: cannot write the output: No space left on device\n"


@needs_posix_shell
def test_closed_pipe_ends_quietly(tmp_path):
    done = shell("$RUN laws --json | head -0", tmp_path)
    assert (done.stdout, done.stderr) == ("", "")


@needs_posix_shell
@pytest.mark.parametrize(
    "sink", ["| cat", pytest.param("> out.txt; code=$?; cat out.txt; exit $code", marks=pytest.mark.thorough)]
)
def test_latex_to_standard_output_loses_nothing(sink, tmp_path):
    done = shell(f"$RUN derive coulomb --latex /dev/stdout {sink}", tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("% ClosedForm: coulomb")
    assert "event-driven threshold" in done.stdout


@pytest.mark.thorough
@needs_posix_shell
def test_files_get_no_colours(tmp_path):
    """Neither help nor results, nor the progress on stderr."""
    start = "unset NO_COLOR; export FORCE_COLOR=1 CLICOLOR_FORCE=1"
    done = shell(f"{start}; $RUN derive coulomb 2>&1 | cat; $RUN --help 2>&1 | cat", tmp_path)
    assert "coulomb" in done.stdout
    assert "Usage: stickslip" in done.stdout
    assert "\x1b" not in done.stdout


@pytest.mark.parametrize(
    ("words", "begun", "expected"),
    [
        ("", "da", "damping"),
        ("damping", "--al", "--all"),
        ("damping linear --method", "sec", "second_order"),
        ("derive linear --criterion", "har", "harmonic"),
        ("laws", "exponential_v", "exponential_viscous"),
    ],
)
def test_shell_completes(words, begun, expected):
    completion = get_completion_class("bash")(program, {}, "stickslip", "_STICKSLIP_COMPLETE")
    found = [item.value for item in completion.get_completions(words.split(), begun)]
    assert expected in found
    assert "equilibrium" not in found


class Terminal(io.StringIO):
    """A stream that is a terminal, or is none."""

    is_one = True

    def isatty(self):
        return self.is_one


@pytest.mark.parametrize("terminal", [True, False])
def test_what_is_under_way_is_shown_in_a_terminal_only(terminal, monkeypatch):
    stream = Terminal()
    stream.is_one = terminal
    monkeypatch.setattr("sys.stderr", stream)
    monkeypatch.setenv("TERM", "xterm")
    with show_progress("study"), steps(range(3), lambda i: f"the plane [of] {i}") as numbers:
        for _ in numbers:
            pass
    assert ("study: the plane [of] 2 (3 of 3)" in stream.getvalue()) == terminal
    assert terminal or stream.getvalue() == ""


SAID = [
    ("derive linear --criterion harmonic -V 0.5", ["harmonic of linear: averaging -a_1*v", "of v (2 of 4)"]),
    ("damping linear --all", ["every method: methods (1 of 7): orbit", "methods (6 of 7): second_order"]),
    ("critical linear --of all -c 1", ["all quantities: margins of m (0 of 7)", "margins of a_1 (6 of 7)"]),
    ("map coulomb --x V=0.1:0.4:2 --y c=1:2:2", ["map: lines of cells (1 of 2)"]),
    ("fit disc.csv --law linear --law gaussian", ["fits: linear (0 of 2)", "fits: gaussian (1 of 2)"]),
]


@pytest.mark.parametrize(("line", "texts"), SAID, ids=[line for line, _ in SAID])
def test_commands_say_how_far_they_are(line, texts, run, tmp_path, monkeypatch):
    (tmp_path / "disc.csv").write_text("v [m/s],mu\n" + "".join(f"{i / 10},{0.5 - i / 50}\n" for i in range(9)))
    shown, show = [], Progress.update

    def update(bar, task, **state):
        shown.append(state["description"])
        show(bar, task, **state)

    monkeypatch.setattr(Progress, "update", update)
    monkeypatch.setattr("stickslip_sym.motion.maps.motions._CELLS", 2)
    stream = Terminal()
    monkeypatch.setattr("sys.stderr", stream)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.chdir(tmp_path)
    program.main(line.split(), standalone_mode=False)
    assert all(any(text in description for description in shown) for text in texts), shown


@needs_posix_shell
@pytest.mark.parametrize(
    "closed", [">&-", *(pytest.param(name, marks=pytest.mark.thorough) for name in ("2>&-", "<&-"))]
)
def test_a_closed_stream_is_no_traceback(closed, tmp_path):
    done = shell(f"$RUN laws {closed}", tmp_path)
    expected = "error: cannot write the output: standard output is closed\n" if closed == ">&-" else ""
    assert (done.returncode, done.stderr) == (1 if closed == ">&-" else 0, expected)


BEFORE_THE_HANDLER = {"__init__.py", "core/__init__.py", "core/version.py", "cli/__init__.py", "cli/start.py"}


@needs_posix_shell
@pytest.mark.parametrize(
    "seconds", [0.5, *(pytest.param(early, marks=pytest.mark.thorough) for early in (0.1, 0.2, 0.3, 0.8))]
)
def test_ctrl_c_while_the_command_begins_is_a_line(seconds, tmp_path):
    """Until Python has begun, and for milliseconds to the handler, the interrupt is Python's own."""
    with started("derive", "exponential", cwd=tmp_path) as process:
        time.sleep(seconds)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert set(re.findall(r"stickslip_sym/(\S+)\"", err)) <= BEFORE_THE_HANDLER, err
    assert (process.returncode, out) == (130, "") or process.returncode in (0, -signal.SIGINT)


@needs_posix_shell
def test_sigterm_leaves_nothing_beside_the_target(tmp_path):
    """The file is half written when the signal comes."""
    (tmp_path / "half.py").write_text(
        "import os, signal, sys\n"
        "from stickslip_sym.cli import start\n"
        "os.fsync = lambda _: signal.raise_signal(signal.SIGTERM)\n"
        "sys.argv = ['stickslip', 'export', 'linear', '--save', 'law.json']\n"
        "start.main()\n"
    )
    done = shell(f"{sys.executable} half.py", tmp_path)
    assert done.returncode == 128 + signal.SIGTERM, done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["half.py"]
