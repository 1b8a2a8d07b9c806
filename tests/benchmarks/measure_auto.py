"""Whether ``method="auto"`` ever picks a dominated method, over seeded operating points.

Run ``python tests/benchmarks/measure_auto.py [COUNT] [SEED]``; COUNT is 500 if not given.

In each point, of a law of the catalogue with random parameters and with V, N, m, k and rtol over decades, every
method is asked by name for a threshold good to rtol, its error included, and so is "auto". The time is that of the
processor, the least of several; the error is the true one, against the grazing orbit to 1e-12, else a proof.

"auto" is dominated by a method that is faster by the margin and as accurate, or as fast and more accurate by it.
What seems so is measured again, so that noise is not taken for it. Each case that is so each time is printed, and
counted by what was picked and what dominates it. Methods that take much longer than
"auto" dominate nothing, and are interrupted; it needs a POSIX system.
"""

import signal
import sys
import time
import warnings
from collections import Counter
from contextlib import contextmanager, suppress
from functools import partial

import numpy as np

import stickslip_sym as ss
from stickslip_sym.motion.thresholds.methods import methods

MARGIN = 1.5  # of times and of errors: what noise and rounding make of equal ones
AGAIN = 4  # times that a dominated pick is measured again
EXACT = 1e-12  # an error below is not told from none
LEAST, MOST = 3, 7  # times that each is measured
ENOUGH = 0.05  # seconds after which it is measured no more
LONGEST = 5.0  # seconds of a reference, and of "auto"
WARM = 1.0  # seconds that the first call of a law may take to make its functions
OTHERS = 5  # times as long, on a machine that does other things too
RANGES = {"V": (-2, 0.5), "N": (-1, 2), "m": (-2, 2), "k": (0, 5)}
TOLERANCES = (-10, -0.5)


def points(count, seed):
    """Yield laws, operating points and tolerances; what friction does to the orbit runs over many decades."""
    rng = np.random.default_rng(seed)
    names = sorted(ss.laws.catalogue)
    for number in range(count):
        law = ss.laws.catalogue[names[number % len(names)]].typical()
        values = {name: float(value) * 10 ** rng.uniform(-0.1, 0.1) for name, value in law.values.items()}
        point = {name: 10 ** rng.uniform(*ends) for name, ends in RANGES.items()}
        yield law.bind(**values), point, 10 ** rng.uniform(*TOLERANCES)


def timed(compute):
    """Return a value, and the least of several times of the processor."""
    times = []
    while len(times) < LEAST or (len(times) < MOST and sum(times) < ENOUGH):
        start = time.process_time()
        value = compute()
        times.append(time.process_time() - start)
        if len(times) > 1 and min(times) > ENOUGH:  # the first call makes functions
            break
    return value, min(times)


@contextmanager
def at_most(seconds):
    """Interrupt what takes longer; a timer of the processor's time would make its clock a coarse one."""

    def stop(*_):
        raise TimeoutError

    signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)


def truth(law, point):
    """Return the threshold; None where there is none, or it is not known well enough."""
    for method, rtol in (("orbit", EXACT), ("proof", 1e-11)):
        with suppress(ss.StickSlipError, TimeoutError), at_most(LONGEST):
            value = ss.pure_slip_damping(law, **point, method=method, rtol=rtol).value
            return value if value > 0 else None
    return None


def measured(law, point, rtol):
    """Return what "auto" picks, its time and true error, and the methods good to rtol that dominate it."""
    exact = truth(law, point)
    if exact is None:
        return None

    def ask(method, tolerance, seconds):
        with at_most(seconds):
            found, taken = timed(partial(ss.pure_slip_damping, law, **point, method=method, rtol=tolerance))
        return found, taken, max(abs(found.value / exact - 1), EXACT)

    try:
        auto, seconds, error = ask("auto", rtol, LONGEST)
    except (ss.StickSlipError, TimeoutError):
        return None
    better = {}
    for name, method in methods().items():
        if name == auto.method or not method.automatic:  # a proof, which takes much longer than any of the others
            continue
        with suppress(ss.StickSlipError, TimeoutError):
            limit = WARM + OTHERS * (LEAST + 1) * seconds
            found, taken, off = ask(name, min(max(rtol, method.tightest), method.loosest), limit)
            good = found.relative_error is not None and max(found.relative_error, off) <= rtol
            if good and (
                (taken * MARGIN <= seconds and off <= error) or (taken <= seconds and off * MARGIN <= error)
            ):
                better[name] = taken, off
    return auto.method, seconds, error, better


def main(count, seed):
    cases, picks, none, dominated, spent = Counter(), Counter(), 0, 0, 0.0
    for law, point, rtol in points(count, seed):
        found = measured(law, point, rtol)
        if found is None:
            none += 1
            continue
        picked, seconds, error, better = found
        picks[picked] += 1
        spent += seconds
        for _ in range(AGAIN):
            again = measured(law, point, rtol) if better else None
            better = {name: better[name] for name in better if again is not None and name in again[3]}
        dominated += bool(better)
        for name, (taken, off) in better.items():
            cases[picked, name] += 1
            place = ", ".join(f"{key} = {value:.3g}" for key, value in point.items())
            times = f"{seconds:.2e} s, {error:.1e} by {taken:.2e} s, {off:.1e}"
            print(f"{law.name}, {place}, rtol = {rtol:.1e}: {picked} {times} of {name}", flush=True)
    print(f"\n{sum(picks.values())} points with a threshold, {none} without; auto took {spent:.3g} s in all")
    print(f"picked: {dict(picks.most_common())}; dominated: {dominated}, {dict(cases)}")


if __name__ == "__main__":
    warnings.simplefilter("ignore", ss.InputWarning)  # of friction that is negative somewhere
    main(*(int(text) for text in sys.argv[1:]), *(500, 1)[len(sys.argv) - 1 :])
