# SPDX-License-Identifier: Apache-2.0
"""``spiral_gripper_demo``: the simulation of two objects, with good and bad radii, for 30 s."""

from __future__ import annotations

import sys

from spiral_gripper_ros.process.program import HELP_OPTIONS
from spiral_gripper_ros.tools.simulate import simulate

TUBE_LIGHT, PIPE = 0.011, 0.030
# The objects take turns, 8 s each. Of the estimates some are not a number, and some are off by more
# than any object: too large, or negative.
SIMULATOR: dict[str, object] = {
    "profile": "step",
    "radius": PIPE,
    "radius_variation": TUBE_LIGHT / PIPE - 1.0,
    "radius_period": 16.0,
    "nan_probability": 0.05,
    "outlier_probability": 0.1,
    "outlier_size": 0.05,
}
# Long enough for each object from its beginning to its end, whichever comes first [s].
DURATION = 29.0
BAD_USAGE = 2
USAGE = """\
usage: spiral_gripper_demo [-h]

Starts node and simulator as processes: a stream of radii, good and bad ones, for 30 s.
Keeps to this machine and a namespace of its own, and ends vented; Ctrl-C stops it.
Exit code: 0 all went well, 1 something did not, 2 an unknown argument.
"""


def main(args: list[str] | None = None) -> int:
    """Run the demo, or show its help; return the process's exit code.

    Args:
        args: the command line's arguments; None: those of this process.
    """
    given = sys.argv[1:] if args is None else args
    if given:
        sys.stdout.write(USAGE)
        return 0 if HELP_OPTIONS.issuperset(given) else BAD_USAGE
    return simulate("paper_design_70", SIMULATOR, DURATION)


if __name__ == "__main__":
    sys.exit(main())
