"""``stickslip simulate``."""

import re
import sys
from pathlib import Path

import pytest

from stickslip_sym.motion.maps import motions


def test_simulate_prints_events_and_a_summary(run):
    code, out, err = run("simulate", "exponential", "-c", "1", "--t-end", "3")
    assert (code, err) == (0, "")
    header, first, second, *_ = out.splitlines()
    assert re.split(r"\s{2,}", header) == ["t in s", "x in m", "v in m/s", "event", "phase that begins"]
    assert re.split(r"\s{2,}", first) == ["0", "0", "0.5", "start", "stick"]
    assert re.split(r"\s{2,}", second)[:4] == ["0.0881", "0.04405", "0.5", "static friction gives way"]
    assert "outcome: finished, at t = 3 s, 10 events" in out
    assert "periods from slip to slip: 4, the last 0.651445008" in out


def test_simulate_takes_a_start_and_writes_files(run, tmp_path):
    code, out, _ = run(
        "simulate", "mu_0 - b*v", "-p", "mu_0=0.4", "-p", "b=0.1", "-V", "1/4", "-m", "2", "-k", "50", "-N", "3",
        "--x0", "0.1", "--v0=-0.5", "--t-end", "2", "--rtol", "1e-8", "--csv", "a.csv", "--plot", "a.png",
    )  # fmt: skip
    assert code == 0
    assert re.search(r"^0 +0\.1 +-0\.5 +start +slip, slower than the belt$", out, re.M)
    assert (tmp_path / "a.csv").read_text().startswith("t (s),x (m),v (m/s),phase\n0.0,0.1")
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


def test_long_tables_are_cut_and_limits_are_outcomes(run):
    _, out, _ = run("simulate", "exponential", "--t-end", "40")
    assert re.search(r"^and \d+ more events$", out, re.M)
    code, out, _ = run("simulate", "exponential", "-c", "1", "--t-end", "1e6", "--time-limit", "0.01")
    assert code == 0
    assert "outcome: time limit, at t = " in out
    _, out, _ = run("simulate", "exponential", "-c", "30", "--t-end", "100")
    assert "outcome: at rest, at t = 100 s" in out
    assert "fewer than two slips" in out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["exponential", "-V", "-0.5"], "mirror the scene"),
        (["exponential", "-m", "-1"], "m = -1 must be positive: it is the mass"),
        (["exponential", "-N", "-1"], "N = -1 must not be negative"),
        (["exponential", "--t-end", "0"], "t_end = 0 must be positive"),
        (["exponential", "--t-end", "nan"], "t_end"),
        (["exponential", "--x0", "here"], "x0 = 'here' is not a number"),
        (["exponential", "--rtol", "1"], "rtol = 1 is outside 1e-13 to 0.001"),
        (["exponential", "-c", "1", "-c", "2"], "-c is given twice; give it once"),
        (["exponential", "--x0", "1", "--x0", "2"], "--x0 is given twice"),
        (["exponential", "--csv", "missing/a.csv"], f"cannot write {str(Path('missing/a.csv'))!r}"),
        (["exponential", "--plot", "a.doc"], "cannot draw to 'a.doc'"),
        (["exponential", "--engine", "magic"], "there is no engine 'magic'"),
        (["a - v"], "no value for a"),
    ],
)
def test_bad_input_is_a_line_on_stderr(run, arguments, message):
    code, _, err = run("simulate", *arguments)
    assert code == 2
    assert err.startswith("error: ")
    assert message in err
    assert len(err.splitlines()) == 1


def test_help_has_an_example(run):
    code, out, _ = run("simulate", "--help")
    assert code == 0
    assert "Example: stickslip simulate " in out


@pytest.mark.parametrize(
    ("file", "message"),
    [
        (["--plot", "map.png"], "plots need matplotlib"),
        (["--csv", "none/map.csv"], "there is no folder 'none'"),
        (["--npz", "none/map.npz"], "there is no folder 'none'"),
    ],
)
def test_a_map_that_cannot_be_written_is_not_computed(run, monkeypatch, file, message):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    monkeypatch.setattr(motions, "motion_map", lambda *args, **kwargs: pytest.fail("computed in vain"))
    code, out, err = run("map", "exponential", "--x", "V=0.1:1:100", "--y", "c=0:6:100", *file)
    assert (code, out) == (2, "")
    assert message in err


def test_a_motion_that_grows_without_bound_is_written(run, tmp_path):
    code, out, err = run("simulate", "exponential", "-c", "-50", "--t-end", "100", "--csv", "a.csv")
    assert (code, err) == (0, "")
    assert "outcome: grows without bound, at t = 4.8" in out
    assert "a larger c" in out
    assert len((tmp_path / "a.csv").read_text().splitlines()) > 100
