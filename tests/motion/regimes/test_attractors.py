"""A further kind of attractor is one entry of a table."""

import csv

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym.cli.map import report
from stickslip_sym.motion.regimes.attractors import ATTRACTORS, AttractorKind, Region
from support.operating_points import paper_oscillator

OVERTAKING = AttractorKind(
    "overtaking", ss.Motion.PURE_SLIP, Region("overtaking", "#0072B2", "\\\\", "V"),
    of=lambda regime: tuple(one for one in regime.cycles if one.amplitude > regime.oscillator.V),
    exists=lambda signs: signs.returns & ~signs.held,
)  # fmt: skip
LAW = ss.laws.exponential.typical()
PLANE = {"x": ("V", [0.5, 5.0]), "y": ("N", [0.5, 20.0]), "c": 0.05, "m": 1, "k": 100}


@pytest.fixture
def one_more():
    ATTRACTORS.append(OVERTAKING)
    yield
    ATTRACTORS.remove(OVERTAKING)


@pytest.mark.usefixtures("one_more")
def test_one_entry_reaches_regimes_maps_files_and_pictures(tmp_path):
    found = ss.motion_map(LAW, **PLANE)
    exists = found.attractors["overtaking"]
    assert exists.any()
    assert not exists.all()
    for row, column in np.ndindex(exists.shape):
        osc = paper_oscillator(0.05, V=found.x.values[column], N=found.y.values[row])
        kinds = {kind.name: bool(kind.of(ss.regime(LAW, osc))) for kind in ATTRACTORS}
        assert kinds == {name: bool(array[row, column]) for name, array in found.attractors.items()}
    found.to_csv(tmp_path / "map.csv")
    with (tmp_path / "map.csv").open(newline="") as stream:
        assert [int(row["overtaking"]) for row in csv.DictReader(stream)] == exists.ravel().astype(int).tolist()
    found.to_npz(tmp_path / "map.npz")
    with np.load(tmp_path / "map.npz") as arrays:
        assert np.array_equal(arrays["overtaking"], exists)
    assert "pure slip or overtaking, by the initial condition" in report(found)
    pytest.importorskip("matplotlib")
    found.plot(tmp_path / "map.svg")
    assert "pure slip or overtaking, by the initial condition" in (tmp_path / "map.svg").read_text()
    row, column = np.argwhere(exists)[0]
    V, N = found.x.values[column], found.y.values[row]
    assert ss.regime(LAW, paper_oscillator(0.05, V=V, N=N)).attractors[-1].amplitude > V


def test_without_its_entry_nothing_knows_it():
    assert "overtaking" not in ss.motion_map(LAW, **PLANE).attractors
