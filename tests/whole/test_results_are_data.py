"""Results are data: what a notebook or a log shows of them computes nothing, and neither does a comparison."""

import copy
import dataclasses
from dataclasses import replace

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym.formula.average import Average
from stickslip_sym.formula.slope_average import SlopeAverage
from stickslip_sym.model import law
from stickslip_sym.model.fitting import least_squares
from stickslip_sym.motion import slip
from stickslip_sym.motion.maps import basins
from stickslip_sym.motion.orbits import needed, orbit
from stickslip_sym.motion.thresholds import methods
from support.sample_results import untouched

LAW = ss.laws.exponential.typical()
OSC = ss.Oscillator(m=1, k=100, c=2.3, V=0.5, N=9.81)
BISTABLE = replace(OSC, c=2.45)


SHARED = "trajectory", "threshold", "thresholds", "cycle", "limit_cycle", "map", "basins", "study", "regime"


def results():
    """Yield results of all functions that integrate motions."""
    *others, study, regime = untouched(*SHARED)
    yield from others
    uncertain = ss.FrictionLaw("0.3 + 0.2*exp(-v/v_s)").bind(v_s="0.4(0.05)")
    yield ss.simulate(LAW, OSC, t_end=3.0, method="solve_ivp")
    yield ss.simulate(LAW, OSC, t_end=3.0, x0=[0.0, 0.1])
    yield from (regime, regime.rest, regime.outside, *regime.cycles, *regime.separatrices, regime.stick_slip)
    threshold = ss.pure_slip_damping(uncertain, OSC, method="orbit")
    yield from (threshold, threshold.budget)
    yield ss.compare(LAW, OSC)
    sweep = ss.basin_sweep(LAW, BISTABLE, ("c", [2.3, 3.0]), x0=(-0.1, 0.1), v0=(-0.5, 0.5))
    yield from (sweep, *sweep.changes)
    fits = ss.fit(*jumping(), laws=["coulomb", "a - b*sign(v - v_0)"])
    yield from (fits, *fits)
    yield from (study, study.margins)
    margins = ss.margins(uncertain, OSC, errors={"N": "9.81(1)"})
    yield from (margins, *margins.rows, margins.rows[0].below or margins.rows[0].above)
    tradeoff = ss.tradeoff(LAW, of="criterion")
    yield from (tradeoff, *tradeoff.trades.values())


def jumping():
    """Measurements of friction that jumps."""
    v = np.linspace(0.05, 1.0, 40)
    return v, np.where(v < 0.5, 0.4, 0.3) + 0.01 * np.random.default_rng(3).normal(size=v.size)


COMPUTING = [  # of motions, orbits, thresholds, averages, closed forms and fits
    (slip, "follow"), (needed, "follow"), (slip, "_follow_all"), (needed, "search_damping_ratios"),
    (needed, "velocity_mismatches"),
    (methods, "evaluate"), (methods, "good_enough"), (orbit, "orbits"), (SlopeAverage, "_total"),
    (least_squares.Problem, "minimum"), (Average, "find"), (basins, "shares_by_area"), (law, "slope_of"),
]  # fmt: skip


def is_compared_by_what_it_says(result):
    """A list of results, and what holds functions, is equal to itself alone."""
    return dataclasses.is_dataclass(result) and type(result).__eq__ is not object.__eq__


def test_no_view_of_a_result_computes(monkeypatch, of_each_kind):
    made = [result for result in results() if result is not None]

    def computed(*_, **__):
        raise RuntimeError("something was computed")

    for owner, name in COMPUTING:
        monkeypatch.setattr(owner, name, computed)
    for control in (
        lambda: ss.simulate(LAW, OSC, t_end=1.0),
        lambda: ss.pure_slip_damping(LAW, OSC),
        lambda: ss.fit(*jumping(), laws="coulomb"),
    ):
        with pytest.raises(RuntimeError, match="computed"):
            control()
    for result in made:
        assert repr(result)
        assert str(result)
        assert result == result
        assert copy.copy(result) == result or not is_compared_by_what_it_says(result)
        if hasattr(result, "_repr_html_"):
            assert result._repr_html_()
