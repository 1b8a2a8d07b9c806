"""Values where a closed form divides 0 by 0 or nearly so, from far below the scale of a law to far above it."""

import mpmath
import pytest

import stickslip_sym as ss
from stickslip_sym.core.symbols import v as ss_v
from support.accuracy import MOST_UNITS
from support.sweeps import sweep

EPS = 2.0**-52
SPEEDS = ("1e-9", "1e-5", "0.3", "5", "1e3", "1e9")
PLACES = {
    "a*(1 + v/w)^(-p)": ("p", ("1", "1.000000000001", "3", "4.000001")),
    "a*exp(-v)*(1 + v)^(-p)": ("p", ("1", "1.000000000001", "5")),
    "a*v^p*exp(-v/w)": ("p", ("1", "1.000000000001", "2")),
    "a*(exp(-v) - exp(-b*v))/v": ("b", ("1.000000000001", "1.000001")),
    "a/(1 + b*v + v^2)": ("b", ("2", "2.000000000001", "1.999999", "0.000000000001")),
    "a*exp(-v)*sin(b*v)": ("b", ("0.000000000001", "0.000001")),
}
"""Whole exponents, two rates that are equal, a discriminant or a coefficient of 0: where, and close to it."""
CASES = [(law, name, value) for law, (name, values) in PLACES.items() for value in values]


@sweep(("law", "name", "value"), CASES, ("a*(1 + v/w)^(-p)", "p", "1"), ("a/(1 + b*v + v^2)", "b", "2"))
def test_values_near_removable_points(law, name, value):
    form = ss.derive(law, search=False)
    others = {key: "1" for key in form.law.parameters if key != name}
    floats = {key: float(text) for key, text in (others | {name: value}).items()}
    bound = form.law.bind(**floats)
    for V in map(float, SPEEDS):
        exact = form.evaluate(25, V=V, N=1, **floats)
        enclosed = ss.enclose(bound, form.criterion, V=V, N=1, digits=20).mid
        assert abs(exact / (mpmath.mpf(enclosed.numerator) / enclosed.denominator) - 1) < 1e-18
        ordered = [V, 1.0, *(floats[key] for key in form.law.parameters)]
        unit = EPS * float(form._unit(ordered)[0])
        assert abs(form(V=V, N=1.0, **floats) - exact) <= MOST_UNITS * unit


ZEROS = ("0.3 + 0.2*exp(-v/0.1) + 0.05*v", "0.5 - 0.3*v + 0.1*v^3", "0.3 + 0.2/(1 + v/0.1) + 0.01*v^2",
         "0.3 + 0.1*exp(-v/0.3)*sin(v/0.1)")  # fmt: skip


@pytest.mark.parametrize("law", ZEROS)
def test_the_unit_of_errors_of_the_equilibrium_near_a_zero(law):
    """It is eps N times the sum of the |terms| of mu', which does not vanish where mu' does."""
    form = ss.derive(law, "equilibrium")
    low, high = 0.05, 5.0
    assert form.evaluate(20, V=low, N=1) * form.evaluate(20, V=high, N=1) < 0 or "sin" in law
    if "sin" in law:
        low, high = 0.1, 0.2
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if form(V=middle, N=1.0) * form(V=low, N=1.0) > 0 else (low, middle)
    slopes = [term.expr.diff(ss_v) for term in form.law.terms]
    sizes = sum(abs(float(part.subs(ss_v, low))) for slope in slopes for part in slope.expand().as_ordered_terms())
    for step in (0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3):
        V = low * (1 + step)
        assert abs(form(V=V, N=1.0) - form.evaluate(25, V=V, N=1)) <= MOST_UNITS * EPS * sizes
