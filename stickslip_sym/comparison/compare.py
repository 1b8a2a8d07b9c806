"""`compare`: the threshold of one operating point by every method, each with its error, status and time.

What one method gives is a `Row`, which `measured` makes, and several are a `Comparison`: the table of `derive`,
the trade-off and the study are made of the same rows.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from time import process_time
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

import numpy as np

from stickslip_sym.core.aliases import Json
from stickslip_sym.core.deadline import check_time, require_seconds
from stickslip_sym.core.errors import InputError, StickSlipError
from stickslip_sym.core.names import lookup
from stickslip_sym.core.numbers import read_rtol
from stickslip_sym.core.progress import stages, steps
from stickslip_sym.core.status import Status
from stickslip_sym.core.uncertain import UFloat
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.thresholds.methods import Reference, find_method
from stickslip_sym.motion.thresholds.methods import methods as every_method
from stickslip_sym.motion.thresholds.operating_points import OperatingPoints, oscillator_quantities
from stickslip_sym.motion.thresholds.threshold import Threshold, threshold_at
from stickslip_sym.output.data import DataResult, TableResult, columns_of
from stickslip_sym.output.shown import Report, views_of
from stickslip_sym.output.tables import duration

if TYPE_CHECKING:
    from stickslip_sym.output.shown import Figure

COMPARED_RTOL = 1e-10
"""Relative error that methods are asked for unless a user says otherwise."""
TIGHT_RTOL = 1e-11
"""The same where digits are shown, or costs are measured; a simulation states 1e-12 at best."""
EXPLAINED_RTOL = 1e-6
"""The same of values that say why a threshold is what it is, or how far it is, and of curves."""
Quantity: TypeAlias = float | str | UFloat
"""A quantity of an operating point in SI units, perhaps with a standard error."""
Result = TypeVar("Result")


@dataclass(frozen=True)
class Row(DataResult):
    """What one method gives.

    Attributes
    ----------
    method : str
    value : float or str
        Text where a float has too few digits; None where the method gives no value.
    relative_error : float or None
        None where it is unknown.
    status : Status or None
    seconds : float
        Time of the processor, of one value.
    reason : str
        Why there is no value; empty where there is one.
    setting : str
        The method's tolerance, number of nodes, digits or initial conditions; empty where there is nothing to set.
    threshold : Threshold or None
        All that is known of a threshold.
    further : mapping of str to float
        What else was measured.
    """

    method: str
    value: float | str | None = None
    relative_error: float | None = None
    status: Status | None = None
    seconds: float = math.nan
    reason: str = ""
    setting: str = ""
    threshold: Threshold[float] | None = None
    further: Mapping[str, float] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The method, and after a comma its setting."""
        return ", ".join(filter(None, (self.method, self.setting)))

    def text(self, column: str, form: str = ".1e") -> str:
        """Return an attribute, or what else was measured, as a cell of a table."""
        if self.value is None:
            if column == "value":
                return f"none: {self.reason}"
            return ""
        value = {**vars(self), **self.further}.get(column)
        if value is None:
            return "" if column == "status" else "unknown"
        if column == "seconds":
            return duration(self.seconds)
        if column == "relative_error" and self.threshold is not None:
            return self.threshold.accuracy(form=form).removeprefix("relative error ")
        if isinstance(value, float):
            return format(value, form)
        return str(value)


def measured(
    method: str,
    compute: Callable[[], Result],
    judge: Callable[[Result], Mapping[str, Any]],
    *,
    setting: str = "",
    count: int = 1,
    least: int = 1,
    enough: float = 0.0,
) -> Row:
    """Run a method, and return what it gives, or why it gives nothing.

    - `judge`: from its result to value, relative error and what else stands in a row.
    - `count`: values that one run gives.
    - `least, enough`: runs, and seconds that they take together, at least; the fastest counts.
    """
    times = list[float]()
    begin = process_time()
    try:
        with np.errstate(all="ignore"), stages() as say:
            say(", ".join(filter(None, (method, setting))), 0, 0)
            while len(times) < least or sum(times) < enough:
                check_time()
                begin = process_time()
                result = compute()
                times.append(process_time() - begin)
            return Row(method, setting=setting, seconds=min(times) / count, **judge(result))
    except (ArithmeticError, NameError, StickSlipError) as error:  # NumPy has no polylog, and lambdify prints it
        return Row(method, setting=setting, seconds=process_time() - begin, reason=str(error))


def threshold_row(threshold: Threshold[float]) -> Json:
    """Return what stands in a row of a threshold."""
    values = {name: getattr(threshold, name) for name in ("value", "relative_error", "status")}
    return values | {"threshold": threshold}


@dataclass(frozen=True, repr=False)
class Comparison(Report, TableResult):
    """One number at one operating point by several methods; `compare` makes that of a threshold.

    Attributes
    ----------
    title : str
    rows : tuple of Row
        In the order of the methods, from the simplest on.
    point : mapping of str to Quantity
        V, N, m and k as they were given.
    """

    title: str
    rows: tuple[Row, ...]
    point: Mapping[str, Quantity] = field(default_factory=dict)

    def __iter__(self) -> Iterator[Row]:
        return iter(self.rows)

    def __getitem__(self, method: str) -> Row:
        """Return what a method gives, by its name and setting."""
        return lookup("method compared", method, {row.name: row for row in self.rows})

    def plot(self, path: str | Path | None = None) -> "Figure":
        """Draw thresholds over the belt speed, with the last of the methods' that there is, and its point.

        Parameters
        ----------
        path : str or Path, optional
            A file to draw to: SVG, PNG or PDF, by its ending.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            If no method gave a threshold, matplotlib is not installed, or the file cannot be written.
        """
        return views_of(self).plot(self, path, None)

    def _table_columns(self) -> dict[str, list[Any]]:
        return columns_of(self.rows, "method", "setting", "value", "relative_error", "status", "seconds", "reason")

    def __repr__(self) -> str:
        values = sum(row.value is not None for row in self.rows)
        return f"{type(self).__name__}: {self.title}, {len(self.rows)} methods, {values} with a value"


def compare(
    law: FrictionLaw | str,
    osc: Oscillator | None = None,
    *,
    methods: str | Sequence[str] | None = None,
    rtol: float = COMPARED_RTOL,
    time_limit: float | None = None,
    **point: Quantity,
) -> Comparison:
    """Compute the threshold of one operating point by every method.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    osc : Oscillator, optional
        The operating point; its damping does not matter.
    methods : str or sequence of str, optional
        Names of methods; all that can be used if not given.
    rtol : float, optional
        Relative error that is asked of methods that can be made more accurate.
    time_limit : float, optional
        Seconds for each method.
    **point : float or str
        V, N, m and k in SI units, in place of `osc`, perhaps with standard errors. Without m and k only the slope
        averages are compared.

    Returns
    -------
    Comparison
        A row for each method; one that gives no value here says why.

    Raises
    ------
    InputError
        For an unknown method, or an operating point that is given twice, not at all, or with other names.

    Examples
    --------
    >>> from stickslip_sym import Oscillator, laws
    >>> for row in compare(laws.polynomial.typical(), Oscillator(m=1, k=100, V=0.5, N=9.81)):
    ...     print(f"{row.method:13} {row.value:.6f} {row.status}")
    equilibrium   3.310875 ESTIMATED
    least_squares 3.048107 ESTIMATED
    harmonic      3.034969 ESTIMATED
    second_order  3.036483 ESTIMATED
    simulation    3.036477 ESTIMATED
    orbit         3.036477 ESTIMATED
    proof         3.036477 PROVED
    """
    law = as_law(law)
    if (osc is None) == (not point):
        raise InputError("give the operating point once: an Oscillator, or V, N, m and k")
    if osc is not None:
        point = oscillator_quantities(osc, {}, "VNmk")
    if unknown := sorted(point.keys() - set("VNmk")):
        raise InputError(f"an operating point has V, N, m and k, not {', '.join(unknown)}")
    if methods is None:
        methods = [name for name, method in every_method().items() if "m" in point or not method.oscillator]
    elif isinstance(methods, str) or not isinstance(methods, Sequence):
        methods = [methods]
    chosen = [find_method(name) for name in methods]
    read_rtol(rtol, least=0.0, most=1.0)
    require_seconds(time_limit)  # below, an error is a method's answer
    shared = Reference()

    def threshold(method: str) -> Threshold[float]:
        return threshold_at(OperatingPoints.of(law, **point), method, rtol, time_limit, shared)

    # What converges comes first: the errors of averages are taken from it.
    order = sorted(range(len(methods)), key=lambda i: not getattr(chosen[i], "converges", True))
    rows = [Row("")] * len(methods)
    with steps(order, lambda _: "methods") as numbers:
        for i in numbers:
            rows[i] = measured(methods[i], partial(threshold, methods[i]), threshold_row)
    return Comparison(law.name or "a law", tuple(rows), point)
