# SPDX-License-Identifier: Apache-2.0
"""``spiral_gripper_demo``: the simulation with a stream of radii, good and bad ones.

Ends by itself after about 30 s; the exit code is then 0 only if everything that should have
happened did. Ctrl-C stops it.
"""

from __future__ import annotations

import math
import os
import random
import sys

from rclpy.qos import qos_profile_sensor_data
from std_msgs.msg import Float64

from spiral_gripper import load_gripper
from spiral_gripper_msgs.msg import GripStatus, Wrap
from spiral_gripper_ros.control.states import Reason
from spiral_gripper_ros.messages.conversions import known
from spiral_gripper_ros.messages.qos import LATEST
from spiral_gripper_ros.process.program import HELP_OPTIONS
from spiral_gripper_ros.tools.demo_report import DemoReport
from spiral_gripper_ros.tools.session import STARTING, run_session
from spiral_gripper_ros.tools.watcher import Watcher, say

GRIPPER = "paper_design_70"
OBJECTS = {"tube light": 0.011, "PVC pipe": 0.030}
# The objects take turns, 8 s each. The demo makes the estimates.
SIMULATOR = {
    "profile": "step",
    "radius": OBJECTS["PVC pipe"],
    "radius_variation": OBJECTS["tube light"] / OBJECTS["PVC pipe"] - 1.0,
    "radius_period": 16.0,
    "dropout_probability": 1.0,
}
# Long enough for each object from its beginning to its end, whichever comes first [s].
DURATION = 29.0
# Standard deviation of the estimates [m].
NOISE = 2.0e-5
# So many estimates, and those of them that are wrong: the first, their number, and their radius
# [m]; None: they do not come.
CYCLE = 200
FAULTS = (
    (40, 5, math.nan),  # a blinded camera
    (60, 2, -0.011),  # a sign error
    (80, 2, 0.02),  # another object that could be gripped
    (100, 6, 0.09),  # one that is too large
    (120, 6, 0.002),  # one that is too small
    (140, 40, None),  # the camera pauses
)
BAD_USAGE = 2
USAGE = """\
usage: spiral_gripper_demo [-h]

Starts node and simulator as processes: a stream of radii, good and bad ones, for 30 s.
Keeps to this machine and a namespace of its own, and ends vented; Ctrl-C stops it.
Exit code: 0 all was as expected, or it was stopped, 1 something was not, 2 an unknown argument.
"""
_NOT_REFUSED = (Reason.NONE, Reason.NO_RADIUS, Reason.RELEASED, Reason.NOT_ACTIVE)


def estimate(number: int, radius: float) -> float | None:
    """Return the estimate of a number for an object's radius [m]; None: it does not come.

    Example:
        >>> estimate(40, 0.03), estimate(140, 0.03)
        (nan, None)
    """
    for first, count, wrong in FAULTS:
        if first <= number % CYCLE < first + count:
            return wrong
    return radius + random.gauss(0.0, NOISE)


class DemoWatcher(Watcher):
    """Publishes estimates of the simulated object, and notes in a report what the node answers.

    Args:
        namespace: of node and simulator.
    """

    def __init__(self, namespace: str) -> None:
        super().__init__(namespace)
        self._report = DemoReport(OBJECTS, load_gripper(GRIPPER).pressure_max)
        self._number = 0
        self._radius: float | None = None
        self._reason = Reason.NONE
        quality = qos_profile_sensor_data
        self._estimates = self.node.create_publisher(Float64, "object_radius", quality)
        self.node.create_subscription(Float64, "simulated/object_radius", self._on_object, quality)
        self.node.create_subscription(Float64, "pressure_command", self._on_pressure, 10)
        self.node.create_subscription(GripStatus, "status", self._on_status, LATEST)
        self.node.create_subscription(Wrap, "wrap", self._on_wrap, LATEST)

    def verdict(self) -> list[str]:
        """Say what was heard; return what was not as expected."""
        for line in self._report.summary():
            say(line)
        found = self._report.problems()
        if not found:
            say("all as expected", "green")
        return [f"NOT AS EXPECTED: {problem}" for problem in found]

    def _on_object(self, message: Float64) -> None:
        radius = estimate(self._number, message.data)
        self._number += 1
        if radius is not None:
            self._estimates.publish(Float64(data=radius))

    def _on_pressure(self, message: Float64) -> None:
        self._report.pressures.append(message.data)

    def _on_status(self, status: GripStatus) -> None:
        reason = Reason(status.reason)
        if reason is not self._reason and reason not in _NOT_REFUSED:
            self._report.refused[reason] += 1
        self._reason = reason
        at_target = status.pressure_command == status.pressure_target
        radius = known(status.object_radius)
        if at_target and radius and status.regime == GripStatus.REGIME_PERFECT_WRAP:
            self._report.wrap(radius, status.pressure_command)

    def _on_wrap(self, message: Wrap) -> None:
        for plan in message.plan:
            if plan.object_radius != self._radius:
                self._report.solve_times.append(plan.solve_time)
            self._radius = plan.object_radius


def main(args: list[str] | None = None) -> int:
    """Run the demo, or show its help; return the process's exit code.

    Args:
        args: the command line's arguments; None: those of this process.
    """
    given = sys.argv[1:] if args is None else args
    if not HELP_OPTIONS.isdisjoint(given):
        sys.stdout.write(USAGE)
        return 0
    if given:
        sys.stderr.write(f"spiral_gripper_demo: it takes no arguments, got {given[0]!r}\n")
        return BAD_USAGE
    space = f"/spiral_gripper_demo_{os.getpid()}"
    lines = [STARTING, f"topics: below {space}; stop: Ctrl-C"]
    return run_session(space, GRIPPER, SIMULATOR, DURATION, lines, DemoWatcher)


if __name__ == "__main__":
    sys.exit(main())
