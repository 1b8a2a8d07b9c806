"""Writing files so that nothing is lost: the new content replaces the old at once, or not at all."""

import os
import tempfile
from pathlib import Path

from stickslip_sym.errors import InputError

__all__ = ["write_text"]


def write_text(path: Path, content: str) -> None:
    """Write text to a file; what was there before stays if writing fails.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    target = path.resolve()
    try:
        if target.exists() and not target.is_file():
            _write_into(target, content)
        else:
            _replace(target, content)
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(f"cannot write {str(path)!r}: {reason}; choose another file") from None


def _write_into(target: Path, content: str) -> None:
    """Write to a device or a pipe, which cannot be replaced; a directory refuses by itself."""
    with target.open("w", encoding="utf-8") as stream:
        stream.write(content)


def _replace(target: Path, content: str) -> None:
    mode = target.stat().st_mode & 0o777 if target.exists() else 0o666 & ~_umask()
    descriptor, temporary = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
    try:
        with os.fdopen(descriptor, "w", encoding="utf-8") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        os.chmod(temporary, mode)
        os.replace(temporary, target)
    except BaseException:
        os.unlink(temporary)
        raise


def _umask() -> int:
    current = os.umask(0)
    os.umask(current)
    return current
