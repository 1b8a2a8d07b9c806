"""Maps of motions against simulation, and what may be asked of them."""

import csv
import dataclasses
import re
from collections import Counter

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym import Motion
from stickslip_sym.cli import map
from stickslip_sym.motion.maps import drawing
from stickslip_sym.motion.maps.columns import Reason
from tests.conftest import paper_oscillator
from tests.test_limit_cycles import TWO

SCENE = {"N": 9.81, "m": 1.0, "k": 100.0}
KNOWN = 1e-8  # of the largest threshold: so well maps know them, and so close to one a cell stays undecided
V, C = np.linspace(0.05, 0.95, 7), np.linspace(0.02, 6, 8)
KINKED = ss.FrictionLaw("Piecewise((0.5 - 0.3*v, v < 0.7), 0.29)", name="kinked")
JUMP = ss.FrictionLaw("0.2 + 0.2*exp(-3*v)", static="0.6", name="jump")


def attractors(found, row, column):
    return [bool(found.stick_slip[row, column]), bool(found.rest[row, column]), bool(found.pure_slip[row, column])]


def simulated(law, osc):
    """Return the attractors and the motion that following motions gives."""
    found = ss.regime(law, osc, rtol=1e-10)
    kinds = [found.stick_slip is not None, found.rest.stable, any(cycle.stable for cycle in found.cycles)]
    return kinds, ss.classify(law, osc)


def agree(law, found, cells):
    for row, column in cells:
        values = {found.x.name: found.x.values[column], found.y.name: found.y.values[row]} | found.fixed
        bound = law.bind(**{name: values.pop(name) for name in [*values] if name in law.parameters})
        assert (attractors(found, row, column), found.motion[row, column]) == simulated(
            bound, ss.Oscillator(**values)
        ), values


def some_cells(found, count, seed):
    rng = np.random.default_rng(seed)
    rows, columns = found.motion.shape
    return [divmod(int(cell), columns) for cell in rng.choice(rows * columns, count, replace=False)]


def test_decided_cells_are_what_simulation_gives(law):
    found = ss.motion_map(law, x=("V", V), y=("c", C), **SCENE)
    assert found.motion.shape == (C.size, V.size)
    assert not found.notes
    assert (found.reason != Reason.SIMULATED).mean() > 0.9
    agree(law, found, some_cells(found, 12, seed=1))


def test_beside_every_threshold_the_two_sides_differ(law):
    """The cells at most one part in 10^6 off a threshold, on either side of it."""
    osc = paper_oscillator()
    edges = [
        ss.pure_slip_damping(law, V=0.5, **SCENE, method=method, rtol=1e-10).value
        for method in ("equilibrium", "orbit")
    ]
    values = np.sort([edge * (1 + side) for edge in edges for side in (-1e-6, 0, 1e-6)])
    found = ss.motion_map(law, x=("V", [osc.V]), y=("c", values), **SCENE)
    column = found.motion[:, 0]
    assert [motion is Motion.UNDECIDED for motion in column] == [False, True, False] * 2
    assert [reason is Reason.TOLERANCE for reason in found.reason[:, 0]] == [False, True, False] * 2
    assert set(found.notes) == {(1, 0), (4, 0)}
    assert all(f"is within {KNOWN * max(edges):.1e} kg/s of a threshold" in note for note in found.notes.values())
    between = [False, False, True] if law.name == "polynomial" else [True, True, False]
    assert [attractors(found, row, 0) for row in (0, 2, 3, 5)] == [
        [True, False, False], between, between, [False, True, False],
    ]  # fmt: skip
    assert not any(attractors(found, 1, 0))


def test_folds_of_the_limit_cycles_bound_regions():
    found = ss.motion_map(TWO, x=("V", [0.5]), y=("c", [2.9, 3.3, 3.8, 4.1]), **SCENE)
    # As test_limit_cycles counts them: none, an unstable one, an unstable and a stable one, none.
    assert [attractors(found, row, 0) for row in range(4)] == [
        [True, False, False], [True, True, False], [False, True, True], [False, True, False],
    ]  # fmt: skip
    assert [motion.value for motion in found.motion[:, 0]] == [
        "stick-slip", "stick-slip", "pure slip", "damped slip",
    ]  # fmt: skip


@pytest.mark.parametrize("other", [KINKED, JUMP])
def test_laws_without_smooth_orbits(other):
    found = ss.motion_map(other, x=("V", [0.2, 0.4]), y=("c", np.linspace(0.5, 4, 6)), **SCENE)
    assert not found.notes
    assert (found.reason == Reason.SIMULATED).sum() <= 2
    agree(other, found, some_cells(found, 4, seed=2))


def test_a_law_without_stick_is_simulated():
    smoothed = ss.FrictionLaw("(0.2 + 0.3*exp(-3*v))*tanh(v/0.2)")
    found = ss.motion_map(smoothed, x=("V", [0.3]), y=("c", [5.0]), **SCENE)
    assert found.reason[0, 0] is Reason.SIMULATED
    assert found.motion[0, 0] is Motion.DAMPED_SLIP


def test_axes_may_be_any_two(law):
    upright = ss.motion_map(law, x=("V", V), y=("c", C), **SCENE)
    turned = ss.motion_map(law, x=("c", C), y=("V", V), **SCENE)
    for name in ("motion", "stick_slip", "rest", "pure_slip", "reason"):
        assert np.array_equal(getattr(upright, name), getattr(turned, name).T)
    assert upright.thresholds["exact"].shape == (1, V.size)
    assert turned.thresholds["exact"].shape == (V.size, 1)
    # One line of it, with c fixed.
    fixed = ss.motion_map(law, x=("V", V), y=("N", [9.81, 20.0]), c=C[3], m=1, k=100)
    assert np.array_equal(fixed.motion[0], upright.motion[3])
    assert fixed.thresholds["exact"].shape == (2, V.size)
    assert fixed.thresholds["exact"][0] == pytest.approx(upright.thresholds["exact"][0])


def test_a_parameter_of_the_law_is_an_axis():
    law = ss.laws.exponential.typical()
    found = ss.motion_map(law, x=("alpha", [1.0, 3.0, 5.0]), y=("c", C), V=0.5, **SCENE)
    assert (found.x.name, found.x.unit, found.y.unit) == ("alpha", "s/m", "kg/s")
    for alpha, exact in zip(found.x.values, found.thresholds["exact"][0], strict=True):
        expected = ss.pure_slip_damping(law.bind(alpha=alpha), V=0.5, **SCENE, method="orbit", rtol=1e-10)
        assert exact == pytest.approx(expected.value, rel=1e-9)
    agree(law, found, some_cells(found, 3, seed=3))
    unbound = ss.laws.exponential.bind(mu_s=0.5, mu_m=0.2)
    again = ss.motion_map(unbound, x=("alpha", [1.0, 3.0, 5.0]), y=("c", C), V=0.5, **SCENE)
    assert np.array_equal(found.motion, again.motion)


def test_thresholds_are_those_of_pure_slip_damping(law):
    found = ss.motion_map(law, x=("V", V), y=("c", [1.0]), **SCENE)
    for curve, method in (("equilibrium", "equilibrium"), ("least_squares", "least_squares"), ("exact", "orbit")):
        expected = ss.pure_slip_damping(law, V=V, **SCENE, method=method, rtol=1e-8).value
        assert found.thresholds[curve][0] == pytest.approx(expected, rel=1e-8)


def test_cells_that_fail_say_why_and_the_others_stay():
    # Measured up to 0.9 m/s only: at higher belt speeds no motion is known.
    law = ss.FrictionLaw.from_samples([0, 0.1, 0.3, 0.9], [0.5, 0.4, 0.3, 0.25])
    found = ss.motion_map(law, x=("V", [0.1, 2.0]), y=("c", [0.1, 9.0]), **SCENE)
    assert [motion.value for motion in found.motion[:, 0]] == ["stick-slip", "damped slip"]
    assert (found.reason[:, 1] == Reason.FAILED).all()
    assert "measured up to v = 0.9 m/s" in found.notes[0, 1]
    with pytest.raises(ss.NotConverged, match=r"every cell failed, .* measured up to v = 0\.9 m/s"):
        ss.motion_map(law, x=("V", [2.0]), y=("c", [0.1, 9.0]), **SCENE)


PLAIN = {"x": ("V", [0.1, 0.2]), "y": ("c", [1.0, 2.0])} | SCENE
WRONG = [
    ({"x": ("alhpa", [1, 2])}, "no axis can be 'alhpa' (did you mean 'alpha'?)"),
    ({"x": "V"}, 'x is a name and its values, such as x=("V", [0.1, 0.2])'),
    ({"x": ("V", [0.2, 0.1])}, "the values of V do not ascend"),
    ({"x": ("V", [0.1, float("nan")])}, "V holds a value that is not finite: nan"),
    ({"x": ("V", [])}, "one row of numbers, got an array of shape (0,)"),
    ({"x": ("V", ["a"])}, "V = ['a'] is not a number or an array of numbers"),
    ({"x": ("V", [-1, 1])}, "V = -1 must be positive"),
    ({"x": ("mu_s", [-1, 1]), "V": 0.5}, "mu_s = -1 is negative"),
    ({"x": ("c", [1, 2])}, "both axes are c"),
    ({"c": 1.0}, "c is an axis, and given as 1.0 too"),
    ({"N": None}, "N is missing: give the normal force"),
    ({"rtol": 1.0}, "rtol = 1 is outside"),
    ({"x": ("V", np.arange(1, 3000)), "y": ("c", np.arange(1000))}, "more than 1000000"),
]


@pytest.mark.parametrize(("change", "message"), WRONG)
def test_unusable_requests_are_refused(change, message):
    with pytest.raises(ss.InputError, match=re.escape(message)):
        ss.motion_map(ss.laws.exponential.typical(), **(PLAIN | change))


def test_an_unbound_law_is_refused():
    with pytest.raises(ss.InputError, match="no value for alpha; bind them first, or make one an axis"):
        ss.motion_map(ss.laws.exponential.bind(mu_s=0.5, mu_m=0.2), **PLAIN)


def test_files_hold_what_the_map_does(tmp_path, law):
    found = ss.motion_map(law, x=("V", V), y=("c", C), **SCENE)
    found.to_npz(tmp_path / "map.npz")
    with np.load(tmp_path / "map.npz", allow_pickle=False) as arrays:
        assert np.array_equal(arrays["x"], V)
        assert (arrays["x_name"], arrays["y_unit"], arrays["fixed_N"]) == ("V", "kg/s", 9.81)
        assert arrays["motion"].tolist() == [[motion.value for motion in row] for row in found.motion]
        assert np.array_equal(arrays["rest"], found.rest)
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
    law = ss.laws.exponential.typical()
    for rows in ([9.81], [5.0, 9.81]):
        found = ss.motion_map(law, x=("V", V), y=("N", rows), c=2.0, m=1.0, k=100.0)
        _, axes = drawing._figure()
        handles = drawing._draw_curves(axes, found)
        drawn = [collection for collection in axes.collections if collection.get_paths()]
        assert len(handles) == len(drawn) == (3 if len(rows) > 1 else 0)


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
        axes = dataclasses.replace(basins, x0=x0, v0=v0, motion=motion).plot().axes[0]
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


# -- basins ----------------------------------------------------------------------------------------


def test_basins_of_rest_and_stick_slip(tmp_path):
    law, osc = ss.laws.exponential.typical(), paper_oscillator(2.3)
    x0, v0 = np.linspace(-0.05, 0.08, 5), [-0.3, 0.0, 0.5, 0.8]
    found = ss.basin_map(law, osc, x0=x0, v0=v0)
    assert found.motion.shape == (4, 5)
    for row, v in enumerate(v0):
        assert found.motion[row].tolist() == [ss.classify(law, osc, x0=x, v0=v) for x in x0]
    assert set(found.count()) == {Motion.STICK_SLIP, Motion.DAMPED_SLIP}
    # The separatrix is the unstable cycle: starts well inside come to rest, those outside do not.
    (curve,) = found.regime.separatrices
    centre = found.regime.rest.x
    ends = np.array([curve.x.min(), curve.x.max()])
    for scale, expected in ((0.9, Motion.DAMPED_SLIP), (1.1, Motion.STICK_SLIP)):
        assert ss.basin_map(law, osc, x0=centre + scale * (ends - centre), v0=[0.0]).count() == {expected: 2}
    found.to_csv(tmp_path / "basins.csv")
    assert len((tmp_path / "basins.csv").read_text().splitlines()) == 1 + 20
    found.to_npz(tmp_path / "basins.npz")
    with np.load(tmp_path / "basins.npz", allow_pickle=False) as arrays:
        assert (arrays["c"], arrays["motion"].shape) == (2.3, (4, 5))
    found.plot(tmp_path / "basins.svg")
    assert ">separatrix</text>" in (tmp_path / "basins.svg").read_text()


def test_basins_keep_what_is_done(tmp_path):
    law, osc = ss.laws.polynomial.typical(), paper_oscillator(3.1)
    starts = {"x0": [-0.1, 0.0, 0.1], "v0": [0.0, 0.5]}
    first = ss.basin_map(law, osc, **starts, checkpoint=tmp_path / "kept")
    again = ss.basin_map(law, osc, **starts, checkpoint=tmp_path / "kept", workers=lambda f, tasks: [])
    assert np.array_equal(first.motion, again.motion)
    assert first.count() == {Motion.PURE_SLIP: 6}
    with pytest.raises(ss.InputError, match="x0 holds inf"):
        ss.basin_map(law, osc, x0=[float("inf")], v0=[0.0])


# -- command line ----------------------------------------------------------------------------------


def test_the_command_prints_a_picture_and_writes_files(run, tmp_path):
    code, out, err = run(
        "map", "exponential", "--x", "V=0.1:1:10", "--y", "c=0.1:6:12", "--plot", "m.png", "--csv", "m.csv",
        "--npz", "m.npz",
    )  # fmt: skip
    assert (code, err) == (0, "")
    picture = out.splitlines()[:12]
    assert all(re.fullmatch(r"[Sb.]{10}", line) for line in picture)
    assert (picture[0][0], picture[0][-1], picture[-1]) == ("S", ".", "S" * 10)
    count = Counter("".join(picture))
    assert re.search(rf"^S +stick-slip +{count['S']} ", out, re.M)
    assert re.search(rf"^b +stick-slip or rest, by the start +{count['b']} ", out, re.M)
    assert (tmp_path / "m.png").read_bytes().startswith(b"\x89PNG")
    assert len((tmp_path / "m.csv").read_text().splitlines()) == 121
    assert (tmp_path / "m.npz").exists()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("V=0.1:1", "--x 'V=0.1:1' is not NAME=START:STOP:COUNT"),
        ("V", "--x 'V' is not NAME=START:STOP:COUNT"),
        ("V=nan:1:5", "the start of V = 'nan' is not a number"),
        ("V=0.1:1:0", "the count '0' is no whole number"),
        ("V=0.1:1:1.5", "the count '1.5' is no whole number"),
        ("V=0.1:1:99999999", "no whole number from 1 to 1000000"),
        ("V=1:0.1:5", "the start must lie below the stop"),
        ("V=1:1:5", "the start must lie below the stop"),
    ],
)
def test_axes_that_cannot_be_read_are_refused(text, message):
    with pytest.raises(ss.InputError, match=re.escape(message)):
        map._axis("--x", text)
