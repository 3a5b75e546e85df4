# SPDX-License-Identifier: Apache-2.0
"""docs/simulation.md is true: topics, services, faults and arguments."""

import re

from repo.source_tree import ROOT
from ros import launch_stand_ins

from spiral_gripper_ros.simulation.regulator import Fault
from spiral_gripper_ros.simulation.simulated_gripper import Grip

PAGE = (ROOT / "docs/simulation.md").read_text(encoding="utf-8")


def section(title):
    return re.split(r"\n##+ ", PAGE.split(f"# {title}\n")[1])[0]


def test_every_topic_of_the_page_is_in_the_code():
    table = section("Topics and services")
    code = "".join(
        path.read_text(encoding="utf-8")
        for path in ROOT.glob("spiral_gripper_ros/spiral_gripper_ros/simulation/*.py")
    )
    names = re.findall(r"^\|[^|]*\| `(/?[\w/]+)` \| `\w+/msg", table, re.MULTILINE)
    assert len(names) == 9
    assert not [name for name in names if f'"{name}"' not in code]
    for grip in Grip:
        assert grip.value in table


def test_every_fault_and_service_stands_on_the_page():
    services = re.findall(
        r"`simulated_regulator/(\w+)` \| `std_srvs", section("Topics and services")
    )
    named = [fault.value for fault in Fault if fault is not Fault.NONE]
    assert services == [*(f"inject_{name}" for name in named), "clear_fault"]
    assert re.findall(r"^\| `(\w+)` \|", section("Faults"), re.MULTILINE) == named


def test_every_test_that_the_page_names_exists():
    sources = "".join(path.read_text(encoding="utf-8") for path in ROOT.glob("tests/ros/*.py"))
    tests = set(re.findall(r"def (test_\w+)", sources))
    named = set(re.findall(r"`(test_\w+)`", PAGE))
    assert len(named) >= 7
    assert named <= tests, named - tests


def test_every_launch_argument_stands_on_the_page(monkeypatch):
    launch_stand_ins.install(monkeypatch)
    table = section("Launch files and RViz")
    rows = re.findall(r"^\| `([\w.]+\.launch\.py)` \|[^|]*\|(.*)\|$", table, re.MULTILINE)
    assert len(rows) == len(list((ROOT / "spiral_gripper_ros/launch").glob("*.py")))
    for name, listed in rows:
        declared = launch_stand_ins.arguments(ROOT / "spiral_gripper_ros/launch" / name)
        assert set(re.findall(r"`(\w+)`", listed)) == set(declared)
