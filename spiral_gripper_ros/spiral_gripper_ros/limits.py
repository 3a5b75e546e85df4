"""The limits that the supervisor keeps, validated together."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from spiral_core.errors import InvalidInputError
from spiral_core.validation import require_non_negative, require_positive


class TimeoutPolicy(Enum):
    """What happens when no usable radius has come for ``radius_timeout``."""

    HOLD = "hold"  # keep the last safe target: an object that hides the camera stays gripped
    VENT = "vent"  # 0 Pa at once
    RAMP_DOWN = "ramp_down"  # 0 Pa at pressure_rate_down


@dataclass(frozen=True, slots=True)
class Limits:
    """What no command may exceed and how inputs are judged.

    Args:
        pressure_cap: largest gauge pressure ever commanded [Pa], > 0.
        pressure_rate_up: fastest rise of the command [Pa/s], > 0.
        pressure_rate_down: fastest fall of the command [Pa/s], > 0; a vent ignores it.
        radius_timeout: age of the last usable radius at which ``timeout_policy`` acts [s], > 0.
        timeout_policy: what then happens.
        radius_rate_limit: fastest believable change of the radius [m/s], > 0.
        radius_jump_limit: a radius is refused if it is farther than this [m], > 0, from a signal
            that follows the estimates no faster than ``radius_rate_limit``.
        radius_hysteresis: the command changes only when the radius has moved by more than this
            from the one in use [m], >= 0.

    Raises:
        InvalidInputError: a limit is not finite, has the wrong sign, or is of the wrong type.

    Example:
        >>> Limits(pressure_cap=float("nan"))
        Traceback (most recent call last):
            ...
        spiral_core.errors.InvalidInputError: pressure_cap must be a positive finite number, got nan
    """

    pressure_cap: float
    pressure_rate_up: float = 1.0e5
    pressure_rate_down: float = 2.0e5
    radius_timeout: float = 1.0
    timeout_policy: TimeoutPolicy = TimeoutPolicy.HOLD
    radius_rate_limit: float = 0.05
    radius_jump_limit: float = 0.002
    radius_hysteresis: float = 0.0001

    def __post_init__(self) -> None:
        for field in (
            "pressure_cap",
            "pressure_rate_up",
            "pressure_rate_down",
            "radius_timeout",
            "radius_rate_limit",
            "radius_jump_limit",
        ):
            require_positive(field, getattr(self, field))
        require_non_negative("radius_hysteresis", self.radius_hysteresis)
        if not isinstance(self.timeout_policy, TimeoutPolicy):
            raise InvalidInputError(
                "timeout_policy",
                self.timeout_policy,
                f"one of {', '.join(policy.value for policy in TimeoutPolicy)}",
            )
