"""A static coefficient that is a parameter of its own."""

import pytest

import stickslip_sym as ss


@pytest.mark.parametrize("method", ["equilibrium", "least_squares", "harmonic"])
def test_averages_do_not_see_it(method):
    """Whichever of the two laws is asked for first: their formulas are equal, their arguments are not."""
    law = ss.FrictionLaw("mu_m + (mu_s - mu_m)/(1 + (v/v_s)^2)").bind(mu_s=0.5, mu_m=0.2, v_s=0.4)
    held = law.with_static("mu_t").bind(mu_t=0.7)
    values = [ss.pure_slip_damping(one, V=0.5, N=9.81, method=method).value for one in (law, held, law)]
    assert values[0] == values[1] == values[2]
