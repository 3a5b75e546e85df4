# SPDX-License-Identifier: Apache-2.0
"""Files are found by name or path, read within bounds, and written whole or not at all."""

import errno
import math
import os
from contextlib import nullcontext
from pathlib import Path
from unittest.mock import Mock

import pytest
from edge.recorded import cases, check

from spiral_gripper import DescriptionError, available_grippers, load_description, load_gripper
from spiral_gripper.files import storage
from spiral_gripper.files.catalog import find_description
from spiral_gripper.files.storage import LARGEST_FILE, FileError, read_text, write_file

# What the paper and our readings say, and the angle of the second family [deg] and the length [m].
SHARED = {
    "tube.inner_radius": 4.7625e-3,
    "tube.wall_thickness": 0.794e-3,
    "fibers.alpha": math.radians(88.0),
    "material.c1": 130e3,
    "material.c2": 15e3,
    "material.density": 950.0,
    # The highest pressure at which the paper shows shapes: eight steps of 2 psi.
    "limits.pressure_max": 8 * 13.7895e3,
}
SHIPPED = {"paper_design_70": (70, 0.361), "prototype_p1": (50, 0.5), "prototype_p2": (60, 0.5)}


def test_shipped_files_say_what_the_paper_and_our_readings_say():
    assert available_grippers() == tuple(SHIPPED)
    for name, (beta, length) in SHIPPED.items():
        stated = SHARED | {"fibers.beta": math.radians(beta), "tube.length": length}
        values = load_description(name).values
        assert {field: values[field] for field in stated} == pytest.approx(stated, rel=2e-6)
        assert (values["material.law"], values["model.pressure_law"]) == (
            "mooney_rivlin", "uniform",
        )  # fmt: skip


def test_a_name_is_a_shipped_gripper_whatever_the_folder_holds():
    Path("prototype_p1").write_text("name: impostor\n")
    assert load_gripper("prototype_p1").name == "prototype_p1"
    with pytest.raises(DescriptionError):
        load_gripper("./prototype_p1")
    assert find_description("./mine") == find_description(Path("mine")) == Path("mine")


@pytest.mark.parametrize("asked", cases("grippers_not_there.txt"))
def test_a_gripper_that_is_not_there(asked):
    with pytest.raises(DescriptionError) as caught:
        load_gripper(asked)
    check("grippers_not_there.txt", asked, [str(caught.value)])


def test_a_byte_order_mark_and_windows_line_ends_are_read(mine):
    mine.write_text(mine.read_text("utf-8"), "utf-8-sig", newline="\r\n")
    assert load_gripper(mine) == load_gripper("paper_design_70")
    mine.write_bytes(b"\xef\xbb\xbf# 1\r\nname: 2\r\n")
    with pytest.raises(DescriptionError, match=":2:7: name must be"):
        load_gripper(mine)


def test_text_is_read_up_to_the_limit():
    path = Path("large.csv")
    for more in (0, 1):
        path.write_text("a" * (LARGEST_FILE + more))
        with pytest.raises(FileError, match="more than 2 MB") if more else nullcontext():
            assert len(read_text(path)) == LARGEST_FILE


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
def test_what_cannot_be_read_or_written_says_why(name, cannot_be_read, cannot_be_written):
    os.mkfifo("pipe")
    Path("loop").symlink_to("loop")
    Path("bytes").write_bytes(b"ab\xff")
    with pytest.raises(FileError, match=cannot_be_read):
        read_text(Path(name))
    if cannot_be_written:
        with pytest.raises(FileError, match=cannot_be_written):
            write_file(Path(name), "")


def test_a_file_is_written_as_any_other_replaced_on_request_and_a_link_stays_a_link():
    other, mine, link = map(Path, ("other", "mine", "link"))
    other.write_text("")
    link.symlink_to(mine)
    write_file(link, "ä")
    assert link.is_symlink()
    assert mine.stat().st_mode == other.stat().st_mode
    with pytest.raises(FileError, match="exists already and is kept"):
        write_file(mine, "other", replace=False)
    assert mine.read_bytes() == "ä".encode()
    write_file(mine, b"\0")
    assert mine.read_bytes() == b"\0"


@pytest.mark.parametrize("replace", [True, False])
@pytest.mark.parametrize("cause", [OSError(errno.ENOSPC, "No space left"), KeyboardInterrupt()])
def test_a_write_that_fails_leaves_everything_as_it_was(monkeypatch, replace, cause):
    path = Path("mine")
    if replace:
        path.write_text("before")
    monkeypatch.setattr(storage.os, "fsync", Mock(side_effect=cause))
    with pytest.raises((FileError, KeyboardInterrupt), match=r"^$|written: the disk is full"):
        write_file(path, "after", replace=replace)
    assert [one.read_text() for one in Path().iterdir()] == ["before"] * replace
