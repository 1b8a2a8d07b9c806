"""The largest error of every law, criterion and regime.

Run ``python tests/benchmarks/measure_accuracy.py [COUNT] [LAW ...]``.

In units of epsilon N <|mu'|>, at random points whose criterion is computed with at least 70 digits. COUNT points
in each regime, 10000 if not given; laws whose special functions take milliseconds a value get fewer, as printed.
"""

import sys
import time
from pathlib import Path

import sympy as sp

sys.path.insert(0, str(Path(__file__).parents[1]))

import stickslip_sym as ss
from support import accuracy
from support.closed_forms import WITHOUT, form_of

SECONDS = 40.0  # of references for one law, criterion and regime


def main(count, names):
    print(f"{'law':20} {'criterion':14} " + " ".join(f"{regime:>16}" for regime in accuracy.REGIMES))
    for name in names:
        for criterion in ss.criteria.catalogue:
            if name in WITHOUT.get(criterion, ()):
                continue
            form = form_of(name, criterion)
            cells = []
            for regime in accuracy.REGIMES:
                try:
                    cells.append(measured(form, regime, count))
                except ss.StickSlipError as error:
                    cells.append(type(error).__name__)
            print(f"{name:20} {criterion:14} " + " ".join(f"{cell:>16}" for cell in cells), flush=True)
    print(f"plain lambdify of (17), middle: {printed(min(count, 1000)):.1e}")


def measured(form, regime, count):
    """Return the largest error and the number of operating points."""
    start = time.perf_counter()
    accuracy.reference(form, accuracy.samples(form.law, regime, 10, seed=0))
    each = (time.perf_counter() - start) / 10
    count = max(10, min(count, int(SECONDS / each)))
    columns = accuracy.samples(form.law, regime, count, seed=0)
    return f"{accuracy.units(form, columns, form(**columns)).max():.1f} ({count})"


def printed(count):
    """Return the largest error of the known-bad function."""
    import numpy as np

    form = form_of("exponential", "least_squares")
    plain = sp.lambdify(list(form.arguments.values()), form.expr, "numpy")
    columns = accuracy.samples(form.law, "middle", count, seed=0)
    with np.errstate(all="ignore"):
        values = plain(*(columns[name] for name in form.arguments))
    return accuracy.units(form, columns, values).max()


if __name__ == "__main__":
    arguments = sys.argv[1:]
    number = int(arguments.pop(0)) if arguments and arguments[0].isdigit() else 10_000
    main(number, arguments or list(ss.laws.catalogue))
