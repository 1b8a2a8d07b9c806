"""What a map's picture and files show."""

import csv
import dataclasses
import re

import numpy as np
import pytest
from scenes import paper_oscillator

import stickslip_sym as ss
from stickslip_sym import Motion
from stickslip_sym.motion.maps.table import Axis

SCENE = {"N": 9.81, "m": 1.0, "k": 100.0}
V, C = np.linspace(0.05, 0.95, 7), np.linspace(0.02, 6, 8)


def test_files_hold_what_the_map_does(tmp_path, law):
    found = ss.motion_map(law, x=("V", V), y=("c", C), **SCENE)
    found.to_npz(tmp_path / "map.npz")
    with np.load(tmp_path / "map.npz", allow_pickle=False) as arrays:
        assert np.array_equal(arrays["x"], V)
        assert (arrays["x_name"], arrays["y_unit"], arrays["fixed_N"]) == ("V", "kg/s", 9.81)
        assert arrays["motion"].tolist() == [[motion.value for motion in row] for row in found.motion]
        assert np.array_equal(arrays["rest"], found.attractors["rest"])
        assert np.array_equal(arrays["c_exact"], found.thresholds["exact"])
    found.to_csv(tmp_path / "map.csv")
    with (tmp_path / "map.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row["V"]) for row in rows] == [*V] * C.size
    assert [row["motion"] for row in rows] == [motion.value for motion in found.motion.ravel()]
    assert [float(row["c_exact"]) for row in rows[: V.size]] == found.thresholds["exact"][0].tolist()
    with pytest.raises(ss.InputError, match="cannot write"):
        found.to_csv(tmp_path / "missing" / "map.csv")


def test_drawings_tell_regions_apart_without_colour(tmp_path, law):
    found = ss.motion_map(law, x=("V", V), y=("c", np.linspace(0.02, 6, 40)), **SCENE)
    found.plot(tmp_path / "map.svg")
    drawn = (tmp_path / "map.svg").read_text()
    for text in (
        "belt speed V (m/s)",
        "viscous damping coefficient c (kg/s)",
        "exact threshold",
        "stick-slip",
        "rest",
    ):
        assert f">{text}</text>" in drawn
    assert "<pattern" in drawn  # hatching
    for axes in (
        {"x": ("V", [0.5])},
        {"x": ("c", [1, 2]), "y": ("V", [0.1, 0.2])},
        {"y": ("m", [1, 2, 3]), "c": 2.6},
    ):
        request = {"x": ("V", V), "y": ("c", C)} | SCENE | axes
        request = {name: value for name, value in request.items() if name != request["y"][0]}
        ss.motion_map(law, **request).plot(tmp_path / "other.png")
    with pytest.raises(ss.InputError, match=r"cannot draw to 'map\.xyz'"):
        found.plot(tmp_path / "map.xyz")


def test_the_legend_names_the_curves_that_are_drawn():
    """Over a single row of N there is no line along which c is a threshold."""
    contour = pytest.importorskip("matplotlib.contour")
    law = ss.laws.exponential.typical()
    for rows in ([9.81], [5.0, 9.81]):
        found = ss.motion_map(law, x=("V", V), y=("N", rows), c=2.0, m=1.0, k=100.0)
        figure = found.plot()
        contours = [one for one in figure.axes[0].collections if isinstance(one, contour.ContourSet)]
        drawn = [one for one in contours if one.get_paths()]
        texts = [text.get_text() for text in figure.legends[0].get_texts()]
        named = [text for text in texts if re.search("threshold|criterion", text)]
        assert len(named) == len(drawn) == (3 if len(rows) > 1 else 0)


def test_maps_are_drawn_into_axes_of_ones_own(tmp_path):
    figure_module = pytest.importorskip("matplotlib.figure")
    law, osc = ss.laws.exponential.typical(), paper_oscillator(2.3)
    figure = figure_module.Figure()
    left, right = figure.subplots(1, 2)
    assert ss.motion_map(law, x=("V", V[:2]), y=("c", C[:2]), **SCENE).plot(ax=left) is figure
    ss.basin_map(law, osc, x0=[0.0, 0.1], v0=[0.0, 0.1]).plot(tmp_path / "both.svg", ax=right)
    text = (tmp_path / "both.svg").read_text()
    assert ">belt speed V (m/s)</text>" in text
    assert ">initial velocity v0 (m/s)</text>" in text


def test_hatching_fills_its_cells_and_no_others():
    """Seeded motions on coarse grids, even, by ratios or neither: what is hatched is what has that colour."""
    to_rgb = pytest.importorskip("matplotlib.colors").to_rgb
    rng, hatched = np.random.default_rng(6), 0
    basins = ss.basin_map(ss.laws.exponential.typical(), paper_oscillator(2.3), x0=[0.0], v0=[0.0])
    for _ in range(12):
        columns, rows = rng.integers(1, 9, 2).tolist()
        x0 = rng.choice([np.geomspace(0.01, 9, columns), np.linspace(-1, 2, columns)])
        v0 = np.cumsum(rng.uniform(0.1, 3, rows))
        motion = rng.choice(list(Motion), (rows, columns))
        over = Axis("x0", x0, "m", ""), Axis("v0", v0, "m/s", "")
        axes = dataclasses.replace(basins, axes=over, motion=motion).plot().axes[0]
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
