# SPDX-License-Identifier: Apache-2.0
"""``spiral-gripper simulate``: a gripper without hardware, until it is stopped."""

from __future__ import annotations

import os
import shlex
import shutil
import sys
from pathlib import Path

from spiral_gripper_ros.simulation.regulator import Fault
from spiral_gripper_ros.tools.injection import injection_name
from spiral_gripper_ros.tools.session import STARTING, Plan, run_session


def simulate(plan: Plan) -> int:
    """Run node and simulator as planned; return the process's exit code."""
    problems, _ = run_session(plan, _introduction(plan.space))
    return 1 if problems else 0


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
