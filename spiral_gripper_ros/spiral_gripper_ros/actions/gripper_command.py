# SPDX-License-Identifier: Apache-2.0
"""Commands of a parallel gripper, translated for a spiral gripper. No ROS.

The opening of a parallel gripper is the diameter of the object to wrap; an opening above a limit
means release. Commands that a spiral gripper cannot execute are refused, never approximated.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from spiral_core.errors import SpiralError
from spiral_gripper_ros.control.grasp import GraspGoal
from spiral_gripper_ros.control.limits import AbortPolicy, Limits
from spiral_gripper_ros.control.release import ReleaseGoal
from spiral_gripper_ros.control.states import Reason, Refusal
from spiral_gripper_ros.control.target import default_overpressure
from spiral_gripper_ros.planning.planner import AnyPlanner, GripperPlanner, WrapPlan

# The overpressure that keeps a max_effort is found to this [Pa].
OVERPRESSURE_STEP = 1.0


@dataclass(frozen=True, slots=True)
class OpeningCommand:
    """A command to a parallel gripper; any float.

    Args:
        position: opening [m].
        max_effort: largest force allowed on the object [N]; 0: no limit.
    """

    position: float
    max_effort: float = 0.0


@dataclass(frozen=True, slots=True)
class GripperReading:
    """The state of a parallel gripper, as its messages report it.

    Args:
        position: diameter that the gripper wraps at its pressure, or its opening if it wraps
            none [m].
        effort: force on the object, summed over the contact, as predicted [N]; 0: it holds none.
    """

    position: float
    effort: float


def command_from_joint(
    position: Sequence[float], effort: Sequence[float]
) -> OpeningCommand | Refusal:
    """Return the command of a joint's state, or why it is none.

    Args:
        position: one opening [m].
        effort: the largest force [N], or nothing.

    Example:
        >>> command_from_joint([0.04], [])
        OpeningCommand(position=0.04, max_effort=0.0)
        >>> command_from_joint([0.02, 0.02], []).text
        'command must have one position and at most one effort, got 2 and 0'
    """
    if len(position) != 1 or len(effort) > 1:
        given = f"got {len(position)} and {len(effort)}"
        text = f"command must have one position and at most one effort, {given}"
        return Refusal(Reason.INVALID_REQUEST, text)
    return OpeningCommand(float(position[0]), float(effort[0]) if len(effort) else 0.0)


def goal_from_command(
    command: OpeningCommand, opening: float, planner: AnyPlanner, limits: Limits
) -> GraspGoal | ReleaseGoal | Refusal:
    """Return the goal that a command means for this gripper, or why it is refused.

    The pressure of a wrap follows from the diameter, and the force from the pressure. A
    ``max_effort`` below the force of the default grip lowers its overpressure; one below the force
    of the bare wrap can only be refused.

    Args:
        command: to a parallel gripper.
        opening: position from which on it means release [m].
        planner: answers for the gripper; it may refuse the diameter, which is told when the goal
            is started.
        limits: those of the default grip.
    """
    position, limit = command.position, command.max_effort
    if not math.isfinite(position):
        text = f"position must be a finite number, got {position}"
        return Refusal(Reason.RADIUS_NOT_FINITE, text)
    if not position > 0.0:
        text = f"position must be the object's diameter, > 0, got {position:.6g} m"
        return Refusal(Reason.RADIUS_NOT_POSITIVE, text)
    if not (math.isfinite(limit) and limit >= 0.0):
        text = f"max_effort must be a non-negative finite number, got {limit:.6g} N"
        return Refusal(Reason.INVALID_REQUEST, text)
    if position >= opening:
        return ReleaseGoal()
    overpressure = None
    if limit > 0.0:
        try:
            plan = planner.plan(0.5 * position)
        except SpiralError:
            return GraspGoal(0.5 * position)  # refused for that reason when it is started
        force = contact_force(plan, planner, plan.pressure)
        if force > limit:
            text = (
                f"wrapping {position:.4g} m presses on the object with {force:.3g} N in all, "
                f"more than max_effort = {limit:.6g} N"
            )
            return Refusal(Reason.INVALID_REQUEST, text)
        # A number: the default grip may press harder once its contact is known.
        overpressure = _overpressure_within(limit, plan, planner, limits)
    # As the controllers of ros2_control: a goal that is canceled or fails holds what it has.
    return GraspGoal(0.5 * position, overpressure=overpressure, abort_policy=AbortPolicy.HOLD)


def _overpressure_within(
    limit: float, plan: WrapPlan, planner: AnyPlanner, limits: Limits
) -> float:
    """Return the overpressure [Pa] whose force keeps a limit [N], at most that of the default."""
    low = 0.0
    high = default_overpressure(plan, limits)
    if contact_force(plan, planner, plan.pressure + high) <= limit:
        return high
    while high - low > OVERPRESSURE_STEP:
        middle = 0.5 * (low + high)
        keeps = contact_force(plan, planner, plan.pressure + middle) <= limit
        low, high = (middle, high) if keeps else (low, middle)
    return low


def contact_force(plan: WrapPlan, planner: AnyPlanner | None, pressure: float) -> float:
    """Return the normal force on the object of a plan, summed over the contact [N].

    By contact where that grip is known, else what the free coil says.

    Args:
        plan: how the object is wrapped.
        planner: answers for the gripper.
        pressure: gauge pressure [Pa].
    """
    if not isinstance(planner, GripperPlanner):
        return 0.0
    return planner.contact_force(plan, pressure)


def wrapped_diameter(pressure: float, opening: float, planner: AnyPlanner | None) -> float:
    """Return the diameter of what a pressure wraps [m].

    Args:
        pressure: gauge pressure [Pa].
        opening: what is returned below the pressures that wrap anything [m].
        planner: answers for the gripper.
    """
    if not isinstance(planner, GripperPlanner):
        return opening
    curve = planner.curve
    if not pressure >= curve.pressure_min:
        return opening
    if pressure >= curve.pressure_max:
        return 2.0 * curve.radius_min
    try:
        return 2.0 * curve.radius_from_pressure(pressure)
    except SpiralError:  # no certified shape there: what it wraps is not known
        return opening
