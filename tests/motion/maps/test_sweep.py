"""Basins over one quantity: the shares, and the places where basins are born and die."""

from dataclasses import asdict
from itertools import pairwise

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym import Motion
from stickslip_sym.motion.kernel.slip_data import TIGHT
from stickslip_sym.motion.maps.results_over_axes import placed
from stickslip_sym.motion.maps.sweep import _folds
from stickslip_sym.motion.orbits.damping import NEAREST, needed_damping
from stickslip_sym.motion.regimes.regime import kept_regime
from stickslip_sym.numerics.resolved import Resolved
from support.operating_points import TWO, WAVY, WAVY_POINT, paper_oscillator
from support.sweeps import sweep

LAW = ss.laws.exponential.bind(mu_s=1, mu_m=0.5, alpha=2)
OSC = ss.Oscillator(m=1, k=1, c=0.1, V=1.5, N=1)
BOX = {"x0": (-2.0, 2.0), "v0": (0.0, 2.0)}


def test_births_and_deaths_have_their_closed_forms():
    found = ss.basin_sweep(LAW, OSC, ("V", np.linspace(1.0, 2.0, 9)), **BOX)
    hopf, graze = found.changes
    assert (hopf.kind, graze.kind) == ("Hopf", "graze")
    assert abs(hopf.value - np.log(10) / 2) <= hopf.error < 1e-12  # c = N alpha (mu_s - mu_m) exp(-alpha V)
    threshold = ss.pure_slip_damping(LAW, V=graze.value, N=1, m=1, k=1, method="orbit", rtol=1e-11)
    assert threshold.value == pytest.approx(0.1, rel=1e-10)
    assert graze.error < 1e-9
    rest, stick = (found.share[motion] for motion in (Motion.REST, Motion.STICK_SLIP))
    assert np.allclose(rest + stick, 1.0, rtol=0, atol=1e-13)
    assert (rest[:2] == 0).all()  # below the Hopf speed
    assert (rest[-2:] == 1).all()  # above the graze
    assert (np.diff(rest[2:-2]) > 0).all()
    osc = ss.Oscillator(m=1, k=1, c=0.1, V=found.x.values[4], N=1)
    share = ss.basin_map(LAW, osc, x0=np.linspace(-2, 2, 300), v0=np.linspace(0, 2, 300)).share[Motion.REST]
    assert abs(share.value - rest[4]) <= 2 * found.error[Motion.REST][4]
    assert max(error.max() for error in found.error.values()) < 1e-8


def test_a_fold_is_where_two_cycles_meet(tmp_path):
    osc = paper_oscillator(2.5)
    found = ss.basin_sweep(TWO, osc, ("c", [2.5, 3.3, 3.8, 4.5]), x0=(-0.2, 0.2), v0=(-1, 1))
    assert [change.kind for change in found.changes] == ["Hopf", "graze", "fold"]
    fold = found.changes[-1]
    counts = [len(ss.limit_cycles(TWO, paper_oscillator(fold.value * (1 + side * 1e-6)))) for side in (-1, 1)]
    assert counts == [2, 0]
    assert fold.error < 1e-6
    found.plot(tmp_path / "sweep.svg")
    text = (tmp_path / "sweep.svg").read_text()
    assert "<!-- fold 4.04658 -->" in text
    assert "<!-- share of the box of initial conditions -->" in text


def test_folds_below_the_least_amplitude_are_not_known(monkeypatch):
    """Beside a jump of mu at V the damping that orbits need is not resolved below an amplitude."""
    law = ss.FrictionLaw("0.5 - 0.1*v - Piecewise((0, v < 1), (0.02, True))")
    need = needed_damping(law, ss.Oscillator(m=1, k=100, c=1, V=1, N=1))
    assert not need.covers_all_amplitudes
    assert needed_damping(LAW, OSC).least == NEAREST

    def at(c):
        return kept_regime(law, ss.Oscillator(m=1, k=100, c=c, V=1, N=1), TIGHT)

    monkeypatch.setitem(vars(need), "resolved", Resolved((), (), 0.0))
    assert _folds(at, 0.05, 2.0, over_damping=True) == ([], [(0.05, 2.0)])


def test_a_fold_over_another_quantity():
    found = ss.basin_sweep(TWO, paper_oscillator(3.8), ("N", [7, 8.6, 9.5, 12]), x0=(-0.2, 0.2), v0=(-1, 1))
    fold, graze = found.changes
    assert (fold.kind, graze.kind) == ("fold", "graze")
    beside = [paper_oscillator(3.8, N=fold.value * (1 + side * 1e-7)) for side in (-1, 1)]
    assert [len(ss.limit_cycles(TWO, osc)) for osc in beside] == [0, 2]


@sweep(
    ("name", "values", "folds"),
    [("c", (0.05, 0.1), 6), ("N", (0.5, 0.8), 6), ("V", (0.43, 0.46), 3), ("h", (0.002, 0.011), 1)],
    ("c", (0.05, 0.1), 6),
)
def test_numbers_of_cycles_change_where_basins_do(name, values, folds):
    """By two at a fold and by one at a graze or where rest turns: so none is missed, and none is too many."""
    found = ss.basin_sweep(WAVY, WAVY_POINT, (name, values), x0=(-0.1, 0.2), v0=(-0.3, 0.4))
    assert found.unresolved == ()
    kinds = [change.kind for change in found.changes]
    assert kinds.count("fold") == folds
    ends = [values[0], *(change.value for change in found.changes), values[1]]
    numbers = [
        len(ss.limit_cycles(*placed(WAVY, asdict(WAVY_POINT) | {name: (low + high) / 2})))
        for low, high in pairwise(ends)
    ]
    assert [abs(step) for step in np.diff(numbers)] == [2 if kind == "fold" else 1 for kind in kinds]


def test_folds_that_are_not_resolved_are_named(monkeypatch):
    monkeypatch.setattr("stickslip_sym.motion.maps.sweep.MOST_ORBITS", 1)
    found = ss.basin_sweep(TWO, paper_oscillator(3.8), ("N", [7, 12]), x0=(-0.2, 0.2), v0=(-1, 1))
    assert found.unresolved == ((7.0, 12.0),)
    assert "folds not resolved from 7 to 12" in str(found)


@pytest.mark.parametrize(("slope", "beyond"), [(0.3, 0.29), (0.2, 0.38)])
def test_where_cycles_reach_a_kink_or_a_jump_there_is_no_fold(slope, beyond):
    law = ss.FrictionLaw(f"Piecewise((0.5 - {slope}*v, v < 0.7), ({beyond}, True))")
    found = ss.basin_sweep(law, paper_oscillator(), ("c", np.linspace(-1, 4, 8)), x0=(-0.2, 0.2), v0=(-1, 1))
    assert [change.kind for change in found.changes] == ["graze", "Hopf"]


def test_a_sweep_of_one_value_is_drawn(tmp_path):
    ss.basin_sweep(LAW, OSC, ("c", [OSC.c]), **BOX).plot(tmp_path / "one.svg")
    assert "<!-- share of the box of initial conditions -->" in (tmp_path / "one.svg").read_text()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"over": ("W", [1, 2])}, "no axis can be 'W'"),
        ({"over": ("V", [2, 1])}, "do not ascend"),
        ({"x0": (1, -1)}, "x0 do not ascend"),
        ({"v0": (1, 1)}, "do not ascend"),
        ({"x0": 1.0}, "the values of x0 are one row of numbers"),
        ({"v0": (1, 2, 3)}, "goes from one v0 to a higher one"),
    ],
)
def test_wrong_input(changes, message):
    with pytest.raises(ss.InputError, match=message):
        ss.basin_sweep(LAW, OSC, **({"over": ("V", [1, 2])} | BOX | changes))
