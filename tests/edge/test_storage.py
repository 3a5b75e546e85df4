# SPDX-License-Identifier: Apache-2.0
"""Files are read within bounds, and written whole or not at all."""

import errno
import os
from pathlib import Path

import pytest

from spiral_gripper.files import storage
from spiral_gripper.files.storage import LARGEST_FILE, FileError, read_text, write_file


def test_text_is_read_up_to_the_limit(tmp_path):
    path = tmp_path / "large.csv"
    path.write_bytes(b"\xef\xbb\xbf" + b"a" * (LARGEST_FILE - 3))
    assert read_text(path) == "a" * (LARGEST_FILE - 3)
    path.write_bytes(b"a" * (LARGEST_FILE + 1))
    with pytest.raises(FileError, match="more than 2 MB"):
        read_text(path)


def test_devices_pipes_and_folders_are_refused_at_once(tmp_path):
    pipe = tmp_path / "pipe.csv"
    os.mkfifo(pipe)
    for path in (Path("/dev/zero"), pipe):
        with pytest.raises(FileError, match="a device or a pipe"):
            read_text(path)
    with pytest.raises(FileError, match="it is a folder"):
        read_text(tmp_path)


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("no.csv", "there is no such file"),
        ("a\0b", "null character"),
        ("a" * 300, "its name is too long"),
        ("loop", "its links lead in a circle"),
        ("bytes", r"it is not text in UTF-8 \(byte 3 is 0xff\)"),
    ],
)
def test_what_cannot_be_read_says_why(tmp_path, name, reason):
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    (tmp_path / "bytes").write_bytes(b"ab\xff")
    with pytest.raises(FileError, match=reason):
        read_text(tmp_path / name)


def test_a_file_is_written_with_the_permissions_of_any_other(tmp_path):
    (tmp_path / "other").write_text("")
    write_file(tmp_path / "mine", "ä")
    assert (tmp_path / "mine").read_bytes() == "ä".encode()
    assert (tmp_path / "mine").stat().st_mode == (tmp_path / "other").stat().st_mode
    write_file(tmp_path / "mine", b"\0")
    assert (tmp_path / "mine").read_bytes() == b"\0"


def test_an_existing_file_is_kept_where_it_must_be(tmp_path):
    path = tmp_path / "mine"
    path.write_text("mine")
    with pytest.raises(FileError, match="exists already and is kept"):
        write_file(path, "other", replace=False)
    assert path.read_text() == "mine"
    write_file(path, "other")
    assert path.read_text() == "other"


def test_a_link_stays_a_link(tmp_path):
    (tmp_path / "link").symlink_to(tmp_path / "target")
    write_file(tmp_path / "link", "text")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "target").read_text() == "text"


@pytest.mark.parametrize("replace", [True, False])
@pytest.mark.parametrize("cause", [OSError(errno.ENOSPC, "No space left"), KeyboardInterrupt()])
def test_a_write_that_fails_leaves_everything_as_it_was(tmp_path, monkeypatch, replace, cause):
    path = tmp_path / "mine"
    if replace:
        path.write_text("before")

    def fail(_handle):
        raise cause

    monkeypatch.setattr(storage.os, "fsync", fail)
    with pytest.raises((FileError, KeyboardInterrupt)) as caught:
        write_file(path, "after", replace=replace)
    if isinstance(cause, OSError):
        assert str(caught.value) == f"{path} cannot be written: the disk is full"
    assert [one.name for one in tmp_path.iterdir()] == (["mine"] if replace else [])
    assert not replace or path.read_text() == "before"


def test_what_cannot_be_written_says_why(tmp_path):
    with pytest.raises(FileError, match="there is no folder"):
        write_file(tmp_path / "no" / "mine", "")
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(FileError, match="it is not a plain file"):
        write_file(tmp_path / "pipe", "")
    with pytest.raises(FileError, match="its name is too long"):
        write_file(tmp_path / ("a" * 300), "")
    with pytest.raises(FileError, match="null character"):
        write_file(tmp_path / "a\0b", "")
