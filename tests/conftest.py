"""Fixtures that several test files use, and how tests are shared out among processes."""

import os
from functools import partial

# Tests run in several processes; threads of linear algebra on top would wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import commands
import pytest

import stickslip_sym as ss


@pytest.hookimpl(tryfirst=True)  # before pytest-xdist looks at the groups
def pytest_collection_modifyitems(items):
    """Let one process check the claims, which share orbits and proofs; begin with the tests that take longest."""
    for item in items:
        if item.get_closest_marker("claim"):
            item.add_marker(pytest.mark.xdist_group("claims"))
    items.sort(key=lambda item: item.path.parent.name != "whole")


@pytest.fixture(params=["exponential", "polynomial"])
def law(request):
    """Each of the paper's two laws at the paper's parameters."""
    return ss.laws.catalogue[request.param].typical()


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """Run the command in this process, in an empty folder; return its exit code and what it printed."""
    monkeypatch.chdir(tmp_path)
    return partial(commands.run, monkeypatch, capsys)
