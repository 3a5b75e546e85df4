# SPDX-License-Identifier: Apache-2.0
"""What the tests of the Python client share."""

import time
from pathlib import Path

from ros.harness import DEADLINE

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "grasp_with_python.py"
RADIUS = 0.02
# Of everything that these tests wait for [s].
PATIENCE = DEADLINE
QUESTIONS = [
    lambda gripper: gripper.wait_until_active(0.2),
    lambda gripper: gripper.wrap(RADIUS),
    lambda gripper: gripper.plan(RADIUS),
    lambda gripper: gripper.release(),
    lambda gripper: gripper.rearm(),
]


def wait_until(condition):
    """Poll a condition that listens itself until it holds."""
    deadline = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < deadline


def wait_for_pressure(gripper):
    """Wait until the wrap that runs has some pressure."""
    wait_until(
        lambda: (
            not gripper.is_done() and gripper.feedback() and gripper.feedback().pressure_command > 0
        )
    )
