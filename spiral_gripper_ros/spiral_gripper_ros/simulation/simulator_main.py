# SPDX-License-Identifier: Apache-2.0
"""``spiral_gripper_simulator``: the process of the simulator."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from spiral_gripper_ros.node.process_frame import (
    parameters_are_known,
    ros_errors,
    run_process,
    start_ros,
)

if TYPE_CHECKING:
    from rclpy.executors import Executor

    from spiral_gripper_ros.node.stop_signals import StopSignals
    from spiral_gripper_ros.simulation.simulator import Simulator

# How long the executor may sleep before it looks whether it was asked to stop [s].
LONGEST_SLEEP = 0.05


def main(args: list[str] | None = None) -> int:
    """Run the simulator until SIGINT or SIGTERM; return the process's exit code."""
    return run_process(args, _usage, _run)


def _usage() -> str:
    from spiral_gripper_ros.simulation.simulator_usage import simulator_usage

    return simulator_usage()


def _run(signals: StopSignals, args: list[str] | None) -> int:
    import rclpy
    from rclpy.executors import SingleThreadedExecutor

    problem = start_ros(args)
    if problem is not None:
        sys.stderr.write(f"spiral_gripper_simulator: {problem}\n")
        return 1
    executor = SingleThreadedExecutor()
    try:
        simulator = _started(executor, args)
        if simulator is None:
            return 1
        signals.defer()
        while not signals.requested:
            executor.spin_once(timeout_sec=LONGEST_SLEEP)
        return 0
    finally:
        signals.defer()
        executor.shutdown()
        rclpy.try_shutdown()


def _started(executor: Executor, args: list[str] | None) -> Simulator | None:
    """Return the simulator, or None after a line in the log that says why there is none."""
    from rclpy.exceptions import ParameterException
    from rclpy.logging import get_logger

    from spiral_core.errors import SpiralError
    from spiral_gripper_ros.simulation.parameters import ALL_NAMES
    from spiral_gripper_ros.simulation.simulator import Simulator

    try:
        simulator = Simulator(executor)
        if parameters_are_known(args, simulator.nodes, ALL_NAMES):
            return simulator
    except (ParameterException, SpiralError, ValueError, *ros_errors()) as error:
        get_logger("spiral_gripper_simulator").fatal(f"cannot start: {error}")
    return None


if __name__ == "__main__":
    sys.exit(main())
