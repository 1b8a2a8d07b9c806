"""`simulate`: the motion from one initial condition, or from many."""

from __future__ import annotations

from typing import overload

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core import deadline
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import read_rtol, real
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.simulation.by_events import simulate_by_events
from stickslip_sym.motion.simulation.many import Trajectories, simulate_many
from stickslip_sym.motion.simulation.reference import simulate_by_solve_ivp
from stickslip_sym.motion.simulation.trajectory import Trajectory

__all__ = ["simulate"]


@overload
def simulate(
    law: FrictionLaw | str, osc: Oscillator, *, t_end: float, x0: float = ..., v0: float | None = ...,
    rtol: float = ..., method: str = ..., max_steps: int = ..., time_limit: float | None = ..., workers: int = ...,
) -> Trajectory: ...  # fmt: skip


@overload
def simulate(
    law: FrictionLaw | str, osc: Oscillator, *, t_end: float, x0: ArrayLike = ..., v0: ArrayLike | None = ...,
    rtol: float = ..., method: str = ..., max_steps: int = ..., time_limit: float | None = ..., workers: int = ...,
) -> Trajectory | Trajectories: ...  # fmt: skip


def simulate(
    law: FrictionLaw | str,
    osc: Oscillator,
    *,
    t_end: float,
    x0: ArrayLike = 0.0,
    v0: ArrayLike | None = None,
    rtol: float = 1e-10,
    method: str = "events",
    max_steps: int = 200_000,
    time_limit: float | None = None,
    workers: int = 1,
) -> Trajectory | Trajectories:
    """Integrate m x'' + c x' + k x = friction from x(0) = x0, x'(0) = v0, events included.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    osc : Oscillator
    t_end : float
        Duration in s, positive.
    x0 : float or array
        Initial displacement in m, one or many.
    v0 : float or array, optional
        Initial velocity in m/s; the belt speed if not given. Arrays of initial conditions broadcast.
    rtol : float
        Relative tolerance of a step, 1e-13 to 1e-3.
    method : {"events", "solve_ivp"}
        The package's integrator, which locates extrema before crossings, kinks and sliding modes; or SciPy's
        `solve_ivp` with events, an independent reference for one initial condition.
    max_steps : int
        Integration steps after which a motion ends as it is; a cycle of stick and slip takes about 30.
    time_limit : float, optional
        Seconds of computation after which it ends as it is.
    workers : int
        Threads for many initial conditions, where numba is there.

    Returns
    -------
    Trajectory or Trajectories
        For one initial condition, or many. The `outcome` says whether `t_end`, a limit, or a rest that goes on
        for ever was reached, or that the motion grows without bound, or comes to where mu has no value.

    Raises
    ------
    InputError
        For unusable numbers, or an unbound law.
    NotConverged
        When `solve_ivp` cannot go on.

    Examples
    --------
    >>> import stickslip_sym as ss
    >>> law, osc = ss.laws.exponential.typical(), ss.Oscillator(m=1, k=100, c=1.0, V=0.5, N=9.81)
    >>> motion = ss.simulate(law, osc, t_end=5.0)
    >>> motion.motion.value, len(motion.starts_of(ss.Phase.STICK))
    ('stick-slip', 8)
    """
    law = as_law(law)
    t_end = real("t_end", t_end)
    if t_end <= 0:
        raise InputError(f"t_end = {t_end:g} must be positive")
    rtol = read_rtol(rtol)
    max_steps = int(real("max_steps", max_steps))
    if max_steps < 1:
        raise InputError(f"max_steps = {max_steps} must be at least 1")
    if method not in ("events", "solve_ivp"):
        raise InputError(f"there is no method {str(method)[:40]!r}; choose 'events' or 'solve_ivp'")
    speeds = osc.V if v0 is None else v0
    many = np.ndim(x0) > 0 or np.ndim(speeds) > 0
    with deadline.time_limit(time_limit):
        if many and method == "events":
            return simulate_many(law, osc, x0, speeds, t_end, rtol, max_steps, workers)
        if many:
            raise InputError("method 'solve_ivp' takes one initial condition; simulate them one by one")
        x, v = real("x0", x0), real("v0", speeds)  # type: ignore[arg-type]
        if method == "solve_ivp":
            return simulate_by_solve_ivp(law, osc, x, v, t_end, rtol)
        return simulate_by_events(law, osc, x, v, t_end, rtol, max_steps)
