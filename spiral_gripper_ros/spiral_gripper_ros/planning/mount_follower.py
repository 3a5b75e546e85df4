# SPDX-License-Identifier: Apache-2.0
"""Updates the planner for a changing gravity while the arm tilts, in the background."""

from __future__ import annotations

import math
from concurrent.futures import Executor, Future

from spiral_core.rod.types import Vector
from spiral_core.wrap.gripper import Gripper
from spiral_gripper_ros.planning.grip_follower import GripFollower
from spiral_gripper_ros.planning.planner import (
    AnyPlanner,
    NoPlanner,
    PlannerFailedError,
    planner_for,
)


class MountFollower:
    """Makes the planner for the newest gravity in the background, one at a time.

    Between a change of gravity and :meth:`poll` handing out the new planner (some tens of
    milliseconds) the old one stands.

    Args:
        planner: the present one.
        gripper: the gripper to be planned for.
        pool: runs the background work.
        grips: what is known of grips by contact, for the planners to come; None: nothing.
    """

    def __init__(
        self,
        planner: AnyPlanner,
        gripper: Gripper,
        pool: Executor,
        grips: GripFollower | None = None,
    ) -> None:
        self.planner = planner
        self._gripper, self._grips = gripper, grips
        self._pool = pool
        self._wanted = planner.gravity
        self._job: Future[AnyPlanner] | None = None

    @property
    def gravity(self) -> Vector:
        """Newest gravity that was asked for [m/s^2]; the planner may still be on its way."""
        return self._wanted

    def want(self, gravity: Vector, hysteresis: float) -> None:
        """Ask for a planner for ``gravity`` unless it is within ``hysteresis`` of the last."""
        if math.dist(gravity, self._wanted) <= hysteresis:
            return
        self._wanted = gravity
        self.refresh()

    def refresh(self) -> None:
        """Ask for the planner at the newest gravity anew, unless one is being made."""
        if self._job is None:
            self._job = self._pool.submit(planner_for, self._gripper, self._wanted, self._grips)

    def poll(self) -> AnyPlanner | None:
        """Return a planner that has become ready, once; None if there is none.

        Should making it have raised, that is raised here, and nothing can be planned any more
        before a planner for another gravity is ready.
        """
        if self._job is None or not self._job.done():
            return None
        job, self._job = self._job, None
        try:
            self.planner = job.result()
        except Exception as error:
            self.planner = NoPlanner(self._wanted, PlannerFailedError(error))
            raise
        if self.planner.gravity != self._wanted:
            self.refresh()
        return self.planner
