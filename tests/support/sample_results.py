"""One of every result, made once for all tests that look at results."""

import pickle
from functools import cache

import numpy as np

import stickslip_sym as ss
from stickslip_sym.formula.proof.proving import prove_equal
from support.operating_points import paper_oscillator


@cache
def one_of_each():
    """Return one of every result by a name, each used once, so that what it keeps for later is there."""
    law = ss.laws.exponential.typical()
    law.mu(0.3)
    form = ss.derive(law)
    form(V=0.5, N=9.81)
    average = ss.slope_average(law)
    average(V=0.5, N=9.81)
    sampled = ss.FrictionLaw.from_samples([0, 0.1, 0.2, 0.5], [0.5, 0.4, 0.35, 0.3])
    sampled.mu(0.3)
    both = paper_oscillator(c=2.2)
    at = {"N": 9.81, "m": 1.0, "k": 100.0}
    regime = ss.regime(law, both)
    return {
        "law": law,
        "sampled": sampled,
        "form": form,
        "average": average,
        "derivation": form.derivation,
        "step": form.derivation.steps[0],
        "verdict": form.verdict,
        "refuted": prove_equal(ss.symbols.V, 2 * ss.symbols.V),
        "threshold": ss.pure_slip_damping(law, V=0.5, **at),
        "thresholds": ss.pure_slip_damping(law, V=np.linspace(0.1, 1.0, 30).reshape(3, 10), **at),
        "unknown": ss.pure_slip_damping(law, V=[0.5, 0.6], N=9.81),
        "speed": ss.critical(law, "V", c=2.0, N=9.81)[0],
        "cycle": ss.stick_slip_cycle(law, both),
        "limit_cycle": ss.limit_cycles(law, both)[0],
        "regime": regime,
        "rest": regime.rest,
        "separatrix": regime.separatrices[0],
        "trajectory": ss.simulate(law, both, t_end=5.0),
        "map": ss.motion_map(law, x=("V", [0.1, 0.9]), y=("alpha", [2.0, 3.0]), c=2.2, **at),
        "basins": ss.basin_map(law, both, x0=[0.0, 0.05], v0=[0.0, 0.5]),
        "study": ss.study(law, both, time_limit=300),
    }


@cache
def _kept():
    return {name: pickle.dumps(result) for name, result in one_of_each().items()}


def untouched(*names):
    """Return results as they were made: nothing was looked at that they would keep for later."""
    return [pickle.loads(_kept()[name]) for name in names]
