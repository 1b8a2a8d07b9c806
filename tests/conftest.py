"""Fixtures that several test files use."""

import os
from functools import partial

# Tests run in several processes; threads of linear algebra on top would wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import commands
import pytest

import stickslip_sym as ss


@pytest.fixture(params=["exponential", "polynomial"])
def law(request):
    """Each of the paper's two laws at the paper's parameters."""
    return ss.laws.catalogue[request.param].typical()


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """Run the command in this process, in an empty folder; return its exit code and what it printed."""
    monkeypatch.chdir(tmp_path)
    return partial(commands.run, monkeypatch, capsys)
