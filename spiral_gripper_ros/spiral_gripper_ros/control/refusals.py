"""The refusals of the control logic that are always the same, and that of a radius gone stale."""

from __future__ import annotations

from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.control.states import Reason, Refusal

NO_RADIUS = Refusal(Reason.NO_RADIUS, "no object_radius has been received yet")
NOT_FOLLOWING = Refusal(Reason.NO_RADIUS, "no object_radius is being followed: name one")
NOT_ACTIVE = Refusal(Reason.NOT_ACTIVE, "the node is not active: configure and activate it")
RELEASED = Refusal(Reason.RELEASED, "released: call rearm, or deactivate and activate, to grip")
RECONFIGURED = Refusal(
    Reason.RECONFIGURED, "another gripper was loaded: call rearm to follow radii with it"
)
GRASP_HOLDS = Refusal(Reason.INVALID_REQUEST, "a grasp is the target: release it first")
GRASP_CANCELED = Refusal(Reason.GRASP_CANCELED, "the grasp was canceled")
GRASP_REPLACED = Refusal(Reason.GRASP_REPLACED, "a newer grasp goal has taken over")


def stale_radius(age: float, limits: Limits, last: Refusal) -> Refusal:
    """Return that no usable radius has come for ``age`` [s], and what was wrong with the last one.

    Example:
        >>> limits = Limits(pressure_cap=1.0e5)
        >>> stale_radius(1.5, limits, Refusal(Reason.NONE, "")).text
        'no usable object_radius for 1.50 s (radius_timeout 1 s, policy hold)'
    """
    return Refusal(
        Reason.RADIUS_STALE,
        f"no usable object_radius for {age:.2f} s (radius_timeout {limits.radius_timeout:.3g} s, "
        f"policy {limits.timeout_policy.value}){cause(last)}",
    )


def cause(last: Refusal) -> str:
    """Return the end of a text that tells what was refused last, if anything was."""
    return "" if last.reason is Reason.NONE else f"; last refused: {last.text}"
