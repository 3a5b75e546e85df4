# SPDX-License-Identifier: Apache-2.0
"""The settings of the studio's controls, and the gripper that they describe."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from spiral_core import FiberAngles, FreeActuation, Gripper, OneFamily
from spiral_core.grip.setup import friction_of
from spiral_core.rod.types import Vector
from spiral_core.wrap.gripper import DEFAULT_FRICTION, STANDARD_GRAVITY
from spiral_gripper.files.description import GripperDescription, stiffness_of

# Below the fastest rates that keep a slow grip (docs/closing.md) [Pa/s].
DEFAULT_RATE = 20e3


@dataclass(frozen=True, slots=True)
class Settings:
    """The controls' values, in SI units.

    Args:
        pressure: gauge pressure [Pa].
        object_radius: radius of the object [m].
        angles: of the wound fiber families [rad]: alpha and beta, or one alone.
        length: of the tube [m].
        tilt: angle of the tube's axis at the base from straight down [rad].
        roll: rotation of the mount about that axis [rad]; at 0 a tilt leans towards the straight
            fiber.
        gravity: its magnitude [m/s^2].
        friction: Coulomb's coefficient between tube and object.
        taper: half-angle of the object [rad]: it thickens the way the coil advances; its radius is
            that in the middle of the coil.
        rate: at which the pressure rises where the closing is played in real time [Pa/s].
    """

    pressure: float
    object_radius: float
    angles: tuple[float, ...]
    length: float
    tilt: float = 0.0
    roll: float = 0.0
    gravity: float = STANDARD_GRAVITY
    friction: float = DEFAULT_FRICTION
    taper: float = 0.0
    rate: float = DEFAULT_RATE

    @property
    def gravity_vector(self) -> Vector:
        """Gravity in the base frame [m/s^2]."""
        across = self.gravity * math.sin(self.tilt)
        return (
            self.gravity * math.cos(self.tilt),
            across * math.cos(self.roll),
            across * math.sin(self.roll),
        )


def settings_of(description: GripperDescription, object_radius: float) -> Settings:
    """Return the settings that show a gripper as its file describes it, without pressure."""
    gravity = description.gripper.gravity
    size = math.hypot(*gravity)
    fibers = description.actuator.fibers
    return Settings(
        pressure=0.0,
        object_radius=object_radius,
        angles=(fibers.alpha, fibers.beta) if isinstance(fibers, FiberAngles) else (fibers.angle,),
        length=description.gripper.tube.length,
        tilt=math.acos(max(-1.0, min(1.0, gravity[0] / size))) if size > 0.0 else 0.0,
        roll=math.atan2(gravity[2], gravity[1]),
        gravity=size,
        friction=friction_of(description.gripper, None),
    )


def cone_ends(radius: float, taper: float, reach: float) -> tuple[float, float]:
    """Return where a cone ends below and above the place with its radius [m].

    It reaches as far as it is wanted to, and ends where only a fifth of its radius is left.
    """
    if taper == 0.0:
        return -reach, reach
    apex = -0.8 * radius / math.tan(taper)
    return (max(-reach, apex), reach) if taper > 0.0 else (-reach, min(reach, apex))


def gripper_for(description: GripperDescription, settings: Settings) -> Gripper:
    """Return the described gripper with the settings' fibers, length, mount and friction.

    A measured curve belongs to the gripper it was measured on: its fibers and its length stay.

    Raises:
        InvalidInputError: a value is out of its range.
        ActuationLimitError: fibers of these angles cannot be pressurized.
    """
    gripper = description.gripper
    if isinstance(gripper.actuation, FreeActuation):
        old, angles = description.actuator, settings.angles
        actuator = replace(
            old,
            tube=replace(old.tube, length=settings.length),
            fibers=FiberAngles(*angles) if len(angles) == 2 else OneFamily(*angles),
        )
        if actuator != old:
            actuation = FreeActuation(actuator)
            gripper = replace(
                gripper,
                tube=actuator.tube,
                actuation=actuation,
                stiffness=stiffness_of(description.values, actuator),
                pressure_max=min(gripper.pressure_max, actuation.pressure_limit),
            )
    gripper = replace(gripper, friction_coefficient=settings.friction)
    return gripper.with_mount(settings.gravity_vector, gripper.object_axis)


def description_of(description: GripperDescription, settings: Settings) -> GripperDescription:
    """Return the description with the settings in place of its own values, to be saved."""
    gripper = gripper_for(description, settings)
    actuation = gripper.actuation
    actuator = actuation.actuator if isinstance(actuation, FreeActuation) else description.actuator
    return replace(description, gripper=gripper, actuator=actuator)
