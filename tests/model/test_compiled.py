"""Laws of the catalogue compute by functions that were written beforehand; a law of the same formula does not."""

import compiled_laws
import numpy as np
import pytest
from forms import LAWS

import stickslip_sym as ss

ROUNDING = 2e-14  # the order of a sum's terms may differ
SPEEDS = np.concatenate([[0.0], np.geomspace(1e-9, 30, 40)])


def same_formula(law):
    """A law that is read, differentiated and compiled by SymPy."""
    return ss.FrictionLaw(law.text, parameters=law.parameters.values())


def random_values(law, rng):
    return {name: float(p.typical) * rng.uniform(0.5, 2) for name, p in law.parameters.items()}


def test_the_module_is_what_the_formulas_say():
    assert compiled_laws.PATH.read_text(encoding="utf-8") == compiled_laws.module()


@pytest.mark.parametrize("name", LAWS)
def test_functions_give_the_values_of_the_formula(name):
    law, rng = ss.laws.catalogue[name], np.random.default_rng(LAWS.index(name))
    plain = same_formula(law)
    assert plain.expr == law.expr
    for _ in range(3):
        values = random_values(law, rng)
        ready, read = law.bind(**values), plain.bind(**values)
        for kind in ("mu", "slope"):
            got, expected = getattr(ready, kind)(SPEEDS[1:]), getattr(read, kind)(SPEEDS[1:])
            assert got == pytest.approx(expected, rel=ROUNDING, abs=ROUNDING), kind
        assert ready.at_speeds(SPEEDS) == pytest.approx(read.at_speeds(SPEEDS), rel=ROUNDING)
        assert ready.kinks() == read.kinks() == []
        assert ready.values == read.values


def test_two_parameters_exchanged_are_noticed():
    law = ss.laws.exponential
    exchanged = {"mu_s": 0.2, "mu_m": 0.5, "alpha": 3}
    assert not np.array_equal(law.typical().mu(SPEEDS), law.bind(**exchanged).mu(SPEEDS))
    assert law.bind(**exchanged).mu(SPEEDS) == pytest.approx(same_formula(law).bind(**exchanged).mu(SPEEDS))


def test_copies_share_what_is_compiled_and_pickling_keeps_the_law():
    import pickle

    law = ss.laws.gaussian.typical()
    again = pickle.loads(pickle.dumps(law))
    assert again == law
    assert again.slope(0.3) == law.slope(0.3)
    assert law.bind(v_s=1).expr is law.expr


def test_the_catalogue_is_a_mapping_of_laws():
    catalogue, law = ss.laws.catalogue, ss.FrictionLaw("mu_a - b*v", units={"b": "s/m"})
    catalogue["mine"] = law
    assert catalogue["mine"] is law
    assert ss.laws.find("mine") is law
    assert len(catalogue) == len(list(catalogue)) == len(LAWS) + 1
    del catalogue["mine"]
    assert "mine" not in catalogue
    with pytest.raises(KeyError):
        catalogue["mine"]
    with pytest.raises(ss.InputError, match="no law 'mine'"):
        ss.laws.find("mine")
