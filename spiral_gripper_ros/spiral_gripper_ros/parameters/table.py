# SPDX-License-Identifier: Apache-2.0
"""The node's parameters: one table, from which they are declared, checked and documented."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import fields

from spiral_core.errors import InvalidInputError
from spiral_gripper_ros.control.limits import HIGHEST_GRIP_RATIO, Limits
from spiral_gripper_ros.parameters.pressure_scale import PressureScale, Reference
from spiral_gripper_ros.parameters.spec import (
    GRAVITY_LIMIT,
    ParameterSpec,
    ParameterValue,
    choice_spec,
    number_spec,
    unmet_requirement,
)

_LIMITS = Limits(pressure_cap=1.0)


def _limit(name: str, low: float, high: float, text: str) -> ParameterSpec:
    """Return the parameter of a limit, with the limit's own default."""
    return number_spec(name, getattr(_LIMITS, name), low, high, text)


def _policy(name: str, text: str) -> ParameterSpec:
    """Return the parameter of a policy, with the policy's own default."""
    return choice_spec(name, getattr(_LIMITS, name), text)


PARAMETERS: tuple[ParameterSpec, ...] = (
    ParameterSpec(
        "gripper",
        "paper_design_70",
        "Gripper description: the name of a shipped one, or the path of a file; a change "
        "vents, and the new gripper is used after rearm.",
    ),
    ParameterSpec(
        "frame_id",
        "gripper_base",
        "Frame of every stamped message: the clamped end, x along the tube.",
        read_only=True,
    ),
    ParameterSpec(
        "autostart",
        True,
        "Configure and activate at start; false leaves that to a lifecycle manager.",
        read_only=True,
    ),
    ParameterSpec(
        "gravity",
        (),
        "Gravity in the base frame [m/s^2], 3 numbers, until a message comes on the topic gravity; "
        "[.nan, .nan, .nan]: as in the gripper description.",
    ),
    number_spec(
        "gravity_hysteresis",
        0.1,
        0.0,
        GRAVITY_LIMIT,
        "Plans and shapes are solved again when gravity has changed by more than this [m/s^2].",
    ),
    number_spec(
        "pressure_cap",
        math.nan,
        0.0,
        1.0e6,
        "Largest gauge pressure ever commanded [Pa]; .nan: the gripper description's limit, which "
        "also bounds any other value. A raised cap acts from the next radius or goal on.",
    ),
    _limit(
        "pressure_rate_up",
        1.0e2,
        1.0e7,
        "Fastest rise of the command [Pa/s].",
    ),
    _limit(
        "pressure_rate_down",
        1.0e2,
        1.0e7,
        "Fastest fall of the command [Pa/s]; a vent ignores it.",
    ),
    _limit(
        "radius_timeout",
        0.01,
        3600.0,
        "Age of the last usable radius at which the policy acts [s].",
    ),
    number_spec(
        "radius_age_limit",
        0.5,
        0.001,
        3600.0,
        "An object_radius_stamped whose stamp is farther from now than this [s] is refused.",
    ),
    number_spec(
        "object_pose_timeout",
        1.0,
        0.01,
        3600.0,
        "An object_pose whose stamp is farther from now than this [s] is not used.",
    ),
    _policy(
        "radius_timeout_policy",
        "Action after radius_timeout: hold the pressure, vent at once, or ramp_down.",
    ),
    _limit(
        "radius_rate_limit",
        1.0e-4,
        10.0,
        "Fastest believable change of the radius [m/s].",
    ),
    _limit(
        "radius_jump_limit",
        1.0e-5,
        1.0,
        "A radius farther than this [m] from what radius_rate_limit allows is refused.",
    ),
    _limit(
        "radius_hysteresis",
        0.0,
        0.1,
        "The command changes when the radius has moved by more than this [m].",
    ),
    _limit(
        "grasp_timeout",
        0.1,
        600.0,
        "Longest time until a grasp reaches its wrap [s], unless the goal has a timeout.",
    ),
    _policy(
        "grasp_abort_policy",
        "Action when a grasp goal fails or is canceled: vent, or hold the pressure.",
    ),
    _limit(
        "measured_pressure_timeout",
        0.01,
        3600.0,
        "Age of the last usable measured_pressure at which it counts as lost [s].",
    ),
    choice_spec(
        "measured_pressure_reference",
        Reference.GAUGE,
        "Reference of measured_pressure; drivers that follow sensor_msgs publish the absolute one.",
    ),
    number_spec(
        "ambient_pressure",
        101325.0,
        5.0e4,
        1.2e5,
        "Ambient absolute pressure [Pa], for an absolute measured_pressure.",
    ),
    _limit(
        "pressure_settle_time",
        0.0,
        60.0,
        "The measured pressure may lag behind the command by this [s].",
    ),
    _limit(
        "pressure_tolerance",
        10.0,
        1.0e6,
        "Largest difference of measured and commanded pressure that is no fault [Pa].",
    ),
    _policy(
        "pressure_fault_policy",
        "Action at a pressure fault: report it, or vent until rearm; a running grasp fails.",
    ),
    number_spec(
        "grip_ratio",
        1.1,
        1.0,
        HIGHEST_GRIP_RATIO,
        "Pressure of a grip, as a multiple of the pressure of the perfect wrap, "
        "whose contact force is almost zero; limited by pressure_cap.",
    ),
    number_spec(
        "keep_alive_timeout",
        0.0,
        0.0,
        3600.0,
        "A grip is vented when no keep_alive has come for this time [s]; 0: none is expected.",
    ),
    number_spec(
        "gravity_timeout",
        0.0,
        0.0,
        3600.0,
        "Age at which a received gravity is stale [s]; 0: never.",
    ),
    _policy("gravity_timeout_policy", "Action at stale gravity: report it, or vent until rearm."),
    ParameterSpec(
        "activation",
        "vent",
        "Start from 0 Pa (vent), or keep the first measured_pressure until "
        "a radius or a goal comes (take_over).",
        choices=("vent", "take_over"),
    ),
    ParameterSpec(
        "exit_with_parent",
        False,
        "Vent and end when the process that started this one ends: ros2 run, ros2 launch.",
        read_only=True,
    ),
    number_spec(
        "gripper_command_open",
        0.1,
        0.001,
        10.0,
        "Position of a gripper action [m] at or above which it means release.",
    ),
    ParameterSpec(
        "gripper_cmd_type",
        "GripperCommand",
        "Type of the action gripper_cmd, of control_msgs; parallel_gripper_cmd is offered beside "
        "the first.",
        choices=("GripperCommand", "ParallelGripperCommand"),
        read_only=True,
    ),
    number_spec(
        "publish_rate",
        50.0,
        1.0,
        500.0,
        "Rate of pressure_command and status while active, and of the ramp [Hz].",
    ),
    number_spec("payload", 0.0, 0.0, 100.0, "Mass of the object [kg] unless a goal says; 0: none."),
    ParameterSpec("grip_radii", 6, "Radii of the table of grips; 0: no grip is computed.", 0, 50),
    number_spec("marker_rate", 5.0, 0.0, 50.0, "Rate of markers while active [Hz]; 0: none."),
    number_spec(
        "robot_state_rate",
        0.0,
        0.0,
        50.0,
        "Rate of joint_states, wrapped_object_pose and /tf while active [Hz]; 0: none.",
    ),
    ParameterSpec(
        "backbone_points",
        50,
        "Largest number of poses in backbone, base and tip included.",
        low=2,
        high=1000,
    ),
)


def refusal_of_values(
    proposed: Mapping[str, ParameterValue],
    *,
    table: Sequence[ParameterSpec] = PARAMETERS,
) -> str | None:
    """Return why these values cannot be set, or None if they can.

    Args:
        proposed: new values by name; names that are not in the table are not judged.
        table: what they may be.

    Example:
        >>> refusal_of_values({"radius_timeout": float("nan")})
        'radius_timeout must be a number from 0.01 to 3600, got nan'
    """
    known = {spec.name: spec for spec in table}
    for name, value in proposed.items():
        spec = known.get(name)
        if spec is None:
            continue
        requirement = unmet_requirement(spec, value)
        if requirement is not None:
            return str(InvalidInputError(name, value, requirement))
    return None


def limits_from_values(values: Mapping[str, ParameterValue], pressure_max: float) -> Limits:
    """Return the control logic's limits for checked parameter values.

    Args:
        values: a value for every parameter in the table.
        pressure_max: the gripper's own limit [Pa]; no parameter can raise the cap above it.
    """
    given = {
        field.name: type(getattr(_LIMITS, field.name))(values[field.name])
        for field in fields(Limits)
    }
    cap = given["pressure_cap"]
    highest = pressure_max if math.isnan(cap) else min(cap, pressure_max)
    return Limits(**given | {"pressure_cap": highest})


def number(values: Mapping[str, ParameterValue], name: str) -> float:
    """Return a number among checked values."""
    value = values[name]
    if not isinstance(value, (int, float)):
        raise InvalidInputError(name, value, "a number")
    return float(value)


def measured_scale(values: Mapping[str, ParameterValue]) -> PressureScale:
    """Return how `measured_pressure` states a pressure, for checked parameter values."""
    return PressureScale(
        reference=Reference(values["measured_pressure_reference"]),
        ambient_pressure=number(values, "ambient_pressure"),
    )
