"""Fixtures that several test files use, and how tests are shared out among processes."""

import os
import random

# Tests run in several processes; threads of linear algebra on top would wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from hypothesis import HealthCheck, settings

from support.shared_bytecode import share_bytecode
from support.sweeps import outside_samples

# The package is imported where it is used: the first process of a run only shares out tests.

TOGETHER = {
    "claims": ("paper_checks/", "tests/whole/test_mutations.py", "tests/whole/test_report.py"),
    "closed forms": ("tests/formula/evaluation/test_accuracy.py", "tests/formula/evaluation/test_calls.py",
                     "tests/formula/export/", "tests/model/test_catalogue.py", "tests/output/test_latex.py"),
    "printed formulas": ("tests/output/test_printers.py",),
    "powers of v": ("tests/formula/test_closed_form.py", "tests/formula/test_letters.py"),
    "measured points": ("tests/model/test_samples.py",),
    "results": ("tests/views/test_notebook.py", "tests/views/test_figures.py", "tests/output/test_data.py",
                "tests/whole/test_results_are_data.py"),
}  # fmt: skip
"""Tests that share orbits and proofs, closed forms, or draws: one process makes them, once."""


# Seeded, so that a failure comes again; ``pytest --thorough`` takes many examples. No deadline on shared machines.
settings.register_profile("default", max_examples=5, derandomize=True, deadline=None, database=None,
                          suppress_health_check=[HealthCheck.too_slow])  # fmt: skip
settings.register_profile("thorough", settings.get_profile("default"), max_examples=300)


def pytest_addoption(parser):
    words = "hundreds of examples a property, and what takes minutes"
    parser.addoption("--thorough", action="store_true", help=words)
    words = "draw other examples: this number is the seed of Hypothesis and is added to every seed of a test"
    parser.addoption("--fresh", type=int, metavar="SEED", help=words)
    words = "run the tests in another order: reverse, or shuffled by a number"
    parser.addoption("--order", metavar="ORDER", help=words)


def pytest_configure(config):
    share_bytecode()
    config.addinivalue_line("markers", "thorough: takes long, and is left to ``pytest --thorough``")
    config.addinivalue_line("markers", "sample(count): so many of its cases, and all with ``pytest --thorough``")
    settings.load_profile("thorough" if config.getoption("--thorough") else "default")
    if (fresh := config.getoption("--fresh")) is not None:
        settings.register_profile("fresh", settings(), derandomize=False)
        settings.load_profile("fresh")
        config.option.hypothesis_seed = fresh


def pytest_report_header(config):
    """Say how a failure of a nightly run comes again."""
    fresh, order = config.getoption("--fresh"), config.getoption("--order")
    lines = [] if fresh is None else [f"examples drawn anew: the same come again with --fresh {fresh}"]
    return lines if order is None else [*lines, f"another order: the same comes again with --order {order}"]


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Share out tests by file, and those in `TOGETHER` at once: what a file computes is computed once."""
    from xdist.scheduler import LoadScopeScheduling

    class Scheduling(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            file = nodeid.partition("::")[0]
            return next((name for name, places in TOGETHER.items() if nodeid.startswith(places)), file)

    return Scheduling(config, log)


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector):
    """Let every other process read the files from the last one on: half of them another has compiled by then."""
    report = yield
    number = os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw")
    if isinstance(collector, pytest.Directory) and int(number) % 2:
        report.result = report.result[::-1]
    return report


def pytest_collection_modifyitems(config, items):
    """Leave what takes long to ``--thorough``; begin with the rest's longest, so that they do not come last."""
    items.sort(key=lambda item: item.path)
    if not config.getoption("--thorough"):
        long = {item for item in items if item.get_closest_marker("thorough")}
        long |= outside_samples([item for item in items if item not in long])
        config.hook.pytest_deselected(items=list(long))
        items[:] = [item for item in items if item not in long]
    for item in items if config.getoption("--fresh") is not None else ():
        parameters = item.callspec.params if hasattr(item, "callspec") else {}
        if "seed" in parameters:
            parameters["seed"] += config.getoption("--fresh")
    order = config.getoption("--order")
    if order is None:
        items.sort(key=lambda item: item.path.parent.name != "whole")
    elif order == "reverse":
        items.reverse()
    else:
        random.Random(int(order)).shuffle(items)


@pytest.fixture(params=["exponential", "polynomial"])
def law(request):
    """Each of the paper's two laws at the paper's parameters."""
    import stickslip_sym as ss

    return ss.laws.catalogue[request.param].typical()


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Run the command in this process, in an empty folder; return its exit code and what it printed."""
    from support import commands

    monkeypatch.chdir(tmp_path)

    def results(*arguments):
        done = commands.inside(*arguments)
        return done.returncode, done.stdout, done.stderr

    return results


@pytest.fixture(scope="session")
def of_each_kind():
    """One of every result by name, made once in a process; `sample_results.untouched` gives them as they were."""
    from support import sample_results

    made = sample_results.one_of_each()
    sample_results.untouched("law")
    return made


@pytest.fixture
def fresh_averages():
    """Forget all averages of profiles before a test that tampers with how they are found, and after it."""
    from stickslip_sym.formula.average import average_of_profile

    average_of_profile.cache_clear()
    yield
    average_of_profile.cache_clear()
