"""Closed forms and laws saved and loaded: what comes back is derived again, and nothing else is taken."""

import hashlib
import json
import random
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp
from sweeps import sweep
from uncertainties import correlated_values

import stickslip_sym as ss
from stickslip_sym import criteria

LAWS = ["exponential", "polynomial", "tanh", "rational", "a*sech(v/w)"]


def rewrite(path, part, **changes):
    """Change an item of a file, or the file itself, and its digest with it."""
    content = json.loads(path.read_text())
    (content if part is None else content["items"][part]).update(changes)
    del content["digest"]
    content["digest"] = hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
    path.write_text(json.dumps(content))


def saved(law, criterion, tmp_path):
    form = ss.derive(law, criterion)
    path = tmp_path / "form.json"
    ss.save(form, path)
    return form, path


@sweep("name", LAWS, 0, 2, 4)
def test_a_form_and_its_sensitivity_come_back(name, tmp_path):
    form = ss.derive(ss.laws.catalogue[name].typical() if name in ss.laws.catalogue else name)
    forms = form, form.sensitivity(list(form.law.parameters)[-1])
    ss.save(forms, tmp_path / "forms.json")
    for again, before in zip(ss.load(tmp_path / "forms.json"), forms, strict=True):
        assert (again.law, again.criterion, again.terms) == (before.law, before.criterion, before.terms)
        assert (again.expr, again.verdict) == (before.expr, before.verdict)
        assert again.derivation.text() == before.derivation.text()


def test_standard_errors_and_correlations_come_back(tmp_path):
    rng = np.random.default_rng(6)
    point = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}
    free = ss.laws.exponential.typical(mu_s="0.531(7)", alpha="2.90+/-0.25")  # exact, and not doubles
    half = rng.normal(size=(3, 3)) * 0.02
    fitted = ss.laws.exponential.bind(
        **dict(zip(("mu_s", "mu_m", "alpha"), correlated_values([0.5, 0.2, 3.0], half @ half.T), strict=True))
    )
    path = tmp_path / "law.json"
    for law in (free, fitted):
        ss.save(law, path)
        again = ss.load(path)
        assert (again.values, again.uncertain.keys()) == (law.values, law.uncertain.keys())
        before, after = (ss.pure_slip_damping(one, **point, method="orbit").budget for one in (law, again))
        assert after.uncertainty == pytest.approx(before.uncertainty, rel=1e-12)
        assert len(after.correlated) == len(before.correlated) == (3 if law is fitted else 0)
        content = json.loads(path.read_text())["items"][0]["law"]
        for wrong in ({"standard": {"mu_s": -1.0}}, {"standard": {"b": 1.0}}, {"correlation": [[1.0]]}):
            rewrite(path, 0, law=content | {"errors": content["errors"] | wrong})
            with pytest.raises(ss.InputError, match=r"standard error|lacks a part|one has another shape"):
                ss.load(path)


def test_several_items_of_every_kind_come_back(tmp_path):
    sampled = ss.FrictionLaw.from_samples([0, 0.1, 0.3, 1.2], ["0.5", "0.4", "0.3", "0.25"], source="bench 4")
    s = ss.symbols.s
    early = ss.Criterion("early", sp.Rational(3, 4) * (1 - s**2) * (1 - s), "low slip speeds")
    items = [ss.derive(sampled, "equilibrium"), sampled, ss.derive(ss.laws.linear, early)]
    ss.save(items, tmp_path / "items.json")
    form, law, other = ss.load(tmp_path / "items.json")
    assert (form.law.v_max, law.expr, law.source) == (sampled.v_max, sampled.expr, "bench 4")
    assert form(V=0.5, N=3.0) == items[0](V=0.5, N=3.0)
    assert (other.criterion, other.expr) == (early, items[2].expr)


def test_fits_come_back_and_are_fitted_again(tmp_path):
    v = np.linspace(0.01, 1, 40)
    mu = 0.2 + 0.3 * np.exp(-3 * v) + 0.005 * np.cos(50 * v)
    fits, path = ss.fit(v, mu, 0.004, laws=["exponential", "gaussian", "coulomb"]), tmp_path / "fits.json"
    for kept in (fits, fits["gaussian"]):
        ss.save(kept, path)
        read = ss.load(path)
        assert (type(read), read.to_json()) == (type(kept), kept.to_json())
        assert read.measured.mu.tolist() == mu.tolist()
    path.write_text(path.read_text().replace(json.dumps(fits["gaussian"].values["v_s"]), "0.7"))
    rewrite(path, None)
    with pytest.raises(ss.InputError, match=r"v_s = 0\.7 of the law gaussian is not that of its measurements"):
        ss.load(path)


def test_a_form_with_another_coefficient_is_not_saved_for_the_law(tmp_path):
    form = ss.derive(ss.laws.exponential)
    constant, term = form.terms
    ss.save(replace(form, terms=(constant, replace(term, amplitude=2 * term.amplitude))), tmp_path / "form.json")
    with pytest.raises(ss.InputError, match="its formula is"):
        ss.load(tmp_path / "form.json")


@pytest.mark.parametrize(
    ("part", "changed"), [('"N*a_1"', '"2*N*a_1"'), ('"a_1"', '"a_1 "'), ('"0.15"', '"0.16"')]
)
def test_a_file_changed_by_hand_is_noticed(part, changed, tmp_path):
    _, path = saved(ss.laws.linear, "least_squares", tmp_path)
    assert part in path.read_text()
    path.write_text(path.read_text().replace(part, changed))
    with pytest.raises(ss.InputError, match="was changed since it was saved; derive the form again"):
        ss.load(path)


KINKED = ss.FrictionLaw("mu_0 + b*Abs(v - v_1)")
REFUSED = [
    *((ss.laws.linear, "equilibrium", part, change, message) for part, change, message in (
        (None, {"version": 1}, "is of version 1, and this package reads version 2"),
        (None, {"version": True}, "is of version True"),
        (None, {"format": "other"}, "holds no closed form and no law"),
        (None, {"items": None}, "lacks a part, or one has another shape"),
        (0, {"criterion": "harmonics"}, "there is no criterion 'harmonics'"),
        (0, {"criterion": {"name": "a", "weight": ["1"], "source": ""}}, "an average needs 1"),
        (0, {"law": None}, "lacks a part"),
        (0, {"formula": None}, "its formula is 'None'"),
    )),
    *((ss.laws.linear, "least_squares", 0, {"formula": wrong}, r"its formula is .* of its law .* 'N\*a_1'")
      for wrong in ("42*V", "N*a_1*1.0000000000000000000001", "__import__('os')")),
    (KINKED, "harmonic", 0, {"status": "PROVED"}, "its status is 'PROVED', .* 'CHECKED'"),
]  # fmt: skip
"""A form, what is changed in its file, of which the digest is computed anew, and what is said of it."""


@pytest.mark.parametrize(("law", "criterion", "part", "change", "message"), REFUSED)
def test_a_file_with_another_claim_is_refused(law, criterion, part, change, message, tmp_path):
    """A verdict is computed, and not believed."""
    form, path = saved(law, criterion, tmp_path)
    assert ss.load(path).verdict == form.verdict
    rewrite(path, part, **change)
    with pytest.raises(ss.InputError, match=message):
        ss.load(path)


def test_a_damaged_file_never_does_anything_else_than_load_or_refuse(tmp_path):
    """What is no JSON, and 300 seeded cuts and changes of single characters."""
    rng = random.Random(4)
    _, path = saved(ss.laws.exponential.typical(), "least_squares", tmp_path)
    whole = path.read_text()
    texts = ["", "{", "[]", "[" * 100_000, "\x00", '{"format": 1e999}']
    for _ in range(300):
        place = rng.randrange(len(whole))
        texts.append(whole[:place] + rng.choice(["", "9", '"', "]", "V", "\u0663"]) + whole[place + 1 :])
    refused = 0
    for text in texts:
        path.write_text(text)
        try:
            ss.load(path)
        except ss.InputError:
            refused += 1
    assert refused > 256  # the others changed a blank, or a character to itself


def test_a_notebook_names_the_law_of_a_form_or_shows_it():
    law = ss.laws.catalogue["linear"]
    assert ss.derive(law, "equilibrium")._repr_html_().count(law.text) == 0
    assert law.name in ss.derive(law, "equilibrium")._repr_html_()
    assert "p - q*v, equilibrium" in ss.derive(ss.FrictionLaw("p - q*v"), "equilibrium")._repr_html_()
    assert criteria.find("equilibrium") is criteria.equilibrium
