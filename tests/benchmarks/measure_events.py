"""Events of seeded random operating points and starts: missed, spurious, and how accurate their times are.

Run ``python tests/benchmarks/measure_events.py [COUNT] [SEED]``.

COUNT points, 5000 if not given. Each motion is looked at between its steps, a hundred times a step; every
twentieth is compared with a reference by DOP853 at 1e-13.
"""

import sys
from collections import defaultdict
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

import motions

import stickslip_sym as ss

COMPARED = 20  # one point of so many


def main(count, seed):
    table = defaultdict(lambda: defaultdict(list))
    for number, (kind, law, osc, x0, v0) in enumerate(motions.points(count, seed)):
        row = table[kind]
        try:
            motion, seconds = motions.simulated(law, osc, x0, v0)
        except ss.StickSlipError as error:
            row["wrong"].append(f"{type(error).__name__}: {error}")
            continue
        row["events"].append(len(motion.events))
        row["seconds"].append(seconds)
        row["wrong"] += [f"{osc}, x0={x0}, v0={v0}: {text}" for text in motions.violations(law, osc, motion)]
        if number // len(motions.KINDS) % COMPARED == seed % COMPARED:
            expected = motions.reference(law, osc, x0, v0, motion.t[-1])
            row["error"].append(error := motions.disagreement(motion.events, expected))
            if error == float("inf"):
                row["wrong"].append(f"{osc}, x0={x0}, v0={v0}: not the events of the reference")
    print(f"{'law':12} points  events  wrong  compared  largest error  median ms  largest ms")
    for kind, row in table.items():
        times = sorted(1e3 * seconds for seconds in row["seconds"])
        print(
            f"{kind:12} {len(times):6} {sum(row['events']):7} {len(row['wrong']):6} {len(row['error']):9} "
            f"{max(row['error'], default=0):14.1e} {times[len(times) // 2]:10.1f} {times[-1]:11.1f}"
        )
    for kind, row in table.items():
        for text in row["wrong"]:
            print(f"{kind}: {text}")


if __name__ == "__main__":
    given = [int(text) for text in sys.argv[1:]]
    main(*given, *(5000, 1)[len(given) :])
