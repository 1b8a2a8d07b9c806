"""Results are data: what a notebook or a log shows of them takes no integration."""

from dataclasses import replace

import pytest

import stickslip_sym as ss
from stickslip_sym.motion import slip
from stickslip_sym.motion.orbits import needed

LAW = ss.laws.exponential.typical()
OSC = ss.Oscillator(m=1, k=100, c=2.3, V=0.5, N=9.81)
BISTABLE = replace(OSC, c=2.45)


def results():
    """Yield results of all functions that integrate motions."""
    law = ss.FrictionLaw("0.3 + 0.2*exp(-v/v_s)").bind(v_s="0.4(0.05)")
    yield ss.simulate(LAW, OSC, t_end=3.0)
    yield ss.simulate(LAW, OSC, t_end=3.0, method="solve_ivp")
    yield ss.simulate(LAW, OSC, t_end=3.0, x0=[0.0, 0.1])
    regime = ss.regime(LAW, BISTABLE)
    yield from (regime, regime.rest, regime.outside, *regime.cycles, *regime.separatrices, regime.stick_slip)
    yield from ss.limit_cycles(LAW, BISTABLE)
    yield ss.stick_slip_cycle(LAW, OSC)
    threshold = ss.pure_slip_damping(law, OSC, method="orbit")
    yield from (threshold, threshold.budget)
    yield ss.pure_slip_damping(LAW, V=[0.5, 0.6], N=9.81, m=1, k=100)
    yield ss.compare(LAW, OSC)
    margins = ss.margins(LAW, OSC)
    yield from (margins, *margins.rows, margins.rows[0].below or margins.rows[0].above)


def test_no_view_of_a_result_integrates(monkeypatch):
    made = [result for result in results() if result is not None]

    def integrated(*_, **__):
        raise RuntimeError("a motion was integrated")

    for module in (slip, needed):
        monkeypatch.setattr(module, "follow", integrated)
    for loop in (slip._follow_all, needed.needed_all, needed.highest_all):
        monkeypatch.setattr(f"{loop.__module__}.{loop.__name__}", integrated)
    with pytest.raises(RuntimeError, match="integrated"):  # a control
        ss.simulate(LAW, OSC, t_end=1.0)
    for result in made:
        assert repr(result)
        assert str(result)
        assert result == result
        if hasattr(result, "_repr_html_"):
            assert result._repr_html_()
