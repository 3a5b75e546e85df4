# SPDX-License-Identifier: Apache-2.0
"""Commands of a parallel gripper, translated for a spiral gripper. No ROS.

The opening of a parallel gripper is the diameter of the object to wrap; an opening above a limit
means release. Commands that a spiral gripper cannot execute are refused, never approximated.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from spiral_core.errors import SpiralError
from spiral_core.numerics.roots import last_positive
from spiral_gripper_ros.control.grasp import GraspGoal
from spiral_gripper_ros.control.limits import AbortPolicy, Limits
from spiral_gripper_ros.control.release import ReleaseGoal
from spiral_gripper_ros.control.states import Reason, Refusal
from spiral_gripper_ros.control.target import default_overpressure
from spiral_gripper_ros.planning.planner import GripperPlanner


def goal_from_command(
    positions: Sequence[float],
    efforts: Sequence[float],
    opening: float,
    planner: GripperPlanner,
    limits: Limits,
) -> GraspGoal | ReleaseGoal | Refusal:
    """Return the goal that a command means for this gripper, or why it is refused.

    The pressure of a wrap follows from the diameter, and the force from the pressure. A
    ``max_effort`` below the force of the default grip lowers its overpressure; one below the force
    of the bare wrap can only be refused.

    Args:
        positions: the opening [m], any float; more than one joint is refused.
        efforts: the largest force allowed on the object [N], any float; nothing, or 0: no limit.
        opening: position from which on it means release [m].
        planner: answers for the gripper; it may refuse the diameter, which is told when the goal
            is started.
        limits: those of the default grip.

    Example:
        >>> goal_from_command([0.02, 0.02], [], 0.1, None, None).text
        'command must have one position and at most one effort, got 2 and 0'
    """
    if len(positions) != 1 or len(efforts) > 1:
        given = f"got {len(positions)} and {len(efforts)}"
        text = f"command must have one position and at most one effort, {given}"
        return Refusal(Reason.INVALID_REQUEST, text)
    position, limit = (float(value) for value in (*positions, *efforts, 0.0)[:2])
    if not math.isfinite(position):
        text = f"position must be a finite number, got {position}"
        return Refusal(Reason.RADIUS_NOT_FINITE, text)
    if not position > 0.0:
        text = f"position must be the object's diameter, > 0, got {position:.6g} m"
        return Refusal(Reason.RADIUS_NOT_POSITIVE, text)
    if not 0.0 <= limit < math.inf:
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
        force = planner.contact_force(plan, plan.pressure)
        if force > limit:
            text = (
                f"wrapping {position:.4g} m presses on the object with {force:.3g} N in all, "
                f"more than max_effort = {limit:.6g} N"
            )
            return Refusal(Reason.INVALID_REQUEST, text)

        def spare(above: float) -> float:
            return limit - planner.contact_force(plan, plan.pressure + above)

        # A number: the default grip may press harder once its contact is known.
        overpressure = default_overpressure(plan, limits)
        if spare(overpressure) < 0.0:
            overpressure = last_positive(spare, 0.0, overpressure)
    # As the controllers of ros2_control: a goal that is canceled or fails holds what it has.
    return GraspGoal(0.5 * position, overpressure=overpressure, abort_policy=AbortPolicy.HOLD)
