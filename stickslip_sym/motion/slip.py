"""An oscillator free of units, and its slips, one in plain Python or many; `kernel` says how."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray
from stickslip_sym.core.deadline import check_time, is_late, time_left
from stickslip_sym.core.errors import InputError, NotConverged, OutOfTime, StickSlipError
from stickslip_sym.model.bound import BoundLaw
from stickslip_sym.model.oscillator import Oscillator, as_oscillator
from stickslip_sym.model.table import FARTHEST, FrictionTable, Rise
from stickslip_sym.motion.compiled import compilable, compiled, is_compiling, is_ready
from stickslip_sym.motion.kernel.follow import follow
from stickslip_sym.motion.kernel.forces import entered, rate_at
from stickslip_sym.motion.kernel.slip_data import (
    ADDED,
    LONGEST_STEP,
    MOST_STEPS,
    TIGHT,
    Branch,
    Field,
    SlipEnd,
    SlipState,
    SlipStep,
    Stop,
    Wedge,
    no_wedge,
)
from stickslip_sym.motion.kernel.steps import stepped
from stickslip_sym.motion.workers import collect
from stickslip_sym.numerics.known import Column, Unknown
from stickslip_sym.numerics.resolved import NODES

Number = TypeVar("Number")


class Slip(NamedTuple, Generic[Number]):
    """The end of a slip, or of many as arrays: why, when, where, and how far it went.

    - `end`: an `SlipEnd`, or the numbers of them.
    - `rate`, `wedge`: w' and D there.
    - `taken`, `passed`: how many steps it took, and how often the mass passed the belt's speed.
    - `q_least` to `u_most`: extremes of q, and of u = side w, at the ends of its steps.
    - `steps`: all of them where they were recorded.
    """

    end: Any
    tau: Number
    q: Number
    w: Number
    side: Number
    rate: Number
    wedge: Number
    taken: Number
    passed: Number
    q_least: Number
    q_most: Number
    u_least: Number
    u_most: Number
    steps: Sequence[SlipStep] = ()

    def one(self, number: int) -> "Slip[float]":
        """Return one of many."""
        end, *numbers = (column[number].item() for column in self[:-1])  # type: ignore[index]  # of arrays
        return Slip(SlipEnd(end), *numbers)


class RoundEnds(NamedTuple):
    """What many rounds outside P's orbit come to.

    - `ends`: the displacements where slip slower than the belt begins again: 0 for a mass that sticks before, or
      stays slower than the belt, infinite for one that moves away for ever, or beyond what was measured.
    - `sticks`, `slower`, `leaves`: which ones stick, which stay slower, and which move away.
    """

    ends: Column
    sticks: BoolArray
    slower: BoolArray
    leaves: BoolArray


_LOST = Unknown("a round takes too many steps")


@compilable
def _follow_all(rise: Rise, columns: Any, rtol: float, until: int, level: float, rows: Any) -> None:
    """Follow many slips, into rows as a `Slip` has them."""
    eta, push, side, damping, hold, q, w, horizon, most, passes = columns
    wedge = no_wedge(rise)
    for i in range(len(q)):
        field = Field(eta[i], push[i], side[i], damping[i])
        begin = SlipState(0.0, q[i], w[i], side[i], 0.0, 0.0)
        stop = Stop(until, level, horizon[i], int(most[i]), int(passes[i]), LONGEST_STEP)
        run = follow(rise, field, hold[i], begin, stop, wedge, rtol, False)
        rows[i, 0] = run.end.value
        rows[i, 1], rows[i, 2], rows[i, 3], rows[i, 4], rows[i, 5], rows[i, 6] = run.state
        rows[i, 7], rows[i, 8], rows[i, 9], rows[i, 10], rows[i, 11], rows[i, 12] = run.extent


@compilable
def _states(rise: Rise, columns: Any, field: Field, rtol: float, rows: Any) -> None:
    """Write q and w at times within steps into rows."""
    begin, q, w, rate, segment, implicit, tau = columns
    wedge = no_wedge(rise)
    for i in range(len(tau)):
        h = tau[i] - begin[i]
        if segment[i] < 0:
            rows[i, 0], rows[i, 1] = q[i] + h * (1.0 - field.side * w[i]), w[i]
        else:
            branch = entered(rise, int(segment[i]), True, w[i])
            state = SlipState(0.0, q[i], w[i], field.side, rate[i], 0.0)
            step = stepped(implicit[i] > 0, branch, field, state, h, rtol, wedge)
            rows[i, 0], rows[i, 1] = step.q, step.w


SAME_AMPLITUDE = 1e-9
"""Over V, the distance of amplitudes that are one, and of slip speeds: a smaller swing is rest."""
_FEW_STATES = 1000  # up to which plain Python is as fast as loading compiled code; so it is for `NODES` slips
_SLIPS_A_BATCH = 4000  # slips that a thread takes at once, mostly some hundredths of a second compiled
_BETWEEN_LOOKS = 0.05  # seconds between two looks at a time limit


@dataclass(frozen=True)
class NondimensionalOscillator:
    """An oscillator with its law, free of units: the equations of `kernel` with their numbers.

    Attributes
    ----------
    eta : float
        N/(V sqrt(k m)).
    zeta : float
        c/(2 sqrt(k m)).
    table : FrictionTable
    V : float
        The belt's speed in m/s, the unit of w.

    Examples
    --------
    The slip from P, up to the belt's speed or the first minimum of the slip speed above:

    >>> from stickslip_sym import Oscillator, laws
    >>> osc = Oscillator(m=1.0, k=100.0, c=2.0, V=0.5, N=9.81)
    >>> system = NondimensionalOscillator.of(laws.exponential.typical().bound, osc)
    >>> slip = system.slip(0.0, 0.0, until=SlipEnd.MINIMUM)
    >>> slip.end.name, round(slip.tau, 6)
    ('RETURN', 5.677805)
    """

    eta: float
    zeta: float
    table: FrictionTable
    V: float

    @classmethod
    def of(cls, law: BoundLaw, osc: Oscillator) -> "NondimensionalOscillator":
        """Make an oscillator with a law dimensionless; raises as `BoundLaw.table`."""
        osc = as_oscillator(osc)
        system = cls(osc.eta, osc.zeta, law.table, osc.V)
        if law.curve is None and system.w_max <= 1.0:
            raise system.unmeasured(1.0)
        return system

    @cached_property
    def rise(self) -> Rise:
        """The rise of mu as a function of w, for plain Python."""
        return self.table.at(self.V)

    @property
    def w_max(self) -> float:
        """The slip speed up to which the law is measured, or tabulated where it varies for ever; else infinite."""
        return self.table.reach / self.V

    @property
    def backward(self) -> "NondimensionalOscillator":
        """The same backward in time, with q negated."""
        return replace(self, eta=-self.eta, zeta=-self.zeta)

    def push(self, side: float) -> float:
        """Return eta (side mu_static - mu(0+))."""
        return self.eta * (side * self.table.static - self.table.onset)

    def field(self, side: float) -> Field:
        """Return the forces on one side of the belt's speed."""
        return Field(self.eta, self.push(side), side, 2 * self.zeta)

    def acceleration(self, q: float, w: float, side: int = 1) -> float:
        """Return w', the rate at which the slip speed grows."""
        branch = Branch(self.rise.pieces, 0, len(self.rise.pieces) - 1, 0)
        return rate_at(branch, self.field(side), q, w)

    def decay(self, w: float) -> float:
        """Return -dw'/dw, the rate at which a deviation of the slip speed w >= 0 decays, between both sides."""
        low = max(w - 1e-6 * max(w, 1.0), 0.0)
        high = w + 1e-6 * max(w, 1.0)
        return (self.acceleration(0.0, low) - self.acceleration(0.0, high)) / (high - low)

    def turn(self, w: float) -> float:
        """Return the displacement q at which w' = 0 for a mass slower than the belt; at rest with w = 1."""
        return -self.acceleration(0.0, w)

    def sticks(self, q: Any) -> Any:
        """Whether static friction holds the mass at a displacement, or at many: |c V + k x| <= mu_static N."""
        return (q <= 0) & (q >= -2 * self.eta * self.table.static)

    @property
    def friction_far_out(self) -> float:
        """mu(V w)/w at slip speeds beyond every feature of the law; 0 if it is measured up to a speed."""
        if math.isfinite(self.table.reach):
            return 0.0
        end = self.table.end
        return (self.table.onset + self.table.rise(end)) * self.V / end

    def slip_speed(self, q: Any, u: Any) -> tuple[Any, Any]:
        """Return w and side for velocities u over the belt's; at the belt's speed, to where the mass leaves."""
        return np.abs(1 - u), np.where((u < 1) | ((u == 1) & (q >= 0)), 1.0, -1.0)

    @property
    def difference(self) -> Wedge:
        """The wedge of a motion with one beside it, at the same numbers and from another state."""
        return Wedge(0.0, 0.0, 0.0, self.rise.pieces, [0.0] * len(self.rise.jumps))

    def slip(
        self, q: float, w: float, side: float = 1, *, passes: int = 0, until: SlipEnd = SlipEnd.RETURN,
        level: float = math.inf, horizon: float = math.inf, rtol: float = TIGHT,
        wedge: tuple[Wedge, float] | None = None, most: int | None = None, recorded: bool = False,
    ) -> Slip[float]:  # fmt: skip
        """Follow one slip from (q, w), in plain Python.

        - `side`: 1 where the mass is slower than the belt, -1 where it is faster.
        - `passes`: how often it may pass the belt's speed where it does not stick; with none steps are recorded.
        - `until`: one more end beside `RETURN`: `MINIMUM`, `MAXIMUM`, or `LEVEL`, where w comes to `level`.
        - `level`: of w, at which a step ends in any case.
        - `horizon`: tau at which to stop; a motion that creeps ends at rest, however long it takes.
        - `rtol`: relative tolerance of a step.
        - `wedge`: the quantity of a wedge, and its value at the begin.
        - `most`: how many steps it may take; then, or when the time of a `time_limit` is up, it ends as it is.
          Without it that is an error, as is all that is no answer.
        - `recorded`: keep the steps.

        At w = 0 the slip is leaving, whatever rounding says of w'.

        Raises, without `most`, what `refusal` returns.
        """
        limits = horizon, MOST_STEPS if most is None else most, passes, LONGEST_STEP
        source, D = (no_wedge(self.rise), 0.0) if wedge is None else wedge
        run = follow(
            self.rise, self.field(float(side)), 2 * self.eta * self.table.static,
            SlipState(0.0, float(q), float(w), float(side), 0.0, D), Stop(int(until), level, *limits),
            source, rtol, recorded,
        )  # fmt: skip
        slip: Slip[float] = Slip._make((run.end, *run.state, *run.extent, run.steps))
        if most is None and (refusal := self.refusal(slip, rtol)) is not None:
            raise refusal
        return slip

    def slips(
        self, q: FloatArray, w: FloatArray, side: ArrayLike = 1.0, *,
        ratios: tuple[ArrayLike, ArrayLike] | None = None, passes: ArrayLike = 0, until: SlipEnd = SlipEnd.RETURN,
        level: float = math.inf, horizon: float = math.inf, rtol: float = TIGHT, most: int = MOST_STEPS,
        few: int | None = None, workers: int = 1,
    ) -> Slip[FloatArray]:  # fmt: skip
        """Follow many slips, compiled where numba is there; arguments as for `slip`, nothing is refused.

        - `ratios`: eta and zeta where they are not this system's.
        - `few`: how many are followed in plain Python; by default none where machine code is loaded.
        - `workers`: a number of threads, -1 for all processors.

        When the time of a `time_limit` is up, which is looked at between batches, the end of what is left is LATE.
        """
        etas, zetas = (self.eta, self.zeta) if ratios is None else ratios
        static = self.table.static
        onset = self.table.onset
        push = np.multiply(etas, np.multiply(side, static) - onset)
        hold = np.multiply(etas, 2 * static)
        damping = np.multiply(2.0, zetas)
        given = etas, push, side, damping, hold, q, w, horizon, most, passes
        columns = np.empty((len(given), *np.broadcast(*given).shape))
        for column, value in zip(columns, given, strict=True):
            column[:] = value
        sides = columns[2]
        u = columns[2] * columns[6]
        none = np.zeros(columns.shape[1:])
        rows = np.column_stack([none + SlipEnd.LATE, none, q, w, sides, *[none] * 4, q, q, u, u])
        halves = min(float(np.max(passes, initial=0)), horizon / math.pi)
        batch = math.ceil(_SLIPS_A_BATCH / (1.0 + halves))
        settings = rtol, int(until), level
        self.spread(_follow_all, [*columns], settings, rows, few=few, batch=batch, workers=workers)
        return Slip(*rows.T)

    def rounds(self, q: FloatArray, rtol: float, **options: Any) -> RoundEnds:
        """Follow rounds outside P's orbit, from displacements q >= 0 at the belt's speed, slower than it at first.

        - `options`: of `slips`.
        """
        slips = self.slips(q, np.zeros_like(q), passes=1, until=SlipEnd.MINIMUM, rtol=rtol, **options)
        returns = slips.end == SlipEnd.RETURN
        leaves = slips.end == SlipEnd.OUTSIDE
        slower = (slips.end == SlipEnd.MINIMUM) | (slips.end == SlipEnd.REST)
        # Without static friction P is passed by all that come to it but for rounding.
        sticks = returns & (slips.q <= 0) & (self.table.static > 0)
        ends = np.where(leaves, math.inf, np.where(returns, np.maximum(slips.q, 0.0), math.nan))
        ends[slower | sticks] = 0.0
        # A displacement is off by what the slip speed is, over the rate with which that comes to 0.
        size = np.maximum(1.0, np.maximum(slips.q_most - slips.q_least, slips.u_most - slips.u_least))
        with np.errstate(divide="ignore"):
            errors = ADDED * rtol * size * (1.0 + 1.0 / np.abs(slips.rate))
        errors[~returns | sticks] = 0.0
        return RoundEnds(Column.of(ends, np.minimum(errors, size), _LOST), sticks, slower, leaves)

    def states(
        self, steps: Sequence[SlipStep], which: IntArray, tau: FloatArray, side: float, rtol: float
    ) -> tuple[FloatArray, FloatArray]:
        """Return q and w at times within recorded steps, each by one shorter step from the begin of its step.

        - `which`: the number of the step for each time.
        """
        begin, q, w, rate, _, segment, implicit = np.array(steps, dtype=np.float64)[which].T
        columns = (begin, q, w, rate, segment, implicit, tau)
        rows = np.empty((len(tau), 2))
        self.spread(_states, columns, (self.field(side), rtol), rows, few=_FEW_STATES)
        check_time()
        return rows[:, 0], rows[:, 1]

    def spread(
        self, loop: Callable[..., None], columns: Sequence[FloatArray], settings: tuple[Any, ...],
        rows: FloatArray, *, few: int | None = None, batch: int = _SLIPS_A_BATCH, workers: int = 1,
    ) -> None:  # fmt: skip
        """Carry out a loop over many motions, compiled where numba is there and they are more than a few.

        The loop gets the rise, columns with an entry for each motion, the settings, and the rows for its results.

        - `rows`: those that are not reached when the time of a `time_limit` is up stay as they are.
        - `few`: how many are left to plain Python; by default none where machine code is loaded.
        - `batch`: how many motions a thread takes at once, at most all between two looks at the time.
        """
        if few is None:
            few = 0 if is_ready(loop) else NODES
        fast = len(columns[0]) > few and is_compiling()
        rise = self.table.at(self.V, arrays=fast)
        run = compiled(loop) if fast else loop

        def carry_out(some: slice) -> bool:
            low = some.start
            count = 1 if fast and time_left() < math.inf else length
            while low < some.stop and not (low and is_late()):
                motions = slice(low, min(low + count, some.stop))
                begin = time_left()
                part = tuple(np.array(column[motions], dtype=np.float64) for column in columns)
                run(rise, part if fast else [column.tolist() for column in part], *settings, rows[motions])
                low = motions.stop
                if begin - time_left() < _BETWEEN_LOOKS:
                    count = 2 * count
            return True

        length = batch if fast else max(len(rows), 1)  # plain Python looks at the time limit itself
        batches = [slice(low, low + length) for low in range(0, len(rows), length)]
        if None in collect(carry_out, batches, workers=workers, what="slips"):
            raise KeyboardInterrupt

    def unmeasured(self, w: float) -> InputError:
        """Return the refusal of a slip speed beyond the last one of the table."""
        limit = self.table.limit(f"{self.w_max:.6g} V")
        return InputError(f"the motion reaches a slip speed of {w:.6g} V, ", *limit)

    def refusal(self, slip: Slip[float], rtol: float) -> StickSlipError | None:
        """Return why a slip has no answer; None where it has one, or grows without bound."""
        if slip.end is SlipEnd.LATE:
            return OutOfTime("the time limit was reached")
        if slip.end is SlipEnd.STEPS:
            return NotConverged(
                f"one slip phase took over {slip.taken:.0f} steps up to {slip.tau:.3g}/omega: mu may be too "
                "rough; try a larger rtol"
            )
        if slip.end not in (SlipEnd.OUTSIDE, SlipEnd.FAILED) or self.unbounded(slip):
            return None
        if slip.end is SlipEnd.OUTSIDE and slip.w >= self.w_max:
            return self.unmeasured(slip.w)
        if slip.end is SlipEnd.OUTSIDE and not slip.taken:
            return InputError(f"mu cannot be computed at a slip speed of {slip.w:g} V, where the motion begins")
        return NotConverged(
            f"the slip phase cannot be integrated at rtol = {rtol:g} beyond a slip speed of {slip.w:.6g} V: "
            "mu may have no finite value there; try a larger rtol or another law"
        )

    def unbounded(self, slip: Slip[float]) -> bool:
        """Whether a slip grew beyond all bounds, and so out of the table."""
        return slip.end is SlipEnd.OUTSIDE and slip.w * self.V >= FARTHEST * (1 - 1e-13)
