"""One slip: plain against compiled, many against one, and back again."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import stickslip_sym as ss
from stickslip_sym.motion.kernel.slip_data import SlipEnd
from stickslip_sym.motion.orbits.needed import search_damping_ratios
from stickslip_sym.motion.slip import NondimensionalOscillator
from support.reference_motions import points
from support.strategies import laws, operating_points
from support.sweeps import fewer


def systems(count, seed):
    """Yield laws, dimensionless oscillators and initial conditions q, w, side."""
    rng = np.random.default_rng(seed)
    for _, law, osc, *_ in points(count, seed):
        system = NondimensionalOscillator.of(law.bound, osc)
        q = rng.uniform(-2, 2) * (1 + 0.3 * system.eta)
        yield law, system, q, rng.uniform(0, 2.5), int(rng.choice((1, 1, -1)))


@pytest.mark.parametrize("compiling", [True, False])
def test_one_slip_and_many_give_the_same_bits(compiling, monkeypatch):
    """Which of both runs must show in no digit: that depends on how many are asked for, and on what is loaded."""
    if compiling:
        pytest.importorskip("numba")
    else:
        monkeypatch.setattr("stickslip_sym.motion.slip.is_compiling", lambda: False)
    for until in (SlipEnd.RETURN, SlipEnd.MINIMUM, SlipEnd.LEVEL):
        for number, (_, system, q, w, side) in enumerate(systems(24 if compiling else 8, seed=3)):
            options = {"until": until, "level": 1.0, "horizon": 20.0, "rtol": 1e-11, "most": 2000}
            options["passes"] = number % 3
            single = system.slip(q, w, side, **options)
            many = system.slips(np.full(20, q), np.full(20, w), side, **options).one(7)  # fewer are plain
            assert many[:-1] == single[:-1]


@fewer(3)
@given(laws(static=True), operating_points(), st.floats(0.02, 1.0), st.sampled_from([1e-4, 1e-9, 1e-13]))
def test_needed_damping_has_the_same_bits_plain_and_compiled(law, osc, amplitude, rtol):
    """With its slope, and in implicit steps too, of strong friction: a threshold does not say what is loaded."""
    pytest.importorskip("numba")
    system = NondimensionalOscillator.of(law.bound, osc)
    for eta in (system.eta, 100 * system.eta):
        push = eta * (system.table.static - system.table.onset)
        rows = np.empty((2, 2, 5))
        for i, few in enumerate((9, 0)):
            orbits = [np.array(column) for column in ([eta, eta], [0.0, push], [amplitude, 1.0])]
            system.spread(search_damping_ratios, orbits, (rtol,), rows[i], few=few)
        assert rows[0].tobytes() == rows[1].tobytes(), law


def test_slip_goes_on_beyond_the_belt_speed():
    """As slips after one another do; and where it ends changes with where it began as the wedge says."""
    compared = 0
    for law, strong, q, w, side in systems(30, seed=5):
        system = replace(strong, eta=strong.eta / 30)  # so weak that the mass seldom sticks

        def end(q, w=w, side=side, system=system, **options):
            return system.slip(q, w, side, passes=2, rtol=1e-12, **options)

        whole = end(q, wedge=(system.difference, -system.acceleration(q, w, side)))
        if whole.end is not SlipEnd.RETURN or whole.passed < 2:
            continue
        parts = [system.slip(q, w, side, rtol=1e-12)]
        for other in (-side, side):
            parts.append(system.slip(parts[-1].q, 0.0, other, rtol=1e-12))
        assert (whole.side, whole.u_least < 0 < whole.u_most) == (side, True), law
        assert whole.q == pytest.approx(parts[-1].q, abs=1e-9), law
        assert whole.tau == pytest.approx(sum(part.tau for part in parts), abs=1e-9), law
        step = 1e-4
        slope = (8 * (end(q + step).q - end(q - step).q) - end(q + 2 * step).q + end(q - 2 * step).q) / (12 * step)
        assert -whole.wedge / whole.rate == pytest.approx(slope, rel=1e-4, abs=1e-6), law
        compared += 1
    assert compared > 4


def test_workers_give_the_same():
    system = NondimensionalOscillator(2.0, 0.1, ss.laws.exponential.typical().bound.table, 0.5)
    q, w, side = np.linspace(-2, 0, 9000), np.linspace(0, 2, 9000), np.ones(9000)
    one, two = (system.slips(q, w, side, horizon=5.0, rtol=1e-6, workers=n) for n in (1, 2))
    assert all(np.array_equal(*columns) for columns in zip(one, two, strict=True))


def test_extremum_is_located_before_a_crossing():
    """The slip from P grazes the belt's speed at the threshold: just above it turns, just below it returns."""
    law, osc = ss.laws.exponential.typical(), ss.Oscillator(m=1, k=100, V=0.5, N=9.81)
    c = ss.pure_slip_damping(law, V=0.5, N=9.81, m=1, k=100, method="proof", rtol=1e-12).value
    system = NondimensionalOscillator.of(law.bound, osc)
    for off, end in ((1e-11, SlipEnd.MINIMUM), (-1e-11, SlipEnd.RETURN)):
        slip = replace(system, zeta=c * (1 + off) / 20).slip(0.0, 0.0, until=SlipEnd.MINIMUM, rtol=1e-13)
        assert slip.end is end
        assert slip.w == pytest.approx(0.0, abs=1e-10)


def test_backward_returns_to_the_begin():
    compared = 0
    for law, system, q, w, side in systems(48, seed=4):
        there = system.slip(q, w, side, horizon=1.0, rtol=1e-13)
        if there.end is SlipEnd.HORIZON and max(system.eta, abs(system.zeta)) < 3 and w > 0.1:
            back = system.backward.slip(-there.q, there.w, side, horizon=1.0, rtol=1e-13)
            assert (-back.q, back.w) == pytest.approx((q, w), abs=1e-8), law
            compared += 1
    assert compared > 4
