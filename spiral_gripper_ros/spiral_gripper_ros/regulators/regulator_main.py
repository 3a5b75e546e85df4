# SPDX-License-Identifier: Apache-2.0
"""``spiral_gripper_regulator``: the process of the adapter; the last thing it sends is a vent."""

from __future__ import annotations

import sys
import time
from typing import TYPE_CHECKING

from spiral_gripper_ros.node.process_frame import (
    parameters_are_known,
    ros_errors,
    run_process,
    start_ros,
)

if TYPE_CHECKING:
    from spiral_gripper_ros.node.stop_signals import StopSignals
    from spiral_gripper_ros.regulators.regulator_node import RegulatorNode

# How long the executor may sleep before it looks whether it was asked to stop [s].
LONGEST_SLEEP = 0.05
# Between attempts to send the last vent [s].
VENT_PAUSE = 0.1


def main(args: list[str] | None = None) -> int:
    """Run the adapter until SIGINT or SIGTERM; return the process's exit code."""
    return run_process(args, _usage, _run)


def _usage() -> str:
    from spiral_gripper_ros.regulators.usage import usage

    return usage()


def _run(signals: StopSignals, args: list[str] | None) -> int:
    import rclpy

    problem = start_ros(args)
    if problem is not None:
        sys.stderr.write(f"spiral_gripper_regulator: {problem}\n")
        return 1
    try:
        node = _made(args)
        return 1 if node is None else _spin(node, signals)
    finally:
        rclpy.try_shutdown()


def _made(args: list[str] | None) -> RegulatorNode | None:
    """Return the node, or None after a line in the log that says why there is none."""
    from rclpy.exceptions import ParameterException
    from rclpy.logging import get_logger

    from spiral_gripper_ros.regulators.parameters import REGULATOR_PARAMETERS
    from spiral_gripper_ros.regulators.regulator_node import REGULATOR_NODE, RegulatorNode

    try:
        node = RegulatorNode()
        if parameters_are_known(args, [node], [spec.name for spec in REGULATOR_PARAMETERS]):
            return node
        node.destroy_node()
    except (ParameterException, ValueError, *ros_errors()) as error:
        get_logger(REGULATOR_NODE).fatal(f"cannot start: {error}")
    return None


def _spin(node: RegulatorNode, signals: StopSignals) -> int:
    from rclpy.executors import SingleThreadedExecutor

    executor = SingleThreadedExecutor()
    executor.add_node(node)
    try:
        signals.defer()
        while not signals.requested:
            executor.spin_once(timeout_sec=LONGEST_SLEEP)
    finally:
        signals.defer()
        vented = node.adapter.vent(lambda: time.sleep(VENT_PAUSE))
        if not vented:
            node.get_logger().error(f"the last vent was not answered: {node.adapter.problem}")
        executor.shutdown()
        node.destroy_node()
    return 0 if vented else 1


if __name__ == "__main__":
    sys.exit(main())
