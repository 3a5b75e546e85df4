# SPDX-License-Identifier: Apache-2.0
"""The inverse to rounding over the whole branch, its limits, and that it never answers wrongly."""

from __future__ import annotations

import dataclasses
import math
import pickle

import numpy as np
import pytest
from core.actuator_cases import (
    PAPER_TUBE,
    actuator,
    extending_pairs,
    repeatable,
)
from core.reference_uniform import reference_pressure
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from spiral_core import (
    ActuationLimit,
    ActuationLimitError,
    Actuator,
    FiberAngles,
    FreeActuation,
    Gent,
    HyperelasticLaw,
    InvalidInputError,
    MooneyRivlin,
    PressureLaw,
    Yeoh,
    pressure_from_stretch,
    unloaded_shape_from_stretch,
)

LAWS: list[HyperelasticLaw] = [
    MooneyRivlin(c1=130.0e3, c2=15.0e3),
    Yeoh(c1=145.0e3, c2=-30.0e3, c3=3.0e3),
    Gent(shear_modulus=290.0e3, extension_limit=0.5),
]
# One actuator for each kind of limit.
ENDS = {
    ActuationLimit.FIBER_LOCKING: actuator(88.0, 60.0),
    ActuationLimit.VOLUME_MAXIMUM: actuator(70.0, -65.0),
    ActuationLimit.LIMIT_POINT: actuator(88.0, 70.0, LAWS[1]),
    ActuationLimit.MATERIAL_LIMIT: actuator(88.0, 70.0, LAWS[2]),
}
EPSILON = 2.0**-52


def rounding_of_pressure(case: Actuator, stretch: float) -> float:
    """Return what a few last bits of the stretch and the energy mean in pressure [Pa]."""
    return 8.0 * EPSILON * (stretch * slope(case, stretch) + abs(reference_pressure(case, stretch)))


def slope(case: Actuator, stretch: float) -> float:
    """Return dP / d lambda_1 [Pa] by a difference, outwards from rest."""
    step = 1e-9 * stretch
    behind = max(stretch - step, 1.0)
    rise = reference_pressure(case, stretch) - reference_pressure(case, behind - step)
    return rise / (stretch - behind + step)


@repeatable
@given(
    fibers=extending_pairs,
    law=st.sampled_from(LAWS),
    fraction=st.one_of(st.floats(0.0, 1.0), st.sampled_from([1e-12, 1e-6, 1 - 1e-12, 1 - 1e-6])),
)
def test_inverse_is_exact_to_rounding(
    fibers: FiberAngles, law: HyperelasticLaw, fraction: float
) -> None:
    case = Actuator(PAPER_TUBE, fibers, law, pressure_law=PressureLaw.UNIFORM)
    actuation = FreeActuation(case)
    stretch = 1.0 + fraction * (actuation.stretch_limit - 1.0)
    pressure = actuation.pressure_from_stretch(min(stretch, actuation.stretch_limit))
    found = actuation.stretch_from_pressure(pressure)
    residual = actuation.pressure_from_stretch(found) - pressure
    crossing = abs(math.sin(fibers.alpha - fibers.beta))
    assert abs(residual) <= rounding_of_pressure(case, found) / crossing


@pytest.mark.parametrize("beta", [50.0, 60.0, 70.0])
def test_round_trip_of_the_papers_pressures(beta: float) -> None:
    actuation = FreeActuation(actuator(88.0, beta))
    for pressure in np.geomspace(100.0, 400.0e3, 200):
        back = actuation.pressure_from_stretch(actuation.stretch_from_pressure(float(pressure)))
        # Rounding of the stretch alone is 2e-16 * 5e5 Pa, 1e-12 of the smallest pressure here.
        assert back == pytest.approx(pressure, rel=2e-12)


@pytest.mark.parametrize("case", ENDS.values(), ids=lambda case: repr(case.material)[:8])
def test_inverse_agrees_with_bracketing(case: Actuator) -> None:
    actuation = FreeActuation(case)
    for stretch in np.linspace(1.001, actuation.stretch_limit * 0.999, 23):
        pressure = pressure_from_stretch(case, float(stretch))
        root = brentq(
            lambda s, p=pressure: pressure_from_stretch(case, s) - p,
            1.0,
            actuation.stretch_limit,
            xtol=1e-15,
            rtol=1e-15,
        )
        # A few last bits of the pressure, over a slope that vanishes at a limit point.
        bits = 64.0 * EPSILON * pressure / slope(case, float(stretch))
        found = actuation.stretch_from_pressure(pressure)
        assert found == pytest.approx(root, rel=1e-13, abs=bits)


@pytest.mark.parametrize("limit", ENDS)
def test_limit_is_reached_and_not_passed(limit: ActuationLimit) -> None:
    actuation = FreeActuation(ENDS[limit])
    assert actuation.limit is limit
    top = actuation.pressure_limit
    assert actuation.stretch_from_pressure(top) == actuation.stretch_limit
    assert actuation.pressure_from_stretch(actuation.stretch_limit) == top
    assert actuation.unloaded_shape(top).stretch == actuation.stretch_limit
    above = math.nextafter(top, math.inf)
    for past in (above, 2.0 * top, 1e300):
        with pytest.raises(ActuationLimitError) as caught:
            actuation.unloaded_shape(past)
        assert (caught.value.limit, caught.value.quantity) == (limit, "pressure")
        assert (caught.value.value, caught.value.bound) == (past, top)
    with pytest.raises(ActuationLimitError) as caught:
        actuation.pressure_from_stretch(math.nextafter(actuation.stretch_limit, 9.0))
    assert (caught.value.limit, caught.value.quantity) == (limit, "stretch")


@pytest.mark.parametrize("limit", ENDS)
def test_stretch_rises_with_pressure_up_to_the_limit(limit: ActuationLimit) -> None:
    actuation = FreeActuation(ENDS[limit])
    top = actuation.pressure_limit
    pressures = np.concatenate(
        [np.linspace(0.0, 0.999 * top, 400), top * (1 - np.logspace(-4, -9))]
    )
    stretches = [actuation.stretch_from_pressure(float(p)) for p in pressures]
    assert stretches[0] == 1.0
    assert np.all(np.diff(stretches) > 0.0)


def test_limit_point_is_approached_as_a_square_root() -> None:
    case = ENDS[ActuationLimit.LIMIT_POINT]
    actuation = FreeActuation(case)
    h = 1e-4
    bend = -slope(case, actuation.stretch_limit - h) / h
    for missing in (1e-4, 1e-6, 1e-8):
        pressure = actuation.pressure_limit * (1.0 - missing)
        gap = actuation.stretch_limit - actuation.stretch_from_pressure(pressure)
        # Leading order only: the next is the relative gap itself, up to 1 % here.
        assert gap == pytest.approx(
            math.sqrt(2.0 * missing * actuation.pressure_limit / -bend), rel=0.02
        )


def test_rest_is_straight_and_unstretched() -> None:
    shape = FreeActuation(actuator()).unloaded_shape(0.0)
    assert (shape.curvature, shape.torsion, shape.stretch) == (0.0, 0.0, 1.0)
    assert shape.backbone_length == PAPER_TUBE.length


@pytest.mark.parametrize("pressure", [1e-300, 1e-12, 1e-3, 1.0])
def test_tiny_pressures_are_linear(pressure: float) -> None:
    case = actuator()
    stretch = FreeActuation(case).stretch_from_pressure(pressure)
    linear = pressure / slope(case, 1.0)
    # The stretch next to 1 has a last bit of 2e-16; 1 Pa is 2e-6 of strain, its square 5e-12.
    assert stretch - 1.0 == pytest.approx(linear, rel=1e-5, abs=3e-16)


def test_rest_shape_is_the_curvature_at_the_inverse() -> None:
    actuation = FreeActuation(actuator())
    stretch = actuation.stretch_from_pressure(55.0e3)
    found, direct = (
        actuation.unloaded_shape(55.0e3),
        unloaded_shape_from_stretch(actuation.actuator, stretch),
    )
    assert dataclasses.astuple(found) == pytest.approx(dataclasses.astuple(direct), rel=1e-14)


def test_mirrored_fibers_mirror_the_torsion() -> None:
    case = actuator()
    mirrored = dataclasses.replace(case, fibers=case.fibers.mirrored())
    shape, image = (FreeActuation(a).unloaded_shape(55.0e3) for a in (case, mirrored))
    assert shape.torsion < 0.0
    assert image == dataclasses.replace(shape, torsion=-shape.torsion)


@pytest.mark.parametrize("pressure", [-1.0, -1e-300, math.nan, math.inf, True, "55 kPa"])
def test_bad_pressures_are_refused(pressure: float) -> None:
    with pytest.raises(InvalidInputError, match="pressure must be a non-negative finite number"):
        FreeActuation(actuator()).unloaded_shape(pressure)


@pytest.mark.parametrize("stretch", [0.9, math.nan, math.inf])
def test_bad_stretches_are_refused(stretch: float) -> None:
    with pytest.raises(InvalidInputError, match="stretch"):
        FreeActuation(actuator()).pressure_from_stretch(stretch)


def test_what_is_no_actuator_is_refused() -> None:
    with pytest.raises(InvalidInputError, match="an Actuator"):
        FreeActuation(PAPER_TUBE)  # type: ignore[arg-type]


def test_values_compare_and_pickle() -> None:
    actuation = FreeActuation(actuator())
    copy = pickle.loads(pickle.dumps(actuation))
    assert copy == actuation == FreeActuation(actuator())
    assert copy != FreeActuation(actuator(beta=50.0))
    assert copy.unloaded_shape(55.0e3) == actuation.unloaded_shape(55.0e3)
    assert hash(copy) == hash(actuation)
