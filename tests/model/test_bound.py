"""`BoundLaw`: a law as numbers, each computed once, the same as the law's."""

import copy
import dataclasses
import pickle

import numpy as np
import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym.model import at_rest, bound
from stickslip_sym.model.lipschitz import _is_positive, _speed
from stickslip_sym.model.table import FrictionTable
from support.sweeps import sample


def hardened():
    return ss.FrictionLaw("mu_m + (mu_s - mu_m)*exp(-alpha*v)", static="mu_0*r", name="hardened")


def test_what_has_no_value_is_named_once():
    law = hardened().bind(mu_s=0.5, r=1.5)
    with pytest.raises(ss.InputError, match=r"^the law 'hardened' has no value for mu_m, alpha, mu_0; give it"):
        _ = law.bound
    with pytest.raises(ss.InputError, match=r"no value for mu_m, alpha; give it first: law.bind\(mu_m=..., a"):
        _ = law.kinetic
    law = law.bind(mu_m=0.2, alpha=3)
    assert law.kinetic.mu(0.0) == law.mu(0.0) == 0.5
    with pytest.raises(ss.InputError, match=r"no value for mu_0; give it first"):
        _ = law.bound
    assert law.bind(mu_0=0.4).bound.static == pytest.approx(0.6)


def test_a_bound_law_is_frozen():
    law = ss.laws.exponential.typical().bound
    for name in (field.name for field in dataclasses.fields(law)):
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(law, name, None)


@sample(10)
@pytest.mark.parametrize("name", ss.laws)
def test_numbers_are_those_of_the_law(name):
    law = ss.laws[name].typical()
    v = np.geomspace(1e-3, 5.0, 9)
    assert law.bound.mu(v) == pytest.approx(law.mu(v), rel=0, abs=0)
    assert law.bound.slope(v) == pytest.approx(law.slope(v), rel=0, abs=0)
    assert (law.bound.onset, law.bound.static) == (law.onset, law.static_value)
    assert law.bound.kinks == tuple(map(float, law.kinks()))
    assert law.bound.mu(0.37) == pytest.approx(float(law.expr.subs(law.point).subs(ss.symbols.v, 0.37)), rel=1e-13)
    kinked = any(kink < 5.0 for kink in law.bound.kinks)
    assert (law.bound.obstacle(5.0) is None) == (not kinked and law.static_value == law.onset)
    assert law.bound.reach == np.inf


COMPUTED = {
    "onset": (at_rest, "limit_at_rest"), "kinks": (bound, "kinks_at"), "exact_kinks": (bound, "kinks_at"),
    "segments": (bound, "branch_from"), "rises": (at_rest, "rises_of"), "table": (FrictionTable, "of"),
}  # fmt: skip


@pytest.mark.parametrize("name", COMPUTED)
def test_each_is_computed_once_for_equal_laws(name, monkeypatch):
    owner, function = COMPUTED[name]
    calls, compute = [], getattr(owner, function)

    def counted(*args):
        calls.append(args)
        return compute(*args)

    text = f"0.2 + 0.3*exp(-v/0.7{sorted(COMPUTED).index(name)}3)"  # no law of another test
    law, again = ss.FrictionLaw(text), ss.FrictionLaw(text)
    law.bound, again.bound  # noqa: B018  # equal laws are one
    monkeypatch.setattr(owner, function, staticmethod(counted) if owner is FrictionTable else counted)
    first = getattr(law.bound, name)
    asked = len(calls)
    assert asked >= 1
    assert getattr(law.bound, name) is getattr(again.bound, name) is getattr(copy.copy(law).bound, name) is first
    assert len(calls) == asked
    assert getattr(ss.FrictionLaw(text + " + 0.01*v").bound, name) is not None
    assert len(calls) > asked  # another law's are its own


def test_a_law_bound_anew_has_other_numbers():
    law = ss.laws.exponential.typical()
    assert law.bound.onset == 0.5  # and kept
    assert law.bind(mu_s=0.7).bound.onset == 0.7
    assert law.with_static(0.9).bound.static == 0.9
    assert law.bound.static == 0.5
    assert law.with_static(0.9).bound.table.static == 0.9
    assert law.with_static(0.9).kinetic is law.bound
    slower = law.partial("mu_s").bound
    assert slower.mu(0.5) == pytest.approx(float(np.exp(-0.5 * float(law.values["alpha"]))))


def test_a_bound_law_is_sent_without_what_was_computed():
    law = ss.laws.exponential.typical()
    value = law.bound.mu(0.3)
    for sent in (pickle.loads(pickle.dumps(law.bound)), pickle.loads(pickle.dumps(law)).bound):
        assert sent == law.bound
        assert sent.mu(0.3) == value
    assert "_mu" not in pickle.loads(pickle.dumps(law.bound)).__dict__


def test_what_is_not_smooth_is_said():
    law = ss.FrictionLaw("0.4 - 0.1*Min(v, 0.3)")
    assert law.bound.obstacle(0.3) is None
    assert law.bound.obstacle(0.31) == "it has a kink at v = 0.3, which the orbit passes"
    assert law.with_static(0.5).bound.obstacle(0.1) == "its static coefficient 0.5 lies above mu(0+) = 0.4"
    assert law.with_static(0.4).bound.obstacle(0.1) is None
    straight = [ss.FrictionLaw(text).bound.is_straight for text in ("0.4 - 0.1*v", "0.4", "0.4 - v^2")]
    assert straight == [True, True, False]
    assert not law.bound.is_straight


def test_a_static_coefficient_that_is_that_at_rest_but_for_rounding():
    for off, above in ((3e-13, False), (3e-12, True)):
        law = ss.FrictionLaw("0.2 + 0.3*exp(-v)")
        assert (law.with_static(0.5 * (1 + off)).bound.static > 0.5) == above
        below = law.with_static(0.5 * (1 - off)).bound
        if above:
            with pytest.raises(ss.InputError, match="below"):
                _ = below.static
        else:
            assert below.static == 0.5


def test_a_sign_is_shown_over_some_hundred_intervals():
    """Of a sum that balls as wide as a quarter of a period do not part from 0."""
    wave = sp.Rational(8, 5) + sp.sin(_speed) + sp.cos(_speed)
    assert [_is_positive(wave, sp.S.Zero, sp.Integer(end)) for end in (100, 200)] == [True, False]
