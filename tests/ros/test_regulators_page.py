# SPDX-License-Identifier: Apache-2.0
"""docs/regulators.md is true: it names parameters that exist, and its lines are good ones."""

import re

from repo.source_tree import ROOT

from spiral_gripper_ros.regulators.line_protocol import (
    LINE_LENGTH_MAX,
    check_sum,
    measurement_from_line,
    set_point_from_line,
)
from spiral_gripper_ros.regulators.parameters import REGULATOR_PARAMETERS

PAGE = (ROOT / "docs/regulators.md").read_text(encoding="utf-8")


def test_what_the_page_says_to_set_is_there():
    names = {spec.name for spec in REGULATOR_PARAMETERS}
    table = PAGE.split("## What to set")[1].split("The path of a number")[0]
    set_there = re.findall(r"`((?:command|measured)_[a-z]+|device|host|port)\b", table)
    assert len(set_there) > 20
    assert set(set_there) <= names | {"measured_"}


def test_the_lines_of_the_page_are_good_ones():
    sent, answered = re.findall(r"^([SM] .*\*[0-9A-F]{4}) ", PAGE, re.MULTILINE)
    assert set_point_from_line(sent.encode()) is not None
    assert measurement_from_line(answered.encode()) is not None
    assert f"gives {check_sum('123456789')}" in PAGE
    assert f"at most {LINE_LENGTH_MAX} characters" in PAGE
