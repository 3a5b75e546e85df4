# SPDX-License-Identifier: Apache-2.0
"""Whether the object stays in the gripper: holding force against the load along gravity."""

from __future__ import annotations

from concurrent.futures import Executor

from spiral_core.wrap.gripper import Gripper
from spiral_gripper_ros.planning.grip_follower import GripFollower, InUse, Solve
from spiral_gripper_ros.simulation.simulated_gripper import Grip

# Wrapped as far as the free coil's tip says; whether it holds is the question here.
_WRAPPED = (Grip.PERFECT_WRAP, Grip.CURLING)


class ObjectHold:
    """Lets the object slip out of the coil once the load exceeds the holding force.

    The grip on the object is solved in the background and takes seconds; until it is known, nothing
    slips. An object that has slipped is gone until the gripper opens, or there is another one.

    Args:
        gripper: as it really is.
        solve: answers a question, in seconds.
        pool: runs it.
    """

    def __init__(self, gripper: Gripper, solve: Solve, pool: Executor) -> None:
        self._gravity = gripper.gravity
        self._grips = GripFollower(gripper, gripper.gravity, solve, pool)
        self._radius: float | None = None
        self._has_slipped = False

    def judge(
        self, now: float, grip: Grip, radius: float | None, pressure: float, load: float
    ) -> Grip:
        """Return how the object is held, or that it has slipped.

        Args:
            now: time [s].
            grip: as the free coil says.
            radius: of the object [m]; None: there is none.
            pressure: in the gripper [Pa].
            load: force that pulls at the object along gravity [N]; 0: none.
        """
        if radius != self._radius or grip not in _WRAPPED or load == 0.0:
            self._radius, self._has_slipped = radius, False
        if radius is None or load == 0.0:
            return grip
        in_use = InUse(radius)
        self._grips.follow(now, self._gravity, (radius, radius), 1, in_use)
        held = self._grips.answer(in_use, pressure, pressure)
        if grip in _WRAPPED and held is not None and held.down < load:
            self._has_slipped = True
        return Grip.SLIPPED if self._has_slipped else grip
