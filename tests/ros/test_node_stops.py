"""Start and stop of node processes: signals, bad starts, lifecycle managers."""

import signal

import pytest
from lifecycle_msgs.msg import State as LifecycleState
from ros.harness import FAST_RAMP, RunningNode

from spiral_gripper_ros.control.states import State


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_stop_signal_makes_a_vent_the_last_command(client, namespace, number):
    with RunningNode(namespace, FAST_RAMP) as node:
        client.wait_until_active()
        assert client.wrap(0.02).pressure_command > 0.0
        assert node.stop(number) == 0
        client.wait_until(lambda: client.pressures[-1] == 0.0, "the vent")
        client.spin(0.2)
        assert client.pressures[-1] == 0.0
        assert client.status.state == State.INACTIVE
        assert "Traceback" not in node.log()


def test_without_autostart_it_waits_for_its_manager(client, namespace):
    with RunningNode(namespace, {"autostart": "false"}) as node:
        assert client.lifecycle_state() == LifecycleState.PRIMARY_STATE_UNCONFIGURED
        assert client.transition("configure")
        assert client.transition("activate")
        client.wait_until_active()
        assert client.transition("active_shutdown")
        assert client.lifecycle_state() == LifecycleState.PRIMARY_STATE_FINALIZED
        client.wait_until(lambda: client.pressures[-1] == 0.0, "the vent")
        assert node.stop() == 0, node.log()


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"radius_timeout": "-1.0"}, "radius_timeout"),
        ({"radius_timeout_policy": "panic"}, "one of hold, vent, ramp_down"),
        ({"gravity": "[1.0, 2.0]"}, "3 finite numbers"),
        ({"gripper": "no_such_gripper"}, "no gripper has this name"),
        ({"griper": "prototype_p1"}, "did you mean gripper?"),
    ],
)
def test_a_start_that_cannot_be_ends_with_the_reason(client, namespace, parameters, message):
    with RunningNode(namespace, parameters) as node:
        client.wait_until(lambda: not node.running, "the end of the process")
        assert node.exit_code == 1
        assert message in node.log()
        assert "Traceback" not in node.log()
        assert not any(client.pressures)
