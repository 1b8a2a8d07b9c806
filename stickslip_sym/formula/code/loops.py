"""A fast function's loop over an array in C, which a compiler turns into vector instructions.

NumPy computes one operation at a time, over a whole block. A loop in C takes a few numbers through all operations
at once: through every branch, and then it keeps the one that serves. That needs no copies, and the order of the
speeds does not matter. It is for terms whose branches are polynomials and exponentials, as those of exp(-v) are.
"""

import ctypes
import math
import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Protocol

import numpy as np

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import InputError
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.evaluation.averages import SlopeAverage
from stickslip_sym.formula.evaluation.branches import Branch, LogTail, Loop, Profile, Series
from stickslip_sym.formula.evaluation.closed import Closed
from stickslip_sym.formula.evaluation.stable import StableFunction
from stickslip_sym.model.law import FrictionLaw

__all__ = ["compiled", "loop_of"]

_COMPILERS = ("cc", "gcc", "clang")
_OPTIONS = ("-O3", "-march=native", "-fno-math-errno", "-fno-trapping-math", "-shared", "-fPIC")
_SECONDS = 60.0  # for the compiler
_AGREED = 8.0  # units in which the loop may differ from NumPy: each of them errs by four at most
_CHECKED = 500  # speeds in each branch at which they are compared, and as many near each of its ends

_TERMS = 14  # of exp(t) for |t| <= log(2)/2: the next one is below 1e-17
_POWERS = {1.0: "r", 2.0: "(r*r)", -1.0: "u", -2.0: "(u*u)"}

_TEXT = """
#include <stdint.h>
#include <string.h>

static inline int64_t bits(double x) {{ int64_t n; memcpy(&n, &x, 8); return n; }}
static inline double number_of(int64_t n) {{ double x; memcpy(&x, &n, 8); return x; }}

/* exp(x) for x <= 0: x = k log 2 + t, and a polynomial for exp(t); 2^k in two steps, for subnormal results. */
static inline double decay(double x)
{{
    const double magic = 6755399441055744.0; /* 1.5 * 2^52: what is added to it is rounded to a whole number */
    double shifted, k, half, t, p;
    int64_t n, h;
    x = x < -745.5 ? -745.5 : x;
    shifted = x*1.4426950408889634 + magic;
    k = shifted - magic;
    n = bits(shifted) - bits(magic);
    half = 0.5*k + magic;
    h = bits(half) - bits(magic);
    t = (x - k*6.93147180369123816490e-01) - k*1.90821492927058770002e-10;
    p = {exponential};
    return p*number_of((h + 1023) << 52)*number_of((n - h + 1023) << 52);
}}

void fill(const double *restrict speeds, double factor, double number, double *restrict out, int64_t count)
{{
    for (int64_t i = 0; i < count; i++) {{
        const double r = factor*speeds[i], u = 1.0/r{exponentials};
{branches}
        out[i] = number*({choice});
    }}
}}
"""


class _Fast(Protocol):
    """A `ClosedForm`, or a `SlopeAverage`."""

    law: FrictionLaw
    criterion: Criterion

    @property
    def function(self) -> StableFunction: ...


def compiled(form: _Fast) -> SlopeAverage:
    """Return the function of a closed form with its loops compiled by this computer's C compiler.

    It is called as before, and has the same accuracy: each loop is compared with NumPy at some thousand speeds
    before it is used. A term with other branches than polynomials and exponentials is left to NumPy, as are scenes
    at the limits of double precision.

    Parameters
    ----------
    form : ClosedForm or SlopeAverage

    Returns
    -------
    SlopeAverage

    Raises
    ------
    InputError
        If there is no compiler, it fails, or no term has a loop that is worth it; or `form` is neither.
    """
    if not isinstance(getattr(form, "function", None), StableFunction):
        kind = type(form).__name__
        raise InputError(f"a closed form, or a slope average, has loops to compile, got {kind}; derive one first")
    terms = form.function.terms or []
    profiles = [term.profile((), 1) for term in terms if not term.shapes]
    if not any(profile is not None and loop_of(profile) is not None for profile in profiles):
        raise InputError(
            f"no term of {form.law.text!r} has only branches that are polynomials and exponentials, so there is "
            "nothing to compile; call the closed form or the slope average itself"
        )
    return SlopeAverage(form.law, form.criterion, form.function.exact, loop_of)


@lru_cache(maxsize=128)
def loop_of(profile: Profile) -> Loop | None:
    """Return the compiled loop of a profile; None where a branch is more than polynomials and exponentials.

    Raises
    ------
    InputError
        If there is no compiler, or what it makes is wrong.
    """
    text = _text(profile)
    if text is None:
        return None
    fill = _library(text).fill
    fill.restype = None
    fill.argtypes = [ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_void_p, ctypes.c_int64]

    def loop(speeds: FloatArray, factor: float, number: float, out: FloatArray) -> None:
        speeds = np.ascontiguousarray(speeds)
        fill(speeds.ctypes.data, factor, number, out.ctypes.data, out.size)

    _require_agreement(loop, profile)
    return loop


def _require_agreement(loop: Loop, profile: Profile) -> None:
    """Compare with NumPy, above all near the ends of each branch."""
    rng = np.random.default_rng(0)
    edges = [2.0**-60, *profile.starts[1:], 2.0**90]
    for branch, low, high in zip(profile.branches, edges[:-1], edges[1:], strict=True):
        assert branch is not None  # or there were no text
        first, last = np.log2(low), np.log2(high)
        ends = rng.uniform(0, min(2.0, last - first), (2, _CHECKED))
        r = 2 ** np.concatenate([rng.uniform(first, last, _CHECKED), first + ends[0], last - ends[1]])
        expected, got = branch(r) * r**branch.power, np.empty_like(r)
        loop(r, 1.0, 1.0, got)
        if not (np.abs(got - expected) <= _AGREED * np.finfo(np.float64).eps * np.abs(expected)).all():
            raise InputError("the C compiler made a loop that is not accurate; call the closed form itself")


def _library(text: str) -> ctypes.CDLL:
    """Compile C, and load it.

    Raises
    ------
    InputError
    """
    compiler = next(filter(None, map(shutil.which, _COMPILERS)), None)
    if compiler is None:
        raise InputError(f"no C compiler was found ({', '.join(_COMPILERS)}); call the closed form itself")
    with tempfile.TemporaryDirectory() as folder:
        source, library = Path(folder, "loop.c"), Path(folder, "loop.so")
        source.write_text(text)
        command = [compiler, *_OPTIONS, str(source), "-o", str(library)]
        try:
            subprocess.run(command, capture_output=True, text=True, timeout=_SECONDS, check=True)
            return ctypes.CDLL(str(library))  # which stays when the file is gone
        except subprocess.CalledProcessError as error:
            raise InputError(f"{compiler} failed: {error.stderr.strip()[:500]}") from None
        except (OSError, subprocess.TimeoutExpired) as error:
            raise InputError(f"{compiler} failed: {error}") from None


def _text(profile: Profile) -> str | None:
    """Return the C text of a profile with a closed form of exponentials; None for another."""
    if not any(isinstance(branch, Closed) for branch in profile.branches):
        return None
    branches, edges = profile.cover(0.0, 2.0**1000)
    exponentials = _exponentials(branches)
    values = [_branch(branch, exponentials) for branch in branches]
    if any(value is None for value in values) or min(exponentials, default=0.0) < 0:
        return None
    lines = [f"        const double branch_{i} = {value};" for i, value in enumerate(values)]
    choice = f"branch_{len(values) - 1}"
    for i in range(len(values) - 2, -1, -1):
        choice = f"r < {edges[i]!r} ? branch_{i} : ({choice})"
    return _TEXT.format(
        exponential=_horner([1 / math.factorial(k) for k in range(_TERMS)], "t"),
        exponentials="".join(f", {name} = {text}" for name, text in exponentials.values()),
        branches="\n".join(lines),
        choice=choice,
    )


def _exponentials(branches: Sequence[Branch | None]) -> dict[float, tuple[str, str]]:
    """Return a name and C text for each exponential; the square of one that is there is not computed anew."""
    rates = {branch.decay for branch in branches if isinstance(branch, Series) and branch.decay}
    for branch in branches:
        if isinstance(branch, Closed):
            rates |= {function.rate for function, _ in branch.parts if function is not None and function.rate}
    names = {rate: f"e{i}" for i, rate in enumerate(sorted(rates))}
    return {
        rate: (name, f"{names[rate / 2]}*{names[rate / 2]}" if rate / 2 in names else f"decay({-rate!r}*r)")
        for rate, name in names.items()
    }


def _branch(branch: Branch | None, exponentials: Mapping[float, tuple[str, str]]) -> str | None:
    """Return r^power G in C; None for what is more than polynomials and exponentials."""
    if branch is None or branch.power != int(branch.power):
        return None
    if isinstance(branch, LogTail) and not branch.slope:
        value = repr(branch.constant)
    elif isinstance(branch, Series) and branch.shift == 0 and branch.stretch == 1 and branch.variable in _POWERS:
        value = _horner(branch.coefficients, _POWERS[branch.variable])
        if branch.decay:
            value = f"{value}*{exponentials[branch.decay][0]}"
    elif isinstance(branch, Closed) and branch.is_light:
        value = " + ".join(
            _horner(coefficients, "u")
            + (f"*{exponentials[function.rate][0]}" if function and function.rate else "")
            for function, coefficients in branch.parts
        )
    else:
        return None
    return "*".join([f"({value})", *["r" if branch.power > 0 else "u"] * abs(int(branch.power))])


def _horner(coefficients: Sequence[float], z: str) -> str:
    """Return a polynomial, nested."""
    text = repr(float(coefficients[-1]))
    for coefficient in reversed(coefficients[:-1]):
        text = f"({float(coefficient)!r} + {z}*{text})"
    return text
