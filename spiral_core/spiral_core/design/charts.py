# SPDX-License-Identifier: Apache-2.0
"""Data of charts: the paper's design space, the effect of gravity, pressure against radius."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from spiral_core.actuator.actuator import Actuator, UnloadedShape
from spiral_core.actuator.curvature import longest_stretch, unloaded_shape_from_stretch
from spiral_core.actuator.fibers import FiberAngles
from spiral_core.actuator.tube import Tube
from spiral_core.brief import brief_repr
from spiral_core.errors import InvalidInputError, SpiralError
from spiral_core.grip.setup import lay_into_coil
from spiral_core.grip.window import grip_window
from spiral_core.numerics.tasks import Progress, in_turn
from spiral_core.rod.types import Array
from spiral_core.validation import require_finite, require_positive
from spiral_core.wrap.curve import WrapCurve
from spiral_core.wrap.gripper import Gripper
from spiral_core.wrap.helix import Helix

# A curve ends this fraction of the elongation before a fiber locks, where torsion diverges.
SHORT_OF_LOCKING = 1e-3
# At rest everything is infinite: a curve begins at this strain.
LEAST_STRAIN = 0.01
# Objects on which the gripper is closed for a chart: a second of computing each.
CONTACT_POINTS = 21


@dataclass(frozen=True, slots=True, eq=False)
class DesignSpace:
    """One angle's curves of the paper's design space (its Fig. 5 a to c), by the helix model.

    Args:
        fiber_angle_beta: [rad].
        stretch: (n,) axial stretch lambda_1.
        radius_ratio: (n,) object radius over tube radius, r_w / r.
        object_length_ratio: (n,) object length over tube radius.
        length_ratio: (n,) gripper length over tube radius, L / r.
    """

    __repr__ = brief_repr

    fiber_angle_beta: float
    stretch: Array
    radius_ratio: Array
    object_length_ratio: Array
    length_ratio: Array


@dataclass(frozen=True, slots=True, eq=False)
class PressureRange:
    """Radius and lengths of the perfect wrap against pressure.

    Args:
        pressure: (n,) gauge pressure [Pa].
        radius: (n,) radius wrapped perfectly [m]; NaN where it does not coil.
        gripper_length: (n,) unstretched length that makes the required turns [m]; NaN likewise.
        object_length: (n,) object length that those turns cover [m]; NaN likewise.
    """

    __repr__ = brief_repr

    pressure: Array
    radius: Array
    gripper_length: Array
    object_length: Array


@dataclass(frozen=True, slots=True, eq=False)
class RegimeChart:
    """Pressure against object radius: the tip criterion's, and the window of contact.

    Args:
        radius: (n,) object radius [m], falling.
        tip: (n,) pressure of the tip criterion [Pa]; NaN in a gap of the grippable range.
        pressure_max: the gripper's limit [Pa].
        onset_wrap, onset_curling, loss: (n,) where the wrap begins, curls and is lost by contact
            [Pa], NaN where it does not; None where no contact was computed.
    """

    __repr__ = brief_repr

    radius: Array
    tip: Array
    pressure_max: float
    onset_wrap: Array | None = None
    onset_curling: Array | None = None
    loss: Array | None = None


def design_space(
    actuator: Actuator,
    fiber_angles_beta: Sequence[float],
    turns_required: float = 1.0,
    stretch_max: float = 1.5,
    points: int = 101,
) -> tuple[DesignSpace, ...]:
    """Return the paper's three charts for several angles of the second family.

    The helix model knows no material: only ratios and angles of ``actuator`` count.

    Args:
        actuator: tube, first angle and form of the curvature; its second angle is replaced.
        fiber_angles_beta: one curve each [rad].
        turns_required: n, for lengths.
        stretch_max: where the curves end, unless a fiber locks before; above 1.01.
        points: of each curve.

    Raises:
        InvalidInputError: an angle or the stretch is out of range.
        ActuationLimitError: the straight fiber locks (``EXACT``) before ``stretch_max``.
    """
    require_positive("turns_required", turns_required)
    if not require_finite("stretch_max", stretch_max) > 1.0 + LEAST_STRAIN:
        raise InvalidInputError("stretch_max", stretch_max, f"above {1.0 + LEAST_STRAIN:g}")
    spaces = []
    for beta in fiber_angles_beta:
        angled = replace(actuator, fibers=FiberAngles(actuator.fiber_pair.alpha, beta))
        locking, tube = longest_stretch(angled), actuator.tube
        end = min(stretch_max, locking - SHORT_OF_LOCKING * (locking - 1.0))
        stretches = np.linspace(1.0 + LEAST_STRAIN, end, points)
        shapes = [unloaded_shape_from_stretch(angled, stretch) for stretch in stretches.tolist()]
        figures = _helix_figures(shapes, tube, turns_required)
        radius, length, object_length = (figure / tube.inner_radius for figure in figures)
        spaces.append(DesignSpace(beta, stretches, radius, object_length, length))
    return tuple(spaces)


def pressure_range(gripper: Gripper, points: int = 61) -> PressureRange:
    """Return radius, gripper length and object length against pressure, over the whole range.

    Where the gripper makes fewer than the required turns the figures are NaN: they do not exist.

    Args:
        gripper: as it is mounted; :func:`helix_range` is the comparison.
        points: of the chart.

    Raises:
        NoCoilError: it nowhere makes the required turns.
        SolverError: a shape could not be certified.
    """
    curve = WrapCurve(gripper)
    pressures = np.linspace(curve.pressure_min, curve.pressure_max, points)
    wraps = [curve.wrap_at_pressure(float(p)) for p in pressures]
    return PressureRange(
        pressure=pressures,
        radius=np.array([wrap.object_radius for wrap in wraps]),
        gripper_length=_or_nan([wrap.gripper_length_needed for wrap in wraps]),
        object_length=_or_nan([wrap.object_length_needed for wrap in wraps]),
    )


def helix_range(gripper: Gripper, pressures: Array) -> PressureRange:
    """Return the same by the helix model: no gravity, closed form.

    Args:
        gripper: whose mount does not matter.
        pressures: (n,) gauge pressures [Pa], > 0.

    Raises:
        InvalidInputError: a pressure is not in (0, ``pressure_max``].
    """
    shapes = [gripper.unloaded_shape(require_positive("pressure", float(p))) for p in pressures]
    figures = _helix_figures(shapes, gripper.tube, gripper.turns_required)
    return PressureRange(np.asarray(pressures, dtype=np.float64), *figures)


def _helix_figures(
    shapes: Sequence[UnloadedShape], tube: Tube, turns: float
) -> tuple[Array, Array, Array]:
    """Return radius, unstretched length and object length of some turns [m], (n,) each."""
    helices = [Helix(shape.curvature, shape.torsion) for shape in shapes]
    outer = tube.outer_radius
    rows = [
        (h.object_radius(outer), h.length_for_turns(turns), h.object_length(turns)) for h in helices
    ]
    radius, length, object_length = np.array(rows).T
    unstretched = np.array([tube.length / shape.backbone_length for shape in shapes])
    return radius, length * unstretched, object_length


def regime_chart(
    curve: WrapCurve, radius_min: float, radius_max: float, points: int = 61
) -> RegimeChart:
    """Return the tip criterion's pressure against object radius.

    Args:
        curve: of the gripper.
        radius_min: smallest object [m].
        radius_max: largest object [m].
        points: of the chart.

    Raises:
        NotGrippableError: a radius is outside the grippable range.
    """
    radii = np.linspace(radius_max, radius_min, points)
    pressures = [
        math.nan
        if any(low < radius < high for low, high in curve.gaps)
        else curve.pressure_from_radius(radius)
        for radius in radii.tolist()
    ]
    return RegimeChart(radii, np.array(pressures), curve.gripper.pressure_max)


def contact_chart(
    curve: WrapCurve,
    radius_min: float,
    radius_max: float,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> RegimeChart:
    """Return the tip criterion's pressure and contact's window against object radius.

    Args:
        curve: of the gripper, with its own friction or the default.
        radius_min: smallest object [m].
        radius_max: largest object [m].
        executor: where the windows are computed; None: one after the other, here.
        progress: called with the number of windows that are done, and the number there are.

    Raises:
        NotGrippableError: a radius is outside the grippable range.
    """
    chart = regime_chart(curve, radius_min, radius_max, CONTACT_POINTS)
    window = partial(_window, curve.gripper)
    windows = in_turn(window, chart.radius.tolist(), executor, progress)
    onset, curling, loss = np.array(list(windows)).T
    return replace(chart, onset_wrap=onset, onset_curling=curling, loss=loss)


def _window(gripper: Gripper, radius: float) -> tuple[float, float, float]:
    """Return where the wrap of a radius [m] begins, curls and is lost [Pa]; NaN where not."""
    with suppress(SpiralError):
        window = grip_window(lay_into_coil(gripper, radius))
        if window.onset_wrap is not None:
            curling, loss = _or_nan([window.onset_curling, window.loss])
            return window.onset_wrap, curling, loss
    return math.nan, math.nan, math.nan


def _or_nan(values: Sequence[float | None]) -> Array:
    return np.array(values, dtype=np.float64)  # None is not a number
