# SPDX-License-Identifier: Apache-2.0
"""A planned wrap, and the interface of what plans it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from spiral_core.wrap.gripper import Gripper
from spiral_core.wrap.placement import ObjectPlacement, coil_place
from spiral_core.wrap.wrap import Wrap, line_force


@dataclass(frozen=True, slots=True)
class WrapPlan:
    """A perfect wrap; derived quantities are computed on request.

    Args:
        wrap: the core's answer, about the object's direction if that is known.
        laid: the wrap about the axis that fits the coil: where the object lies.
        gripper: that it is for, as it is mounted.
        solve_time: time that the answer took [s].
        onset: pressure from which the object is wrapped [Pa], by contact; 0 where it is not known.
        highest_good: largest pressure of a good grip [Pa], by contact; inf where it is not known.
        loss: pressure at which the grip is lost [Pa], by contact; inf where it is not known.
    """

    wrap: Wrap
    laid: Wrap
    gripper: Gripper
    solve_time: float
    onset: float = 0.0
    highest_good: float = math.inf
    loss: float = math.inf

    @property
    def pressure(self) -> float:
        """Gauge pressure of the perfect wrap [Pa].

        That is the tip criterion's, but not below the onset nor above what contact recommends.
        """
        return min(max(self.wrap.pressure, self.onset), 0.5 * (self.onset + self.highest_good))

    @property
    def placement(self) -> ObjectPlacement:
        """Where the object lies, as in its grip."""
        return coil_place(self.laid, self.gripper)

    @property
    def turns_margin(self) -> float:
        """Turns beyond those required."""
        return self.wrap.turns - self.wrap.turns_required

    @property
    def recommended(self) -> float | None:
        """Middle of the good grips [Pa], by contact; None where it is not known."""
        return None if math.isinf(self.highest_good) else 0.5 * (self.onset + self.highest_good)

    def is_wrapped(self, pressure: float) -> bool:
        """Return whether contact is known to wrap the object at a pressure [Pa]."""
        return 0.0 < self.onset <= pressure < self.loss

    def line_force(self, pressure: float) -> float:
        """Return the normal force per length of gripper on the object at a pressure [N/m].

        Raises:
            SpiralError: the pressure [Pa] is beyond the description.
        """
        gripper, wrap = self.gripper, self.wrap
        shape, outer = gripper.unloaded_shape(pressure), gripper.tube.outer_radius
        return line_force(gripper.stiffness, shape, wrap.object_radius, wrap.helix_angle, outer)


class Planner(Protocol):
    """Interface of the plans of one gripper at one gravity."""

    @property
    def radius_range(self) -> tuple[float, float]:
        """Smallest and largest radius that can be gripped [m]."""
        ...

    def plan(self, radius: float) -> WrapPlan:
        """Return the perfect wrap for a radius [m]; raise a ``SpiralError`` if there is none."""
        ...
