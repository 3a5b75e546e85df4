# SPDX-License-Identifier: Apache-2.0
"""What an operator reads: the help, and a log that says each thing once."""

import pytest
from ros.harness import FAST_RAMP, PATIENT, RunningNode

from spiral_gripper_ros.control.states import State
from spiral_gripper_ros.node.main import main
from spiral_gripper_ros.parameters.table import PARAMETERS


def test_an_operator_reads_what_happens_once(client, namespace):
    with RunningNode(namespace, {**FAST_RAMP, **PATIENT}) as node:
        client.wait_until_active()
        client.regulator = lambda pressure: pressure
        client.wait_until(lambda: client.status.measured_pressure, "a measured pressure")
        client.wrap(0.02)
        client.wait_until(lambda: client.status.wrapped, "the wrap")
        for _ in range(20):
            client.send_radius(0.2)
            client.spin(0.02)
        client.wait_for_state(State.HOLDING)
        client.regulator = lambda pressure: 0.8 * pressure
        client.wait_until(lambda: client.status.fault, "the fault")
        assert client.release().success
        client.wait_for_state(State.RELEASED)
        client.spin(0.2)
        assert node.stop() == 0
        log = node.log()
    for line in (
        "waiting for an object_radius",
        "following object_radius, radius 20 mm",
        "the object is wrapped at",
        "holding at",
        "stays below the command",
        "released, vented",
        "inactive, vented",
    ):
        assert log.count(line) == 1, f"{line!r} in\n{log}"
    assert "[ERROR]" in log
    assert "[WARN]" in log
    assert len(log.splitlines()) < 20, log


@pytest.mark.parametrize("option", ["-h", "--help"])
def test_help_is_printed_and_no_node_started(option, capsys):
    assert main([option]) == 0
    captured = capsys.readouterr()
    assert captured.out.startswith("usage: spiral_gripper_node")
    assert captured.err == ""
    assert all(f"  {spec.name} (" in captured.out for spec in PARAMETERS)
