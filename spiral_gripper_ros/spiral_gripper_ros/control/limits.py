# SPDX-License-Identifier: Apache-2.0
"""The limits of the control logic, validated together."""

from __future__ import annotations

from dataclasses import dataclass, fields
from enum import Enum

from spiral_core.errors import InvalidInputError
from spiral_core.validation import require_in_range, require_non_negative, require_positive

# A coil that is pressed harder than this multiple of its wrap pressure may unwind from its tip.
HIGHEST_GRIP_RATIO = 1.2


class TimeoutPolicy(Enum):
    """What happens after ``radius_timeout`` without a usable radius."""

    HOLD = "hold"  # keep the last safe target: an object that hides the camera stays gripped
    VENT = "vent"  # 0 Pa at once
    RAMP_DOWN = "ramp_down"  # 0 Pa at pressure_rate_down


class FaultPolicy(Enum):
    """What happens when the measured pressure does not follow the command."""

    REPORT = "report"  # say so; a grasp goal that is running fails
    VENT = "vent"  # 0 Pa at once, until re-armed


class AbortPolicy(Enum):
    """What happens to the pressure when a grasp is canceled or fails."""

    VENT = "vent"  # 0 Pa at once, until re-armed or the next goal
    HOLD = "hold"  # the command at that moment stands


@dataclass(frozen=True, slots=True)
class Limits:
    """The limits of commands and inputs.

    Args:
        pressure_cap: largest gauge pressure ever commanded [Pa], >= 0.
        pressure_rate_up: fastest rise of the command [Pa/s], > 0; the default is slow enough for
            the shipped grippers to keep 90 % of their slow grip (docs/closing.md).
        pressure_rate_down: fastest fall of the command [Pa/s], > 0; a vent ignores it.
        radius_timeout: age of the last usable radius at which the policy acts [s], > 0.
        radius_timeout_policy: what then happens.
        radius_rate_limit: fastest believable change of the radius [m/s], > 0.
        radius_jump_limit: a radius is refused if it is farther than this [m], > 0, from a signal
            that follows the estimates no faster than ``radius_rate_limit``.
        radius_hysteresis: the command changes only when the radius has moved by more than this
            from the one in use [m], >= 0.
        grasp_timeout: longest time until a grasp's wrap is reached [s], > 0, unless its goal says.
        grasp_abort_policy: what becomes of the pressure when a grasp fails, unless its goal says.
        measured_pressure_timeout: age of the last measurement at which it counts as lost [s], > 0.
        pressure_settle_time: the measured pressure may be where the command was this long ago [s],
            >= 0; a grasp that is not measured counts as reached so long after its command is.
        pressure_tolerance: largest difference between measured and commanded pressure that is no
            fault [Pa], > 0.
        pressure_fault_policy: what happens at a fault of the measured pressure.
        grip_ratio: pressure of a grip, as a multiple of the pressure of the bare wrap, unless a
            goal names an overpressure, >= 1; None: the one that contact recommends.
        keep_alive_timeout: without a sign of life of the client for this time [s] a grip is vented;
            0: none is expected.
        gravity_timeout: age of a heard gravity at which it is stale [s]; 0: it never is.
        gravity_timeout_policy: what happens then.
        publish_rate: commands in a second [Hz], > 0.

    Raises:
        InvalidInputError: a limit is not finite, has the wrong sign, or is of the wrong type.

    Example:
        >>> Limits(pressure_cap=1.0e5).radius_timeout_policy.value
        'hold'
    """

    pressure_cap: float
    pressure_rate_up: float = 1.5e4
    pressure_rate_down: float = 2.0e5
    radius_timeout: float = 1.0
    radius_timeout_policy: TimeoutPolicy = TimeoutPolicy.HOLD
    radius_rate_limit: float = 0.05
    radius_jump_limit: float = 0.002
    radius_hysteresis: float = 0.0001
    grasp_timeout: float = 10.0
    grasp_abort_policy: AbortPolicy = AbortPolicy.VENT
    measured_pressure_timeout: float = 0.5
    pressure_settle_time: float = 0.5
    pressure_tolerance: float = 1000.0
    pressure_fault_policy: FaultPolicy = FaultPolicy.REPORT
    grip_ratio: float | None = 1.0
    keep_alive_timeout: float = 0.0
    gravity_timeout: float = 0.0
    gravity_timeout_policy: FaultPolicy = FaultPolicy.REPORT
    publish_rate: float = 50.0

    def __post_init__(self) -> None:
        for field in fields(self):
            name, value, kind = field.name, getattr(self, field.name), type(field.default)
            if issubclass(kind, Enum):
                if not isinstance(value, kind):
                    names = ", ".join(str(known.value) for known in kind)
                    raise InvalidInputError(name, value, f"one of {names}")
            elif name == "grip_ratio":
                if value is not None:
                    require_in_range(name, value, 1.0, HIGHEST_GRIP_RATIO)
            elif name in _NON_NEGATIVE:
                require_non_negative(name, value)
            else:
                require_positive(name, value)

    @property
    def period(self) -> float:
        """Time between two commands [s]."""
        return 1.0 / self.publish_rate


_NON_NEGATIVE = (
    "pressure_cap",
    "radius_hysteresis",
    "pressure_settle_time",
    "keep_alive_timeout",
    "gravity_timeout",
)
