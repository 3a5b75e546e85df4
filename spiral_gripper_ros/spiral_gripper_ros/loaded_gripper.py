"""A gripper that the node has loaded: its description, its planner, its present shape."""

from __future__ import annotations

from concurrent.futures import Executor

from spiral_core.errors import SpiralError
from spiral_core.gripper import Gripper
from spiral_core.rod import Vector
from spiral_gripper import GripperDescription, load_description
from spiral_gripper_ros.mount_follower import MountFollower
from spiral_gripper_ros.planner import AnyPlanner, CommandedShape, GripperPlanner


class LoadedGripper:
    """What exists between "configured" and "cleaned up"; made warm, ready for callbacks.

    Args:
        name_or_path: the gripper's description.
        gravity: in the base frame [m/s^2]; empty: as described.
        pool: where planners for other gravities are made.

    Raises:
        SpiralError: the description cannot be used, or the gripper cannot coil.
    """

    def __init__(self, name_or_path: str, gravity: tuple[float, ...], pool: Executor) -> None:
        self.description: GripperDescription = load_description(name_or_path)
        planner = GripperPlanner(
            self.gripper.with_mount(self.gravity_or_own(gravity), self.gripper.object_axis)
        )
        planner.warm_up()
        self.mount = MountFollower(planner, self.gripper, pool)
        self.shape: CommandedShape | None = None
        self._shape_key: tuple[AnyPlanner, float, float | None] | None = None

    @property
    def gripper(self) -> Gripper:
        """The gripper as described."""
        return self.description.gripper

    @property
    def planner(self) -> AnyPlanner:
        """The planner for the present gravity."""
        return self.mount.planner

    def gravity_or_own(self, gravity: tuple[float, ...]) -> Vector:
        """Return ``gravity`` [m/s^2], or the description's if it is empty."""
        if not gravity:
            return self.gripper.gravity
        x, y, z = gravity
        return (x, y, z)

    def update_shape(self, pressure: float, radius: float | None) -> bool:
        """Solve the shape at a pressure [Pa] if anything has changed; return whether it has.

        ``shape`` is then the new one, or None if it cannot be certified.
        """
        key = (self.planner, pressure, radius)
        if key == self._shape_key:
            return False
        self._shape_key = key
        try:
            self.shape = self.planner.shape(pressure, radius)
        except SpiralError:
            self.shape = None
        return self.shape is not None
