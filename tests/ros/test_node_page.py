# SPDX-License-Identifier: Apache-2.0
"""The node's pages are true: interfaces are in the code, the contract's tests exist."""

import re

import pytest
from repo.source_tree import ROOT
from ros import launch_stand_ins

from spiral_gripper_ros.simulation.regulator import Fault

SERVICES = {f"inject_{fault.value}" for fault in Fault}
CONTRACT = "".join(path.read_text(encoding="utf-8") for path in ROOT.glob("docs/safety*.md"))


def section(page, title):
    text = (ROOT / f"docs/{page}.md").read_text(encoding="utf-8")
    return re.split(r"\n##+ ", text.split(f"# {title}\n")[1])[0]


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


@pytest.mark.parametrize(
    ("page", "title", "folder"),
    [
        ("node_interfaces", "Topics, services and actions", ""),
        ("simulation", "Topics and services", "simulation/"),
    ],
)
def test_every_service_and_topic_of_a_page_is_in_the_code(page, title, folder):
    names = re.findall(r"^\|[^|]*\| `/?([\w/]+)` \|", section(page, title), re.MULTILINE)
    sources = ROOT.glob(f"spiral_gripper_ros/spiral_gripper_ros/{folder}**/*.py")
    code = "".join(path.read_text(encoding="utf-8") for path in sources)
    assert len(names) >= 10
    told = {word.lstrip("/") for word in re.findall(r'"(/?[\w/]+)"', code)}
    assert not [name for name in names if name.rpartition("regulator/")[2] not in told | SERVICES]


def test_every_fault_and_service_stands_on_the_page():
    services = re.findall(
        r"`simulated_regulator/(\w+)` \| `std_srvs", section("simulation", "Topics and services")
    )
    named = [fault.value for fault in Fault if fault is not Fault.NONE]
    assert services == [*(f"inject_{name}" for name in named), "clear_fault"]
    assert re.findall(r"^\| `(\w+)` \|", section("simulation", "Faults"), re.MULTILINE) == named


def test_every_launch_argument_stands_on_the_page(monkeypatch):
    launch_stand_ins.install(monkeypatch)
    table = section("simulation", "Launch files and RViz")
    rows = re.findall(r"^\| `([\w.]+\.launch\.py)` \|[^|]*\|(.*)\|$", table, re.MULTILINE)
    assert len(rows) == len(list((ROOT / "spiral_gripper_ros/launch").glob("*.py")))
    for name, listed in rows:
        declared = launch_stand_ins.arguments(ROOT / "spiral_gripper_ros/launch" / name)
        assert set(re.findall(r"`(\w+)`", listed)) == set(declared)
