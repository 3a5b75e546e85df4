# SPDX-License-Identifier: Apache-2.0
"""Exceptions where none should be: the node in this process, with parts that break."""

import math
import time
from types import SimpleNamespace

import pytest
from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped
from rclpy.action import ActionClient
from rclpy.executors import MultiThreadedExecutor
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.parameter import Parameter
from ros.grasp_goals import Goals, refused, started
from ros.harness import deliver, plan_request, serve, tick, tick_until
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64

from spiral_core import SolverError
from spiral_core.rod.state import RodStatus
from spiral_gripper_msgs.action import Grasp, Release
from spiral_gripper_ros.actions import grasp
from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.node import display
from spiral_gripper_ros.node.gripper_node import SHUT_DOWN, GripperNode
from spiral_gripper_ros.planning import loaded_gripper
from spiral_gripper_ros.planning.planner import GripperPlanner, NoPlanner
from spiral_gripper_ros.runtime.runtime import Outputs

SUCCESS = TransitionCallbackReturn.SUCCESS
FAULT = (State.FAULT, Reason.INTERNAL_ERROR)
TRACKING = (State.TRACKING, Reason.NONE)
GRASP = Grasp.Goal(object_radius=0.025)


def broken(*_):
    return 1 // 0


def offer(node, radius=0.02):
    deliver(node, "object_radius", Float64(data=radius))


def change(node, **values):
    """Set parameters, whose dots are written as two underscores."""
    named = [Parameter(name.replace("__", "."), value=value) for name, value in values.items()]
    assert all(result.successful for result in node.set_parameters(named))


def state_of(node):
    snapshot = node.runtime.control.snapshot()
    return snapshot.state, snapshot.refusal.reason


@pytest.fixture
def tracking(node):
    """A node that follows a radius."""
    offer(node)
    return node


@pytest.fixture
def goals(tracking, client):
    """Goals to that node, which is spun with its client."""
    client.spinner.add_node(tracking)
    goals = Goals(client)
    yield goals
    goals.close()
    client.spinner.remove_node(tracking)


@pytest.mark.parametrize(
    ("part", "provoke", "answers"),
    [
        ("offer_radius", offer, False),
        ("command", tick, False),
        ("reconfigure", lambda node: change(node, radius__timeout=2.0), False),
        ("release", lambda node: serve(node, "vent", None), True),
        ("rearm", lambda node: serve(node, "rearm", None), True),
    ],
)
def test_an_exception_in_a_callback_vents_is_logged_and_becomes_a_state(
    tracking, part, provoke, answers, capfd
):
    control = tracking.runtime.control
    setattr(control, part, broken)
    answer = provoke(tracking)
    if answers:
        assert not answer.success
        assert "ZeroDivisionError" in answer.message
    assert tracking.published[-1] == 0.0
    assert state_of(tracking) == FAULT
    assert "ZeroDivisionError" in control.snapshot().refusal.text
    assert "Traceback" in capfd.readouterr().err
    delattr(control, part)
    offer(tracking)
    tick(tracking)
    assert tracking.published[-1] == 0.0
    control.rearm()
    offer(tracking)
    assert state_of(tracking) == TRACKING


def test_without_a_certificate_the_command_stands_and_the_status_says_so(tracking):
    target = tracking.runtime.control.snapshot().pressure_target
    error = SolverError(RodStatus.UNSTABLE, 0.1, 3)
    tracking.runtime.loaded.planner = NoPlanner((9.80665, 0.0, 0.0), error)
    offer(tracking, 0.0205)
    tick(tracking)
    assert state_of(tracking) == (State.HOLDING, Reason.NOT_CERTIFIED)
    assert tracking.runtime.control.snapshot().pressure_target == target
    assert tracking.runtime.loaded.commanded.shape is None


def test_an_exception_in_a_transition_is_logged_and_leads_to_unconfigured(tracking, capfd):
    assert tracking.trigger_deactivate() == tracking.trigger_cleanup() == SUCCESS
    tracking.runtime.outputs.configure = broken
    assert tracking.trigger_configure() == TransitionCallbackReturn.ERROR
    assert "Traceback" in capfd.readouterr().err
    assert tracking.published[-1] == 0.0
    assert tracking.runtime.loaded is None
    del tracking.runtime.outputs.configure
    assert tracking.trigger_configure() == SUCCESS


BREAKS = (
    "outputs.publish outputs.publish_shape outputs.publish_diagnostics loaded.update_shape "
    "objects.offer scene drawn"
)


@pytest.mark.parametrize("part", BREAKS.split())
def test_an_exception_while_telling_is_logged_now_and_then_and_the_grip_is_kept(
    node, told, part, monkeypatch, capfd
):
    others = {"scene": (display, "scene_to_msg"), "drawn": (GripperPlanner, "wrapped_diameter")}
    owner, _, name = part.rpartition(".")
    broken_part = others.get(part) or (getattr(node.runtime, owner), name)
    assert told
    change(node, publish__robot_state_rate=10.0)
    monkeypatch.setattr(*broken_part, broken)
    for _ in range(100):
        deliver(node, "object_pose", PoseStamped())
        tick(node)
    assert node.runtime.control.snapshot().wrapped == (
        part not in ("loaded.update_shape", "outputs.publish")
    )
    offer(node, 0.0205)
    tick(node)
    assert state_of(node) == TRACKING
    assert node.published[-1] > 0.0
    assert 1 <= capfd.readouterr().err.count("Traceback") <= 2  # a status and a drawing


def test_a_bad_sample_of_the_clock_does_not_let_go(node, capfd):
    assert node.trigger_deactivate() == SUCCESS
    change(node, use_sim_time=True)
    deliver(node, "clock", Clock(clock=Time(sec=5)))
    assert node.trigger_activate() == SUCCESS
    before = node.runtime.now()
    offer(node)
    deliver(node, "clock", Clock(clock=Time(sec=-7)))
    assert "Seconds value must not be negative" in capfd.readouterr().err
    assert state_of(node) == TRACKING
    deliver(node, "clock", Clock(clock=Time(sec=6)))
    assert node.runtime.now() == before + 1.0


def test_an_executor_with_many_threads_is_refused(node, capfd):
    executor = MultiThreadedExecutor(2)  # a machine of one core has one thread for it
    executor.add_node(node)
    assert node.trigger_deactivate() == SUCCESS
    assert node.trigger_activate() == TransitionCallbackReturn.FAILURE
    assert "executor must be one of a single thread" in capfd.readouterr().err
    executor.remove_node(node)
    executor.shutdown()


def test_the_pressure_goes_out_before_anything_else(node):
    order = []
    for name in ("publish_pressure", "publish", "publish_shape"):
        setattr(node.runtime.outputs, name, lambda *arguments, name=name: order.append(name))
    offer(node)
    tick(node)
    assert order[0] == "publish_pressure"
    assert set(order) == {"publish_pressure", "publish", "publish_shape"}


def test_an_exception_while_another_gripper_is_loaded_is_a_fault(node, monkeypatch, capfd):
    monkeypatch.setattr(loaded_gripper, "planner_for", broken)
    change(node, gripper="prototype_p1")
    tick_until(node, lambda: state_of(node) == FAULT)
    assert "ZeroDivisionError" in node.runtime.control.snapshot().refusal.text
    assert "Traceback" in capfd.readouterr().err
    monkeypatch.undo()
    change(node, gripper="prototype_p1")
    node.runtime.control.rearm()
    tick_until(node, lambda: (offer(node), state_of(node) == TRACKING)[1])
    assert node.runtime.loaded.gripper.name == "prototype_p1"


def test_a_planner_that_breaks_while_a_plan_is_asked_for_is_answered(tracking, capfd):
    tracking.runtime.loaded.poll = broken
    answers = serve(tracking, "plan_wrap", plan_request([0.02, 0.025])).plans
    assert [answer.reason for answer in answers] == [Reason.INTERNAL_ERROR] * 2
    assert "ZeroDivisionError" in answers[0].message
    assert state_of(tracking) == TRACKING
    assert "Traceback" in capfd.readouterr().err


# --- goals -------------------------------------------------------------------------------------


def test_a_goal_and_its_cancel_are_commanded_at_once_not_at_the_next_tick(tracking, goals):
    """The simulated clock stands still: no tick comes."""
    assert tracking.trigger_deactivate() == SUCCESS
    change(tracking, use_sim_time=True)
    deliver(tracking, "clock", Clock(clock=Time(sec=5)))
    assert tracking.trigger_activate() == SUCCESS
    before = len(tracking.published)
    goal = goals.grasp(0.02)
    goals.client.wait_until(lambda: len(tracking.published) > before, "a command")
    assert state_of(tracking)[0] is State.GRASPING
    assert goal.cancel()
    assert len(tracking.published) == before + 2
    assert goal.end()[1].reason == Reason.GRASP_CANCELED


@pytest.mark.parametrize("name", ["release", "grasp"])
def test_a_goal_that_is_canceled_before_it_is_started_vents_if_it_is_a_release(
    tracking, client, name
):
    """Both requests wait before the node looks for either; a grasp has changed nothing."""
    kind, goal = (Release, Release.Goal()) if name == "release" else (Grasp, GRASP)
    client.spinner.add_node(tracking)
    action = ActionClient(client, kind, name)
    canceling = client.create_client(CancelGoal, f"{name}/_action/cancel_goal")
    client.wait_until(
        lambda: action.server_is_ready() and canceling.service_is_ready(), "the action"
    )
    answer = action.send_goal_async(goal)
    canceling.call_async(CancelGoal.Request())
    time.sleep(0.3)
    client.wait_until(answer.done, "an answer to the goal")
    ended = answer.result().get_result_async()
    client.wait_until(ended.done, "the end of the goal")
    assert ended.result().status == GoalStatus.STATUS_CANCELED
    assert ended.result().result.reason == Reason.GRASP_CANCELED
    vented = (State.RELEASED, Reason.RELEASED)
    assert state_of(tracking) == (vented if name == "release" else TRACKING)
    assert tracking.runtime.control.snapshot().radius == (None if name == "release" else 0.02)
    action.destroy()
    client.spinner.remove_node(tracking)


@pytest.mark.parametrize("part", ["start_grasp", "command"])
def test_an_exception_during_a_goal_is_logged_vents_and_ends_the_goal(tracking, goals, part, capfd):
    goal = started(goals.grasp(0.02, timeout=[600.0])) if part == "command" else None
    setattr(tracking.runtime.control, part, broken)
    assert "ZeroDivisionError" in refused(goal or goals.grasp(0.02), Reason.INTERNAL_ERROR)
    assert (tracking.published[-1], state_of(tracking)) == (0.0, FAULT)
    assert "Traceback" in capfd.readouterr().err
    delattr(tracking.runtime.control, part)


def test_a_goal_that_cannot_be_read_is_refused_and_the_grip_is_kept(
    tracking, goals, monkeypatch, capfd
):
    monkeypatch.setattr(grasp, "known", broken)
    refused(goals.grasp(0.03), Reason.INTERNAL_ERROR)
    assert state_of(tracking) == TRACKING
    assert "Traceback" in capfd.readouterr().err


def test_a_result_that_cannot_be_filled_leaves_the_grip_and_is_answered(
    tracking, goals, monkeypatch, capfd
):
    monkeypatch.setattr(grasp, "figures_to_msg", broken)
    change(tracking, pressure__settle_time=0.1, pressure__rate_up=2.0e6)
    _, result = goals.grasp(0.02).end()
    assert result.success
    assert "ZeroDivisionError" in result.message
    assert state_of(tracking) == (State.GRASPING, Reason.NONE)
    assert "Traceback" in capfd.readouterr().err


def test_a_request_after_the_shutdown_is_told_to_start_anew(tracking, goals):
    assert tracking.trigger_shutdown() == SUCCESS
    assert refused(goals.grasp(0.02), Reason.NOT_ACTIVE) == SHUT_DOWN
    (answer,) = serve(tracking, "plan_wrap", plan_request([0.02])).plans
    assert (answer.message, answer.reason) == (SHUT_DOWN, Reason.NOT_ACTIVE)


def test_a_node_that_is_destroyed_during_a_goal_leaves_nothing_behind(namespace, client, capfd):
    node = GripperNode(namespace=namespace)
    assert node.start()
    client.spinner.add_node(node)
    goals = Goals(client)
    started(goals.grasp(0.02, timeout=[600.0]))
    client.spinner.remove_node(node)
    node.destroy_node()
    client.spin(0.1)
    goals.close()
    assert "Traceback" not in capfd.readouterr().err


@pytest.mark.parametrize("bad", [math.nan, -math.inf])
def test_the_last_line_of_defense_sends_no_number_that_is_none(bad):
    sent = []
    publisher = SimpleNamespace(publish=sent.append)
    outputs = Outputs(SimpleNamespace(create_publisher=lambda *arguments: publisher), "base")
    outputs.publish_pressure(bad)
    assert [message.data for message in sent] == [0.0]
