# SPDX-License-Identifier: Apache-2.0
"""A run of the benchmarks: alone on its ROS domain, with node processes that say nothing."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import rclpy
from rclpy.signals import SignalHandlerOptions

from spiral_gripper_ros.process.node_process import NODE, NodeProcess

GRIPPER = "paper_design_70"
# Every radius counts, and none waits for the ramp: what is measured is the time from radius to
# pressure, not the limits that a robot would set.
PROMPT = {
    "gripper": GRIPPER,
    "radius.hysteresis": 0.0,
    "radius.rate_limit": 10.0,
    "radius.jump_limit": 1.0,
    "radius.timeout": 600.0,
    "pressure.rate_up": 1.0e7,
    "pressure.rate_down": 1.0e7,
    "grip.ratio": 1.0,  # the answer that is waited for is that of the bare wrap
}


@contextmanager
def own_domain() -> Iterator[None]:
    """Start rclpy on a domain of this run, on this machine only."""
    # Domain 101 is the last whose ports lie outside Linux' range for outgoing connections.
    os.environ["ROS_DOMAIN_ID"] = str(1 + os.getpid() % 101)
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    try:
        yield
    finally:
        rclpy.try_shutdown()


@contextmanager
def process(
    namespace: str,
    parameters: Mapping[str, object] | None = None,
    environment: Mapping[str, str] | None = None,
    module: str = NODE,
) -> Iterator[NodeProcess]:
    """Run a node process without its log."""
    with (
        Path(os.devnull).open("w", encoding="utf-8") as nowhere,
        NodeProcess(namespace, parameters, environment, nowhere, module) as running,
    ):
        yield running
