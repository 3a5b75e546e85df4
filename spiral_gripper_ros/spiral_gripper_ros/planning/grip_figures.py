# SPDX-License-Identifier: Apache-2.0
"""The grip on one object, with contact and friction, as plain values. No ROS."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spiral_core.rod.types import Array, Vector
from spiral_core.wrap.gripper import Gripper
from spiral_core.wrap.wrap import WrapRegime


@dataclass(frozen=True, slots=True)
class GripQuestion:
    """The inputs of a grip on a cylinder.

    Args:
        gripper: as it is mounted, with its gravity.
        radius: of the object [m], > 0.
        friction: Coulomb's coefficient between tube and object; None: the gripper's own, or the
            cautious default of :func:`spiral_core.grip.setup.friction_of`.
        pose: a point of the object's axis [m] and its direction; None: laid into the free coil.
        rate: of the ramp that closes the gripper [Pa/s]; 0: how long it then swings is not asked.
    """

    gripper: Gripper
    radius: float
    friction: float | None = None
    pose: tuple[Vector, Vector] | None = None
    rate: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class TubeShape:
    """A tube that lies on an object, to be drawn.

    Args:
        positions: of its nodes (n, 3) [m].
        orientations: of its material frames (n, 4), scalar last.
    """

    positions: Array
    orientations: Array


@dataclass(frozen=True, slots=True, eq=False)
class GripFigures:
    """The grip on an object while the pressure rises slowly, the object in place.

    Args:
        tip_pressure: of the perfect wrap by the criterion at the free coil's tip [Pa].
        onset_wrap: lowest pressure of the perfect wrap [Pa].
        onset_curling: pressure at which the tip lifts off again [Pa]; None: it does not.
        loss: pressure at which the wrapped coil loses stability [Pa]; None: it does not.
        highest_good: upper end of the recommended range [Pa].
        top: largest pressure at which the grip was found to hold [Pa].
        friction: coefficient used.
        pressures: of the path (n,) [Pa].
        contact_lengths, normal_forces: at those (n,) [m], [N].
        force_pressures: at which holding forces were computed (m,) [Pa].
        away, towards: the largest force that holds the object against moving along its axis, away
            from the base and towards it (m,) [N].
        down: the same along gravity (m,) [N]; zeros without gravity.
        settling: how long the tube swings on after a ramp that ends there (m,) [s]; NaN where its
            weight, or a shape, is not known.
        positions, orientations: the tube's nodes at the pressures of the path (n, nodes, 3) [m],
            (n, nodes, 4), scalar last.
        center, axis: of the object [m], in the base frame.
    """

    tip_pressure: float
    onset_wrap: float
    onset_curling: float | None
    loss: float | None
    highest_good: float
    top: float
    friction: float
    pressures: Array
    contact_lengths: Array
    normal_forces: Array
    force_pressures: Array
    away: Array
    towards: Array
    down: Array
    settling: Array
    positions: Array
    orientations: Array
    center: Vector
    axis: Vector

    def regime(self, pressure: float) -> WrapRegime:
        """Return how the object is held at a pressure [Pa] that has risen from nothing."""
        if pressure < self.onset_wrap or (self.loss is not None and pressure >= self.loss):
            return WrapRegime.OVERHANG
        curls = self.onset_curling is not None and pressure >= self.onset_curling
        return WrapRegime.CURLING if curls else WrapRegime.PERFECT_WRAP

    def shape(self, pressure: float) -> TubeShape | None:
        """Return the tube on the object, blended between the pressures of the path [Pa]."""
        if not 0.0 <= pressure <= self.top:
            return None
        above = max(int(np.searchsorted(self.pressures, pressure)), 1)
        low, high = self.pressures[above - 1 : above + 1]
        part = (pressure - low) / (high - low)
        positions, turns = (
            (1.0 - part) * each[above - 1] + part * each[above]
            for each in (self.positions, self.orientations)
        )
        return TubeShape(positions, turns / np.linalg.norm(turns, axis=1, keepdims=True))
