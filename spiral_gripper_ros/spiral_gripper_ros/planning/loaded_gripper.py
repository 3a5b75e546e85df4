# SPDX-License-Identifier: Apache-2.0
"""A gripper that the node has loaded: its description, its planner, its present shapes."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor

from spiral_core.errors import SpiralError
from spiral_core.rod.types import Vector
from spiral_core.wrap.gripper import Gripper
from spiral_core.wrap.placement import ObjectPlacement
from spiral_core.wrap.wrap import WrapRegime
from spiral_gripper import GripperDescription, load_description
from spiral_gripper_ros.planning.grip_figures import GripFigures
from spiral_gripper_ros.planning.grip_follower import GripFollower, InUse
from spiral_gripper_ros.planning.grip_table import GripAnswer
from spiral_gripper_ros.planning.mount_follower import MountFollower
from spiral_gripper_ros.planning.object_pose import SeenObject
from spiral_gripper_ros.planning.planner import (
    AnyPlanner,
    GripperPlanner,
    GripShape,
    NoPlanner,
    StillLoadingError,
    WrapPlan,
    planner_for,
)

# The measured shape is solved anew when the pressure has changed by more than this [Pa]: noise of
# a good sensor; it moves the tip of a 0.35 m gripper by 0.35 mm.
MEASURED_STEP = 50.0


class FollowedShape:
    """The shape at the newest pressure, within the tolerance ``step``.

    Args:
        step: changes of the pressure up to this [Pa] keep the shape, >= 0.
    """

    def __init__(self, step: float) -> None:
        self.shape: GripShape | None = None
        self._step = step
        self._planner: AnyPlanner | None = None
        self._radius: float | None = None
        self._pressure: float | None = None

    def update(self, planner: AnyPlanner, pressure: float | None, radius: float | None) -> bool:
        """Solve the shape at a pressure [Pa] if anything has changed; return whether it has.

        ``shape`` is then the new one, or None if it cannot be certified or no pressure is known.
        """
        if planner is self._planner and radius == self._radius and self._is_close(pressure):
            return False
        self._planner, self._radius, self._pressure = planner, radius, pressure
        try:
            self.shape = None if pressure is None else planner.shape(pressure, radius)
        except SpiralError:
            self.shape = None
        return self.shape is not None

    def _is_close(self, pressure: float | None) -> bool:
        if pressure is None or self._pressure is None:
            return pressure is self._pressure
        return abs(pressure - self._pressure) <= self._step


class LoadedGripper:
    """The gripper of a configured node: description, planner and present shapes.

    Args:
        description: of the gripper.
        planner: for the present gravity.
        pool: where planners for other gravities are made.
        grips: what is known of grips by contact.
    """

    def __init__(
        self,
        description: GripperDescription,
        planner: AnyPlanner,
        pool: Executor,
        grips: GripFollower,
    ) -> None:
        self.description = description
        self.grips = grips
        self.mount = MountFollower(planner, self.gripper, pool, grips)
        self._commanded = FollowedShape(step=0.0)
        self._measured = FollowedShape(step=MEASURED_STEP)
        self._is_measured = False
        self._contact: GripFigures | None = None
        self._is_never_wrapped = False
        self._placed: tuple[WrapPlan, ObjectPlacement] | None = None

    @classmethod
    def ready(
        cls,
        name_or_path: str,
        gravity: tuple[float, ...],
        pool: Executor,
        follow: Callable[[Gripper, Vector], GripFollower],
    ) -> LoadedGripper:
        """Return a gripper whose planner is ready for callbacks.

        Args:
            name_or_path: the gripper's description.
            gravity: in the base frame [m/s^2]; empty: as described.
            pool: where planners for other gravities are made.
            follow: makes what follows the grips of a gripper from a gravity [m/s^2] on.

        Raises:
            SpiralError: the description cannot be used, or the gripper cannot coil.
        """
        description = load_description(name_or_path)
        gripper = description.gripper
        at = gravity_or_own(gravity, gripper)
        grips = follow(gripper, at)
        planner = planner_for(gripper, at, grips)
        if isinstance(planner, NoPlanner):
            raise planner.error
        return cls(description, planner, pool, grips)

    @classmethod
    def loading(
        cls,
        description: GripperDescription,
        gravity: tuple[float, ...],
        pool: Executor,
        follow: Callable[[Gripper, Vector], GripFollower],
    ) -> LoadedGripper:
        """Return a gripper whose planner is still being made; until then every plan is refused.

        ``mount.poll`` hands out the planner, or the stand-in that says why there is none.
        """
        gripper = description.gripper
        at = gravity_or_own(gravity, gripper)
        nothing_yet = NoPlanner(at, StillLoadingError(gripper.name))
        loaded = cls(description, nothing_yet, pool, follow(gripper, at))
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
    def is_regime_from_contact(self) -> bool:
        """Whether regimes are those of the contact, because the object's place is known."""
        return self._contact is not None or self._is_never_wrapped

    def regime(self, pressure: float | None = None) -> WrapRegime | None:
        """Return how the object in use is held, as far as is known: measured, else as commanded.

        Args:
            pressure: at which it is held [Pa], for the regime of the contact.
        """
        return self.regime_of(self.measured_shape if self._is_measured else self.shape, pressure)

    def regime_of(self, shape: GripShape | None, pressure: float | None) -> WrapRegime | None:
        """Return the regime of a shape: of the contact at its pressure [Pa], else of its tip."""
        if self._is_never_wrapped and shape is not None:
            return WrapRegime.OVERHANG
        if self._contact is not None and pressure is not None:
            return self._contact.regime(pressure)
        return None if shape is None else shape.regime

    def follow_grips(
        self, now: float, count: int, radius: float | None, seen: SeenObject | None
    ) -> bool:
        """Take the grips that are solved, start the next one; return whether one was taken.

        Args:
            now: time [s].
            count: radii of the table of grips; 0: none is solved.
            radius: of the object in use [m], or None.
            seen: where it is, or None.
        """
        self._contact, self._is_never_wrapped = None, False
        in_use = None if radius is None else InUse(radius, seen)
        radii = self.planner.radius_range
        taken = self.grips.follow(now, self.mount.gravity, radii, count, in_use)
        if in_use is not None:
            self._is_never_wrapped = self.grips.refusal(in_use) is not None
            entry = self.grips.entry(in_use)
            self._contact = entry.figures if entry is not None and seen is not None else None
        return taken

    def grip(
        self, plan: WrapPlan | None, radius: float | None, seen: SeenObject | None, pressure: float
    ) -> GripAnswer | None:
        """Return the grip on an object at a pressure [Pa], from contact; None: it is not known."""
        if plan is None or radius is None:
            return None
        return self.grips.answer(InUse(radius, seen), plan.laid.pressure, pressure)

    def line_force(self, plan: WrapPlan | None, pressure: float) -> float | None:
        """Return the force per length on a plan's object at a pressure [N/m], if it is known."""
        if plan is None or not isinstance(self.planner, GripperPlanner):
            return None
        try:
            return self.planner.line_force(plan.wrap, pressure)
        except SpiralError:  # a pressure beyond the description
            return None

    def placement(self, plan: WrapPlan | None) -> ObjectPlacement | None:
        """Return where a plan's object lies in the free coil; None without a plan."""
        if plan is None:
            return None
        if self._placed is None or self._placed[0] is not plan:
            self._placed = (plan, plan.placement)
        return self._placed[1]

    def table_grip(self, radius: float, tip_pressure: float, pressure: float) -> GripAnswer | None:
        """Return the grip on a radius [m] at a pressure [Pa] that the table says, if it does.

        Args:
            radius: of the object [m].
            tip_pressure: of its wrap by the tip criterion [Pa].
            pressure: gauge [Pa].
        """
        return self.grips.answer(InUse(radius), tip_pressure, pressure)

    def update_shape(self, pressure: float, radius: float | None) -> bool:
        """Solve the commanded shape at a pressure [Pa] if it has changed; return whether it has."""
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
