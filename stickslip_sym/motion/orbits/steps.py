"""Steps of many states at once, each of its own length: DOP853, the explicit Runge-Kutta method of order 8.

Coefficients and error estimate are those of SciPy, which takes one step length for all.
"""

from collections.abc import Callable

import numpy as np
from scipy.integrate import DOP853

from stickslip_sym.core.aliases import FloatArray

__all__ = ["EXPONENT", "error_of", "take_step"]

EXPONENT = -1 / (DOP853.error_estimator_order + 1)
"""Of the error of a step, in the length of the next one."""
_A, _B = np.array(DOP853.A), np.array(DOP853.B)
_ERRORS = np.array([DOP853.E5[:-1], DOP853.E3[:-1]])  # the rates at the end of a step have no share
_STAGES = len(_B)


def take_step(
    rates: Callable[[FloatArray, FloatArray], object],
    state: FloatArray,
    h: FloatArray,
    first: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Return the states after a step, and two estimates of its error for each component, to a unit of time.

    - `rates`: writes the rates of states into an array.
    - `state`: of shape (components, n).
    - `h`: of shape (n,).
    - `first`: the rates of `state`, where they are known.
    """
    stages = np.empty((_STAGES, *state.shape))
    flat = stages.reshape(_STAGES, -1)
    if first is None:
        rates(state, stages[0])
    else:
        stages[0] = first
    for i in range(1, _STAGES):
        rates(state + h * (_A[i, :i] @ flat[:i]).reshape(state.shape), stages[i])
    return state + h * (_B @ flat).reshape(state.shape), (_ERRORS @ flat).reshape(2, *state.shape)


def error_of(estimates: FloatArray, size: FloatArray, h: FloatArray) -> FloatArray:
    """Return the errors of steps over their tolerances, where a component may be off by `size`."""
    fifth, third = ((estimates / size) ** 2).sum(axis=1)
    both = fifth + 0.01 * third
    error: FloatArray = np.where(both == 0, 0.0, np.abs(h) * fifth / np.sqrt(2 * np.where(both == 0, 1.0, both)))
    return error
