"""``stickslip critical``."""

import pytest
from commands import read_json


def test_critical_prints_every_value(run):
    code, out, err = run("critical", "alpha", "exponential", "-c", "2", "-V", "0.5", "--method", "harmonic")
    assert (code, err) == (0, "")
    assert [line.split(" (")[0] for line in out.splitlines()] == [
        "alpha = 1.168213768 s/m",
        "alpha = 9.145431583 s/m",
    ]
    _, out, _ = run("critical", "alpha", "exponential", "-c", "2", "--within", "5:20", "--json")
    (one,) = read_json(out)["values"]
    assert one["value"] == {"value": pytest.approx(9.145431583), "unit": "s/m"}
    assert one["sensitivity"]["c"] < 0 < one["sensitivity"]["mu_s"]
    _, out, _ = run("critical", "mu_s", "exponential", "-c", "2", "--within", "1:5")
    assert out == "there is no such value of mu_s\n"


def test_critical_all_prints_margins_and_a_probability(run):
    line = ("critical", "all", "linear", "-p", "a_1=0.30(3)", "-c", "3.2+/-0.1", "--method", "orbit")
    code, out, err = run(*line)
    assert (code, err) == (0, "")
    assert out.startswith("no stick-slip: c = 3.2 kg/s, pure-slip damping 2.94 +/- 0.29 kg/s (parameters)")
    assert "probability of stick-slip: 0.2" in out
    _, out, _ = run(*line, "--json")
    margins = {row["name"]: row["change"] for row in read_json(out)["margins"]}
    # c = N a_1 for a straight line, whatever else
    assert margins["a_1"] == margins["N"] == pytest.approx(3.2 / 2.943 - 1, rel=1e-6)
    assert margins["V"] is margins["m"] is margins["mu_s"] is None
    assert read_json(out)["stick_slip"] is False


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["N", "exponential"], "the damping is what all but c is sought for; give -c"),
        (["N", "exponential", "-c", "1", "-N", "2"], "N is what is sought; leave its value out"),
        (["alpha", "exponential", "-c", "1", "--within", "3"], "is not LOW:HIGH"),
        (["beta", "exponential", "-c", "1"], "there is no quantity or parameter 'beta'"),
    ],
)
def test_critical_refuses(run, arguments, message):
    code, out, err = run("critical", *arguments)
    assert (code, out) == (2, "")
    assert message in err
