# SPDX-License-Identifier: Apache-2.0
"""Several grippers in one process: ``python -m benchmarks.ros.many_grippers``.

The node is a class like any other: make as many as there are grippers, each in a namespace of its
own, and give them one executor. ``SPIRAL_GRIPPERS`` says how many.
"""

from __future__ import annotations

import gc
import os

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from benchmarks.ros.session import PROMPT
from spiral_gripper_ros.node.gripper_node import GripperNode
from spiral_gripper_ros.process.stop_signals import StopSignals

MODULE = "benchmarks.ros.many_grippers"
PARAMETERS = {**PROMPT, "pressure.fault_policy": "vent"}


def main() -> None:
    """Run the grippers until a stop signal; then vent all of them."""
    signals = StopSignals()
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    executor = SingleThreadedExecutor()
    grippers = [gripper(index) for index in range(int(os.environ.get("SPIRAL_GRIPPERS", "10")))]
    for node in grippers:
        executor.add_node(node)
        node.start()
    gc.freeze()
    signals.defer()
    while not signals.requested:
        executor.spin_once(timeout_sec=0.05)
    for node in grippers:
        node.vent()
    executor.shutdown()
    for node in grippers:
        node.destroy_node()
    rclpy.try_shutdown()


def gripper(index: int) -> GripperNode:
    """Return one of them; its namespace and parameters are its own, not those of the process."""
    return GripperNode(
        namespace=f"/many/gripper_{index}",
        use_global_arguments=False,
        parameter_overrides=[Parameter(name, value=value) for name, value in PARAMETERS.items()],
    )


if __name__ == "__main__":
    main()
