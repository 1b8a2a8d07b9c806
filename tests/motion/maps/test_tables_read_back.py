"""Every column of the files that maps and basins write, read back by its header's name.

The content is made up and different in every direction, so that no column can stand in for another, nor rows for
columns.
"""

import csv
from dataclasses import asdict, replace
from itertools import product

import numpy as np
import pytest
from scenes import paper_oscillator

import stickslip_sym as ss
from stickslip_sym import Motion
from stickslip_sym.motion.maps.basins import BasinMap
from stickslip_sym.motion.maps.cells import Reason
from stickslip_sym.motion.maps.motions import MotionMap
from stickslip_sym.motion.maps.table import Axis

LAW = ss.laws.exponential.typical()
ATTRACTORS = ("stick_slip", "rest", "pure_slip")
CURVES = ("equilibrium", "least_squares", "exact")


def rows_of(path):
    with path.open(newline="") as stream:
        return list(csv.DictReader(stream))


def any_of(rng, kinds, shape):
    found = np.empty(shape, dtype=object)
    for place in np.ndindex(shape):
        found[place] = list(kinds)[rng.integers(len(kinds))]
    return found


def made_up_map(rng, names):
    """Return a map of 5 rows and 3 columns, or of 2 and 4, whose arrays have nothing in common."""
    shape = [(5, 3), (2, 4)][rng.integers(2)]
    x, y = (
        Axis(name, np.sort(rng.uniform(low, low + 1, size)), "some unit", "")
        for name, low, size in zip(names, (0, 3), shape[::-1], strict=True)
    )
    # A threshold broadcasts: along c it is one number for each cell of the other axis.
    flat = (1, shape[1]) if y.name == "c" else (shape[0], 1) if x.name == "c" else shape
    return MotionMap(
        axes=(x, y), law=LAW, fixed={"m": 1.0, "k": 100.0}, motion=any_of(rng, Motion, shape),
        attractors={name: rng.random(shape) < 0.5 for name in ATTRACTORS}, reason=any_of(rng, Reason, shape),
        thresholds={name: rng.normal(size=flat) for name in CURVES}, notes={},
    )  # fmt: skip


@pytest.mark.parametrize("names", [("V", "c"), ("c", "alpha"), ("N", "k")])
def test_a_maps_columns_are_what_its_cells_say(tmp_path, names):
    rng = np.random.default_rng(20160428)
    for number in range(5):
        found = made_up_map(rng, names)
        found.to_csv(tmp_path / f"{number}.csv")
        rows = iter(rows_of(tmp_path / f"{number}.csv"))
        height, width = found.motion.shape
        for row, column in product(range(height), range(width)):
            cell = next(rows)
            thresholds = {
                f"c_{name}": curve[row % curve.shape[0], column % curve.shape[1]]
                for name, curve in found.thresholds.items()
            }
            expected = {found.x.name: found.x.values[column], found.y.name: found.y.values[row]}
            expected |= {name: found.attractors[name][row, column] for name in ATTRACTORS} | thresholds
            assert (cell.pop("motion"), cell.pop("reason")) == (
                found.motion[row, column].value, found.reason[row, column].value,
            )  # fmt: skip
            assert {name: float(text) for name, text in cell.items()} == expected
        assert next(rows, None) is None


@pytest.mark.parametrize("names", [("V", "c"), ("c", "alpha")])
def test_a_maps_arrays_are_its_attributes(tmp_path, names):
    found = made_up_map(np.random.default_rng(7), names)
    found.to_npz(tmp_path / "map.npz")
    with np.load(tmp_path / "map.npz", allow_pickle=False) as arrays:
        kept = {name: arrays[name] for name in arrays.files}
    for side, axis in (("x", found.x), ("y", found.y)):
        assert kept.pop(side).tolist() == axis.values.tolist()
        assert (kept.pop(f"{side}_name"), kept.pop(f"{side}_unit")) == (axis.name, axis.unit)
    for name in ATTRACTORS:
        assert kept.pop(name).tolist() == found.attractors[name].tolist()
    for name in ("motion", "reason"):
        assert kept.pop(name).tolist() == [[one.value for one in row] for row in getattr(found, name)]
    for name, curve in found.thresholds.items():
        assert kept.pop(f"c_{name}").tolist() == curve.tolist()
    assert {name: float(kept.pop(f"fixed_{name}")) for name in found.fixed} == found.fixed
    assert set(kept) == {"law"}


def test_a_basins_files_are_what_its_starts_say(tmp_path):
    rng = np.random.default_rng(3)
    osc = paper_oscillator(3.0)
    osc = replace(osc, **{name: value * rng.uniform(0.9, 1.1) for name, value in asdict(osc).items()})
    x0, v0 = np.sort(rng.uniform(-2, -1, 4)), np.sort(rng.uniform(0, 1, 3))
    axes = Axis("x0", x0, "m", ""), Axis("v0", v0, "m/s", "")
    motion = any_of(rng, Motion, (3, 4))
    found = BasinMap(axes, LAW, asdict(osc), motion, ss.regime(LAW, osc), {}, 12, 0, {})
    found.to_csv(tmp_path / "basins.csv")
    rows = [(float(row["x0"]), float(row["v0"]), row["motion"]) for row in rows_of(tmp_path / "basins.csv")]
    assert rows == [(x, v, found.motion[j, i].value) for (j, v), (i, x) in product(enumerate(v0), enumerate(x0))]
    found.to_npz(tmp_path / "basins.npz")
    with np.load(tmp_path / "basins.npz", allow_pickle=False) as arrays:
        assert (arrays["x"].tolist(), arrays["y"].tolist()) == (x0.tolist(), v0.tolist())
        assert (arrays["x_name"], arrays["y_unit"]) == ("x0", "m/s")
        assert arrays["motion"].tolist() == [[one.value for one in row] for row in found.motion]
        assert {name: float(arrays[f"fixed_{name}"]) for name in asdict(osc)} == asdict(osc)


def test_a_motions_columns_are_its_samples(tmp_path):
    motion = ss.simulate(LAW, paper_oscillator(1.0), t_end=3.0, v0=0.1)
    motion.to_csv(tmp_path / "motion.csv")
    rows = rows_of(tmp_path / "motion.csv")
    for name in ("t", "x", "v"):
        (column,) = (header for header in rows[0] if header.split()[0] == name)
        assert [float(row[column]) for row in rows] == getattr(motion, name).tolist()
    assert [row["phase"] for row in rows] == [phase.name.lower() for phase in motion.phase]
