"""One slip: against another integrator, plain against compiled, and the wedge against differences."""

from dataclasses import replace

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym.motion.slip import Dimensionless
from stickslip_sym.motion.steps import End
from stickslip_sym.motion.table import FrictionTable

RTOL = 1e-11
LAWS = {
    "exponential": ("0.2 + 0.3*exp(-3*v)", None),
    "cubic": ("0.5 - 0.45*(v - v^3/3)", None),
    "static": ("0.25 + 0.2*exp(-2*v)", "0.6"),
    "kinked": ("0.5 - 0.3*Min(v, 0.4) + 0.2*Max(v - 0.9, 0)", None),
    "falls": ("Piecewise((0.5, v < 0.2), (0.3 + 0.1*exp(-v), True))", None),
    "rises": ("Piecewise((0.5 - 0.2*v, v < 0.45), (0.55 - 0.1*v, True))", None),
    "root": ("0.5 - 0.2*sqrt(v)/(1 + v)", None),
    "steep": ("0.2 + 0.3*exp(-v) + 0.1*(tanh(80*v) - 1)", None),
}


def systems(count, seed):
    """Yield kinds of laws, dimensionless oscillators with them, and initial conditions q, w, side."""
    rng = np.random.default_rng(seed)
    for number in range(count):
        kind = list(LAWS)[number % len(LAWS)]
        formula, static = LAWS[kind]
        eta, zeta, V = 10 ** rng.uniform((-2, -3, -0.7), (1.3, 0.2, 0.5))
        table = FrictionTable.of(ss.FrictionLaw(formula, static=static))
        # A fifth of them is driven by a weak negative damping.
        system = Dimensionless(eta, zeta * rng.choice((1, 1, 1, 1, -0.02)), table, V)
        yield kind, system, rng.uniform(-2, 2) * (1 + 0.3 * eta), rng.uniform(0, 2.5), int(rng.choice((1, 1, -1)))


@pytest.mark.parametrize("compiling", [True, False])
def test_one_slip_and_many_give_the_same_digits(compiling, monkeypatch):
    if compiling:
        pytest.importorskip("numba")
    else:
        monkeypatch.setattr("stickslip_sym.motion.slip.is_compiling", lambda: False)
    for until in (End.RETURN, End.MINIMUM, End.LEVEL):
        for _, system, q, w, side in systems(24 if compiling else 8, seed=3):
            options = {"until": until, "level": 1.0, "horizon": 20.0, "rtol": RTOL, "most": 2000}
            single = system.slip(q, w, side, **options)
            many = system.slips(np.full(20, q), np.full(20, w), side, **options).one(7)  # fewer are plain
            assert many.end is single.end
            assert many[1:7] == pytest.approx(single[1:7], rel=1e-13, abs=1e-13)
            assert many.extremes == pytest.approx(single.extremes, rel=1e-13, abs=1e-13)


def test_workers_give_the_same():
    system = Dimensionless(2.0, 0.1, FrictionTable.of(ss.laws.exponential.typical()), 0.5)
    q, w, side = np.linspace(-2, 0, 9000), np.linspace(0, 2, 9000), np.ones(9000)
    one, two = (system.slips(q, w, side, horizon=5.0, rtol=1e-6, workers=n) for n in (1, 2))
    assert all(np.array_equal(*columns) for columns in zip(one, two, strict=True))


def test_extremum_is_located_before_a_crossing():
    # The slip from P grazes the belt's speed at the threshold: just above it turns, just below it returns.
    law, osc = ss.laws.exponential.typical(), ss.Oscillator(m=1, k=100, V=0.5, N=9.81)
    c = ss.pure_slip_damping(law, V=0.5, N=9.81, m=1, k=100, method="proof", rtol=1e-12).value
    system = Dimensionless.of(law, osc)
    for off, end in ((1e-11, End.MINIMUM), (-1e-11, End.RETURN)):
        slip = replace(system, zeta=c * (1 + off) / 20).slip(0.0, 0.0, until=End.MINIMUM, rtol=1e-13)
        assert slip.end is end
        assert slip.w == pytest.approx(0.0, abs=1e-10)


def test_backward_returns_to_the_begin():
    for kind, system, q, w, side in systems(48, seed=4):
        if kind in ("rises", "falls") or w < 0.1:  # through a sliding mode there is no way back
            continue
        there = system.slip(q, w, side, horizon=1.0, rtol=1e-13)
        if there.end is not End.HORIZON or max(system.eta, abs(system.zeta)) > 3:
            continue
        back = system.backward.slip(-there.q, there.w, side, horizon=1.0, rtol=1e-13)
        assert (-back.q, back.w) == pytest.approx((q, w), abs=1e-8)
