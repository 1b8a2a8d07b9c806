"""SymPy's integrator as a last resort, in a process of its own that ends after so many calls of functions.

SymPy's `integrate` may take minutes, hang, or return something wrong; none of that can be prevented from
inside. Its calls are counted, not its seconds, and the process hashes names alike each time: so what it finds
does not depend on the machine, nor on what else runs. Expressions travel between the two processes as pickles
made here, never as text.
"""

import contextlib
import math
import os
import pickle
import subprocess
import sys
from types import FrameType

import sympy as sp

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.deadline import time_left
from stickslip_sym.core.errors import OutOfTime
from stickslip_sym.core.progress import stages

RULE = "SymPy's integrator"
_CALLS = 1_000_000
"""Calls of functions that an integral may take, one to two seconds: what SymPy finds at all, it finds in fewer."""
_MEMORY = 1 << 30  # bytes that the process may take: SymPy's intermediate results can explode
_SAME_HASHES = {"PYTHONHASHSEED": "0"}  # sets are in the same order in each process
_UNFINISHED = (sp.oo, sp.zoo, sp.nan, sp.I)


class NothingFound(Exception):
    """Why nothing was found, in words."""


def search_antiderivative(f: Expr, polynomial: Expr, x: Expr, calls: int = _CALLS) -> Expr:
    """Return an antiderivative of f(x) polynomial(x), or raise `NothingFound`.

    SymPy is asked for f x^n, without the coefficients of the polynomial: with them it finds less, and some wrong.
    """
    terms = sp.Poly(polynomial, x).terms()
    with stages() as say:
        say(f"{RULE}: {f}", 0, 0)
        result = _done(sp.Tuple(*[sp.Integral(f * x**n, x) for (n,), _ in terms]), calls)
    if result.has(sp.Integral, sp.Piecewise, *_UNFINISHED):
        raise NothingFound(f"{RULE} ended without a usable result")
    return sp.Add(*[coefficient * value for (_, coefficient), value in zip(terms, result, strict=True)])


def _done(exprs: Expr, calls: int) -> sp.Tuple:
    """Carry out integrals by SymPy."""
    left = time_left()
    try:
        # On any exception, Ctrl-C included, `run` kills the process and waits for it.
        done = subprocess.run(
            [sys.executable, "-m", __name__],
            input=pickle.dumps((exprs, calls)),
            capture_output=True,
            env={**os.environ, **_SAME_HASHES},
            timeout=None if math.isinf(left) else max(left, 0.0),
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise OutOfTime("the time limit was reached") from None
    if done.returncode != 0:
        said = done.stderr.decode(errors="replace").strip().splitlines()
        why = ""
        if said:
            why = f": {said[-1][:200]}"
        raise NothingFound(f"{RULE} failed without a look at it: its process ended with {done.returncode}{why}")
    result: sp.Tuple | str = pickle.loads(done.stdout)
    if isinstance(result, str):
        raise NothingFound(f"{RULE} {result}")
    return result


class _TooLong(BaseException):
    """More calls than were granted; no `except Exception` of SymPy's stops it."""


def confine(calls: int) -> None:
    """Bound what this process may take from now on, for good: calls of functions, and memory if the system can."""
    with contextlib.suppress(ImportError, ValueError, OSError):
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
    left = calls

    def count(frame: FrameType, event: str, argument: object) -> None:
        nonlocal left
        left -= 1
        if left < 0:
            raise _TooLong

    sys.settrace(count)


def carried_out(expr: Expr) -> Expr | str:
    """Carry out integrals, or say how that ended."""
    try:
        done = expr.doit()
        if done.has(sp.meijerg):
            return sp.hyperexpand(done)
        return done
    except _TooLong:
        return "found nothing in the steps that it is granted"
    except MemoryError:
        return f"needed more than {_MEMORY >> 30} GB"
    except Exception as error:  # SymPy raises many kinds
        return f"gave up with {type(error).__name__}: {str(error)[:200]}"


if __name__ == "__main__":
    asked, granted = pickle.load(sys.stdin.buffer)
    confine(granted)
    outcome = carried_out(asked)
    sys.settrace(None)
    sys.stdout.buffer.write(pickle.dumps(outcome))
