# SPDX-License-Identifier: Apache-2.0
"""A gripper that the node has loaded: its description, its planner, its present shapes."""

from __future__ import annotations

from concurrent.futures import Executor

from spiral_core.errors import SpiralError
from spiral_core.rod.types import Vector
from spiral_core.wrap.gripper import Gripper
from spiral_core.wrap.wrap import WrapRegime
from spiral_gripper import GripperDescription, load_description
from spiral_gripper_ros.planning.followed_shape import FollowedShape
from spiral_gripper_ros.planning.mount_follower import MountFollower
from spiral_gripper_ros.planning.planner import (
    AnyPlanner,
    GripperPlanner,
    GripShape,
    NoPlanner,
    StillLoadingError,
    WrapPlan,
)

# The measured shape is solved anew when the pressure has changed by more than this [Pa]: noise of
# a good sensor; it moves the tip of a 0.35 m gripper by 0.35 mm.
MEASURED_STEP = 50.0


class LoadedGripper:
    """What exists between "configured" and "cleaned up".

    Args:
        description: what the gripper is.
        planner: for the present gravity.
        pool: where planners for other gravities are made.
    """

    def __init__(
        self, description: GripperDescription, planner: AnyPlanner, pool: Executor
    ) -> None:
        self.description = description
        self.mount = MountFollower(planner, self.gripper, pool)
        self._commanded = FollowedShape(step=0.0)
        self._measured = FollowedShape(step=MEASURED_STEP)
        self._is_measured = False

    @classmethod
    def ready(cls, name_or_path: str, gravity: tuple[float, ...], pool: Executor) -> LoadedGripper:
        """Return a gripper that is warm, ready for callbacks.

        Args:
            name_or_path: the gripper's description.
            gravity: in the base frame [m/s^2]; empty: as described.
            pool: where planners for other gravities are made.

        Raises:
            SpiralError: the description cannot be used, or the gripper cannot coil.
        """
        description = load_description(name_or_path)
        gripper = description.gripper
        at = gravity_or_own(gravity, gripper)
        planner = GripperPlanner(gripper.with_mount(at, gripper.object_axis))
        planner.warm_up()
        return cls(description, planner, pool)

    @classmethod
    def loading(
        cls, description: GripperDescription, gravity: tuple[float, ...], pool: Executor
    ) -> LoadedGripper:
        """Return a gripper whose planner is still being made; until then every plan says so.

        ``mount.poll`` hands out the planner, or the stand-in that says why there is none.
        """
        gripper = description.gripper
        nothing_yet = NoPlanner(gravity_or_own(gravity, gripper), StillLoadingError(gripper.name))
        loaded = cls(description, nothing_yet, pool)
        loaded.mount.refresh()
        return loaded

    @property
    def gripper(self) -> Gripper:
        """The gripper as described."""
        return self.description.gripper

    @property
    def planner(self) -> AnyPlanner:
        """The planner for the present gravity."""
        return self.mount.planner

    @property
    def is_loading(self) -> bool:
        """Whether the first planner is still being made."""
        planner = self.planner
        return isinstance(planner, NoPlanner) and isinstance(planner.error, StillLoadingError)

    @property
    def shape(self) -> GripShape | None:
        """The shape at the commanded pressure, if it is certified."""
        return self._commanded.shape

    @property
    def measured_shape(self) -> GripShape | None:
        """The shape at the measured pressure, if that is known and the shape certified."""
        return self._measured.shape

    @property
    def regime(self) -> WrapRegime | None:
        """How the object in use is held, as far as is known: measured, else as commanded."""
        shape = self.measured_shape if self._is_measured else self.shape
        return None if shape is None else shape.regime

    def line_force(self, plan: WrapPlan | None, pressure: float) -> float | None:
        """Return the force per length on a plan's object at a pressure [N/m], if it is known."""
        if plan is None or not isinstance(self.planner, GripperPlanner):
            return None
        try:
            return self.planner.line_force(plan.wrap, pressure)
        except SpiralError:  # a pressure beyond the description
            return None

    def update_shape(self, pressure: float, radius: float | None) -> bool:
        """Solve the commanded shape at a pressure [Pa] if that is news; return whether it is."""
        return self._commanded.update(self.planner, pressure, radius)

    def update_measured_shape(
        self, pressure: float | None, radius: float | None, tolerance: float
    ) -> bool:
        """Solve the measured shape if its pressure has changed noticeably; return whether it has.

        Args:
            pressure: measured gauge pressure [Pa], or None if it is not known.
            radius: of the object in use [m], or None.
            tolerance: a pressure that is outside [0, the gripper's limit] by no more than this [Pa]
                counts as that bound: a vented sensor reads a little less than zero. Beyond it no
                shape can be certified.
        """
        self._is_measured = pressure is not None
        if pressure is not None:
            nearest = min(max(pressure, 0.0), self.gripper.pressure_max)
            pressure = nearest if abs(pressure - nearest) <= tolerance else pressure
        return self._measured.update(self.planner, pressure, radius)


def gravity_or_own(gravity: tuple[float, ...], gripper: Gripper) -> Vector:
    """Return ``gravity`` [m/s^2], or the gripper's own if it is empty."""
    if not gravity:
        return gripper.gravity
    x, y, z = gravity
    return (x, y, z)
