# SPDX-License-Identifier: Apache-2.0
"""A Python client in the style of Nav2's simple commander: :class:`SpiralGripper`."""

from spiral_gripper_ros.client.answers import (
    NoAnswerError,
    RequestRefusedError,
    WrapOutcome,
    WrapResult,
)
from spiral_gripper_ros.client.spiral_gripper import SpiralGripper
from spiral_gripper_ros.control.limits import AbortPolicy

__all__ = [
    "AbortPolicy",
    "NoAnswerError",
    "RequestRefusedError",
    "SpiralGripper",
    "WrapOutcome",
    "WrapResult",
]
