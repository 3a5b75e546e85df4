# SPDX-License-Identifier: Apache-2.0
"""For ``spiral-gripper doctor``: start a node, and ask it to plan one wrap."""

from __future__ import annotations

import os
import tempfile
import time

from spiral_core.errors import SpiralError
from spiral_gripper.files.shown import shown
from spiral_gripper_ros.client import SpiralGripper
from spiral_gripper_ros.process.node_process import NodeProcess
from spiral_gripper_ros.tools.injection import local_discovery
from spiral_gripper_ros.tools.node_text import node_text

# A node starts within seconds, on a slow and busy machine within a minute [s].
START_TIMEOUT = 60.0
LOG_LINES = 5


def plan_by_new_node(gripper: str, radius: float) -> str:
    """Return what a new node of a gripper answers about an object of a radius [m].

    Raises:
        RuntimeError: it does not start, or cannot wrap the object; the message holds its log.
    """
    local_discovery()
    namespace, start = f"/spiral_gripper_doctor_{os.getpid()}", time.monotonic()
    with tempfile.TemporaryFile("w+", errors="replace") as log:
        try:
            given = {"gripper": gripper, "exit_with_parent": True}
            with (
                NodeProcess(namespace, given, output=log),
                SpiralGripper(namespace) as client,
            ):
                client.wait_until_active(START_TIMEOUT)
                elapsed = time.monotonic() - start
                answer = client.plan(radius)
        except SpiralError as error:
            log.seek(0)
            lines = log.read().splitlines()[-LOG_LINES:]
            raise RuntimeError("\n".join((str(error), *lines))) from None
    if not answer.success:
        raise RuntimeError(node_text(answer.message))
    pressure = shown(answer.figures[0].pressure, "Pa")
    return f"active after {elapsed:.1f} s; wraps an object of {shown(radius, 'm')} at {pressure}"
