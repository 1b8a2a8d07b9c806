"""Critical values at strong and at weak friction, close together, and what is said of values not looked at."""

import math

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import stickslip_sym as ss
from stickslip_sym.core import symbols
from stickslip_sym.motion.margins import critical as module
from support.commands import inside, read_json
from support.sweeps import sweep

POINT = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}


def without(point, of):
    return {name: value for name, value in point.items() if name != of}


@pytest.mark.parametrize("seed", range(3))
def test_the_threshold_put_in_as_damping_is_found_again(seed):
    """At belt speeds far below all that N/(V sqrt(k m)) up to 100 allows; by N, m or k, static excess or not."""
    rng = np.random.default_rng(seed)
    V = 10 ** rng.uniform(-4, -2)
    law = ss.laws.exponential.typical(alpha=rng.uniform(0.3, 1) / V)
    if seed == 2:
        law = law.with_static(0.52)
    point = {"V": V, "N": 10 ** rng.uniform(0, 1), "m": 1.0, "k": 100 * (rng.uniform(0.5, 1) / V) ** 2}
    c = ss.pure_slip_damping(law, **point, rtol=1e-12).value
    of = ("m", "k", "N")[seed]
    found = ss.critical(law, of, c=c, **without(point, of))
    assert min(abs(one.value / point[of] - 1) for one in found) < 1e-3
    for one in found:
        assert ss.pure_slip_damping(law, **point | {of: one.value}, rtol=1e-9).value == pytest.approx(c, rel=1e-7)
    assert found.looked[0] < point[of] < found.looked[1]
    assert f"{of} was looked at from " in str(found)


@sweep("above", [0.0, 1e-3], 0)
def test_two_at_an_extremum_of_strong_friction(above):
    """Where the mismatch of both halves is infinite, on either side: above the highest threshold there is none."""
    law, point = ss.laws.lorentzian.typical(), POINT | {"N": 60.0}
    places = np.linspace(0.2, 1.2, 21)
    highest = max(ss.pure_slip_damping(law.bind(v_s=x), **point).value for x in places)
    found = ss.critical(law, "v_s", c=highest * (0.999 + 10 * above), **point, within=(0.2, 1.2))
    assert len(found) == (0 if above else 2)
    assert found.unresolved == ()


def test_what_the_budget_leaves_open_is_said(monkeypatch):
    """In words, and as data: within which values."""
    monkeypatch.setattr(module, "MOST_INTERVALS", 1)
    law = ss.FrictionLaw("0.4 - 0.1*v + 0.02*sin(10*a)*v").bind(a=1)
    found = ss.critical(law, "a", c=0.981, V=0.5, N=9.81, within=(0.5, 2))
    assert found.unresolved == ((0.5, 2.0),)
    assert "a was looked at from 0.5 to 2; not decided, or without a threshold: 0.5 to 2" in str(found)
    monkeypatch.undo()
    whole = ss.critical(law, "a", c=0.981, V=0.5, N=9.81, within=(0.5, 2))
    zeros = np.arange(math.ceil(5 / math.pi), 20 / math.pi) * math.pi / 10
    assert [one.value for one in whole] == pytest.approx(zeros[zeros < 2], rel=1e-6)


def test_a_threshold_that_is_c_everywhere_is_no_list_of_values():
    law = ss.FrictionLaw("0.45 - 0.3*Min(v, 0.4) + 0.3*Max(v - 0.4, 0)")
    with pytest.raises(ss.NotConverged, match="the threshold is c, within its error, whatever N is"):
        ss.critical(law, "N", c=0.0, V=0.4, m=1, k=100, within=(1, 20))


def test_where_it_was_looked_is_in_text_and_json():
    given = "critical", "exponential", "--of", "alpha", "-c", "2", "--within", "1:6"
    assert "alpha was looked at from 1 to 6" in inside(*given).stdout
    found = read_json(inside(*given, "--json").stdout)
    assert (found["looked"], found["unresolved"]) == ([1, 6], [])


WORDS = {
    "overtakes": (
        ss.laws.exponential.typical(),
        {"N": 0.05, "c": 0.0},
        "the mass overtakes the belt, and does not",
    ),
    "mu(0) = 0": (
        ss.FrictionLaw("0.5*tanh(20*v)*exp(-v)"),
        {"c": 0.1},
        "the mass overtakes the belt, and does not",
    ),
    "sticks": (ss.laws.exponential.typical(), {"c": 1.0}, "stick-slip is possible"),
    "slips": (ss.laws.exponential.typical(), {"c": 4.0}, "no stick-slip"),
}


@pytest.mark.parametrize("name", WORDS)
def test_margins_say_what_the_motion_does(name):
    """As the stick-slip cycle that is there, or not."""
    law, changes, words = WORDS[name]
    osc = ss.Oscillator(**POINT | changes)
    found = ss.margins(law, osc, reach=1.02, samples=0)
    assert str(found).startswith(words)
    assert found.stick_slip == (ss.stick_slip_cycle(law, osc) is not None)


def _returns(law, m, k, c, V, N):
    """Whether the slip from P returns to the belt's speed, by SciPy's implicit steps."""
    mu = sp.lambdify(symbols.v, law.expr.subs({p.symbol: law.values[n] for n, p in law.parameters.items()}))

    def rates(t, y):
        return V - y[1], (c * (V - y[1]) + k * y[0] - N * mu(max(y[1], 0.0))) / m

    def at_belt(t, y):
        return y[1]

    def at_minimum(t, y):
        return rates(t, y)[1]

    at_belt.terminal, at_belt.direction, at_minimum.terminal, at_minimum.direction = True, -1, 2, 1
    begin = [(float(mu(0.0)) * N - c * V) / k, 0.0]
    slip = solve_ivp(rates, (0, 100), begin, method="Radau", rtol=1e-8, atol=1e-11, events=[at_belt, at_minimum])
    return slip.t_events[0].size > 0 and slip.t_events[0][-1] > 1e-6


def test_critical_values_at_strong_friction_against_scipy():
    """N/(V sqrt(k m)) is 100: stick-slip is there between the values, and not outside."""
    law, point = ss.laws.lorentzian.typical(), {"m": 1.0, "k": 100.0, "c": 148.6, "V": 0.5, "N": 500.0}
    found = ss.critical(law, "v_s", **point, within=(0.35, 0.6))
    assert [one.value for one in found] == pytest.approx([0.4514592, 0.485726], rel=1e-6)
    low, high = (one.value for one in found)
    for v_s, returns in (
        (0.9995 * low, False),
        (1.0005 * low, True),
        (0.9995 * high, True),
        (1.0005 * high, False),
    ):
        assert _returns(law.bind(v_s=v_s), **point) == returns


def test_where_it_looks_where_nothing_is_said():
    """At N <|mu'|> from 1e-8 to 10 sqrt(k m), 24 decades of belt speeds, and a hundredth of a parameter to 100."""
    law = ss.FrictionLaw("0.5 - a*v").bind(a=0.2)
    weak, strong = (np.array([1e-8, 10]) * 10 / 0.2).tolist()
    for of, low, high in (
        ("V", 1e-12, 1e12),
        ("N", weak, strong),
        ("m", (9.81 / strong) ** 2, (9.81 / weak) ** 2),
        ("k", 100 * (9.81 / strong) ** 2, 100 * (9.81 / weak) ** 2),
    ):
        assert ss.critical(law, of, c=1.0, **without(POINT, of)).looked == pytest.approx((low, high), rel=1e-9)
    law = ss.laws.exponential.typical()
    for c in (0.9, 1.1):
        found = ss.critical(law, "alpha", c=c, V=0.5, N=9.81, method="equilibrium")
        assert found.looked == pytest.approx((0.03, 300), rel=1e-9)


@pytest.mark.parametrize(("N", "method"), [(1.0, "second_order"), (2.5, "orbit")])
def test_values_are_known_to_a_thousandth_of_the_tolerance(N, method):
    """The second order is off by 2e-7 and by 7e-6 there; 1e-3 was asked for."""
    law, point = ss.laws.exponential.typical(), POINT | {"N": N}
    c = ss.pure_slip_damping(law, **point, rtol=1e-10).value
    (found,) = ss.critical(law, "N", c=c, **without(point, "N"), within=(0.9 * N, 1.1 * N))
    assert found.method == method
    assert found.value == pytest.approx(N, rel=1e-6)
