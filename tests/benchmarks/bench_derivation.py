"""`derive` beside bare `sympy.integrate` on the same integrals: time, success and correctness.

``python tests/benchmarks/bench_derivation.py`` prints the table: for each law of the catalogue the time of
both, whether each found a formula, its operations, and whether its value agrees with quadrature at one point.
"""

import multiprocessing
import time

import mpmath
import sympy as sp

import stickslip_sym as ss
from stickslip_sym import criteria, symbols
from stickslip_sym.output.tables import aligned_table, duration

LIMIT = 30.0  # seconds that SymPy gets for an integral
NAMES = [name for name, law in ss.laws.catalogue.items() if law.expr.has(symbols.v)]


def law_integral(law, criterion):
    """Return a criterion as the integral that defines it."""
    slope = sp.diff(law, symbols.v).subs(symbols.v, symbols.V * (1 + symbols.s))
    return sp.Integral(-symbols.N * criterion.weight * slope, (symbols.s, -1, 1))


def sympy_alone(integral):
    """Return SymPy's result, or None, and the time it took."""
    start = time.perf_counter()
    with multiprocessing.Pool(1) as pool:  # which ends what takes too long
        try:
            result = pool.apply_async(sp.integrate, (integral.function, *integral.limits)).get(LIMIT)
        except Exception:  # of whatever kind: SymPy is late, or gave up
            result = None
    return (None if result is None or result.has(sp.Integral) else result), time.perf_counter() - start


def agrees(expr, law, criterion):
    """Tell whether a formula has the value of the definition at the typical parameters."""
    point = {symbols.V: sp.Rational(1, 2), symbols.N: sp.Integer(10)}
    point |= {law.parameters[name].symbol: value for name, value in law.values.items()}
    expected = ss.quadrature.damping(law, criterion, V="1/2", N=10, digits=20)
    try:
        got = mpmath.mpmathify(sp.N(expr.subs(point), 20))
        return bool(abs(got - expected) <= abs(expected) * mpmath.mpf("1e-12"))
    except (TypeError, ValueError):
        return False


def row(name, criterion):
    law = ss.laws.catalogue[name].typical()
    start = time.perf_counter()
    try:
        ours = ss.derive(law, criterion).expr
    except ss.NoClosedForm:
        ours = None
    ours_seconds = time.perf_counter() - start
    theirs, theirs_seconds = sympy_alone(law_integral(law.expr, criteria.find(criterion)))
    cells = [name, criterion]
    for expr, seconds in ((ours, ours_seconds), (theirs, theirs_seconds)):
        verdict = "none" if expr is None else "right" if agrees(expr, law, criterion) else "WRONG"
        cells += [duration(seconds), verdict, "" if expr is None else str(expr.count_ops())]
    return cells


if __name__ == "__main__":
    header = ["law", "criterion", "derive", "is", "operations", "sympy.integrate", "is", "operations"]
    rows = [row(name, criterion) for criterion in ("least_squares", "harmonic") for name in NAMES]
    print(aligned_table(header, rows))
