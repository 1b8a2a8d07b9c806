"""Single steps of two plain numbers q and w: an explicit Runge-Kutta method of order 8, and an implicit one.

The explicit one is SciPy's DOP853, coefficients and step control, written for two floats: SciPy's own works on
arrays, which for two unknowns cost four times what the arithmetic does. The implicit one is SciPy's Radau. Both
work alike: `step()` returns the interpolant of the step it took.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from operator import mul
from typing import Protocol

import numpy as np
from scipy.integrate import DOP853, Radau

from stickslip_sym.core.aliases import FloatArray, Numbers

__all__ = ["Explicit", "Implicit", "Interpolant", "Pair", "Point", "Rates"]

Pair = tuple[Numbers, Numbers] | FloatArray
"""q and w: two numbers, or two arrays."""
Rates = Callable[[float, float], tuple[float, float]]
"""q' and w' at (q, w)."""

_STAGES = [row[:i].tolist() for i, row in enumerate(DOP853.A)][1:]
_END, _ERROR_3, _ERROR_5 = DOP853.B.tolist(), DOP853.E3.tolist(), DOP853.E5.tolist()
_EXTRA = [row[: 13 + i].tolist() for i, row in enumerate(DOP853.A_EXTRA)]
_DENSE = DOP853.D.tolist()
_SMALL = 0.01  # states below count as that large: events are where w is 0, so it is less than their order of one
_SAFETY, _LEAST, _MOST = 0.9, 0.2, 10.0
_EXPONENT = -1 / (DOP853.error_estimator_order + 1)


@dataclass(frozen=True)
class Point:
    """A state (q, w) at a time tau."""

    tau: float
    q: float
    w: float


class Interpolant(Protocol):
    """The interpolant of one step: rows q and w at times from that of `start` to `t`."""

    @property
    def start(self) -> Point: ...  # noqa: D102

    @property
    def t(self) -> float: ...  # noqa: D102

    def __call__(self, tau: Numbers) -> Pair: ...  # noqa: D102


class Explicit:
    """Steps of DOP853.

    - `end`: time that no step passes.
    - `rtol`: relative tolerance of a step; the absolute one is a hundredth of it, all states being of order one.
    - `step`: length of the first step.
    - `longest`: of a step.

    - `slope`: w' there.
    - `length`: of the next step, as far as it is foreseen.
    """

    def __init__(
        self, rates: Rates, start: Point, end: float, rtol: float,
        *, step: float | None = None, longest: float = math.inf,
    ) -> None:  # fmt: skip
        self.rates, self.now, self.end, self.rtol, self.longest = rates, start, end, rtol, longest
        self._first = rates(start.q, start.w)
        fast = max(1.0, abs(self._first[0]), abs(self._first[1]))
        # As a rule states are of order one, and so is what the error of order 8 is relative to; in a motion that
        # grows without bound they are not, and no step is shorter than the rounding of the time.
        first = max(rtol**-_EXPONENT / fast, 100 * math.ulp(start.tau))
        self.length = step if step is not None else first

    @property
    def slope(self) -> float:
        """The rate w' now."""
        return self._first[1]

    def step(self) -> Interpolant | None:
        """Take one step; None if none is short enough for the tolerance."""
        now, shortened = self.now, False
        while True:
            h = min(self.length, self.longest, self.end - now.tau)
            if h <= 10 * math.ulp(now.tau) and h < self.end - now.tau:
                return None
            course = _Course(self.rates, now, h, *_stages(self.rates, now, h, self._first))
            error = self._error(course)
            if error < 1:
                break
            # What is not finite compares as false, and counts as the largest error.
            factor = _SAFETY * error**_EXPONENT if error < math.inf else 0.0
            self.length, shortened = h * max(_LEAST, factor), True
        factor = _MOST if error == 0 else min(_MOST, _SAFETY * error**_EXPONENT)
        self.length = h * (min(1.0, factor) if shortened else factor)
        self.now = course.last
        self._first = (course.dq[-1], course.dw[-1])
        return course

    def _error(self, course: "_Course") -> float:
        fifth = third = 0.0
        for rates, before, after in (
            (course.dq, course.start.q, course.last.q),
            (course.dw, course.start.w, course.last.w),
        ):
            scale = self.rtol * (_SMALL + max(abs(before), abs(after)))
            high, low = (sum(map(mul, row, rates)) / scale for row in (_ERROR_5, _ERROR_3))
            fifth += high * high  # a power would raise where a product overflows
            third += low * low
        if fifth == third == 0:
            return 0.0
        return course.length * fifth / math.sqrt(2 * (fifth + 0.01 * third))


def _stages(
    rates: Rates, start: Point, h: float, first: tuple[float, float]
) -> tuple[list[float], list[float], Point]:
    """Return q' and w' at the 12 stages and at the end, and the end."""
    q, w = start.q, start.w
    dq, dw = [first[0]], [first[1]]
    for row in _STAGES:
        slope = rates(q + h * sum(map(mul, row, dq)), w + h * sum(map(mul, row, dw)))
        dq.append(slope[0])
        dw.append(slope[1])
    last = Point(start.tau + h, q + h * sum(map(mul, _END, dq)), w + h * sum(map(mul, _END, dw)))
    slope = rates(last.q, last.w)
    return [*dq, slope[0]], [*dw, slope[1]], last


class _Course:
    """The interpolant of order 7 of an explicit step; its three extra stages are computed when first needed."""

    def __init__(
        self, rates: Rates, start: Point, length: float, dq: list[float], dw: list[float], last: Point
    ) -> None:
        self.rates, self.start, self.length, self.dq, self.dw, self.last = rates, start, length, dq, dw, last
        self.t = last.tau

    def __getstate__(self) -> dict[str, object]:
        # The rates cannot be pickled, and are for the rows only.
        return {"start": self.start, "length": self.length, "t": self.t, "_rows": self._rows}

    @cached_property
    def _rows(self) -> tuple[list[float], list[float]]:
        h, start, last = self.length, self.start, self.last
        dq, dw = list(self.dq), list(self.dw)
        for row in _EXTRA:
            slope = self.rates(start.q + h * sum(map(mul, row, dq)), start.w + h * sum(map(mul, row, dw)))
            dq.append(slope[0])
            dw.append(slope[1])

        def row_of(rates: list[float], rise: float) -> list[float]:
            begin, end = h * rates[0], h * rates[12]
            high = [h * sum(map(mul, row, rates)) for row in reversed(_DENSE)]
            return [*high, 2 * rise - begin - end, begin - rise, rise]

        return row_of(dq, last.q - start.q), row_of(dw, last.w - start.w)

    def __call__(self, tau: Numbers) -> Pair:
        forward, (of_q, of_w) = (tau - self.start.tau) / self.length, self._rows
        return _nested(of_q, forward, self.start.q), _nested(of_w, forward, self.start.w)


def _nested(row: list[float], forward: Numbers, origin: float) -> Numbers:
    """Evaluate a polynomial whose nested factors are by turns the distances to the end and from the start."""
    value: Numbers = 0.0
    for i, coefficient in enumerate(row):
        value = (value + coefficient) * (1 - forward if i % 2 else forward)
    return origin + value


class Implicit:
    """Steps of Radau, with the interface of `Explicit`.

    Its Jacobian is that of any slip phase: q' falls by `side` a unit of w, w' rises by as much a unit of q, and
    falls by `decay(w)` a unit of w.
    """

    def __init__(
        self, rates: Rates, start: Point, end: float, rtol: float,
        *, side: int, decay: Callable[[float], float], step: float | None = None,
    ) -> None:  # fmt: skip
        # Radau's estimate is of order 3, its solution of order 5.
        loose = rtol ** (2 / 3)
        first = None if step is None else min(step, end - start.tau)
        self._solver = Radau(
            lambda _, state: np.array(rates(*state.tolist())),
            start.tau, np.array((start.q, start.w)), end,
            rtol=loose, atol=loose, first_step=first,
            jac=lambda _, state: np.array(((0.0, -side), (side, -decay(max(float(state[1]), 0.0))))),
        )  # fmt: skip
        self.now, self.end = start, end

    @property
    def slope(self) -> float:
        """The rate w' now."""
        return float(self._solver.f[1])

    @property
    def length(self) -> float:
        """Of the next step, as far as it is foreseen."""
        return float(self._solver.h_abs)

    def step(self) -> Interpolant | None:
        """Take one step; None if none is short enough for the tolerance, or the linear algebra fails."""
        start = self.now
        try:
            self._solver.step()
        except ValueError:  # from a state that is not finite
            return None
        if self._solver.status == "failed":
            return None
        self.now = Point(float(self._solver.t), *self._solver.y.tolist())
        return _Implicit(start, self.now.tau, self._solver.dense_output())


@dataclass
class _Implicit:
    """The interpolant of an implicit step."""

    start: Point
    t: float
    course: Callable[[Numbers], Pair]

    def __call__(self, tau: Numbers) -> Pair:
        return self.course(tau)
