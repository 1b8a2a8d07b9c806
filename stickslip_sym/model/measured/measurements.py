"""`Measurements`: slip speeds, coefficients of friction and their standard deviations, from arrays or a file."""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import Number, read_array
from stickslip_sym.model.measured.folding import Column, Folded, fold
from stickslip_sym.model.measured.table import Table, read_table

__all__ = ["Measurements", "read_measurements"]

FloatArray = NDArray[np.float64]

_EXACTLY = 5000  # rows up to which numbers are kept exactly; more are averaged, or fitted, in double precision


@dataclass(frozen=True, eq=False, repr=False)
class Measurements:
    """Measured friction: rows of a slip speed, a coefficient and, where known, its standard deviation.

    Attributes
    ----------
    v : ndarray of shape (n,)
        Slip speeds in m/s, not negative, ascending; a speed may repeat.
    mu : ndarray of shape (n,)
        Coefficients of friction.
    sigma : ndarray of shape (n,) or None
        Standard deviation of each coefficient.
    understood : str
        What was read, in a line.
    name : str or None
        Of the file, without its ending.
    """

    v: FloatArray
    mu: FloatArray
    sigma: FloatArray | None = None
    understood: str = ""
    name: str | None = None
    _exact: tuple[tuple[Fraction, ...], tuple[Fraction, ...]] | None = None

    @classmethod
    def of(cls, v: ArrayLike, mu: ArrayLike, sigma: ArrayLike | None = None) -> "Measurements":
        """Return measurements from arrays of one length; `sigma` may be one number for all.

        Raises
        ------
        InputError
            For lengths that differ, speeds below 0, standard deviations not above 0, or what is no number.
        """
        speeds, coefficients = (np.array(read_array(name, x), np.float64) for name, x in (("v", v), ("mu", mu)))
        if speeds.ndim != 1 or speeds.shape != coefficients.shape:
            raise InputError(f"v has the shape {speeds.shape} and mu {coefficients.shape}; give one mu for each v")
        if (speeds < 0).any():
            raise InputError(f"v = {speeds[speeds < 0][0]:g} is below 0; the slip speed is |x' - V|")
        deviations = None
        if sigma is not None:
            given = np.asarray(read_array("sigma", sigma), np.float64)
            if given.shape not in ((), speeds.shape):
                raise InputError(f"sigma has the shape {given.shape} and mu {speeds.shape}; give one for each mu")
            if (given <= 0).any():
                raise InputError(f"sigma = {given[given <= 0].flat[0]:g} is not above 0; leave it out if unknown")
            deviations = np.broadcast_to(given, speeds.shape)
        order = np.argsort(speeds, kind="stable")
        rows = f"{len(speeds)} rows{'' if sigma is None else ' with sigma'}"
        return cls(speeds[order], coefficients[order], None if deviations is None else deviations[order], rows)

    def __len__(self) -> int:
        return len(self.v)

    def __str__(self) -> str:
        return self.understood

    def __repr__(self) -> str:
        return f"Measurements: {self.understood or f'{len(self)} rows'}"

    @property
    def speeds(self) -> FloatArray:
        """The different slip speeds in m/s, ascending."""
        return np.unique(self.v)

    def averaged(self) -> "Measurements":
        """Return the measurements with one row for each speed: the mean of its rows.

        With `sigma` the mean is weighted by 1/sigma^2, and its standard deviation is that of the weighted mean.
        Without it the scatter of the rows of one speed about their mean, pooled over all speeds that repeat,
        divided by the root of the number of rows, is the standard deviation of each mean.
        """
        speeds, place, counts = np.unique(self.v, return_inverse=True, return_counts=True)
        if len(speeds) == len(self.v):
            return self
        mean: FloatArray
        deviation: FloatArray
        if self.sigma is not None:
            weights = self.sigma**-2.0
            total = np.bincount(place, weights)
            mean, deviation = np.bincount(place, weights * self.mu) / total, 1 / np.sqrt(total)
            scatter = "weighted by 1/sigma^2"
        else:
            mean = np.bincount(place, self.mu) / counts
            pooled = float(np.sqrt(np.sum((self.mu - mean[place]) ** 2) / (len(self.v) - len(speeds))))
            deviation = np.asarray(pooled / np.sqrt(counts), np.float64)
            scatter = f"scatter {pooled:.2g} about the means"
        understood = f"{self.understood}; averaged at {len(speeds)} speeds, {scatter}"
        return Measurements(speeds, mean, deviation, understood, self.name, self._exact_means())

    def binned(self, count: int) -> "Measurements":
        """Return the means of `count` bins of speed, with as many rows in each as nearly as can be.

        Raises
        ------
        InputError
            If there are fewer rows than bins, or fewer than one bin.
        """
        if not 1 <= count <= len(self.v):
            raise InputError(f"{count} bins of {len(self.v)} rows; take 1 to {len(self.v)}")
        places = np.repeat(np.arange(count), [len(part) for part in np.array_split(self.v, count)])
        sizes = np.bincount(places)
        speed = np.bincount(places, self.v) / sizes
        rows = Measurements(speed[places], self.mu, self.sigma, self.understood, self.name)
        return rows.averaged()

    def points(self) -> tuple[list[Number], list[Number]]:
        """Return speeds, each once and ascending, and mean coefficients, exact where the file had decimal text."""
        means = self.averaged()
        if means._exact is not None:
            return list(means._exact[0]), list(means._exact[1])
        return means.v.tolist(), means.mu.tolist()

    def _exact_means(self) -> tuple[tuple[Fraction, ...], tuple[Fraction, ...]] | None:
        if self._exact is None or self.sigma is not None:  # weights are no decimal text
            return None
        rows: dict[Fraction, list[Fraction]] = {}
        for speed, coefficient in zip(*self._exact, strict=True):
            rows.setdefault(speed, []).append(coefficient)
        return tuple(rows), tuple(sum(row, Fraction(0)) / len(row) for row in rows.values())


def read_measurements(path: str | Path) -> Measurements:
    r"""Return the friction measurements in a text file of columns, as instruments write them.

    Commas, semicolons, tabs, bars or blanks part the columns; the decimal sign is a point or a comma. A header
    names them, in any of the usual words, with units: a speed, ``v [mm/s]``, and a coefficient, ``mu``, or forces,
    ``F_t [N]`` and ``F_n [N]``; a standard deviation, ``sigma``, if there is one. Other columns are left out.
    Without a header there are two columns, v in m/s and mu. Lines that begin with # or % are comments. Rows may
    come in any order; speeds and forces may have both signs, which are folded.

    Returns
    -------
    Measurements
        Printed, it says what was understood.

    Raises
    ------
    InputError
        For what is not understood, with the line and the column of the file, and what to write.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder, "pin.csv")
    ...     _ = file.write_text("v [mm/s];F_t [N];F_n [N]\n100;3,5;10\n-50;-4;10\n")
    ...     print(read_measurements(file))
    2 rows, v in mm/s, mu from F_t/F_n, both signs of speed folded
    """
    if not isinstance(path, str | Path) or not str(path):
        raise InputError(f"the name of a CSV file is text, got {path!r}")
    path = Path(path)
    table = read_table(path)
    exactly = len(table.lines) <= _EXACTLY
    values: dict[str, Column] = {}
    for name, cells in table.cells.items():
        size = table.columns.sizes[name]
        if exactly:
            values[name] = [Fraction(cell) * size for cell in cells]
        else:
            values[name] = np.array(cells, dtype=np.float64) * float(size)
    folded = fold(values, table, repr(str(path)))
    v, mu = (np.array(x, dtype=np.float64) for x in (folded.v, folded.mu))
    order = np.argsort(v, kind="stable")
    sigma = None if folded.sigma is None else np.array(folded.sigma, dtype=np.float64)[order]
    kept = None
    if exactly:
        kept = tuple(folded.v[i] for i in order), tuple(folded.mu[i] for i in order)
    return Measurements(v[order], mu[order], sigma, _understood(table, folded), path.stem, kept)


def _understood(table: Table, folded: Folded) -> str:
    columns = table.columns
    count = len(table.lines)
    unit = columns.units["v"] or "m/s"
    parts = [f"{count} row{'s' * (count != 1)}", f"v in {unit}"]
    parts.append("mu from F_t/F_n" if "F_t" in columns.places else f"mu from column {columns.places['mu'] + 1}")
    parts += [f"{name} from column {columns.places[key] + 1}" for key, name in _SIGMAS if key in columns.places]
    parts += folded.notes
    if columns.left_out:
        parts.append(f"left out: {_listed(columns.left_out)}")
    return ", ".join(parts)


_SIGMAS = (("sigma_mu", "sigma"), ("sigma_F_t", "sigma of F_t"))


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")
