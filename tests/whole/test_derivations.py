"""The derivations: all proved, and each refuted as soon as an equation is wrong."""

import re
from pathlib import Path

import pytest
import sympy as sp

from derivations import CERTIFICATES, CHAPTERS, chapter, paper
from derivations.d8_second_order import law_4
from stickslip_sym import InputError, Status, derive
from stickslip_sym.certificates.derivations import certificate_of_derivation
from stickslip_sym.core.symbols import N, V, a, c, k, m, mu, s, u
from stickslip_sym.formula.proof.proving import prove_equal, prove_positive
from stickslip_sym.formula.proof.theorems import Antiderivative, ChangeOfVariable
from support.sweeps import sample, sweep

PRINTED = paper.equations()
alpha, mu_s, mu_m = (paper.exponential[name] for name in ("alpha", "mu_s", "mu_m"))
v_m = paper.polynomial["v_m"]


@sweep("name", CHAPTERS, "least_squares")
def test_every_step_is_proved(name):
    """The page of the derivations says so of all of them, and is run by another test."""
    derivation = chapter(name)({})
    assert {step.verdict.status for step in derivation.steps} == {Status.PROVED}


TAKEN = {
    "energy_balance": ["(5)"], "linearised_force": ["(9)", "(10)", "(11)"], "exponential_law": ["(3)", "(17)"],
    "least_squares": ["(13)", "(15) a", "(15) b", "(16)"], "polynomial_law": ["(4)", "(18)"], "hopf": ["(4)"],
    "second_order": ["(4)"],
}  # fmt: skip
"""Printed equations that chapters hold; other errors in them are mutations of the paper's checks."""
TAMPERED = [
    *((name, label, -PRINTED[label]) for name, labels in TAKEN.items() for label in labels),
    ("exponential_law", "(17)", PRINTED["(17)"] * sp.exp(2 * alpha * V)),
    ("polynomial_law", "transition speed", sp.sqrt(sp.Rational(26, 21)) * v_m),
    ("one_threshold", "field", paper.velocity**2 / m),
    ("one_threshold", "P", (mu_s * N + c * V) / k),
    ("hopf", "A^2", 4 * (v_m**2 - V**2) - 4 * c * v_m**3 / (3 * N * (mu_s - mu_m))),
    ("units", "(17)", PRINTED["(17)"] / V),
    ("units", "(18)", PRINTED["(18)"] * v_m**2),
]  # fmt: skip
MORE_TAMPERED = [
    *((name, label, 2 * PRINTED[label]) for name, labels in TAKEN.items() for label in labels),
    ("second_order", "second order", law_4() - 2 * (law_4() - law_4().subs(m, sp.oo))),
]


@sample(6)
@sweep(("name", "label", "wrong"), TAMPERED + MORE_TAMPERED, *TAMPERED)
def test_a_tampered_equation_is_refuted_with_its_point(name, label, wrong):
    verdict = chapter(name)({label: wrong})[label].verdict
    assert verdict.status is Status.REFUTED
    assert verdict.point
    assert " at " in verdict.evidence


@sweep(
    "weight",
    [(1 + s**4) * 5 / 8, (1 - s**4) * 5 / 4, (1 - s**2) * 3 / 4, (s**4 - 1) * 5 / 8],
    (1 + s**4) * 5 / 8, (1 - s**2) * 3 / 4,
)  # fmt: skip
def test_another_weight_is_refuted(weight):
    derivation = chapter("slope_average")({"weight": weight})
    assert derivation["slope average"].verdict.status is Status.REFUTED


def test_a_refutation_holds_by_plain_numbers():
    wrong = PRINTED["(17)"].replace(sp.sinh, sp.cosh)
    verdict = prove_equal(PRINTED["(17)"], wrong)
    numbers = {key: float(value) for key, value in verdict.point.items()}
    left, right = (float(side.subs(numbers)) for side in (PRINTED["(17)"], wrong))
    assert abs(left - right) > 1e-6 * abs(left)


def test_an_unknown_equation_is_an_error():
    with pytest.raises(KeyError, match="no printed equation"):
        chapter("least_squares")({"(99)": a})


def test_theorems_check_their_hypotheses():
    wrong = Antiderivative(u**3, u)
    assert prove_equal(sp.Integral(u**2, (u, 0, V)), V**3, by=wrong).status is Status.REFUTED
    # True, but not by this theorem: checked at points, never called proved.
    whole = sp.Integral(mu(u), (u, 0, V))
    for unfit in (Antiderivative(u, u), ChangeOfVariable(u, s, V * s**2)):
        assert prove_equal(whole, whole, by=unfit).status is Status.CHECKED
    pole = Antiderivative(-1 / u, u)
    assert prove_equal(sp.Integral(1 / u**2, (u, 0, V)), -1 / V, by=pole).status is not Status.PROVED


def test_positivity():
    assert prove_positive(V**2 + 1).status is Status.PROVED
    refuted = prove_positive(V - N)
    assert refuted.status is Status.REFUTED
    assert refuted.point[V] <= refuted.point[N]
    # Positive, but not by the signs of its factors.
    assert prove_positive(V**2 - V + 1).status is Status.CHECKED


def test_text_and_latex_name_every_equation():
    derivation = chapter("least_squares")({})
    for label in ("(13)", "(14) a", "(15) b", "(16)"):
        assert label in derivation.text()
        assert f"\\tag*{{{label}}}" in derivation.latex()
    assert derivation.latex().count("\\begin{equation*}") == len(derivation.steps)
    assert "PROVED" in repr(derivation)


def test_the_linearisation_leaves_with_its_proof():
    """The page beside the derivations is made anew; a wrong sign is noticed, and what has no page says why."""
    pages = Path(__file__).parents[2] / "derivations" / "certificates"
    page = certificate_of_derivation(chapter("least_squares")({}))
    assert (pages / "least_squares.py").read_text(encoding="utf-8") == page
    for right, wrong, step in (
        ("(V - u, u))", "(V + u, u))", "step 1 (13)"),
        ("right_4 = 5 *", "right_4 = -5 *", "(15) a"),
        ("right_8 = 5 *", "right_8 = 10 *", "(16)"),
        ("sp.diff(right_2, a)", "-sp.diff(right_2, a)", "step 6"),
    ):
        assert right in page
        with pytest.raises(Exception, match=re.escape(step)):
            exec(page.replace(right, wrong, 1), {})
    with pytest.raises(InputError, match="no rule for PieceByPiece, which step 1 takes"):
        certificate_of_derivation(chapter("energy_balance")({}))
    wrong = {"(15) a": paper.equations()["(15) b"]}
    with pytest.raises(InputError, match="a certificate is for what is PROVED"):
        certificate_of_derivation(chapter("least_squares")(wrong))


@pytest.mark.parametrize(("law", "criterion"), CERTIFICATES)
def test_certificates_are_those_that_the_package_makes(law, criterion):
    """Made anew and compared; other tests run such scripts without the package."""
    page = Path(__file__).parents[2] / "derivations" / "certificates" / f"{law}_{criterion}.py"
    assert page.read_text(encoding="utf-8") == derive(law, criterion).certificate()
