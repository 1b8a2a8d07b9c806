"""SymPy's integrator and limits as a last resort, in a process of its own that is killed when its time is up.

SymPy's `integrate` and `limit` may take minutes, hang, or return something wrong; none of that can be
prevented from inside. Expressions travel between the two processes as pickles made here, never as text.
"""

import pickle
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

import sympy as sp

__all__ = ["antiderivative", "definite_integral", "limit"]

_RULE = "SymPy's integrator"
_LEAST = 0.5  # seconds; with less there is no point in starting a process


def antiderivative(f: Any, x: Any, deadline: float, progress: Callable[[str], None]) -> tuple[str, Any] | None:
    """Return the rule's name and an antiderivative of f(x), or None if none came by the deadline."""
    return _ask(sp.Integral(f, x), deadline, progress)


def definite_integral(integral: Any, deadline: float, progress: Callable[[str], None]) -> tuple[str, Any] | None:
    """Return the rule's name and the value of an integral, or None if none came by the deadline."""
    return _ask(integral, deadline, progress)


def limit(expr: Any, variable: Any, place: Any, deadline: float) -> Any | None:
    """Return the finite limit of an expression from above, or from below at infinity; None if none came."""
    found = _done(sp.Limit(expr, variable, place, "-" if place == sp.oo else "+"), deadline)
    unfinished = found is None or found.has(sp.Limit, sp.AccumBounds, sp.oo, sp.zoo, sp.nan, sp.I, variable)
    return None if unfinished else found


def _ask(integral: Any, deadline: float, progress: Callable[[str], None]) -> tuple[str, Any] | None:
    left = deadline - time.monotonic()
    if left < _LEAST:
        return None
    progress(f"{_RULE} for at most {left:.0f} s: {integral.function}")
    result = _done(integral, deadline)
    unfinished = result is None or result.has(sp.Integral, sp.Piecewise, sp.oo, sp.zoo, sp.nan, sp.I)
    return None if unfinished else (_RULE, result)


def _done(expr: Any, deadline: float) -> Any | None:
    """Carry out an integral or a limit by SymPy; None if nothing came by the deadline."""
    left = deadline - time.monotonic()
    if left < _LEAST:
        return None
    try:
        # On any exception, Ctrl-C included, `run` kills the process and waits for it.
        done = subprocess.run(
            [sys.executable, "-m", "stickslip_sym.search"],
            input=pickle.dumps(expr),
            capture_output=True,
            timeout=left,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return None
    if done.returncode != 0:
        return None
    return pickle.loads(done.stdout)


if __name__ == "__main__":
    # Refuse to outlive the parent's patience by memory either: SymPy's intermediate results can explode.
    import resource

    resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))
    sys.stdout.buffer.write(pickle.dumps(pickle.load(sys.stdin.buffer).doit()))
