"""Thresholds: what they separate, steep laws, twelve decades of each quantity, and what is refused."""

import math
from dataclasses import replace

import numpy as np
import pytest

import stickslip_sym as ss
from support.operating_points import laws_in_pieces, paper_oscillator
from support.sweeps import sample, sweep

POINT = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}
EXPONENTIAL, POLYNOMIAL = ss.laws.exponential.typical(), ss.laws.polynomial.typical()
ROOT = ss.FrictionLaw("0.5-0.1*sqrt(v)")
# The paper's two, "alpha 8", "N 50", "layer" and "root" are middles of enclosures by method="proof" at rtol=1e-11.
# Where friction is stronger a proof takes minutes: those are values of the simulation itself, against its changes,
# and the dampings on both sides of each are tried below.
STEEP = {
    "paper, exponential": (EXPONENTIAL, {}, 2.57307887898),
    "paper, polynomial": (POLYNOMIAL, {}, 3.03647724356),
    "alpha 8": (ss.laws.exponential.typical(alpha=8), {}, 2.067284261),
    "N 50": (EXPONENTIAL, {"N": 50.0}, 12.47356032),
    "canard": (EXPONENTIAL, {"V": 0.3, "N": 1e3}, 366.0493724),
    "light": (EXPONENTIAL, {"m": 1e-6}, 1.970041565),
    "soft": (EXPONENTIAL, {"k": 1e-4}, 1.970041565),
    "layer": (ss.FrictionLaw("0.2+0.1*exp(-v/0.01)", static="0.4"), {"V": 0.1}, 3.692056429),
    "polynomial": (POLYNOMIAL, {"N": 1e4}, 3374.977777),
    "root": (ROOT, {}, 0.832662017),
    "root, loaded": (ROOT, {"N": 500.0}, 38.8216104753),
    "root, heavily loaded": (ROOT, {"N": 1e3}, 72.8108848633),
}


def simulated(law, rtol=1e-10, **changes):
    return ss.pure_slip_damping(law, **POINT | {"method": "simulation", "rtol": rtol} | changes)


def separates(law, damping, off, **changes):
    """Whether the mass sticks and slips just below a damping, and not just above."""
    below, above = (paper_oscillator(damping * factor, **changes) for factor in (1 - off, 1 + off))
    return ss.stick_slip_cycle(law, below) is not None and ss.stick_slip_cycle(law, above) is None


@pytest.mark.parametrize("name", STEEP)
def test_thresholds_of_steep_laws(name):
    law, changes, expected = STEEP[name]
    threshold = simulated(law, rtol=1e-8, **changes)
    assert {type(threshold.value), type(threshold.relative_error)} == {float}
    assert threshold.value == pytest.approx(expected, rel=1e-8)
    assert separates(law, threshold.value, 1e-6, **changes)


@pytest.mark.parametrize("V", [0.95, 1.5])
def test_every_method_says_no_damping_is_needed(V):
    """By a negative value, and in words."""
    point = {"V": V, "N": 9.81, "m": 1, "k": 100}
    methods = ("harmonic", "orbit", "simulation", "auto")
    found = [ss.pure_slip_damping(POLYNOMIAL, **point, method=method) for method in methods]
    assert all(one.value < 0 and "no damping is needed" in str(one) for one in found)
    assert found[1].value == pytest.approx(found[2].value, rel=1e-5)
    several = ss.pure_slip_damping(POLYNOMIAL, **point | {"V": [0.5, V]}, method="harmonic")
    assert "no damping is needed" in str(several)
    rising = ss.FrictionLaw("mu_0 + b*v").bind(mu_0=0.3, b=0.1)
    assert ss.pure_slip_damping(rising, **point, method="simulation").value == pytest.approx(-0.981, rel=1e-9)


@pytest.mark.parametrize("method", ["orbit", "simulation", "auto"])
def test_without_friction_no_damping_is_needed(method):
    found = simulated(EXPONENTIAL, N=0.0, method=method)
    assert found.value == 0
    assert found.relative_error <= 1e-13


@pytest.mark.parametrize("formula", ["0.3", "0.3 + 0.005*v + 0.01*Max(v - 0.7, 0)"])
def test_a_static_coefficient_moves_the_threshold(formula):
    """But no average, also where the slope of mu is positive and it alone makes the mass stick."""
    plain, jump = ss.FrictionLaw(formula), ss.FrictionLaw(formula, static="0.5")
    assert ss.derive(jump)(V=0.5, N=9.81) == ss.derive(plain)(V=0.5, N=9.81) <= 0
    threshold = simulated(jump, rtol=1e-8).value
    assert 0 < threshold < 5
    assert separates(jump, threshold, 1e-7)
    assert simulated(plain, rtol=1e-8).value <= 0


def test_a_refusal_holds_the_best_value(law):
    assert simulated(law, rtol=1e-11).relative_error <= 1e-11
    with pytest.raises(ss.NotConverged, match=r'the best value found .* kg/s, relative error.* or method="proof"'):
        simulated(law, rtol=1e-13)


@sweep("count", [8, 60], 8)
def test_a_threshold_of_pieces_separates_return_from_none(count):
    """Within its error, wherever it is positive."""
    rng = np.random.default_rng(17)
    positive = 0
    for law in laws_in_pieces(rng, count):
        V, N, k = rng.uniform(0.05, 0.9), 10 ** rng.uniform(-0.5, 1.5), 10 ** rng.uniform(1, 3.5)
        found = ss.pure_slip_damping(law, V=V, N=N, m=1, k=k, method="simulation", rtol=rng.choice([1e-6, 1e-8]))
        off = max(2 * found.relative_error, 1e-9)
        positive += found.value > 0
        below, above = (ss.Oscillator(m=1, k=k, V=V, N=N, c=found.value * (1 + sign * off)) for sign in (-1, 1))
        if found.value > 0:
            assert ss.peak_velocity(law, below) > V > ss.peak_velocity(law, above), (law, below)
    assert count / 2 <= positive < count


@pytest.mark.parametrize("seed", range(3))
def test_the_last_measured_speed_is_no_threshold(seed):
    """Where motions leave the measured speeds at the threshold it is refused, else they do not matter."""
    rng = np.random.default_rng([7, seed])
    v = np.r_[0, np.sort(rng.uniform(0.02, 2, int(rng.integers(4, 20)) - 1))]
    mu = 0.2 + 0.3 * np.exp(-rng.uniform(1, 5) * v) + rng.uniform(0, 0.03) * rng.standard_normal(v.size)
    held, measured = (ss.FrictionLaw.from_samples(v, mu, extrapolate=held) for held in (True, False))
    refused = 0
    for V in v[-1] * np.array([0.42, 0.4999, 0.5001, 0.51, 0.6]):  # motions slip at a little over 2 V
        point = {"V": V, "N": 10 ** rng.uniform(-1, 1.5), "m": 1, "k": 100, "method": "simulation"}
        try:
            threshold = ss.pure_slip_damping(measured, **point).value
        except ss.InputError as error:
            refused += "measure further" in str(error)
            continue
        assert threshold == pytest.approx(ss.pure_slip_damping(held, **point).value, rel=1e-7)
    assert 0 < refused < 5


def test_without_an_oscillator_the_error_is_unknown():
    found = ss.pure_slip_damping(EXPONENTIAL, V=0.5, N=9.81)
    assert (found.method, found.relative_error) == ("harmonic", None)
    assert "relative error unknown" in str(found)
    straight = ss.pure_slip_damping(ss.laws.catalogue["linear"].typical(), V=0.5, N=9.81)
    assert straight.value == pytest.approx(0.15 * 9.81, rel=1e-15)
    assert straight.relative_error < 1e-13


def test_arrays_broadcast():
    V, k = np.array([[0.2], [0.5], [0.8]]), np.array([50.0, 100.0])
    for method in ("auto", "harmonic", "second_order", "orbit"):
        found = ss.pure_slip_damping(EXPONENTIAL, V=V, N=9.81, m=1.0, k=k, method=method)
        assert found.value.shape == found.relative_error.shape == found.method.shape == (3, 2)
        single = ss.pure_slip_damping(EXPONENTIAL, V=0.8, N=9.81, m=1.0, k=50.0, method=method)
        assert found.value[2, 0] == pytest.approx(single.value, rel=1e-9)
        assert found.method[2, 0] == single.method
    assert ss.pure_slip_damping(EXPONENTIAL, V=V, N=9.81).value.shape == (3, 1)
    assert ss.pure_slip_damping(EXPONENTIAL, V=np.empty(0), N=9.81, m=1.0, k=1.0).value.shape == (0,)


@pytest.mark.parametrize("size", [1e-6, 1e6])
@pytest.mark.parametrize("name", ["m", "k", "N", "V"])
def test_twelve_decades_of_each_quantity(name, size):
    """An answer within the tolerance, or an outcome that says why not."""
    point = POINT | {name: size}
    # m and k matter by their product only, and N and k m by the ratio of their squares.
    both = point | {"m": point["m"] * np.array([1, 64]), "k": point["k"] / np.array([1, 64])}
    found = ss.pure_slip_damping(EXPONENTIAL, **both, rtol=1e-3)
    assert np.isfinite(found.value).all()
    assert (found.relative_error <= 1e-3).all()
    assert found.value[1] == pytest.approx(found.value[0], rel=1e-9)


KINKED = ss.FrictionLaw("Piecewise((0.5 - 0.2*v, v < 0.7), 0.36)")
JUMP = ss.FrictionLaw("0.4 - 0.1*v", static="0.45")


@pytest.mark.parametrize(
    ("law", "why"), [(KINKED, "kink at v = 0.7"), (JUMP, "static coefficient 0.45 lies above")]
)
@pytest.mark.parametrize("method", ["second_order", "orbit"])
def test_rough_laws_belong_to_simulation(law, why, method):
    with pytest.raises(ss.InputError, match=f'{why}.*method="simulation"'):
        ss.pure_slip_damping(law, **POINT, method=method)
    found = ss.pure_slip_damping(law, **POINT, rtol=1e-6)
    assert found.method == "simulation"


def test_a_small_static_excess():
    """zeta = (dF/(V sqrt(m k)))^2/(4 pi) for Coulomb friction; the deviation falls with the excess."""
    jump, off = 0.02 / 2.0 ** np.arange(4), []
    for excess in jump:
        law = ss.FrictionLaw("0.3", static=repr(0.3 + float(excess)))
        zeta = ss.pure_slip_damping(law, **POINT, method="simulation", rtol=1e-7).value / (2 * 10.0)
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
        ({"V": np.ma.array([0.5, 0.6], mask=[0, 1])}, "V has masked entries"),
    ],
)
def test_wrong_input(changes, message):
    with pytest.raises(ss.InputError, match=message):
        ss.pure_slip_damping(EXPONENTIAL, **(POINT | changes))


def test_a_slope_of_zero_needs_no_damping():
    law = ss.laws.polynomial.bind(mu_s="0.5", mu_m="0.2", v_m="1")
    assert ss.pure_slip_damping(law, V=1.0, N=9.81, method="equilibrium").value == 0


@sweep("formula", ["mu_k", "mu_k - a*v", "mu_k + a*(cos(v) + v)", "mu_k*cos(a*v)"], "mu_k", "mu_k - a*v")
def test_no_threshold_is_minus_zero(formula):
    law = ss.FrictionLaw(formula)
    law = law.bind(**{name: {"a": 0.0, "mu_k": 0.37}[name] for name in law.parameters})
    for method in ("auto", "equilibrium", "least_squares", "harmonic", "second_order", "orbit"):
        assert not np.signbit(ss.pure_slip_damping(law, **POINT | {"V": [0.3, 0.9]}, method=method).value).any()
        assert str(ss.pure_slip_damping(law, **POINT, method=method)).startswith("0 kg/s")


def test_a_jump_at_the_speed_of_the_belt():
    """Below c = 3 the motion spirals to rest, where it is driven off; from there on it creeps to it."""
    law = "0.6 - 0.1*v - Piecewise((0, v < 1), (0.4, True))"
    point = {"V": 1.0, "N": 10.0, "m": 1.0, "k": 1.0}
    found = ss.pure_slip_damping(law, **point, method="simulation", rtol=1e-9)
    assert found.value == pytest.approx(3.0, rel=1e-9)
    assert abs(found.value - 3.0) <= found.error
    cycles = [ss.stick_slip_cycle(law, ss.Oscillator(c=c, **point)) for c in (3.0 - 1e-6, 3.0 + 1e-6)]
    assert (cycles[0] is None, cycles[1] is None) == (False, True)


@sample(1)
@pytest.mark.parametrize(("V", "value"), [(0.5, 0.608019865), (0.1, -2.523740298)])
def test_a_law_that_rises_from_rest_more_slowly_than_every_power(V, value):
    """Savkoor's, whose table goes down to 1e-40 m/s: its narrow pieces there are no places to stop at."""
    law = "0.6*exp(-0.1*(log(v/0.005)/log(10))^2)"
    osc = ss.Oscillator(V=V, N=9.81, m=1, k=100, c=value - 0.01)
    found = ss.pure_slip_damping(law, osc, method="simulation")
    assert found.value == pytest.approx(value, rel=1e-7)
    assert [ss.peak_velocity(law, replace(osc, c=value + off)) > V for off in (-0.01, 0.01)] == [True, False]


def test_a_law_that_holds_nothing_is_said_to():
    assert "mu(0) = 0" in str(ss.pure_slip_damping("0.3*tanh(v/1e-3)*exp(-v)", V=0.5, N=1, m=1, k=1))
    assert "mu(0) = 0" not in str(ss.pure_slip_damping("0.3*exp(-v)", V=0.5, N=1, m=1, k=1))


@sample(1)
@pytest.mark.parametrize(
    "rise", ["0.2/(1 + log(v/0.1)^2)", "0.2*(v/0.1)^0.3*exp(-v/0.1)", "0.4*(v/0.1)^0.1*exp(-v/0.1)"]
)
def test_friction_that_rises_at_rest_faster_than_any_line(rise):
    """Slip reversed in time is that by the law upside down: there steps at rest are explicit, here implicit."""
    point = {"V": 0.2, "N": 10.0, "m": 1.0, "k": 100.0}
    up, down = (
        ss.pure_slip_damping(f"0.3 {sign} {rise}", **point, method="simulation", rtol=1e-9) for sign in "+-"
    )
    assert abs(up.value + down.value) <= up.error + down.error
    assert up.relative_error < 1e-8
    law = ss.FrictionLaw(f"0.3 + {rise}")
    below, above = (ss.Oscillator(**point, c=up.value * (1 + side * 1e-3)) for side in (-1, 1))
    assert ss.peak_velocity(law, below) > point["V"] >= ss.peak_velocity(law, above)
    assert ss.stick_slip_cycle(law, below) is not None
    assert ss.stick_slip_cycle(law, above) is None
