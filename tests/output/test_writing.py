"""What the commands write: files that survive a failure, links, permissions, long names."""

import os
from pathlib import Path

import pytest
from systems import needs_links, needs_long_names, needs_modes

from stickslip_sym import InputError
from stickslip_sym.output import files


def test_a_file_survives_a_failed_write(tmp_path, monkeypatch):
    path = tmp_path / "form.tex"
    path.write_text("precious")

    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", fail)
    with pytest.raises(InputError, match="No space left on device; choose another file"):
        files.write_text(path, "new")
    assert path.read_text() == "precious"
    assert [entry.name for entry in tmp_path.iterdir()] == ["form.tex"]


@needs_links
def test_a_loop_of_links_is_refused(tmp_path):
    path, other = tmp_path / "a", tmp_path / "b"
    path.symlink_to(other)
    other.symlink_to(path)
    with pytest.raises(InputError, match="Too many levels of symbolic links; choose another file"):
        files.write_text(path, "new")
    assert path.is_symlink()


@needs_links
def test_a_link_to_nowhere_yet_is_followed(tmp_path):
    path, link = tmp_path / "form.tex", tmp_path / "link.tex"
    link.symlink_to(path)
    files.write_text(link, "new")
    assert path.read_text() == "new"
    assert link.is_symlink()


def test_a_read_only_file_is_kept(tmp_path, monkeypatch):
    path = tmp_path / "form.tex"
    path.write_text("precious")
    # The superuser may write everywhere, so what the system would answer is put in its place.
    monkeypatch.setattr("os.access", lambda target, mode: not (Path(target) == path and mode == os.W_OK))
    with pytest.raises(InputError, match="Permission denied; choose another file"):
        files.write_text(path, "new")
    assert path.read_text() == "precious"


@needs_long_names
def test_names_may_be_as_long_as_the_system_allows(tmp_path):
    path = tmp_path / ("x" * 255)
    files.write_text(path, "new")
    assert path.read_text() == "new"
    with pytest.raises(InputError, match="File name too long"):
        files.write_text(tmp_path / ("x" * 256), "new")


@needs_modes
@needs_links
def test_writing_keeps_permissions_and_follows_links(tmp_path):
    path, link = tmp_path / "form.tex", tmp_path / "link.tex"
    path.write_text("old")
    path.chmod(0o640)
    link.symlink_to(path)
    files.write_text(link, "new")
    assert (path.read_text(), path.stat().st_mode & 0o777) == ("new", 0o640)
    assert link.is_symlink()


@needs_modes
def test_new_file_has_the_permissions_of_any_other(tmp_path):
    before = os.umask(0o027)
    try:
        files.write_texts({tmp_path / "new": "text"})
    finally:
        os.umask(before)
    assert (tmp_path / "new").stat().st_mode & 0o777 == 0o640


@needs_modes
def test_pipe_is_written_into(tmp_path):
    reading, writing = os.pipe()
    files.write_texts({Path(f"/dev/fd/{writing}"): "sent", tmp_path / "kept": "kept"})
    os.close(writing)
    with os.fdopen(reading) as pipe:
        assert pipe.read() == "sent"
    assert (tmp_path / "kept").read_text() == "kept"
