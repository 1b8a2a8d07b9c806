"""The paper's equations (15) to (18), checked by the proof assistant Coq."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "derivations" / "certificates"
PROVED = {"least_squares": ("eq15", "eq16"), "exponential_law": ("eq17", "slope_average"),
          "polynomial_law": ("eq18", "transition_speed")}  # fmt: skip
CHANGED = {
    "least_squares": ("Definition a15 := 5 /", "Definition a15 := 4 /"),
    "exponential_law": ("(6 + 3 * (alpha * V) ^ 2)", "(6 + 2 * (alpha * V) ^ 2)"),
    "polynomial_law": ("21 * v_m ^ 2 - 26", "21 * v_m ^ 2 - 25"),
}
needs_coq = pytest.mark.skipif(shutil.which("coqc") is None, reason="no coqc here")


def accepts(text, folder):
    (folder / "proof.v").write_text(text, encoding="utf-8")
    return subprocess.run(["coqc", "-q", "proof.v"], cwd=folder, capture_output=True, text=True, timeout=600)


def test_every_proof_is_listed():
    assert {path.stem for path in FOLDER.glob("*.v")} == set(PROVED)


@needs_coq
@pytest.mark.parametrize("name", [pytest.param("least_squares", marks=pytest.mark.thorough),
                                  pytest.param("exponential_law", marks=pytest.mark.thorough),
                                  "polynomial_law"])  # fmt: skip
def test_coq_accepts_the_equations(name, tmp_path):
    text = (FOLDER / f"{name}.v").read_text(encoding="utf-8")
    assert not re.search("Admitted|Axiom|Parameter", text)
    assert all(f"Theorem {theorem} " in text for theorem in PROVED[name])
    done = accepts(text, tmp_path)
    assert done.returncode == 0, done.stderr


@needs_coq
@pytest.mark.thorough
@pytest.mark.parametrize("name", PROVED)
def test_coq_accepts_no_other_equations(name, tmp_path):
    text, (right, wrong) = (FOLDER / f"{name}.v").read_text(encoding="utf-8"), CHANGED[name]
    assert right in text
    assert accepts(text.replace(right, wrong, 1), tmp_path).returncode != 0
