"""``stickslip fit``: a file to ranked laws, and broken ones to an error with the row, in the words of options."""

import numpy as np
import pytest
from commands import read_json

import stickslip_sym as ss


def written(rng):
    """Speeds that repeat, and coefficients, as decimals, and the file of them."""
    v = np.repeat(np.round(np.geomspace(0.005, 1.5, 30), 4), 2)
    mu = np.round(ss.laws.exponential.typical().mu(v) + 0.005 * rng.normal(size=60), 4)
    return v, mu, "v [m/s],mu\n" + "".join(f"{a},{b}\n" for a, b in zip(v, mu, strict=True))


V, MU, TEXT = written(np.random.default_rng(7))


def test_a_file_gives_the_fit_of_its_numbers(tmp_path, run):
    (tmp_path / "disc.csv").write_text(TEXT)
    code, out, err = run("fit", "disc.csv", "--law", "exponential", "--law", "linear", "--json")
    assert (code, err) == (0, "")
    found, fit = read_json(out)["fits"], ss.fit(V, MU, laws="exponential").best
    best = found["fits"][0]
    assert best["law"]["name"] == "exponential"
    assert found["measured"]["understood"] == "60 rows, v in m/s, mu from column 2"
    for name, value in best["values"].items():
        assert value == pytest.approx(fit.values[name], rel=1e-9)
        assert best["confidence"][name] == pytest.approx(fit.confidence()[name], rel=1e-9)


def test_a_fit_is_printed_drawn_and_fixed(tmp_path, run):
    pytest.importorskip("matplotlib")
    (tmp_path / "disc.csv").write_text(TEXT)
    laws = [word for law in ("exponential", "stribeck", "a + b/(d + v)") for word in ("--law", law)]
    line = ["fit", "disc.csv", *laws, "-p", "delta=1", "--plot", "fit.svg"]
    code, out, err = run(*line)
    assert (code, err) == (0, "")
    assert out.startswith("60 rows, v in m/s, mu from column 2\n\nlaw ")
    assert "delta =" not in out
    assert (tmp_path / "fit.svg").is_file()
