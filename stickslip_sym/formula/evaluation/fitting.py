"""Coefficients of short formulas: power series of slope averages, and polynomials through values."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import mpmath
import numpy as np
import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.criteria.criterion import Criterion

__all__ = ["TERMS", "chebyshev_fit", "chebyshev_nodes", "economised", "moment", "taylor", "to_monomials"]

TERMS = 30
"""The most terms of a series."""

DIGITS = 40  # in which coefficients are computed


@lru_cache(maxsize=256)
def moment(criterion: Criterion, k: int) -> Any:
    """Return <(1 + s)^k>_w, exact."""
    return sp.Add(*[sp.binomial(k, j) * criterion.moment(j) for j in range(k + 1)])


def taylor(slope: Any, criterion: Criterion, decay: float) -> tuple[list[Any], float] | None:
    """Return the coefficients of exp(decay r) F(r), and a radius within which they serve.

    The coefficients of g are its Fourier coefficients on a circle: a small one, and a large one if g has no
    singularity inside.
    """
    g = function_of([symbols.v], slope, "mpmath")
    with mpmath.workdps(DIGITS):
        small = _on_circle(g, mpmath.mpf(1) / 4)
        if small is None:
            return None
        large = _on_circle(g, mpmath.mpf(12))
        scale = max(abs(c) / mpmath.mpf(4) ** k for k, c in enumerate(small))
        agree = large is not None and all(
            abs(a - b) <= scale * mpmath.mpf(4) ** k * mpmath.mpf("1e-30")
            for k, (a, b) in enumerate(zip(small[:12], large[:12], strict=True))
        )
        coefficients, radius = (large, 24.0) if agree and large is not None else (small, 0.25)
        tiny = scale * mpmath.mpf("1e-30")
        moments = [
            -g_k * mpmath.mpf(moment(criterion, k).p) / moment(criterion, k).q
            for k, g_k in enumerate(coefficients)
        ]
        rate = mpmath.mpf(decay)
        exponential = [rate**k / mpmath.factorial(k) for k in range(len(moments))]
        result = [mpmath.fsum(moments[i] * exponential[k - i] for i in range(k + 1)) for k in range(len(moments))]
        sizes = [
            mpmath.fsum(abs(moments[i]) * exponential[k - i] for i in range(k + 1)) for k in range(len(moments))
        ]
        reach = mpmath.mpf(12 if agree else mpmath.mpf(1) / 4)
        return [
            c if abs(c) > max(size * mpmath.mpf("1e-25"), tiny / reach**k * mpmath.mpf("1e-6")) else mpmath.mpf(0)
            for k, (c, size) in enumerate(zip(result, sizes, strict=True))
        ], radius


def _on_circle(g: Callable[[Any], Any], radius: Any) -> list[Any] | None:
    """Return the Taylor coefficients of a function that is real on the real axis; None where it has none."""
    count = 2 * (TERMS + 34)
    half = count // 2
    cosines = [mpmath.cospi(mpmath.mpf(2 * i) / count) for i in range(count)]
    sines = [mpmath.sinpi(mpmath.mpf(2 * i) / count) for i in range(count)]
    try:
        values = [mpmath.mpmathify(g(radius * mpmath.mpc(cosines[i], sines[i]))) for i in range(half + 1)]
        check = mpmath.mpmathify(g(radius * mpmath.mpf("0.37")))
    except (ValueError, TypeError, ZeroDivisionError, ArithmeticError):
        return None
    if not all(mpmath.isfinite(value) for value in values):
        return None
    inner = [value.real for value in values[1:half]] + [value.imag for value in values[1:half]]
    coefficients = []
    for k in range(2 * TERMS):
        turns = [i * k % count for i in range(1, half)]
        wave = [cosines[i] for i in turns] + [sines[i] for i in turns]
        ends = values[0].real + values[-1].real * (-1) ** k
        coefficients.append((ends + 2 * mpmath.fdot(inner, wave)) / count / radius**k)
    total = mpmath.fsum(c * (radius * mpmath.mpf("0.37")) ** k for k, c in enumerate(coefficients))
    size = max(abs(value) for value in values)
    return coefficients if abs(total - check) <= mpmath.mpf("1e-22") * size else None


def economised(coefficients: list[Any], end: float) -> tuple[float, ...]:
    """Return a polynomial with as few terms as equal a given one on [0, end] to double precision."""
    with mpmath.workdps(DIGITS):

        def polynomial(z: Any) -> Any:
            return mpmath.polyval(coefficients[::-1], z)

        least = min(abs(polynomial(0)), abs(polynomial(end))) * mpmath.mpf(2) ** -57
        for terms in range(2, len(coefficients)):
            fitted, error = mpmath.chebyfit(polynomial, [0, end], terms, error=True)
            if error < least:
                return tuple(float(c) for c in reversed(fitted))
    return tuple(float(c) for c in coefficients)


def chebyshev_nodes(n: int) -> Any:
    """Return the n zeros of the Chebyshev polynomial of degree n, in extended precision."""
    real = np.longdouble
    pi = 4 * np.arctan(real(1))
    return np.cos(pi * (np.arange(n, dtype=real) + real(0.5)) / n)


def chebyshev_fit(y: Any) -> Any:
    """Return the Chebyshev coefficients of the polynomial through values at Chebyshev nodes."""
    n = len(y)
    real = np.longdouble
    pi = 4 * np.arctan(real(1))
    angles = pi * (np.arange(n, dtype=real) + real(0.5)) / n
    coefficients = np.array([2 * (y * np.cos(k * angles)).sum() / n for k in range(n)], dtype=real)
    coefficients[0] /= 2
    return coefficients


def to_monomials(coefficients: Any) -> Any:
    """Return the coefficients in powers of t of a Chebyshev sum."""
    n = len(coefficients)
    before, now = np.zeros(n, dtype=np.longdouble), np.zeros(n, dtype=np.longdouble)
    before[0] = 1
    total = coefficients[0] * before
    if n > 1:
        now[1] = 1
        total = total + coefficients[1] * now
    for k in range(2, n):
        after = -before
        after[1:] += 2 * now[:-1]
        before, now = now, after
        total = total + coefficients[k] * now
    return total
