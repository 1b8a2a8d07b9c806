"""Numbers with a standard error: read by `uncertainties`, kept with their correlations, refused where unusable."""

import numpy as np
import pytest
import sympy as sp
import uncertainties

import stickslip_sym as ss

FORMULA = "mu_m + (mu_s - mu_m)*exp(-alpha*v)"


def test_every_way_to_write_one_is_the_same():
    rng = np.random.default_rng(5)
    for _ in range(20):
        number, error = round(rng.uniform(0.1, 0.9), 2), int(rng.integers(1, 99))
        texts = [f"{number:.2f}{end}" for end in (f"({error})", f"+/-{error / 100:.2f}", f" ± {error / 100:.2f}")]
        for value in (*texts, uncertainties.ufloat(number, error / 100)):
            law = ss.FrictionLaw(FORMULA).bind(mu_s=value)
            assert float(law.values["mu_s"]) == number
            assert law.uncertain["mu_s"].std_dev == pytest.approx(error / 100, rel=1e-12)
        decimal = ss.FrictionLaw(FORMULA).bind(mu_s=texts[0]).values["mu_s"]
        assert decimal == sp.Rational(f"{number:.2f}")  # the decimal, not the binary number next to it


def test_a_new_value_takes_the_error_away_and_another_leaves_it():
    law = ss.laws.exponential.typical(mu_s="0.50(2)", mu_m="0.20(1)")
    plain = ss.laws.exponential.typical(mu_s="0.50", mu_m="0.20")
    assert (set(law.uncertain), set(plain.uncertain)) == ({"mu_s", "mu_m"}, set())
    assert plain.mu(0.3) == law.mu(0.3)
    assert plain != law
    assert "mu_s=0.5+/-0.02" in repr(law)
    assert set(law.bind(mu_s=0.4).uncertain) == {"mu_m"}
    assert set(law.bind(alpha=2.0).typical().uncertain) == {"mu_s", "mu_m"}
    assert set(law.with_static("0.6").uncertain) == {"mu_s", "mu_m"}
    assert dict(law.bind(mu_s="0.50+/-0", mu_m=0.2).uncertain) == {}
