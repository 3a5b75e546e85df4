# SPDX-License-Identifier: Apache-2.0
"""Files are found by name or path, read within bounds, and written whole or not at all."""

import errno
import os
from pathlib import Path

import numpy as np
import pytest

from spiral_core import MooneyRivlin
from spiral_gripper import DescriptionError, available_grippers, load_description, load_gripper
from spiral_gripper.files import storage
from spiral_gripper.files.catalog import GRIPPERS, find_description
from spiral_gripper.files.storage import LARGEST_FILE, FileError, read_text, write_file

# Name, angle of the second family [deg], length [m] and other figures of the paper and our own.
SHIPPED = [
    ("paper_design_70", 70, 0.361),
    ("prototype_p1", 50, 0.5),
    ("prototype_p2", 60, 0.5),
]


@pytest.mark.parametrize(("name", "beta", "length"), SHIPPED)
def test_shipped_files_say_what_the_paper_and_our_readings_say(name, beta, length):
    assert available_grippers() == tuple(row[0] for row in SHIPPED)
    description = load_description(name)
    actuator, gripper = description.actuator, description.gripper
    tube, fibers = actuator.tube, np.degrees([actuator.fibers.alpha, actuator.fibers.beta])
    figures = (tube.inner_radius, tube.wall_thickness, tube.length, *fibers, description.density)
    assert figures == pytest.approx((4.7625e-3, 0.794e-3, length, 88.0, beta, 950.0))
    assert actuator.material == MooneyRivlin(c1=130e3, c2=15e3)
    # The highest pressure at which the paper shows shapes: eight steps of 2 psi.
    assert gripper.pressure_max == pytest.approx(8 * 13.7895e3, rel=2e-6)  # stated to six digits
    assert description.written["model.pressure_law"] == actuator.pressure_law.value == "uniform"


def test_a_name_is_a_shipped_gripper_whatever_the_folder_holds(tmp_path, monkeypatch):
    (tmp_path / "prototype_p1").write_text("name: impostor\n")
    monkeypatch.chdir(tmp_path)
    assert load_gripper("prototype_p1").name == "prototype_p1"
    with pytest.raises(DescriptionError):
        load_gripper("./prototype_p1")
    for path in ("mine.yaml", "./mine", Path("mine")):
        assert find_description(path) == Path(path)


NOT_THERE = {
    "prototype_p3": "no gripper has this name; did you mean prototype_p2? the shipped grippers are",
    "xyzzy": "no gripper has this name; the shipped grippers are paper_design_70, prototype",
    "": "no gripper has this name; the shipped grippers are paper_design_70, prototype",
    "protoype_p1.yaml": "there is no such file; did you mean prototype_p1? the shipped grippers",
    ".": "it is a folder",
}


@pytest.mark.parametrize("asked", NOT_THERE)
def test_a_gripper_that_is_not_there(asked):
    with pytest.raises(DescriptionError) as caught:
        load_gripper(asked)
    named = asked or '""'
    assert str(caught.value).startswith(f"{named}: this file cannot be read: {NOT_THERE[asked]}")


def test_a_byte_order_mark_and_windows_line_ends_are_read(tmp_path):
    text, path = (GRIPPERS.path / "prototype_p1.yaml").read_text("utf-8"), tmp_path / "mine.yaml"
    for written in (text, text.replace("500 mm  ", "500")):
        path.write_bytes(written.replace("\n", "\r\n").encode("utf-8-sig"))
        if written == text:
            assert load_gripper(path) == load_gripper("prototype_p1")
    with pytest.raises(DescriptionError) as caught:
        load_gripper(path)
    assert caught.value.problems[0].line == text[: text.index("500 mm  ")].count("\n") + 1


def test_text_is_read_up_to_the_limit(tmp_path):
    path = tmp_path / "large.csv"
    path.write_bytes(b"\xef\xbb\xbf" + b"a" * (LARGEST_FILE - 3))
    assert read_text(path) == "a" * (LARGEST_FILE - 3)
    path.write_bytes(b"a" * (LARGEST_FILE + 1))
    with pytest.raises(FileError, match="more than 2 MB"):
        read_text(path)


@pytest.mark.parametrize(
    ("name", "cannot_be_read", "cannot_be_written"),
    [
        ("/dev/zero", "a device or a pipe", "not a plain file"),
        ("/proc/self/mem", "the device reports a failure", ""),
        ("pipe", "a device or a pipe", "not a plain file"),
        ("no/file", "there is no such file", "there is no folder"),
        ("a\0b", "null character", "null character"),
        ("a" * 300, "its name is too long", "its name is too long"),
        ("loop", "its links lead in a circle", ""),
        ("bytes", r"it is not text in UTF-8 \(byte 3 is 0xff\)", ""),
        ("", "it is a folder", ""),
    ],
)
def test_what_cannot_be_read_or_written_says_why(tmp_path, name, cannot_be_read, cannot_be_written):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    (tmp_path / "bytes").write_bytes(b"ab\xff")
    with pytest.raises(FileError, match=cannot_be_read):
        read_text(tmp_path / name)
    if cannot_be_written:
        with pytest.raises(FileError, match=cannot_be_written):
            write_file(tmp_path / name, "")


def test_a_file_is_written_as_any_other_replaced_on_request_and_a_link_stays_a_link(tmp_path):
    (tmp_path / "other").write_text("")
    mine, link = tmp_path / "mine", tmp_path / "link"
    link.symlink_to(mine)
    write_file(link, "ä")
    assert link.is_symlink()
    assert mine.read_bytes() == "ä".encode()
    assert mine.stat().st_mode == (tmp_path / "other").stat().st_mode
    with pytest.raises(FileError, match="exists already and is kept"):
        write_file(mine, "other", replace=False)
    assert mine.read_text(encoding="utf-8") == "ä"
    write_file(mine, b"\0")
    assert mine.read_bytes() == b"\0"


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
    assert [one.read_text() for one in tmp_path.iterdir()] == ["before"] * replace
