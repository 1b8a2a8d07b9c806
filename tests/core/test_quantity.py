"""Results that are one quantity behave as numbers."""

import numpy as np
import pytest

import stickslip_sym as ss

LAW = ss.laws.exponential.typical()
REST = {"N": 9.81, "m": 1, "k": 100}


def test_a_threshold_is_formatted_compared_and_computed_with():
    threshold = ss.pure_slip_damping(LAW, V=0.5, **REST)
    value = threshold.value
    assert f"{threshold:.3f}" == f"{value:.3f}"
    assert f"{threshold}" == str(threshold)
    assert threshold > 2.0 > threshold - 1
    assert 2 * threshold + 1 == 2 * value + 1
    assert threshold / threshold == 1
    assert np.sqrt(threshold) == np.sqrt(value)
    assert float(threshold) == value
    assert threshold == ss.pure_slip_damping(LAW, V=0.5, **REST)
    assert max(threshold, 1.0) is threshold


def test_several_thresholds_are_an_array():
    thresholds = ss.pure_slip_damping(LAW, V=[0.4, 0.5], **REST)
    np.testing.assert_array_equal(thresholds > 2.6, thresholds.value > 2.6)
    np.testing.assert_array_equal(np.asarray(thresholds), thresholds.value)
    with pytest.raises(ss.InputError, match="take value"):
        f"{thresholds:.3f}"


def test_a_critical_value_is_a_number_too():
    (critical,) = ss.critical(LAW, "V", c=2.3, **REST)
    assert critical - critical.value == 0
    assert f"{critical:.6f}" == f"{critical.value:.6f}"
