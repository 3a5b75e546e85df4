# SPDX-License-Identifier: Apache-2.0
"""The node's pages are true: interfaces are in the code, the contract's tests exist."""

import re

from repo.source_tree import ROOT

INTERFACES = (ROOT / "docs/node_interfaces.md").read_text(encoding="utf-8")
CONTRACT = "".join(path.read_text(encoding="utf-8") for path in ROOT.glob("docs/safety*.md"))


def test_every_row_of_the_safety_contract_names_tests_that_exist():
    rows = re.findall(r"^\| .* \|$", CONTRACT, re.MULTILINE)
    sources = "".join(path.read_text(encoding="utf-8") for path in ROOT.glob("tests/ros/*.py"))
    tests = set(re.findall(r"def (test_\w+)", sources))
    stated = [row for row in rows if not row.startswith("| event |")]
    assert len(stated) > 70
    for row in stated:
        named = set(re.findall(r"`(test_\w+)`", row))
        assert named, row
        assert named <= tests, named - tests


def test_every_service_and_topic_of_the_page_is_in_the_code():
    table = INTERFACES.split("## Topics, services and actions")[1].split("## ")[0]
    names = re.findall(r"^\|[^|]*\| `/?(\w+)` \|", table, re.MULTILINE)
    code = "".join(
        path.read_text() for path in ROOT.glob("spiral_gripper_ros/spiral_gripper_ros/**/*.py")
    )
    assert len(names) >= 10
    assert not [name for name in names if f'"{name}"' not in code and f'"/{name}"' not in code]
