"""The threshold by SciPy's DOP853, parted where a law varies quickly; only mu comes from the package.

In units of sqrt(m/k) and V the slip from P has q' = 1 - w and w' = q - 2 zeta w - eta (mu(V w) - mu(0)), from
q = w = 0. Forward in time it comes to w = 1 from above, and backward from below; at the threshold both are one
orbit, with one w' there.
"""

import math

import numpy as np
from scipy.integrate import solve_ivp

LONGEST = 60.0  # of a part
LONGEST_STEP = 0.06  # within which what events are located by has 12 digits too
PARTS = 400  # of a way, at most


def rate_at_top(rises, edges, eta, zeta, side):
    """Return w' where the slip from P comes to w = 1, forward or backward in time; None if it does not.

    `rises` has mu(V w) - mu(0) between neighbours of `edges`; a slip that is held at a jump does not come.
    """
    edges, y, part = [0.0, *edges, math.inf], np.zeros(2), 0
    for _ in range(PARTS):
        rise, low, high = rises[part], edges[part], edges[part + 1]

        def rates(_, y, rise=rise):
            return side * (1 - y[1]), side * (y[0] - 2 * zeta * y[1] - eta * rise(y[1]))

        def crossing(level, direction):
            def event(_, state):
                return state[1] - level

            event.terminal, event.direction = True, direction
            return event

        events = [crossing(1.0, -side), crossing(low, -1)]
        if high < math.inf:
            events.append(crossing(high, 1))
        pace = abs(rates(0, y)[1])
        longest = min(LONGEST_STEP, 0.3 * (high - low) / pace) if pace > 1e-3 else LONGEST_STEP
        way = solve_ivp(
            rates, (0, LONGEST), y, method="DOP853", rtol=1e-13, atol=1e-14, events=events, max_step=longest
        )
        y = way.y[:, -1]
        if way.status != 1:
            return None
        if way.t_events[0].size:
            return side * rates(0, (y[0], 1.0))[1]
        rising = not way.t_events[1].size
        if not rising and part == 0:
            return None
        y = np.array([y[0], high if rising else low])
        part += 1 if rising else -1
        onward = side * (y[0] - 2 * zeta * y[1] - eta * rises[part](y[1]))
        if (onward > 0) != rising:
            return None  # held at a jump
    return None


def lies_between(rises, edges, eta, low, high):
    """Whether the damping ratio at which both ways meet lies between two; None if a way does not come to w = 1."""
    gaps = []
    for zeta in (low, high):
        there, back = (rate_at_top(rises, edges, eta, zeta, side) for side in (1, -1))
        if there is None or back is None:
            return None
        gaps.append(there - back)
    return bool(gaps[0] * gaps[1] <= 0)
