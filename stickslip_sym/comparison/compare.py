"""`compare`: the threshold of one operating point by every method, each with its error, status and time."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias, TypeVar

from stickslip_sym.core.deadline import time_limit as limited
from stickslip_sym.core.errors import InputError, StickSlipError
from stickslip_sym.core.numbers import lookup, read_rtol
from stickslip_sym.core.uncertain import UFloat
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.thresholds.methods import find_method
from stickslip_sym.motion.thresholds.methods import methods as every_method
from stickslip_sym.motion.thresholds.operating_points import of_oscillator
from stickslip_sym.motion.thresholds.threshold import Threshold, pure_slip_damping
from stickslip_sym.output import markup
from stickslip_sym.output.tables import duration, table

Quantity: TypeAlias = float | str | UFloat
"""A quantity of an operating point in SI units, perhaps with a standard error."""
Result = TypeVar("Result")
HEADER = ("method", "c in kg/s", "relative error", "status", "time")


@dataclass(frozen=True)
class Answer:
    """What one method gives.

    Attributes
    ----------
    method : str
    threshold : Threshold or None
        None where the method gives no value.
    reason : str
        Why there is no value; empty where there is one.
    seconds : float
        Elapsed time.
    """

    method: str
    threshold: Threshold | None
    reason: str
    seconds: float

    @property
    def cells(self) -> list[str]:
        """The row of a table: method, damping, relative error, status and time, as text."""
        found = self.threshold
        if found is None:
            return [self.method, f"none: {self.reason}", "", "", ""]
        error = "unknown" if found.relative_error is None else f"{found.relative_error:.1e}"
        return [self.method, f"{found.value:.12g}", error, str(found.status), duration(self.seconds)]


def timed(compute: Callable[..., Result], *given: Any, **more: Any) -> tuple[Result | None, str, float]:
    """Return what is computed, or None and why it is not, and the elapsed time in seconds."""
    begin = time.perf_counter()
    try:
        return compute(*given, **more), "", time.perf_counter() - begin
    except StickSlipError as error:
        return None, str(error), time.perf_counter() - begin


@dataclass(frozen=True, repr=False)
class Comparison:
    """The threshold of one operating point by several methods; `compare` makes it.

    Attributes
    ----------
    law : FrictionLaw
    point : mapping of str to Quantity
        V, N, m and k as they were given.
    answers : tuple of Answer
        In the order of the methods, from the simplest on.
    """

    law: FrictionLaw
    point: Mapping[str, Quantity]
    answers: tuple[Answer, ...]

    def __iter__(self) -> Iterator[Answer]:
        return iter(self.answers)

    def __getitem__(self, method: str) -> Answer:
        """Return what a method gives, by its name."""
        return lookup("method compared", method, {one.method: one for one in self.answers})

    def __str__(self) -> str:
        return table(HEADER, [one.cells for one in self.answers])

    def __repr__(self) -> str:
        values = sum(one.threshold is not None for one in self.answers)
        return f"Comparison: {self.law.name or 'a law'}, {len(self.answers)} methods, {values} with a value"

    def _repr_html_(self) -> str:
        return markup.block(markup.table(HEADER, [one.cells for one in self.answers], caption=repr(self)))


def compare(
    law: FrictionLaw | str,
    osc: Oscillator | None = None,
    *,
    methods: str | Sequence[str] | None = None,
    rtol: float = 1e-10,
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
        A method that gives no value here says why in its row.

    Raises
    ------
    InputError
        For an unknown method, or an operating point that is given twice, not at all, or with other names.

    Examples
    --------
    >>> from stickslip_sym import Oscillator, laws
    >>> found = compare(laws.polynomial.typical(), Oscillator(m=1, k=100, V=0.5, N=9.81))
    >>> for one in found:
    ...     print(f"{one.method:13} {one.threshold.value:.6f} {one.threshold.status}")
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
        raise InputError("give the operating point once: an Oscillator, or V=, N=, m= and k=")
    if osc is not None:
        point = of_oscillator(osc, {}, "VNmk")
    if unknown := sorted(point.keys() - set("VNmk")):
        raise InputError(f"an operating point has V, N, m and k, not {', '.join(unknown)}")
    if methods is None:
        methods = [name for name, method in every_method().items() if "m" in point or not method.oscillator]
    elif isinstance(methods, str) or not isinstance(methods, Sequence):
        methods = [methods]
    for name in methods:
        find_method(name)
    read_rtol(rtol, least=0.0, most=1.0)
    with limited(time_limit):  # refuses a limit that is no number of seconds: below, an error is a method's answer
        pass
    options = {"rtol": rtol, "time_limit": time_limit, **point}
    answers = (Answer(name, *timed(pure_slip_damping, law, method=name, **options)) for name in methods)
    return Comparison(law, point, tuple(answers))
