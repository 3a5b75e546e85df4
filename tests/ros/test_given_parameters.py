# SPDX-License-Identifier: Apache-2.0
"""Parameters given at start that nobody has."""

import re

import pytest
from repo.source_tree import ROOT

from spiral_gripper_ros.parameters.given import judge_given_parameters
from spiral_gripper_ros.parameters.table import PARAMETERS

KNOWN = ["pressure.cap", "gripper"]
NODE = "/left/spiral_gripper"


def judge(*args):
    return judge_given_parameters(["--ros-args", *args], [NODE], KNOWN)


def file_of(tmp_path, text):
    path = tmp_path / "given.yaml"
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    "key",
    [
        "/**",
        "/left/spiral_gripper",
        "/**/spiral_gripper",
        "/*/spiral_gripper",
        "/left/*",
        "/left/spiral_*",
    ],
)
def test_a_file_for_this_node_is_good(tmp_path, key):
    path = file_of(tmp_path, f"{key}:\n  ros__parameters:\n    pressure.cap: 2.0e4\n")
    findings = judge("--params-file", str(path))
    assert findings.errors == findings.warnings == []


def test_namespaces_may_be_nested(tmp_path):
    text = "left:\n  spiral_gripper:\n    ros__parameters:\n      pressure.cap: 2.0e4\n"
    assert not judge("--params-file", str(file_of(tmp_path, text))).errors


@pytest.mark.parametrize(
    "key", ["/right/spiral_gripper", "spiral_gripper", "/left/other", "/*", "/left"]
)
def test_a_file_for_another_node_is_an_error(tmp_path, key):
    path = file_of(tmp_path, f"{key}:\n  ros__parameters:\n    pressure.cap: 2.0e4\n")
    (error,) = judge("--params-file", str(path)).errors
    assert f"{path} has no parameters for {NODE}" in error
    assert "/" + key.strip("/") in error
    assert "/**/spiral_gripper" in error


@pytest.mark.parametrize("args", [[], ["--ros-args"], ["--"], ["-p", "speed:=1.0"]])
def test_arguments_that_give_no_parameter_are_good(args):
    findings = judge_given_parameters(args, [NODE], KNOWN)
    assert findings.errors == findings.warnings == []


@pytest.mark.parametrize("text", ["", "7", "/**:\n", "[1, 2]"])
def test_a_file_without_parameters_is_an_error(tmp_path, text):
    (error,) = judge("--params-file", str(file_of(tmp_path, text))).errors
    assert "only for nothing" in error


def test_a_foreign_name_in_a_section_for_every_node_is_a_warning(tmp_path):
    text = "/**:\n  ros__parameters:\n    camera_frame: x\n    pressure.cap: 2.0e4\n"
    findings = judge("--params-file", str(file_of(tmp_path, text)))
    assert not findings.errors
    (warning,) = findings.warnings
    assert "camera_frame is not a parameter of this node" in warning


def test_a_foreign_name_in_a_section_of_this_node_is_an_error(tmp_path):
    text = "/**/spiral_gripper:\n  ros__parameters:\n    presure_cap: 2.0e4\n"
    findings = judge("--params-file", str(file_of(tmp_path, text)))
    assert not findings.warnings
    (error,) = findings.errors
    assert "did you mean pressure.cap?" in error


@pytest.mark.parametrize(
    ("values", "unknown"),
    [
        ("{pressure: {cap: 2.0e4}}", []),
        ("{pressure.cap: 2.0e4}", []),
        ("{pressure: {cpa: 2.0e4}, gripper: p1}", ["pressure.cpa"]),
        ("{pressure: {cap: {deep: 1}}}", ["pressure.cap.deep"]),
    ],
)
def test_names_in_namespaces_have_dots(tmp_path, values, unknown):
    text = f"/**/spiral_gripper:\n  ros__parameters: {values}\n"
    errors = judge("--params-file", str(file_of(tmp_path, text))).errors
    assert [error.split(": ")[1].split(" is not")[0] for error in errors] == unknown


def test_the_file_on_the_page_has_names_of_the_node(tmp_path):
    page = (ROOT / "docs/node_parameters.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)
    args = ["--ros-args", "--params-file", str(file_of(tmp_path, text))]
    findings = judge_given_parameters(args, [NODE], [spec.name for spec in PARAMETERS])
    assert findings.errors == findings.warnings == []


def test_a_file_that_is_gone_is_an_error(tmp_path):
    (error,) = judge("--params-file", str(tmp_path / "none.yaml")).errors
    assert "cannot be read" in error


@pytest.mark.parametrize(
    ("rule", "count"),
    [
        ("pressure.cap:=1.0", 0),
        ("use_sim_time:=true", 0),
        ("qos_overrides./x.publisher.depth:=1", 0),
        ("camera:=1", 1),
        ("spiral_gripper:camera:=1", 1),
        ("other:camera:=1", 0),
    ],
)
def test_names_on_the_command_line_are_judged_for_their_node(rule, count):
    assert len(judge("-p", rule).errors) == count
    assert len(judge("--param", rule).errors) == count


def test_only_arguments_of_ros_are_judged():
    args = ["-p", "camera:=1", "--ros-args", "-r", "a:=b", "--", "-p", "camera:=2"]
    findings = judge_given_parameters(args, [NODE], KNOWN)
    assert findings.errors == findings.warnings == []
