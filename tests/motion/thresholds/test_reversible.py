"""Laws that are even about the belt's speed make slip reversible without damping: the threshold is exactly 0."""

import numpy as np
import pytest

import stickslip_sym as ss

OSCILLATOR = {"N": 9.81, "m": 1.0, "k": 100.0}
EVEN = {
    "smooth": "0.4 + {a}*(v - {V})^2 - {b}*(v - {V})^4",
    "kinked": "0.45 - {a}*Min(v, {V}) + {a}*Max(v - {V}, 0) + {b}*Abs(v - {V})^3",
    "jumps": "Piecewise((0.5, v < {V}*(1 - {a})), (0.4, v < {V}*(1 + {a})), (0.5, True))",
}


def even(kind, seed):
    """Return a law that is even about a speed, and that speed."""
    V, a, b = np.random.default_rng(seed).uniform((0.1, 0.1, 0.01), (1, 0.6, 0.3)).round(3).tolist()
    return ss.FrictionLaw(EVEN[kind].format(V=V, a=a, b=b)), V


@pytest.mark.parametrize("kind", EVEN)
def test_a_threshold_of_0_is_a_number(kind):
    """Of every method, within its error; a speed beside is the control: there it is not 0."""
    law, V = even(kind, 7)
    methods = {"smooth": ["orbit", "second_order", "proof"], "kinked": ["proof"], "jumps": []}[kind]
    for method in ("auto", "simulation", "harmonic", *methods):
        found = ss.pure_slip_damping(law, V=V, **OSCILLATOR, method=method, rtol=1e-3)
        assert abs(found.value) <= found.error
        assert found.relative_error <= 1e-3
        assert found.relative_error == pytest.approx(found.error / (1e-8 * found.points.slope_scale[0]), rel=1e-9)
        assert "relative error" not in str(found) + found._repr_html_()
        assert "of 1e-08 N <|mu'|>" in str(found)
        assert "no damping is needed" not in str(found)
        if method == "proof":
            assert found.enclosure.low < 0 < found.enclosure.high
            assert found.error == pytest.approx(float(found.enclosure.radius), rel=1e-9)
        beside = ss.pure_slip_damping(law, V=1.02 * V, **OSCILLATOR, method=method, rtol=1e-3)
        assert abs(beside.value) > 1e-3
        assert "relative error" in str(beside)
    several = ss.pure_slip_damping(law, V=[V, 1.02 * V], **OSCILLATOR)
    assert several.value == pytest.approx([0, beside.value], abs=1e-3)


def test_errors_of_averages_beside_it_are_in_words():
    """The threshold is 0, and an average is not: how many times it is off says nothing."""
    rows = ss.compare(ss.FrictionLaw("0.5 - 0.1*v + 0.1*exp(3*(v - 0.5)) + 0.1*exp(-3*(v - 0.5)) + 0.1*v"),
                      V=0.5, **OSCILLATOR, methods=["harmonic", "simulation"], rtol=1e-3)  # fmt: skip
    assert str(rows).count("kg/s, which is") == 2


def test_margins_and_critical_values_where_the_threshold_is_0():
    law = ss.FrictionLaw("0.45 - a*Min(v, 0.4) + 0.3*Max(v - 0.4, 0)").bind(a="0.30+/-0.06")
    found = ss.margins(law, ss.Oscillator(V=0.4, c=0.02, **OSCILLATOR), samples=60)
    assert found.probability == pytest.approx(0.473, abs=1e-3)
    assert abs(found.sampled.probability - found.probability) < 4 * found.sampled.standard_error
    assert {row.name for row in found.rows} == {"V", "a", "c", "m", "k", "N"}
    assert not found.refused
    (speed,) = ss.critical(law, "V", c=0.0, **OSCILLATOR)
    assert speed.value == pytest.approx(0.4, rel=1e-9)


def test_without_slope_there_is_nothing_to_enclose():
    with pytest.raises(ss.NoThreshold, match="friction does no work"):
        ss.pure_slip_damping(ss.FrictionLaw("0.3"), V=0.4, **OSCILLATOR, method="proof")
