"""`Measurements`: slip speeds, coefficients of friction and their standard deviations, from arrays or a file."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import SAME, Number, fraction, read_array, real, require_type
from stickslip_sym.core.remedies import Argument
from stickslip_sym.core.units import has_no_unit, strip_unit
from stickslip_sym.model.measured.blocks import VARIES, Block, refuse_contradiction
from stickslip_sym.model.measured.heavy_tails import (
    DEVIATIONS_OUTLYING,
    NORMAL_DEVIATION,
    have_heavy_tails,
    huber_weights,
)
from stickslip_sym.model.measured.sweep_branches import FEW, SweepBranches, sweep_branches_of
from stickslip_sym.model.measured.text_table import Table, read_table
from stickslip_sym.output.data import TableResult
from stickslip_sym.output.shown import Drawn, views_of

_LARGEST_MU = 5.0  # no dry or lubricated contact comes near it
_FASTEST = 100.0  # m/s, above which a speed without a unit is taken for one in mm/s
_FEW_ROWS = 20.0  # of fewer the robust deviation is itself uncertain by a factor
_GAP_RATIOS = 2.0, 3.0  # times what three rows span, and the mean gap: mu may be anything beyond such a gap
_ROWS_BESIDE_OUTLIER = 3  # rows on either side that an outlier is held against; one of them may be an outlier too
_RISES = 4.0  # times what friction changes between rows beside an outlier, which a smooth curve may exceed too
_ROBUST = NORMAL_DEVIATION / 1.5**0.5  # standard deviation over the median of |mu_i - (mu_i-1 + mu_i+1)/2|
_LARGE_TRACK = 1  # m; those of tribometers are smaller
_RESOLUTION = 0.01  # of mu: smaller steps are no outliers, however even the other rows are
_OTHERS = {"sigma_mu": "sigma", "sigma_F_t": "sigma of F_t", "n": "n"}


@dataclass(frozen=True, eq=False, repr=False)
class Measurements(Drawn, TableResult):
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
    order : ndarray of shape (n,) or None
        Where each row stood in the file or the arrays; None for means.
    counts : ndarray of shape (n,) or None
        How many values each coefficient is the mean of, where the file says so.
    source : str
        The file and its date.
    written : str
        How the file is written: what parts its columns, and its decimal sign.
    branches : Branches or None
        Where the speed rises and falls, or both directions were measured: by how much mu differs between them.
    static_at_least : float or None
        The largest coefficient of rows at rest in which friction builds up: they are set apart, as nothing slips
        in them; None where there are none.
    tails : ndarray of shape (n,) or None
        Where noise has heavy tails: Huber's weight of each row, a factor of its square in a sum of squares.
    blocks : tuple of Block
        The blocks of a file that has more than one table, read or not.
    """

    reported = ("understood", "written", "source", "branches", "static_at_least", "blocks")

    v: FloatArray
    mu: FloatArray
    sigma: FloatArray | None = None
    understood: str = ""
    name: str | None = None
    order: IntArray | None = None
    counts: FloatArray | None = None
    source: str = ""
    written: str = ""
    branches: SweepBranches | None = None
    static_at_least: float | None = None
    tails: FloatArray | None = None
    blocks: tuple[Block, ...] = ()

    @classmethod
    def of(cls, v: ArrayLike, mu: ArrayLike, sigma: ArrayLike | None = None) -> "Measurements":
        """Return measurements from arrays of one length; `sigma` may be one number for all.

        Rows with a value that a masked array of NumPy masks are left out, and counted.

        Raises
        ------
        InputError
            For lengths that differ, speeds below 0, coefficients beyond 5, standard deviations not above 0, or
            what is no number.
        """
        given, masked = _unmasked({"v": v, "mu": mu, "sigma": sigma})
        v = given["v"]
        mu = given["mu"]
        sigma = given["sigma"]
        speeds, coefficients = (np.array(read_array(name, x), np.float64) for name, x in (("v", v), ("mu", mu)))
        if speeds.ndim != 1 or speeds.shape != coefficients.shape:
            raise InputError(f"v has the shape {speeds.shape} and mu {coefficients.shape}; give one mu for each v")
        if (speeds < 0).any():
            raise InputError(f"v = {speeds.min():g} is below 0; the slip speed is |x' - V|")
        if (large := np.abs(coefficients) > _LARGEST_MU).any():
            raise InputError(
                f"mu[{np.argmax(large)}] = {coefficients[large][0]:g}; a coefficient of friction is below "
                f"{_LARGEST_MU:g}: leave the row out"
            )
        deviations = None
        if sigma is not None:
            deviations = np.asarray(read_array("sigma", sigma), np.float64)
        if deviations is not None and deviations.shape not in ((), speeds.shape):
            raise InputError(f"sigma has the shape {deviations.shape} and mu {speeds.shape}; give one for each mu")
        if deviations is not None and (deviations <= 0).any():
            raise InputError(f"sigma = {deviations.min():g} is not above 0; leave it out if unknown")
        order = np.argsort(speeds, kind="stable")
        known = None
        if deviations is not None:
            known = np.broadcast_to(deviations, speeds.shape)[order]
        rows = f"{len(speeds)} rows{'' if sigma is None else ' with sigma'}"
        if masked:
            rows += f", {masked} masked rows left out"
        return cls(speeds[order], coefficients[order], known, rows, order=order).in_branches().with_tails_weighed()

    def in_branches(self, direction: IntArray | None = None) -> "Measurements":
        """Return the measurements with what their order says of branches, and an offset of directions removed.

        `direction` is 1 or -1, or 0 for a row without one.
        """
        if self.order is None:
            return self
        branches = sweep_branches_of(self.v, self.mu, self.weights, self.order, direction)
        if branches is None:
            return self
        mu = self.mu
        if direction is not None:
            mu = self.mu - branches.offset * direction
        return replace(self, mu=mu, understood=f"{self.understood}, {branches}", branches=branches)

    def with_tails_weighed(self, heavy: bool | None = None) -> "Measurements":
        """Return the measurements with Huber's weights, if noise has heavy tails, which may be known."""
        if not (have_heavy_tails(self.v, self.means) if heavy is None else heavy):
            return self
        tails = huber_weights(self.v, self.means)
        said = f"noise with heavy tails: {int((tails < 1).sum())} rows far off weighed down (Huber)"
        return replace(self, tails=tails, understood=f"{self.understood}, {said}")

    def __len__(self) -> int:
        return len(self.v)

    def __str__(self) -> str:
        return self.understood

    def __repr__(self) -> str:
        return f"Measurements: {self.understood or f'{len(self)} rows'}"

    @property
    def columns(self) -> dict[str, FloatArray]:
        """The rows in ascending speed as columns of SI units: v, mu, and sigma where it is known."""
        rows = {"v": self.v, "mu": self.mu}
        if self.sigma is None:
            return rows
        return rows | {"sigma": self.sigma}

    def _table_columns(self) -> dict[str, FloatArray]:
        return self.columns

    def preview(self) -> str:
        """Return what was read, before anything is computed: columns and units, what was assumed, first rows."""
        return views_of(self).plain_text(self)

    @property
    def speeds(self) -> FloatArray:
        """The different slip speeds in m/s, ascending."""
        return np.unique(self.v)

    @property
    def weights(self) -> FloatArray:
        """What multiplies each residual in a sum of squares: 1/sigma where it is known, less in heavy tails."""
        if self.sigma is None:
            weights = np.ones(len(self))
        else:
            weights = 1 / self.sigma
        if self.tails is None:
            return weights
        return weights * np.sqrt(self.tails)

    @property
    def means(self) -> FloatArray:
        """Coefficients of the mean of rising and falling branches: mu less its hysteresis."""
        if self.branches is None:
            return self.mu
        return self.mu - self.branches.hysteresis

    @cached_property
    def _of_branches(self) -> FloatArray | None:
        """Orthonormal columns of what differs between branches and directions, times the weights."""
        if self.branches is None or not self.branches.terms.size:
            return None
        return np.linalg.qr(self.weights[:, None] * self.branches.terms).Q

    @property
    def differences(self) -> int:
        """How many factors of differences between branches and directions the rows settle besides a law's."""
        return 0 if self.branches is None else self.branches.terms.shape[1]

    def project_out_branches(self, rows: FloatArray) -> FloatArray:
        """Return weighted values of rows, the last axis, without the part that branches and directions explain.

        Least squares of what is left are those with factors of these differences free.
        """
        columns = self._of_branches
        if columns is None:
            return rows
        return np.asarray(rows - (rows @ columns) @ columns.T)

    def averaged(self) -> "Measurements":
        """Return the measurements with one row for each speed: the mean of its rows, and of all branches.

        With `sigma` the mean is weighted by 1/sigma^2, and its standard deviation is that of the weighted mean.
        Without it the scatter of the rows of one speed about their mean, pooled over all speeds that repeat,
        divided by the root of the number of rows, is the standard deviation of each mean; where they agree in all
        digits, it is not known.
        """
        speeds, index = np.unique(self.v, return_inverse=True)
        if len(speeds) == len(self):
            if self.branches is None:
                return self
            return replace(self, mu=self.means, branches=None, tails=None)
        total = np.bincount(index, self.weights**2)
        mean = np.bincount(index, self.weights**2 * self.means) / total
        said = "weighted by 1/sigma^2"
        deviations: FloatArray | None = 1 / np.sqrt(total)
        if self.sigma is None:
            squares = (self.weights * (self.means - mean[index])) ** 2
            scatter = float(np.sqrt(np.sum(squares) / (len(self) - len(speeds))))
            said = f"scatter {scatter:.2g} about the means"
            deviations = scatter / np.sqrt(total)
            if scatter <= SAME * np.max(np.abs(mean)):  # rounding
                said = "at each of which rows agree"
                deviations = None
        understood = f"{self.understood}; averaged at {len(speeds)} speeds, {said}"
        return replace(
            self,
            v=speeds,
            mu=mean,
            sigma=deviations,
            understood=understood,
            order=None,
            counts=None,
            branches=None,
            tails=None,
        )

    def binned(self, count: int) -> "Measurements":
        """Return the means of `count` bins of speed, with as many rows in each as nearly as can be.

        Raises
        ------
        InputError
            If there are fewer rows than bins, or fewer than one bin.
        """
        if not 1 <= count <= len(self.v):
            raise InputError(f"{count} bins of {len(self.v)} rows; take 1 to {len(self.v)}")
        bins = np.repeat(np.arange(count), [len(rows) for rows in np.array_split(self.v, count)])
        speed = np.bincount(bins, self.v) / np.bincount(bins)
        return replace(self, v=speed[bins]).averaged()

    def points(self) -> tuple[list[str], list[str]]:
        """Return speeds, each once and ascending, and mean coefficients: the decimals that a file has."""
        means = self.averaged()
        text = repr if means is self else "{:.15g}".format  # rounding is not in the mean of decimals
        return [text(v) for v in means.v.tolist()], [text(mu) for mu in means.mu.tolist()]


def read_measurements(
    path: str | Path,
    *,
    columns: Mapping[str, str | int] | None = None,
    radius: Number | None = None,
    speeds: tuple[Number | None, Number | None] | None = None,
    leave_out: bool = False,
    keep_outliers: bool = False,
    bins: int | None = None,
    block: int | Iterable[int] | None = None,
) -> Measurements:
    r"""Return the friction measurements in a text file of columns, as instruments write them.

    Commas, semicolons, tabs, bars or blanks part the columns; the decimal sign is a point or a comma. A header
    just above the rows names them, in any of the usual words, with units behind the names or in a row below them:
    a speed, ``v [mm/s]``, and a coefficient, ``mu``, or forces, ``F_t [N]`` and ``F_n [N]``; a standard deviation,
    ``sigma``, if there is one. Other columns are left out. Without a header there are two columns, v in m/s and
    mu. Lines that begin with # or % are comments. Rows may come in any order; speeds and forces may have both
    signs, which are folded, and an offset between the directions removed. Rising and falling branches are
    recognised, and how much they differ is `Measurements.branches`.

    Parameters
    ----------
    path : str or Path
    columns : dict of str to str or int, optional
        Columns whose names are not understood: the quantity, ``v``, ``mu``, ``F_t``, ``F_n``, ``sigma_mu``,
        ``sigma_F_t`` or ``n``, and the column's name or its number from 1; a unit may follow, ``"2 [mm/s]"``.
    radius : number, optional
        Of the track in m, or with its unit, ``"25 mm"``, where the speed is a rotational one, like rpm; above 1
        the unit is required. A radius of the track with its unit in the lines above the header is taken.
    speeds : tuple of two numbers or None, optional
        The slip speeds in m/s, from and to, of the rows to read.
    leave_out : bool
        Leave out rows that are no measurements, and count them, instead of refusing the first: cells without a
        number, summaries like a mean, numbers that stand for none like -999 or 9.9E37, abs(mu) above 5, and
        outliers. Rows that follow each other, stand at even steps or are of one end of the speeds are refused all
        the same: what remains would be no fair sample.
    keep_outliers : bool
        Keep rows more than 6 robust standard deviations off a smooth curve.
    bins : int, optional
        Average the rows in so many bins of speed, as `Measurements.binned` does.
    block : int or several, optional
        The numbers, from 1, of the blocks to read in a file that holds several tables, as `Measurements.blocks`
        lists them. All blocks of one header are read together unless they contradict each other.

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
    require_type("the name of a file of measurements", path, str | Path, "text")
    require_type("columns", columns or {}, Mapping, "a dict like {'v': 1, 'mu': 'Friction Factor'}")
    track = None if radius is None else read_radius(radius)
    if speeds is not None and not (isinstance(speeds, Sequence) and len(speeds) == 2):
        raise InputError(f"speeds are two numbers, from and to, or None for no end; got {speeds!r}")
    low, high = (
        default if end is None else real("speeds", end)
        for end, default in zip(speeds or (None, None), (0.0, math.inf), strict=True)
    )
    if not 0 <= low < high:
        raise InputError(
            f"speeds from {low:g} to {high:g} m/s are no range; give the smaller first, both not below 0"
        )
    path = Path(path)
    table = read_table(path, columns or {}, track, leave_out=leave_out, block=_chosen_blocks(block))
    v, mu, sigma, direction, notes = _fold(table)
    if len(set(table.origin)) > 1:
        refuse_contradiction(table.name, v, mu, np.array(table.origin), table.blocks)
        notes.append(f"{len(set(table.origin))} blocks together")
    order = np.argsort(v, kind="stable")
    order = order[(v[order] >= low) & (v[order] <= high)]
    if not len(order):
        raise InputError(
            f"{table.name} has no row from {low:g} to {high:g} m/s; it reaches {v.min():g} to {v.max():g}"
        )
    if speeds is not None:
        notes.insert(0, f"{len(order)} of {len(v)} from {low:g} to {high:g} m/s")
    held = _rows_held_at_rest(v, mu)
    static_at_least = None
    if held.any() and not held.all():
        static_at_least = float(mu[held].max())
        notes.append(
            f"{int(held.sum())} rows at rest set apart: friction builds up to {static_at_least:.4g} there, and "
            "the static coefficient is at least that"
        )
        order = order[~held[order]]
    counts = table.floats("n") if "n" in table.columns else None
    heavy: bool | None = have_heavy_tails(v[order], mu[order])
    if not (keep_outliers or heavy):
        off = _outliers(v[order], mu[order])
        smooth = ~np.isin(np.arange(len(v)), order[off])
        rule = "mu is more than 6 robust standard deviations off a smooth curve; keep such rows by "
        rule += str(Argument("keep_outliers", True))
        table.require(smooth, "F_t" if "F_t" in table.columns else "mu", rule, "off a smooth curve")
        if off.any():
            order = order[~off]
            heavy = None
    table.refuse_systematic()
    if table.faults:
        notes.append(f"rows left out: {table.left_out}")
    if table.unread:
        more = len(table.unread) - 4
        notes.append(f"columns not read: {', '.join(table.unread[:4])}" + (f" and {more} more" * (more > 0)))
    sigma, counts = (None if column is None else column[order] for column in (sigma, counts))
    source = f"{path.name}, {datetime.fromtimestamp(path.stat().st_mtime, UTC):%Y-%m-%d}"
    rows = f"{len(order)} row{'s' * (len(order) != 1)}"
    understood = ", ".join([rows, *_columns_in_words(table), *notes])
    read = Measurements(
        v[order],
        mu[order],
        sigma,
        understood,
        path.stem,
        order,
        counts,
        source,
        table.written,
        static_at_least=static_at_least,
        blocks=table.blocks,
    )
    read = read.in_branches(direction[order])
    read = read.with_tails_weighed(heavy if read.branches is None else None)
    if bins is None:
        return read
    return read.binned(bins)


def _unmasked(given: Mapping[str, Any]) -> tuple[dict[str, Any], int]:
    """Return arrays without the rows that a mask of any of them hides, and the number of such rows."""
    hidden = [np.ma.getmaskarray(x) for x in given.values() if np.ma.is_masked(x)]
    shapes = {mask.shape for mask in hidden}
    if not hidden or len(shapes) > 1 or len(hidden[0].shape) != 1:
        return dict(given), 0
    keep = ~np.any(hidden, axis=0)
    shown = {
        name: np.ma.getdata(x)[keep] if np.shape(x) == keep.shape else x
        for name, x in given.items()
    }  # fmt: skip
    return shown, int((~keep).sum())


def _chosen_blocks(block: int | Iterable[int] | None) -> tuple[int, ...]:
    """Return the numbers of blocks that were chosen, none for all."""
    if block is None:
        return ()
    numbers = (block,) if isinstance(block, int) else tuple(block)
    if any(isinstance(number, bool) or not isinstance(number, int) for number in numbers):
        raise InputError(f"block is the number of a block, from 1, or several; got {block!r}")
    return numbers


def read_radius(radius: Number) -> Fraction:
    """Return the radius of a track in m; one above 1 needs its unit, as it may be in mm.

    Raises
    ------
    InputError
        For what is no radius of a track, or one that may be in mm.
    """
    track = fraction(radius, "radius")
    if not 0 < track < 1000 * _LARGE_TRACK:  # even in mm
        raise InputError(f"radius = {float(track):g} m is that of no track; give it in m, like 0.03")
    plain = not isinstance(radius, str) or has_no_unit(radius)
    if plain and track > _LARGE_TRACK and strip_unit(radius, "radius") is radius:
        like = f"{Argument('radius', f'{float(track):g} mm')} or {Argument('radius', f'{float(track):g} m')}"
        raise InputError(f"radius = {float(track):g} without a unit would be in m; write it with its unit: {like}")
    return track


def _rows_held_at_rest(v: FloatArray, mu: FloatArray) -> BoolArray:
    """Return which rows are at rest, if friction differs among them: there it builds up, and nothing slips.

    One row at rest, or several of one coefficient, may be meant as mu(0+).
    """
    at_rest: BoolArray = np.asarray(v == 0)
    if at_rest.sum() < 2 or np.ptp(mu[at_rest]) <= VARIES * np.max(np.abs(mu)):
        return np.zeros(len(v), dtype=bool)
    return at_rest


def _columns_in_words(table: Table) -> list[str]:
    """Return where speeds, coefficients, their standard deviations and counts come from."""
    columns = table.columns
    mu = "F_t/F_n"
    if "F_t" not in columns:
        mu = f"column {columns['mu'].number}"
    more = [f"{name} from column {columns[key].number}" for key, name in _OTHERS.items() if key in columns]
    weighed = [key for key in ("F_t", "F_n") if key in columns and columns[key].is_mass]
    more += [f"{key} in {columns[key].unit_text} taken for weights" for key in weighed]
    speed = "v taken to be in m/s"
    if columns["v"].unit_text:
        speed = f"v in {columns['v'].unit_text}"
    radius = [table.said_of_radius] if table.said_of_radius else []
    return ["no header"] * (not columns["v"].text) + [speed, *radius, f"mu from {mu}", *more]


def _outliers(v: FloatArray, y: FloatArray) -> BoolArray:
    """Return which coefficients, at ascending speeds, are off a smooth curve through the others.

    A row that is far from those beside it is none: the curve may change between them.
    """
    if len(y) < 2 * _ROWS_BESIDE_OUTLIER + 1:
        return np.zeros(len(y), dtype=bool)
    noise = _ROBUST * float(np.median(np.abs(y[1:-1] - (y[:-2] + y[2:]) / 2)))
    few = 1 + (_FEW_ROWS / len(y)) ** 2
    tolerance = DEVIATIONS_OUTLYING * few * max(noise, _RESOLUTION * float(np.median(np.abs(y))))
    # mu is between the medians of the three rows on either side, or beyond by as much as neighbours differ; at the
    # lowest speeds it may rise or fall steeply, and only a multiple of what follows is refused.
    lower = np.minimum(y[:-2], y[1:-1])
    upper = np.maximum(y[:-2], y[1:-1])
    third = y[2:]
    middle = np.maximum(lower, np.minimum(upper, third))
    gap_below = middle - np.minimum(lower, third)
    gap_above = np.maximum(upper, third) - middle
    i = np.arange(len(y))
    below = np.clip(i - _ROWS_BESIDE_OUTLIER, 0, None)
    above = np.clip(i + 1, None, len(y) - _ROWS_BESIDE_OUTLIER)
    below[:_ROWS_BESIDE_OUTLIER], above[-_ROWS_BESIDE_OUTLIER:] = (
        above[:_ROWS_BESIDE_OUTLIER],
        below[-_ROWS_BESIDE_OUTLIER:],
    )  # at an end, the rows on the other side
    low = np.minimum(middle[below], middle[above])
    high = np.maximum(middle[below], middle[above])
    least = np.minimum(gap_below, gap_above)
    largest = np.maximum(gap_below, gap_above)
    change = np.where(below == above, largest[below], np.maximum(least[below], least[above]))
    slack = np.maximum(tolerance, _RISES * change)
    first = np.abs(y) > _RISES * np.abs(high) + slack
    spans = v[_ROWS_BESIDE_OUTLIER - 1 :] - v[: 1 - _ROWS_BESIDE_OUTLIER]  # of trios
    gap = np.maximum(v - v[np.minimum(below + _ROWS_BESIDE_OUTLIER - 1, i)], v[np.maximum(above, i)] - v)
    mean = (v[-1] - v[0]) / len(np.unique(v))
    far = gap > np.maximum(_GAP_RATIOS[0] * np.maximum(spans[below], spans[above]), _GAP_RATIOS[1] * mean)
    return np.asarray(np.where(i < _ROWS_BESIDE_OUTLIER, first, (y < low - slack) | (y > high + slack)) & ~far)


def _fold(table: Table) -> tuple[FloatArray, FloatArray, FloatArray | None, IntArray, list[str]]:
    """Return slip speeds in m/s, coefficients, standard deviations, directions, and what was done with signs."""
    friction, load = ("F_t", "F_n") if "F_t" in table.columns else ("mu", None)
    deviation = next((key for key in ("sigma_mu", "sigma_F_t") if key in table.columns), None)
    if deviation is not None:
        rule = "a standard deviation is above 0"
        table.require(table.floats(deviation) > 0, deviation, rule, "without a standard deviation")
    down = 1.0
    if load is not None:
        signs = np.sign(table.floats(load))
        down = 1.0 if signs.sum() >= 0 else -1.0
        table.require(signs == down, load, "a normal force is not 0, and has one sign", "without a normal force")
    mu = down * table.numbers(friction, load)
    rule = f"a coefficient of friction is below {_LARGEST_MU:g}"
    table.require(np.abs(mu) <= _LARGEST_MU, friction, rule, "with abs(mu) above 5")
    v = table.numbers("v")
    mu = mu[np.abs(mu) <= _LARGEST_MU]
    if (fast := np.abs(v) > _FASTEST).any() and not table.columns["v"].unit_text:
        row = int(np.argmax(fast))
        raise InputError(
            f"{table.place(row, 'v')}: got v = {table.cell('v', row)}; without a unit a speed is in m/s; write "
            "it, like v [mm/s]"
        )
    mu, direction, notes = _remove_stroke_signs(table, np.sign(v), mu, friction)
    sigma = None
    if deviation is not None:
        sigma = np.abs(table.numbers(deviation, load if "F_t" in deviation else None))
    return np.abs(v), mu + 0.0, sigma, direction.astype(np.int64), notes  # -0.0 becomes 0.0


def _remove_stroke_signs(
    table: Table, way: FloatArray, mu: FloatArray, friction: str
) -> tuple[FloatArray, FloatArray, list[str]]:
    """Return coefficients without the signs of strokes, the direction of each, and what to say of it.

    With the speed friction turns its sign. Signs that are noise stay: magnitudes would push small means up.
    """
    reverses = bool((way < 0).any() and (way > 0).any())
    notes = ["both signs of speed folded"] if reverses else []
    if (mu >= 0).all():
        return mu, way, notes
    along = way if reverses else np.ones_like(mu)
    below, above = (int((side * along * mu > 0).sum()) for side in (-1, 1))
    direction = -1 if below > above else 1
    if min(below, above) <= FEW * (below + above):  # noise of a small force
        folded = np.where(along == 0, np.abs(mu), direction * along * mu)  # a speed of 0 has no direction
        return folded, way, notes
    if reverses:
        wrong = int(np.argmax(direction * along * mu < 0))
        raise InputError(
            f"{table.place(wrong, friction)}: {friction} = {table.cell(friction, wrong)} at v = "
            f"{table.cell('v', wrong)} is along the motion, "
            "and in most rows it is against it; give friction the sign of the speed, or no sign"
        )
    return np.abs(mu), np.sign(mu), [*notes, f"both signs of {friction} folded"]
