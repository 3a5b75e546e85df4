# SPDX-License-Identifier: Apache-2.0
"""The node's parameters: one table, from which they are declared, checked and documented."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from operator import attrgetter
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
class Gravity(Parameters):
    """Gravity in the base frame."""

    NAMESPACE = "gravity."
    vector: tuple[float, ...] = parameter(
        (),
        "Gravity in the base frame [m/s^2], 3 numbers, until a message comes on the topic "
        "gravity; [.nan, .nan, .nan]: as in the gripper description.",
    )
    frame: str = parameter(
        "",
        "Frame whose z axis points up, such as world: gravity then follows from /tf, in place of "
        "the topic gravity; needs tf2_ros. Empty: the topic.",
        read_only=True,
    )
    hysteresis: float = parameter(
        0.1,
        "Plans and shapes are solved again when gravity has changed by more than this [m/s^2].",
        0.0,
        GRAVITY_LIMIT,
    )
    timeout: float = parameter(
        0.0,
        "Age at which gravity is stale [s], received or, with gravity.frame, expected; 0: never.",
        0.0,
        3600.0,
    )
    timeout_policy: str = choice(
        _LIMITS.gravity_timeout_policy, "Action at stale gravity: report it, or vent until rearm."
    )


@dataclass(frozen=True, slots=True)
class Pressure(Parameters):
    """The command, and what is measured of it."""

    NAMESPACE = "pressure."
    cap: float = parameter(
        math.nan,
        "Largest gauge pressure ever commanded [Pa]; .nan: the gripper description's limit, "
        "which also bounds any other value. A raised cap acts from the next radius or goal on.",
        0.0,
        1.0e6,
    )
    rate_up: float = parameter(
        _LIMITS.pressure_rate_up, "Fastest rise of the command [Pa/s].", 1.0e2, 1.0e7
    )
    rate_down: float = parameter(
        _LIMITS.pressure_rate_down,
        "Fastest fall of the command [Pa/s]; a vent ignores it.",
        1.0e2,
        1.0e7,
    )
    settle_time: float = parameter(
        _LIMITS.pressure_settle_time,
        "The measured pressure may lag behind the command by this [s].",
        0.0,
        60.0,
    )
    tolerance: float = parameter(
        _LIMITS.pressure_tolerance,
        "Largest difference of measured and commanded pressure that is no fault [Pa].",
        10.0,
        1.0e6,
    )
    fault_policy: str = choice(
        _LIMITS.pressure_fault_policy,
        "Action at a pressure fault: report it, or vent until rearm; a running grasp fails.",
    )


@dataclass(frozen=True, slots=True)
class MeasuredPressure(Parameters):
    """The topic `measured_pressure`."""

    NAMESPACE = "measured_pressure."
    timeout: float = parameter(
        _LIMITS.measured_pressure_timeout,
        "Age of the last usable measured_pressure at which it counts as lost [s].",
        0.01,
        3600.0,
    )


@dataclass(frozen=True, slots=True)
class Radius(Parameters):
    """The radius that is followed."""

    NAMESPACE = "radius."
    timeout: float = parameter(
        _LIMITS.radius_timeout,
        "Age of the last usable radius at which the policy acts [s].",
        0.01,
        3600.0,
    )
    timeout_policy: str = choice(
        _LIMITS.radius_timeout_policy,
        "Action after radius.timeout: hold the pressure, vent at once, or ramp_down.",
    )
    age_limit: float = parameter(
        0.5,
        "An object_radius_stamped whose stamp is farther from now than this [s] is refused.",
        0.001,
        3600.0,
    )
    rate_limit: float = parameter(
        _LIMITS.radius_rate_limit, "Fastest believable change of the radius [m/s].", 1.0e-4, 10.0
    )
    jump_limit: float = parameter(
        _LIMITS.radius_jump_limit,
        "A radius farther than this [m] from what radius.rate_limit allows is refused.",
        1.0e-5,
        1.0,
    )
    hysteresis: float = parameter(
        _LIMITS.radius_hysteresis,
        "The command changes when the radius has moved by more than this [m].",
        0.0,
        0.1,
    )


@dataclass(frozen=True, slots=True)
class ObjectPose(Parameters):
    """The topic `object_pose`."""

    NAMESPACE = "object_pose."
    timeout: float = parameter(
        1.0,
        "An object_pose whose stamp is farther from now than this [s] is not used.",
        0.01,
        3600.0,
    )


@dataclass(frozen=True, slots=True)
class KeepAlive(Parameters):
    """The topic `keep_alive`."""

    NAMESPACE = "keep_alive."
    timeout: float = parameter(
        0.0,
        "A grip is vented when no keep_alive has come for this time [s]; 0: none is expected.",
        0.0,
        3600.0,
    )


@dataclass(frozen=True, slots=True)
class Grasp(Parameters):
    """The action `grasp`, unless its goal says."""

    NAMESPACE = "grasp."
    timeout: float = parameter(
        _LIMITS.grasp_timeout,
        "Longest time until a grasp reaches its wrap [s], unless the goal has a timeout.",
        0.1,
        600.0,
    )
    abort_policy: str = choice(
        _LIMITS.grasp_abort_policy,
        "Action when a grasp goal fails or is canceled: vent, or hold the pressure.",
    )


@dataclass(frozen=True, slots=True)
class Grip(Parameters):
    """The pressure that grips, and the grip with contact and friction."""

    NAMESPACE = "grip."
    ratio: float = parameter(
        math.nan,
        "Pressure of a grip, as a multiple of the pressure of the perfect wrap, whose contact "
        "force is almost zero; .nan: what the grip with contact recommends, and 1.1 where that is "
        "not known. Limited by pressure.cap.",
        1.0,
        HIGHEST_GRIP_RATIO,
    )
    payload: float = parameter(
        math.nan,
        "Mass of the object [kg] unless a goal says; .nan: not known.",
        0.0,
        LARGEST_PAYLOAD,
    )
    contact: bool = parameter(
        True,
        "Whether grips with contact are used: those of the table, and of the object in use. false: "
        "the criterion at the free coil's tip alone.",
    )


@dataclass(frozen=True, slots=True)
class GripperCmd(Parameters):
    """The actions of control_msgs."""

    NAMESPACE = "gripper_cmd."
    type: str = parameter(
        "GripperCommand",
        "Type of the action gripper_cmd, of control_msgs; parallel_gripper_cmd is offered "
        "beside the first.",
        choices=("GripperCommand", "ParallelGripperCommand"),
        read_only=True,
    )
    open_position: float = parameter(
        0.1, "Position of a gripper action [m] at or above which it means release.", 0.001, 10.0
    )


@dataclass(frozen=True, slots=True)
class Publish(Parameters):
    """What the node publishes."""

    NAMESPACE = "publish."
    rate: float = parameter(
        _LIMITS.publish_rate,
        "Rate of pressure_command and status while active, and of the ramp [Hz].",
        1.0,
        500.0,
    )
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
    gravity: Gravity = field(default_factory=Gravity)
    pressure: Pressure = field(default_factory=Pressure)
    measured_pressure: MeasuredPressure = field(default_factory=MeasuredPressure)
    radius: Radius = field(default_factory=Radius)
    object_pose: ObjectPose = field(default_factory=ObjectPose)
    keep_alive: KeepAlive = field(default_factory=KeepAlive)
    grasp: Grasp = field(default_factory=Grasp)
    grip: Grip = field(default_factory=Grip)
    gripper_cmd: GripperCmd = field(default_factory=GripperCmd)
    publish: Publish = field(default_factory=Publish)

    def limits(self, pressure_max: float) -> Limits:
        """Return the control logic's limits.

        Args:
            pressure_max: the gripper's own limit [Pa]; no parameter can raise the cap above it.
        """
        values = {spec.name.replace(".", "_"): attrgetter(spec.name)(self) for spec in PARAMETERS}
        given = {
            one.name: type(getattr(_LIMITS, one.name))(values[one.name]) for one in fields(Limits)
        }
        cap, ratio = self.pressure.cap, self.grip.ratio
        highest = pressure_max if math.isnan(cap) else min(cap, pressure_max)
        wanted = None if math.isnan(ratio) else ratio
        return Limits(**given | {"pressure_cap": highest, "grip_ratio": wanted})


PARAMETERS: Final = GripperParameters.specs()
