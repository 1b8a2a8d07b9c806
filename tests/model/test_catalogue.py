"""Every law of the catalogue, whatever it is: a new entry is tested here without another line."""

import mpmath
import numpy as np
import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym import symbols
from stickslip_sym.model.expression.dimensions import multiply_by_units, parse_unit
from support.closed_forms import FORMS, LAWS, WITHOUT, form_of
from support.sweeps import sample, sweep

SPEEDS = np.array([1e-3, 0.03, 0.2, 0.5, 1.0, 3.0])


@sample(12)
@pytest.mark.parametrize("name", LAWS)
def test_is_described_and_sensible(name):
    law = ss.laws.catalogue[name]
    assert law.name == name
    assert law.source
    assert law.validity
    for parameter in law.parameters.values():
        assert parameter.meaning
        assert parameter.unit
        assert parameter.typical
    law = law.typical()
    assert np.all(law.mu(SPEEDS) >= 0)
    assert law.onset >= 0
    assert law.mu(1e-12) == pytest.approx(law.onset, abs=1e-6)
    assert law.slope(0.0) == pytest.approx(law.slope(1e-12), abs=1e-4, rel=1e-4)


@sample(3)
@sweep(
    ("name", "criterion"), FORMS,
    *[(name, criterion) for name in ("exponential", "logarithmic") for criterion in WITHOUT],
    ("arctangent", "least_squares"), ("polynomial", "harmonic"),
)  # fmt: skip
def test_a_closed_form_is_proved_agrees_with_the_definition_and_is_in_kg_per_s(name, criterion):
    """Enclosed at three speeds; by quadrature, which takes longer, at one."""
    form = form_of(name, criterion)
    assert form.verdict.status is ss.Status.PROVED
    assert form.expr == 0 or "digits at 12 random points" in form.verdict.evidence
    assert form.latex().startswith("c = ")
    assert repr(form) == f"ClosedForm: {name}, {criterion}, {form.verdict.status.value}"
    law = ss.laws.catalogue[name].typical()
    values = {key: float(value) for key, value in law.values.items()}
    speeds = [0.02, 0.5, 4.0]
    got = form(V=speeds, N=9.81, **values)
    exact = [float(ss.enclose(law, criterion, V=speed, N=9.81, digits=18)) for speed in speeds]
    exact.append(float(ss.quadrature.damping(law, criterion, V=speeds[1], N=9.81, digits=18)))
    # Typical values as floats differ in the input.
    assert [*got, got[1]] == pytest.approx(exact, rel=1e-8, abs=1e-12)
    if criterion == "harmonic":  # as V -> 0 every criterion becomes -N mu'(0+), where that is finite
        slope = law.slope(0.0)
        slow = float(form.evaluate(15, V="1e-9", N=1, **law.values))
        assert slow == pytest.approx(-slope, abs=1e-5 * (abs(slope) or 1.0))
    units = {p.symbol: p.unit for p in form.law.parameters.values()} | {symbols.V: "m/s", symbols.N: "N"}
    point = {p.symbol: sp.Rational(p.typical) for p in form.law.parameters.values()}
    point |= {symbols.V: sp.Rational(1, 2), symbols.N: sp.Integer(2)}
    sizes = {parse_unit(unit): sp.Rational(n, 7) for n, unit in enumerate(("m", "s", "kg"), 3)}
    scaled = sp.N(multiply_by_units(form.expr, units).xreplace(point | sizes), 20)
    plain = sp.N(form.expr.xreplace(point), 20) * sizes[parse_unit("kg")] / sizes[parse_unit("s")]
    assert abs(scaled - plain) < 1e-12 * max(1, abs(plain))


@sweep(
    ("name", "criterion"), [(name, criterion) for criterion, names in WITHOUT.items() for name in sorted(names)],
    ("sech", "harmonic"), ("andersson", "least_squares"),
)  # fmt: skip
def test_refuses_honestly(name, criterion):
    with pytest.raises(ss.NoClosedForm, match=r"the term .* has no closed form that is known here.*Take the"):
        form_of(name, criterion)
    law = ss.laws.catalogue[name].typical()
    assert mpmath.isfinite(ss.quadrature.damping(law, criterion, V=0.5, N=9.81, digits=15))


HARMONIC_BY_HAND = {
    "exponential": lambda V, N, mu_s, mu_m, a: 2 * N * (mu_s - mu_m) * sp.exp(-a * V) * sp.besseli(1, a * V) / V,
    "polynomial": lambda V, N, mu_s, mu_m, v_m: N * (mu_s - mu_m) * (12 * v_m**2 - 15 * V**2) / (8 * v_m**3),
    "hyperbolic": lambda V, N, mu_s, mu_m, v_s: (
        2 * N * (mu_s - mu_m) / V * (1 + V / v_s - sp.sqrt(1 + 2 * V / v_s)) / (V / v_s * sp.sqrt(1 + 2 * V / v_s))
    ),
}


@pytest.mark.parametrize("name", HARMONIC_BY_HAND)
def test_harmonic_forms_are_the_textbook_s(name):
    form = form_of(name, "harmonic")
    by_hand = HARMONIC_BY_HAND[name](*form.arguments.values())
    # A common number taken out of a bracket counts as one operation more.
    assert form.expr.count_ops() <= by_hand.count_ops() + 1
    for n in range(1, 6):
        point = {symbol: sp.Rational(3 * n + i, 7) for i, symbol in enumerate(form.arguments.values())}
        assert abs(sp.N((form.expr - by_hand).xreplace(point), 30)) < 1e-25


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
