"""Closed forms saved and loaded."""

import hashlib
import json
import random

import numpy as np
import pytest
import sympy as sp
from uncertainties import correlated_values

import stickslip_sym as ss
from stickslip_sym import criteria
from stickslip_sym.model.trees import from_tree, to_tree

LAWS = ["exponential", "polynomial", "gaussian", "tanh", "sech", "rational", "bengisu_akay"]


def rewrite(path, **changes):
    """Change parts of a file, and its digest with them."""
    content = json.loads(path.read_text()) | changes
    del content["digest"]
    content["digest"] = hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
    path.write_text(json.dumps(content))


def kept(law, criterion, tmp_path):
    form = ss.derive(law, criterion)
    path = tmp_path / "form.json"
    ss.save(form, path)
    return form, path


@pytest.mark.parametrize("name", LAWS)
def test_a_form_comes_back_as_it_was(name, tmp_path):
    form, path = kept(ss.laws.catalogue[name].typical(), "least_squares", tmp_path)
    again = ss.load(path)
    assert again.expr == form.expr
    assert again.criterion is form.criterion
    assert again.law.expr == form.law.expr
    assert again.law.values == form.law.values
    assert {n: vars(p) for n, p in again.law.parameters.items()} == {
        n: vars(p) for n, p in form.law.parameters.items()
    }
    assert again.derivation.text() == form.derivation.text()
    assert [step.statement for step in again.derivation.steps] == [s.statement for s in form.derivation.steps]
    assert (again.verdict, again.gate) == (form.verdict, form.gate)
    assert again.evaluate(30, V="0.3", N=2) == form.evaluate(30, V="0.3", N=2)


def test_standard_errors_and_correlations_come_back(tmp_path):
    rng = np.random.default_rng(6)
    scene = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}
    free = ss.laws.exponential.typical(mu_s="0.531(7)", alpha="2.90+/-0.25")  # exact, and not doubles
    half = rng.normal(size=(3, 3)) * 0.02
    fitted = ss.laws.exponential.bind(
        **dict(zip(("mu_s", "mu_m", "alpha"), correlated_values([0.5, 0.2, 3.0], half @ half.T), strict=True))
    )
    for law in (free, fitted):
        _, path = kept(law, "equilibrium", tmp_path)
        again = ss.load(path).law
        assert (again.values, again.uncertain.keys()) == (law.values, law.uncertain.keys())
        before, after = (ss.pure_slip_damping(one, **scene, method="orbit").budget for one in (law, again))
        assert after.uncertainty == pytest.approx(before.uncertainty, rel=1e-12)
        assert after.shares == pytest.approx(before.shares, rel=1e-12)
        assert len(after.correlated) == len(before.correlated) == (3 if law is fitted else 0)
        content = json.loads(path.read_text())["law"]
        for wrong in ({"standard": {"mu_s": -1.0}}, {"standard": {"b": 1.0}}, {"correlation": [[1.0]]}):
            rewrite(path, law=content | {"errors": content["errors"] | wrong})
            with pytest.raises(ss.InputError, match=r"standard error|lacks a part|one has another shape"):
                ss.load(path)


@pytest.mark.parametrize("criterion", list(criteria.catalogue))
def test_a_sampled_law_comes_back_too(criterion, tmp_path):
    law = ss.FrictionLaw.from_samples([0, 0.1, 0.3, 1.2], ["0.5", "0.4", "0.3", "0.25"], source="bench 4")
    form, path = kept(law, criterion, tmp_path)
    again = ss.load(path, verify=True)
    assert (again.expr, again.law.expr, again.law.v_max, again.law.source) == (
        form.expr,
        law.expr,
        law.v_max,
        "bench 4",
    )
    assert again(V=0.5, N=3.0) == form(V=0.5, N=3.0)


def test_verification_is_done_again_on_demand(tmp_path):
    form, path = kept(ss.laws.exponential, "harmonic", tmp_path)
    assert ss.load(path, verify=True).gate == form.gate
    wrong = form.expr * (1 + sp.Rational(1, 10**20))
    rewrite(path, formula=to_tree(wrong))
    assert ss.load(path).expr == wrong
    with pytest.raises(ss.NoClosedForm, match="the formula in the file is refuted"):
        ss.load(path, verify=True)


@pytest.mark.parametrize(
    ("part", "changed"),
    [("c = N*a_1", "c = 2*N*a_1"), ('"least_squares"', '"harmonic"'), ('"a_1"', '"a_1 "'), ('"0.15"', '"0.16"')],
)
def test_a_file_changed_by_hand_is_noticed(part, changed, tmp_path):
    _, path = kept(ss.laws.catalogue["linear"], "least_squares", tmp_path)
    assert part in path.read_text()
    path.write_text(path.read_text().replace(part, changed))
    with pytest.raises(ss.InputError, match="was changed since it was saved; derive the form again"):
        ss.load(path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"version": 2}, "is of version 2, and this package reads version 1"),
        ({"format": "other"}, "is no stickslip_sym closed form"),
        ({"criterion": "harmonics"}, "there is no criterion 'harmonics'"),
        ({"law": None}, "lacks a part"),
        ({"formula": ["__import__", "os"]}, "this is no part of an expression"),
        ({"formula": ["*", "N", "__class__"]}, "'__class__' is neither a number nor a name"),
        ({"formula": ["^", ["^", "10", "100"], "100"]}, "a number is a power of a power"),
        ({"formula": ["+", "N", ["piece", "true", "true"]]}, r"piece cannot have these arguments|\+ cannot have"),
        ({"formula": ["+", "N", ["tuple", "N"]]}, r"\+ cannot have these arguments"),
        ({"version": True}, "is of version True"),
        ({"derivation": {"name": "a", "title": "b", "steps": []}}, "its derivation has no steps"),
        ({"formula": ["^", "10", "9999999999"]}, "at most 100 is read"),
        ({"formula": ["lowergamma", "100000", "V"]}, "at most 100 is read"),
        ({"formula": ["exp", "V", "N", "V"]}, "exp cannot have these arguments"),
        ({"formula": ["+"] + ["V"] * 300_000}, "over 200000 parts"),
        ({"formula": "1/0"}, "neither a number nor a name"),
        ({"formula": "9" * 5000}, "neither a number nor a name"),
        ({"gate": {"status": "TRUSTED", "evidence": ""}}, "lacks a part, or one has another shape"),
        ({"gate": {"status": "REFUTED", "evidence": ""}}, "it is marked as refuted"),
    ],
)
def test_what_is_no_closed_form_is_refused(change, message, tmp_path):
    _, path = kept(ss.laws.catalogue["linear"], "equilibrium", tmp_path)
    rewrite(path, **change)
    with pytest.raises(ss.InputError, match=message):
        ss.load(path)


@pytest.mark.parametrize("text", ["", "{", "[]", "[" * 100_000, "\x00", '{"format": 1e999}'])
def test_what_is_no_json_is_refused(text, tmp_path):
    path = tmp_path / "form.json"
    path.write_text(text)
    with pytest.raises(ss.InputError):
        ss.load(path)


def test_a_damaged_file_never_does_anything_else_than_load_or_refuse(tmp_path):
    """300 seeded cuts and changes of single characters."""
    rng = random.Random(4)
    _, path = kept(ss.laws.exponential.typical(), "least_squares", tmp_path)
    whole = path.read_text()
    refused = 0
    for _ in range(300):
        place = rng.randrange(len(whole))
        damaged = whole[:place] + rng.choice(["", "9", '"', "]", "V", "\u0663"]) + whole[place + 1 :]
        path.write_text(damaged)
        try:
            ss.load(path)
        except ss.InputError:
            refused += 1
    assert refused > 250  # the others changed a blank, or a character to itself


def test_a_tree_is_exact_for_every_part_of_a_law_in_pieces():
    law = ss.FrictionLaw("Piecewise((a*v^2, v < 1/3), (Max(a, b), v < 2), tanh(v)*sqrt(b))")
    names = {name: parameter.symbol for name, parameter in law.parameters.items()}
    assert from_tree(to_tree(law.expr), names) == law.expr
    with pytest.raises(ss.InputError, match="no written form"):
        to_tree(sp.Function("f")(ss.symbols.V))


def test_a_collection_says_that_it_is_one(tmp_path):
    path = tmp_path / "forms.json"
    ss.save_all([ss.derive(ss.laws.catalogue["linear"], "equilibrium")], path)
    content = json.loads(path.read_text())
    (form,) = ss.load_all(path)
    assert form.criterion is criteria.equilibrium
    for change in ({"format": "other"}, {"forms": {}}, {"format": None, "forms": None}):
        path.write_text(json.dumps(content | change))
        with pytest.raises(ss.InputError, match="holds no stickslip_sym closed forms"):
            ss.load_all(path)


def test_a_notebook_names_the_law_of_a_form_or_shows_it():
    law = ss.laws.catalogue["linear"]
    assert ss.derive(law, "equilibrium")._repr_html_().count(law.text) == 0
    assert law.name in ss.derive(law, "equilibrium")._repr_html_()
    assert "p - q*v, equilibrium" in ss.derive(ss.FrictionLaw("p - q*v"), "equilibrium")._repr_html_()
