# SPDX-License-Identifier: Apache-2.0
import os

import pytest

from spiral_gripper.files.catalog import GRIPPERS
from spiral_gripper.files.storage import LARGEST_FILE
from spiral_gripper_ros.node.proposed_gripper import ProposedGripper


def test_a_good_gripper_is_read_and_kept():
    proposed = ProposedGripper()
    assert proposed.refusal({"gripper": "prototype_p1"}) is None
    assert proposed.description.gripper.name == "prototype_p1"
    assert proposed.refusal({"radius.timeout": 1.0}) is None
    assert proposed.description is None


def test_a_file_is_read_by_its_path(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text((GRIPPERS.path / "prototype_p2.yaml").read_text())
    proposed = ProposedGripper()
    assert proposed.refusal({"gripper": str(file)}) is None
    assert proposed.description.source == file


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("no_such_gripper", "no gripper has this name"),
        ("./nowhere.yaml", "there is no such file"),
        ("/dev/zero", "not a plain file"),
        (os.curdir, "it is a folder"),
        ("null\0byte.yaml", "null"),
    ],
)
def test_what_cannot_be_read_is_refused_with_the_reason(name, reason):
    proposed = ProposedGripper()
    assert reason in proposed.refusal({"gripper": name})
    assert proposed.description is None


def test_a_pipe_is_refused_and_does_not_hold_up_the_node(tmp_path):
    pipe = tmp_path / "pipe.yaml"
    os.mkfifo(pipe)
    assert "not a plain file" in ProposedGripper().refusal({"gripper": str(pipe)})


def test_a_file_that_is_too_long_is_refused_unread(tmp_path):
    file = tmp_path / "long.yaml"
    with file.open("wb") as opened:
        opened.truncate(LARGEST_FILE + 1)
    assert "more than 2 MB" in ProposedGripper().refusal({"gripper": str(file)})


def test_a_description_with_mistakes_is_refused_with_all_of_them(tmp_path):
    file = tmp_path / "wrong.yaml"
    text = (GRIPPERS.path / "prototype_p2.yaml").read_text()
    file.write_text(text.replace("length:", "lenght:", 1))
    refusal = ProposedGripper().refusal({"gripper": str(file)})
    assert "lenght" in refusal
