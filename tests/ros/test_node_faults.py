# SPDX-License-Identifier: Apache-2.0
"""Exceptions where none should be: the node in this process, with parts that break."""

import math
import time
from unittest.mock import Mock

import pytest
from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped
from rclpy.action import ActionClient
from rclpy.executors import MultiThreadedExecutor
from rclpy.lifecycle import TransitionCallbackReturn
from ros.grasp_goals import Goals, refused, started
from ros.harness import BARE, deliver, plan_request, serve, tick, tick_until
from ros.local_nodes import change, offer, overhear, parameters, state_of
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64

from spiral_gripper_msgs.action import Grasp, Release
from spiral_gripper_ros.actions import grasp
from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.node import display, robot_state
from spiral_gripper_ros.node.gripper_node import GripperNode
from spiral_gripper_ros.planning import loaded_gripper
from spiral_gripper_ros.process.guards import GuardedLoop
from spiral_gripper_ros.runtime.runtime import Outputs

SUCCESS = TransitionCallbackReturn.SUCCESS
FAULT = (State.FAULT, Reason.INTERNAL_ERROR)
TRACKING = (State.TRACKING, Reason.NONE)


def broken(*_):
    return 1 // 0


@pytest.fixture
def tracking(node):
    """A node that follows a radius."""
    offer(node)
    return node


@pytest.fixture
def logged(capfd):
    """The log must tell of an exception."""
    yield
    assert "Traceback" in capfd.readouterr().err


@pytest.fixture
def goals(tracking, client):
    """Goals to that node, which is spun with its client."""
    client.spinner.add_node(tracking)
    goals = Goals(client)
    yield goals
    goals.close()
    client.spinner.remove_node(tracking)


def plan(node, _):
    return serve(node, "plan_wrap", plan_request([0.02, 0.025])).plans[1].message


def goal(_, goals):
    return refused(goals.grasp(0.03), Reason.INTERNAL_ERROR)


def grasped(node, goals):
    change(node, pressure__settle_time=0.1, pressure__rate_up=2.0e6)
    _, result = goals.grasp(0.02).end()
    assert result.success
    return result.message


@pytest.mark.usefixtures("logged")
@pytest.mark.parametrize(
    ("part", "provoke", "expected"),
    [
        ("control.offer_radius", lambda node, _: offer(node), FAULT),
        ("control.command", lambda node, _: tick(node), FAULT),
        ("control.reconfigure", lambda node, _: change(node, radius__timeout=2.0), FAULT),
        ("control.release", lambda node, _: serve(node, "vent", None).message, FAULT),
        ("control.rearm", lambda node, _: serve(node, "rearm", None).message, FAULT),
        ("control.start_grasp", goal, FAULT),
        ("control.command", None, FAULT),  # while a goal is under way
        ("loaded.poll", plan, TRACKING),
        ("grasp.known", goal, TRACKING),
        ("grasp.figures_to_msg", grasped, (State.GRASPING, Reason.NONE)),
    ],
)
def test_an_exception_is_logged_and_answered_and_vents_if_it_is_of_the_control_logic(
    tracking, goals, monkeypatch, part, provoke, expected
):
    control, (owner, name) = tracking.runtime.control, part.split(".")
    running = provoke or started(goals.grasp(0.02, timeout=[600.0]))
    place = grasp if owner == "grasp" else getattr(tracking.runtime, owner)
    monkeypatch.setattr(place, name, broken)
    said = provoke(tracking, goals) if provoke else refused(running, Reason.INTERNAL_ERROR)
    assert state_of(tracking) == expected
    assert "ZeroDivisionError" in (said or control.snapshot().refusal.text)
    monkeypatch.undo()
    if expected == FAULT:
        assert tracking.published[-1] == 0.0
        offer(tracking)
        tick(tracking)
        assert tracking.published[-1] == 0.0
        control.rearm()
        offer(tracking)
        assert state_of(tracking) == TRACKING


@pytest.mark.usefixtures("logged")
def test_an_exception_in_a_transition_is_logged_and_leads_to_unconfigured(tracking):
    assert tracking.trigger_deactivate() == tracking.trigger_cleanup() == SUCCESS
    tracking.runtime.outputs.configure = broken
    assert tracking.trigger_configure() == TransitionCallbackReturn.ERROR
    assert (tracking.published[-1], tracking.runtime.loaded) == (0.0, None)
    del tracking.runtime.outputs.configure
    assert tracking.trigger_configure() == SUCCESS


BREAKS = "outputs.publish outputs.publish_diagnostics loaded.update_shape objects.offer scene drawn"


@pytest.mark.usefixtures("wrapped")
@pytest.mark.parametrize("part", BREAKS.split())
def test_an_exception_while_telling_is_logged_now_and_then_and_the_grip_is_kept(
    node, part, monkeypatch, capfd
):
    others = {"scene": (display, "scene_to_msg"), "drawn": (robot_state, "place_of")}
    owner, _, name = part.rpartition(".")
    change(node, publish__robot_state_rate=10.0)
    place = others.get(part) or (getattr(node.runtime, owner), name)
    monkeypatch.setattr(*place, broken)
    for _ in range(100):
        deliver(node, "object_pose", PoseStamped())
        tick(node)
    unshown = part in ("loaded.update_shape", "outputs.publish")
    assert node.runtime.control.snapshot().wrapped is not unshown
    offer(node, 0.0205)
    tick(node)
    assert state_of(node) == TRACKING
    assert node.published[-1] > 0.0
    assert 1 <= capfd.readouterr().err.count("Traceback") <= 2  # a status and a drawing


def test_an_executor_with_many_threads_is_refused(node, capfd):
    executor = MultiThreadedExecutor(2)  # a machine of one core has one thread for it
    executor.add_node(node)
    assert node.trigger_deactivate() == SUCCESS
    assert node.trigger_activate() == TransitionCallbackReturn.FAILURE
    assert "executor must be one of a single thread" in capfd.readouterr().err
    executor.remove_node(node)
    executor.shutdown()


def test_the_pressure_goes_out_before_anything_else(node, monkeypatch):
    order, names = [], ["publish_pressure", "publish"]
    for name in names:
        setattr(node.runtime.outputs, name, lambda *_, name=name: order.append(name))
    offer(node)
    for part in ("offer_radius", "command"):  # none that a tick needs, then one
        order.clear()
        monkeypatch.setattr(node.runtime.control, part, broken)
        tick(node)
        assert order[:2] == names
    order.clear()
    monkeypatch.setattr(node.runtime.control, "deactivate", broken)
    with pytest.raises(ZeroDivisionError):
        node.vent()
    assert order == names[:1]


@pytest.mark.usefixtures("logged")
def test_an_exception_while_another_gripper_is_loaded_is_a_fault(node, monkeypatch):
    monkeypatch.setattr(loaded_gripper, "planner_for", broken)
    change(node, gripper="prototype_p1")
    tick_until(node, lambda: state_of(node) == FAULT)
    assert "ZeroDivisionError" in node.runtime.control.snapshot().refusal.text
    answer = serve(node, "rearm", None)
    assert (answer.success, "ZeroDivisionError" in answer.message) == (False, True)
    assert state_of(node) == FAULT


# --- goals -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "after"),
    [(Release, ((State.RELEASED, Reason.RELEASED), None)), (Grasp, (TRACKING, 0.02))],
)
def test_a_goal_that_is_canceled_before_it_is_started_vents_if_it_is_a_release(
    tracking, client, kind, after
):
    """Both requests wait before the node looks for either; a grasp has changed nothing."""
    name = kind.__name__.lower()
    client.spinner.add_node(tracking)
    action = ActionClient(client, kind, name)
    canceling = client.create_client(CancelGoal, f"{name}/_action/cancel_goal")
    client.wait_until(
        lambda: action.server_is_ready() and canceling.service_is_ready(), "the action"
    )
    answer = action.send_goal_async(kind.Goal())
    canceling.call_async(CancelGoal.Request())
    time.sleep(0.3)
    client.wait_until(answer.done, "an answer to the goal")
    ended = answer.result().get_result_async()
    client.wait_until(ended.done, "the end of the goal")
    assert ended.result().status == GoalStatus.STATUS_CANCELED
    assert ended.result().result.reason == Reason.GRASP_CANCELED
    assert (state_of(tracking), tracking.runtime.control.snapshot().radius) == after
    action.destroy()
    client.spinner.remove_node(tracking)


def test_a_node_that_is_destroyed_during_a_goal_leaves_nothing_behind(namespace, client, capfd):
    node = GripperNode(namespace=namespace)
    assert node.start()
    client.spinner.add_node(node)
    goals = Goals(client)
    loop = GuardedLoop(node.errors, client.spinner)
    assert not node.goals.end(loop)
    started(goals.grasp(0.02, timeout=[600.0]))
    assert node.goals.end(loop)
    client.spinner.remove_node(node)
    node.destroy_node()
    client.spin(0.1)
    goals.close()
    assert "Traceback" not in capfd.readouterr().err


@pytest.mark.parametrize("bad", [math.nan, -math.inf])
def test_the_last_line_of_defense_sends_no_number_that_is_none(bad):
    node = Mock()
    Outputs(node, "base").publish_pressure(bad)
    (message,) = node.create_publisher().publish.call_args.args
    assert message.data == 0.0


def test_a_second_commander_and_a_bad_clock_are_noticed_on_remapped_topics(namespace, client):
    remapped = ["--ros-args", "-r", "pressure_command:=valve", "-r", "/clock:=sim_clock"]
    given = parameters(use_sim_time=True, **BARE)
    node = GripperNode(namespace=namespace, cli_args=remapped, parameter_overrides=given)
    told = overhear(node)["/diagnostics"]
    assert node.start()
    deliver(node, "sim_clock", Clock(clock=Time(sec=-7)))
    assert node.runtime.errors.count == 1
    client.create_publisher(Float64, "valve", 1)
    tick_until(node, lambda: told and "2 nodes publish" in told[-1].status[0].message)
    node.destroy_node()
