"""Rounds outside P's orbit: motions that overtake the belt and do not stick, and their limit cycles.

A round begins at the belt's speed at a displacement q >= 0, slower than the belt, and ends where that begins
again, at R(q). Orbits in a plane do not cross, so R never falls; it counts as 0 where the mass sticks or stays
slower. A limit cycle is a q with R(q) = q. Where R(b) <= a there is none between a and b, and elsewhere
(R - q)/(R + q) is resolved as a function of log q, up to a reach beyond which no orbit is closed.

**The reach by energy.** With q taken from where all but the spring vanishes at the belt's speed, the force
a(w) = eta mu(V w) + 2 zeta w acts against the slip. Let a have one sign for all w >= W >= 1, U = W + 1, and
|a| <= M on the strip |u| <= U of velocities u over the belt's. Outside the strip the energy only falls, or only
grows. Where |q| >= B > M + U in it all along a closed orbit, |q| varies by 4 U there at most, and both crossings
of the strip change the energy by -2 J/B to first order, J = 2 int_0^W w a dw + int_W^(U+1) (w - 1) a dw. That has
the same sign, and outdoes all that is left out, if |J| (B - M) > M U^2 (4 U + 2 M): such an orbit is not closed.
A closed orbit with |q| < B somewhere in the strip stays within B + 8 U + M, since |u'| >= |q| - M there.

**The reach by losses.** Let eta mu >= l >= 0, and eta mu <= h at slip speeds w <= 1, where alone friction feeds
energy in; s = eta mu_static, zeta >= 0. An orbit that overtakes passes the belt's speed at X_R >= s - 2 zeta and
at -X_L >= s + 2 zeta. In a round it loses 2 l (X_R - X_L) at least to the part l of friction, and 2 zeta times its
area to damping, which is X_R - X_L + pi r^2/2 at least, if it passes u = 0 at -r. It gains (h - l) (d_R + d_L) at
most, on the stretches over which u goes from 1 to 0 and back, and the energy there gives
d_R^2 <= 1 + 2 (h - s + 2 zeta) d_R, d_L^2 <= 1 - 2 s d_L and r^2 >= 1 + s^2 - 2 h d_L. Where zeta or mu is
negative somewhere the same holds for a(w) in place of eta mu, without damping.
"""

import math
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np
from scipy.special import comb

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.deadline import check_time
from stickslip_sym.core.numbers import SAME
from stickslip_sym.model.table import TABLE_DEGREE, FrictionTable
from stickslip_sym.motion.kernel.slip_data import ADDED, PRECISE
from stickslip_sym.motion.orbits.damping import MOST_ORBITS, NEAREST
from stickslip_sym.motion.slip import NondimensionalOscillator
from stickslip_sym.numerics.known import Column, Unknown
from stickslip_sym.numerics.resolved import NODES, Resolved, Root, resolve
from stickslip_sym.numerics.subdivide import joined

_FARTHEST_DISPLACEMENT = 1e6  # displacement up to which cycles are sought where there is no reach
_SHARE_OF_FIRST_ROUND = 0.9  # of R(0): all rounds grow up to there
_SAME_PERIOD = 1e-6  # relative, periods of such a cycle by steps of two tolerances, or it is not known
_LOST = Unknown("a round takes too many steps")

_POWERS = np.arange(TABLE_DEGREE + 1)
_BINOMIAL = comb(_POWERS[:, None], _POWERS)
_BERNSTEIN = _BINOMIAL.T / comb(TABLE_DEGREE, _POWERS)[:, None]
"""Powers of a place from 0 to 1 in Bernstein's polynomials, between whose coefficients a polynomial lies."""
_GAUSS_NODES, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(
    TABLE_DEGREE // 2 + 1
)  # exact for w times such a polynomial


Kind = Literal["cycle", "jump", "open"]


class FixedPoint(NamedTuple):
    """Two displacements, and what lies between: a limit cycle, a jump of R past q, or what is not resolved.

    Between two different ones a limit cycle is stable: all rounds about it come to it at once, but for rounding.
    """

    low: float
    high: float
    kind: Kind


class Rounds(NamedTuple):
    """What rounds outside P's orbit do, from inside out.

    - `marks`: where it changes.
    - `growth`: 1 where rounds grow, -1 where they shrink, 0 where that is not known, before the first mark,
      between two, and after the last.
    """

    marks: tuple[FixedPoint, ...]
    growth: tuple[int, ...]


@lru_cache
def _bounded(table: FrictionTable, V: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the edges of intervals of w, and Bernstein coefficients of w and of mu(V w) on each, in rows."""
    pieces = np.asarray(table.at(V, arrays=True).pieces)
    end = table.end / V
    octaves = np.exp2(np.arange(-3.0, math.log2(max(end, 1.0))))
    edges = np.union1d(np.append(pieces[:, 0], end), octaves[octaves < end])
    rows = pieces[np.searchsorted(pieces[:, 0], edges[:-1], side="right") - 1]
    low = edges[:-1, None]
    width = np.diff(edges)[:, None]
    scale = rows[:, 2:3]
    # In powers of t = begin + scale width s, then of s from 0 to 1.
    begin = (low - rows[:, 1:2]) * scale
    shifts = np.tril(begin[:, :, None] ** np.maximum(_POWERS[:, None] - _POWERS, 0)) * _BINOMIAL
    powers = np.einsum("ik,ikj->ij", rows[:, 3:], shifts) * (scale * width) ** _POWERS
    return edges, low + width * _POWERS / TABLE_DEGREE, table.onset + powers @ _BERNSTEIN


def reaches(system: NondimensionalOscillator, eta: FloatArray, zeta: FloatArray) -> FloatArray:
    """Return how far out closed orbits may lie that overtake the belt, by their losses, for many oscillators.

    Where it is 0 or less there is none. It is infinite where a(w) < 0 somewhere.
    """
    edges, w, mu = _bounded(system.table, system.V)
    damping = np.where((zeta >= 0) & (mu.min() >= 0), zeta, 0.0)
    slower = edges[:-1] < 1
    low = eta * mu.min()
    high = eta * mu[slower].max()
    for i in np.flatnonzero(damping != zeta).tolist():
        a = eta[i] * mu + 2 * zeta[i] * w
        low[i], high[i] = a.min(), a[slower].max()
    s = eta * system.table.static
    ahead = high - s + 2 * damping
    d_L = np.hypot(s, 1) - s
    gain = (high - low) * (ahead + np.hypot(ahead, 1) + d_L)
    gain -= np.pi * damping * np.maximum(1 + s**2 - 2 * high * d_L, s**2)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where((low >= 0) & (low + damping > 0), gain / (2 * (low + damping)) - 2 * s, math.inf)


def reach(system: NondimensionalOscillator) -> float:
    """Return a displacement beyond which no orbit is closed; infinite if a has no certain sign far out."""
    edges, w, mu = _bounded(system.table, system.V)
    a = system.eta * mu + 2 * system.zeta * w
    low = a.min(axis=1)
    high = a.max(axis=1)
    nodes = (1 + _GAUSS_NODES[:, None]) / 2
    half = np.diff(edges) / 2
    basis = _BINOMIAL[-1] * nodes**_POWERS * (1 - nodes) ** _POWERS[::-1]
    speeds = w[:, :1] + 2 * half[:, None] * nodes.T
    J = np.append(0.0, 2 * np.cumsum(half * ((speeds * (a @ basis.T)) @ _GAUSS_WEIGHTS)))[:-1]
    W = edges[:-1]
    U = edges[:-1] + 1
    largest = np.maximum.accumulate(np.maximum(np.abs(low), np.abs(high)))
    M = largest[np.searchsorted(W, U + 1, side="right") - 1]
    least = math.inf
    noise = PRECISE * abs(system.eta * system.table.onset)
    for one_sign, work in ((low >= -noise, J), (high <= noise, -J)):
        certain = np.logical_and.accumulate(one_sign[::-1])[::-1] & (W >= 1) & (work > 0)
        with np.errstate(all="ignore"):
            B = M + np.maximum(U, M * U**2 * (4 * U + 2 * M) / work)
            least = min(least, float(np.nanmin((B + 8 * U + 2 * M)[certain], initial=math.inf)))
    return least


def rounds_outside(system: NondimensionalOscillator, rtol: float) -> Rounds:
    """Return where rounds outside P's orbit grow and shrink, with steps of a relative tolerance."""
    bound = float(reaches(system, np.array([system.eta]), np.array([system.zeta]))[0])
    if bound <= 0:
        return Rounds((), (-1,))
    bound = min(bound, reach(system))

    from_P = system.rounds(np.zeros(1), rtol, few=0)
    check_time()
    first = from_P.ends.at(0)
    if isinstance(first, Unknown):
        return Rounds((FixedPoint(0.0, math.inf, "open"),), (0, 0))
    if first >= bound:  # as where it moves away for ever
        return Rounds((), (1,))
    far = min(bound, _FARTHEST_DISPLACEMENT * max(1.0, first))

    if system.table.static == 0 and not from_P.slower[0]:
        inner, low = _sink(system, first, far, rtol)
    elif first == 0:
        inner, low = _rounds_that_stick(system, far, rtol)
    else:
        inner = Rounds((), (1,))
        low = _SHARE_OF_FIRST_ROUND * first
    if low >= far:
        return inner

    outer = _rounds_between(system, low, far, rtol)
    marks = (*inner.marks, *outer.marks)
    growth = (*inner.growth[:-1], *outer.growth)
    if far < bound:
        return Rounds((*marks, FixedPoint(far, math.inf, "open")), (*growth, 0))
    return Rounds(marks, growth)


def _end_of_round(system: NondimensionalOscillator, q: float, rtol: float) -> float | Unknown:
    """Return where one round ends."""
    ends = system.rounds(np.array([q]), rtol, few=0).ends
    check_time()
    return ends.at(0)


def _rounds_that_stick(system: NondimensionalOscillator, far: float, rtol: float) -> tuple[Rounds, float]:
    """Return what rounds do up to where none sticks any more, and from where they are to be looked at.

    Up to there they shrink. Where static friction holds a mass, faster than the belt, up to one displacement, R
    jumps.
    """
    inside = far * SAME
    low = far
    at_inside = _end_of_round(system, inside, rtol)
    at_low = _end_of_round(system, low, rtol)
    if isinstance(at_low, Unknown) or isinstance(at_inside, Unknown):
        return Rounds((FixedPoint(0.0, far, "open"),), (0, 0)), far
    if at_low <= 0:
        return Rounds((), (-1,)), far
    if at_inside > 0:
        low = inside
        at_low = at_inside
        inside = 0.0

    while at_low > inside and low > inside * (1 + rtol) and inside > 0:
        middle = math.sqrt(inside * low)
        R = _end_of_round(system, middle, rtol)
        if isinstance(R, Unknown):
            break
        if R <= 0:
            inside = middle
        else:
            low = middle
            at_low = R

    if at_low > inside:
        return Rounds((FixedPoint(inside, low, "jump"),), (-1, 1)), low
    return Rounds((), (-1,)), low


def _sink(system: NondimensionalOscillator, first: float, far: float, rtol: float) -> tuple[Rounds, float]:
    """Return the same of a law with mu(0) = 0, whose rounds may all come to one displacement but for rounding.

    So they do where the mass slips so slowly beside the belt's speed that it all but sticks. R never falls: all
    rounds from 0 to a displacement end between R(0) and its own end. It is as good as constant
    up to a displacement of which that is less than the part that is looked at of an amplitude.
    """
    q = np.geomspace(max(first, far * SAME), far, NODES)
    ends = system.rounds(q, rtol, few=0).ends
    check_time()
    come_in = np.flatnonzero(ends.known & (ends.filled(math.inf) <= NEAREST * q))
    if not come_in.size:
        return Rounds((), (1,)), _SHARE_OF_FIRST_ROUND * float(q[0])
    last = int(come_in[-1])
    low = float(q[last])
    beyond = float(q[min(last + 1, NODES - 1)])
    while beyond > low * (1 + rtol):
        middle = math.sqrt(low * beyond)
        R = _end_of_round(system, middle, rtol)
        if not isinstance(R, Unknown) and NEAREST * middle >= R:
            low = middle
        else:
            beyond = middle

    def period(rtol: float) -> float:
        return float(system.slips(np.zeros(1), np.zeros(1), passes=1, rtol=rtol, few=0).tau.item())

    by_steps = period(rtol)
    known = abs(by_steps - period(max(rtol / 10, PRECISE))) <= _SAME_PERIOD * by_steps
    kind: Kind = "cycle" if known else "open"
    return Rounds((FixedPoint(0.0, NEAREST * low, kind),), (1, -1)), low


def _rounds_between(system: NondimensionalOscillator, low: float, far: float, rtol: float) -> Rounds:
    """Return what rounds do between two displacements: (R - q)/(R + q) is resolved in log q."""

    def growth(x: FloatArray) -> Column:
        q = np.exp(x)
        ends = system.rounds(q, rtol, few=0).ends
        check_time()
        R = ends.filled(math.nan)
        with np.errstate(invalid="ignore"):
            grown = np.where(np.isinf(R), R, (R - q) / (R + q))
            errors = 2 * q * ends.errors / (R + q) ** 2
        return Column.of(grown, np.maximum(np.nan_to_num(errors), least), _LOST)

    least = ADDED * rtol
    growths = resolve(growth, [math.log(low), math.log(far)], rtol=least, most=MOST_ORBITS)

    marks = list[FixedPoint]()
    for begin, end in np.exp(joined(one[:2] for one in growths.open)).tolist():
        R = system.rounds(np.array([begin, end]), rtol, few=0).ends
        passes = R.surely(below=begin)[1] or R.surely(above=end)[0]
        if not passes:
            marks.append(FixedPoint(begin, end, "open"))
    folds = [math.exp(turn.x) for turn in growths.turns[1:-1] if abs(turn.value) <= turn.error]
    marks += [FixedPoint(q, q, "open") for q in folds]  # two cycles, or none
    for root in growths.roots():
        q = math.exp(root.x)
        marks.append(FixedPoint(q, q, _kind_of_root(growths, root, least)))
    marks.sort()

    directions = list[int]()
    begins = [low, *(mark.high for mark in marks)]
    ends = [*(mark.low for mark in marks), far]
    for begin, end in zip(begins, ends, strict=True):
        between = growths((math.log(begin) + math.log(end)) / 2)
        directions.append(int(np.sign(between)) * (abs(between) > least))
    return Rounds(tuple(marks), tuple(directions))


def _kind_of_root(growths: Resolved, root: Root, least: float) -> Kind:
    """Return what lies at a root of (R - q)/(R + q), known within `least`."""
    off, before, after = (growths(x) for x in root)
    if abs(before) > least and abs(after) > least:
        if before > 0 > after:
            return "cycle"  # R never falls, and so does not jump there: it is all but constant
        if abs(off) <= least:
            return "cycle"
    return "jump" if abs(off) > least else "open"
