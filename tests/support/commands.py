"""The command line, run in this process, in one of its own, and by a shell."""

import contextlib
import io
import json
import signal
import subprocess
import sys

import pytest

from stickslip_sym.cli import program
from support.platforms import WINDOWS

_RUN = "from stickslip_sym.cli.start import main; main()"


def inside(*arguments, cwd="."):
    """Run the command in this process, which has imported all it needs; the result is that of a process."""
    out, err = io.StringIO(), io.StringIO()
    with pytest.MonkeyPatch.context() as patched, contextlib.chdir(cwd):
        patched.setattr("sys.argv", ["stickslip", *arguments])
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), pytest.raises(SystemExit) as end:
            program.main()
    return subprocess.CompletedProcess(arguments, end.value.code or 0, out.getvalue(), err.getvalue())


def stickslip(*arguments, cwd=None):
    """Run the command in a process of its own."""
    command = [sys.executable, "-c", _RUN, *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, cwd=cwd, check=False)


@contextlib.contextmanager
def started(*arguments, cwd="."):
    """Start the command in a process, and a group, of its own; it is ended if it does not end by itself."""

    def obey():  # an interrupt, also where the tests run in the background of a shell, which ignores it
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    with subprocess.Popen(
        [sys.executable, "-c", _RUN, *arguments],
        cwd=cwd,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=None if WINDOWS else obey,
    ) as process:
        try:
            yield process
        finally:
            process.kill()


def shell(line, cwd):
    """Run a line of shell in which $RUN is the command."""
    run = f"{sys.executable} -c '{_RUN}'"
    command = ["bash", "-c", "set -o pipefail; " + line.replace("$RUN", run)]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, cwd=cwd, check=False)


def refuse(name):
    raise AssertionError(f"{name} is not JSON")


def read_json(text):
    return json.loads(text, parse_constant=refuse)
