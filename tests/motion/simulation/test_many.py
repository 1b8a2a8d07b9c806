"""Many initial conditions: each motion is the one that `simulate` and `classify` give for it alone."""

import csv
import os
import subprocess
import sys

import numpy as np
import pytest

import stickslip_sym as ss
from support.operating_points import paper_oscillator
from support.reference_motions import points

AGREES = 1e-7  # of the size of the motion, at rtol = 1e-10, where grazes carry errors on


def initial_conditions(osc, count, seed):
    rng = np.random.default_rng(seed)
    return rng.normal(size=count) * 2 * osc.length, osc.V * (1 + rng.normal(size=count) * 1.5)


def test_each_motion_is_that_of_simulate():
    stuck = 0
    for number, (kind, law, osc, _, _) in enumerate(points(8, seed=31)):
        x0, v0 = initial_conditions(osc, 12, number)  # as many as are compiled
        t_end = 25 / osc.omega
        many = ss.simulate(law, osc, x0=x0, v0=v0, t_end=t_end)
        for i in range(3):
            one = ss.simulate(law, osc, x0=x0[i], v0=v0[i], t_end=t_end)
            off = AGREES * (osc.length + np.ptp(one.x))
            sticks = one.starts_of(ss.Phase.STICK)
            expected = one.outcome, one.phase[-1], len(one.events) - 1, sticks.size
            assert (many.outcome[i], many.phase[i], many.changes[i], many.sticks[i]) == expected, kind
            assert many.x[i] == pytest.approx(one.x[-1], abs=off), kind
            assert many.v[i] == pytest.approx(one.v[-1], abs=off * osc.omega), kind
            if sticks.size:
                assert many.first_stick[i] == pytest.approx(sticks[0], abs=AGREES * t_end), kind
                stuck += 1
            x, v, _ = one.at(np.linspace(0, one.t[-1], 4001))
            assert many.x_min[i] <= x.min() + off, kind
            assert many.x_max[i] == pytest.approx(x.max(), abs=1e-3 * off / AGREES), kind
            assert many.v_min[i] == pytest.approx(v.min(), abs=1e-2 * off / AGREES * osc.omega), kind
            assert many.v_max[i] >= v.max() - off * osc.omega, kind
    assert stuck > 4


def test_motions_are_written_to_a_file(law, tmp_path):
    osc = paper_oscillator(1.0)
    many = ss.simulate(law, osc, x0=[0.0, 0.1, 0.2], v0=0.0, t_end=3.0)
    many.to_csv(tmp_path / "motions.csv")
    with open(tmp_path / "motions.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["x (m)"]) for row in rows] == pytest.approx(many.x.tolist())
    assert "3 initial conditions" in repr(many)
    assert many.count() == {"stick": 3}


def test_limits_end_motions_as_they_are(law):
    given = {"x0": [0.0, 0.2], "v0": 0.0, "t_end": 50.0}
    for limit, outcome in (("max_steps", ss.Outcome.STEP_LIMIT), ("time_limit", ss.Outcome.TIME_LIMIT)):
        found = ss.simulate(law, paper_oscillator(1.0), **given, **{limit: 10 if limit == "max_steps" else 0})
        assert set(found.outcome) == {outcome}


def test_a_time_limit_keeps_the_batches_that_are_done(law, monkeypatch):
    """The time is up after the first batch: its motions are as without a limit, and all others have not begun."""
    pytest.importorskip("numba")
    osc = paper_oscillator(1.0)
    x0, v0 = initial_conditions(osc, 9000, 5)
    whole = ss.simulate(law, osc, x0=x0, v0=v0, t_end=1.0)
    monkeypatch.setattr("stickslip_sym.motion.slip.is_late", lambda: True)
    late = ss.simulate(law, osc, x0=x0, v0=v0, t_end=1.0)
    left = late.outcome == ss.Outcome.TIME_LIMIT
    assert 0 < left.argmax() < left.sum() < left.size
    assert (late.t[left] == 0).all()
    assert late.x[left] == pytest.approx(x0[left], abs=1e-12)
    assert late.x[~left] == pytest.approx(whole.x[~left], abs=AGREES * osc.length)
    assert np.array_equal(late.sticks[~left], whole.sticks[~left])


DAMAGES = {"empty": b"", "text": b"no machine code", "bytes": bytes(range(256)) * 40, "half": None}
IN_DEFAULT = {("half", "nbi")}


@pytest.mark.parametrize(
    ("damage", "suffix"),
    [
        pytest.param(damage, suffix, marks=[] if (damage, suffix) in IN_DEFAULT else pytest.mark.thorough)
        for damage in DAMAGES
        for suffix in ("nbi", "nbc")
    ],
)
def test_damaged_machine_code_is_made_again(damage, suffix, tmp_path):
    """What the first run kept is damaged; the third one reads what the second one made; the first one says so."""
    pytest.importorskip("numba")
    (tmp_path / "twice.py").write_text(
        "from stickslip_sym.motion.compiled import compilable, compiled\n"
        "@compilable\ndef half(x):\n    return x / 2\n"
        "def quarter(x):\n    return half(half(x))\n"
        "print(compiled(quarter)(1.0))\n"
    )
    turns = (
        "import runpy, sys\n"
        "from pathlib import Path\n"
        "suffix, content = sys.argv[1], bytes.fromhex(sys.argv[2])\n"
        "from stickslip_sym.motion import compiled\n"
        "for turn in range(3):\n"
        "    compiled._say_once.cache_clear()\n"
        "    runpy.run_path('twice.py')\n"
        "    kept = {path: path.stat().st_mtime_ns for path in Path('kept').rglob(f'*.{suffix}')}\n"
        "    print(bool(kept), turn == 2 and kept == before)\n"
        "    before = kept\n"
        "    for path in kept if turn == 0 else ():\n"
        "        half = path.read_bytes()[: path.stat().st_size // 2]\n"
        "        path.write_bytes(half if len(sys.argv) > 3 else content)\n"
    )
    content = DAMAGES[damage]
    line = [sys.executable, "-c", turns, suffix, (content or b"").hex(), *(["half"] if content is None else [])]
    kept_in = {"NUMBA_CACHE_DIR": str(tmp_path / "kept"), "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        line, cwd=tmp_path, env=os.environ | kept_in, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.stdout.splitlines() == ["0.25", "True False", "0.25", "True False", "0.25", "True True"], (
        done.stderr
    )
    assert done.stderr.count("compiling") == 1
