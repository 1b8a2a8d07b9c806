"""`tradeoff`: speed against accuracy, measured, of every method for a criterion, a threshold and a basin."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from time import process_time
from typing import TYPE_CHECKING

import numpy as np

from stickslip_sym.comparison.candidates import Candidate, Problem, of_criterion, of_share, of_threshold
from stickslip_sym.core import deadline
from stickslip_sym.core.errors import InputError, NotConverged, StickSlipError
from stickslip_sym.core.numbers import Number, exact, suggestion
from stickslip_sym.criteria.criterion import Criterion, find
from stickslip_sym.formula.closed_form import derive
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.operating_point import LOW_SPEED, PAPER
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.thresholds.threshold import pure_slip_damping
from stickslip_sym.output import drawing, markup
from stickslip_sym.output.tables import duration, table, wrapped

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["KINDS", "Row", "Trade", "Tradeoff", "dominators", "draw", "measure", "tradeoff"]

KINDS = ("criterion", "threshold", "basin")
_REACH = 4 / 3  # of the box of initial conditions where none is given: in V/omega to both sides of 0, and in V
_DERIVING = 120.0  # seconds of the search for a closed form
_LEAST, _ENOUGH = 3, 0.02  # repetitions of a measurement, and seconds that they take together, at least
_WIDTH, _HEIGHT = 7.2, 3.5  # inches, of a panel of the picture
_SMALLEST = 1e-51  # error of a method whose own is less
_ROUNDING = 2.0**-52
_TITLE = 95  # characters of a line above a panel
_MARGIN = 12  # times the longest time, for the labels to its right
_COLORS = ("tab:blue", "tab:red", "tab:green", "tab:purple", "tab:orange", "tab:brown", "tab:olive", "tab:cyan")


@dataclass(frozen=True)
class Row:
    """One method at one tolerance, measured.

    Attributes
    ----------
    method : str
    setting : str
        Its tolerance, number of nodes, digits or initial conditions; empty where there is nothing to set.
    seconds : float
        Time of the processor, to one number; NaN where the method gives none.
    error : float
        Relative; NaN where the method gives no number.
    further : mapping
        What else is known: of a threshold its status and largest error over belt speeds, of a share its value
        and standard error.
    """

    method: str
    setting: str = ""
    seconds: float = math.nan
    error: float = math.nan
    further: Mapping[str, float | str] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The method, and after a comma its setting."""
        return ", ".join(filter(None, (self.method, self.setting)))

    @property
    def found(self) -> bool:
        """Whether the method gives a number."""
        return not math.isnan(self.seconds)

    def dominates(self, other: Row) -> bool:
        """Whether it is at least as fast and at least as accurate as another, and better in one of the two."""
        at_least = self.seconds <= other.seconds and self.error <= other.error
        return at_least and (self.seconds < other.seconds or self.error < other.error)


@dataclass(frozen=True)
class Trade:
    """The methods for one number, measured at one operating point.

    Attributes
    ----------
    number : str
        What kind of number: "value" of a criterion, "threshold" or "share" of a basin.
    title : str
        Which number it is, and at which operating point.
    rows : tuple of Row
    point : mapping
        Name to number, in SI units.
    box : mapping
        From and to, of the initial displacements x0 and velocities v0.
    columns : mapping of str to str
        Titles of what else is known of every row, by its key.
    """

    number: str
    title: str
    rows: tuple[Row, ...]
    point: Mapping[str, float] = field(default_factory=dict)
    box: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    columns: Mapping[str, str] = field(default_factory=dict)

    @property
    def dominators(self) -> dict[str, tuple[str, ...]]:
        """For each method which ones dominate it: at least as fast and as accurate, and better in one of the two.

        Named are those that are not dominated themselves.
        """
        return dominators(self.rows)

    @property
    def header(self) -> list[str]:
        """Titles of the table's columns."""
        return ["method", f"time a {self.number}", "relative error", *self.columns.values(), "dominated by"]

    @property
    def cells(self) -> list[list[str]]:
        """The table's cells as text, a line for each row."""
        by = self.dominators
        return [
            [
                row.name,
                duration(row.seconds) if row.found else "no number",
                f"{row.error:.1e}" if row.found else "",
                *(_further(key, row.further.get(key, "")) for key in self.columns),
                "; ".join(by[row.name]),
            ]
            for row in self.rows
        ]

    def __str__(self) -> str:
        return f"{self.title}\n\n{table(self.header, self.cells)}"


def _further(key: str, value: float | str) -> str:
    if isinstance(value, str):
        return value
    return "not measured" if math.isnan(value) else f"{value:.11g}" if key == "share" else f"{value:.2g}"


def dominators(rows: Iterable[Row]) -> dict[str, tuple[str, ...]]:
    """Return for each row which ones dominate it, of those that none dominates.

    They suffice: what is dominated at all is dominated by one of them.
    """
    rows = list(rows)
    front = [row for row in rows if not any(other.dominates(row) for other in rows)]
    return {row.name: tuple(other.name for other in front if other.dominates(row)) for row in rows}


def measure(problem: Problem) -> Trade:
    """Measure the time and the error of every candidate; one that fails, or is left when time is up, has none."""
    rows = tuple(_measured(problem, candidate) for candidate in problem.candidates)
    return Trade(problem.number, problem.title, rows, problem.point, problem.box, problem.columns)


def _measured(problem: Problem, candidate: Candidate) -> Row:
    times: list[float] = []
    least, enough = (_LEAST, _ENOUGH) if candidate.repeated else (1, 0.0)
    try:
        with np.errstate(all="ignore"):
            while len(times) < least or sum(times) < enough:
                deadline.check_time()
                begin = process_time()
                result = candidate.compute()
                times.append(process_time() - begin)
    except (ArithmeticError, NameError, StickSlipError):  # NumPy has no polylog, and lambdify prints it
        return Row(candidate.method, candidate.setting)
    further = problem.further(candidate, result)
    return Row(candidate.method, candidate.setting, min(times) / candidate.count, problem.error(result), further)


@dataclass(frozen=True, repr=False)
class Tradeoff(drawing.Drawn):
    """What each method for a number costs, and how far it is off, from one run.

    Attributes
    ----------
    trades : dict of str to Trade
        By kind: "criterion", "threshold" and "basin", as far as they were asked for and measured. Each has `rows`,
        with `seconds` and relative `error`, and `dominators`.
    refused : dict of str to str
        Of the others that were asked for, why there is none.
    """

    trades: dict[str, Trade]
    refused: dict[str, str] = field(default_factory=dict)

    def __str__(self) -> str:
        none = [f"{kind}: none: {reason}" for kind, reason in self.refused.items()]
        return "\n\n".join([*map(str, self.trades.values()), *none])

    def __repr__(self) -> str:
        counts = ", ".join(f"{len(trade.rows)} methods for a {kind}" for kind, trade in self.trades.items())
        return f"Tradeoff: {counts or 'nothing'}"

    def _repr_html_(self) -> str:
        tables = [markup.table(trade.header, trade.cells, caption=trade.title) for trade in self.trades.values()]
        return markup.block(drawing.picture(self.plot, repr(self)), *tables)

    def _figure(self) -> Figure:
        drawing.require_matplotlib()
        from matplotlib.figure import Figure

        figure = Figure(figsize=(_WIDTH, _HEIGHT * max(1, len(self.trades))), layout="constrained")
        for panel, trade in enumerate(self.trades.values(), 1):
            draw(trade, figure.add_subplot(len(self.trades), 1, panel))
        return figure


def draw(trade: Trade, ax: Axes) -> None:
    """Draw error against time: filled what no other method dominates, and hollow what one does."""
    by, rows = trade.dominators, [row for row in trade.rows if row.found]
    families = list(dict.fromkeys(row.method for row in trade.rows))
    labels, named = [], set()
    for row in rows:
        color = _COLORS[families.index(row.method) % len(_COLORS)]
        place = row.seconds, max(row.error, _SMALLEST)
        ax.plot(*place, "o", color=color, markerfacecolor="white" if by[row.name] else color)
        labels.append((row.setting or row.method if row.method in named else row.name, place, color))
        named.add(row.method)
    front = sorted((row.seconds, max(row.error, _SMALLEST)) for row in rows if not by[row.name])
    ends = zip(*front, strict=True) if front else ((), ())
    ax.plot(*ends, drawstyle="steps-post", color="0.75", lw=1, zorder=0)
    ax.set(xscale="log", yscale="log", xlabel=f"time for one {trade.number} (s)", ylabel="relative error")
    ax.set_title("\n".join(wrapped(trade.title, _TITLE)), fontsize=8)
    ax.margins(0.08, 0.12)
    left, right = ax.get_xlim()
    ax.set_xlim(left, right * _MARGIN)
    ax.axhline(_ROUNDING, color="0.8", lw=0.8, ls=":", zorder=0)
    ax.minorticks_off()
    ax.grid(alpha=0.25)
    drawing.label(ax, labels)


def tradeoff(
    law: FrictionLaw | str,
    *,
    of: str | Sequence[str] = KINDS,
    criterion: str | Criterion = "least_squares",
    x0: tuple[float, float] | None = None,
    v0: tuple[float, float] | None = None,
    time_limit: float | None = None,
    V: Number | None = None,
    N: Number | None = None,
    m: Number | None = None,
    k: Number | None = None,
    c: Number | None = None,
) -> Tradeoff:
    """Measure what each method for a number costs, and how far it is off; methods without this package too.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    of : str or sequence of str
        Of which numbers: "criterion", "threshold", "basin". Of several, one that cannot be measured here is left
        out, with the reason.
    criterion : str or Criterion
    x0, v0 : tuple of float, optional
        The box of initial conditions, displacements in m and velocities in m/s. If not given 4/3 V/omega to both
        sides of 0, and from 0 to 4/3 V.
    time_limit : float, optional
        Seconds after which no other method is tried; those that are left give no number.
    V, N, m, k : float or str, optional
        In SI units, text exactly. What is not given is the paper's; but the criterion is measured at V = 0.05 m/s,
        where the methods for it differ.
    c : float or str, optional
        Damping in kg/s, of the basins. If not given it is halfway from the linear threshold to the exact one.

    Returns
    -------
    Tradeoff

    Raises
    ------
    InputError
        For an unknown kind or criterion, or unusable numbers.
    StickSlipError
        If nothing can be measured, the reason of the first kind.

    Examples
    --------
    >>> from stickslip_sym import laws
    >>> found = tradeoff(laws.hyperbolic.typical(), of="criterion", V="0.001")
    >>> error = {row.name: row.error for row in found.trades["criterion"].rows}
    >>> error["plain lambdify, array"] > 1e-9 > 1e-15 > error["stable function, array"]
    True
    """
    law = as_law(law)
    kinds = [of] if isinstance(of, str) else list(of) if isinstance(of, Sequence) else []
    if not kinds:
        raise InputError(f"of = {of!r} names nothing to measure; there are: {', '.join(KINDS)}")
    for kind in kinds:
        if kind not in KINDS:
            known = ", ".join(KINDS)
            raise InputError(f"there is no trade of {kind!r}{suggestion(kind, list(KINDS))}; there are: {known}")
    if law.missing:
        raise InputError(f"the law has no value for {', '.join(law.missing)}; bind it first")
    chosen = find(criterion)
    given = {name: value for name, value in {"V": V, "N": N, "m": m, "k": k}.items() if value is not None}
    low, paper = {**PAPER, "V": LOW_SPEED, **given}, {**PAPER, **given}
    numbers = {name: float(exact(value, name)) for name, value in paper.items()}
    damping = None if c is None else float(exact(c, "c"))
    problems: dict[str, Callable[[], Problem]] = {
        "criterion": lambda: of_criterion(derive(law, chosen, time_limit=_left()), low),
        "threshold": lambda: of_threshold(law, numbers),
        "basin": lambda: of_share(*_with_box(law, numbers, damping, x0, v0)),
    }
    found, first = Tradeoff({}), None
    with deadline.time_limit(time_limit):
        for kind in kinds:
            try:
                trade = measure(problems[kind]())
            except StickSlipError as error:
                first = first or error
                found.refused[kind] = str(error)
            else:
                found.trades[kind] = trade
    if first is not None and not found.trades:
        raise first
    return found


def _left() -> float:
    return max(0.0, min(_DERIVING, deadline.time_left()))


def _with_box(
    law: FrictionLaw,
    point: Mapping[str, float],
    c: float | None,
    x0: tuple[float, float] | None,
    v0: tuple[float, float] | None,
) -> tuple[FrictionLaw, Oscillator, tuple[float, float], tuple[float, float]]:
    """Return law, oscillator and box, with the damping and the box that were not given."""
    if c is None:
        ends = [float(pure_slip_damping(law, **point, method=method).value) for method in ("equilibrium", "auto")]
        if not ends[0] < ends[1]:
            raise NotConverged(
                f"rest is stable from {ends[0]:.4g} kg/s on, and the threshold is {ends[1]:.4g} kg/s: rest and "
                "stick-slip coexist at no damping; give c, and a box where some motions come to rest"
            )
        c = sum(ends) / 2
    osc = Oscillator(c=c, **point)
    reach = _REACH * osc.V
    return law, osc, x0 or (-reach / osc.omega, reach / osc.omega), v0 or (0.0, reach)
