"""Tasks in other processes and by other maps, and what is kept of them when a run is killed."""

import json
import multiprocessing
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from commands import started
from parallel_tasks import KILL, die_once, slow_lines, slow_square, square
from systems import needs_groups

import stickslip_sym as ss
from stickslip_sym.cli import map
from stickslip_sym.motion.maps import checkpoint, lines, workers

LAW = ss.laws.exponential.typical()
PLANE = {"x": ("V", np.linspace(0.2, 0.8, 7)), "y": ("c", np.linspace(0.5, 6, 12)), "N": 9.81, "m": 1, "k": 100}


def same(one, other):
    """Whether two maps are equal, to the last bit."""
    return all(
        np.array_equal(getattr(one, name), getattr(other, name))
        for name in ("motion", "reason", "stick_slip", "rest", "pure_slip")
    ) and all(
        np.array_equal(one.thresholds[name], other.thresholds[name], equal_nan=True) for name in one.thresholds
    )


@pytest.fixture(scope="module", autouse=True)
def _two_lines_at_once():
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(lines, "_CELLS", 24)
        yield


@pytest.fixture(scope="module")
def serial(_two_lines_at_once):
    """The map that one process computes."""
    return ss.motion_map(LAW, **PLANE)


def test_a_map_like_callable_and_the_builtin_give_the_same(serial):
    calls = []

    def mapper(function, tasks):
        calls.append(function)
        return [function(json.loads(json.dumps(task))) for task in tasks]  # plain enough for any wire

    assert same(serial, ss.motion_map(LAW, **PLANE, workers=mapper))
    assert len(calls) == 1


def test_processes_give_the_same_in_order(serial):
    assert same(serial, ss.motion_map(LAW, **PLANE, workers=2))
    assert not multiprocessing.active_children()


def test_processes_work_where_signals_cannot_be_blocked(monkeypatch):
    """As on Windows, which has no signal masks."""
    monkeypatch.delattr(signal, "pthread_sigmask", raising=False)
    assert list(workers.run(square, [3, 4], 2)) in ([(0, 9), (1, 16)], [(1, 16), (0, 9)])


def test_a_killed_process_loses_nothing(tmp_path):
    tasks = [[str(tmp_path / "died"), i] for i in range(6)]
    assert sorted(workers.run(die_once, tasks, 2)) == [(i, i) for i in range(6)]
    assert (tmp_path / "died").exists()


def test_processes_that_always_die_are_an_error():
    with pytest.raises(ss.NotConverged, match="worker processes ended 3 times"):
        list(workers.run(os._exit, [1, 1], 2))


def test_no_process_is_left_when_the_caller_stops():
    running = workers.run(slow_square, [0, 30, 30], 2)
    assert next(running) == (0, 0)
    begin = time.monotonic()
    running.close()
    assert time.monotonic() - begin < 10
    assert not multiprocessing.active_children()


# dask's own sockets and event loops may be closed by the garbage collector only.
@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_dask_cluster_gives_the_same_and_a_killed_worker_loses_nothing(serial, tmp_path):
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, local_directory=tmp_path,
            silence_logs=50,
        ) as cluster,
        distributed.Client(cluster) as client,
    ):  # fmt: skip

        def mapper(function, tasks):
            return client.gather(client.map(function, tasks))

        assert same(serial, ss.motion_map(LAW, **PLANE, workers=mapper))
        before = client.run(os.getpid)
        assert len(before) == 2

        def killing(function, tasks):
            futures = client.map(slow_lines, tasks)
            client.gather(futures[:1])
            os.kill(next(iter(before.values())), KILL)
            return client.gather(futures)

        assert same(serial, ss.motion_map(LAW, **PLANE, workers=killing))


@pytest.mark.parametrize("wrong", [0, -2, 1.5, True, "2", None])
def test_unusable_workers_are_refused(wrong):
    with pytest.raises(ss.InputError, match=r"workers = .* must be a number of processes"):
        ss.motion_map(LAW, **PLANE, workers=wrong)


@pytest.mark.parametrize(
    ("mapper", "what"), [(lambda f, x: [], "0 results"), (lambda f, x: [*[f(one) for one in x], None], "more")]
)
def test_a_map_of_another_length_is_refused(mapper, what):
    with pytest.raises(ss.InputError, match=what):
        ss.motion_map(LAW, **PLANE, workers=mapper)


# -- checkpoints -----------------------------------------------------------------------------------


def test_results_are_kept_as_they_come_and_not_computed_twice(tmp_path):
    file = tmp_path / "kept"
    asked = []

    def lazily(function, tasks):
        for task in tasks:
            asked.append(task)
            if len(asked) == 4:
                raise KeyboardInterrupt
            yield function(task)

    with pytest.raises(KeyboardInterrupt):
        checkpoint.collect(square, range(8), workers=lazily, checkpoint=file)
    assert len(file.read_text().splitlines()) == 1 + 3
    told = []
    again = checkpoint.collect(
        square, range(8), workers=lambda f, tasks: (asked.append(t) or f(t) for t in tasks), checkpoint=file,
        progress=lambda done, total: told.append((done, total)),
    )  # fmt: skip
    assert again == [i * i for i in range(8)]
    assert asked == [0, 1, 2, 3, 3, 4, 5, 6, 7]
    assert told == [(i, 8) for i in range(3, 9)]
    assert checkpoint.collect(square, range(8), workers=lambda f, tasks: [], checkpoint=file) == again


def test_tasks_go_together_the_same_way_in_every_run(tmp_path):
    """Three at once: of a part that was torn apart all is computed again, and what was kept stays."""
    file, asked = tmp_path / "kept", []

    def squares(numbers):
        asked.append(numbers)
        return [square(number) for number in numbers]

    told = []
    options = {"together": 3, "checkpoint": file, "progress": lambda done, total: told.append((done, total))}
    whole = checkpoint.collect(squares, range(8), **options)
    assert (whole, asked) == ([i * i for i in range(8)], [[0, 1, 2], [3, 4, 5], [6, 7]])
    assert told == [(0, 8), (3, 8), (6, 8), (8, 8)]
    content = file.read_bytes().splitlines(keepends=True)
    file.write_bytes(b"".join(content[:5]))  # the request, and four tasks
    assert checkpoint.collect(squares, range(8), **options) == whole
    assert asked[3:] == [[3, 4, 5], [6, 7]]
    assert file.read_bytes() == b"".join(content)


@pytest.mark.parametrize("cut", [1, 30, -1, -5])
def test_a_torn_line_is_dropped(tmp_path, cut):
    file = tmp_path / "kept"
    whole = checkpoint.collect(square, range(5), checkpoint=file)
    content = file.read_bytes()
    file.write_bytes(content[:cut])
    assert checkpoint.collect(square, range(5), checkpoint=file) == whole
    assert file.read_bytes() == content


def test_files_of_others_are_refused_and_left(tmp_path):
    file = tmp_path / "kept"
    checkpoint.collect(square, range(5), checkpoint=file)
    kept = file.read_bytes()
    for function, tasks in ((square, range(6)), (slow_square, range(5)), (square, [0, 1, 2, 4, 3])):
        with pytest.raises(ss.InputError, match="belongs to another request"):
            checkpoint.collect(function, list(tasks), checkpoint=file)
    assert file.read_bytes() == kept
    for content in (b"V,c\n1,2\n", b"V,c", b"[1]\n", kept + b"[9, 1]\n", kept.replace(b"[1, 1]", b"[1, ")):
        file.write_bytes(content)
        with pytest.raises(ss.InputError, match=r"is no checkpoint|was changed"):
            checkpoint.collect(square, range(5), checkpoint=file)
        assert file.read_bytes() == content
    with pytest.raises(ss.InputError, match="cannot use the checkpoint"):
        checkpoint.collect(square, range(5), checkpoint=tmp_path)


def test_another_law_or_value_is_another_request(tmp_path):
    file = tmp_path / "kept"
    ss.motion_map(LAW, **PLANE, checkpoint=file)
    for law, plane in ((LAW.bind(alpha=3.5), PLANE), (LAW, PLANE | {"N": 9.8})):
        with pytest.raises(ss.InputError, match="belongs to another request"):
            ss.motion_map(law, **plane, checkpoint=file)


def test_a_run_killed_midway_goes_on_to_the_same_output(run, tmp_path):
    command = [
        sys.executable, "-c", "from stickslip_sym.cli.program import main; main()", "map", "exponential",
        "--x", "V=0.2:0.9:30", "--y", "c=0.5:6:20",
    ]  # fmt: skip
    checkpointed = [*command, "--checkpoint", "kept", "--csv", "resumed.csv", "--npz", "resumed.npz"]
    with subprocess.Popen(checkpointed, cwd=tmp_path, stdout=subprocess.DEVNULL) as process:
        deadline = time.monotonic() + 60
        file = tmp_path / "kept"
        while not (file.exists() and file.read_bytes().count(b"\n") > 3) and time.monotonic() < deadline:
            assert process.poll() is None
            time.sleep(0.002)
        process.kill()
    assert process.returncode != 0
    done = file.read_bytes().count(b"\n") - 1
    assert 3 <= done < 30
    code, out, err = run(*checkpointed[3:])
    assert (code, err) == (0, "")
    axes = {"x": ("V", np.linspace(0.2, 0.9, 30)), "y": ("c", np.linspace(0.5, 6, 20))}
    whole = ss.motion_map(LAW, **(PLANE | axes))
    whole.to_csv(tmp_path / "whole.csv")
    whole.to_npz(tmp_path / "whole.npz")
    for kind in ("csv", "npz"):
        assert (tmp_path / f"resumed.{kind}").read_bytes() == (tmp_path / f"whole.{kind}").read_bytes()
    assert out == map.report(whole) + "\n"
    assert file.read_bytes().count(b"\n") == 31  # nothing was computed twice


@needs_groups
def test_ctrl_c_ends_quietly_and_the_checkpoint_remains(tmp_path):
    axes = ["--x", "V=0.2:0.9:1200", "--y", "c=0.5:6:20", "--workers", "2", "--checkpoint", "kept"]
    with started("map", "exponential", *axes, cwd=tmp_path) as process:
        file = tmp_path / "kept"
        deadline = time.monotonic() + 60
        while not (file.exists() and file.read_bytes().count(b"\n") > 2) and time.monotonic() < deadline:
            time.sleep(0.01)
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to the workers too
        out, err = process.communicate(timeout=30)
    assert (process.returncode, out, err.strip()) == (130, "", "")
    assert 3 <= file.read_bytes().count(b"\n") < 1201
