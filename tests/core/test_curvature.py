# SPDX-License-Identifier: Apache-2.0
"""Both forms against geometry: the straight fiber's length, measured on the bent tube."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from core.actuator_cases import LATEX, PAPER_TUBE, actuator, extending_pairs, repeatable
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from spiral_core import ActuationLimitError, Actuator, CurvatureForm, PressureLaw
from spiral_core.actuator.actuator import UnloadedShape
from spiral_core.actuator.curvature import unloaded_shape_from_stretch
from spiral_core.actuator.fibers import FiberAngles, fiber_state
from spiral_core.errors import ActuationLimit
from spiral_core.wrap.helix import Helix

EXACT = CurvatureForm.EXACT
CASES = [(88.0, 50.0, 1.2, None), (90.0, 60.0, 1.15, 5.5e-3), (88.0, -70.0, 1.3, 3.0e-3)]


def length_of_offset_fiber(shape: UnloadedShape, radius: float) -> float:
    """Return the length of the curve at ``radius`` along y of the material frame, by integration.

    Frame, centerline and fiber length are integrated together from the strain vector
    (torsion, 0, curvature) alone; no closed form of the helix takes part.
    """

    def rates(_: float, state: np.ndarray) -> np.ndarray:
        frame = state[:9].reshape(3, 3)  # columns x, y, z in the base frame
        tau, kappa = shape.torsion, shape.curvature
        skew = np.array([[0.0, -kappa, 0.0], [kappa, 0.0, -tau], [0.0, tau, 0.0]])
        turning = frame @ skew
        fiber_rate = frame[:, 0] + radius * turning[:, 1]
        return np.concatenate([turning.ravel(), [np.linalg.norm(fiber_rate)]])

    start = np.concatenate([np.eye(3).ravel(), [0.0]])
    result = solve_ivp(
        rates, (0.0, shape.backbone_length), start, method="DOP853", rtol=1e-12, atol=1e-13
    )
    return float(result.y[9, -1])


def length_of_inner_helix(shape: UnloadedShape, radius: float) -> float:
    """Return the length of the helix of equal pitch whose radius is smaller by ``radius``."""
    rate = math.hypot(shape.curvature, shape.torsion)
    helix_radius, rise = shape.curvature / rate**2, shape.torsion / rate**2  # per radian
    turned = rate * shape.backbone_length
    return turned * math.hypot(helix_radius - radius, rise)


@pytest.mark.parametrize(("alpha", "beta", "stretch", "radius"), CASES)
def test_exact_form_keeps_the_fibers_length(
    alpha: float, beta: float, stretch: float, radius: float | None
) -> None:
    case = actuator(alpha, beta, straight_fiber_radius=radius, curvature_form=EXACT)
    shape = unloaded_shape_from_stretch(case, stretch)
    assert shape.backbone_length == stretch * PAPER_TUBE.length
    assert length_of_inner_helix(shape, case.fiber_radius) == pytest.approx(
        PAPER_TUBE.length, rel=1e-13
    )
    # The integrator's tolerance.
    assert length_of_offset_fiber(shape, case.fiber_radius) == pytest.approx(
        PAPER_TUBE.length, rel=1e-10
    )


@repeatable
@given(
    beta=st.floats(30.0, 80.0),
    fraction=st.one_of(st.floats(1e-6, 0.3), st.sampled_from([1e-12, 1e-9])),
    radius=st.floats(2.0e-3, 5.0e-3),
)
def test_exact_form_keeps_the_fibers_length_near_rest_too(
    beta: float, fraction: float, radius: float
) -> None:
    case = actuator(88.0, beta, straight_fiber_radius=radius, curvature_form=EXACT)
    stretch = 1.0 + fraction * (1.0 / math.cos(math.radians(beta)) - 1.0)
    shape = unloaded_shape_from_stretch(case, stretch)
    # A unit of fiber inside the bent tube: shorter by the bend, longer by the twist.
    along = 1.0 - shape.curvature * radius
    assert stretch * math.hypot(along, radius * shape.torsion) == pytest.approx(1.0, rel=1e-14)


def test_first_order_form_misses_the_fibers_length_by_second_order() -> None:
    misses = []
    for elongation in (0.02, 0.01, 0.005):
        shape = unloaded_shape_from_stretch(actuator(90.0, 60.0), 1.0 + elongation)
        stretched = dataclasses.replace(
            shape,
            curvature=shape.curvature / (1.0 + elongation),
            torsion=shape.torsion / (1.0 + elongation),
            backbone_length=shape.backbone_length * (1.0 + elongation),
        )
        length = length_of_inner_helix(stretched, PAPER_TUBE.inner_radius)
        misses.append(abs(length / PAPER_TUBE.length - 1.0))
    orders = np.log2(np.array(misses[:-1]) / np.array(misses[1:]))
    # The observed order tends to 2 as the elongation halves.
    np.testing.assert_allclose(orders, 2.0, atol=0.05)


@pytest.mark.parametrize("beta", [50.0, 60.0, 70.0])
def test_forms_agree_to_first_order(beta: float) -> None:
    differences = []
    for elongation in (4e-4, 2e-4, 1e-4):
        first, exact = (
            unloaded_shape_from_stretch(actuator(88.0, beta, curvature_form=form), 1.0 + elongation)
            for form in CurvatureForm
        )
        differences.append(abs(exact.curvature / first.curvature - 1.0) / elongation)
        # Per deformed length, hence the stretch between the two.
        assert exact.torsion * (1.0 + elongation) == pytest.approx(first.torsion, rel=1e-14)
    # The relative difference is proportional to the elongation: its slope is constant.
    assert differences == pytest.approx([differences[0]] * 3, rel=2e-3)


def test_forms_differ_at_working_stretch_as_documented() -> None:
    first, exact = (
        unloaded_shape_from_stretch(actuator(88.0, 60.0, curvature_form=form), 1.1)
        for form in CurvatureForm
    )
    coil, exact_coil = (Helix(shape.curvature, shape.torsion) for shape in (first, exact))
    turns = coil.turns(first.backbone_length), exact_coil.turns(exact.backbone_length)
    assert round(100.0 * (exact.curvature / first.curvature - 1.0)) == -7
    assert round(100.0 * (exact_coil.radius / coil.radius - 1.0)) == 9
    assert round(1000.0 * (turns[1] / turns[0] - 1.0)) == 15


def test_first_order_form_by_hand() -> None:
    shape = unloaded_shape_from_stretch(actuator(90.0, 60.0, straight_fiber_radius=5.0e-3), 1.1)
    twist = math.sqrt(4.0 - 1.1**2) - math.sqrt(3.0)
    assert shape.curvature == pytest.approx(0.1 / 5.0e-3, rel=1e-14)
    assert shape.torsion == pytest.approx(twist / PAPER_TUBE.inner_radius, rel=1e-12)
    assert shape.backbone_length == PAPER_TUBE.length
    assert shape.stretch == 1.1


@pytest.mark.parametrize("form", CurvatureForm)
def test_rest_is_straight(form: CurvatureForm) -> None:
    shape = unloaded_shape_from_stretch(actuator(curvature_form=form), 1.0)
    assert shape == UnloadedShape(0.0, 0.0, PAPER_TUBE.length, 1.0)


@repeatable
@given(fibers=extending_pairs, fraction=st.floats(1e-9, 0.2), form=st.sampled_from(CurvatureForm))
def test_mirrored_fibers_mirror_the_coil(
    fibers: FiberAngles, fraction: float, form: CurvatureForm
) -> None:
    case = Actuator(PAPER_TUBE, fibers, LATEX, 1.0e-3, form, pressure_law=PressureLaw.UNIFORM)
    stretch = 1.0 + fraction * (1.0 / math.cos(min(abs(fibers.alpha), abs(fibers.beta))) - 1.0)
    if (
        form is EXACT
        and abs(fiber_state(fibers, stretch).twist) * 1.0e-3 >= PAPER_TUBE.inner_radius
    ):
        return
    shape = unloaded_shape_from_stretch(case, stretch)
    mirrored = dataclasses.replace(case, fibers=fibers.mirrored())
    assert unloaded_shape_from_stretch(mirrored, stretch) == dataclasses.replace(
        shape, torsion=-shape.torsion
    )


@pytest.mark.parametrize("form", CurvatureForm)
@pytest.mark.parametrize("beta", [20.0, 50.0, 70.0])
def test_positive_beta_coils_left_handed(form: CurvatureForm, beta: float) -> None:
    shape = unloaded_shape_from_stretch(actuator(88.0, beta, curvature_form=form), 1.05)
    assert shape.curvature > 0.0
    assert shape.torsion < 0.0


def test_twist_can_use_up_the_straight_fiber() -> None:
    case = actuator(90.0, 70.0, curvature_form=EXACT)
    locking = math.sqrt(2.0 * math.tan(math.radians(70.0)))  # where |omega| = 1
    assert unloaded_shape_from_stretch(case, locking - 1e-9).curvature > 0.0
    with pytest.raises(ActuationLimitError, match="straight fiber is too short") as caught:
        unloaded_shape_from_stretch(case, locking + 1e-9)
    assert caught.value.limit is ActuationLimit.STRAIGHT_FIBER_LOCKING
    assert caught.value.quantity == "twist"
    assert caught.value.bound == 1.0


def test_locked_fibers_have_no_shape() -> None:
    with pytest.raises(ActuationLimitError) as caught:
        unloaded_shape_from_stretch(actuator(88.0, 60.0), 2.0001)
    assert caught.value.limit is ActuationLimit.FIBER_LOCKING
