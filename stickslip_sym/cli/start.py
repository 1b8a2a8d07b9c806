"""Where the command begins: it imports nothing heavy, so that Ctrl-C in the first second ends it in a line."""

from __future__ import annotations

import sys

try:
    import os
    import signal

    from stickslip_sym.cli.exit_codes import SIGNALLED
except KeyboardInterrupt:
    print("interrupted", file=sys.stderr)
    sys.exit(130)  # as below

TYPE_CHECKING = False  # as in typing, which is no light import
if TYPE_CHECKING:
    from types import FrameType
    from typing import NoReturn


def main() -> None:
    """Run the command line."""
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w")  # noqa: SIM115  # for as long as the process runs
    if sys.stdout is None:
        sys.exit("error: cannot write the output: standard output is closed")
    heard = signal.getsignal(signal.SIGINT)
    if heard is signal.default_int_handler:
        # An exception within an import may be caught there, or leave the module half made.
        signal.signal(signal.SIGINT, _leave)
    from stickslip_sym.cli import program

    if heard is signal.default_int_handler:
        signal.signal(signal.SIGINT, heard)
    signal.signal(signal.SIGTERM, _end_by_signal)
    program.main()


def _leave(number: int, frame: FrameType | None) -> NoReturn:
    """End at once: nothing has begun that would have to be put in order."""
    os.write(2, b"interrupted\n")
    os._exit(SIGNALLED + number)


def _end_by_signal(number: int, frame: FrameType | None) -> NoReturn:
    """End by an exception, so that files which are half written are removed."""
    raise SystemExit(SIGNALLED + number)
