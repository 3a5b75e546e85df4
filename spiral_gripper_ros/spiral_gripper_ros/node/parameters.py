"""The node's parameters: one table, from which they are declared, checked and documented."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import TypeAlias

from spiral_core.errors import InvalidInputError
from spiral_gripper_ros.control.grasp import AbortPolicy
from spiral_gripper_ros.control.limits import FaultPolicy, Limits, TimeoutPolicy
from spiral_gripper_ros.regulators.pressure_scale import PressureScale, Reference

ParameterValue: TypeAlias = bool | int | float | str | tuple[float, ...]

# Fastest acceleration that is still believed to be gravity plus the arm's own motion [m/s^2]:
# twice what arms of this payload reach.
GRAVITY_LIMIT = 50.0
GRAVITY_REQUIREMENT = f"3 finite numbers of norm at most {GRAVITY_LIMIT:g} m/s^2"


@dataclass(frozen=True, slots=True)
class ParameterSpec:
    """One parameter: what it is, and what it may be.

    Args:
        name: as ``ros2 param`` knows it.
        default: its type is the parameter's type; () is an array of floats that is not set.
        description: what it does, with its unit.
        low, high: bounds of a number, both allowed.
        choices: what a string may be; empty: anything but "".
        read_only: fixed when the node starts.
    """

    name: str
    default: ParameterValue
    description: str
    low: float | None = None
    high: float | None = None
    choices: tuple[str, ...] = ()
    read_only: bool = False


def _number(name: str, default: float, low: float, high: float, text: str) -> ParameterSpec:
    return ParameterSpec(name, default, text, low=low, high=high)


def _choice(name: str, default: Enum, text: str) -> ParameterSpec:
    return ParameterSpec(
        name, default.value, text, choices=tuple(policy.value for policy in type(default))
    )


_LIMITS = Limits(pressure_cap=1.0)

PARAMETERS: tuple[ParameterSpec, ...] = (
    ParameterSpec(
        "gripper",
        "paper_design_70",
        "Gripper description: the name of a shipped one, or the path of a file; another one vents "
        "first and is followed after rearm.",
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
        "Gravity in the base frame [m/s^2], 3 numbers, until the topic says otherwise; "
        "[.nan, .nan, .nan]: as in the gripper description.",
    ),
    _number(
        "gravity_hysteresis",
        0.1,
        0.0,
        GRAVITY_LIMIT,
        "The shapes are solved anew when gravity has changed by more than this [m/s^2].",
    ),
    _number(
        "pressure_cap",
        0.0,
        0.0,
        1.0e6,
        "Largest gauge pressure ever commanded [Pa]; 0: the gripper description's limit, which "
        "also bounds any other value.",
    ),
    _number(
        "pressure_rate_up",
        _LIMITS.pressure_rate_up,
        1.0e2,
        1.0e7,
        "Fastest rise of the command [Pa/s].",
    ),
    _number(
        "pressure_rate_down",
        _LIMITS.pressure_rate_down,
        1.0e2,
        1.0e7,
        "Fastest fall of the command [Pa/s]; a vent ignores it.",
    ),
    _number(
        "radius_timeout",
        _LIMITS.radius_timeout,
        0.01,
        3600.0,
        "Age of the last usable radius at which the policy acts [s].",
    ),
    _choice(
        "radius_timeout_policy",
        _LIMITS.timeout_policy,
        "What happens then: hold the pressure, vent at once, or ramp_down.",
    ),
    _number(
        "radius_rate_limit",
        _LIMITS.radius_rate_limit,
        1.0e-4,
        10.0,
        "Fastest believable change of the radius [m/s].",
    ),
    _number(
        "radius_jump_limit",
        _LIMITS.radius_jump_limit,
        1.0e-5,
        1.0,
        "A radius farther than this [m] from what radius_rate_limit allows is refused.",
    ),
    _number(
        "radius_hysteresis",
        _LIMITS.radius_hysteresis,
        0.0,
        0.1,
        "The command changes when the radius has moved by more than this [m].",
    ),
    _number(
        "grasp_timeout",
        _LIMITS.grasp_timeout,
        0.1,
        600.0,
        "Longest time until the wrap of a grasp goal is reached [s], unless the goal says.",
    ),
    _choice(
        "grasp_abort_policy",
        _LIMITS.grasp_abort_policy,
        "What a grasp goal that fails or is canceled does: vent, or hold the pressure of then.",
    ),
    _number(
        "measured_pressure_timeout",
        _LIMITS.measured_pressure_timeout,
        0.01,
        3600.0,
        "Age of the last usable measured_pressure at which it counts as lost [s].",
    ),
    _choice(
        "measured_pressure_reference",
        Reference.GAUGE,
        "What measured_pressure is counted from; drivers that follow sensor_msgs say absolute.",
    ),
    _number(
        "ambient_pressure",
        101325.0,
        5.0e4,
        1.2e5,
        "Absolute pressure of the air around [Pa]; for a measured_pressure that is absolute.",
    ),
    _number(
        "pressure_settle_time",
        _LIMITS.pressure_settle_time,
        0.0,
        60.0,
        "The measured pressure may lag behind the command by this [s].",
    ),
    _number(
        "pressure_tolerance",
        _LIMITS.pressure_tolerance,
        10.0,
        1.0e6,
        "Largest difference of measured and commanded pressure that is no fault [Pa].",
    ),
    _choice(
        "pressure_fault_policy",
        _LIMITS.pressure_fault_policy,
        "What such a fault does: report it, or vent until rearm; a running grasp fails either way.",
    ),
    _number(
        "gripper_command_open",
        0.1,
        0.001,
        10.0,
        "A gripper action's position [m] at or above which it means: open (release).",
    ),
    _number(
        "publish_rate",
        50.0,
        1.0,
        500.0,
        "Rate of pressure_command and status while active, and of the ramp [Hz].",
    ),
    _number("marker_rate", 5.0, 0.0, 50.0, "Rate of markers while active [Hz]; 0: none."),
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
        requirement = _unmet_requirement(spec, value)
        if requirement is not None:
            return str(InvalidInputError(name, value, requirement))
    return None


def limits_from_values(values: Mapping[str, ParameterValue], pressure_max: float) -> Limits:
    """Return the control logic's limits for checked parameter values.

    Args:
        values: a value for every parameter in the table.
        pressure_max: the gripper's own limit [Pa]; no parameter can raise the cap above it.
    """
    cap = number(values, "pressure_cap")
    return Limits(
        pressure_cap=min(cap, pressure_max) if cap > 0.0 else pressure_max,
        pressure_rate_up=number(values, "pressure_rate_up"),
        pressure_rate_down=number(values, "pressure_rate_down"),
        radius_timeout=number(values, "radius_timeout"),
        timeout_policy=TimeoutPolicy(values["radius_timeout_policy"]),
        radius_rate_limit=number(values, "radius_rate_limit"),
        radius_jump_limit=number(values, "radius_jump_limit"),
        radius_hysteresis=number(values, "radius_hysteresis"),
        grasp_timeout=number(values, "grasp_timeout"),
        grasp_abort_policy=AbortPolicy(values["grasp_abort_policy"]),
        measured_pressure_timeout=number(values, "measured_pressure_timeout"),
        pressure_settle_time=number(values, "pressure_settle_time"),
        pressure_tolerance=number(values, "pressure_tolerance"),
        pressure_fault_policy=FaultPolicy(values["pressure_fault_policy"]),
    )


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


def gravity_problem(components: Iterable[float]) -> str | None:
    """Return what is wrong with three components of gravity [m/s^2], or None.

    Example:
        >>> gravity_problem((0.0, 0.0, 98.1))
        'gravity must be 3 finite numbers of norm at most 50 m/s^2, got (0.0, 0.0, 98.1)'
    """
    vector = tuple(components)
    if (
        len(vector) == 3
        and all(map(math.isfinite, vector))
        and math.hypot(*vector) <= GRAVITY_LIMIT
    ):
        return None
    return str(InvalidInputError("gravity", vector, GRAVITY_REQUIREMENT))


def _unmet_requirement(spec: ParameterSpec, value: ParameterValue) -> str | None:
    low, high = spec.low, spec.high
    if low is not None and high is not None and not _is_within(value, low, high):
        return f"a number from {low:g} to {high:g}"
    if spec.choices and value not in spec.choices:
        return f"one of {', '.join(spec.choices)}"
    if isinstance(spec.default, str) and not value:
        return "text that is not empty"
    if isinstance(spec.default, tuple) and isinstance(value, tuple) and value:
        return None if gravity_problem(value) is None else GRAVITY_REQUIREMENT
    return None


def _is_within(value: ParameterValue, low: float, high: float) -> bool:
    """Return whether a value is a number within bounds; true and false are none."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and low <= value <= high
