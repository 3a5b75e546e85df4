# SPDX-License-Identifier: Apache-2.0
"""The node's parameters: what they may be, the limits they make, and what nobody has."""

import math
import os
import re
from dataclasses import fields

import pytest
from repo.source_tree import ROOT
from ros.control_bench import rows

from spiral_core import InvalidInputError
from spiral_gripper.files.catalog import GRIPPERS
from spiral_gripper.files.storage import LARGEST_FILE
from spiral_gripper_ros.control.limits import HIGHEST_GRIP_RATIO, Limits
from spiral_gripper_ros.node.proposed_gripper import ProposedGripper
from spiral_gripper_ros.parameters.given import judge_given_parameters
from spiral_gripper_ros.parameters.spec import GRAVITY_LIMIT, gravity_problem, may_be_unset
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
    assert GripperParameters.refusal({"use_sim_time": True}) is None
    for value in good:
        assert GripperParameters.refusal({spec.name: value}) is None
    for value in bad:
        refusal = GripperParameters.refusal({spec.name: value})
        assert spec.name in refusal
        assert all(choice in refusal for choice in spec.choices)


@pytest.mark.parametrize(
    "gravity",
    [(1.0, 2.0), (1.0, 2.0, 3.0, 4.0), (math.nan, 0.0, 0.0), (0.0, 0.0, 1.01 * GRAVITY_LIMIT)],
)
def test_a_gravity_that_is_none_is_refused_but_weightlessness_is_one(gravity):
    assert gravity_problem((0.0, 0.0, 0.0)) is None
    assert gravity_problem(gravity) is not None
    assert GripperParameters.refusal({"gravity.vector": gravity}) is not None


@pytest.mark.parametrize(
    ("parameter", "expected"),
    [(math.nan, 1.0e5), (0.0, 0.0), (6.0e4, 6.0e4), (9.0e5, 1.0e5)],
)
def test_no_parameter_raises_the_cap_above_the_grippers_limit(parameter, expected):
    values = GripperParameters.from_names({"pressure.cap": parameter})
    assert values.limits(pressure_max=1.0e5).pressure_cap == expected


def test_every_limit_comes_from_the_parameter_of_its_name_and_has_its_default():
    own = GripperParameters().limits(pressure_max=1.0e5)
    assert own == Limits(pressure_cap=1.0e5, grip_ratio=None)
    by_name = {spec.name.replace(".", "_"): spec for spec in PARAMETERS}
    for field in fields(Limits):
        spec, before = by_name[field.name], getattr(own, field.name)
        if field.name == "pressure_cap":
            continue
        value = (
            spec.high
            if spec.low is not None
            else next(choice for choice in spec.choices if choice != before.value)
        )
        limits = GripperParameters.from_names({spec.name: value}).limits(pressure_max=1.0e5)
        changed = getattr(limits, field.name)
        assert getattr(changed, "value", changed) == value != before


@pytest.mark.parametrize("field", fields(Limits), ids=lambda field: field.name)
def test_limits_refuse_what_is_no_limit(field):
    bad = [math.nan, math.inf, -1.0]
    if field.name == "grip_ratio":
        bad += [0.999, math.nextafter(HIGHEST_GRIP_RATIO, 2.0)]
    if field.name.endswith("policy"):
        bad = ["vent"]
    for value in bad:
        with pytest.raises(InvalidInputError, match=f"{field.name} must be"):
            Limits(**{"pressure_cap": 1.0e5, field.name: value})


# --- a gripper that is proposed --------------------------------------------------------------


def test_a_good_gripper_is_read_and_kept_until_the_next_proposal(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text((GRIPPERS.path / "prototype_p2.yaml").read_text())
    proposed = ProposedGripper()
    assert proposed.refusal({"gripper": str(file)}) is None
    assert proposed.description.source == file
    assert proposed.refusal({"radius.timeout": 1.0}) is None
    assert proposed.description is None


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("no_such_gripper", "no gripper has this name"),
        ("nowhere.yaml", "there is no such file"),
        ("pipe.yaml", "not a plain file"),  # and does not hold up the node
        ("long.yaml", "more than 2 MB"),
        ("wrong.yaml", "lenght"),
        (os.curdir, "it is a folder"),
        ("null\0byte.yaml", "null"),
    ],
)
def test_what_cannot_be_read_is_refused_with_the_reason(tmp_path, monkeypatch, name, reason):
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe.yaml")
    os.truncate(os.open("long.yaml", os.O_CREAT | os.O_WRONLY), LARGEST_FILE + 1)
    text = (GRIPPERS.path / "prototype_p2.yaml").read_text()
    (tmp_path / "wrong.yaml").write_text(text.replace("length:", "lenght:", 1))
    path = f"./{name}" if name.endswith(".yaml") else name
    proposed = ProposedGripper()
    assert reason in proposed.refusal({"gripper": path})
    assert proposed.description is None


# --- what is given at start and nobody has ---------------------------------------------------


def judge(*args, ros="--ros-args"):
    return judge_given_parameters([ros, *args], [NODE], ["pressure.cap", "gripper"])


@pytest.fixture
def judged(tmp_path):
    """Judges the text of a file."""

    def judge_text(text):
        path = tmp_path / "given.yaml"
        path.write_text(text)
        return judge("--params-file", str(path))

    return judge_text


FOR_THE_NODE = (
    "/** /left/spiral_gripper /**/spiral_gripper /left/* /left/spiral_* left:{spiral_gripper"
)
FOR_OTHERS = "spiral_gripper /left/other /* /left"


@pytest.mark.parametrize("key", [*FOR_THE_NODE.split(), *FOR_OTHERS.split(), ""])
def test_a_file_for_another_node_is_an_error(judged, key):
    applies = key in FOR_THE_NODE.split()
    key = key.replace(":", ": ")  # nested
    end = "}}" if "{" in key else "}"
    findings = judged(f"{{{key}: {{ros__parameters: {{pressure.cap: 2.0e4}}}}{end}")
    assert (len(findings.errors), findings.warnings) == (0 if applies else 1, [])
    for error in findings.errors:
        assert f"has no parameters for {NODE}, only for /{key.strip('/')}" in error
        assert "/**/spiral_gripper" in error


@pytest.mark.parametrize(
    ("values", "unknown"),
    [
        ("{pressure: {cap: 2.0e4}}", []),
        ("{pressure: {cpa: 2.0e4}, gripper: p1}", ["pressure.cpa"]),
        ("{pressure: {cap: {deep: 1}}}", ["pressure.cap.deep"]),
    ],
)
def test_a_foreign_name_is_an_error_or_in_a_section_for_every_node_a_warning(
    judged, values, unknown
):
    own = judged(f"/**/spiral_gripper: {{ros__parameters: {values}}}")
    of_all = judged(f"/**: {{ros__parameters: {values}}}")
    assert own.warnings == of_all.errors == []
    assert own.errors == of_all.warnings
    assert [error.split(": ")[1].split(" is not")[0] for error in own.errors] == unknown
    assert all("did you mean pressure.cap?" in error for error in own.errors)


def test_the_file_on_the_page_has_names_of_the_node(tmp_path):
    page = (ROOT / "docs/node_parameters.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)
    path = tmp_path / "given.yaml"
    path.write_text(text)
    args = ["--ros-args", "--params-file", str(path)]
    findings = judge_given_parameters(args, [NODE], [spec.name for spec in PARAMETERS])
    assert findings.errors == findings.warnings == []


# Arguments, and how many errors they are.
ARGUMENTS = """
0:
0: -p pressure.cap:=1.0 -p use_sim_time:=true
0: -p qos_overrides./x.publisher.depth:=1
1: -p camera:=1
1: --param spiral_gripper:camera:=1
0: -p other:camera:=1
0: -r a:=b -- -p camera:=2
1: --params-file none.yaml
"""


@pytest.mark.parametrize("row", rows(ARGUMENTS))
def test_names_on_the_command_line_are_judged_for_their_node(row):
    count, args = int(row[0]), row[2:].split()
    assert len(judge(*args).errors) == count
    assert not judge(*args, ros="--").errors
