"""Laws saved and loaded: what comes back is the equal law, and nothing else is taken."""

import hashlib
import json
import random

import numpy as np
import pytest
from uncertainties import correlated_values

import stickslip_sym as ss


def rewrite(path, part, **changes):
    """Change an item of a file, or the file itself, and its digest with it."""
    content = json.loads(path.read_text())
    (content if part is None else content["items"][part]).update(changes)
    del content["digest"]
    content["digest"] = hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
    path.write_text(json.dumps(content))


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


@pytest.mark.parametrize(
    ("part", "changed"), [('"mu_s - a_1*v"', '"mu_s - 2*a_1*v"'), ('"a_1"', '"a_1 "'), ('"0.15"', '"0.16"')]
)
def test_a_file_changed_by_hand_is_noticed(part, changed, tmp_path):
    path = tmp_path / "law.json"
    ss.save(ss.laws.linear, path)
    assert part in path.read_text()
    path.write_text(path.read_text().replace(part, changed))
    with pytest.raises(ss.InputError, match="was changed since it was saved; make the law again"):
        ss.load(path)


REFUSED = [
    (None, {"version": 1}, "is of version 1, and this package reads version 2"),
    (None, {"version": True}, "is of version True"),
    (None, {"format": "other"}, "holds no law"),
    (None, {"items": None}, "lacks a part, or one has another shape"),
    (0, {"kind": "closed form"}, "a closed form: laws alone are kept in files"),
    (0, {"law": None}, "lacks a part"),
]
"""What is changed in the file of a law, of which the digest is computed anew, and what is said of it."""


@pytest.mark.parametrize(("part", "change", "message"), REFUSED)
def test_a_file_of_another_shape_is_refused(part, change, message, tmp_path):
    path = tmp_path / "law.json"
    ss.save(ss.laws.linear, path)
    assert ss.load(path) == ss.laws.linear
    rewrite(path, part, **change)
    with pytest.raises(ss.InputError, match=message):
        ss.load(path)


def test_several_laws_come_back(tmp_path):
    sampled = ss.FrictionLaw.from_samples([0, 0.1, 0.3, 1.2], ["0.5", "0.4", "0.3", "0.25"], source="bench 4")
    laws = (sampled, ss.laws.exponential.typical(), ss.FrictionLaw("a*sech(v/w)", static="b"))
    ss.save(laws, tmp_path / "laws.json")
    assert ss.load(tmp_path / "laws.json") == laws


def test_a_damaged_file_never_does_anything_else_than_load_or_refuse(tmp_path):
    """What is no JSON, and 300 seeded cuts and changes of single characters."""
    rng = random.Random(4)
    path = tmp_path / "law.json"
    ss.save(ss.laws.exponential.typical(), path)
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
