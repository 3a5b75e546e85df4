# SPDX-License-Identifier: Apache-2.0
"""Plans, shapes and regimes of one gripper at one gravity. No ROS."""

from __future__ import annotations

import math
import time
from dataclasses import replace

from spiral_core.errors import NotGrippableError, SpiralError
from spiral_core.grip.curve import GripCurve
from spiral_core.message import Message, Quantity
from spiral_core.rod.state import RodState
from spiral_core.rod.types import Vector
from spiral_core.wrap.curve import WrapCurve
from spiral_core.wrap.gripper import Gripper
from spiral_core.wrap.wrap import WrapRegime
from spiral_gripper_ros.control.plan import WrapPlan
from spiral_gripper_ros.planning.grip_follower import GripFollower, InUse


class GripperPlanner:
    """The grippable range and the wraps within it, for one gripper and gravity.

    The constructor solves the whole range (tens of milliseconds); a plan then takes about a
    millisecond.

    Args:
        gripper: as it is mounted, with its gravity.
        error: why nothing can be planned; asked for a plan or a shape it raises that.

    Attributes:
        grips: what is known of grips by contact, or None: nothing.

    Raises:
        SpiralError: the gripper coils nowhere, or a shape could not be certified.
    """

    def __init__(self, gripper: Gripper, error: SpiralError | None = None) -> None:
        self.gripper, self.error = gripper, error
        self.grips: GripFollower | None = None
        if error is None:
            self._curve = self._fitted = WrapCurve(gripper)
            if gripper.object_axis is not None:
                self._fitted = WrapCurve(replace(gripper, object_axis=None))

    @property
    def curve(self) -> WrapCurve:
        """The wraps of all radii."""
        if self.error is not None:
            raise self.error.with_traceback(None)  # else that would grow each time
        return self._curve

    @property
    def gravity(self) -> Vector:
        """Gravity that the answers are for [m/s^2]."""
        return self.gripper.gravity

    @property
    def radius_range(self) -> tuple[float, float]:
        """Smallest and largest radius by the tip criterion [m]; all, if none can be planned for."""
        if self.error is not None:
            return 0.0, math.inf
        return self._curve.radius_min, self._curve.radius_max

    @property
    def held_range(self) -> tuple[float, float]:
        """Smallest and largest radius that the table of grips holds [m]; some between may not be.

        Without a table :attr:`radius_range`.
        """
        table = None if self.grips is None else self.grips.table(self.gravity)
        smallest, largest = self.radius_range
        if table is None or not table.held:
            return smallest, largest
        thin, thick = table.held[0], table.held[-1]
        # What lies beyond an end that is held has room there.
        return (
            smallest if thin == table.radii[0] else thin,
            largest if thick == table.radii[-1] else thick,
        )

    def plan(self, radius: float, *, by_tip: bool = False) -> WrapPlan:
        """Return the perfect wrap of a radius [m]; raise the core's error if there is none.

        Args:
            radius: of the object.
            by_tip: whether only the tip criterion refuses it, because contact is asked for next.

        Raises:
            NotGrippableError: the tip criterion has no pressure, or contact is known to find none.
        """
        start = time.perf_counter()
        try:
            wrap = laid = self.curve.wrap_for_radius(radius)
        except NotGrippableError as error:
            if error.nearest_radius is None:
                raise
            low, high = self.held_range
            held = min(max(error.nearest_radius, low), high)
            raise NotGrippableError(radius, error.constraint, error.margin, held) from None
        if self._fitted is not self._curve:
            laid = self._fitted.wrap_for_radius(radius)
        window: tuple[float, ...] | None = None
        if self.grips is not None:
            found = self.grips.found(InUse(radius), self.gravity)
            table = self.grips.table(self.gravity)
            if isinstance(found, NotGrippableError) and not by_tip:
                raise found.with_traceback(None)
            is_solved = by_tip or isinstance(found, GripCurve)
            if table is not None and not is_solved and table.is_not_held(radius):
                reason = "the table of grips has no pressure that wraps it"
                nearest = table.nearest_held(radius)
                if nearest is not None:
                    reason = Message("{}; it holds {}", reason, Quantity(nearest, "m"))
                raise NotGrippableError(radius, reason, 0.0, None)
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
        if self.grips is not None:
            grip = self.grips.answer(plan, None, pressure)
            if grip is not None:
                return grip.normal_force
        return max(plan.line_force(pressure), 0.0) * plan.wrap.contact_length

    def wrapped_diameter(self, pressure: float, opening: float) -> float:
        """Return the diameter of what a pressure [Pa] wraps [m], or an opening if it wraps none."""
        try:
            curve = self.curve
            if not pressure >= curve.pressure_min:
                return opening
            if pressure >= curve.pressure_max:
                return 2.0 * curve.radius_min
            return 2.0 * curve.radius_from_pressure(pressure)
        except SpiralError:  # no certified shape there: what it wraps is not known
            return opening

    def shape(self, pressure: float, radius: float | None) -> tuple[RodState, WrapRegime | None]:
        """Return the certified shape at a pressure [Pa], and how it holds a radius [m].

        That is None without an object that can be gripped.
        """
        state = self.curve.state_at_pressure(pressure)
        smallest, largest = self.radius_range
        if radius is None or not smallest <= radius <= largest:
            return state, None
        return state, self.curve.regime(pressure, radius, state)


def planner_for(
    gripper: Gripper, gravity: Vector, grips: GripFollower | None = None
) -> GripperPlanner:
    """Return the planner of a gripper at a gravity; if no plan is possible, one that raises why.

    Args:
        gripper: as described.
        gravity: [m/s^2].
        grips: what is known of grips by contact, if anything is.
    """
    mounted = gripper.with_mount(gravity, gripper.object_axis)
    try:
        planner = GripperPlanner(mounted)
        # Nothing is to be compiled or imported in a callback.
        planner.shape(0.0, None)
        radius = 0.5 * math.fsum(planner.radius_range)
        planner.shape(planner.plan(radius).pressure, radius)
    except SpiralError as error:
        return GripperPlanner(mounted, error)
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
