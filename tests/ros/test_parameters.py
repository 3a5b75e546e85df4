# SPDX-License-Identifier: Apache-2.0
"""The node's parameters: what they may be, the limits they make, and what nobody has."""

import math
import re
from dataclasses import fields

import pytest
from repo.source_tree import ROOT
from ros.control_bench import rows

from spiral_core import InvalidInputError
from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.parameters.given import judge_given_parameters
from spiral_gripper_ros.parameters.spec import GRAVITY_LIMIT, may_be_unset
from spiral_gripper_ros.parameters.table import PARAMETERS, GripperParameters

NODE = "/left/spiral_gripper"


@pytest.mark.parametrize("spec", PARAMETERS, ids=lambda spec: spec.name)
def test_what_lies_within_its_range_or_choices_is_accepted_and_nothing_else(spec):
    good, bad = [spec.default, *spec.choices], []
    if spec.low is not None:
        good += [spec.low, spec.high]
        bad += [spec.low - 1.0, 2.0 * spec.high, 10**400, math.inf, -math.inf, True, "1"]
        bad += [] if may_be_unset(spec) else [math.nan]
    elif isinstance(spec.default, str) and spec.default:
        bad.append("panic" if spec.choices else "")
    elif isinstance(spec.default, tuple):
        good.append((0.0, 0.0, 0.0))
        bad += [(1.0, 2.0), (math.nan, 0.0, 0.0), (0.0, 0.0, 1.01 * GRAVITY_LIMIT)]
    assert [GripperParameters.refusal({spec.name: value}) for value in good] == [None] * len(good)
    for value in bad:
        refusal = GripperParameters.refusal({spec.name: value})
        assert spec.name in refusal
        assert all(choice in refusal for choice in spec.choices)


@pytest.mark.parametrize(
    ("parameter", "expected"),
    [(math.nan, 1.0e5), (0.0, 0.0), (6.0e4, 6.0e4), (9.0e5, 1.0e5)],
)
def test_no_parameter_raises_the_cap_above_the_grippers_limit(parameter, expected):
    values = GripperParameters.from_names({"pressure.cap": parameter})
    assert values.limits(pressure_max=1.0e5).pressure_cap == expected


@pytest.mark.parametrize("field", fields(Limits), ids=lambda field: field.name)
def test_every_limit_comes_from_the_parameter_of_its_name_has_its_default_and_its_range(field):
    own = GripperParameters().limits(pressure_max=1.0e6)
    assert own == Limits(pressure_cap=1.0e6, grip_ratio=None)
    before = getattr(own, field.name)
    (spec,) = [one for one in PARAMETERS if one.name.replace(".", "_") == field.name]
    value = 0.5 * (spec.low + spec.high) if spec.choices == () else spec.choices[-1]
    changed = GripperParameters.from_names({spec.name: value}).limits(pressure_max=1.0e6)
    changed = getattr(changed, field.name)
    assert getattr(changed, "value", changed) == value != before
    for bad in ["vent"] if spec.choices else [math.nan, math.inf, -1.0]:
        with pytest.raises(InvalidInputError, match=f"{field.name} must be"):
            Limits(**{"pressure_cap": 1.0e5, field.name: bad})


# --- what is given at start and nobody has ---------------------------------------------------


def judge(*args, known=("pressure.cap", "gripper")):
    return judge_given_parameters(args, [NODE], known)


@pytest.fixture
def judged(tmp_path):
    """Judges the text of a file."""

    def judge_text(text, **known):
        path = tmp_path / "given.yaml"
        path.write_text(text)
        return judge("--ros-args", "--params-file", str(path), **known)

    return judge_text


KEYS = """
0 /**
0 /left/spiral_gripper
0 /**/spiral_gripper
0 /left/*
0 /left/spiral_*
0 left: {spiral_gripper
1 spiral_gripper
1 /left/other
1 /*
1 /left
"""


@pytest.mark.parametrize("row", rows(KEYS))
def test_a_file_for_another_node_is_an_error(judged, row):
    count, key = row.split(" ", 1)
    findings = judged(f"{key}: {{ros__parameters: {{pressure.cap: 2.0e4}}}}{'}' * ('{' in key)}")
    assert (len(findings.errors), findings.warnings) == (int(count), [])
    for error in findings.errors:
        assert f"has no parameters for {NODE}, only for /{key.strip('/')}" in error
        assert "/**/spiral_gripper" in error


VALUES = """
{pressure: {cap: 2.0e4}} -> none
{pressure: {cpa: 2.0e4}, gripper: p1} -> pressure.cpa
{pressure: {cap: {deep: 1}}} -> pressure.cap.deep
"""


@pytest.mark.parametrize("row", rows(VALUES))
def test_a_foreign_name_is_an_error_or_in_a_section_for_every_node_a_warning(judged, row):
    values, unknown = row.split(" -> ")
    own, of_all = (judged(f"{key}: {{ros__parameters: {values}}}") for key in (f"/**{NODE}", "/**"))
    assert own.warnings == of_all.errors == []
    assert own.errors == of_all.warnings
    assert len(own.errors) == (unknown != "none")
    assert all(f"{unknown} is not" in one and "mean pressure.cap?" in one for one in own.errors)


def test_the_file_on_the_page_has_names_of_the_node(judged):
    page = (ROOT / "docs/node_parameters.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)
    findings = judged(text, known=[spec.name for spec in PARAMETERS])
    assert findings.errors == findings.warnings == []


# Arguments, and how many errors they are.
ARGUMENTS = """
0 --ros-args
0 --ros-args -p pressure.cap:=1.0 -p use_sim_time:=true
0 --ros-args -p qos_overrides./x.publisher.depth:=1
1 --ros-args -p camera:=1
1 --ros-args --param spiral_gripper:camera:=1
0 --ros-args -p other:camera:=1
0 --ros-args -r a:=b -- -p camera:=2
0 -p camera:=1
1 --ros-args --params-file none.yaml
"""


@pytest.mark.parametrize("row", rows(ARGUMENTS))
def test_names_on_the_command_line_are_judged_for_their_node(row):
    count, *args = row.split()
    assert len(judge(*args).errors) == int(count)
