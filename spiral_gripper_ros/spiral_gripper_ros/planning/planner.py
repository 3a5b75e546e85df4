# SPDX-License-Identifier: Apache-2.0
"""Plans, shapes and regimes of one gripper at one gravity. No ROS."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace
from typing import NoReturn

from spiral_core.errors import NotGrippableError, SpiralError
from spiral_core.grip.curve import GripCurve
from spiral_core.grip.table import GripTable
from spiral_core.message import Message, Quantity
from spiral_core.rod.state import RodState
from spiral_core.rod.types import Vector
from spiral_core.wrap.curve import WrapCurve
from spiral_core.wrap.gripper import Gripper
from spiral_core.wrap.wrap import WrapRegime
from spiral_gripper_ros.control.plan import WrapPlan
from spiral_gripper_ros.planning.grip_follower import GripFollower, InUse


class StillLoadingError(SpiralError):
    """The gripper's range is being solved."""


class PlannerFailedError(SpiralError):
    """A planner could not be made because of an error in the program."""


@dataclass(frozen=True, slots=True)
class GripShape:
    """The shape of the gripper at a pressure.

    Args:
        state: the certified shape.
        regime: how it holds the object in use; None without an object that can be gripped.
    """

    state: RodState
    regime: WrapRegime | None


class GripperPlanner:
    """The grippable range and the wraps within it, for one gripper and gravity.

    The constructor solves the whole range (tens of milliseconds); a plan then takes about a
    millisecond.

    Args:
        gripper: as it is mounted, with its gravity.

    Attributes:
        grips: what is known of grips by contact, or None: nothing.

    Raises:
        SpiralError: the gripper coils nowhere, or a shape could not be certified.
    """

    def __init__(self, gripper: Gripper) -> None:
        self.gripper = gripper
        self.curve = self._fitted = WrapCurve(gripper)
        if gripper.object_axis is not None:
            self._fitted = WrapCurve(replace(gripper, object_axis=None))
        self.grips: GripFollower | None = None

    @property
    def gravity(self) -> Vector:
        """Gravity that the answers are for [m/s^2]."""
        return self.gripper.gravity

    @property
    def radius_range(self) -> tuple[float, float]:
        """Smallest and largest radius that can be gripped [m]."""
        return self.curve.radius_min, self.curve.radius_max

    def plan(self, radius: float, *, by_tip: bool = False) -> WrapPlan:
        """Return the perfect wrap of a radius [m]; raise the core's error if there is none.

        Args:
            radius: of the object.
            by_tip: whether only the tip criterion refuses it, because contact is asked for next.

        Raises:
            NotGrippableError: the tip criterion has no pressure, or contact is known to find none.
        """
        start = time.perf_counter()
        wrap = laid = self.curve.wrap_for_radius(radius)
        if self._fitted is not self.curve:
            laid = self._fitted.wrap_for_radius(radius)
        window: tuple[float, ...] | None = None
        if self.grips is not None:
            found = self.grips.found(InUse(radius), self.gravity)
            table = self.grips.table(self.gravity)
            if isinstance(found, NotGrippableError) and not by_tip:
                raise found
            is_solved = by_tip or isinstance(found, GripCurve)
            if table is not None and not is_solved and table.is_not_held(radius):
                raise _not_held(radius, table)
            window = None if table is None else table.window(radius, laid.pressure)
            if window is None and isinstance(found, GripCurve):
                scale = laid.pressure / found.tip_pressure  # of a radius that differs a little
                window = tuple(scale * end for end in found.window)
        solve_time = time.perf_counter() - start
        return WrapPlan(wrap, laid, self.gripper, solve_time, *(window or ()))

    def contact_force(self, plan: WrapPlan, pressure: float) -> float:
        """Return the normal force on the object of ``plan`` at a pressure [Pa], in all [N].

        By contact where that grip is known, else what the free coil says.
        """
        wrap = plan.wrap
        if self.grips is not None:
            in_use = InUse(wrap.object_radius)
            grip = self.grips.answer(in_use, self.gravity, plan.laid.pressure, pressure)
            if grip is not None:
                return grip.normal_force
        return max(plan.line_force(pressure), 0.0) * wrap.contact_length

    def wrapped_diameter(self, pressure: float, opening: float) -> float:
        """Return the diameter of what a pressure [Pa] wraps [m], or an opening if it wraps none."""
        curve = self.curve
        if not pressure >= curve.pressure_min:
            return opening
        if pressure >= curve.pressure_max:
            return 2.0 * curve.radius_min
        try:
            return 2.0 * curve.radius_from_pressure(pressure)
        except SpiralError:  # no certified shape there: what it wraps is not known
            return opening

    def shape(self, pressure: float, radius: float | None) -> GripShape:
        """Return the shape at any pressure [Pa] and how it holds an object of ``radius`` [m]."""
        state = self.curve.state_at_pressure(pressure)
        smallest, largest = self.radius_range
        if radius is None or not smallest <= radius <= largest:
            return GripShape(state, None)
        return GripShape(state, self.curve.regime(pressure, radius, state))


def _not_held(radius: float, table: GripTable) -> NotGrippableError:
    """Return that a table of grips does not hold a radius [m]."""
    reason = "the table of grips has no pressure that wraps it"
    nearest = table.nearest_held(radius)
    if nearest is not None:
        reason = Message("{}; it holds {}", reason, Quantity(nearest, "m"))
    return NotGrippableError(radius, reason, 0.0, None)


class NoPlanner:
    """The planner of a gravity at which no plan is possible: asked for one it raises the reason.

    Args:
        gravity: that gravity [m/s^2].
        error: why.
    """

    def __init__(self, gravity: Vector, error: SpiralError) -> None:
        self.gravity = gravity
        self.error = error

    @property
    def radius_range(self) -> tuple[float, float]:
        """All radii, so that :meth:`plan` raises the reason."""
        return 0.0, float("inf")

    def plan(self, radius: float) -> NoReturn:
        """Raise why nothing can be planned."""
        raise self.error

    def shape(self, pressure: float, radius: float | None) -> NoReturn:
        """Raise why nothing can be solved."""
        raise self.error

    def contact_force(self, plan: WrapPlan, pressure: float) -> float:
        """Return that no force is known [N]."""
        del plan, pressure
        return 0.0

    def wrapped_diameter(self, pressure: float, opening: float) -> float:
        """Return the opening [m]."""
        del pressure
        return opening


AnyPlanner = GripperPlanner | NoPlanner


def planner_for(gripper: Gripper, gravity: Vector, grips: GripFollower | None = None) -> AnyPlanner:
    """Return the planner of a gripper at a gravity; if none is possible, a NoPlanner.

    Args:
        gripper: as described.
        gravity: [m/s^2].
        grips: what is known of grips by contact, if anything is.
    """
    try:
        planner = GripperPlanner(gripper.with_mount(gravity, gripper.object_axis))
        # Nothing is to be compiled or imported in a callback.
        planner.shape(0.0, None)
        radius = 0.5 * math.fsum(planner.radius_range)
        planner.shape(planner.plan(radius).pressure, radius)
    except SpiralError as error:
        return NoPlanner(gravity, error)
    planner.grips = grips
    return planner


def compile_all() -> None:
    """Compile the numerical kernels, if they are not cached yet.

    The first compilation of an installation takes some 15 s or more. Inside the node it would block
    services and signals for that time.
    """
    from spiral_gripper import load_gripper
    from spiral_gripper.files.catalog import available_grippers
    from spiral_gripper.kernels import compile_kernels

    compile_kernels()
    gripper = load_gripper(available_grippers()[0])
    planner_for(gripper, gripper.gravity)
