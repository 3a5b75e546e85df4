# SPDX-License-Identifier: Apache-2.0
"""docs/node.md is true: its parameters are the table's, its tests and services exist."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

from spiral_gripper_ros.parameters.spec import ParameterSpec
from spiral_gripper_ros.parameters.table import PARAMETERS

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/node.md").read_text(encoding="utf-8")


def _row(spec: ParameterSpec) -> list[str]:
    """Return the cells that the page should have for a parameter."""
    default = spec.default
    if isinstance(default, bool):
        shown = str(default).lower()
    elif isinstance(default, float):
        # as it must be typed: rclpy takes 1 for another type than 1.0
        shown = ".nan" if math.isnan(default) else repr(default)
    else:
        shown = "not set" if default == () else str(default)
    span = ", ".join(spec.choices) if spec.low is None else f"{spec.low:g} to {spec.high:g}"
    when = "read-only" if spec.read_only else "at once"
    return [f"`{spec.name}`", shown, span, when, spec.description]


@pytest.mark.parametrize("spec", PARAMETERS, ids=lambda spec: spec.name)
def test_every_parameter_stands_on_the_page_as_it_is(spec):
    (line,) = re.findall(rf"^\| `{spec.name}` \|.*$", PAGE, re.MULTILINE)
    assert [cell.strip() for cell in line.strip("|").split("|")] == _row(spec)


def test_the_page_has_no_other_parameters():
    table = PAGE.split("## Parameters")[1].split("## ")[0]
    assert re.findall(r"^\| `(\w+)`", table, re.MULTILINE) == [spec.name for spec in PARAMETERS]


def test_every_row_of_the_safety_contract_names_tests_that_exist():
    rows = re.findall(r"^\| .* \|$", PAGE.split("## Safety contract")[1], re.MULTILINE)[1:]
    sources = "".join(path.read_text(encoding="utf-8") for path in ROOT.glob("tests/ros/*.py"))
    tests = set(re.findall(r"def (test_\w+)", sources))
    for row in rows:
        named = set(re.findall(r"`(test_\w+)`", row))
        assert named, row
        assert named <= tests, named - tests


def test_every_service_and_topic_of_the_page_is_in_the_code():
    table = PAGE.split("## Topics, services and actions")[1].split("## ")[0]
    names = re.findall(r"^\|[^|]*\| `/?(\w+)` \|", table, re.MULTILINE)
    code = "".join(
        path.read_text() for path in ROOT.glob("spiral_gripper_ros/spiral_gripper_ros/**/*.py")
    )
    assert len(names) >= 10
    assert not [name for name in names if f'"{name}"' not in code and f'"/{name}"' not in code]
