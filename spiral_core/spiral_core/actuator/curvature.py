# SPDX-License-Identifier: Apache-2.0
r"""Curvature and torsion from stretch and twist, by the constraint of the straight fiber.

The straight fiber, at distance :math:`r_f` from the axis, keeps its length L while the tube around
it stretches and twists. Two forms, chosen by :class:`spiral_core.CurvatureForm`:

``FIRST_ORDER`` (as the paper's numbers suggest), on a backbone of length L:

.. math:: \kappa = \frac{\lambda_1 - 1}{r_f}, \qquad \tau = \frac{\omega}{r}

``EXACT``, on the centerline of length :math:`\lambda_1 L`, from the length of a curve at distance
:math:`r_f` inside a helix:

.. math:: \kappa = \frac{\lambda_1 - \sqrt{1 - (\omega r_f / r)^2}}{\lambda_1 r_f}, \qquad
    \tau = \frac{\omega}{\lambda_1 r}

They agree to first order in the stretch; ``docs/derivations/actuator.md`` derives both.
"""

from __future__ import annotations

import math

from spiral_core.actuator.actuator import Actuator, CurvatureForm, PressureLaw, UnloadedShape
from spiral_core.actuator.fibers import fiber_state, locking_stretch
from spiral_core.actuator.section import ShapePath, section_path
from spiral_core.errors import ActuationLimit, ActuationLimitError, InvalidInputError
from spiral_core.validation import require_finite


def unloaded_shape_from_stretch(actuator: Actuator, stretch: float) -> UnloadedShape:
    r"""Return the unloaded shape of an actuator at an axial stretch.

    The curvature points at the straight fiber, which is fixed in the wall, so the torsion of the
    centerline is the rate at which the wall twists. With ``beta`` > 0 next to an ``alpha`` near
    90 degrees, extension unwinds the fibers: twist and torsion are negative (a left-handed coil).

    Args:
        actuator: the actuator.
        stretch: axial stretch, >= 1: a fiber can pull but not push.

    Returns:
        Curvature and torsion per length of the backbone, and that backbone's length.

    Raises:
        InvalidInputError: ``stretch`` is below 1 or not finite.
        ActuationLimitError: a wound fiber locks, or (``EXACT``) the twist alone uses up the
            length of the straight fiber: \|omega\| r_f / r >= 1.

    Source: ``docs/derivations/actuator.md``, "Curvature and torsion".

    Example:
        >>> from spiral_core import FiberAngles, NeoHookean, Tube
        >>> actuator = Actuator(
        ...     tube=Tube(inner_radius=5.0e-3, wall_thickness=1.0e-3, length=0.5),
        ...     fibers=FiberAngles(alpha=math.radians(90.0), beta=math.radians(60.0)),
        ...     material=NeoHookean(c1=145.0e3),
        ... )
        >>> shape = unloaded_shape_from_stretch(actuator, stretch=1.1)
        >>> round(shape.curvature, 6), round(shape.torsion, 6), shape.backbone_length
        (20.0, -12.3443, 0.5)
    """
    if not require_finite("stretch", stretch) >= 1.0 and actuator.single_fibers:
        raise InvalidInputError("stretch", stretch, "at least 1 (a fiber cannot push)")
    exact = actuator.curvature_form is CurvatureForm.EXACT
    if exact and actuator.pressure_law is PressureLaw.SECTION:
        limit = longest_stretch(actuator)  # refuses one family, whose shape is the elastomer's too
        path = section_path(actuator.fiber_set)
        change = (stretch - 1.0) * path.direction
        if not change >= 0.0:
            side = "at least" if path.direction > 0.0 else "at most"
            raise InvalidInputError("stretch", stretch, f"{side} 1 for these fibers")
        if not change <= abs(limit - 1.0):
            raise ActuationLimitError(path.limit, "stretch", stretch, limit)
        return shape_on_path(actuator, path, path.strain_from_stretch(stretch))
    state = fiber_state(actuator.fiber_pair, stretch)
    carried = stretch if exact else 1.0
    return UnloadedShape(
        even_curvature(actuator, stretch, state.twist) / carried,
        state.twist / (actuator.wound_radius * carried),
        carried * actuator.tube.length,
        stretch,
    )


def shape_on_path(actuator: Actuator, path: ShapePath, size: float) -> UnloadedShape:
    """Return the unloaded shape at a size, on a backbone that stretches in the exact form.

    Args:
        actuator: whose fibers the path belongs to.
        path: its shapes.
        size: of the deformation, at most the path's limit.
    """
    stretch = path.stretch_at(size)
    carried = stretch if actuator.curvature_form is CurvatureForm.EXACT else 1.0
    scale = 1.0 / (actuator.wound_radius * carried)
    return UnloadedShape(
        curvature=size * path.curvature(size) * scale,
        torsion=(path.fibers.single_slope + size * path.torsion(size)) * scale,
        backbone_length=carried * actuator.tube.length,
        stretch=stretch,
    )


def longest_stretch(actuator: Actuator) -> float:
    """Return the stretch at which the fibers alone, whatever the elastomer, end the shapes.

    Raises:
        InvalidInputError: it has one wound family.
    """
    pair = actuator.fiber_pair
    exact = actuator.curvature_form is CurvatureForm.EXACT
    if not (exact and actuator.pressure_law is PressureLaw.SECTION):
        return locking_stretch(pair)
    path = section_path(actuator.fiber_set)
    return path.stretch_at(path.strain_limit)


def even_curvature(actuator: Actuator, stretch: float, twist: float) -> float:
    r"""Return the curvature of an evenly stretched wall per unstretched length [1/m].

    In the exact form :math:`(\lambda_1 - \sqrt{1 - x^2}) / r_f` with :math:`x = \omega r_f / r`,
    free of cancellation; 0 without single fibers.

    Raises:
        ActuationLimitError: the twist alone uses up the straight fiber's length.
    """
    if not actuator.single_fibers:
        return 0.0
    if actuator.curvature_form is CurvatureForm.FIRST_ORDER:
        return (stretch - 1.0) / actuator.fiber_radius
    radius_ratio = actuator.fiber_radius / actuator.tube.inner_radius
    x = twist * radius_ratio
    remaining = (1.0 - x) * (1.0 + x)
    if not remaining > 0.0:
        raise ActuationLimitError(
            ActuationLimit.STRAIGHT_FIBER_LOCKING, "twist", abs(twist), 1.0 / radius_ratio
        )
    return ((stretch - 1.0) + x * x / (1.0 + math.sqrt(remaining))) / actuator.fiber_radius
