# SPDX-License-Identifier: Apache-2.0
"""The grip on one object over the pressure, with contact and friction, as plain values."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from spiral_core.rod.types import Array, Vector
from spiral_core.wrap.gripper import Gripper
from spiral_core.wrap.wrap import WrapRegime

# What holds an object, and changes with the pressure.
FORCES = ("contact_length", "normal_force", "away", "towards", "down")


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
class GripShapes:
    """The tube on its object at each pressure of a path.

    Args:
        positions: of its nodes (n, nodes, 3) [m].
        orientations: of its material frames (n, nodes, 4), scalar last.
        center, axis: of the object [m], in the base frame.
    """

    positions: Array
    orientations: Array
    center: Vector
    axis: Vector


@dataclass(frozen=True, slots=True)
class GripAnswer:
    """The grip on one object at one pressure.

    Args:
        at_pose: whether it was computed for the object where it is seen; else for one that is laid
            into the free coil.
        computed_at: when [s].
        friction: coefficient used.
        onset_wrap: lowest pressure of the perfect wrap [Pa].
        onset_curling: pressure at which the tube lifts off before the tip [Pa]; inf: it does not.
        loss: pressure at which the grip is lost [Pa]; inf: it is not.
        regime: how the object is held.
        contact_length: of tube on the object [m].
        normal_force: on the object, summed [N].
        away, towards, down: force that holds the object against moving along its axis away from
            the base, towards it, and along gravity [N].
        settling: how long the tube swings on after a ramp to this pressure [s]; NaN: not known.
    """

    at_pose: bool
    computed_at: float
    friction: float
    onset_wrap: float
    onset_curling: float
    loss: float
    regime: WrapRegime
    contact_length: float = 0.0
    normal_force: float = 0.0
    away: float = 0.0
    towards: float = 0.0
    down: float = 0.0
    settling: float = math.nan


@dataclass(frozen=True, slots=True, eq=False)
class GripCurve:
    """The grip on an object while the pressure rises slowly, the object in place.

    Args:
        tip_pressure: of the perfect wrap by the criterion at the free coil's tip [Pa].
        onset_wrap: lowest pressure of the perfect wrap [Pa].
        onset_curling: pressure at which the tube lifts off before the tip [Pa]; inf: it does not.
        loss: pressure at which the wrapped coil loses stability [Pa], or up to which it could be
            followed; inf: neither.
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
        shapes: of the tube at the pressures of the path; None: they are not kept.
        computed_at: when [s].
    """

    tip_pressure: float
    onset_wrap: float
    onset_curling: float
    loss: float
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
    shapes: GripShapes | None = None
    computed_at: float = 0.0

    @property
    def window(self) -> tuple[float, float, float]:
        """Where good grips begin and end, and where the grip is lost [Pa]; inf: nowhere."""
        return self.onset_wrap, self.highest_good, self.loss

    def answer(self, pressure: float, *, at_pose: bool) -> GripAnswer:
        """Return the grip at a pressure [Pa]; above the loss nothing is held."""
        return GripAnswer(
            at_pose=at_pose,
            computed_at=self.computed_at,
            friction=self.friction,
            onset_wrap=self.onset_wrap,
            onset_curling=self.onset_curling,
            loss=self.loss,
            regime=self.regime(pressure),
            **self.forces(pressure),
        )

    def regime(self, pressure: float) -> WrapRegime:
        """Return how the object is held at a pressure [Pa] that has risen from nothing."""
        return regime_at(pressure, self.onset_wrap, self.onset_curling, self.loss)

    def forces(self, pressure: float) -> dict[str, float]:
        """Return what changes with the pressure [Pa], by its name in :class:`GripAnswer`."""
        if not pressure < self.loss:
            return dict.fromkeys(FORCES, 0.0) | {"settling": math.nan}
        path = {"contact_length": self.contact_lengths, "normal_force": self.normal_forces}
        values = {n: float(np.interp(pressure, self.pressures, each)) for n, each in path.items()}
        for name in ("away", "towards", "down", "settling"):
            # Below the first of its pressures nothing holds that could be relied on.
            least = None if name == "settling" else 0.0
            each = getattr(self, name)
            values[name] = float(np.interp(pressure, self.force_pressures, each, left=least))
        return values

    def shape(self, pressure: float) -> TubeShape | None:
        """Return the tube on the object, blended between the pressures of the path [Pa]."""
        if self.shapes is None or not 0.0 <= pressure <= self.top:
            return None
        above = max(int(np.searchsorted(self.pressures, pressure)), 1)
        low, high = self.pressures[above - 1 : above + 1]
        part = (pressure - low) / (high - low)
        positions, turns = (
            (1.0 - part) * each[above - 1] + part * each[above]
            for each in (self.shapes.positions, self.shapes.orientations)
        )
        return TubeShape(positions, turns / np.linalg.norm(turns, axis=1, keepdims=True))


def regime_at(pressure: float, onset: float, curling: float, loss: float) -> WrapRegime:
    """Return how an object is held at a pressure, between those at which that changes [Pa]."""
    if not onset <= pressure < loss:
        return WrapRegime.OVERHANG
    return WrapRegime.CURLING if pressure >= curling else WrapRegime.PERFECT_WRAP
