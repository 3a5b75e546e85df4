"""Exceptions where none should be: the node in this process, with parts that break."""

import math
import time
from types import SimpleNamespace

import pytest
from lifecycle_msgs.msg import State as LifecycleState
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.parameter import Parameter
from sensor_msgs.msg import FluidPressure
from std_msgs.msg import Float64
from std_srvs.srv import Trigger

from spiral_core import SolverError
from spiral_core.rod.types import RodStatus
from spiral_gripper_ros.control.states import Reason, State
from spiral_gripper_ros.node.gripper_node import GripperNode
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
    snapshot = node.control.snapshot()
    return snapshot.state, snapshot.refusal.reason


def test_an_exception_in_a_callback_vents_is_logged_and_becomes_a_state(node, capfd):
    node._on_radius(Float64(data=0.02))
    good = node.loaded.mount.planner
    node.loaded.mount.planner = BrokenPlanner(ZeroDivisionError("broken on purpose"))
    node._on_radius(Float64(data=0.0205))
    assert node.published[-1] == 0.0
    assert state_of(node) == (State.FAULT, Reason.INTERNAL_ERROR)
    assert "broken on purpose" in node.control.snapshot().refusal.text
    log = capfd.readouterr().err
    assert "Traceback" in log
    assert "ZeroDivisionError: broken on purpose" in log
    node.loaded.mount.planner = good
    node._on_radius(Float64(data=0.02))
    node._on_tick()
    assert node.published[-1] == 0.0
    node.control.rearm()
    node._on_radius(Float64(data=0.02))
    assert state_of(node) == (State.TRACKING, Reason.NONE)


def test_without_a_certificate_the_command_stands_and_the_status_says_so(node):
    node._on_radius(Float64(data=0.02))
    target = node.control.snapshot().pressure_target
    error = SolverError(RodStatus.UNSTABLE, 0.1, 3)
    node.loaded.mount.planner = BrokenPlanner(error)
    node._on_radius(Float64(data=0.0205))
    node._on_tick()
    assert state_of(node) == (State.HOLDING, Reason.NOT_CERTIFIED)
    assert node.control.snapshot().pressure_target == target
    assert node.loaded.shape is None
    assert all(math.isfinite(pressure) for pressure in node.published)


def test_an_exception_in_a_transition_is_logged_and_leads_to_unconfigured(node, capfd):
    def broken():
        raise RuntimeError("cannot connect, on purpose")

    assert node.trigger_deactivate() == TransitionCallbackReturn.SUCCESS
    assert node.trigger_cleanup() == TransitionCallbackReturn.SUCCESS
    node.outputs.configure = broken
    assert node.trigger_configure() == TransitionCallbackReturn.ERROR
    assert "RuntimeError: cannot connect, on purpose" in capfd.readouterr().err
    assert node._state_machine.current_state[0] == LifecycleState.PRIMARY_STATE_UNCONFIGURED
    assert node.published[-1] == 0.0
    assert node.loaded is None


def test_a_diagnostics_exception_vents_too(node):
    node.get_fully_qualified_name = lambda: 1 // 0
    node._diagnosis.tell()
    assert state_of(node) == (State.FAULT, Reason.INTERNAL_ERROR)


def test_the_pressure_goes_out_before_anything_else(node):
    order = []
    for name in ("publish_pressure", "publish_status", "publish_backbone"):
        setattr(node.outputs, name, lambda *arguments, name=name: order.append(name))
    node._on_radius(Float64(data=0.02))
    node._on_tick()
    assert order[0] == "publish_pressure"
    assert set(order) == {"publish_pressure", "publish_status", "publish_backbone"}


@pytest.mark.parametrize("service", ["release", "rearm"])
def test_an_exception_in_a_service_vents_and_is_answered(node, service, capfd):
    node._on_radius(Float64(data=0.02))
    setattr(node.control, service, lambda: 1 // 0)
    response = getattr(node._served, f"_{service}")(None, Trigger.Response())
    assert not response.success
    assert "ZeroDivisionError" in response.message
    assert node.published[-1] == 0.0
    assert state_of(node) == (State.FAULT, Reason.INTERNAL_ERROR)
    assert "Traceback" in capfd.readouterr().err


def test_an_exception_when_a_parameter_takes_effect_vents_and_is_logged(node, capfd):
    node._on_radius(Float64(data=0.02))
    node.control.reconfigure = lambda limits: 1 // 0
    (result,) = node.set_parameters([Parameter("radius_timeout", value=2.0)])
    assert result.successful
    assert state_of(node) == (State.FAULT, Reason.INTERNAL_ERROR)
    assert "Traceback" in capfd.readouterr().err


def test_an_exception_while_another_gripper_is_loaded_is_a_fault(node, monkeypatch, capfd):
    monkeypatch.setattr(mount_follower, "planner_for", lambda gripper, gravity: 1 // 0)
    (result,) = node.set_parameters([Parameter("gripper", value="prototype_p1")])
    assert result.successful
    deadline = time.monotonic() + 30.0
    while state_of(node)[0] is not State.FAULT:
        assert time.monotonic() < deadline
        node._on_tick()
    assert "ZeroDivisionError" in node.control.snapshot().refusal.text
    assert "Traceback" in capfd.readouterr().err
    node.control.rearm()
    node._on_radius(Float64(data=0.02))
    assert state_of(node) == (State.WAITING, Reason.NOT_CERTIFIED)
    monkeypatch.undo()
    node.set_parameters([Parameter("gripper", value="prototype_p1")])
    node.control.rearm()
    while state_of(node)[0] is not State.TRACKING:
        assert time.monotonic() < deadline
        node._on_tick()
        node._on_radius(Float64(data=0.02))
    assert node.loaded.gripper.name == "prototype_p1"


def test_measured_pressure_is_heard_only_while_active(node):
    assert node.trigger_deactivate() == TransitionCallbackReturn.SUCCESS
    node._on_measured(FluidPressure(fluid_pressure=math.nan))
    assert node.control.snapshot().pressure_fault.reason is Reason.NONE
    assert not node.control.snapshot().refused


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_the_last_line_of_defense_sends_no_number_that_is_none(namespace, bad):
    node = GripperNode(namespace=namespace)
    sent = []
    node.outputs._pressure = SimpleNamespace(publish=sent.append)
    node.outputs.publish_pressure(bad)
    node.destroy_node()
    assert [message.data for message in sent] == [0.0]
