"""Writing files so that nothing is lost: the new content replaces the old at once, or not at all."""

import errno
import os
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from stickslip_sym.core.errors import InputError

__all__ = ["is_kept", "require_name", "write_bytes", "write_text", "write_texts"]


def is_kept(path: Path) -> bool:
    """Return whether a file would be lost if it were written: not a stream, nor this process's own output."""
    if not path.is_file():
        return False
    if (own := _own_output(path)) is not None:
        os.close(own)
        return False
    return True


def require_name(path: Path) -> None:
    """Refuse what no system takes for the name of a file, each with words of its own.

    Raises
    ------
    InputError
        If it holds a null byte.
    """
    if "\0" in str(path):
        raise InputError(f"the name of a file cannot hold a null byte, as {str(path)!r} does; choose another file")


def write_text(path: Path, content: str) -> None:
    """Write text to a file; what was there before stays if writing fails.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    write_bytes(path, content.encode())


def write_bytes(path: Path, content: bytes) -> None:
    """Write bytes to a file, as `write_text` does."""
    _write_all({path: content})


def write_texts(contents: Mapping[Path, str]) -> None:
    """Write texts to files, all of them or none; streams and devices, which cannot be taken back, come last.

    Raises
    ------
    InputError
        If a file cannot be written.
    """
    _write_all({path: content.encode() for path, content in contents.items()})


def _write_all(contents: Mapping[Path, bytes]) -> None:
    staged: list[tuple[Path, str, Path]] = []
    streams: list[tuple[Path, Path | int, bytes]] = []
    try:
        for path, content in contents.items():
            require_name(path)
            with _refusing(path):
                # Before links are followed: /dev/stdout leads to a name such as pipe:[42] that no file has.
                if path.exists() and not path.is_file():
                    streams.append((path, path, content))
                elif (own := _own_output(path)) is not None:
                    streams.append((path, own, content))
                else:
                    target = Path(os.path.realpath(path))
                    staged.append((path, _staged(target, content), target))
        while staged:
            path, temporary, target = staged[0]
            with _refusing(path):
                os.replace(temporary, target)
            del staged[0]
        for path, stream, content in streams:
            with _refusing(path):
                _write_into(stream, content)
    finally:
        for _, temporary, _ in staged:
            os.unlink(temporary)


@contextmanager
def _refusing(path: Path) -> Iterator[None]:
    try:
        yield
    except BrokenPipeError:  # of /dev/stdout: a reader that has read enough is no bad input
        raise
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"cannot write {str(path)!r}: {reason}; choose another file") from None


def _own_output(path: Path) -> int | None:
    """Return a copy of this process's output stream if that is what `path` is.

    `/dev/stdout` with output sent to a file: to replace that file would lose what is printed afterwards.
    """
    for stream in (1, 2):
        with suppress(OSError):
            if os.path.samestat(path.stat(), os.fstat(stream)):
                return os.dup(stream)
    return None


def _write_into(target: Path | int, content: bytes) -> None:
    """Write to a stream, a device or a pipe, which cannot be replaced; a directory refuses by itself."""
    with open(target, "wb") as stream:
        stream.write(content)


def _staged(target: Path, content: bytes) -> str:
    """Write beside a file what shall replace it, and return where."""
    if target.is_symlink():  # no link is left after following all, except in a loop
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP))
    exists = target.exists()
    if exists and not os.access(target, os.W_OK):
        # Replacing needs no permission on the file itself; a file that may not be written stays all the same.
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    mode = target.stat().st_mode & 0o777 if exists else 0o666 & ~_umask()
    # A fixed prefix: with the target's own name the longest names would become too long.
    descriptor, temporary = tempfile.mkstemp(dir=target.parent, prefix=".stickslip-")
    try:
        with os.fdopen(descriptor, "wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        os.chmod(temporary, mode)
    except BaseException:
        os.unlink(temporary)
        raise
    return temporary


def _umask() -> int:
    current = os.umask(0)
    os.umask(current)
    return current
