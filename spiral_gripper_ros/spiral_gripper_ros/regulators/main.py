# SPDX-License-Identifier: Apache-2.0
"""``spiral_gripper_regulator``: the process of the adapter; the last thing it sends is a vent."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from spiral_gripper_ros.process.program import run
from spiral_gripper_ros.process.stop_signals import STARTED_BY, Parent

if TYPE_CHECKING:
    from spiral_gripper_ros.parameters.spec import ParameterSpec
    from spiral_gripper_ros.process.guards import GuardedLoop
    from spiral_gripper_ros.process.stop_signals import StopSignals
    from spiral_gripper_ros.regulators.regulator_node import RegulatorNode

# Between attempts to send the last vent [s].
VENT_PAUSE = 0.1

ABOUT = """\
An adapter from the gripper node to a pressure regulator: topics of its driver, a serial line, or
Modbus TCP.

  subscribes pressure_command [Pa gauge]
  publishes  measured_pressure [Pa gauge], /diagnostics

examples:
  spiral_gripper_regulator --ros-args -p device:=serial -p port:=/dev/ttyACM0
  spiral_gripper_regulator --ros-args -p command_topic:=/valve/set -p command_unit:=kPa
"""


class RegulatorProgram:
    """The adapter's node; it ends with a vent."""

    executable = "spiral_gripper_regulator"
    about = ABOUT

    def __init__(self) -> None:
        self._parent = Parent() if STARTED_BY in os.environ else None

    def make(self) -> RegulatorNode:
        """Make the node."""
        from spiral_gripper_ros.regulators.regulator_node import RegulatorNode

        return RegulatorNode()

    def parameters(self) -> Mapping[str, Sequence[ParameterSpec]]:
        """Return its tables of parameters."""
        from spiral_gripper_ros.regulators.parameters import REGULATOR_PARAMETERS

        return {"parameters": REGULATOR_PARAMETERS}

    def spin(self, node: RegulatorNode, loop: GuardedLoop, signals: StopSignals) -> int:
        """Pass commands on until a stop is requested, or the process that started this one ends.

        Returns:
            The exit code; 1 if the last vent was not answered.
        """
        try:
            signals.defer()
            while not signals.requested:
                loop.turn()
                if self._parent and self._parent.has_gone:
                    node.get_logger().warning("the process that started this one has gone: vented")
                    break
        finally:
            signals.defer()
            vented = node.adapter.vent(lambda: time.sleep(VENT_PAUSE))
            if not vented:
                node.get_logger().error(f"the last vent was not answered: {node.adapter.problem}")
        return 0 if vented else 1


def main(args: list[str] | None = None) -> int:
    """Run the adapter until SIGINT or SIGTERM; return the process's exit code."""
    return run(RegulatorProgram(), args)


if __name__ == "__main__":
    sys.exit(main())
