# SPDX-License-Identifier: Apache-2.0
"""Requests that rclpy's own services raise at are refused, and end no process."""

import pytest
from lifecycle_msgs.msg import State as LifecycleState
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.action import ActionServer
from ros.harness import RunningNode

PROGRAMS = {
    "spiral_gripper": "spiral_gripper_ros.node.main",
    "regulator": "spiral_gripper_ros.regulators.main",
    "simulated_regulator": "spiral_gripper_ros.simulation.main",
}
OF_NO_TYPE = Parameter(name="pressure.cap", value=ParameterValue(type=99))
USABLE = Parameter(
    name="start_type_description_service",
    value=ParameterValue(type=ParameterType.PARAMETER_BOOL, bool_value=False),
)
BOTH = SetParameters.Request(parameters=[USABLE, OF_NO_TYPE])
BURST = 25  # more than the exceptions in a row that end a process


@pytest.mark.parametrize("name", PROGRAMS)
def test_values_of_no_type_are_refused_and_the_process_goes_on(name, namespace, client):
    with RunningNode(namespace, module=PROGRAMS[name]) as process:
        for _ in range(BURST):
            results = client.call(SetParameters, f"{name}/set_parameters", BOTH).results
            assert [result.successful for result in results] == [False, False]
            assert "99" in results[1].reason
        atomic = SetParametersAtomically.Request(parameters=[OF_NO_TYPE])
        service = f"{name}/set_parameters_atomically"
        assert not client.call(SetParametersAtomically, service, atomic).result.successful
        assert process.running
        assert process.log().count("set_parameters refused: ") == 1
        assert "Traceback" not in process.log()


def test_a_burst_of_them_and_of_impossible_transitions_lets_a_grip_go_on(active):
    pressure = active.wrap(0.02).pressure_command
    active.pressures.clear()
    for _ in range(BURST):
        active.call(SetParameters, "spiral_gripper/set_parameters", BOTH)
        assert not active.transition("create")
    assert not active.transition("configure")
    active.hear_more()
    assert set(active.pressures) == {pressure}
    assert active.lifecycle_state() == LifecycleState.PRIMARY_STATE_ACTIVE


def test_what_rclpy_raises_at_a_request_to_an_action_ends_nothing(node):
    servers = [waitable for waitable in node.waitables if isinstance(waitable, ActionServer)]
    assert servers
    for server in servers:
        with pytest.raises(StopIteration):
            server.execute({"cancel": (None, None)}).send(None)  # an answer to nobody
    assert node.runtime.errors.count == 0  # what callers cause
