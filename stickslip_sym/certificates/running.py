"""A certificate is run as its reader would run it: in a process of its own, without this package."""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from stickslip_sym.core.deadline import time_left
from stickslip_sym.core.errors import InputError, OutOfTime
from stickslip_sym.core.status import Status

_WITHOUT_THE_PACKAGE = "import sys; sys.modules['stickslip_sym'] = None; exec(sys.stdin.read(), {})"


def outcome_in_sympy(page: str) -> tuple[Status, str]:
    """Return what a page in SymPy establishes of its formula, PROVED or CHECKED, and a sentence that says so."""
    done = _run_program([sys.executable, "-I", "-c", _WITHOUT_THE_PACKAGE], page)
    if done.returncode != 0:
        return Status.CHECKED, f"its page in SymPy stops here: {_last_line(done.stderr)}"
    if done.stdout.startswith("proved: "):
        return Status.PROVED, "its page in SymPy has proved it here"
    return Status.CHECKED, "its page in SymPy has compared it here, at points only"


def outcome_in_coq(script: str) -> tuple[Status, str]:
    """Return whether Coq accepts a script, PROVED or CHECKED, and a sentence that says so.

    Raises `InputError` where there is no Coq.
    """
    compiler = shutil.which("coqc")
    if compiler is None:
        raise InputError(
            "there is no command coqc here, which checks a proof in Coq; on Debian it is installed by "
            "apt-get install coq libcoq-coquelicot"
        )
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "proof.v").write_text(script, encoding="utf-8")
        done = _run_program([compiler, "-q", "proof.v"], "", folder)
    if done.returncode != 0:
        return Status.CHECKED, f"Coq does not accept its script here: {_last_line(done.stderr)}"
    return Status.PROVED, "Coq has accepted its script here"


def _run_program(command: list[str], text: str, folder: str | None = None) -> "subprocess.CompletedProcess[str]":
    left = time_left()
    try:
        return subprocess.run(
            command,
            input=text,
            capture_output=True,
            encoding="utf-8",
            cwd=folder,
            timeout=None if left == float("inf") else max(left, 0.0),
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise OutOfTime("the time limit was reached before the certificate had run") from None


def _last_line(text: str) -> str:
    lines = text.strip().splitlines()
    if lines:
        return lines[-1][:200]
    return "it says nothing"
