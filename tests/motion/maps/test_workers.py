"""Maps by several threads and other executors, and what is kept when they are interrupted."""

import os
import pickle
import subprocess
import sys
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym.core import deadline
from stickslip_sym.core.progress import report_steps_to
from stickslip_sym.motion import workers
from stickslip_sym.motion.maps import motions
from stickslip_sym.motion.maps.cells import LATE

LAW = ss.laws.exponential.typical()
PLANE = {"x": ("V", np.linspace(0.2, 0.8, 7)), "y": ("c", np.linspace(0.5, 6, 12)), "N": 9.81, "m": 1, "k": 100}


class AnyWire(Executor):
    """An executor to which everything comes over a wire."""

    def submit(self, function, /, *arguments):
        function, arguments = pickle.loads(pickle.dumps((function, arguments)))
        future = Future()
        future.set_result(function(*arguments))
        return future


def same(one, other):
    """Whether two maps are equal, to the last bit."""
    return one.columns.keys() == other.columns.keys() and all(
        np.array_equal(column, other.columns[name], equal_nan=column.dtype.kind == "f")
        for name, column in one.columns.items()
    )


@pytest.fixture(scope="module", autouse=True)
def _two_lines_at_once():
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(motions, "_CELLS", 24)
        yield


@pytest.fixture(scope="module")
def serial(_two_lines_at_once):
    """The map that one process computes."""
    return ss.motion_map(LAW, **PLANE)


def test_every_executor_gives_the_same_map(serial):
    assert same(serial, ss.motion_map(LAW, **PLANE, workers=2))
    assert same(serial, ss.motion_map(LAW, **PLANE, workers=AnyWire()))
    with ThreadPoolExecutor(2) as threads:
        assert same(serial, ss.motion_map(LAW, **PLANE, workers=threads))
        assert threads.submit(abs, -9).result() == 9  # it stays the caller's
    other = ss.motion_map(LAW, **(PLANE | {"N": 5.0}))
    assert not same(serial, other)


# dask's own sockets and event loops may be closed by the garbage collector only.
@pytest.mark.thorough
@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_dask_cluster_is_an_executor(serial, tmp_path):
    distributed = pytest.importorskip("distributed")
    options = {"dashboard_address": None, "local_directory": tmp_path, "silence_logs": 50}
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, **options) as cluster,
        distributed.Client(cluster) as client,
    ):
        assert same(serial, ss.motion_map(LAW, **PLANE, workers=client.get_executor()))


@pytest.mark.parametrize("wrong", [0, -2, 1.5, True, "2", None, [1]])
def test_unusable_workers_are_refused(wrong):
    with pytest.raises(ss.InputError, match=r"workers = .* must be a number of threads"):
        ss.motion_map(LAW, **PLANE, workers=wrong)
    with pytest.raises(ss.InputError, match="progress is a function of two numbers, got"):
        ss.motion_map(LAW, **PLANE, progress=wrong or 0)


def test_executors_that_break_are_an_error():
    spawned = ProcessPoolExecutor(1, mp_context=get_context("spawn"))
    with spawned, pytest.raises(ss.NotConverged, match="the executor ended before its work"):
        workers.collect(os._exit, [1, 1], workers=spawned, what="tasks")


def test_time_that_is_left_goes_to_workers():
    with deadline.time_limit(100):
        assert all(0 < left < 100 for left in workers.collect(_left, [1, 2], workers=2, what="tasks"))
    assert workers.collect(_left, [1], what="tasks") == [np.inf]


def _left(_):
    return deadline.time_left()


def test_only_many_motions_speak_of_the_extra():
    script = """
import sys
sys.modules["numba"] = None
import stickslip_sym as ss
osc, law = ss.Oscillator(m=1, k=100, c=1, V=0.5, N=9.81), ss.laws.exponential.typical()
motion = ss.simulate(law, osc, t_end=5).at(0.3)
ss.regime(law, osc)
print(file=sys.stderr)
ss.classify(law, osc, x0=[0.001 * i for i in range(20)], v0=[0.0] * 20)
"""
    said = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, timeout=60)
    one, many = said.stderr.splitlines()
    assert one == ""
    assert many.startswith("many motions are computed in plain Python; pip install")


def press(done, total):
    """Interrupt after two parts."""
    if done == 2:
        raise KeyboardInterrupt


def test_control_c_prints_what_is_done(run, monkeypatch, tmp_path):
    heard = report_steps_to(lambda step: press(step.done, step.total))
    monkeypatch.setattr("stickslip_sym.cli.map.show_progress", lambda _: heard)
    code, out, err = run("map", "exponential", "--x", "V=0.2:0.8:7", "--y", "c=0.5:6:12", "--csv", "part.csv")
    assert (code, err.strip()) == (130, "interrupted")
    assert "stick-slip" in out
    assert LATE in out
    assert len((tmp_path / "part.csv").read_text().splitlines()) == 85


def test_interruption_leaves_cells_undecided():
    whole, part = (ss.motion_map(LAW, **PLANE, progress=progress) for progress in (None, press))
    decided = part.motion != ss.Motion.UNDECIDED
    assert 0 < decided.sum() < decided.size
    assert (part.motion[decided] == whole.motion[decided]).all()
    assert part.notes == dict.fromkeys(map(tuple, np.argwhere(~decided).tolist()), LATE)
    with pytest.raises(KeyboardInterrupt):
        ss.motion_map(LAW, **PLANE, progress=lambda done, total: press(2, total))


class Interrupted(Executor):
    """An executor that Ctrl-C interrupts while it is given its third task."""

    def __init__(self):
        self.futures = []

    def submit(self, function, /, *arguments):
        if len(self.futures) == 2:
            raise KeyboardInterrupt
        self.futures.append(Future())
        return self.futures[-1]


def test_interruption_while_tasks_are_handed_out_leaves_none_of_them_waiting():
    executor = Interrupted()
    with pytest.raises(KeyboardInterrupt):
        ss.motion_map(LAW, **PLANE, workers=executor)
    assert [future.cancelled() for future in executor.futures] == [True, True]
