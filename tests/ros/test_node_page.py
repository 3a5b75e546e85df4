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
    "page", ["node_interfaces: Topics, services and actions", "simulation: Topics and services"]
)
def test_every_service_and_topic_of_a_page_stands_in_the_policies(page):
    """Which are what the nodes do (test_security.py)."""
    names = re.findall(r"^\|[^|]*\| `/?([\w/]+)` \|", section(*page.split(": ")), re.MULTILINE)
    assert len(names) >= 10
    known = re.findall(r">[~/]*([\w/]+)<", text_of("spiral_gripper_ros/security/*.xml"))
    assert {name.removeprefix("simulated_regulator/") for name in names} <= set(known)


def test_every_fault_stands_on_the_page():
    found = re.findall(r"^\| `(\w+)` \|", section("simulation", "Faults"), re.MULTILINE)
    assert found == FAULTS
