"""``stickslip fit``: files of three instruments to ranked laws, and five broken ones to an error with the row."""

import numpy as np
import pytest
from commands import read_json, run

import stickslip_sym as ss

LAWS = ["exponential", "gaussian", "linear"]


def points(rng):
    """Speeds that repeat, and coefficients, as decimals."""
    v = np.repeat(np.round(np.geomspace(0.005, 1.5, 30), 4), 2)
    return v, np.round(ss.laws.exponential.typical().mu(v) + 0.005 * rng.normal(size=60), 4)


def instruments():
    """The same friction as three instruments write it."""
    rng = np.random.default_rng(7)
    v, mu = points(rng)
    way = rng.choice([-1, 1], 60)
    shuffled = rng.permutation(60)
    comma = "v [m/s],mu\n" + "".join(f"{a},{b}\n" for a, b in zip(v, mu, strict=True))
    semicolon = "\ufeffReibwert;Gleitgeschwindigkeit [mm/s]\r\n" + "".join(
        f"{mu[i]};{1000 * v[i]:.1f}\r\n".replace(".", ",") for i in shuffled
    )
    forces = "# disc 7\ntime [s]\tspeed (m/min)\tF_t [N]\tF_n [kN]\n" + "".join(
        f"{i}\t{way[i] * v[i] * 60:.6g}\t{way[i] * mu[i] * 20:.6g}\t0.02\n" for i in range(60)
    )
    return {"comma": comma, "semicolon": semicolon, "forces": forces}


@pytest.mark.parametrize("name", ["comma", "semicolon", "forces"])
def test_three_instruments_give_the_same_fit(name, tmp_path, monkeypatch, capsys):
    path = tmp_path / f"{name}.csv"
    path.write_text(instruments()[name], encoding="utf-8", newline="")
    code, out, err = run(
        monkeypatch, capsys, "fit", str(path), *(word for law in LAWS for word in ("--law", law)), "--json"
    )
    assert (code, err) == (0, "")
    found = read_json(out)
    assert found["measured"].startswith("60 rows, v in ")
    best = found["fits"][0]
    assert best["law"] == "exponential"
    values = {key: parameter["value"] for key, parameter in best["parameters"].items()}
    assert values == pytest.approx(
        ss.fit(*points(np.random.default_rng(7)), laws="exponential").best.values, rel=1e-5
    )
    low, high = best["parameters"]["alpha"]["confidence_95"]
    assert low < 3 < high


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("0.0061,", "0.0061;"), "line 4, column 1: the row has 1 column,"),
        (
            ("v [m/s]", "v [rpm]"),
            "rpm is a rotational speed; give the radius of the track in m, like --radius",
        ),
        ((",mu\n", ",load [N]\n"), "line 1: no column is mu, or F_t and F_n; understood: 'v [m/s]' as v"),
        (("1.5,", "1.5,n/a "), "column 2, 'mu': a finite number is needed, like 0.35; got 'n/a"),
        (("1.0122,", "1,0122,"), "the row has 3 columns, and the header 2"),
    ],
)
def test_five_broken_files_are_refused_with_the_row(change, message, tmp_path, monkeypatch, capsys):
    text = instruments()["comma"]
    assert change[0] in text
    (tmp_path / "a.csv").write_text(text.replace(*change, 1))
    for command in (["fit", str(tmp_path / "a.csv")], ["damping", "--from-csv", str(tmp_path / "a.csv")]):
        code, out, err = run(monkeypatch, capsys, *command)
        assert (code, out) == (2, "")
        assert message in err
        assert "line " in err


def test_a_fit_is_printed_drawn_and_fixed(tmp_path, monkeypatch, capsys):
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "disc.csv").write_text(instruments()["comma"])
    laws = [word for law in ("exponential", "stribeck", "a + b/(d + v)") for word in ("--law", law)]
    line = ["fit", "disc.csv", *laws, "-p", "delta=1", "--plot", "fit.svg"]
    code, out, err = run(monkeypatch, capsys, *line, "--profile")
    assert (code, err) == (0, "")
    assert out.startswith("60 rows, v in m/s, mu from column 2\n\nlaw ")
    assert "95 % intervals from the sum of squares" in out
    assert "delta =" not in out
    assert (tmp_path / "fit.svg").is_file()


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("--law exponental", "did you mean 'exponential'"),
        ("--law linear -p beta=1", "no law that is fitted has a parameter 'beta'; leave -p beta=... out"),
        ("--law linear --unit a=m", "--unit does nothing here"),
        ("--law a*b*(1+v)", "do not tell a and b apart; fix one: -p "),
    ],
)
def test_what_cannot_be_fitted_is_told_in_options(line, message, tmp_path, monkeypatch, capsys):
    (tmp_path / "a.csv").write_text(instruments()["comma"])
    code, out, err = run(monkeypatch, capsys, "fit", str(tmp_path / "a.csv"), *line.split())
    assert (code, out) == (2, "")
    assert message in err
