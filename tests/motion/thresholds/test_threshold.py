"""The ladder of thresholds: its estimates, its choices and its bounds; and the transition speed, its inverse."""

import math
from dataclasses import replace

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym.criteria import criterion
from stickslip_sym.motion.thresholds import rungs as ladder
from stickslip_sym.motion.thresholds.rungs import numerical_averages, rungs, second_order
from stickslip_sym.motion.thresholds.scenes import Scenes

SCENE = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}
SIX = ["exponential", "polynomial", "hyperbolic", "gaussian", "lorentzian", "tanh"]
REFERENCE = 2e-12  # relative error of the orbits that estimates are judged by
SIMULATED = 1e-9


@pytest.fixture(scope="module")
def exponential():
    return ss.laws.exponential.typical()


def random_scenes(count):
    """Yield seeded laws, scenes and tolerances; what friction does to the orbit runs over three decades."""
    rng = np.random.default_rng(20160428)
    for number in range(count):
        law = ss.laws.catalogue[SIX[number % len(SIX)]].typical()
        others = {name: float(value) for name, value in law.values.items() if name not in ("mu_s", "mu_m")}
        others = {name: value * 10 ** rng.uniform(-0.3, 0.3) for name, value in others.items()}
        law = law.bind(**others, mu_s=rng.uniform(0.35, 0.9), mu_m=rng.uniform(0.05, 0.3))
        ranges = {"V": (-1.5, 0), "N": (-1, 2), "m": (-2, 2), "k": (1, 5)}
        yield law, {name: 10 ** rng.uniform(*ends) for name, ends in ranges.items()}, 10 ** rng.uniform(-8, -0.3)


def test_estimates_bound_the_error_and_the_rung_is_the_cheapest():
    """60 scenes by default; wider runs change nothing but the number."""
    bounded, cheap, total = 0, 0, 0
    for law, scene, rtol in random_scenes(60):
        try:
            exact = ss.pure_slip_damping(law, **scene, method="orbit", rtol=1e-12)
        except ss.NotConverged:
            continue
        found = ss.pure_slip_damping(law, **scene, rtol=rtol)
        scenes = Scenes.of(law, **scene)
        values = numerical_averages(scenes) | {"second_order": second_order(scenes)[0], "orbit": [exact.value]}
        errors = [abs(float(value[0]) / exact.value - 1) for value in values.values()]
        cheapest = next(rung for rung, error in enumerate(errors) if error <= rtol)
        total += 1
        bounded += abs(found.value / exact.value - 1) <= found.error + REFERENCE
        cheap += list(rungs()).index(found.method) <= cheapest + 1
        assert found.error <= rtol
    assert total >= 55
    assert bounded >= 0.99 * total
    assert cheap == total


def test_the_name_of_a_rung_is_never_cut(exponential, monkeypatch):
    """Whatever it is called: the criterion of the lowest rung under seeded names of 1 to 60 letters."""
    rng = np.random.default_rng(13)
    for length in (1, 13, 14, *rng.integers(15, 61, 5).tolist()):
        name = "".join(rng.choice(list("abcdefghij_"), length))
        monkeypatch.setattr(criterion, "catalogue", {name: ss.Criterion(name, None)} | ss.criteria.catalogue)
        assert ss.pure_slip_damping(exponential, **SCENE, rtol=0.5).method == name
        several = ss.pure_slip_damping(exponential, **SCENE | {"V": [0.5, 0.5, 1.0]}, rtol=0.5)
        assert several.method.dtype.kind == "U"
        assert name in several.method
        assert set(several.method) <= {name, *rungs()}


@pytest.mark.parametrize(
    ("rtol", "method"),
    [(0.5, "equilibrium"), (0.05, "least_squares"), (5e-3, "harmonic"), (1e-4, "second_order"), (1e-9, "orbit")],
)
def test_auto_climbs_as_far_as_it_must(exponential, rtol, method):
    found = ss.pure_slip_damping(exponential, **SCENE, rtol=rtol)
    assert found.method == method
    exact = ss.pure_slip_damping(exponential, **SCENE, method="simulation", rtol=1e-12).value
    assert abs(found.value / exact - 1) <= found.error + 2e-11
    assert found.error <= rtol


def test_auto_climbs_no_further(exponential, monkeypatch):
    def no(*_):
        raise AssertionError("climbed too far")

    def forbid(name):
        above = ladder.rungs()[name]
        monkeypatch.setitem(ladder._table, name, replace(above, compute=no))

    forbid("simulation")
    assert ss.pure_slip_damping(exponential, **SCENE, rtol=1e-9).method == "orbit"
    forbid("orbit")
    assert ss.pure_slip_damping(exponential, **SCENE, rtol=0.05).method == "least_squares"
    with pytest.raises(AssertionError, match="too far"):
        ss.pure_slip_damping(exponential, **SCENE, rtol=1e-4)


def test_without_mass_and_stiffness_the_error_is_not_known(exponential):
    found = ss.pure_slip_damping(exponential, V=0.5, N=9.81)
    assert (found.method, found.error) == ("harmonic", None)
    assert "relative error unknown" in str(found)
    straight = ss.pure_slip_damping(ss.laws.catalogue["linear"].typical(), V=0.5, N=9.81)
    assert straight.value == pytest.approx(0.15 * 9.81, rel=1e-15)
    assert straight.error < 1e-13


def test_arrays_broadcast(exponential):
    V, k = np.array([[0.2], [0.5], [0.8]]), np.array([50.0, 100.0])
    for method in ("auto", "harmonic", "second_order", "orbit"):
        found = ss.pure_slip_damping(exponential, V=V, N=9.81, m=1.0, k=k, method=method)
        assert found.value.shape == found.error.shape == found.method.shape == (3, 2)
        single = ss.pure_slip_damping(exponential, V=0.8, N=9.81, m=1.0, k=50.0, method=method)
        assert found.value[2, 0] == pytest.approx(single.value, rel=1e-9)
        assert found.method[2, 0] == single.method
    assert ss.pure_slip_damping(exponential, V=V, N=9.81).value.shape == (3, 1)
    assert ss.pure_slip_damping(exponential, V=np.empty(0), N=9.81, m=1.0, k=1.0).value.shape == (0,)


@pytest.mark.parametrize("size", [1e-6, 1e6])
@pytest.mark.parametrize("name", ["m", "k", "N", "V"])
def test_twelve_decades_of_each_quantity(exponential, name, size):
    """An answer within the tolerance, or an outcome that says why not."""
    scene = SCENE | {name: size}
    if size == 1e6 and name == "V":  # a layer too thin to be followed
        with pytest.raises(ss.NotConverged, match=r"rtol = 0\.001 is not reached for .*; try another rtol"):
            ss.pure_slip_damping(exponential, **scene, rtol=1e-3)
        return
    # m and k matter by their product only, and N and k m by the ratio of their squares.
    both = scene | {"m": scene["m"] * np.array([1, 64]), "k": scene["k"] / np.array([1, 64])}
    found = ss.pure_slip_damping(exponential, **both, rtol=1e-3)
    assert np.isfinite(found.value).all()
    assert (found.error <= 1e-3).all()
    assert found.value[1] == pytest.approx(found.value[0], rel=1e-9)


KINKED = ss.FrictionLaw("Piecewise((0.5 - 0.2*v, v < 0.7), 0.36)")
JUMP = ss.FrictionLaw("0.4 - 0.1*v", static="0.45")


@pytest.mark.parametrize(
    ("law", "why"), [(KINKED, "kink at v = 0.7"), (JUMP, "static coefficient 0.45 lies above")]
)
@pytest.mark.parametrize("method", ["second_order", "orbit"])
def test_laws_that_are_not_smooth_belong_to_simulation(law, why, method):
    with pytest.raises(ss.InputError, match=f'{why}.*method="simulation"'):
        ss.pure_slip_damping(law, **SCENE, method=method)
    found = ss.pure_slip_damping(law, **SCENE, rtol=1e-6)
    assert found.method == "simulation"


def test_a_kink_beyond_reach_does_no_harm():
    far = ss.FrictionLaw("Piecewise((0.5 - 0.2*v + 0.05*v^2, v < 5), 0.36)")
    smooth = ss.FrictionLaw("0.5 - 0.2*v + 0.05*v^2")
    values = [ss.pure_slip_damping(law, **SCENE, method="orbit", rtol=1e-12).value for law in (far, smooth)]
    assert values[0] == pytest.approx(values[1], rel=1e-14)


def test_an_infinite_slope_at_rest_is_told():
    law = ss.FrictionLaw("0.5 - 0.1*sqrt(v)")
    with pytest.raises(ss.NotConverged, match='try method="simulation"'):
        ss.pure_slip_damping(law, **SCENE, method="orbit", rtol=1e-9)
    assert ss.pure_slip_damping(law, **SCENE, method="simulation", rtol=1e-10).value == pytest.approx(0.832662017)


def test_simulation_of_kinks_and_jumps_settles_to_1e_9():
    for law in (KINKED, JUMP, ss.FrictionLaw("Piecewise((0.4, v < 0.3), 0.43 - 0.1*v)", static="0.41")):
        loose, tight = (
            ss.pure_slip_damping(law, **SCENE, method="simulation", rtol=rtol) for rtol in (1e-10, 1e-12)
        )
        assert abs(loose.value / tight.value - 1) < SIMULATED
        assert tight.error < SIMULATED


def test_a_small_static_excess_follows_the_weak_friction_law():
    """zeta = (dF/(V sqrt(m k)))^2/(4 pi) for Coulomb friction; the deviation falls with the excess."""
    jump, off = 0.02 / 2.0 ** np.arange(4), []
    for excess in jump:
        law = ss.FrictionLaw("0.3", static=repr(0.3 + float(excess)))
        zeta = ss.pure_slip_damping(law, **SCENE, method="simulation", rtol=1e-11).value / (2 * 10.0)
        off.append(abs(zeta / ((excess * 9.81 / (0.5 * 10.0)) ** 2 / (4 * math.pi)) - 1))
    order, _ = np.polyfit(np.log(jump), np.log(off), 1)
    assert order == pytest.approx(2, abs=0.1)
    assert off[-1] < 1e-4


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"rtol": 2.0}, "rtol = 2 is outside 1e-13 to 1"),
        ({"m": None}, "give both the mass m and the stiffness k"),
        ({"m": None, "k": None, "method": "orbit"}, 'method="orbit" needs the mass m'),
        ({"V": [0.5, 0.0]}, "V = 0 must be positive"),
        ({"N": -1.0}, "N = -1 must not be negative"),
        ({"k": [1.0, 2.0], "V": [1.0, 2.0, 3.0]}, "the shapes do not broadcast"),
        ({"V": "fast"}, "V = 'fast' is not a number"),
        ({"m": float("inf")}, "m holds a value that is not finite"),
    ],
)
def test_wrong_input(exponential, changes, message):
    with pytest.raises(ss.InputError, match=message):
        ss.pure_slip_damping(exponential, **(SCENE | changes))


# -- transition speed --------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["exponential", "polynomial", "gaussian"])
@pytest.mark.parametrize("method", ["equilibrium", "least_squares", "harmonic", "second_order", "orbit"])
def test_the_transition_speed_inverts_the_threshold(name, method):
    law, scene = ss.laws.catalogue[name].typical(), {"N": 9.81, "m": 1.0, "k": 100.0}
    found = ss.transition_speed(law, c=2.0, **scene, method=method)
    assert len(found) == (2 if name == "gaussian" else 1)
    for speed in found:
        if method in ("second_order", "orbit"):
            value = ss.pure_slip_damping(law, V=speed.value, **scene, method=method, rtol=1e-12).value
        else:
            value = numerical_averages(Scenes.of(law, V=speed.value, N=9.81))[method][0]
        assert value == pytest.approx(2.0, rel=1e-11)


def test_the_polynomial_law_by_its_closed_forms():
    law = ss.laws.polynomial.bind(mu_s=0.5, mu_m=0.2, v_m=2.0)
    for method, square in (("equilibrium", 1), ("least_squares", 21 / 26), ("harmonic", 12 / 15)):
        (speed,) = ss.transition_speed(law, c=0.0, N=9.81, method=method)
        assert speed.value == pytest.approx(2 * math.sqrt(square), rel=1e-15)
    # (18) solved for V, and a damping that suffices at every speed.
    (speed,) = ss.transition_speed(law, c=1.0, N=9.81, method="least_squares")
    assert speed.value == pytest.approx(math.sqrt((21 * 4 - 14 * 8 / (0.3 * 9.81)) / 26), rel=1e-14)
    assert ss.transition_speed(law, c=3.0, N=9.81, method="least_squares") == ()


def test_a_slope_that_is_exactly_zero_needs_no_damping():
    law = ss.laws.polynomial.bind(mu_s="0.5", mu_m="0.2", v_m="1")
    assert ss.pure_slip_damping(law, V=1.0, N=9.81, method="equilibrium").value == 0


def test_the_asymptotes_as_the_damping_vanishes(exponential):
    """least_squares: c = (5/2) N D/(alpha V^2); harmonic: c = N D sqrt(2/(pi alpha)) V^-3/2."""
    ND, alpha = 9.81 * 0.3, 3.0
    for c in (1e-6, 1e-9):
        (square,) = ss.transition_speed(exponential, c=c, N=9.81, method="least_squares")
        (power,) = ss.transition_speed(exponential, c=c, N=9.81, method="harmonic")
        assert square.value == pytest.approx(math.sqrt(2.5 * ND / (alpha * c)), rel=10 / (alpha * square.value))
        assert power.value == pytest.approx(
            (ND / c * math.sqrt(2 / (math.pi * alpha))) ** (2 / 3), rel=1 / power.value
        )
    assert ss.transition_speed(exponential, c=0.0, N=9.81) == ()


def test_auto_gives_the_cheapest_transition_speed_with_its_error(exponential):
    exact = ss.transition_speed(exponential, c=2.5, N=9.81, m=1.0, k=100.0, method="simulation")[0]
    for rtol, method in ((0.3, "equilibrium"), (0.03, "least_squares"), (1e-4, "second_order"), (1e-8, "orbit")):
        (found,) = ss.transition_speed(exponential, c=2.5, N=9.81, m=1.0, k=100.0, rtol=rtol)
        assert found.method == method
        assert abs(found.value / exact.value - 1) < 1.2 * found.error + 1e-8
    assert "m/s (orbit, relative error" in str(found)


def test_the_transition_speed_of_a_static_jump():
    (found,) = ss.transition_speed(
        ss.FrictionLaw("0.3", static="0.35"), c=0.1, N=9.81, m=1.0, k=100.0, method="simulation"
    )
    law = ss.FrictionLaw("0.3", static="0.35")
    back = ss.pure_slip_damping(law, V=found.value, N=9.81, m=1.0, k=100.0, method="simulation", rtol=1e-10)
    assert back.value == pytest.approx(0.1, rel=1e-7)


def test_the_command_line_prints_the_ladder(run):
    scene = ["-p", "mu_s=0.5", "-V", "0.5", "-N", "9.81", "-m", "1", "-k", "100"]
    best = "3.036483165 kg/s (second_order, relative error 2e-06, ESTIMATED)\n"
    assert run("damping", "polynomial", *scene, "--rtol", "1e-4") == (0, best, "")
    _, ladder, _ = run("damping", "linear", "-m", "1", "-k", "100", "--all")
    assert [line.split()[0] for line in ladder.splitlines()[1:]] == list(rungs())
    assert run("damping", "linear", "-m", "1")[0] == 2


def test_the_transition_speed_of_a_kink_is_found_by_simulation():
    law = ss.FrictionLaw("0.2 + 0.3*Max(0, 1 - v/0.3)")
    scene = {"c": 2.0, "N": 9.81, "m": 1.0, "k": 1e4}
    (found,) = ss.transition_speed(law, **scene)
    assert found.method == "simulation"
    threshold = ss.pure_slip_damping(law, V=found.value, N=9.81, m=1.0, k=1e4, method="simulation", rtol=1e-9)
    assert threshold.value == pytest.approx(2.0, rel=1e-6)
    with pytest.raises(ss.InputError, match="needs a law that is smooth"):
        ss.transition_speed(law, **scene, method="orbit")


def test_the_transition_speed_of_measured_points():
    law = ss.FrictionLaw.from_samples([0, 0.1, 0.2, 0.4, 0.8, 1.6, 3.0], [0.5, 0.42, 0.37, 0.3, 0.25, 0.22, 0.21])
    (found,) = ss.transition_speed(law, c=1.0, N=9.81)
    assert ss.derive(law, "harmonic")(V=found.value, N=9.81) == pytest.approx(1.0, rel=1e-9)


def test_masked_scenes_are_refused():
    with pytest.raises(ss.InputError, match="V has masked entries"):
        ss.pure_slip_damping(ss.laws.exponential.typical(), V=np.ma.array([0.5, 0.6], mask=[0, 1]), N=9.81)


@pytest.mark.parametrize("formula", ["mu_k", "mu_k + a*v", "mu_k - a*v", "mu_k + a*(cos(v) + v)", "mu_k*cos(a*v)"])
def test_no_threshold_is_minus_zero(formula):
    rng = np.random.default_rng(5)
    law = ss.FrictionLaw(formula)
    law = law.bind(**{name: {"a": 0.0, "mu_k": rng.uniform(0.1, 1)}[name] for name in law.parameters})
    scene = {"V": rng.uniform(0.1, 1, 3), "N": rng.uniform(1, 10)}
    for method in ("auto", "equilibrium", "least_squares", "harmonic", "second_order", "orbit"):
        oscillator = {"m": 1.0, "k": rng.uniform(50, 200)} if method in ("second_order", "orbit") else {}
        assert not np.signbit(ss.pure_slip_damping(law, **scene, **oscillator, method=method).value).any()
        found = ss.pure_slip_damping(law, **scene | {"V": 0.5}, **oscillator, method=method)
        assert str(found).startswith("0 kg/s")
