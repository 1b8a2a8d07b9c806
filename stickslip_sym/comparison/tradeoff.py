"""`tradeoff`: speed against accuracy, measured, of every way to a criterion, a threshold and a share of starts."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from stickslip_sym.comparison.ways import Trade
from stickslip_sym.core import deadline
from stickslip_sym.core.errors import InputError, NotConverged, StickSlipError
from stickslip_sym.core.numbers import Number, exact, suggestion
from stickslip_sym.criteria.criterion import Criterion, find
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.operating_point import LOW_SPEED, PAPER
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.thresholds.threshold import pure_slip_damping
from stickslip_sym.output import drawing, markup

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["KINDS", "Tradeoff", "tradeoff"]

KINDS = ("criterion", "threshold", "basin")
_REACH = 4 / 3  # of the box of starts that is taken where none is given: in V/omega to both sides of 0, and in V
_DERIVING = 120.0  # seconds of the search for a closed form


@dataclass(frozen=True, repr=False)
class Tradeoff(drawing.Drawn):
    """What each way to a number costs, and how far it is off, from one run.

    Attributes
    ----------
    trades : dict of str to Trade
        By kind: "criterion", "threshold" and "basin", as far as they were asked for and measured. Each has `ways`,
        with `seconds` and relative `error`, and `dominators`.
    refused : dict of str to str
        Of the others that were asked for, why there is none.
    """

    trades: dict[str, Trade[Any]]
    refused: dict[str, str] = field(default_factory=dict)

    def __str__(self) -> str:
        none = [f"{kind}: none: {reason}" for kind, reason in self.refused.items()]
        return "\n\n".join([*map(str, self.trades.values()), *none])

    def __repr__(self) -> str:
        counts = ", ".join(f"{len(trade.ways)} ways to a {kind}" for kind, trade in self.trades.items())
        return f"Tradeoff: {counts or 'nothing'}"

    def _repr_html_(self) -> str:
        tables = [
            markup.table(trade.header(), trade.rows(), caption=trade.title) for trade in self.trades.values()
        ]
        return markup.block(drawing.picture(self.plot, repr(self)), *tables)

    def _figure(self) -> "Figure":
        from stickslip_sym.comparison.tradeoff_picture import draw

        return draw(tuple(self.trades.values()))


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
    """Measure what each way to a number costs, and how far it is off: this package's, and what one writes without.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    of : str or sequence of str
        Of which numbers: "criterion", "threshold", "basin". Of several, one that cannot be measured here is left
        out, with the reason.
    criterion : str or Criterion
    x0, v0 : tuple of float, optional
        The box of starts, displacements in m and velocities in m/s. If not given 4/3 V/omega to both sides of 0,
        and from 0 to 4/3 V.
    time_limit : float, optional
        Seconds after which no other way is tried; those that are left give no number.
    V, N, m, k : float or str, optional
        In SI units, text exactly. What is not given is the paper's; but the criterion is measured at V = 0.05 m/s,
        where the ways to it differ.
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
    found, first = Tradeoff({}), None
    with deadline.time_limit(time_limit):
        for kind in kinds:
            try:
                if kind == "criterion":
                    trade = _of_criterion(law, chosen, low)
                elif kind == "threshold":
                    trade = _of_threshold(law, numbers)
                else:
                    trade = _of_basin(law, numbers, damping, x0, v0)
            except StickSlipError as error:
                first = first or error
                found.refused[kind] = str(error)
            else:
                found.trades[kind] = trade
    if first is not None and not found.trades:
        raise first
    return found


def _of_criterion(law: FrictionLaw, criterion: Criterion, scene: dict[str, Number]) -> Trade[Any]:
    from stickslip_sym.comparison.criterion_tradeoff import criterion_tradeoff
    from stickslip_sym.formula.closed_form import derive

    form = derive(law, criterion, time_limit=max(0.0, min(_DERIVING, deadline.time_left())))
    return criterion_tradeoff(form, {name: scene[name] for name in "VN"})


def _of_threshold(law: FrictionLaw, scene: dict[str, float]) -> Trade[Any]:
    from stickslip_sym.comparison.threshold_tradeoff import threshold_tradeoff

    return threshold_tradeoff(law, scene)


def _of_basin(
    law: FrictionLaw,
    scene: dict[str, float],
    damping: float | None,
    x0: tuple[float, float] | None,
    v0: tuple[float, float] | None,
) -> Trade[Any]:
    from stickslip_sym.comparison.basin_tradeoff import basin_tradeoff

    if damping is None:
        ends = [float(pure_slip_damping(law, **scene, method=method).value) for method in ("equilibrium", "auto")]
        damping = sum(ends) / 2
        if not ends[0] < ends[1]:
            raise NotConverged(
                f"rest is stable from {ends[0]:.4g} kg/s on, and the threshold is {ends[1]:.4g} kg/s: rest and "
                "stick-slip coexist at no damping; give a c and a box of starts of which some come to rest"
            )
    reach = _REACH * scene["V"]
    across = reach / math.sqrt(scene["k"] / scene["m"])
    osc = Oscillator(c=damping, **scene)
    return basin_tradeoff(law, osc, x0=x0 or (-across, across), v0=v0 or (0.0, reach))
