# SPDX-License-Identifier: Apache-2.0
"""A gripper that the node has loaded: its planner and its present shapes."""

from __future__ import annotations

import math
from concurrent.futures import Executor, Future
from contextlib import suppress
from dataclasses import replace

from spiral_core.errors import NotGrippableError, SpiralError
from spiral_core.grip.curve import GripCurve, TubeShape
from spiral_core.rod.state import RodState
from spiral_core.rod.types import Vector
from spiral_core.wrap.gripper import Gripper
from spiral_core.wrap.placement import ObjectPlacement
from spiral_core.wrap.wrap import WrapRegime
from spiral_gripper import GripperDescription
from spiral_gripper.files.regions import StoredRegion
from spiral_gripper_ros.control.snapshot import Snapshot
from spiral_gripper_ros.planning.grip_follower import GripFollower, InUse
from spiral_gripper_ros.planning.object_pose import SeenObject
from spiral_gripper_ros.planning.planner import (
    GripperPlanner,
    planner_for,
)

# The measured shape is solved anew when the pressure has changed by more than this [Pa]: noise of
# a good sensor; it moves the tip of a 0.35 m gripper by 0.35 mm.
MEASURED_STEP = 50.0


class FollowedShape:
    """The shape at the newest pressure, within the tolerance ``step``.

    Args:
        step: changes of the pressure up to this [Pa] keep the shape, >= 0.

    Attributes:
        pressure: that it was solved for [Pa]; None: none is known.
        shape: at that pressure, if it is certified.
        regime: how that holds the object in use; None without one that can be gripped.
    """

    def __init__(self, step: float) -> None:
        self.shape: RodState | None = None
        self.regime: WrapRegime | None = None
        self._step = step
        self._planner: GripperPlanner | None = None
        self._radius: float | None = None
        self.pressure: float | None = None

    def update(self, planner: GripperPlanner, pressure: float | None, radius: float | None) -> bool:
        """Solve the shape at a pressure [Pa] if anything has changed; return whether it has.

        ``shape`` is then the new one, or None if it cannot be certified or no pressure is known.
        """
        is_close = pressure is self.pressure
        if pressure is not None and self.pressure is not None:
            is_close = abs(pressure - self.pressure) <= self._step
        if planner is self._planner and radius == self._radius and is_close:
            return False
        self._planner, self._radius, self.pressure = planner, radius, pressure
        self.shape = self.regime = None
        if pressure is not None:
            with suppress(SpiralError):
                self.shape, self.regime = planner.shape(pressure, radius)
        return self.shape is not None


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
        is_loading: whether the first planner is still being made.
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
        self.is_loading = True
        loading = SpiralError(f"{self.gripper.name} is being loaded")
        self.planner = self._without(loading)
        self.commanded, self.measured = FollowedShape(step=0.0), FollowedShape(step=MEASURED_STEP)
        self._pool = pool
        self._job: Future[GripperPlanner] | None = None

    # --- planner -------------------------------------------------------------------------------

    def load(self) -> None:
        """Make the planner now.

        Raises:
            SpiralError: the gripper cannot coil.
        """
        planner = planner_for(self.gripper, self.gravity, self.grips)
        if planner.error is not None:
            raise planner.error
        self.planner, self.is_loading = planner, False

    def want(self, gravity: Vector, hysteresis: float) -> None:
        """Ask for a planner for ``gravity`` unless it is within ``hysteresis`` of the last."""
        if math.dist(gravity, self.gravity) > hysteresis:
            self.gravity = gravity
            self.refresh()

    def refresh(self) -> None:
        """Ask for the planner at the newest gravity anew, unless one is being made."""
        if self._job is None:
            self._job = self._pool.submit(planner_for, self.gripper, self.gravity, self.grips)

    def poll(self) -> GripperPlanner | None:
        """Return a planner that has become ready, once; None if there is none.

        Should making it have raised, that is raised here, and nothing can be planned any more
        before a planner for another gravity is ready.
        """
        if self._job is None or not self._job.done():
            return None
        (job, self._job), self.is_loading = (self._job, None), False
        try:
            self.planner = job.result()
        except Exception as error:
            why = f"no planner could be made: {type(error).__name__}: {error}"
            self.planner = self._without(SpiralError(why))
            raise
        if self.planner.gravity != self.gravity:
            self.refresh()
        return self.planner

    def _without(self, error: SpiralError) -> GripperPlanner:
        """Return a planner that says why there is none."""
        mounted = self.gripper.with_mount(self.gravity, self.gripper.object_axis)
        return GripperPlanner(mounted, error)

    # --- grip ----------------------------------------------------------------------------------

    @property
    def _contact(self) -> GripCurve | NotGrippableError | None:
        """The contact at the object's place if that is known, or that it never wraps the object."""
        in_use = self.grips.in_use
        found = None if in_use is None else self.grips.found(in_use, self.gravity)
        if isinstance(found, NotGrippableError):
            return found
        is_placed = in_use is not None and in_use.seen is not None
        return found if is_placed and isinstance(found, GripCurve) else None

    @property
    def is_regime_from_contact(self) -> bool:
        """Whether regimes are those of the contact, because the object's place is known."""
        return self._contact is not None

    def regime(self, snapshot: Snapshot) -> WrapRegime | None:
        """Return how the object in use is held at the pressure of the gripper, as far as is known.

        By the contact at its place if that is known, else by the measured shape, else by the
        commanded one, whose tip may hang over within the window of the grip.
        """
        contact, plan, pressure = self._contact, snapshot.plan, snapshot.pressure
        if isinstance(contact, GripCurve):
            return contact.regime(pressure)
        free = self.commanded if self.measured.pressure is None else self.measured
        if free.regime is None:
            return None
        if contact is not None or (plan is not None and pressure >= plan.loss):
            return WrapRegime.OVERHANG  # contact never wraps it, or not any more
        hangs = free.regime is WrapRegime.OVERHANG
        is_wrapped = hangs and plan is not None and plan.is_wrapped(pressure)
        return WrapRegime.PERFECT_WRAP if is_wrapped else free.regime

    def shown_regime(self, snapshot: Snapshot) -> WrapRegime | None:
        """Return the regime as it is shown: by the tip alone, overpressure is no curling yet."""
        regime = self.regime(snapshot)
        pressed = snapshot.wrapped and regime is WrapRegime.CURLING and self._contact is None
        return WrapRegime.PERFECT_WRAP if pressed else regime

    # --- shapes --------------------------------------------------------------------------------

    def curve(self, radius: float | None, seen: SeenObject | None) -> GripCurve | None:
        """Return the grip on an object where that is solved; None without one, or not yet."""
        found = None if radius is None else self.grips.found(InUse(radius, seen), self.gravity)
        return found if isinstance(found, GripCurve) else None

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
        if pressure is not None:
            nearest = min(max(pressure, 0.0), self.gripper.pressure_max)
            pressure = nearest if abs(pressure - nearest) <= tolerance else pressure
        return self.measured.update(self.planner, pressure, radius)


def tube_at(
    curve: GripCurve | None, pressure: float | None, free: RodState | None
) -> RodState | TubeShape | None:
    """Return the tube at a pressure [Pa]: on the object where that is solved, else the free one."""
    held = None if curve is None or pressure is None else curve.shape(pressure)
    return free if held is None else held


def place_of(
    placement: ObjectPlacement | None, curve: GripCurve | None, seen: SeenObject | None
) -> ObjectPlacement | None:
    """Return where an object is: as it is seen, else where its grip has it, else as planned."""
    at = seen or (curve and curve.shapes)
    if placement is None or not at:
        return placement
    return replace(placement, center=at.center, axis=at.axis)


def gravity_or_own(gravity: tuple[float, ...], gripper: Gripper) -> Vector:
    """Return ``gravity`` [m/s^2], or the gripper's own if it is empty."""
    x, y, z = gravity or gripper.gravity
    return x, y, z
