# SPDX-License-Identifier: Apache-2.0
"""The process of the node: its executor, its end."""

from __future__ import annotations

import gc
import sys
from collections.abc import Mapping, Sequence
from concurrent import futures
from typing import TYPE_CHECKING

from spiral_gripper_ros.process.program import run
from spiral_gripper_ros.process.stop_signals import Parent

if TYPE_CHECKING:
    from spiral_gripper_ros.node.gripper_node import GripperNode
    from spiral_gripper_ros.parameters.spec import ParameterSpec
    from spiral_gripper_ros.process.guards import GuardedLoop
    from spiral_gripper_ros.process.stop_signals import StopSignals

# So often a process that only waits looks whether it was asked to stop [s].
LONGEST_WAIT = 0.05
# Kernels that cannot be kept would be compiled within the node, which then answers nobody.
UNKEPT = (
    "the compiled kernels cannot be kept, neither in the installation nor in the user's cache: set "
    "NUMBA_CACHE_DIR to a folder that can be written, and start again"
)

ABOUT = """\
A lifecycle node that turns object radii into the pressure of the perfect wrap.

  subscribes object_radius [m], gravity [m/s^2], measured_pressure [Pa gauge, optional]
  publishes  pressure_command [Pa gauge]
             status, wrap, backbone, measured_backbone, markers, /diagnostics
  serves     vent, rearm, plan_wrap, design_gripper, cancel_design
             actions: grasp, release, find_approach
             and, with control_msgs, gripper_cmd, parallel_gripper_cmd

example:
  spiral_gripper_node --ros-args -r __ns:=/left -p gripper:=prototype_p1
"""


class NodeProgram:
    """The gripper's node, its executor and its end."""

    executable = "spiral_gripper_node"
    about = ABOUT

    def __init__(self) -> None:
        self._parent = Parent()

    def make(self) -> GripperNode:
        """Make the node."""
        from spiral_gripper_ros.node.gripper_node import GripperNode

        return GripperNode()

    def parameters(self) -> Mapping[str, Sequence[ParameterSpec]]:
        """Return its tables of parameters."""
        from spiral_gripper_ros.parameters.table import PARAMETERS

        return {"parameters": PARAMETERS}

    def spin(self, node: GripperNode, loop: GuardedLoop, signals: StopSignals) -> int:
        """Run the node until a stop is requested; it ends vented."""
        from rclpy.executors import ExternalShutdownException

        from spiral_gripper_ros.planning.worker import join_ended

        signals.defer()
        is_frozen = False
        try:
            _compile_kernels(node, loop, signals)
            if node.runtime.values.autostart and not signals.requested and not node.start():
                return 1
            while not signals.requested:
                if not is_frozen and node.runtime.loaded is not None:
                    # A full collection would look at every object of the libraries again and again,
                    # which takes 50 to 150 ms in which nothing is commanded.
                    gc.freeze()
                    is_frozen = True
                loop.turn()
                if node.runtime.values.exit_with_parent and self._parent.has_gone:
                    node.get_logger().warning("the process that started this one has gone: vented")
                    break
        except (KeyboardInterrupt, ExternalShutdownException):
            pass
        finally:
            node.vent()
            if node.goals.end(loop):
                node.vent()  # whatever else has been called meanwhile
            node.runtime.background.end()
            join_ended()
        return 0


def main(args: list[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM; return the process's exit code."""
    return run(NodeProgram(), args)


def _compile_kernels(node: GripperNode, loop: GuardedLoop, signals: StopSignals) -> None:
    """Compile what is not cached, in another process; meanwhile services are answered.

    Only a request to configure waits for it.
    """
    from spiral_gripper.kernels import kernels_are_compiled
    from spiral_gripper_ros.planning.planner import compile_all
    from spiral_gripper_ros.planning.worker import Worker

    if kernels_are_compiled():
        return
    node.get_logger().info(
        "compiling the numerical kernels, once for this installation: some 15 s or more"
    )
    worker = Worker("compilation")
    compilation = worker.submit(compile_all)

    def wait() -> bool:
        while not futures.wait([compilation], LONGEST_WAIT).done:
            if signals.requested:
                return False
        if not kernels_are_compiled():
            node.get_logger().error(UNKEPT)
        return kernels_are_compiled()

    node.wait_for_kernels = wait
    try:
        while not compilation.done():
            if signals.requested:
                return
            loop.turn()
    finally:
        worker.end()
    error = compilation.exception()
    if error is not None:
        node.get_logger().error(f"compiling the kernels: {type(error).__name__}: {error}")
    if kernels_are_compiled():
        node.get_logger().info("the kernels are compiled")


if __name__ == "__main__":
    sys.exit(main())
