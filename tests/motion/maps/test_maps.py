"""Maps of motions against simulation, and what may be asked of them."""

import re
import sys
from collections import Counter

import numpy as np
import pytest
from scenes import TWO, paper_oscillator

import stickslip_sym as ss
from stickslip_sym import Motion
from stickslip_sym.cli import map
from stickslip_sym.motion.maps.cells import Reason
from stickslip_sym.motion.maps.table import read_axes

SCENE = {"N": 9.81, "m": 1.0, "k": 100.0}
KNOWN = 1e-8  # of the largest threshold: so well maps know them, and so close to one a cell stays undecided
V, C = np.linspace(0.05, 0.95, 7), np.linspace(0.02, 6, 8)
KINKED = ss.FrictionLaw("Piecewise((0.5 - 0.3*v, v < 0.7), 0.29)", name="kinked")
JUMP = ss.FrictionLaw("0.2 + 0.2*exp(-3*v)", static="0.6", name="jump")


def attractors(found, row, column):
    return [bool(found.attractors[name][row, column]) for name in ("stick_slip", "rest", "pure_slip")]


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
    agree(law, found, some_cells(found, 5, seed=1))


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
        "stick-slip", "stick-slip", "pure slip", "rest",
    ]  # fmt: skip


@pytest.mark.parametrize("other", [KINKED, JUMP])
def test_laws_without_smooth_orbits(other):
    found = ss.motion_map(other, x=("V", [0.2, 0.4]), y=("c", np.linspace(0.5, 4, 6)), **SCENE)
    assert not found.notes
    assert (found.reason == Reason.SIMULATED).sum() <= 2
    agree(other, found, some_cells(found, 4, seed=2))


def test_a_law_without_stick_overtakes_the_belt():
    smoothed = ss.FrictionLaw("(0.2 + 0.3*exp(-3*v))*tanh(v/0.2)")
    found = ss.motion_map(smoothed, x=("V", [0.3, 0.6]), y=("c", [0.5, 1.5, 5.0]), **SCENE)
    assert not found.attractors["stick_slip"].any()
    assert len(found.count()) == 2
    agree(smoothed, found, [(row, column) for row in range(3) for column in range(2)])


def test_axes_may_be_any_two(law):
    upright = ss.motion_map(law, x=("V", V), y=("c", C), **SCENE)
    turned = ss.motion_map(law, x=("c", C), y=("V", V), **SCENE)
    for one, other in ((upright.motion, turned.motion), (upright.reason, turned.reason)):
        assert np.array_equal(one, other.T)
    for name, exists in upright.attractors.items():
        assert np.array_equal(exists, turned.attractors[name].T)
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
    assert [motion.value for motion in found.motion[:, 0]] == ["stick-slip", "rest"]
    assert (found.reason[:, 1] == Reason.FAILED).all()
    assert "measured up to v = 0.9 m/s" in found.notes[0, 1]
    with pytest.raises(ss.NotConverged, match=r"every cell failed, .* measured up to v = 0\.9 m/s"):
        ss.motion_map(law, x=("V", [2.0]), y=("c", [0.1, 9.0]), **SCENE)


def test_the_work_grows_as_the_columns_do():
    """Counted in calls, not seconds: twice the columns, twice the work."""

    def calls(columns):
        count = 0

        def profile(frame, event, argument):
            nonlocal count
            count += event == "call" and "stickslip_sym" in frame.f_code.co_filename

        sys.setprofile(profile)
        try:
            ss.motion_map(
                ss.laws.exponential.typical(),
                **(PLAIN | {"x": ("V", np.linspace(0.2, 0.8, columns)), "y": ("c", [1, 2, 3])}),
            )
        finally:
            sys.setprofile(None)
        return count

    calls(2)
    assert calls(40) < 2.2 * calls(20)


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


# -- command line ----------------------------------------------------------------------------------


def test_the_command_prints_a_picture_and_writes_files(run, tmp_path):
    code, out, err = run(
        "map", "exponential", "--x", "V=0.1:1:10", "--y", "c=0.1:6:12", "--plot", "m.png", "--csv", "m.csv",
        "--npz", "m.npz",
    )  # fmt: skip
    assert (code, err) == (0, "")
    picture = [line for line in out.splitlines() if re.fullmatch(r"[Sb.]{10}", line)]
    assert len(picture) == 12
    assert (picture[0][0], picture[0][-1], picture[-1]) == ("S", ".", "S" * 10)
    count = Counter("".join(picture))
    assert re.search(rf"^S +stick-slip +{count['S']} ", out, re.M)
    assert re.search(rf"^b +rest or stick-slip, by the initial condition +{count['b']} ", out, re.M)
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
        map.read_axis("--x", text)


@pytest.mark.parametrize("given", [(1, [0.1, 0.2]), (["V"], [0.1]), ("V", [0.1], [0.2]), ("V",), "Vc", 3, ()])
def test_what_is_no_name_with_values_is_no_axis(given):
    with pytest.raises(ss.InputError, match="x is a name and its values"):
        read_axes(JUMP, given, ("c", [1.0]))
