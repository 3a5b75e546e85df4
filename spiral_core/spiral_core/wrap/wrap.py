# SPDX-License-Identifier: Apache-2.0
r"""The perfect wrap: the cylinder that a gripper fits at a pressure.

At the perfect wrap the whole length touches the object and the tip, which carries no moment, has
the curvature of the free shape; its tangent makes the angle :math:`\theta` with the object's axis,
so that

.. math:: r_w(P) = \sin^2\theta_\mathrm{end}(P) / \kappa(P) - r_o

(derived in ``docs/derivations/wrap.md``).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from functools import cached_property

import numpy as np

from spiral_core.actuator.actuator import UnloadedShape
from spiral_core.actuator.tube import Tube
from spiral_core.brief import brief_repr
from spiral_core.rod.state import RodState
from spiral_core.rod.types import Section, Vector
from spiral_core.validation import require_finite, require_positive
from spiral_core.wrap.coil import LEAST_SINE, Coil, coil_from_state
from spiral_core.wrap.gripper import Gripper

# A radius within this fraction of the perfect one still counts as a perfect wrap: the scatter of
# the paper's prototypes and of an estimated radius is no finer.
PERFECT_BAND = 0.02


class WrapRegime(Enum):
    """How a gripper at some pressure holds an object (the paper's Fig. 4)."""

    OVERHANG = "overhang"
    PERFECT_WRAP = "perfect wrap"
    CURLING = "curling"


@dataclass(frozen=True, eq=False)
class Wrap:
    """A gripper coiled by one pressure, and the cylinder it fits.

    Properties that follow from the shape are computed at first use, because a control loop needs
    the pressure first; the class therefore has no slots.

    Args:
        pressure: gauge pressure [Pa].
        object_radius: radius of the cylinder that it wraps perfectly [m].
        unloaded_shape: the unloaded shape.
        state: the shape, with its certificate.
        axis: of that cylinder, a unit vector that points the way the coil advances.
        turns_required: turns about the object that count as a wrap.
        tube: of the gripper.
    """

    __repr__ = brief_repr

    pressure: float
    object_radius: float
    unloaded_shape: UnloadedShape
    state: RodState
    axis: Vector
    turns_required: float
    tube: Tube

    @property
    def outer_radius(self) -> float:
        """Of the gripper's tube [m]."""
        return self.tube.outer_radius

    @cached_property
    def coil(self) -> Coil:
        """Turns and advance along the rod."""
        return coil_from_state(self.state, self.axis)

    @property
    def turns(self) -> float:
        """Turns of the whole length about the object's axis."""
        return self.coil.total_turns

    @property
    def helix_angle(self) -> float:
        """Angle between the tip's tangent and that axis [rad]."""
        return self.coil.helix_angle

    @cached_property
    def gripper_length_needed(self) -> float | None:
        """Unstretched length of gripper that makes the required turns, counted from the tip [m].

        None if it makes fewer.
        """
        needed = self.coil.length_for_turns(self.turns_required)
        return needed and needed * self.tube.length / self.unloaded_shape.backbone_length

    @cached_property
    def object_length_needed(self) -> float | None:
        """Object length that those turns cover [m]; None if the gripper makes fewer."""
        return self.coil.advance_for_turns(self.turns_required)

    @cached_property
    def turn_count_margin(self) -> float:
        """How far the tangent's sine, where it turns back, is above the least that counts.

        At the place that comes nearest to it; infinite without any. Where this passes zero the
        turns change in a leap.
        """
        along = self.state.tangents @ np.asarray(self.axis)
        sines = np.sqrt(np.maximum(1.0 - along * along, 0.0))
        inner = sines[1:-1]
        lowest = inner[(inner <= sines[:-2]) & (inner <= sines[2:])] - LEAST_SINE * sines[-1]
        return float(lowest[np.abs(lowest).argmin()]) if lowest.size else math.inf

    @property
    def contact_length(self) -> float:
        """Length of gripper on its cylinder [m]: all of it, which is what perfect wrap means."""
        return self.unloaded_shape.backbone_length


def wrapped_radius(gripper: Gripper, shape: UnloadedShape, state: RodState) -> tuple[float, Vector]:
    """Return r_w [m] of a gripper in some state, and the object's axis (unit vector).

    Args:
        gripper: the gripper.
        shape: its unloaded shape at the pressure in question.
        state: its shape there.
    """
    # Compile only when a wrap is asked for.
    from spiral_core.wrap._kernels import FITTED, fitted_radius

    axis = gripper.object_axis
    return fitted_radius(
        np.array(state.orientations),
        np.array(state.strains),
        np.array(state.positions[-1]),
        float(shape.backbone_length),
        (float(shape.torsion), 0.0, float(shape.curvature)),
        FITTED if axis is None else (float(axis[0]), float(axis[1]), float(axis[2])),
        float(gripper.tube.outer_radius),
    )


def line_force(
    stiffness: Section,
    shape: UnloadedShape,
    radius: float,
    helix_angle: float,
    outer_radius: float,
) -> float:
    r"""Return the force per length [N/m] of a uniform coil on a cylinder; negative lifts off.

    .. math:: q = [m_z \sin^2\theta + m_x \sin\theta \cos\theta] / \rho^2, \quad
        m_z = EI (\kappa - \kappa_c) + C (\tau - \tau_c), \quad
        m_x = GJ (\tau - \tau_c) + C (\kappa - \kappa_c), \quad \rho = r_w + r_o

    with the coupling C, and :math:`\kappa_c = \sin^2\theta/\rho` and
    :math:`\tau_c = \pm\sin\theta\cos\theta/\rho` of the free shape's hand: the derivative of the
    energy per length by the radius (our derivation; the paper gives no force model). Zero at the
    perfect wrap of the unloaded helix.

    Args:
        stiffness: of the rod.
        shape: the unloaded shape at the pressure in question.
        radius: of the object [m].
        helix_angle: between tangent and axis on the object [rad].
        outer_radius: of the gripper's tube [m].

    Raises:
        InvalidInputError: a radius is not positive and finite, or the angle not finite.
    """
    require_positive("radius", radius)
    require_finite("helix_angle", helix_angle)
    require_positive("outer_radius", outer_radius)
    rho = radius + outer_radius
    sine, cosine = math.sin(helix_angle), abs(math.cos(helix_angle))
    # Mirrored to the right hand, where the coupling has the other sign.
    coupling = math.copysign(stiffness.coupling, stiffness.coupling * shape.torsion)
    bent = shape.curvature - sine * sine / rho
    twisted = abs(shape.torsion) - sine * cosine / rho
    bending = (stiffness.bending * bent + coupling * twisted) * sine * sine
    twisting = (stiffness.torsional * twisted + coupling * bent) * sine * cosine
    return (bending + twisting) / (rho * rho)
