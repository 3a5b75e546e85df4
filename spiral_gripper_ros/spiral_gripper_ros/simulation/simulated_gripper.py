# SPDX-License-Identifier: Apache-2.0
r"""The real gripper of the simulation, which may differ from its description.

A tube whose material is :math:`s` times as stiff as described takes at :math:`s P` the shape that
is described for :math:`P` at :math:`1/s` of the weight: the unloaded shape depends on the pressure
and the material's moduli only through their ratio, and the shape under weight on that of the
bending and torsional stiffnesses, which are :math:`s` times those described, to the weight.
"""

from __future__ import annotations

import math
from enum import Enum

from spiral_core.errors import NotGrippableError, SolverError
from spiral_core.grip.table import GripTable
from spiral_core.rod.state import RodState
from spiral_core.validation import require_positive
from spiral_core.wrap.curve import WrapCurve
from spiral_core.wrap.gripper import Gripper
from spiral_gripper_ros.control.limits import HIGHEST_GRIP_RATIO
from spiral_gripper_ros.planning.grip_follower import GRAVITY_TOLERANCE


class Grip(Enum):
    """How the real gripper holds the real object; the values are what is published."""

    NO_OBJECT = "no object"
    OVERHANG = "overhang"
    PERFECT_WRAP = "perfect wrap"
    CURLING = "curling"
    NOT_GRIPPABLE = "not grippable"  # the object is outside the range of radii
    OVERPRESSURE = "overpressure"  # beyond what the gripper's model reaches
    UNKNOWN = "unknown"  # no certified shape was found


class SimulatedGripper:
    """What a gripper really does at a real pressure.

    Args:
        described: the gripper as the node knows it.
        stiffness_factor: how stiff its material really is, as a multiple, > 0; 1: as described.
        table: of its grips by contact, which say how an object is held if the tube is as described
            and mounted so; else the tip criterion does.

    Raises:
        InvalidInputError: the factor is not positive and finite.
        SpiralError: the gripper coils nowhere, or a shape could not be certified.
    """

    def __init__(
        self, described: Gripper, stiffness_factor: float = 1.0, table: GripTable | None = None
    ) -> None:
        self._factor = require_positive("stiffness_factor", stiffness_factor)
        x, y, z = (component / self._factor for component in described.gravity)
        self._curve = WrapCurve(described.with_mount((x, y, z), described.object_axis))
        self._table = None
        if table is not None and self._factor == 1.0:
            near = math.dist(table.gravity, described.gravity) <= GRAVITY_TOLERANCE
            self._table = table if near else None

    @property
    def middle_radius(self) -> float:
        """A radius in the middle of those that it can grip [m]."""
        held = [] if self._table is None else self._table.held
        if held:
            return held[len(held) // 2]
        return 0.5 * (self._curve.radius_min + self._curve.radius_max)

    def shape(self, pressure: float) -> RodState | None:
        """Return the shape at a gauge pressure [Pa] >= 0; None: beyond the model or uncertified."""
        described = pressure / self._factor
        if described > self._curve.gripper.pressure_max:
            return None
        try:
            return self._curve.state_at_pressure(described)
        except SolverError:
            return None

    def grip(self, pressure: float, radius: float | None, shape: RodState | None = None) -> Grip:
        """Return how it holds an object.

        Args:
            pressure: gauge [Pa], >= 0.
            radius: of the object [m], > 0; None: there is none.
            shape: at this pressure, if it is known already.
        """
        if radius is None:
            return Grip.NO_OBJECT
        described = pressure / self._factor
        if described > self._curve.gripper.pressure_max:
            return Grip.OVERPRESSURE
        try:
            if self._table is not None:
                if self._table.is_not_held(radius):
                    return Grip.NOT_GRIPPABLE
                tip_pressure = self._curve.pressure_from_radius(radius)
                answer = self._table.answer(radius, tip_pressure, described)
                if answer is not None:
                    return Grip(answer.regime.value)
            grip = Grip(self._curve.regime(described, radius, shape).value)
            if grip is Grip.CURLING:  # the object keeps the tip from curling off for a while
                pressed_until = HIGHEST_GRIP_RATIO * self._curve.pressure_from_radius(radius)
                return Grip.PERFECT_WRAP if described <= pressed_until else grip
            return grip
        except NotGrippableError:
            return Grip.NOT_GRIPPABLE
        except SolverError:
            return Grip.UNKNOWN
