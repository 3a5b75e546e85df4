# SPDX-License-Identifier: Apache-2.0
"""From the start of the process to the first command, and where that time goes."""

from __future__ import annotations

import tempfile
import time

import numpy as np

from benchmarks.results import Section, Table
from benchmarks.ros.effort import NodeEffort
from benchmarks.ros.probe import Probe
from benchmarks.ros.session import PROMPT, process
from benchmarks.startup import run

# Seconds from the start of Python to: imported, node made, configured, active.
STAGES = """
import sys, time
begin = time.perf_counter()
found = []
def stage():
    found.append(time.perf_counter() - begin)
import rclpy
from spiral_gripper_ros.node.gripper_node import GripperNode
stage()
rclpy.init()
node = GripperNode(namespace="/stages", enable_rosout=False)
stage()
node.get_logger().set_level(rclpy.logging.LoggingSeverity.ERROR)
node.trigger_configure()
stage()
node.trigger_activate()
stage()
print(*found)
"""


def measure(effort: NodeEffort) -> Section:
    """Start processes, with and without compiled kernels."""
    warm = float(np.median([first_status(f"/warm_{k}", {}) for k in range(effort.starts)]))
    stages = np.median([run(STAGES) for _ in range(effort.starts)], axis=0)
    imported, made, configured, active = np.diff(stages, prepend=0.0).tolist()
    values = {"warm": warm, "import": imported, "node": made, "configure": configured}
    rows = [
        ("start to first status, kernels cached", f"{warm:.2f} s"),
        ("... of which: import", f"{imported:.2f} s"),
        ("... rclpy and the node", f"{made:.2f} s"),
        ("... configure", f"{configured:.2f} s"),
        ("... activate", f"{active:.2f} s"),
    ]
    if effort.compile_anew:
        with tempfile.TemporaryDirectory() as empty:
            first = first_status("/compiling", {"NUMBA_CACHE_DIR": empty})
        values["compiling"] = first
        rows.append(("first start ever, compiling the kernels", f"{first:.1f} s"))
    note = f"Medians of {effort.starts} processes. The rest of the first row is Python itself, and "
    note += "discovery: the status must arrive in another process."
    return Section((Table("Start", ("", "time"), tuple(rows), note),), values)


def first_status(namespace: str, environment: dict[str, str]) -> float:
    """Return the time from starting a process until its first status arrives [s]."""
    probe = Probe(namespace)
    probe.follow_status()
    begin = time.perf_counter()
    with process(namespace, PROMPT, environment):
        probe.spin_until(lambda: probe.status is not None)
        duration = time.perf_counter() - begin
    probe.close()
    return duration
