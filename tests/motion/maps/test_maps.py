"""Maps of motions against motions that are followed, and what may be asked of them."""

import re

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym import Motion
from stickslip_sym.motion.maps.cells import Reason
from stickslip_sym.motion.orbits.damping import NeededDamping
from support.operating_points import TWO, laws_in_pieces
from support.sweeps import sample

POINT = {"N": 9.81, "m": 1.0, "k": 100.0}
LAW = ss.laws.exponential.typical()
V, C = ("V", np.linspace(0.05, 0.95, 7)), ("c", np.linspace(0.02, 6, 8))
FORCES, SPEEDS = ("N", np.linspace(2, 20, 5)), ("V", np.linspace(0.15, 0.8, 6))
KNOWN = 1e-8  # of the largest threshold: so well maps know them, and so close to one a cell stays undecided
HELD = LAW.with_static("mu_p", parameters=[ss.Parameter("mu_p", "breakaway", "1")])
KINKED = ss.FrictionLaw("Piecewise((0.5 - 0.3*v, v < 0.7), (0.29, True))")
JUMP = ss.FrictionLaw("0.2 + 0.2*exp(-3*v)", static="0.6")
SMOOTHED = ss.FrictionLaw("(0.2 + 0.3*exp(-3*v))*tanh(v/0.2)")  # it never sticks, and overtakes the belt
RISING = ss.FrictionLaw("0.4 - 0.02*v + 0.3*v^2 + 0.05*v^3")  # it needs a negative damping to stick and slip
(MEASURED,) = laws_in_pieces(np.random.default_rng(52), 1)
SPEED = {"V": 0.5, "m": 1, "k": 100}
PLANES = {
    "exponential": (LAW, {"x": V, "y": C} | POINT),
    "kinked": (KINKED, {"x": ("V", [0.2, 0.4]), "y": ("c", np.linspace(0.5, 4, 6))} | POINT),
    "jump": (JUMP, {"x": ("V", [0.2, 0.4]), "y": ("c", np.linspace(0.5, 4, 6))} | POINT),
    "smoothed": (SMOOTHED, {"x": ("V", [0.3, 0.6]), "y": ("c", [0.5, 1.5, 5.0])} | POINT),
    "alpha and c": (LAW, {"x": ("alpha", [1.0, 3.0, 5.0]), "y": C, "V": 0.5} | POINT),
    "static": (HELD, {"x": ("mu_p", [0.5, 0.7]), "y": ("N", [5, 9.81]), "c": 2} | SPEED),
    "V and N": (LAW, {"x": SPEEDS, "y": FORCES, "c": 2, "m": 1, "k": 100}),
    "V and k": (ss.laws.logarithmic.typical(), {"x": SPEEDS, "y": ("k", [20, 600]), "c": 0.8, "m": 1, "N": 9.81}),
    "brown_mcphee": (
        ss.laws.brown_mcphee.typical(), {"x": ("V", [0.3, 0.6]), "y": ("N", [4, 9]), "c": 2, "m": 1, "k": 100},
    ),
    "rising": (RISING, {"x": ("V", [0.2, 0.6]), "y": ("c", np.linspace(-7, 1, 6))} | POINT),
    "in pieces": (MEASURED, {"x": V, "y": FORCES, "c": 1.5, "m": 1, "k": 100}),
}  # fmt: skip


def attractors(found, row, column):
    return [bool(found.attractors[name][row, column]) for name in ("stick_slip", "rest", "pure_slip")]


def cell(found, row, column):
    """Return the law and the oscillator of a cell."""
    values = {found.x.name: found.x.values[column], found.y.name: found.y.values[row]} | found.fixed
    law = found.law.bind(**{name: values.pop(name) for name in [*values] if name in found.law.parameters})
    return law, ss.Oscillator(**values)


@sample(5)
@pytest.mark.parametrize("name", PLANES)
def test_cells_are_what_following_motions_gives(name):
    law, request = PLANES[name]
    found = ss.motion_map(law, **request)
    assert found.motion.shape == (len(request["y"][1]), len(request["x"][1]))
    assert not found.notes
    assert np.isin(found.reason, (Reason.SIMULATED, Reason.FAILED)).mean() <= 0.2
    assert len(found.count()) > 1
    rng = np.random.default_rng(51)
    for place in rng.choice(found.motion.size, 3, replace=False):
        row, column = np.unravel_index(place, found.motion.shape)
        law, osc = cell(found, row, column)
        motions = ss.regime(law, osc, rtol=1e-10)
        stable = any(cycle.stable for cycle in motions.cycles)
        assert attractors(found, row, column) == [motions.stick_slip is not None, motions.rest.stable, stable]
        assert found.motion[row, column] is ss.classify(law, osc)
        point = {name: getattr(osc, name) for name in "VNmk"}
        for curve, method in (("least_squares", "least_squares"), ("exact", "simulation")):
            expected = ss.pure_slip_damping(law, **point, method=method, rtol=1e-8).value
            curve = np.broadcast_to(found.thresholds[curve], found.motion.shape)
            assert curve[row, column] == pytest.approx(expected, rel=1e-7)


def test_beside_every_threshold_the_two_sides_differ(law):
    """The cells at most one part in 10^6 off a threshold, on either side of it, along c and each by itself."""
    edges = [
        ss.pure_slip_damping(law, V=0.5, **POINT, method=method, rtol=1e-10).value
        for method in ("equilibrium", "orbit")
    ]
    values = np.sort([edge * (1 + side) for edge in edges for side in (-1e-6, 0, 1e-6)])
    found = ss.motion_map(law, x=("V", [0.5]), y=("c", values), **POINT)
    column = found.motion[:, 0].tolist()
    assert [motion is Motion.UNDECIDED for motion in column] == [False, True, False] * 2
    assert [reason is Reason.TOLERANCE for reason in found.reason[:, 0]] == [False, True, False] * 2
    assert set(found.notes) == {(1, 0), (4, 0)}
    for note in found.notes.values():
        margin = float(re.search(r"is within (\S+) kg/s of a threshold", note)[1])
        assert 0.95 <= margin / (KNOWN * max(edges)) <= 1.15  # the error of the threshold is at most a tenth of it
    between = [False, False, True] if law.name == "polynomial" else [True, True, False]
    assert [attractors(found, row, 0) for row in (0, 2, 3, 5)] == [
        [True, False, False], between, between, [False, True, False],
    ]  # fmt: skip
    assert not any(attractors(found, 1, 0))
    lone = [ss.motion_map(law, x=("V", [0.5]), y=("N", [9.81]), c=c, m=1, k=100).motion[0, 0] for c in values]
    assert lone == column


def test_folds_of_the_limit_cycles_bound_regions():
    found = ss.motion_map(TWO, x=("V", [0.5]), y=("c", [2.9, 3.3, 3.8, 4.1]), **POINT)
    # As test_limit_cycles counts them: none, an unstable one, an unstable and a stable one, none.
    assert [attractors(found, row, 0) for row in range(4)] == [
        [True, False, False], [True, True, False], [False, True, True], [False, True, False],
    ]  # fmt: skip
    assert [motion.value for motion in found.motion[:, 0]] == ["stick-slip", "stick-slip", "pure slip", "rest"]


NARROW = {
    "a cycle at the bump": (
        "0.2 + 0.3*exp(-3*v) - 0.1*exp(-((v - 0.2)/0.001)^2)",
        {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0, "c": 1.95},
        [True, False, True],
    ),
    "a cycle below the bump": (
        "0.3 + 0.2*exp(-v/0.7) + 0.02*exp(-((v - 0.28)/0.0001)^2)",
        {"V": 0.336, "N": 3.75, "m": 1.0, "k": 100.0, "c": 0.704},
        [False, True, True],
    ),
}


@pytest.mark.parametrize("name", NARROW)
@pytest.mark.parametrize("count", [1, 21])
def test_cycles_beside_a_narrow_bump(name, count):
    """The damping that orbits need has a wave there, which nine amplitudes missed: alone and in a row alike."""
    formula, point, expected = NARROW[name]
    law, c = ss.FrictionLaw(formula), point["c"]
    values = [c] if count == 1 else np.linspace(0.9 * c, 1.1 * c, count)
    found = ss.motion_map(law, x=("V", [point["V"]]), y=("c", values), **{n: point[n] for n in "Nmk"})
    assert attractors(found, count // 2, 0) == expected
    motions = ss.regime(law, ss.Oscillator(**point))
    stable = any(cycle.stable for cycle in motions.cycles)
    assert [motions.stick_slip is not None, motions.rest.stable, stable] == expected


def test_a_cell_that_its_regime_contradicts_has_its_line_followed(monkeypatch):
    """Comparisons that go wrong, here by leaving out all limit cycles, are noticed."""
    monkeypatch.setattr(
        NeededDamping, "signs", lambda self, c, grows: (grows & False, grows & False, grows & False)
    )
    found = ss.motion_map(TWO, x=("V", [0.5]), y=("c", [3.3, 3.8]), **POINT)
    assert [attractors(found, row, 0) for row in range(2)] == [[True, True, False], [False, True, True]]
    assert (found.reason == Reason.SIMULATED).all()


def test_axes_may_be_any_two(law):
    upright, turned = (ss.motion_map(law, x=x, y=y, **POINT) for x, y in ((V, C), (C, V)))
    assert np.array_equal(upright.motion, turned.motion.T)
    assert np.array_equal(upright.reason, turned.reason.T)
    for name, exists in upright.attractors.items():
        assert np.array_equal(exists, turned.attractors[name].T)
    assert upright.thresholds["exact"].shape == turned.thresholds["exact"].T.shape == (1, V[1].size)
    # One line of it, with c fixed.
    fixed = ss.motion_map(law, x=V, y=("N", [9.81, 20.0]), c=C[1][3], m=1, k=100)
    assert np.array_equal(fixed.motion[0], upright.motion[3])
    assert fixed.thresholds["exact"][0] == pytest.approx(upright.thresholds["exact"][0])
    unbound = ss.laws.exponential.bind(mu_s=0.5, mu_m=0.2)
    planes = [ss.motion_map(one, x=("alpha", [1.0, 3.0]), y=C, V=0.5, **POINT) for one in (LAW, unbound)]
    assert np.array_equal(planes[0].motion, planes[1].motion)
    assert (planes[0].x.unit, planes[0].y.unit) == ("s/m", "kg/s")


def test_cells_that_fail_say_why():
    # Measured up to 0.9 m/s only: at higher belt speeds no motion is known.
    law = ss.FrictionLaw.from_samples([0, 0.1, 0.3, 0.9], [0.5, 0.4, 0.3, 0.25])
    found = ss.motion_map(law, x=("V", [0.1, 2.0]), y=("c", [0.1, 9.0]), **POINT)
    assert [motion.value for motion in found.motion[:, 0]] == ["stick-slip", "rest"]
    assert (found.reason[:, 1] == Reason.FAILED).all()
    assert "measured up to v = 0.9 m/s" in found.notes[0, 1]
    with pytest.raises(ss.NotConverged, match=r"every cell failed, .* measured up to v = 0\.9 m/s"):
        ss.motion_map(law, x=("V", [2.0]), y=("c", [0.1, 9.0]), **POINT)


PLAIN = {"x": ("V", [0.1, 0.2]), "y": ("c", [1.0, 2.0])} | POINT
WRONG = [
    *(({"x": given}, "x is a name and its values")
      for given in ((1, [0.1, 0.2]), (["V"], [0.1]), ("V", [0.1], [0.2]), ("V",), "Vc", 3, ())),
    ({"x": ("alhpa", [1, 2])}, "no axis can be 'alhpa' (did you mean 'alpha'?)"),
    ({"x": ("V", [0.2, 0.1])}, "the values of V do not ascend"),
    ({"x": ("V", [0.1, float("nan")])}, "V holds a value that is not finite: nan"),
    ({"x": ("V", [])}, "one row of numbers, got an array of shape (0,)"),
    ({"x": ("V", ["a"])}, "V = 'a' is not a number"),
    ({"x": ("V", [-1, 1])}, "V = -1 must be positive"),
    ({"x": ("mu_s", [-1, 1]), "V": 0.5}, "mu_s = -1 is negative"),
    ({"x": ("c", [1, 2])}, "both axes are c"),
    ({"c": 1.0}, "c is an axis, and given as 1.0 too"),
    ({"N": None}, "N is missing: give the normal force"),
    ({"rtol": 1.0}, "rtol = 1 is outside"),
    ({"x": ("V", np.arange(1, 3000)), "y": ("c", np.arange(1000))}, "more than 1000000"),
    ({"law": ss.laws.exponential.bind(mu_s=0.5, mu_m=0.2)}, "no value for alpha; make one an axis, or give"),
]  # fmt: skip


@pytest.mark.parametrize(("change", "message"), WRONG)
def test_unusable_requests_are_refused(change, message):
    with pytest.raises(ss.InputError, match=re.escape(message)):
        ss.motion_map(**({"law": LAW} | PLAIN | change))


def test_the_command_prints_a_picture_and_writes_files(run, tmp_path):
    files = ["m.png", "m.csv", "m.npz"]
    options = [word for name in files for word in (f"--{name[2:].replace('png', 'plot')}", name)]
    code, out, err = run("map", "exponential", "--x", "V=0.1:1:10", "--y", "c=0.1:6:12", *options)
    assert (code, err) == (0, "")
    picture = [line for line in out.splitlines() if re.fullmatch(r"[Sb.]{10}", line)]
    assert len(picture) == 12
    assert (picture[0][0], picture[0][-1], picture[-1]) == ("S", ".", "S" * 10)
    for letter, name in (("S", "stick-slip"), ("b", "rest or stick-slip, by the initial condition")):
        assert re.search(rf"^{letter} +{name} +{''.join(picture).count(letter)} ", out, re.M)
    assert (tmp_path / "m.png").read_bytes().startswith(b"\x89PNG")
    assert len((tmp_path / "m.csv").read_text().splitlines()) == 121
    assert (tmp_path / "m.npz").exists()


def test_a_map_is_computed_in_parts_of_a_hundred_cells():
    """Of which progress is said, and one cell each is confirmed."""
    said = []
    plane = {"x": ("c", np.linspace(1, 3, 100)), "y": ("V", [0.5, 0.6])}
    ss.motion_map(ss.laws.linear.typical(), **plane, N=9.81, m=1, k=100, progress=lambda *done: said.append(done))
    assert said[-1] == (2, 2)
