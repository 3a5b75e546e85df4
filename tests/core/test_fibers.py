# SPDX-License-Identifier: Apache-2.0
"""Kinematics of the two families: their defining property, closed forms, and singular corners."""

from __future__ import annotations

import cmath
import math

import pytest
from core.actuator_cases import degrees, fiber_pairs, fractions, repeatable
from hypothesis import given
from hypothesis import strategies as st

from spiral_core import ActuationLimitError, FiberAngles
from spiral_core.actuator.fibers import fiber_derivatives, fiber_state, locking_stretch
from spiral_core.errors import ActuationLimit

STRETCHES = [1.0, 1.0 + 1e-9, 1.05, 1.3, 1.9]


def stretch_at(fibers: FiberAngles, fraction: float) -> float:
    """Return the stretch at a fraction of the way from rest to just below locking."""
    return 1.0 + (locking_stretch(fibers) - 1.0) * min(fraction, 1.0 - 1e-14)


def textbook(fibers: FiberAngles, stretch: complex) -> tuple[complex, complex]:
    """Return hoop stretch and shear from the formulas as they are written, also complex."""
    alpha, beta = fibers.alpha, fibers.beta
    a = math.copysign(1.0, alpha) * cmath.sqrt(1.0 - (stretch * math.cos(alpha)) ** 2)
    b = math.copysign(1.0, beta) * cmath.sqrt(1.0 - (stretch * math.cos(beta)) ** 2)
    crossing = math.sin(alpha - beta)
    return (
        (a * math.cos(beta) - b * math.cos(alpha)) / crossing,
        (b * math.sin(alpha) - a * math.sin(beta)) / crossing,
    )


@repeatable
@given(fibers=fiber_pairs, fraction=fractions)
def test_both_families_keep_their_length_and_sense(fibers: FiberAngles, fraction: float) -> None:
    stretch = stretch_at(fibers, fraction)
    state = fiber_state(fibers, stretch)
    shear = state.hoop_stretch * state.twist
    # Rounding is magnified by the division by sin(alpha - beta).
    tolerance = 8e-16 * (1.0 + state.hoop_stretch + abs(shear))
    tolerance /= abs(math.sin(fibers.alpha - fibers.beta))
    for angle in (fibers.alpha, fibers.beta):
        axial = stretch * math.cos(angle)
        hoop = state.hoop_stretch * math.sin(angle) + shear * math.cos(angle)
        assert abs(axial**2 + hoop**2 - 1.0) <= 4.0 * tolerance
        assert hoop * math.copysign(1.0, angle) > -tolerance


@repeatable
@given(fibers=fiber_pairs, fraction=fractions)
def test_wall_keeps_its_volume(fibers: FiberAngles, fraction: float) -> None:
    state = fiber_state(fibers, stretch_at(fibers, fraction))
    product = state.stretch * state.hoop_stretch * state.radial_stretch
    assert product == pytest.approx(1.0, rel=1e-15)


@pytest.mark.parametrize("beta", [10.0, 30.0, 50.0, 70.0, 89.0])
@pytest.mark.parametrize("fraction", [1e-9, 0.1, 0.5, 0.9, 0.999999])
def test_hoop_family_gives_the_closed_form(beta: float, fraction: float) -> None:
    fibers = degrees(90.0, beta)
    stretch = stretch_at(fibers, fraction)
    state = fiber_state(fibers, stretch)
    secant, tangent = 1.0 / math.cos(fibers.beta), math.tan(fibers.beta)
    assert state.hoop_stretch == pytest.approx(1.0, rel=1e-14)
    # The closed form itself cancels near rest, and its root near locking by rounding of the secant.
    closed = math.sqrt((secant - stretch) * (secant + stretch)) - tangent
    rounding = 1e-15 * (tangent + secant**2 / (closed + tangent))
    assert state.twist == pytest.approx(closed, rel=1e-12, abs=rounding)


@pytest.mark.parametrize("degrees_off", [1e-3, 1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize("stretch", STRETCHES)
def test_hoop_family_is_approached_smoothly(degrees_off: float, stretch: float) -> None:
    near, at = (fiber_state(degrees(90.0 - off, 60.0), stretch) for off in (degrees_off, 0.0))
    # First order in the angle: 1 degree is 0.017 rad, times a factor of order 10 near locking.
    assert near.hoop_stretch == pytest.approx(at.hoop_stretch, abs=0.2 * degrees_off + 1e-15)
    assert near.twist == pytest.approx(at.twist, abs=0.2 * degrees_off + 1e-15)


@repeatable
@given(fibers=fiber_pairs, fraction=st.floats(1e-3, 0.99))
def test_jet_agrees_with_the_textbook_formulas(fibers: FiberAngles, fraction: float) -> None:
    stretch = stretch_at(fibers, fraction)
    derivatives = fiber_derivatives(fibers, stretch)
    # The textbook cancels near rest and for near families; its derivative by a complex step.
    # Next to locking the last bit of the stretch counts.
    largest = 1.0 + max(map(abs, derivatives))
    scale = largest * (1e-13 + 1e-15 / (locking_stretch(fibers) - stretch))
    scale /= abs(math.sin(fibers.alpha - fibers.beta))
    hoop, shear = textbook(fibers, stretch)
    step = 1e-200
    hoop_step, shear_step = textbook(fibers, complex(stretch, step))
    assert derivatives.hoop == pytest.approx(hoop.real, rel=1e-11, abs=scale)
    assert derivatives.shear == pytest.approx(shear.real, rel=1e-11, abs=scale)
    assert derivatives.hoop_prime == pytest.approx(hoop_step.imag / step, rel=1e-11, abs=scale)
    assert derivatives.shear_prime == pytest.approx(shear_step.imag / step, rel=1e-11, abs=scale)


@repeatable
@given(fibers=fiber_pairs)
def test_slopes_at_rest_are_products_and_sums_of_cotangents(fibers: FiberAngles) -> None:
    derivatives = fiber_derivatives(fibers, 1.0)
    cot_alpha, cot_beta = 1.0 / math.tan(fibers.alpha), 1.0 / math.tan(fibers.beta)
    size = abs(cot_alpha) + abs(cot_beta)
    rounding = 1e-14 * (1.0 + size) ** 2 / abs(math.sin(fibers.alpha - fibers.beta))
    assert (derivatives.hoop, derivatives.shear) == (1.0, 0.0)
    assert derivatives.hoop_prime == pytest.approx(cot_alpha * cot_beta, rel=1e-11, abs=rounding)
    assert derivatives.shear_prime == pytest.approx(
        -(cot_alpha + cot_beta), rel=1e-11, abs=rounding
    )


@pytest.mark.parametrize("elongation", [1e-15, 1e-12, 1e-9, 1e-6])
def test_nothing_cancels_near_rest(elongation: float) -> None:
    fibers = degrees(88.0, 60.0)
    stretch = 1.0 + elongation
    exact_elongation = stretch - 1.0  # what the float can hold
    rest = fiber_derivatives(fibers, 1.0)
    # (2) with A'' = -cos^2 / sin^3 at rest.
    sin_alpha, sin_beta = math.sin(fibers.alpha), math.sin(fibers.beta)
    bend_a, bend_b = -(math.cos(fibers.alpha) ** 2), -(math.cos(fibers.beta) ** 2)
    second = bend_b * sin_alpha / sin_beta**3 - bend_a * sin_beta / sin_alpha**3
    second /= math.sin(fibers.alpha - fibers.beta)
    linear = rest.shear_prime * exact_elongation
    series = linear + 0.5 * second * exact_elongation**2
    assert fiber_derivatives(fibers, stretch).shear == pytest.approx(series, rel=1e-11)


@pytest.mark.parametrize("fibers", [degrees(90, 60), degrees(88, -30), degrees(40, 60)], ids=repr)
def test_locking_is_where_a_fiber_lies_along_the_axis(fibers: FiberAngles) -> None:
    locking = locking_stretch(fibers)
    smaller = min(abs(fibers.alpha), abs(fibers.beta))
    assert locking * math.cos(smaller) == pytest.approx(1.0, rel=1e-15)
    fiber_state(fibers, locking * (1.0 - 1e-15))
    for past in (locking * (1.0 + 1e-15), 2.0 * locking, 1e100):
        with pytest.raises(ActuationLimitError, match="locks") as caught:
            fiber_state(fibers, past)
        assert caught.value.limit is ActuationLimit.FIBER_LOCKING
        assert (caught.value.value, caught.value.bound) == (past, locking)
