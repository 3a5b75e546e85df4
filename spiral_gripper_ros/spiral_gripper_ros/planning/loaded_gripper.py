# SPDX-License-Identifier: Apache-2.0
"""A gripper that the node has loaded: its planner and its present shapes."""

from __future__ import annotations

import math
from concurrent.futures import Executor, Future

from spiral_core.errors import NotGrippableError, SpiralError
from spiral_core.grip.curve import GripAnswer, GripCurve
from spiral_core.rod.types import Vector
from spiral_core.wrap.gripper import Gripper
from spiral_core.wrap.placement import ObjectPlacement
from spiral_core.wrap.wrap import WrapRegime
from spiral_gripper import GripperDescription
from spiral_gripper.files.regions import StoredRegion
from spiral_gripper_ros.control.plan import WrapPlan
from spiral_gripper_ros.control.snapshot import Snapshot
from spiral_gripper_ros.planning.grip_follower import GripFollower, InUse
from spiral_gripper_ros.planning.object_pose import SeenObject
from spiral_gripper_ros.planning.planner import (
    AnyPlanner,
    GripShape,
    NoPlanner,
    PlannerFailedError,
    StillLoadingError,
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
    """A gripper that the node has loaded: its planner for the newest gravity, its present shapes.

    At first every plan is refused: either :meth:`load` or :meth:`refresh` makes the planner. When
    gravity changes another one is made in the background, one at a time; the old one stands until
    :meth:`poll` hands out the new one, some tens of milliseconds later.

    Args:
        description: of the gripper.
        gravity: in the base frame [m/s^2].
        pool: where planners are made.
        grips: what is known of grips by contact.
        regions: of capture that are known.

    Attributes:
        planner: the present one.
        gravity: the newest that was asked for [m/s^2].
        commanded, measured: the shapes at the commanded and at the measured pressure.
    """

    def __init__(
        self,
        description: GripperDescription,
        gravity: Vector,
        pool: Executor,
        grips: GripFollower,
        regions: tuple[StoredRegion, ...] = (),
    ) -> None:
        self.description, self.gripper = description, description.gripper
        self.gravity, self.grips, self.regions = gravity, grips, regions
        still_loading = StillLoadingError(f"{self.gripper.name} is being loaded")
        self.planner: AnyPlanner = NoPlanner(gravity, still_loading)
        self.commanded, self.measured = FollowedShape(step=0.0), FollowedShape(step=MEASURED_STEP)
        self._pool = pool
        self._job: Future[AnyPlanner] | None = None
        self._is_measured = False
        self._contact: GripCurve | NotGrippableError | None = None
        self._placed: tuple[WrapPlan, ObjectPlacement] | None = None

    # --- planner -------------------------------------------------------------------------------

    def load(self) -> None:
        """Make the planner now.

        Raises:
            SpiralError: the gripper cannot coil.
        """
        planner = planner_for(self.gripper, self.gravity, self.grips)
        if isinstance(planner, NoPlanner):
            raise planner.error
        self.planner = planner

    def want(self, gravity: Vector, hysteresis: float) -> None:
        """Ask for a planner for ``gravity`` unless it is within ``hysteresis`` of the last."""
        if math.dist(gravity, self.gravity) > hysteresis:
            self.gravity = gravity
            self.refresh()

    def refresh(self) -> None:
        """Ask for the planner at the newest gravity anew, unless one is being made."""
        if self._job is None:
            self._job = self._pool.submit(planner_for, self.gripper, self.gravity, self.grips)

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
            why = f"no planner could be made: {type(error).__name__}: {error}"
            self.planner = NoPlanner(self.gravity, PlannerFailedError(why))
            raise
        if self.planner.gravity != self.gravity:
            self.refresh()
        return self.planner

    @property
    def is_loading(self) -> bool:
        """Whether the first planner is still being made."""
        planner = self.planner
        return isinstance(planner, NoPlanner) and isinstance(planner.error, StillLoadingError)

    # --- grip ----------------------------------------------------------------------------------

    @property
    def is_regime_from_contact(self) -> bool:
        """Whether regimes are those of the contact, because the object's place is known."""
        return self._contact is not None

    def regime(self, pressure: float) -> WrapRegime | None:
        """Return how the object in use is held at a pressure [Pa], as far as is known.

        By the contact if that is known, else by the measured shape, else by the commanded one.
        """
        if isinstance(self._contact, GripCurve):
            return self._contact.regime(pressure)
        shape = (self.measured if self._is_measured else self.commanded).shape
        if shape is None or self._contact is None:
            return None if shape is None else shape.regime
        return WrapRegime.OVERHANG  # contact never wraps it

    def shown_regime(self, snapshot: Snapshot) -> WrapRegime | None:
        """Return the regime as it is shown: by the tip alone, overpressure is no curling yet."""
        regime = self.regime(snapshot.pressure)
        pressed = snapshot.wrapped and regime is WrapRegime.CURLING and self._contact is None
        return WrapRegime.PERFECT_WRAP if pressed else regime

    def follow_grips(
        self, now: float, rate: float, radius: float | None, seen: SeenObject | None, *, is_on: bool
    ) -> bool:
        """Take the grip that is solved, start the next one; return whether one was taken.

        Args:
            now: time [s].
            rate: of the ramps [Pa/s].
            radius: of the object in use [m], or None.
            seen: where it is, or None.
            is_on: whether any grip is known and solved.
        """
        in_use = None if radius is None else InUse(radius, seen)
        taken = self.grips.follow(now, self.gravity, rate, in_use, is_on=is_on)
        found = None if in_use is None else self.grips.found(in_use, self.gravity)
        is_placed = isinstance(found, GripCurve) and seen is not None
        is_refused = isinstance(found, NotGrippableError)
        self._contact = found if is_placed or is_refused else None  # type: ignore[assignment]
        return taken

    def grip(
        self, plan: WrapPlan | None, radius: float | None, seen: SeenObject | None, pressure: float
    ) -> GripAnswer | None:
        """Return the grip on an object at a pressure [Pa], from contact; None: it is not known."""
        if plan is None or radius is None:
            return None
        in_use, gravity = InUse(radius, seen), plan.gripper.gravity
        return self.grips.answer(in_use, gravity, plan.laid.pressure, pressure)

    def placement(self, plan: WrapPlan | None) -> ObjectPlacement | None:
        """Return where a plan's object lies in the free coil; None without a plan."""
        if plan is None:
            return None
        if self._placed is None or self._placed[0] is not plan:
            self._placed = (plan, plan.placement)
        return self._placed[1]

    # --- shapes --------------------------------------------------------------------------------

    def update_shape(self, pressure: float, radius: float | None) -> bool:
        """Solve the commanded shape at a pressure [Pa] if it has changed; return whether it has."""
        return self.commanded.update(self.planner, pressure, radius)

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
        return self.measured.update(self.planner, pressure, radius)


def gravity_or_own(gravity: tuple[float, ...], gripper: Gripper) -> Vector:
    """Return ``gravity`` [m/s^2], or the gripper's own if it is empty."""
    if not gravity:
        return gripper.gravity
    x, y, z = gravity
    return (x, y, z)
