"""Where a function of one quantity changes its sign."""

from collections.abc import Callable, Iterator, Sequence

from scipy.optimize import brentq

__all__ = ["sign_changes"]


def sign_changes(
    function: Callable[[float], float], nodes: Sequence[float], values: Sequence[float], rtol: float
) -> Iterator[float]:
    """Yield where a function changes its sign between nodes, from its values there, within a relative tolerance.

    Also nodes at which it is 0, but for zeros beside zeros. Values beyond -1 and 1 count as these: they may be
    infinite.
    """

    def bounded(x: float) -> float:
        return min(max(function(x), -1.0), 1.0)

    last = len(nodes) - 1
    for i, (x, value) in enumerate(zip(nodes, values, strict=True)):
        if value == 0 and (i == 0 or values[i - 1] != 0) and (i == last or values[i + 1] != 0):
            yield x
        elif i < last and value * values[i + 1] < 0:
            yield brentq(bounded, x, nodes[i + 1], xtol=rtol * max(abs(x), abs(nodes[i + 1])))
