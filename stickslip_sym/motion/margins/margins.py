"""`margins`: how much each quantity and parameter may change, alone, before stick-slip sets in or ends."""

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from typing import Any, SupportsIndex

import numpy as np

from stickslip_sym.core import deadline
from stickslip_sym.core.errors import NO_RESULT, InputError, OutOfTime, StickSlipError
from stickslip_sym.core.numbers import SAME, SEED, real, require_type
from stickslip_sym.core.progress import steps
from stickslip_sym.core.uncertain import UFloat, split
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.oscillator import Oscillator, as_oscillator
from stickslip_sym.motion.margins.critical import Critical, critical, critical_damping, excess
from stickslip_sym.motion.simulation.cycle import stick_slip_cycle
from stickslip_sym.motion.thresholds.methods import Method, MethodName
from stickslip_sym.motion.thresholds.threshold import Threshold, pure_slip_damping
from stickslip_sym.motion.thresholds.uncertainty import standard_errors
from stickslip_sym.numerics.known import Unknown
from stickslip_sym.output.data import DataResult, TableResult, columns_of
from stickslip_sym.output.shown import Report, views_of


@dataclass(frozen=True)
class Margin(DataResult):
    """How far one quantity is from where stick-slip sets in or ends, with all others as they are.

    Attributes
    ----------
    name : str
    value : float
        As it is, in SI units.
    below, above : Critical or None
        The nearest critical values; None if there is none within reach.
    """

    reported = ("name", "value", "below", "above", "change")

    name: str
    value: float
    below: Critical | None
    above: Critical | None

    @property
    def change(self) -> float:
        """The smallest relative change that reaches a critical value, with its sign; infinite if there is none."""
        changes = [end.value / self.value - 1 for end in (self.below, self.above) if end is not None]
        return min(changes, key=abs, default=math.inf)


@dataclass(frozen=True)
class Sampled:
    """The probability that stick-slip is possible, from samples.

    Attributes
    ----------
    probability, standard_error : float
        The share of the decided samples, and its standard error.
    undecided : float
        The share of samples whose threshold is not known, or that are no operating point, as where a parameter is
        negative that may not be.
    """

    probability: float
    standard_error: float
    undecided: float

    def __str__(self) -> str:
        undecided = ""
        if self.undecided:
            undecided = f", {100 * self.undecided:.2g} % undecided"
        return f"{self.probability:.3g} +/- {self.standard_error:.1g} (samples{undecided})"


@dataclass(frozen=True, repr=False)
class Margins(Report, TableResult):
    """How far an operating point is from where stick-slip sets in or ends.

    Attributes
    ----------
    threshold : Threshold
        The pure-slip damping.
    c : float
        Its damping, in kg/s.
    rows : tuple of Margin
        The smallest change first.
    probability : float or None
        That stick-slip is possible: that c lies below the threshold. Where the equilibrium is stable too, the
        initial condition decides. From the standard errors to first order; None where there are none.
    sampled : Sampled or None
        The same from seeded samples of the quantities, normal and correlated as they are.
    refused : mapping of str to str
        Quantities whose critical values could not be found, and why.
    open : mapping of str to tuple of (float, float)
        Quantities of which more critical values may lie within some intervals, or thresholds are not there.
    sticks : bool or None
        Whether the mass sticks where it comes to the belt's speed; None where c lies above the threshold, or that
        is not known. Where friction is weak, or mu(0) is 0, it overtakes the belt and slips on.
    """

    reported = ("stick_slip", "sticks", "threshold", "rows", "probability", "sampled", "refused", "open")

    threshold: Threshold[float]
    c: float
    rows: tuple[Margin, ...]
    probability: float | None
    sampled: Sampled | None
    refused: Mapping[str, str]
    open: Mapping[str, tuple[tuple[float, float], ...]]
    sticks: bool | None

    @property
    def stick_slip(self) -> bool:
        """Whether stick-slip is possible: c lies below the threshold, and the mass is held at the belt's speed."""
        return bool(self.c < self.threshold.value) and self.sticks is not False

    def _table_columns(self) -> dict[str, list[Any]]:
        columns = columns_of(self.rows, "name", "value", "below", "above", "change")
        for end in ("below", "above"):
            columns[end] = [None if critical is None else critical["value"] for critical in columns[end]]
        return columns

    def __repr__(self) -> str:
        return views_of(self).one_line(self)


def margins(
    law: FrictionLaw | str,
    osc: Oscillator,
    *,
    errors: Mapping[str, str | UFloat] | None = None,
    method: MethodName | Criterion | Method = "auto",
    rtol: float = 1e-3,
    samples: int = 200,
    reach: float = 10.0,
    each: float | None = None,
    time_limit: float | None = None,
) -> Margins:
    """Return how much each quantity and parameter may change, alone, before stick-slip sets in or ends.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound; those that carry a standard error make a probability.
    osc : Oscillator
    errors : mapping of str to number with a standard error, optional
        V, N, m, k or c with theirs, as in ``{"V": "0.50(1)"}``; their values are those of `osc`.
    method, rtol
        As for `critical`.
    samples : int
        Seeded samples for the probability; each takes less than a threshold. 0 for none.
    reach : float
        How far changes are looked for: from a value over it to the value times it, above 1. That of c needs no
        search, and is given wherever it lies.
    each : float, optional
        Seconds for the critical values of one quantity, after which it is among the refused.
    time_limit : float, optional
        Seconds of computation after which it is given up.

    Returns
    -------
    Margins
        Critical values within reach.

    Raises
    ------
    InputError
        As `critical`, and for an error of what has none, or of another value than the oscillator's.
    OutOfTime
        When the time limit is reached.

    Examples
    --------
    >>> from stickslip_sym import Oscillator, laws
    >>> found = margins(laws.linear.typical(), Oscillator(m=1, k=100, c=2, V=0.5, N=9.81))
    >>> print(found.rows[0].name, f"{found.rows[0].change:+.3f}")
    c -0.264
    """
    law = as_law(law)
    require_type("samples", samples, SupportsIndex, "a whole number")
    reach = real("reach", reach)
    if not reach > 1:
        raise InputError(f"reach = {reach:g} is no factor above 1, by which a value may change; 10 is usual")
    carried = carried_by(osc, errors or {})
    quantities = asdict(osc)
    if samples < 0:
        raise InputError(f"samples = {samples} must not be negative; 0 is for none")
    deadline.require_seconds(each)
    with deadline.time_limit(time_limit):
        numbers = {name: carried.get(name, quantities[name]) for name in "VNmk"}
        threshold = pure_slip_damping(law, **numbers, method=method, rtol=rtol)
        return margins_of(threshold, osc, carried.get("c"), method, rtol, samples=samples, reach=reach, each=each)


def margins_of(
    threshold: Threshold[float], osc: Oscillator, c: UFloat | None,
    method: MethodName | Criterion | Method = "auto", rtol: float = 1e-3,
    *, samples: int, reach: float, each: float | None,
) -> Margins:  # fmt: skip
    """Return margins as `margins` does, about a threshold that is there; `c` is the damping with its error."""
    law = threshold.points.law
    rows = list[Margin]()
    refused = dict[str, str]()
    open_ = {}
    quantities = asdict(osc)
    values = quantities | {name: float(value) for name, value in law.values.items()}
    with steps([name for name, value in values.items() if value], "margins of {}".format) as names:
        for name in names:
            value = values[name]
            others = {key: number for key, number in quantities.items() if key != name}
            within = sorted((value / reach, value * reach))
            try:
                with deadline.time_limit(each):
                    if name == "c":
                        criticals = critical_damping(threshold)
                    else:
                        criticals = critical(law, name, **others, method=method, rtol=rtol, within=within)
            except StickSlipError as error:
                deadline.check_time()  # raises if it was the limit on all of them
                refused[name] = f"not found within {each} s" if isinstance(error, OutOfTime) else str(error)
                continue
            below = [end for end in criticals if end.value <= value]
            above = criticals[len(below) :]
            if criticals.unresolved:
                open_[name] = criticals.unresolved
            rows.append(Margin(name, value, below[-1] if below else None, above[0] if above else None))
    probability, sampled = _probabilities(threshold, osc.c, c, samples)
    sticks = None
    if osc.c < threshold.value and threshold.points.has_oscillator:
        with suppress(*NO_RESULT):
            sticks = stick_slip_cycle(law, osc) is not None
    rows.sort(key=lambda row: abs(row.change))
    return Margins(threshold, osc.c, tuple(rows), probability, sampled, refused, open_, sticks)


def carried_by(osc: Oscillator, errors: Mapping[str, str | UFloat]) -> dict[str, UFloat]:
    """Return the quantities that carry a standard error; each must have the oscillator's value."""
    osc = as_oscillator(osc)
    require_type("errors", errors, Mapping, "a mapping such as {'V': '0.50(1)'}")
    carried = {}
    for name, given in errors.items():
        if name not in ("V", "N", "m", "k", "c"):
            raise InputError(
                f"errors has {name!r}; it takes V, N, m, k and c; a parameter carries its own in the law"
            )
        _, read = split(given, name)
        if read is not None:
            own = getattr(osc, name)
            if not math.isclose(read.nominal_value, own, rel_tol=SAME):
                raise InputError(
                    f"{name} is {own:g} in the oscillator and {read.nominal_value:g} in errors; "
                    "give the same value"
                )
            carried[name] = read
    return carried


def _probabilities(
    threshold: Threshold[float], c: float, own: UFloat | None, samples: int
) -> tuple[float | None, Sampled | None]:
    """Return the probability that c lies below the threshold, to first order and from samples."""
    spread = 0.0 if own is None else own.std_dev
    first = 0.0 if threshold.budget is None else threshold.budget.uncertainty
    whole = math.hypot(first, spread)
    if whole == 0:
        return None, None
    probability = 0.5 * math.erfc((c - threshold.value) / (whole * math.sqrt(2)))
    if not samples:
        return probability, None
    names, covariance = standard_errors(threshold.points)
    (method,) = threshold.used.values()
    rng = np.random.default_rng(SEED)
    off = np.full(samples, np.nan)
    for i in range(samples):
        shift = rng.multivariate_normal(np.zeros(len(names)), covariance) if names else ()
        damping = c + spread * rng.standard_normal()
        with suppress(*NO_RESULT):  # where it is no operating point
            points = threshold.points.shifted(dict(zip(names, shift, strict=True)))
            sample = excess(points, damping, method if method.criterion else None)
            if not isinstance(sample, Unknown):
                off[i] = sample
    decided = off[np.abs(off) > 0]  # neither 0 nor NaN
    if not decided.size:
        return probability, Sampled(math.nan, math.nan, 1.0)
    share = float((decided > 0).mean())
    error = math.sqrt(max(share * (1 - share), 1 / decided.size) / decided.size)
    return probability, Sampled(share, error, 1 - decided.size / samples)
