# SPDX-License-Identifier: Apache-2.0
"""``spiral_gripper_simulator``: the process of the simulator."""

from __future__ import annotations

import sys
from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Any

from spiral_gripper_ros.process.program import run

if TYPE_CHECKING:
    from spiral_gripper_ros.process.stop_signals import StopSignals
    from spiral_gripper_ros.simulation.simulator import Simulator

# How long the executor may sleep before it looks whether it was asked to stop [s].
LONGEST_SLEEP = 0.05


class SimulatorProgram:
    """The simulator, its nodes and its executor."""

    executable = "spiral_gripper_simulator"

    def usage(self) -> str:
        """Return the help text."""
        from spiral_gripper_ros.simulation.usage import simulator_usage

        return simulator_usage()

    def make(self) -> Simulator:
        """Make the simulator."""
        from rclpy.executors import SingleThreadedExecutor

        from spiral_gripper_ros.simulation.simulator import Simulator

        return Simulator(SingleThreadedExecutor())

    def nodes(self, simulator: Simulator) -> Sequence[Any]:
        """Return its nodes."""
        return simulator.nodes

    def parameters(self) -> Collection[str]:
        """Return the names of their parameters."""
        from spiral_gripper_ros.simulation.parameters import ALL_NAMES

        return ALL_NAMES

    def spin(self, simulator: Simulator, signals: StopSignals) -> int:
        """Simulate until a stop is requested."""
        signals.defer()
        try:
            while not signals.requested:
                simulator.executor.spin_once(timeout_sec=LONGEST_SLEEP)
        finally:
            simulator.executor.shutdown()
        return 0


def main(args: list[str] | None = None) -> int:
    """Run the simulator until SIGINT or SIGTERM; return the process's exit code."""
    return run(SimulatorProgram(), args)


if __name__ == "__main__":
    sys.exit(main())
