"""Laws with fitted numbers, given in any form, compared: what holds of every law once it has values."""

import pytest
from forms import LAWS

import stickslip_sym as ss
from stickslip_sym.model.laws import as_law


def test_a_law_is_given_by_name_or_formula():
    for given in (ss.laws.stribeck, "stribeck", " stribeck", ss.laws.stribeck.text, ss.laws.stribeck.expr):
        assert as_law(given).text == ss.laws["stribeck"].text
    assert as_law("mu_k").text == "mu_k"
    assert as_law(0.3).mu(1.0) == 0.3
    with pytest.raises(ss.InputError, match="did you mean 'exponential'"):
        as_law("exponental")
    for wrong in (None, [0.1], ss.Oscillator(m=1, k=1, V=1, N=1)):
        with pytest.raises(ss.InputError, match="a friction law is needed"):
            as_law(wrong)


TEXT = "0.2 + 0.3*exp(-3*v)"
OSC = ss.Oscillator(m=1, k=100, V=0.5, N=9.81, c=2.0)
CALLS = {
    "derive": lambda law: ss.derive(law)(V=0.5, N=9.81),
    "slope_average": lambda law: ss.slope_average(law)(V=0.5, N=9.81),
    "enclose": lambda law: float(ss.enclose(law, V=0.5, N=9.81, digits=15)),
    "quadrature": lambda law: float(ss.quadrature.damping(law, V=0.5, N=9.81, digits=15)),
    "pure_slip_damping": lambda law: ss.pure_slip_damping(law, OSC, method="harmonic").value,
    "simulate": lambda law: float(ss.simulate(law, OSC, t_end=0.1).x[-1]),
    "regime": lambda law: str(ss.regime(law, OSC)),
    "limit_cycles": lambda law: len(ss.limit_cycles(law, OSC)),
    "stick_slip_cycle": lambda law: ss.stick_slip_cycle(law, OSC).period,
    "critical": lambda law: [found.value for found in ss.critical(law, "V", c=2.0, N=9.81, m=1, k=100)],
    "compare": lambda law: ss.compare(law, OSC, methods=["harmonic"])["harmonic"].threshold.value,
}


@pytest.mark.parametrize("name", CALLS)
def test_functions_take_a_law_by_its_text(name):
    assert CALLS[name](TEXT) == CALLS[name](ss.FrictionLaw(TEXT))
    with pytest.raises(ss.InputError, match="a friction law is needed"):
        CALLS[name](OSC)


def test_the_catalogue_is_a_mapping_of_laws():
    law = ss.FrictionLaw("mu_a - b*v", units={"b": "s/m"})
    ss.laws["mine"] = law
    assert ss.laws["mine"] is ss.laws.mine is ss.laws.catalogue["mine"] is ss.laws.find("mine") is law
    assert len(ss.laws) == len(LAWS) + 1
    del ss.laws["mine"]
    assert all(getattr(ss.laws, name) is law for name, law in ss.laws.items())
    assert set(ss.laws) <= set(dir(ss.laws))
    with pytest.raises(AttributeError, match="did you mean 'exponential'"):
        _ = ss.laws.exponental
