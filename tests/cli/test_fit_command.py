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


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("0.0061,", "0.0061;"), "line 4, column 1: the row has 1 column,"),
        (("v [m/s]", "v [rpm]"), "rpm is a rotational speed; give the radius of the track in m, like --radius"),
        ((",mu\n", ",load [N]\n"), "line 1: got 'v [m/s],load [N]'; a table begins with a header"),
        (("1.5,", "1.5,n/a "), "column 2, 'mu': a finite number is needed, like 0.35"),
        (("0.0061,", "0.0061,-999,"), "mend the row, begin it with #, or leave out rows like it: --leave-out"),
    ],
)
def test_broken_files_are_refused_with_the_row(change, message, tmp_path, run):
    assert change[0] in TEXT
    (tmp_path / "a.csv").write_text(TEXT.replace(*change, 1))
    for command in (["fit", "a.csv"], ["damping", "--from-csv", "a.csv"]):
        code, out, err = run(*command)
        assert (code, out) == (2, "")
        assert message in err
        assert "line " in err


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
