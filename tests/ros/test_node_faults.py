# SPDX-License-Identifier: Apache-2.0
"""Exceptions where none should be: the node in this process, with parts that break."""

import math
import time
from types import SimpleNamespace

import pytest
from builtin_interfaces.msg import Time
from lifecycle_msgs.msg import State as LifecycleState
from rclpy.executors import MultiThreadedExecutor
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.parameter import Parameter
from ros.grasp_goals import handle_of
from ros.harness import DEADLINE, FAST_RAMP, PATIENT, deliver, plan_request
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64
from std_srvs.srv import Trigger

from spiral_core import SolverError
from spiral_core.rod.state import RodStatus
from spiral_gripper_msgs.action import Grasp
from spiral_gripper_msgs.srv import PlanWrap
from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.node.gripper_node import SHUT_DOWN, GripperNode
from spiral_gripper_ros.planning import mount_follower


class BrokenPlanner:
    """Breaks in the way that is asked for."""

    radius_range = (0.0, math.inf)
    gravity = (9.80665, 0.0, 0.0)

    def __init__(self, error):
        self.error = error

    def plan(self, radius):
        raise self.error

    def shape(self, pressure, radius):
        raise self.error


def state_of(node):
    snapshot = node.runtime.control.snapshot()
    return snapshot.state, snapshot.refusal.reason


def test_an_exception_in_a_callback_vents_is_logged_and_becomes_a_state(node, capfd):
    deliver(node, "object_radius", Float64(data=0.02))
    good = node.runtime.loaded.mount.planner
    node.runtime.loaded.mount.planner = BrokenPlanner(ZeroDivisionError("broken on purpose"))
    deliver(node, "object_radius", Float64(data=0.0205))
    assert node.published[-1] == 0.0
    assert state_of(node) == (State.FAULT, Reason.INTERNAL_ERROR)
    assert "broken on purpose" in node.runtime.control.snapshot().refusal.text
    log = capfd.readouterr().err
    assert "Traceback" in log
    assert "ZeroDivisionError: broken on purpose" in log
    node.runtime.loaded.mount.planner = good
    deliver(node, "object_radius", Float64(data=0.02))
    node._timer.callback()
    assert node.published[-1] == 0.0
    node.runtime.control.rearm()
    deliver(node, "object_radius", Float64(data=0.02))
    assert state_of(node) == (State.TRACKING, Reason.NONE)


def test_without_a_certificate_the_command_stands_and_the_status_says_so(node):
    deliver(node, "object_radius", Float64(data=0.02))
    target = node.runtime.control.snapshot().pressure_target
    error = SolverError(RodStatus.UNSTABLE, 0.1, 3)
    node.runtime.loaded.mount.planner = BrokenPlanner(error)
    deliver(node, "object_radius", Float64(data=0.0205))
    node._timer.callback()
    assert state_of(node) == (State.HOLDING, Reason.NOT_CERTIFIED)
    assert node.runtime.control.snapshot().pressure_target == target
    assert node.runtime.loaded.shape is None
    assert all(math.isfinite(pressure) for pressure in node.published)


def test_an_exception_in_a_transition_is_logged_and_leads_to_unconfigured(node, capfd):
    def broken():
        raise RuntimeError("cannot connect, on purpose")

    assert node.trigger_deactivate() == TransitionCallbackReturn.SUCCESS
    assert node.trigger_cleanup() == TransitionCallbackReturn.SUCCESS
    node.runtime.outputs.configure = broken
    assert node.trigger_configure() == TransitionCallbackReturn.ERROR
    assert "RuntimeError: cannot connect, on purpose" in capfd.readouterr().err
    assert node._state_machine.current_state[0] == LifecycleState.PRIMARY_STATE_UNCONFIGURED
    assert node.published[-1] == 0.0
    assert node.runtime.loaded is None


def test_an_exception_in_diagnostics_is_logged_and_the_grip_is_kept(node, capfd):
    deliver(node, "object_radius", Float64(data=0.02))
    node.get_fully_qualified_name = lambda: 1 // 0
    node._diagnosis.tell()
    assert state_of(node) == (State.TRACKING, Reason.NONE)
    assert "ZeroDivisionError" in capfd.readouterr().err


@pytest.mark.parametrize("part", ["publish", "publish_shape"])
def test_an_exception_while_telling_is_logged_now_and_then_and_the_grip_is_kept(node, part, capfd):
    setattr(node.runtime.outputs, part, lambda *arguments: 1 // 0)
    deliver(node, "object_radius", Float64(data=0.02))
    for _ in range(100):
        node._timer.callback()
    assert state_of(node) == (State.TRACKING, Reason.NONE)
    assert node.published[-1] > 0.0
    assert capfd.readouterr().err.count("Traceback") == 1


def test_a_shape_that_raises_leaves_the_grip_and_calls_nothing_wrapped(node):
    node.set_parameters(
        [Parameter(name, value=value) for name, value in (FAST_RAMP | PATIENT).items()]
    )
    deliver(node, "object_radius", Float64(data=0.02))
    deadline = time.monotonic() + DEADLINE
    while not node.runtime.control.snapshot().wrapped:
        assert time.monotonic() < deadline
        time.sleep(0.01)
        node._timer.callback()
    node.runtime.loaded.update_shape = lambda *arguments: 1 // 0
    node._timer.callback()
    assert state_of(node) == (State.TRACKING, Reason.NONE)
    assert node.published[-1] > 0.0
    assert not node.runtime.control.snapshot().wrapped


@pytest.mark.parametrize("rate", [5e-324, 1e-10, 0.0, 50.0])
def test_no_rate_of_the_markers_lets_go(node, rate):
    deliver(node, "object_radius", Float64(data=0.02))
    (result,) = node.set_parameters([Parameter("publish.marker_rate", value=rate)])
    assert result.successful
    assert node.runtime.errors.count == 0
    assert state_of(node) == (State.TRACKING, Reason.NONE)


def test_a_bad_sample_of_the_clock_does_not_let_go(node, capfd):
    assert node.trigger_deactivate() == TransitionCallbackReturn.SUCCESS
    (result,) = node.set_parameters([Parameter("use_sim_time", value=True)])
    assert result.successful
    deliver(node, "clock", Clock(clock=Time(sec=5)))
    assert node.trigger_activate() == TransitionCallbackReturn.SUCCESS
    before = node.runtime.now()
    deliver(node, "object_radius", Float64(data=0.02))
    deliver(node, "clock", Clock(clock=Time(sec=-7)))
    assert "Seconds value must not be negative" in capfd.readouterr().err
    assert state_of(node) == (State.TRACKING, Reason.NONE)
    deliver(node, "clock", Clock(clock=Time(sec=6)))
    assert node.runtime.now() == before + 1.0


def test_an_executor_with_many_threads_is_refused(node, capfd):
    executor = MultiThreadedExecutor()
    executor.add_node(node)
    assert node.trigger_deactivate() == TransitionCallbackReturn.SUCCESS
    assert node.trigger_activate() == TransitionCallbackReturn.FAILURE
    assert "executor must be one of a single thread" in capfd.readouterr().err
    executor.remove_node(node)
    executor.shutdown()


def test_the_pressure_goes_out_before_anything_else(node):
    order = []
    for name in ("publish_pressure", "publish", "publish_shape"):
        setattr(node.runtime.outputs, name, lambda *arguments, name=name: order.append(name))
    deliver(node, "object_radius", Float64(data=0.02))
    node._timer.callback()
    assert order[0] == "publish_pressure"
    assert set(order) == {"publish_pressure", "publish", "publish_shape"}


@pytest.mark.parametrize(("service", "act"), [("vent", "release"), ("rearm", "rearm")])
def test_an_exception_in_a_service_vents_and_is_answered(node, service, act, capfd):
    deliver(node, "object_radius", Float64(data=0.02))
    setattr(node.runtime.control, act, lambda: 1 // 0)
    response = getattr(node._served, f"_{service}")(None, Trigger.Response())
    assert not response.success
    assert "ZeroDivisionError" in response.message
    assert node.published[-1] == 0.0
    assert state_of(node) == (State.FAULT, Reason.INTERNAL_ERROR)
    assert "Traceback" in capfd.readouterr().err


def test_an_exception_when_a_parameter_takes_effect_vents_and_is_logged(node, capfd):
    deliver(node, "object_radius", Float64(data=0.02))
    node.runtime.control.reconfigure = lambda limits: 1 // 0
    (result,) = node.set_parameters([Parameter("radius.timeout", value=2.0)])
    assert result.successful
    assert state_of(node) == (State.FAULT, Reason.INTERNAL_ERROR)
    assert "Traceback" in capfd.readouterr().err


def test_an_exception_while_another_gripper_is_loaded_is_a_fault(node, monkeypatch, capfd):
    monkeypatch.setattr(mount_follower, "planner_for", lambda *mounted: 1 // 0)
    (result,) = node.set_parameters([Parameter("gripper", value="prototype_p1")])
    assert result.successful
    deadline = time.monotonic() + DEADLINE
    while state_of(node)[0] is not State.FAULT:
        assert time.monotonic() < deadline
        node._timer.callback()
    assert "ZeroDivisionError" in node.runtime.control.snapshot().refusal.text
    assert "Traceback" in capfd.readouterr().err
    node.runtime.control.rearm()
    deliver(node, "object_radius", Float64(data=0.02))
    assert state_of(node) == (State.WAITING, Reason.NOT_CERTIFIED)
    monkeypatch.undo()
    node.set_parameters([Parameter("gripper", value="prototype_p1")])
    node.runtime.control.rearm()
    while state_of(node)[0] is not State.TRACKING:
        assert time.monotonic() < deadline
        node._timer.callback()
        deliver(node, "object_radius", Float64(data=0.02))
    assert node.runtime.loaded.gripper.name == "prototype_p1"


def test_a_planner_that_breaks_while_a_plan_is_asked_for_is_answered(node, monkeypatch, capfd):
    deliver(node, "object_radius", Float64(data=0.02))
    monkeypatch.setattr(node.runtime.loaded.mount, "poll", lambda: 1 // 0)
    for radii in ([0.02], [0.02, 0.025]):
        asked = node._served._plan_wrap(plan_request(radii), PlanWrap.Response())
        with pytest.raises(StopIteration) as ended:
            asked.send(None)
        answers = ended.value.value.plans
        assert [answer.reason for answer in answers] == [Reason.INTERNAL_ERROR] * len(radii)
        assert "ZeroDivisionError" in answers[0].message
    assert state_of(node) == (State.TRACKING, Reason.NONE)
    assert "Traceback" in capfd.readouterr().err


def carried_out(node, handle):
    """Let a grasp goal run to its end; return its result."""
    goal = node.goals._servers[0]._execute(handle)
    deadline = time.monotonic() + DEADLINE
    while time.monotonic() < deadline:
        node._timer.callback()
        try:
            goal.send(None)
        except StopIteration as ended:
            return ended.value
        time.sleep(0.01)
    raise AssertionError("the goal does not end")


def test_a_result_that_cannot_be_filled_leaves_the_grip_and_is_answered(node, capfd):
    node.goals._servers[0].result = lambda request, report: 1 // 0
    handle = handle_of(Grasp.Goal(object_radius=0.02))
    result = carried_out(node, handle)
    assert handle.ends == ["succeeded"]
    assert result.success
    assert "ZeroDivisionError" in result.message
    assert state_of(node) == (State.GRASPING, Reason.NONE)
    assert node.published[-1] > 0.0
    assert "Traceback" in capfd.readouterr().err


def test_a_goal_that_cannot_be_read_is_refused_and_the_grip_is_kept(node, capfd):
    deliver(node, "object_radius", Float64(data=0.02))
    node.goals._servers[0].goal = lambda request: 1 // 0
    handle = handle_of(Grasp.Goal(object_radius=0.03))
    result = carried_out(node, handle)
    assert handle.ends == ["aborted"]
    assert not result.success
    assert result.reason == Reason.INTERNAL_ERROR
    assert state_of(node) == (State.TRACKING, Reason.NONE)
    assert "Traceback" in capfd.readouterr().err


def test_a_goal_after_the_shutdown_is_told_to_start_anew(node):
    assert node.trigger_shutdown() == TransitionCallbackReturn.SUCCESS
    result = node.goals._servers[0]._execute(handle_of(Grasp.Goal(object_radius=0.02)))
    with pytest.raises(StopIteration) as ended:
        result.send(None)
    assert ended.value.value.message == SHUT_DOWN
    asked = node._served._plan_wrap(plan_request([0.02]), PlanWrap.Response())
    with pytest.raises(StopIteration) as ended:
        asked.send(None)
    (answer,) = ended.value.value.plans
    assert (answer.message, answer.reason) == (SHUT_DOWN, Reason.NOT_ACTIVE)


def test_measured_pressure_is_heard_only_while_active(node):
    assert node.trigger_deactivate() == TransitionCallbackReturn.SUCCESS
    deliver(node, "measured_pressure", Float64(data=math.nan))
    assert node.runtime.control.snapshot().pressure_fault.reason is Reason.NONE
    assert not node.runtime.control.snapshot().refused


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_the_last_line_of_defense_sends_no_number_that_is_none(namespace, bad):
    node = GripperNode(namespace=namespace)
    sent = []
    node.runtime.outputs._pressure = SimpleNamespace(publish=sent.append)
    node.runtime.outputs.publish_pressure(bad)
    node.destroy_node()
    assert [message.data for message in sent] == [0.0]
