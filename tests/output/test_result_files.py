"""Names that no system takes for a file are refused, in the same words everywhere."""

import os
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from scenes import paper_oscillator

import stickslip_sym as ss
from stickslip_sym.output import drawing, files

LAW = ss.laws.exponential.typical()


@pytest.fixture(scope="module")
def results():
    """One of each kind of result that writes files."""
    osc, form = paper_oscillator(2.3), ss.derive(ss.FrictionLaw("a - b*v"))
    scene = {"N": 9.81, "m": 1.0, "k": 100.0}
    return {
        "form": form,
        "motion": ss.simulate(LAW, osc, t_end=0.5),
        "map": ss.motion_map(LAW, x=("V", [0.5]), y=("c", [1.0]), **scene),
        "basins": ss.basin_map(LAW, osc, x0=[0.0], v0=[0.0]),
    }


CALLS = {
    "from_csv": lambda results, path: ss.FrictionLaw.from_csv(path),
    "load": lambda results, path: ss.load(path),
    "save": lambda results, path: ss.save(results["form"], path),
    "motion.to_csv": lambda results, path: results["motion"].to_csv(path),
    "motion.plot": lambda results, path: results["motion"].plot(path),
    "map.to_csv": lambda results, path: results["map"].to_csv(path),
    "map.to_npz": lambda results, path: results["map"].to_npz(path),
    "map.plot": lambda results, path: results["map"].plot(path),
    "basins.to_csv": lambda results, path: results["basins"].to_csv(path),
    "basins.to_npz": lambda results, path: results["basins"].to_npz(path),
    "basins.plot": lambda results, path: results["basins"].plot(path),
    "regime.plot": lambda results, path: results["basins"].regime.plot(path),
    "write_text": lambda results, path: files.write_text(path, ""),
}


@pytest.mark.parametrize("call", CALLS)
def test_a_null_byte_is_refused_in_our_words(call, results, tmp_path):
    """Wherever it is in the name; what the system says of it differs from one Python to the next."""
    if call.endswith("plot"):
        pytest.importorskip("matplotlib")
    rng = np.random.default_rng(13)
    for _ in range(3):
        letters = list(rng.choice(list("ab."), 6))
        letters[rng.integers(0, 6)] = "\0"
        name = "".join(letters)
        for path in (tmp_path / name, tmp_path / name / "a.csv"):
            with pytest.raises(ss.InputError, match="the name of a file cannot hold a null byte"):
                CALLS[call](results, path)
    assert list(tmp_path.iterdir()) == []


def test_a_picture_without_matplotlib_is_none(monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert drawing.picture(lambda: pytest.fail("drawn"), "a picture") == ""
    with pytest.raises(ss.InputError, match="null byte"):
        files.require_name(Path("a\0b"))


@pytest.mark.skipif(not Path("/dev/stdout").exists(), reason="needs /dev/stdout")
def test_standard_output_is_no_file_to_keep(tmp_path):
    assert not files.is_kept(Path("/dev/stdout"))
    assert not files.is_kept(tmp_path)
    (tmp_path / "a.csv").write_text("measured")
    assert files.is_kept(tmp_path / "a.csv")


@pytest.mark.parametrize("seed", range(4))
def test_all_files_are_written_or_none_and_none_is_left_behind(seed, tmp_path, monkeypatch):
    """Whatever step fails, each file has its old content or its new one, whole."""
    rng = np.random.default_rng(seed)
    paths = [tmp_path / name for name in "abcd"]
    for path in paths[: rng.integers(0, 4)]:
        path.write_text("old")
    before = {path: path.read_text() for path in paths if path.exists()}
    step, failing = rng.choice(["os.fsync", "shutil.copymode", "os.replace"]), int(rng.integers(0, 4))
    real, calls = {"os.fsync": os.fsync, "shutil.copymode": shutil.copymode, "os.replace": os.replace}[step], []

    def sometimes(*arguments):
        calls.append(arguments)
        if len(calls) == failing + 1:
            raise OSError(28, "No space left on device")
        return real(*arguments)

    monkeypatch.setattr(step, sometimes)
    new = {path: f"new {path.name}" for path in paths}
    try:
        files.write_texts(new)
        replaced = len(paths)
    except ss.InputError as error:
        assert "No space left on device; choose another file" in str(error)  # noqa: PT017
        replaced = failing if step == "os.replace" else 0
    monkeypatch.undo()
    expected = before | {path: new[path] for path in paths[:replaced]}
    assert {path: path.read_text() for path in tmp_path.iterdir()} == expected
