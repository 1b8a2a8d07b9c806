"""What is under way ends where it began, however it ended."""

import pytest

import stickslip_sym as ss
from stickslip_sym.core.progress import report_every_step_to, steps

LAW, SCENE = ss.laws.exponential.typical(), ss.Oscillator(V=0.3, N=9.81, m=1, k=10, c=1)


def said_by(function):
    heard = []
    with report_every_step_to(heard.append):
        function()
    return [tuple(step.what for step in path) for path in heard]


def two_steps():
    with steps(["a", "b"], str) as letters:
        assert list(letters) == ["a", "b"]


def test_an_error_that_is_kept_leaves_no_step_behind():
    """In a loop, and in a comprehension, which keep the suspended iterator in the traceback."""
    kept = []
    for _ in range(2):
        try:
            with steps(["c", "d"], str) as letters:
                [1 / (letter == "d") for letter in letters]
        except ZeroDivisionError as error:
            kept.append(error)
        assert said_by(two_steps) == [("a",), ("b",), ("b",)]
    kept.clear()
    assert said_by(two_steps) == [("a",), ("b",), ("b",)]


def test_a_sweep_out_of_time_leaves_no_step_behind():
    with pytest.raises(ss.OutOfTime) as kept:
        ss.basin_sweep(LAW, SCENE, ("V", [0.3, 0.4]), x0=(-1, 1), v0=(0, 1), time_limit=0.001)
    assert kept.value.__traceback__ is not None
    assert said_by(two_steps) == [("a",), ("b",), ("b",)]
