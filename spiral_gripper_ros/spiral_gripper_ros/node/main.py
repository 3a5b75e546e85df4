# SPDX-License-Identifier: Apache-2.0
"""The process of the node: its executor, its end."""

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
    from spiral_gripper_ros.node.gripper_node import GripperNode
    from spiral_gripper_ros.node.guarded_loop import GuardedLoop
    from spiral_gripper_ros.node.stop_signals import StopSignals

# The interpreter lets another thread run after this time [s] instead of 5 ms: a question that is
# answered in the background then delays a radius by less.
SWITCH_INTERVAL = 0.0005
# So often a process that only waits looks whether it was asked to stop [s].
LONGEST_WAIT = 0.05


def main(args: list[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM; return the process's exit code."""
    return run_process(args, _usage, _run)


def _usage() -> str:
    from spiral_gripper_ros.node.usage import usage

    return usage()


def _run(signals: StopSignals, args: list[str] | None) -> int:
    import rclpy

    sys.setswitchinterval(SWITCH_INTERVAL)
    problem = start_ros(args)
    if problem is not None:
        sys.stderr.write(f"spiral_gripper_node: {problem}\n")
        return 1
    try:
        node = _made(args)
        return 1 if node is None else _spin(node, signals)
    finally:
        rclpy.try_shutdown()


def _made(args: list[str] | None) -> GripperNode | None:
    """Return the node, or None after a line in the log that says why there is none."""
    from rclpy.exceptions import ParameterException
    from rclpy.logging import get_logger

    from spiral_gripper_ros.node.gripper_node import NODE_NAME, GripperNode
    from spiral_gripper_ros.node.parameters import PARAMETERS

    try:
        node = GripperNode()
        if parameters_are_known(args, [node], [spec.name for spec in PARAMETERS]):
            return node
        node.destroy_node()
    except (ParameterException, ValueError) as error:
        get_logger(NODE_NAME).fatal(f"bad parameter at start: {error}")
    except ros_errors() as error:
        get_logger(NODE_NAME).fatal(f"cannot start: {error}")
    return None


def _spin(node: GripperNode, signals: StopSignals) -> int:
    from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor

    from spiral_gripper_ros.node.guarded_loop import GuardedLoop
    from spiral_gripper_ros.node.quiet_memory import QuietMemory
    from spiral_gripper_ros.node.stop_signals import Parent

    signals.defer()
    executor, memory = SingleThreadedExecutor(), QuietMemory()
    executor.add_node(node)
    loop, parent = GuardedLoop(node, executor), Parent()
    try:
        _compile_kernels(node, loop, signals)
        if node.values["autostart"] and not signals.requested and not node.start():
            return 1
        while not signals.requested:
            memory.settle(node.loaded)
            loop.turn()
            if node.values["exit_with_parent"] and parent.has_gone:
                node.get_logger().warning("the process that started this one has gone: vented")
                break
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.vent()
        node.grasps.end(executor)
        executor.shutdown()
        node.destroy_node()
    return 0


def _compile_kernels(node: GripperNode, loop: GuardedLoop, signals: StopSignals) -> None:
    """Compile what is not cached, in another process; meanwhile services are answered.

    Without autostart they are not: the next request configures.
    """
    from spiral_gripper_ros.planning.compilation import Compilation, missing_kernels

    count = missing_kernels()
    if count == 0:
        return
    node.get_logger().info(
        f"compiling {count} numerical kernels, once for this installation: half a minute or more"
    )
    compilation = Compilation()
    try:
        while not compilation.wait(0.0 if node.values["autostart"] else LONGEST_WAIT):
            if signals.requested:
                return
            if node.values["autostart"]:
                loop.turn()
    finally:
        compilation.end()
    node.get_logger().info("the kernels are compiled")


if __name__ == "__main__":
    sys.exit(main())
