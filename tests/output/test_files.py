"""What is written: files survive a failure, links, permissions, long names; what is no name is refused."""

import os
import shutil
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym.output import files
from stickslip_sym.views import drawing
from support.operating_points import paper_oscillator
from support.platforms import needs_links, needs_long_names, needs_modes


def test_a_null_byte_in_a_name_is_refused(tmp_path):
    motion = ss.simulate(ss.laws.exponential.typical(), paper_oscillator(2.3), t_end=0.1)
    save = partial(ss.save, ss.laws.linear)
    for use in (ss.FrictionLaw.from_csv, ss.load, motion.to_csv, motion.plot, save):
        with pytest.raises(ss.InputError):
            use(tmp_path / "a\0b.png")
    assert list(tmp_path.iterdir()) == []


def test_a_picture_without_matplotlib_is_none(monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert drawing.picture(lambda: pytest.fail("drawn"), "a picture") == ""


@pytest.mark.skipif(not Path("/dev/stdout").exists(), reason="needs /dev/stdout")
def test_standard_output_is_no_file_to_keep(tmp_path):
    (tmp_path / "a.csv").write_text("measured")
    kept = [files.is_kept(path) for path in (Path("/dev/stdout"), tmp_path, tmp_path / "a.csv")]
    assert kept == [False, False, True]


@pytest.mark.parametrize("seed", range(5))
def test_all_files_are_written_or_none(seed, tmp_path, monkeypatch):
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


@needs_modes
@needs_links
def test_links_are_followed_and_permissions_kept(tmp_path):
    path, link = tmp_path / "form.tex", tmp_path / "link.tex"
    link.symlink_to(path)  # to nowhere yet
    before = os.umask(0o027)
    try:
        files.write_text(link, "new")
    finally:
        os.umask(before)
    assert (path.read_text(), path.stat().st_mode & 0o777) == ("new", 0o640)
    path.chmod(0o604)
    files.write_text(link, "newer")
    assert (link.read_text(), path.stat().st_mode & 0o777) == ("newer", 0o604)
    assert link.is_symlink()
    loop = tmp_path / "a"
    loop.symlink_to(tmp_path / "b")
    (tmp_path / "b").symlink_to(loop)
    with pytest.raises(ss.InputError, match="Too many levels of symbolic links; choose another file"):
        files.write_text(loop, "new")


def test_a_read_only_file_is_kept(tmp_path, monkeypatch):
    path = tmp_path / "form.tex"
    path.write_text("precious")
    # The superuser may write everywhere, so what the system would answer is put in its place.
    monkeypatch.setattr("os.access", lambda target, mode: not (Path(target) == path and mode == os.W_OK))
    with pytest.raises(ss.InputError, match="Permission denied; choose another file"):
        files.write_text(path, "new")
    assert path.read_text() == "precious"


@needs_long_names
def test_long_names_are_written(tmp_path):
    path = tmp_path / ("x" * 255)
    files.write_text(path, "new")
    assert path.read_text() == "new"
    with pytest.raises(ss.InputError, match="File name too long"):
        files.write_text(tmp_path / ("x" * 256), "new")


@needs_modes
def test_a_pipe_is_written_into(tmp_path):
    reading, writing = os.pipe()
    files.write_texts({Path(f"/dev/fd/{writing}"): "sent", tmp_path / "kept": "kept"})
    os.close(writing)
    with os.fdopen(reading) as pipe:
        assert pipe.read() == "sent"
    assert (tmp_path / "kept").read_text() == "kept"


ENDLESS = [path for path in ("/dev/zero", "/dev/random", "PIPE") if path == "PIPE" or Path(path).exists()]


@needs_modes
@pytest.mark.parametrize("name", ENDLESS)
def test_what_is_no_regular_file_is_refused_at_once(name, run, tmp_path):
    """A device has no end, and a pipe that nobody writes into has no beginning."""
    path = Path(name)
    if name == "PIPE":
        path = tmp_path / "pipe"
        os.mkfifo(path)
    for read in (ss.load, ss.read_measurements, ss.FrictionLaw.from_csv):
        with pytest.raises(ss.InputError, match="it is no regular file; save its content in one"):
            read(path)
    for line in ("read", "damping linear --point", "study --from-csv"):
        code, _, err = run(*line.split(), str(path))
        assert code == 2
        assert "it is no regular file" in err


@needs_modes
def test_a_pipe_without_a_reader_is_not_waited_for(tmp_path):
    path = tmp_path / "pipe"
    os.mkfifo(path)
    with pytest.raises(ss.InputError, match="cannot write"):
        ss.save(ss.laws.linear, path)


@pytest.mark.parametrize("length", [100, 101])
def test_no_more_is_read_than_is_allowed(length, tmp_path):
    path = tmp_path / "some"
    path.write_bytes(b"x" * length)
    if length == 100:
        assert files.read_bytes(path, 100) == b"x" * 100
    else:
        with pytest.raises(ss.InputError, match="has over 100 bytes"):
            files.read_bytes(path, 100)
