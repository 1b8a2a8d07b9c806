"""What each constant of `formula.evaluation.branch_builder` is worth, for laws of the catalogue and laws with
kinks.

Run ``python tests/benchmarks/measure_branches.py [CONSTANT ...]``; all of them take about five minutes.

Each constant is given other values, one at a time, and all branches are made anew. Printed are the seconds that
takes, averages that get no branches, panels, seconds for 2e5 values, and the largest error against balls, in units
of eps <|g'|>, over 30 decades about the scale of the profile.
"""

import sys
import time
from pathlib import Path

import numpy as np
from flint import arb

sys.path.insert(0, str(Path(__file__).parents[1]))

import stickslip_sym as ss
from stickslip_sym.core.precision import refined, working_precision
from stickslip_sym.criteria.enclosure import average_enclosure
from stickslip_sym.formula.evaluation import branch_builder
from stickslip_sym.formula.evaluation.branches import PanelTable
from stickslip_sym.formula.evaluation.reference_average import BITS, SMALLEST, MeanSlope
from stickslip_sym.numerics.known import Unknown

OTHERS = {
    "NEGLIGIBLE": (2.0**-53, 2.0**-72),
    "_CONDITION": ({-1: 1.1, 1: 1.1}, {-1: 4.0, 1: 16.0}),
    "_ALLOWED_UNITS": (1.0, 8.0),
    "OCTAVES_BEYOND_SCALES": (12, 40),
    "_OCTAVES": ((0.0,), tuple(np.linspace(0, 20, 41))),
    "_BRANCH_NODES": (13, 25),
    "_SMOOTH": (0.05 * 2.0**-52, 5 * 2.0**-52),
    "MOST_INTERVALS": (100, 2000),
    "_AT_KINK": (0.0, 64 * 2.0**-52),
}
R = np.geomspace(1e-15, 1e15, 121)
MANY = np.geomspace(1e-15, 1e15, 200_000)
KINKED = [
    "0.3 + 0.1*Abs(v - 0.7)", "0.2 + Max(0.3 - 0.4*v, 0)", "0.5*exp(-v)*Max(1 - v/3, 0)", "Max(0.5*exp(-v), 0.2)",
    "0.3*exp(-v)*cos(3*v)", "0.3*exp(-v)*tanh(v/0.01)",
]  # fmt: skip


class Case:
    """An average, its branches as a call makes them, and its values in balls."""

    def __init__(self, term, shapes):
        average = term.average
        closed = None if average.profile.has(branch_builder.sp.Piecewise) else average.closed
        self.arguments = average.profile, average.criterion, closed, tuple(term.exact_shapes(shapes).items())
        point = dict(self.arguments[-1])
        with np.errstate(all="ignore"):
            self.size = MeanSlope(average.profile, average.criterion, list(point))(R, *shapes)
        with working_precision(BITS):
            self.exact = [self.enclosed(average, point, r) for r in R]

    @staticmethod
    def enclosed(average, point, r):
        try:
            return refined(
                lambda: average_enclosure(average.profile, point, average.criterion, arb(r)), BITS // 2, 600
            )
        except ss.StickSlipError:
            return arb("nan")

    def errors(self, branches):
        with np.errstate(all="ignore"):
            values = branches(R)
        unit = 2.0**-52 * np.fmax(self.size, np.abs(values)) + SMALLEST
        off = [float((ball - arb(x)).abs_lower()) for ball, x in zip(self.exact, values, strict=True)]
        radii = np.array([float(ball.rad()) for ball in self.exact])
        known = np.isfinite(values) & (radii <= unit / 8)
        return (np.array(off)[known] / unit[known]).max(initial=0.0)


def cases():
    """Return the averages of the terms of some laws, each once."""
    found = {}
    for law in [*(law.typical() for law in ss.laws.catalogue.values()), *map(ss.FrictionLaw, KINKED)]:
        for criterion in ss.criteria.catalogue.values():
            average = ss.slope_average(law, criterion)
            values = [0.5, 1.0, *(float(average.law.values[name]) for name in list(average.arguments)[2:])]
            for term in average.functions:
                case = Case(term, term.shape_values(values))
                found.setdefault(case.arguments, case)
    return list(found.values())


def measured(all_cases):
    """Return seconds to make all branches, averages without, panels, seconds of values, the largest error."""
    making_time = calling_time = worst = 0.0
    without = panels = 0
    for case in all_cases:
        branch_builder.branches_of.cache_clear()
        start = time.process_time()
        branches = branch_builder.branches_of(*case.arguments)
        making_time += time.process_time() - start
        if isinstance(branches, Unknown):
            without += 1
            continue
        panels += sum(len(branch.rows) for branch in branches.branches if isinstance(branch, PanelTable))
        with np.errstate(all="ignore"):
            branches(MANY[:1000])
            start = time.process_time()
            branches(MANY)
            calling_time += time.process_time() - start
        worst = max(worst, case.errors(branches))
    return making_time, without, panels, calling_time, worst


def main(names):
    all_cases = cases()
    print(f"{len(all_cases)} averages of terms")
    header = ("constant", "value", "made in/s", "without", "panels", "called/s", "units")
    line = "{:12} {:>28.28} {:>9} {:>7} {:>6} {:>8} {:>7}"
    print(line.format(*header))
    measured(all_cases)  # what is computed once for all is not counted

    def row(name, value):
        made, without, panels, called, worst = measured(all_cases)
        cells = f"{made:.2f}", str(without), str(panels), f"{called:.2f}", f"{worst:.1f}"
        print(line.format(name, str(value), *cells), flush=True)

    row("as they are", "")
    for name in names:
        usual = getattr(branch_builder, name)
        for value in OTHERS[name]:
            setattr(branch_builder, name, value)
            row(name, value)
        setattr(branch_builder, name, usual)
    row("as they are", "")


if __name__ == "__main__":
    main(sys.argv[1:] or list(OTHERS))
