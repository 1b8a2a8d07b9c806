"""SymPy's integrator and limits as a last resort, in a process of its own that is killed when its time is up.

SymPy's `integrate` and `limit` may take minutes, hang, or return something wrong; none of that can be
prevented from inside. Expressions travel between the two processes as pickles made here, never as text.
"""

import contextlib
import pickle
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass

import sympy as sp

from stickslip_sym.core.aliases import Expr

__all__ = ["Found", "Nothing", "antiderivative", "carried_out", "definite_integral", "limit"]

_RULE = "SymPy's integrator"
_LEAST = 0.5  # seconds; with less there is no point in starting a process
_MEMORY = 4  # GB that the process may take: SymPy's intermediate results can explode


@dataclass(frozen=True)
class Found:
    """What came out, and the name of the rule that gave it."""

    rule: str
    value: Expr


@dataclass(frozen=True)
class Nothing:
    """Why nothing came out, in words that follow the name of what was asked."""

    reason: str


def antiderivative(f: Expr, x: Expr, deadline: float, progress: Callable[[str], None]) -> Found | Nothing:
    """Return an antiderivative of f(x), or why none came by the deadline."""
    return _ask(sp.Integral(f, x), deadline, progress)


def definite_integral(integral: Expr, deadline: float, progress: Callable[[str], None]) -> Found | Nothing:
    """Return the value of an integral, or why none came by the deadline."""
    return _ask(integral, deadline, progress)


def limit(expr: Expr, variable: Expr, place: Expr, deadline: float) -> Expr | None:
    """Return the finite limit of an expression from above, or from below at infinity; None if none came."""
    found = _done(sp.Limit(expr, variable, place, "-" if place == sp.oo else "+"), deadline)
    unfinished = isinstance(found, Nothing) or found.has(
        sp.Limit, sp.AccumBounds, sp.oo, sp.zoo, sp.nan, sp.I, variable
    )
    return None if unfinished else found


def _ask(integral: Expr, deadline: float, progress: Callable[[str], None]) -> Found | Nothing:
    start = time.monotonic()
    if deadline - start >= _LEAST:
        progress(f"{_RULE} for at most {deadline - start:.0f} s: {integral.function}")
    result = _done(integral, deadline)
    if isinstance(result, Nothing):
        return Nothing(f"{_RULE} {result.reason}")
    if result.has(sp.Integral, sp.Piecewise, sp.oo, sp.zoo, sp.nan, sp.I):
        return Nothing(f"{_RULE} ended after {time.monotonic() - start:.1f} s without a usable result")
    return Found(_RULE, result)


def _done(expr: Expr, deadline: float) -> Expr:
    """Carry out an integral or a limit by SymPy, or return `Nothing`."""
    left = deadline - time.monotonic()
    if left < _LEAST:
        return Nothing("was not asked, as there was no time for it")
    try:
        # On any exception, Ctrl-C included, `run` kills the process and waits for it.
        done = subprocess.run(
            [sys.executable, "-m", __name__],
            input=pickle.dumps(expr),
            capture_output=True,
            timeout=left,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return Nothing(f"found nothing in its {left:.0f} s")
    if done.returncode != 0:
        said = done.stderr.decode(errors="replace").strip().splitlines()
        why = f": {said[-1][:200]}" if said else ""
        return Nothing(f"failed without a look at it: its process ended with {done.returncode}{why}")
    return pickle.loads(done.stdout)


def carried_out(expr: Expr) -> Expr:
    """Carry out an integral or a limit in this process, or say how that ended."""
    # A limit on memory beside the one on time; only Unix has it.
    with contextlib.suppress(ImportError, ValueError, OSError):
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (_MEMORY << 30, _MEMORY << 30))
    try:
        return expr.doit()
    except MemoryError:
        return Nothing(f"needed more than {_MEMORY} GB")
    except Exception as error:  # SymPy raises many kinds
        return Nothing(f"gave up with {type(error).__name__}: {str(error)[:200]}")


if __name__ == "__main__":
    # As the module's own, for the classes to be the parent's.
    from stickslip_sym.formula.integration import search

    sys.stdout.buffer.write(pickle.dumps(search.carried_out(pickle.load(sys.stdin.buffer))))
