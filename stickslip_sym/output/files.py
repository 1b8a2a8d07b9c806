"""Reading regular files, and writing so that nothing is lost: new content replaces the old at once, or not at all.

Arrays are written so that files are the same, byte by byte, for the same content.
"""

import csv
import errno
import io
import os
import secrets
import shutil
import stat
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stickslip_sym.core.errors import InputError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from stickslip_sym.core.aliases import ObjectArray

_MOST_BYTES = 20_000_000  # of a file that people write, as laws and operating points are
_OWN = {"/dev/stdout": 1, "/dev/stderr": 2}
"""This process's own output: sent to a file, it must not be replaced, or what is printed later is lost."""


def is_kept(path: Path) -> bool:
    """Return whether a file would be lost if it were written: not a stream, nor this process's own output."""
    return path.is_file() and str(path) not in _OWN


def read_bytes(path: Path, most: int = _MOST_BYTES) -> bytes:
    """Return what a regular file holds, `most` bytes of it at most.

    Raises `InputError` for a file that cannot be read, that is longer, or that is a pipe or a device, which may
    have no end.
    """
    name = repr(str(path))
    try:
        with open(path, "rb", opener=_open_without_waiting) as stream:
            status = os.fstat(stream.fileno())
            is_regular = stat.S_ISREG(status.st_mode)
            content = b""
            if is_regular and status.st_size <= most:
                content = stream.read(most + 1)
    except OSError as error:
        raise InputError(f"cannot read {name}: {error.strerror or error}") from None
    except ValueError as error:  # a name may hold a null byte
        raise InputError(f"cannot read {name}: {error}") from None
    if not is_regular:
        raise InputError(f"cannot read {name}: it is no regular file; save its content in one")
    if max(status.st_size, len(content)) > most:
        raise InputError(f"{name} has over {most} bytes; nothing that is read here is as long")
    return content


def _open_without_waiting(path: str, flags: int) -> int:
    """Open a file; a pipe whose other end nobody has opened is not waited for."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0), 0o666)


def _write_stream(path: Path, content: bytes) -> None:
    """Write to a pipe, a device or this process's own output."""
    own = _OWN.get(str(path))
    if own is not None:
        number = os.dup(own)
    else:
        number = _open_without_waiting(str(path), os.O_WRONLY)
    with open(number, "wb") as stream:
        if own is None and hasattr(os, "O_NONBLOCK"):
            os.set_blocking(stream.fileno(), True)  # a reader is there, and may be slow
        stream.write(content)


def write_text(path: Path, content: str | bytes) -> None:
    """Write a file; what was there before stays if writing fails."""
    write_texts({path: content})


def write_texts(contents: Mapping[Path, str | bytes]) -> None:
    """Write files, all of them or none; streams and devices, which cannot be taken back, come last.

    Raises `InputError` if a file cannot be written.
    """
    staged: list[tuple[Path, Path, Path]] = []
    streams: list[tuple[Path, bytes]] = []
    with ExitStack() as left_over:
        for path, content in contents.items():
            whole = content.encode() if isinstance(content, str) else content
            with _refusing(path):
                if str(path) in _OWN or (path.exists() and not path.is_file()):
                    streams.append((path, whole))
                    continue
                target = Path(os.path.realpath(path))
                # A fixed length: with the target's own name the longest names would become too long.
                temporary = target.parent / f".stickslip-{secrets.token_hex(8)}"
                with temporary.open("xb") as stream:
                    left_over.callback(temporary.unlink, missing_ok=True)
                    stream.write(whole)
                    stream.flush()
                    os.fsync(stream.fileno())
                with suppress(FileNotFoundError):
                    target.stat()  # refuses a loop of links
                    if not os.access(target, os.W_OK):  # it could be replaced all the same
                        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
                    shutil.copymode(target, temporary)
                staged.append((path, temporary, target))
        for path, temporary, target in staged:
            with _refusing(path):
                os.replace(temporary, target)
        for path, whole in streams:  # a directory refuses by itself
            with _refusing(path):
                _write_stream(path, whole)


@contextmanager
def _refusing(path: Path) -> Iterator[None]:
    try:
        yield
    except BrokenPipeError:  # of /dev/stdout: a reader that has read enough is no bad input
        raise
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"cannot write {str(path)!r}: {reason}; choose another file") from None


def texts(array: "ObjectArray") -> "NDArray[np.str_]":
    """Return an array of members of an enumeration as text."""
    import numpy as np

    return np.array([entry.value for entry in np.ravel(array)]).reshape(np.shape(array))


def write_csv(path: Path, columns: "Mapping[str, ArrayLike]") -> None:
    """Write arrays of one size as columns of a CSV file, floats to their last digit, as `write_text` does."""
    import numpy as np

    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*(np.ravel(column).tolist() for column in columns.values()), strict=True))
    write_text(path, buffer.getvalue())


def write_npz(path: Path, arrays: "Mapping[str, ArrayLike]") -> None:
    """Write arrays as ``numpy.savez_compressed`` does, which notes no time, as `write_text` does."""
    import numpy as np

    buffer = io.BytesIO()
    named = dict[str, Any](arrays)
    np.savez_compressed(buffer, **named)
    write_text(path, buffer.getvalue())
