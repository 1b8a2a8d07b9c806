"""Writing files so that nothing is lost: the new content replaces the old at once, or not at all.

Arrays are written so that files are the same, byte by byte, for the same content.
"""

import csv
import errno
import io
import os
import secrets
import shutil
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from stickslip_sym.core.errors import InputError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from stickslip_sym.core.aliases import ObjectArray

__all__ = ["is_kept", "require_name", "texts", "write_csv", "write_npz", "write_text", "write_texts"]

_OWN = {"/dev/stdout": 1, "/dev/stderr": 2}
"""This process's own output: sent to a file, it must not be replaced, or what is printed later is lost."""


def is_kept(path: Path) -> bool:
    """Return whether a file would be lost if it were written: not a stream, nor this process's own output."""
    return path.is_file() and str(path) not in _OWN


def require_name(path: Path) -> None:
    """Refuse what no system takes for the name of a file, each with words of its own.

    Raises `InputError` if it holds a null byte.
    """
    if "\0" in str(path):
        raise InputError(f"the name of a file cannot hold a null byte, as {str(path)!r} does; choose another file")


def write_text(path: Path, content: str | bytes) -> None:
    """Write a file; what was there before stays if writing fails.

    Raises `InputError` if the file cannot be written.
    """
    write_texts({path: content})


def write_texts(contents: Mapping[Path, str | bytes]) -> None:
    """Write files, all of them or none; streams and devices, which cannot be taken back, come last.

    Raises `InputError` if a file cannot be written.
    """
    staged: list[tuple[Path, Path, Path]] = []
    streams: list[tuple[Path, bytes]] = []
    try:
        for path, content in contents.items():
            require_name(path)
            whole = content.encode() if isinstance(content, str) else content
            with _refusing(path):
                if str(path) in _OWN or (path.exists() and not path.is_file()):
                    streams.append((path, whole))
                else:
                    staged.append((path, *_staged(path, whole)))
        while staged:
            path, temporary, target = staged[0]
            with _refusing(path):
                os.replace(temporary, target)
            del staged[0]
        for path, whole in streams:
            with _refusing(path):
                _write_into(path, whole)
    finally:
        for _, temporary, _ in staged:
            temporary.unlink()


@contextmanager
def _refusing(path: Path) -> Iterator[None]:
    try:
        yield
    except BrokenPipeError:  # of /dev/stdout: a reader that has read enough is no bad input
        raise
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"cannot write {str(path)!r}: {reason}; choose another file") from None


def _write_into(path: Path, content: bytes) -> None:
    """Write to a stream, a device or a pipe, which cannot be replaced; a directory refuses by itself."""
    own = _OWN.get(str(path))
    with open(path if own is None else os.dup(own), "wb") as stream:
        stream.write(content)


def _staged(path: Path, content: bytes) -> tuple[Path, Path]:
    """Write beside a file what shall replace it, and return both; links are followed."""
    target = Path(os.path.realpath(path))
    try:
        target.stat()
        exists = True
    except FileNotFoundError:
        exists = False
    if exists and not os.access(target, os.W_OK):
        # Replacing needs no permission on the file itself; a file that may not be written stays all the same.
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    # A fixed length: with the target's own name the longest names would become too long.
    temporary = target.parent / f".stickslip-{secrets.token_hex(8)}"
    try:
        with temporary.open("xb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        if exists:
            shutil.copymode(target, temporary)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
    return temporary, target


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
    """Write arrays as ``numpy.savez_compressed`` does, but without the time of writing, as `write_text` does."""
    import numpy as np

    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as whole:
        for name, array in arrays.items():
            part = io.BytesIO()
            np.lib.format.write_array(part, np.asarray(array, order="C"), allow_pickle=False)
            whole.writestr(zipfile.ZipInfo(f"{name}.npy"), part.getvalue(), zipfile.ZIP_DEFLATED)
    write_text(path, buffer.getvalue())
