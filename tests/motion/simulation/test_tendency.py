"""What a simulated motion has come to: against exact decay, against `classify`, and on the command line."""

import json
import math
import re

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym import Motion
from support.operating_points import paper_oscillator


def test_change_of_a_linear_oscillator_is_exact():
    """Under constant friction a swing is exp(-2 pi zeta/sqrt(1 - zeta^2)) of the last."""
    law, rng = ss.FrictionLaw("0.3"), np.random.default_rng(17)
    seen = set()
    for zeta in [0.0, 3e-9, -1e-7, *(rng.choice([-1, 1], 15) * 10 ** rng.uniform(-4, -0.5, 15)).tolist()]:
        m, k, V, N = (10 ** rng.uniform(-2, 2, 4)).tolist()
        osc = ss.Oscillator(m=m, k=k, V=V, N=N, c=2 * zeta * math.sqrt(k * m))
        x0 = 0.3 * N / k + 0.01 * osc.length
        motion = ss.simulate(law, osc, t_end=4 * 2 * math.pi / osc.omega, x0=x0, v0=0.0, rtol=1e-11)
        exact = math.expm1(-2 * math.pi * zeta / math.sqrt(1 - zeta**2))
        assert motion.change == pytest.approx(exact, abs=1e-9)
        assert ("the same within 1e-07 % a round" in motion.summary) == (zeta == 0)
        expected = Motion.PURE_SLIP if zeta == 0 else Motion.SHRINKING if zeta > 0 else Motion.GROWING
        assert motion.motion is expected
        seen.add(motion.motion)
    assert len(seen) == 3


@pytest.mark.parametrize(
    ("point", "initial", "expected", "end"),
    [
        ({"c": 1.0}, {"t_end": 0.05}, Motion.STICK, "stick-slip"),
        ({"c": 1.0}, {"t_end": 0.5}, Motion.UNDECIDED, "stick-slip"),
        ({"c": 1.0}, {"t_end": 1.0}, Motion.STICK_SLIP, None),
        ({"c": 3.5}, {"t_end": 6.0}, Motion.SHRINKING, "rest"),
        ({"c": 30.0}, {"t_end": 100.0}, Motion.REST, None),
        ({"c": 1.0}, {"t_end": 2.5, "x0": 0.0262, "v0": 0.01}, Motion.GROWING, "stick-slip"),
        ({"c": 0.0, "V": 5.0, "N": 0.5}, {"t_end": 6.0}, Motion.OVERTAKING, "pure slip"),
        ({"c": -50.0}, {"t_end": 100.0}, Motion.UNBOUNDED, None),
    ],
)
def test_command_says_where_a_motion_leads(point, initial, expected, end, run):
    motion = ss.simulate(ss.laws.exponential.typical(), paper_oscillator(**point), **initial)
    assert motion.motion is expected
    assert repr(motion).startswith(f"Trajectory: {expected.value}")
    options = [word for name, value in point.items() for word in (f"-{name}", str(value))]
    options += [f"--{name.replace('_', '-')}={value}" for name, value in initial.items()]
    code, out, err = run("simulate", "exponential", *options)
    assert (code, err) == (0, "")
    (line,) = re.findall(r"^motion: (.*)$", out, re.M)
    assert line == motion.summary + ("" if end is None else f"; in the end: {end}")
    _, out, _ = run("simulate", "exponential", *options, "--json")
    said = json.loads(out)
    assert (said["motion"]["motion"], said["motion"]["change"], said["in_the_end"]) == (
        expected.value,
        motion.change,
        end,
    )
