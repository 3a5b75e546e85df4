# SPDX-License-Identifier: Apache-2.0
"""A gripper on its object at one pressure: contact, turns, forces, and how it holds."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from spiral_core.grip.setup import GripSetup
from spiral_core.rod.state import RodState
from spiral_core.rod.types import Array
from spiral_core.wrap.wrap import WrapRegime

# The tip counts as touching within this fraction of the tube's outer radius, and the end as curled
# away where it bridges more than the second one: half a millimeter for the paper's tube.
TOUCH_GAP = 0.01
CURL_GAP = 0.1
# Of the tube, the part that has to touch before contact counts as something to lose.
FEWEST_TOUCHING = 0.1


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class GripPoint:
    """A gripper on its object at one pressure.

    Args:
        pressure: gauge pressure [Pa].
        setup: the gripper and its object.
        state: the tube's shape, its contact forces and its certificate.
    """

    pressure: float
    setup: GripSetup
    state: RodState

    def __repr__(self) -> str:
        return (
            f"GripPoint({1e-3 * self.pressure:.2f} kPa: {self.regime.value}, "
            f"{1e3 * self.contact_length:.0f} mm in contact, {self.turns:.2f} turns, "
            f"normal force {self.normal_force:.3g} N)"
        )

    @property
    def regime(self) -> WrapRegime:
        """How the tube lies on the object, from its contact."""
        if not self.is_wrapped:
            return WrapRegime.OVERHANG
        return WrapRegime.CURLING if self.is_curled else WrapRegime.PERFECT_WRAP

    @property
    def is_wrapped(self) -> bool:
        """Whether the tip touches, and more than a tenth of the tube with it."""
        return self.tip_gap <= TOUCH_GAP * self.outer_radius and wraps(self.state)

    @property
    def is_curled(self) -> bool:
        """Whether the end bridges more than a curl's gap after its first touch."""
        return wraps(self.state) and self.largest_gap > CURL_GAP * self.outer_radius

    @property
    def outer_radius(self) -> float:
        """Of the tube [m]."""
        return self.setup.gripper.tube.outer_radius

    @property
    def contact_length(self) -> float:
        """Length of tube that touches the object, its gap at most that of a touching tip [m]."""
        return float(self.state.lengths_within(TOUCH_GAP * self.outer_radius)[0])

    @property
    def normal_force(self) -> float:
        """Sum of the normal forces on the object [N]."""
        return float(self.state.normal_forces.sum())

    @property
    def line_force(self) -> Array:
        """Normal force per length of tube at its nodes (n,) [N/m].

        Where the tube lifts off it presses with a point force, which an element spreads over its
        own length: compare resultants, or :attr:`contact_pressure`, not this peak.
        """
        values: Array = self.state.normal_forces[0] / self.state.node_lengths
        return values

    @property
    def contact_pressure(self) -> float:
        r"""Largest pressure of the tube on the object [Pa]: an estimate.

        .. math:: p = \sqrt{\frac{q E^*}{\pi r_o}}, \quad E^* = \frac{EI}{I (1 - \nu^2)}, \;
            \nu = 1/2

        Hertz's line contact of a solid elastomer cylinder of the tube's outer radius with a flat,
        hard surface; q is the largest line force, averaged over a length of two outer radii, which
        the tube's thickness spreads a point force over. A hollow tube flattens and presses less.
        EI is that of bending sideways, in which fibers take the least part.
        """
        tube = self.setup.gripper.tube
        forces = self.state.normal_forces[0]
        at = self.state.arc_lengths
        half = tube.outer_radius
        within = np.abs(at[:, None] - at[None, :]) <= half
        shared = np.maximum(within @ self.state.node_lengths, 2.0 * half)
        peak = float(np.max((within @ forces) / shared))
        modulus = self.setup.gripper.stiffness.sideways / tube.second_moment_of_area / 0.75
        return math.sqrt(max(peak, 0.0) * modulus / (math.pi * half))

    @property
    def turns(self) -> float:
        """Turns of the touching part about the object's axis."""
        axis = self.setup.axis
        offsets = self.state.positions - np.asarray(self.setup.obstacle.position)
        offsets = offsets - np.outer(offsets @ axis, axis)
        touching = np.flatnonzero(self.state.touching[0])
        if touching.size < 2:
            return 0.0
        part = offsets[touching[0] : touching[-1] + 1]
        sines = np.cross(part[:-1], part[1:]) @ axis
        cosines = np.einsum("ij,ij->i", part[:-1], part[1:])
        return float(abs(np.sum(np.arctan2(sines, cosines))) / (2.0 * np.pi))

    @property
    def tip_gap(self) -> float:
        """Distance between the tip's surface and the object's [m]."""
        return float(self.state.gaps[0, -1])

    @property
    def largest_gap(self) -> float:
        """Largest distance to the object between the first touch and the tip [m].

        Infinite where nothing touches.
        """
        touching = np.flatnonzero(self.state.touching[0])
        return float(self.state.gaps[0, touching[0] :].max()) if touching.size else math.inf

    @property
    def base_reaction(self) -> Array:
        """Force [N] and moment [N m] with which the mount holds the gripper (6,), base frame."""
        return self.state.base_reaction


def wraps(state: RodState) -> bool:
    """Return whether more than a few elements touch: contact that can be lost.

    An element touches with both ends. A node that touches alone is a point where tube and object
    cross: on more elements it stands for less of the tube.
    """
    touching = state.touching[0]
    return int((touching[:-1] & touching[1:]).sum()) > FEWEST_TOUCHING * (len(touching) - 1)
