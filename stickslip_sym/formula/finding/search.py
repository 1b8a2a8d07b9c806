"""SymPy's integrator as a last resort, in a process of its own that is killed when its time is up:
seconds of the processor, so that what is found does not depend on what else runs.

SymPy's `integrate` may take minutes, hang, or return something wrong; none of that can be prevented from
inside. Expressions travel between the two processes as pickles made here, never as text.
"""

import contextlib
import pickle
import subprocess
import sys
import time

import sympy as sp

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.deadline import check_time, time_left
from stickslip_sym.core.progress import stages

"""Called with a few words on the present step."""

RULE = "SymPy's integrator"
_PATIENCE = 8.0  # times as long as its own time a process may take on a busy machine
_OUT_OF_TIME = 24  # the signal that ends a process whose time is up
_MEMORY = 4  # GB that the process may take: SymPy's intermediate results can explode
_UNFINISHED = (sp.oo, sp.zoo, sp.nan, sp.I)


class NothingFound(Exception):
    """Why nothing was found, in words."""


def antiderivative(f: Expr, polynomial: Expr, x: Expr, seconds: float) -> Expr:
    """Return an antiderivative of f(x) polynomial(x), or raise `NothingFound`.

    SymPy is asked for f x^n, without the coefficients of the polynomial: with them it finds less, and some wrong.
    """
    start = time.monotonic()
    terms = sp.Poly(polynomial, x).terms()
    with stages() as say:
        if seconds > 0:
            say(f"{RULE} for at most {seconds:.0f} s: {f}", 0, 0)
        result = _done(sp.Tuple(*[sp.Integral(f * x**n, x) for (n,), _ in terms]), seconds)
    if result.has(sp.Integral, sp.Piecewise, *_UNFINISHED):
        raise NothingFound(f"{RULE} ended after {time.monotonic() - start:.1f} s without a usable result")
    return sp.Add(*[coefficient * value for (_, coefficient), value in zip(terms, result, strict=True)])


def _done(expr: Expr, seconds: float) -> Expr:
    """Carry out integrals by SymPy."""
    if seconds <= 0:
        raise NothingFound(f"{RULE} was not asked")
    late = NothingFound(f"{RULE} found nothing in its {seconds:.0f} s")
    try:
        # On any exception, Ctrl-C included, `run` kills the process and waits for it.
        done = subprocess.run(
            [sys.executable, "-m", __name__],
            input=pickle.dumps((expr, seconds)),
            capture_output=True,
            timeout=min(_PATIENCE * seconds, max(time_left(), 0.0)),
            check=False,
        )
    except subprocess.TimeoutExpired:
        check_time()
        raise late from None
    if done.returncode == -_OUT_OF_TIME:
        raise late
    if done.returncode != 0:
        said = done.stderr.decode(errors="replace").strip().splitlines()
        why = f": {said[-1][:200]}" if said else ""
        raise NothingFound(f"{RULE} failed without a look at it: its process ended with {done.returncode}{why}")
    result = pickle.loads(done.stdout)
    if isinstance(result, str):
        raise NothingFound(f"{RULE} {result}")
    return result


def confine(seconds: float) -> None:
    """Bound what this process may take from now on, for good: seconds of the processor, and memory.

    On a busy machine no less is found so. Only Unix has such bounds.
    """
    with contextlib.suppress(ImportError, ValueError, OSError):
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (_MEMORY << 30, _MEMORY << 30))
        resource.setrlimit(resource.RLIMIT_CPU, (int(time.process_time() + seconds) + 1, resource.RLIM_INFINITY))


def carried_out(expr: Expr) -> Expr | str:
    """Carry out integrals, or say how that ended."""
    try:
        return expr.doit()
    except MemoryError:
        return f"needed more than {_MEMORY} GB"
    except Exception as error:  # SymPy raises many kinds
        return f"gave up with {type(error).__name__}: {str(error)[:200]}"


if __name__ == "__main__":
    asked, limit_of_time = pickle.load(sys.stdin.buffer)
    confine(limit_of_time)
    sys.stdout.buffer.write(pickle.dumps(carried_out(asked)))
