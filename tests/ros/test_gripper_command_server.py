# SPDX-License-Identifier: Apache-2.0
"""Real goals of control_msgs' shape, to a node that has found a control_msgs."""

import importlib
import os
import re
import sys
import types

import pytest
from action_msgs.msg import GoalStatus
from rclpy.parameter import Parameter
from ros.compiled_control_msgs import PACKAGE, compile_control_msgs
from ros.grasp_goals import Goals
from ros.harness import Client, RunningNode, all_finite

from spiral_gripper_ros.control.states import State
from spiral_gripper_ros.node.gripper_node import GripperNode

pytestmark = pytest.mark.slow

OPEN, DIAMETER = 0.1, 0.04


@pytest.fixture(scope="module")
def control_msgs(tmp_path_factory):
    """A compiled control_msgs, importable here and by nodes while this module is tested."""
    path = str(compile_control_msgs(tmp_path_factory.mktemp(PACKAGE)))
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(path)
        patch.setenv("PYTHONPATH", path, prepend=os.pathsep)
        yield importlib.import_module(f"{PACKAGE}.action")
        for name in [name for name in sys.modules if name.split(".")[0] == PACKAGE]:
            patch.delitem(sys.modules, name)


@pytest.fixture(scope="module")
def facade(control_msgs):
    """A node that has found control_msgs, its client, and goals to both of its actions."""
    client = Client("/facade")
    with RunningNode("/facade") as node:
        client.wait_until_active()
        client.node = node
        client.gripper = Goals(client, control_msgs.GripperCommand, "gripper_cmd")
        client.joint = Goals(client, control_msgs.ParallelGripperCommand, "parallel_gripper_cmd")
        yield client
        assert node.stop() == 0, node.log()
        for line in ("gripper_cmd is offered as control_msgs/action/GripperCommand", "velocity is"):
            assert line in node.log()
        assert "Traceback" not in node.log()
        for goals in (client.gripper, client.joint):
            goals.close()
    client.close()


@pytest.fixture
def active(facade):
    facade.restore()
    facade.change("pressure.settle_time", 0.1)
    return facade


def command(goals, position, **fields):
    goal = goals.kind.Goal()
    for name, value in {"position": position, **fields}.items():
        setattr(goal.command, name, value)
    return goals.send(goal)


def reading(message):
    """Return what a result or feedback tells: position and effort."""
    assert all_finite(message)
    assert not getattr(
        message, "stalled", False
    )  # which clients may take for an object that is held
    if hasattr(message, "position"):
        return message.position, message.effort
    return message.state.position[0], message.state.effort[0]


def test_a_position_wraps_the_object_of_that_diameter_and_opening_releases_it(active):
    active.change("pressure.rate_up", 2.0e5)
    for goals, only in ((active.gripper, float), (active.joint, lambda number: [number])):
        goal = command(goals, only(DIAMETER))
        result = goal.end()[1]
        position, effort = reading(result)
        assert result.reached_goal
        assert position == pytest.approx(DIAMETER, rel=1e-6)
        assert effort > 0.0
        assert reading(goal.feedback[0]) == (OPEN, 0.0)
        result = command(goals, only(OPEN)).end()[1]
        assert (result.reached_goal, *reading(result)) == (True, OPEN, 0.0)
        assert active.wait_for_state(State.RELEASED).pressure_command == 0.0
    assert result.state.header.stamp.sec > 0
    assert result.state.name == ["spiral_gripper_opening"]
    active.change("gripper_cmd.open_position", 0.05)
    result = command(active.joint, [0.06], name=["grip"], velocity=[0.1]).end()[1]
    assert reading(result)[0] == 0.05
    assert result.state.name == ["grip"]


def refused(client, goal, words):
    """Return what a goal tells that has failed without a claim; the log says why."""
    status, result = goal.end()
    assert status == GoalStatus.STATUS_ABORTED
    assert not result.reached_goal
    told = re.compile(f"gripper_cmd: .*{words}")
    client.wait_until(lambda: told.search(client.node.log()), f"the log to say: {words}")
    return reading(result)


def test_what_cannot_be_gripped_is_refused_and_moves_nothing(active):
    """Nor does it deny what is held."""
    command(active.gripper, DIAMETER).end()
    active.hear_more()
    held = active.pressures[-1]
    active.pressures.clear()
    for position, max_effort, words in (
        (0.09, 0.0, "above the grippable range"),
        (DIAMETER, 0.001, "more than max_effort"),
    ):
        goal = command(active.gripper, position, max_effort=max_effort)
        told = refused(active, goal, words)
        assert told[0] == pytest.approx(DIAMETER, rel=1e-6)
        assert told[1] > 0.0
    active.hear_more()
    assert active.status.state == State.GRASPING
    assert set(active.pressures) == {held}


def test_opening_fails_if_the_measured_pressure_stays(active):
    active.change("grasp.timeout", 0.3)
    active.regulator = lambda commanded: 4.0e4
    active.wait_until(lambda: active.status.measured_pressure, "measurement")
    goal = command(active.gripper, OPEN)
    assert refused(active, goal, "after the release")[0] < OPEN
    assert reading(goal.feedback[0])[0] < OPEN


@pytest.mark.usefixtures("control_msgs")
def test_one_name_has_the_type_that_the_parameter_says(namespace, capfd):
    chosen = [Parameter("gripper_cmd.type", value="ParallelGripperCommand")]
    GripperNode(namespace=namespace, parameter_overrides=chosen).destroy_node()
    log = capfd.readouterr().err
    assert ": gripper_cmd is offered as control_msgs/action/ParallelGripperCommand" in log
    assert "parallel_gripper_cmd" not in log


@pytest.mark.parametrize(
    ("found", "said"),
    [
        (None, "control_msgs is not installed"),
        # One without type support, as if it were built for another Python, and without the other.
        (
            types.SimpleNamespace(GripperCommand=int),
            "control_msgs cannot be used, gripper_cmd is not offered(.|\n)*has no Parallel",
        ),
    ],
)
def test_without_a_usable_control_msgs_the_node_does_without_and_says_so(
    namespace, monkeypatch, capfd, found, said
):
    monkeypatch.setitem(sys.modules, PACKAGE, types.ModuleType(PACKAGE))
    monkeypatch.setitem(sys.modules, f"{PACKAGE}.action", found)
    GripperNode(namespace=namespace).destroy_node()
    assert re.search(said, capfd.readouterr().err)
