"""The short formulas of an average, each against what it stands for."""

from itertools import product

import numpy as np
import pytest
import sympy as sp

from stickslip_sym.core.symbols import v
from stickslip_sym.criteria.criterion import harmonic, least_squares
from stickslip_sym.formula.evaluation.conditioning import speed_scales
from stickslip_sym.formula.evaluation.profile import profile_of


@pytest.mark.parametrize("criterion", [least_squares, harmonic], ids=lambda one: one.name)
def test_the_average_of_a_polynomial_is_the_sum_of_its_moments(criterion):
    """Also where every coefficient of the average itself is 0 or 1, or 1 where its neighbours are not."""
    r = np.array([0.3, 1.0, 7.0])
    for coefficients in product((-1, 0, 1), repeat=3):
        if not any(coefficients):
            continue
        moments = [criterion.mean_power(k) for k in range(3)]
        law = sum(
            c / moment * v ** (k + 1) / (k + 1)
            for k, (c, moment) in enumerate(zip(coefficients, moments, strict=True))
        )
        profile = profile_of(law, criterion)
        for one in r:
            branch = profile.branches[int(np.searchsorted(profile.starts, one, side="right")) - 1]
            expected = -sum(c * one**k for k, c in enumerate(coefficients))
            assert branch(one) * one**branch.power == pytest.approx(expected, rel=1e-14, abs=1e-14)


def test_scales_of_functions_are_where_their_arguments_are_one():
    a = sp.Symbol("a", positive=True)
    for function in (sp.tanh, sp.exp, sp.sech, lambda x: 2**x):
        assert speed_scales(function(a * v), v) == [1 / a]
        assert speed_scales(function(-a * v**2), v) == [1 / sp.sqrt(a)]
