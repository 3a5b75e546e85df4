# SPDX-License-Identifier: Apache-2.0
"""``spiral_gripper_simulator``: the process of the simulator."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from spiral_gripper_ros.process.program import run
from spiral_gripper_ros.process.stop_signals import STARTED_BY, Parent

if TYPE_CHECKING:
    from spiral_gripper_ros.parameters.spec import ParameterSpec
    from spiral_gripper_ros.process.guards import GuardedLoop
    from spiral_gripper_ros.process.stop_signals import StopSignals
    from spiral_gripper_ros.simulation.simulator import Simulator


ABOUT = """\
A simulated regulator, gripper and source of radii: the node without hardware.

  subscribes pressure_command [Pa gauge]
  publishes  measured_pressure, object_radius, /diagnostics; /clock if asked to
             simulated/pressure, simulated/object_radius, simulated/grip, simulated/backbone
  serves     simulated_regulator/inject_leak, inject_stuck_valve, inject_lost_link, clear_fault

example:
  spiral_gripper_simulator --ros-args -r __ns:=/left -p radius:=0.02 -p fault:=leak
"""


class SimulatorProgram:
    """The simulator and its nodes."""

    executable = "spiral_gripper_simulator"
    about = ABOUT

    def __init__(self) -> None:
        self._parent = Parent() if STARTED_BY in os.environ else None

    def make(self) -> Simulator:
        """Make the simulator."""
        from spiral_gripper_ros.simulation.simulator import Simulator

        return Simulator()

    def parameters(self) -> Mapping[str, Sequence[ParameterSpec]]:
        """Return its tables of parameters."""
        from spiral_gripper_ros.simulation.radius_estimator import RadiusParameters
        from spiral_gripper_ros.simulation.regulator import SimulatedRegulatorParameters

        return {
            "parameters of simulated_regulator": SimulatedRegulatorParameters.specs(),
            "parameters of radius_source": RadiusParameters.specs(),
        }

    def spin(self, simulator: Simulator, loop: GuardedLoop, signals: StopSignals) -> int:
        """Simulate until a stop is requested, or the process that started this one has gone."""
        del simulator
        signals.defer()
        while not signals.requested and not (self._parent and self._parent.has_gone):
            loop.turn()
        return 0


def main(args: list[str] | None = None) -> int:
    """Run the simulator until SIGINT or SIGTERM; return the process's exit code."""
    return run(SimulatorProgram(), args)


if __name__ == "__main__":
    sys.exit(main())
