"""Arrays in files that are the same, byte by byte, for the same content."""

import csv
import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from stickslip_sym.output.files import write_bytes, write_text

__all__ = ["texts", "write_csv", "write_npz"]


def texts(array: Any) -> Any:
    """Return an array of members of an enumeration as text."""
    return np.array([entry.value for entry in np.ravel(array)]).reshape(np.shape(array))


def write_csv(path: Path, columns: dict[str, Any]) -> None:
    """Write arrays of one size as columns of a CSV file, floats to their last digit.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*(np.ravel(column).tolist() for column in columns.values()), strict=True))
    write_text(path, buffer.getvalue())


def write_npz(path: Path, arrays: dict[str, Any]) -> None:
    """Write arrays as ``numpy.savez_compressed`` does, but without the time of writing.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as whole:
        for name, array in arrays.items():
            part = io.BytesIO()
            np.lib.format.write_array(part, np.asarray(array, order="C"), allow_pickle=False)
            whole.writestr(zipfile.ZipInfo(f"{name}.npy"), part.getvalue(), zipfile.ZIP_DEFLATED)
    write_bytes(path, buffer.getvalue())
