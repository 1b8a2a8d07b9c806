"""Laws that end, or may have a pole: closed forms with a condition, continued from the sign that has none."""

import random

import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym.core import symbols
from stickslip_sym.criteria.criterion import find
from stickslip_sym.formula.average import Continued, average_of_profile
from stickslip_sym.formula.proof.recurrence import definition
from support.sweeps import sample, sweep

RNG = random.Random(4009)
LAWS = {
    "(1-sigma)/(1+2*a*v/(1-sigma))": {"sigma": (0.1, 0.9), "a": (0.2, 3)},
    "mu_0/(1+v/(v_1-v_2))": {"mu_0": (0.2, 0.5), "v_1": (0.2, 1), "v_2": (1.5, 3)},
    "mu_0/(1-a*v)": {"mu_0": (0.2, 0.5), "a": (0.1, 3)},
    "log(2-a*v)": {"a": (0.1, 3)},
    "1/((1+b*v)*(1-a*v))": {"a": (0.1, 3), "b": (0.1, 3)},
}


@sample(3)
@sweep(
    ("law", "criterion"),
    [(law, criterion) for law in LAWS for criterion in ("least_squares", "harmonic")],
    *((law, ("least_squares", "harmonic")[number % 2]) for number, law in enumerate(LAWS)),
)
def test_a_closed_form_holds_where_its_condition_does(law, criterion):
    form = ss.derive(law, criterion)
    assert form.verdict.status is ss.Status.PROVED
    assert " i" not in form.latex()
    assert ">" in form.latex()
    values = {name: round(RNG.uniform(*ends), 3) for name, ends in LAWS[law].items()}
    bound = ss.FrictionLaw(law).bind(**values)
    end = min(
        float(sp.solve(relation.lts - relation.gts, symbols.V)[0].subs(bound.point)) for relation in form.domain
    )
    inside, beyond = end if end > 0 else 5.0, end
    V = round(0.6 * inside, 6)
    exact = float(ss.enclose(bound, criterion, V=V, N=1))
    assert form(V=V, N=1.0, **values) == pytest.approx(exact, rel=1e-13)
    assert float(form.evaluate(20, V=V, N=1, **values)) == pytest.approx(exact, rel=1e-15)
    if beyond > 0:
        for refused in (form.evaluate, form):
            with pytest.raises(ss.InputError, match="needs mu up to"):
                refused(V=1.2 * beyond, N=1, **values)


def test_what_is_not_analytic_is_not_continued():
    """|r - 1| is 1 - r for r < 1, and not beyond: a formula with it is refused by the theorem."""
    average = average_of_profile(1 / (1 - symbols.v), find("harmonic"))
    continued = Continued(average)
    integral = definition(average.profile, average.criterion)
    assert continued(integral) == average.find()
    (rate,) = continued.positive.values()
    wrong = continued._formula * sp.Abs(sp.Symbol("r", real=True)).subs(sp.Symbol("r", real=True), rate - 1)
    continued.__class__ = type("Altered", (Continued,), {"_formula": wrong})
    with pytest.raises(ValueError, match="analytic"):
        continued(integral)
