# SPDX-License-Identifier: Apache-2.0
"""The node's parameters: what they may be, the limits they make, and what nobody has."""

import math
import re
from dataclasses import fields
from pathlib import Path

import pytest
from repo.source_tree import ROOT
from ros.control_bench import rows
from ros.records import agrees, told

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

# Keys of a file and their parameters, then arguments: names for another node, unknown names, which
# are warnings in a section for every node.
FILES = """
/**: {pressure.cap: 2.0e4, gripper: p1}
/left/spiral_gripper: {pressure: {cap: 2.0e4}}
/**/spiral_gripper: {pressure: {cap: 2.0e4}}
/left/*: {pressure.cap: 2.0e4}
/left/spiral_*: {pressure.cap: 2.0e4}
spiral_gripper: {pressure.cap: 2.0e4}
/left/other: {pressure.cap: 2.0e4}
/left/helper: {pressure.cap: 2.0e4}
/*: {pressure.cap: 2.0e4}
/left: {pressure.cap: 2.0e4}
/**/left/spiral_gripper: {pressure: {cpa: 2.0e4}, gripper: p1}
/**: {pressure: {cpa: 2.0e4}, gripper: p1}
/**/spiral_gripper: {pressure: {cap: {deep: 1}}}
/**: {pressure: {cap: {deep: 1}}}
"""
ARGUMENTS = """
--ros-args
--ros-args -p pressure.cap:=1.0 -p use_sim_time:=true
--ros-args -p qos_overrides./x.publisher.depth:=1
--ros-args -p camera:=1
--ros-args --param spiral_gripper:camera:=1
--ros-args -p other:camera:=1
--ros-args -p seed:=1 -p helper:seed:=1
--ros-args -p spiral_gripper:seed:=1 -p helper:gripper:=p1
--ros-args -r a:=b -- -p camera:=2
-p camera:=1
--ros-args --params-file none.yaml
"""


def judge(*arguments, known=("pressure.cap", "gripper", "use_sim_time")):
    return judge_given_parameters(arguments, {NODE: known, "/left/helper": ["seed"]})


def test_what_is_given_at_start_is_judged_as_on_record(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs/node_parameters.md").read_text(encoding="utf-8")
    (shown,) = re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)
    texts = [row.replace(": ", ": {ros__parameters: ", 1) + "}" for row in rows(FILES)]
    texts.append("left: {spiral_gripper: {ros__parameters: {pressure.cap: 2.0e4}}}")
    found, from_file = [], ("--ros-args", "--params-file", "given.yaml")
    for text in texts:
        Path("given.yaml").write_text(text)
        found += [f"# {text}", told(judge(*from_file))]
    for row in rows(ARGUMENTS):
        found += [f"# {row}", told(judge(*row.split()))]
    agrees("given", "\n".join(found))
    Path("given.yaml").write_text(shown)
    findings = judge(*from_file, known=[spec.name for spec in PARAMETERS])
    assert findings.errors == findings.warnings == []
