"""Which motion an initial condition leads to."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core import deadline
from stickslip_sym.core.aliases import FloatArray, IntArray, ObjectArray
from stickslip_sym.core.errors import StickSlipError
from stickslip_sym.core.numbers import read_rtol
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.oscillator import Oscillator, as_oscillator
from stickslip_sym.motion.kernel.slip_data import ADDED, SlipEnd
from stickslip_sym.motion.motion import Motion
from stickslip_sym.motion.orbits.damping import MOST_ORBITS
from stickslip_sym.motion.regimes.regime import kept_regime
from stickslip_sym.motion.simulation.simulate import read_initial_conditions


@overload
def classify(
    law: FrictionLaw | str, osc: Oscillator, *, x0: float = ..., v0: float | None = ..., rtol: float = ...,
    time_limit: float | None = ..., workers: int = ...,
) -> Motion: ...  # fmt: skip


@overload
def classify(
    law: FrictionLaw | str, osc: Oscillator, *, x0: ArrayLike = ..., v0: ArrayLike | None = ..., rtol: float = ...,
    time_limit: float | None = ..., workers: int = ...,
) -> Motion | ObjectArray: ...  # fmt: skip


def classify(
    law: FrictionLaw | str,
    osc: Oscillator,
    *,
    x0: ArrayLike = 0.0,
    v0: ArrayLike | None = None,
    rtol: float = 1e-10,
    time_limit: float | None = None,
    workers: int = 1,
) -> Motion | ObjectArray:
    """Return the motion to which an initial condition leads, or many.

    A mass that comes to stick leaves at P, and all that follows is the slip from there. One that only slips has
    peaks of velocity that grow or shrink up to the next limit cycle. So a few slip phases decide; and of many
    initial conditions those by which a separatrix does not pass are decided by their side of it.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound. One with mu(0) = 0 never sticks: its relaxation oscillation is pure slip.
    osc : Oscillator
    x0 : float or array
        Initial displacement in m, one or many.
    v0 : float or array, optional
        Initial velocity in m/s, on either side of the belt's; the belt's speed if not given. Arrays broadcast.
    rtol : float
        Relative tolerance of an integration step, 1e-13 to 1e-3.
    time_limit : float, optional
        Seconds of computation after which it is given up.
    workers : int
        Threads for many initial conditions, where numba is there.

    Returns
    -------
    Motion or numpy.ndarray of Motion
        STICK_SLIP, PURE_SLIP, REST, UNBOUNDED; `UNDECIDED` where the initial condition, or the oscillator itself,
        is on a boundary within the tolerance.

    Raises
    ------
    InputError
        For unusable numbers or an unbound law.
    NotConverged
        When the bound on the work is reached.
    OutOfTime
        When the time limit is reached.

    Examples
    --------
    >>> import stickslip_sym as ss
    >>> osc = ss.Oscillator(m=1, k=100, c=2.3, V=0.5, N=9.81)
    >>> [motion.name for motion in ss.classify(ss.laws.exponential.typical(), osc, x0=[-0.1, 0.0], v0=0.0)]
    ['STICK_SLIP', 'REST']
    """
    law = as_law(law)
    osc = as_oscillator(osc)
    rtol = read_rtol(rtol)
    x, v = read_initial_conditions(x0, osc.V if v0 is None else v0)
    fates = np.full(x.shape, None, dtype=object)
    with deadline.time_limit(time_limit):
        deadline.check_time()  # what is kept from earlier calls may need no look at the time
        if x.size >= MOST_ORBITS:  # separatrices take fewer
            with suppress(StickSlipError):  # where the phase plane is not known, some motions may be decided yet
                fates = kept_regime(law, osc, rtol).by_side(x, v)
        left = ~fates.astype(bool)
        fates[left] = followed(law, osc, rtol, np.array([x[left], v[left]]), workers)
    for fate in fates.flat:
        if isinstance(fate, StickSlipError):
            raise fate
    return fates if fates.ndim else fates.item()


def followed(law: FrictionLaw, osc: Oscillator, rtol: float, points: FloatArray, workers: int = 1) -> ObjectArray:
    """Return what initial conditions, rows x0 and v0, lead to, or errors: by slips, up to where the regime knows.

    Slips are followed until each motion has come to stick, to a peak below the belt's speed, to rest, or where
    slip slower than the belt begins outside P's orbit; from there a round says where it goes.
    """
    plane = kept_regime(law, osc, rtol)
    (x, v) = points
    system = plane.system
    q = (x - osc.onset(law)) / osc.length
    w, side = system.slip_speed(q, v / osc.V)
    fates = np.full(q.shape, None, dtype=object)

    def decide(rows: IntArray, motion: Callable[[], Any]) -> None:
        if rows.size:
            try:
                fates[rows] = motion()
            except StickSlipError as error:
                fates[rows] = error

    rest = system.turn(1.0)
    near = ADDED * rtol
    at_rest = (side > 0) & (np.abs(w - 1) <= near) & (np.abs(q - rest) <= near * max(1.0, abs(rest)))
    decide(np.flatnonzero(at_rest), lambda: plane.at_rest)
    stuck = (w == 0) & system.sticks(q) & ~at_rest
    decide(np.flatnonzero(stuck), lambda: plane.from_onset)
    left = np.flatnonzero(~(at_rest | stuck))
    begun = np.where((w == 0) & (side > 0), q, np.nan)  # where slip slower than the belt began, outside P's orbit
    while left.size:
        slips = system.slips(
            q[left], w[left], side[left], passes=side[left] > 0, until=SlipEnd.MINIMUM, rtol=rtol, workers=workers
        )
        decide(left[slips.end == SlipEnd.REST], lambda: plane.at_rest)
        turned = slips.end == SlipEnd.MINIMUM
        decide(left[turned], partial(plane.of_peaks, 1 - slips.w[turned]))
        late = slips.end == SlipEnd.LATE
        lost = np.isin(slips.end, (SlipEnd.OUTSIDE, SlipEnd.STEPS, SlipEnd.FAILED))
        for rows in filter(len, [np.flatnonzero(late), *np.flatnonzero(lost)[:, None]]):
            fates[left[rows]] = system.refusal(slips.one(rows[0]), rtol) or plane.beyond
        back = slips.end == SlipEnd.RETURN
        stuck = back & system.sticks(slips.q)
        decide(left[stuck], lambda: plane.from_onset)
        left = left[back & ~stuck]
        ends = slips.q[back & ~stuck]
        again = ~np.isnan(begun[left])
        decide(left[again], partial(plane.of_rounds, ends[again]))
        begun[left], q[left], w[left], side[left] = ends, ends, 0.0, 1.0
        left = left[~again]
    return fates
