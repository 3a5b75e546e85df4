# SPDX-License-Identifier: Apache-2.0
"""The node's pages are true: interfaces are in the code, the contract's tests exist."""

import re

import pytest
from repo.source_tree import ROOT

from spiral_gripper_ros.simulation.regulator import Fault

FAULTS = [fault.value for fault in Fault if fault is not Fault.NONE]


def text_of(*patterns):
    return "".join(path.read_text("utf-8") for one in patterns for path in ROOT.glob(one))


def section(page, title):
    return re.split(r"\n##+ ", text_of(f"docs/{page}.md").split(f"# {title}\n")[1])[0]


def test_every_row_of_the_safety_contract_names_tests_that_exist():
    rows = re.findall(r"^\| (?!event ).* \|$", text_of("docs/safety*.md"), re.MULTILINE)
    tests = set(re.findall(r"def (test_\w+)", text_of("tests/ros/*.py")))
    assert len(rows) > 70
    for row in rows:
        named = set(re.findall(r"`(test_\w+)`", row))
        assert named, row
        assert named <= tests, named - tests


@pytest.mark.parametrize(
    ("page", "title", "folder"),
    [
        ("node_interfaces", "Topics, services and actions", ""),
        ("simulation", "Topics and services", "simulation/"),
    ],
)
def test_every_service_and_topic_of_a_page_is_in_the_code(page, title, folder):
    names = re.findall(r"^\|[^|]*\| `/?([\w/]+)` \|", section(page, title), re.MULTILINE)
    assert len(names) >= 10
    code = text_of(f"spiral_gripper_ros/spiral_gripper_ros/{folder}**/*.py")
    told = {word.lstrip("/") for word in re.findall(r'"(/?[\w/]+)"', code)}
    services = [f"inject_{name}" for name in FAULTS]
    others = [name.rpartition("regulator/")[2] for name in names]
    assert [name for name in others if name not in told] == (services if folder else [])


def test_every_fault_stands_on_the_page():
    found = re.findall(r"^\| `(\w+)` \|", section("simulation", "Faults"), re.MULTILINE)
    assert found == FAULTS
