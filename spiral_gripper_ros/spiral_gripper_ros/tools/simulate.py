# SPDX-License-Identifier: Apache-2.0
"""``spiral-gripper simulate``: a gripper without hardware, until it is stopped."""

from __future__ import annotations

import math
import os
import shlex
import shutil
import sys
from pathlib import Path

from spiral_gripper_ros.simulation.regulator import Fault
from spiral_gripper_ros.tools.injection import injection_name
from spiral_gripper_ros.tools.session import STARTING, run_session


def simulate(
    gripper: str,
    settings: dict[str, object],
    duration: float = math.inf,
    namespace: str | None = None,
) -> int:
    """Run node and simulator; return the process's exit code.

    Args:
        gripper: a shipped gripper's name, or a description file's path.
        settings: parameters of the simulator.
        duration: from when the node is active [s]; inf: until SIGINT or SIGTERM.
        namespace: of all topics; None: one that nobody else has.
    """
    space = "/" + (namespace or f"spiral_gripper_simulation_{os.getpid()}").strip("/")
    return run_session(space, gripper, settings, duration, _introduction(space))


def program() -> str:
    """Return the program that runs, as a shell anywhere on this machine finds it."""
    own = Path(sys.argv[0]).absolute()
    return shlex.quote(str(own)) if own.is_file() and os.access(own, os.X_OK) else "spiral-gripper"


def _introduction(space: str) -> list[str]:
    """Return what is started, and what may be done with it."""
    faults = ", ".join(fault.value for fault in Fault)
    lines = [
        STARTING,
        f"topics: below {space}; stop: Ctrl-C",
        f"faults ({faults}), from another terminal:",
        f"  {program()} inject {Fault.LEAK.value} --namespace {space}",
    ]
    if shutil.which("ros2") is not None:
        service = injection_name(space, Fault.LEAK)
        lines.append(f"  ros2 service call {service} std_srvs/srv/Trigger")
    return lines
