"""What the files and the pictures of maps, basins and sweeps show."""

import csv
import re
from dataclasses import replace

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym import Motion
from stickslip_sym.motion.maps.results_over_axes import Axis
from support.operating_points import paper_oscillator

LAW = ss.laws.exponential.typical()
POINT = {"N": 9.81, "m": 1.0, "k": 100.0}
V, C = np.linspace(0.05, 0.95, 7), np.linspace(0.02, 6, 8)


AXES = [
    (("V", V[:3]), ("c", C[:5])),
    (("c", C[:4]), ("alpha", [2.0, 3.0])),
    (("N", [2.0, 9.0, 12.0]), ("k", [20, 90])),
]


def words(cells):
    return [[one.value for one in row] for row in cells]


@pytest.mark.parametrize(("x", "y"), AXES)
def test_files_hold_what_the_cells_say(tmp_path, x, y):
    fixed = {"V": 0.4, "c": 2.3, "m": 1.0, "k": 100.0, "N": 9.81}
    found = ss.motion_map(LAW, x=x, y=y, **{name: fixed[name] for name in fixed if name not in (x[0], y[0])})
    expected = {name: words(getattr(found, name)) for name in ("motion", "reason")}
    expected |= found.attractors | {f"c_{name}": curve for name, curve in found.thresholds.items()}
    check_files(found, expected, tmp_path)


def test_files_of_basins(tmp_path):
    found = ss.basin_map(LAW, paper_oscillator(2.3), x0=[-0.1, 0.0, 0.02, 0.1], v0=[0.0, 0.1, 0.4])
    check_files(found, {"motion": words(found.motion)}, tmp_path)


def check_files(found, expected, folder):
    cells = {name: np.broadcast_to(np.array(column), found.motion.shape) for name, column in expected.items()}
    cells |= dict(zip((found.x.name, found.y.name), np.meshgrid(found.x.values, found.y.values), strict=True))
    found.to_csv(folder / "cells.csv")
    with (folder / "cells.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert set(rows[0]) == set(cells)
    for name, column in cells.items():
        texts = [row[name] for row in rows]
        assert (texts if column.dtype.kind == "U" else list(map(float, texts))) == column.ravel().tolist()
    found.to_npz(folder / "cells.npz")
    expected |= {"x": found.x.values, "x_name": found.x.name, "x_unit": found.x.unit}
    expected |= {"y": found.y.values, "y_name": found.y.name, "y_unit": found.y.unit}
    expected |= {f"fixed_{name}": value for name, value in found.fixed.items()}
    with np.load(folder / "cells.npz", allow_pickle=False) as arrays:
        assert set(arrays.files) == {"law", *expected}
        assert all(np.array_equal(arrays[name], content) for name, content in expected.items())
    with pytest.raises(ss.InputError, match="cannot write"):
        found.to_csv(folder / "missing" / "map.csv")


def test_the_legend_names_the_curves_that_are_drawn():
    """Lines along c, and contours otherwise."""
    contour = pytest.importorskip("matplotlib.contour")
    for axes, curves in (
        ({"x": ("V", V), "y": ("N", [9.81]), "c": 2.0}, 0),  # over a single row of N there is none
        ({"x": ("V", V), "y": ("N", [5.0, 9.81]), "c": 2.0}, 3),
        ({"x": ("c", [1, 2]), "y": ("V", [0.1, 0.2]), "N": 9.81}, 3),
    ):
        figure = ss.motion_map(LAW, **axes, m=1.0, k=100.0).plot()
        contours = [one for one in figure.axes[0].collections if isinstance(one, contour.ContourSet)]
        drawn = [one for one in contours if one.get_paths()] + figure.axes[0].lines[:]
        texts = [text.get_text() for text in figure.legends[0].get_texts()]
        named = [text for text in texts if re.search("threshold|criterion", text)]
        assert len(named) == len(drawn) == curves


def test_pictures_in_axes_of_ones_own(tmp_path):
    figure_module = pytest.importorskip("matplotlib.figure")
    osc, figure = paper_oscillator(2.3), figure_module.Figure()
    results = [
        ss.motion_map(LAW, x=("V", V[:2]), y=("c", C[:2]), **POINT),
        ss.basin_map(LAW, osc, x0=[0.0, 0.1], v0=[0.0, 0.1]),
        ss.basin_sweep(LAW, osc, ("c", [2.2, 2.3]), x0=(0, 0.1), v0=(0, 0.1)),
        ss.regime(LAW, osc),
    ]
    panels = figure.subplots(2, 2).ravel()
    assert all(found.plot(ax=ax) is figure for found, ax in zip(results, panels, strict=True))
    results[0].plot(tmp_path / "all.svg", ax=panels[0])
    text = (tmp_path / "all.svg").read_text()
    for label in ("belt speed V (m/s)", "initial velocity v0 (m/s)", "separatrix", "stick-slip", "rest"):
        assert f"<!-- {label} -->" in text


def test_hatching_fills_its_cells_and_no_others():
    """Seeded motions on coarse grids, even, by ratios or neither: what is hatched is what has that colour."""
    to_rgb = pytest.importorskip("matplotlib.colors").to_rgb
    rng, hatched = np.random.default_rng(6), 0
    basins = ss.basin_map(LAW, paper_oscillator(2.3), x0=[0.0], v0=[0.0])
    for _ in range(12):
        columns, rows = rng.integers(1, 9, 2).tolist()
        x0 = rng.choice([np.geomspace(0.01, 9, columns), np.linspace(-1, 2, columns)])
        v0 = np.cumsum(rng.uniform(0.1, 3, rows))
        motion = rng.choice(list(Motion), (rows, columns))
        over = Axis("x0", x0, "m", ""), Axis("v0", v0, "m/s", "")
        axes = replace(basins, axes=over, motion=motion).plot().axes[0]
        (mesh,) = (one for one in axes.collections if hasattr(one, "get_coordinates"))
        edges, colours = mesh.get_coordinates(), mesh.to_rgba(mesh.get_array())
        (left, low), (right, high) = edges[:-1, :-1].T, edges[1:, 1:].T
        share = rng.uniform(0.02, 0.98, (40, 2, columns, rows))
        places = np.stack([left + share[:, 0] * (right - left), low + share[:, 1] * (high - low)], axis=-1)
        inside = {
            patch.get_hatch(): patch.get_path().contains_points(places.reshape(-1, 2)).reshape(40, columns, rows)
            for patch in axes.patches
        }
        expected = (colours.transpose(1, 0, 2)[:, :, :3] == to_rgb("#009E73")).all(axis=-1)  # pure slip
        assert set(inside) <= {"...."}
        assert expected.any() == bool(inside)
        for found in inside.values():
            assert (found == expected).all()
            hatched += 1
    assert hatched >= 8
