# SPDX-License-Identifier: Apache-2.0
"""``spiral-gripper inject``: sets the fault of a running simulation, without ros2cli."""

from __future__ import annotations

import os
import sys

from std_srvs.srv import Trigger

from spiral_gripper_ros.client.connection import Connection
from spiral_gripper_ros.simulation.regulator import REGULATOR_NODE, Fault, injection_service

DISCOVERY_TIMEOUT = 5.0
NOT_SET = 2


def local_discovery() -> None:
    """Keep to this machine, unless the environment says otherwise."""
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")


def injection_name(namespace: str, fault: Fault) -> str:
    """Return the full name of the service that sets a fault."""
    space = namespace.strip("/")
    return f"{'/' if space else ''}{space}/{REGULATOR_NODE}/{injection_service(fault)}"


def inject(namespace: str, fault: str) -> int:
    """Set the fault of the simulation in a namespace; return the process's exit code.

    Raises:
        NoAnswerError: no simulation answers.
    """
    local_discovery()
    name = injection_name(namespace, Fault(fault))
    link = Connection("/", DISCOVERY_TIMEOUT, lambda: f"no simulation answers at {name}")
    try:
        answer = link.call(link.node.create_client(Trigger, name), Trigger.Request())
    finally:
        link.close()
    sys.stdout.write(f"{answer.message}\n")
    return 0 if answer.success else NOT_SET
