# SPDX-License-Identifier: Apache-2.0
"""The node's parameters: one table, from which they are declared, checked and documented."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Final

from spiral_gripper_ros.control.limits import HIGHEST_GRIP_RATIO, Limits
from spiral_gripper_ros.parameters.spec import (
    GRAVITY_LIMIT,
    LARGEST_PAYLOAD,
    Parameters,
    choice,
    parameter,
)

_LIMITS = Limits(pressure_cap=1.0)


@dataclass(frozen=True, slots=True)
class GripperParameters(Parameters):
    """Parameters of the node; those of :class:`Limits` have its defaults."""

    gripper: str = parameter(
        "paper_design_70",
        "Gripper description: the name of a shipped one, or the path of a file; a change "
        "vents, and the new gripper is used after rearm.",
    )
    frame_id: str = parameter(
        "gripper_base",
        "Frame of every stamped message: the clamped end, x along the tube.",
        read_only=True,
    )
    autostart: bool = parameter(
        True,
        "Configure and activate at start; false leaves that to a lifecycle manager.",
        read_only=True,
    )
    gravity: tuple[float, ...] = parameter(
        (),
        "Gravity in the base frame [m/s^2], 3 numbers, until a message comes on the topic "
        "gravity; [.nan, .nan, .nan]: as in the gripper description.",
    )
    gravity_hysteresis: float = parameter(
        0.1,
        "Plans and shapes are solved again when gravity has changed by more than this [m/s^2].",
        0.0,
        GRAVITY_LIMIT,
    )
    pressure_cap: float = parameter(
        math.nan,
        "Largest gauge pressure ever commanded [Pa]; .nan: the gripper description's limit, "
        "which also bounds any other value. A raised cap acts from the next radius or goal on.",
        0.0,
        1.0e6,
    )
    pressure_rate_up: float = parameter(
        _LIMITS.pressure_rate_up, "Fastest rise of the command [Pa/s].", 1.0e2, 1.0e7
    )
    pressure_rate_down: float = parameter(
        _LIMITS.pressure_rate_down,
        "Fastest fall of the command [Pa/s]; a vent ignores it.",
        1.0e2,
        1.0e7,
    )
    radius_timeout: float = parameter(
        _LIMITS.radius_timeout,
        "Age of the last usable radius at which the policy acts [s].",
        0.01,
        3600.0,
    )
    radius_age_limit: float = parameter(
        0.5,
        "An object_radius_stamped whose stamp is farther from now than this [s] is refused.",
        0.001,
        3600.0,
    )
    object_pose_timeout: float = parameter(
        1.0,
        "An object_pose whose stamp is farther from now than this [s] is not used.",
        0.01,
        3600.0,
    )
    radius_timeout_policy: str = choice(
        _LIMITS.radius_timeout_policy,
        "Action after radius_timeout: hold the pressure, vent at once, or ramp_down.",
    )
    radius_rate_limit: float = parameter(
        _LIMITS.radius_rate_limit, "Fastest believable change of the radius [m/s].", 1.0e-4, 10.0
    )
    radius_jump_limit: float = parameter(
        _LIMITS.radius_jump_limit,
        "A radius farther than this [m] from what radius_rate_limit allows is refused.",
        1.0e-5,
        1.0,
    )
    radius_hysteresis: float = parameter(
        _LIMITS.radius_hysteresis,
        "The command changes when the radius has moved by more than this [m].",
        0.0,
        0.1,
    )
    grasp_timeout: float = parameter(
        _LIMITS.grasp_timeout,
        "Longest time until a grasp reaches its wrap [s], unless the goal has a timeout.",
        0.1,
        600.0,
    )
    grasp_abort_policy: str = choice(
        _LIMITS.grasp_abort_policy,
        "Action when a grasp goal fails or is canceled: vent, or hold the pressure.",
    )
    measured_pressure_timeout: float = parameter(
        _LIMITS.measured_pressure_timeout,
        "Age of the last usable measured_pressure at which it counts as lost [s].",
        0.01,
        3600.0,
    )
    pressure_settle_time: float = parameter(
        _LIMITS.pressure_settle_time,
        "The measured pressure may lag behind the command by this [s].",
        0.0,
        60.0,
    )
    pressure_tolerance: float = parameter(
        _LIMITS.pressure_tolerance,
        "Largest difference of measured and commanded pressure that is no fault [Pa].",
        10.0,
        1.0e6,
    )
    pressure_fault_policy: str = choice(
        _LIMITS.pressure_fault_policy,
        "Action at a pressure fault: report it, or vent until rearm; a running grasp fails.",
    )
    grip_ratio: float = parameter(
        math.nan,
        "Pressure of a grip, as a multiple of the pressure of the perfect wrap, whose contact "
        "force is almost zero; .nan: what the grip with contact recommends, and 1.1 until it is "
        "known. Limited by pressure_cap.",
        1.0,
        HIGHEST_GRIP_RATIO,
    )
    keep_alive_timeout: float = parameter(
        0.0,
        "A grip is vented when no keep_alive has come for this time [s]; 0: none is expected.",
        0.0,
        3600.0,
    )
    gravity_timeout: float = parameter(
        0.0, "Age at which a received gravity is stale [s]; 0: never.", 0.0, 3600.0
    )
    gravity_timeout_policy: str = choice(
        _LIMITS.gravity_timeout_policy, "Action at stale gravity: report it, or vent until rearm."
    )
    activation: str = parameter(
        "vent",
        "Start from 0 Pa (vent), or keep the first measured_pressure until a radius or a goal "
        "comes (take_over).",
        choices=("vent", "take_over"),
    )
    exit_with_parent: bool = parameter(
        False,
        "Vent and end when the process that started this one ends: ros2 run, ros2 launch.",
        read_only=True,
    )
    gripper_command_open: float = parameter(
        0.1, "Position of a gripper action [m] at or above which it means release.", 0.001, 10.0
    )
    gripper_cmd_type: str = parameter(
        "GripperCommand",
        "Type of the action gripper_cmd, of control_msgs; parallel_gripper_cmd is offered "
        "beside the first.",
        choices=("GripperCommand", "ParallelGripperCommand"),
        read_only=True,
    )
    publish_rate: float = parameter(
        50.0, "Rate of pressure_command and status while active, and of the ramp [Hz].", 1.0, 500.0
    )
    payload: float = parameter(
        math.nan,
        "Mass of the object [kg] unless a goal says; .nan: not known.",
        0.0,
        LARGEST_PAYLOAD,
    )
    grip_radii: int = parameter(6, "Radii of the table of grips; 0: no grip is computed.", 0, 50)
    marker_rate: float = parameter(5.0, "Rate of markers while active [Hz]; 0: none.", 0.0, 50.0)
    robot_state_rate: float = parameter(
        0.0,
        "Rate of joint_states, wrapped_object_pose and /tf while active [Hz]; 0: none.",
        0.0,
        50.0,
    )
    backbone_points: int = parameter(
        50, "Largest number of poses in backbone, base and tip included.", 2, 1000
    )

    def limits(self, pressure_max: float) -> Limits:
        """Return the control logic's limits.

        Args:
            pressure_max: the gripper's own limit [Pa]; no parameter can raise the cap above it.
        """
        given = {
            field.name: type(getattr(_LIMITS, field.name))(getattr(self, field.name))
            for field in fields(Limits)
        }
        cap = self.pressure_cap
        highest = pressure_max if math.isnan(cap) else min(cap, pressure_max)
        ratio = None if math.isnan(self.grip_ratio) else self.grip_ratio
        return Limits(**given | {"pressure_cap": highest, "grip_ratio": ratio})


PARAMETERS: Final = GripperParameters.specs()
