"""Fixtures that several test files use."""

import os

# Tests run in several processes; threads of linear algebra on top would wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest

import stickslip_sym as ss


@pytest.fixture(params=["exponential", "polynomial"])
def law(request):
    """Each of the paper's two laws at the paper's parameters."""
    return ss.laws.catalogue[request.param].typical()


def paper_oscillator(c=0.0, **changes):
    """Return the oscillator of the paper's section 3."""
    return ss.Oscillator(**({"m": 1.0, "k": 100.0, "c": c, "V": 0.5, "N": 9.81} | changes))


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """Run the command in this process, in an empty folder; return its exit code and what it printed."""
    from stickslip_sym.cli import program

    monkeypatch.chdir(tmp_path)

    def call(*arguments):
        monkeypatch.setattr("sys.argv", ["stickslip", *arguments])
        with pytest.raises(SystemExit) as end:
            program.main()
        printed = capsys.readouterr()
        return end.value.code or 0, printed.out, printed.err

    return call
