# SPDX-License-Identifier: Apache-2.0
"""The uniform law's tabulated curve against the law itself, where it is hardest to tabulate."""

from __future__ import annotations

import dataclasses
import math
import pickle

import numpy as np
import pytest
from core.actuator_cases import PAPER_TUBE, actuator, extending_pairs, repeatable
from core.reference_uniform import reference_pressure, reference_twist
from hypothesis import given
from hypothesis import strategies as st

from spiral_core import (
    ActuationLimitError,
    Actuator,
    CurvatureForm,
    FiberAngles,
    FreeActuation,
    Gent,
    HyperelasticLaw,
    InvalidInputError,
    MooneyRivlin,
    NeoHookean,
    PressureLaw,
    Yeoh,
)
from spiral_core.actuator.actuator import UnloadedShape
from spiral_core.actuator.curvature import unloaded_shape_from_stretch
from spiral_core.actuator.uniform_law import pressure_from_stretch
from spiral_core.errors import ActuationLimit

EXACT = CurvatureForm.EXACT
GENT = Gent(shear_modulus=290.0e3, extension_limit=0.5)
HARD = {
    "fiber locking": actuator(88.0, 60.0),
    "a hoop, whose pressure diverges": actuator(90.0, 60.0),
    "no twist shear": actuator(88.0, 50.0, twist_shear=False),
    "locks far out": actuator(85.0, 84.0),
    "both lock nearly together": actuator(60.0, 60.01),
    "both lock together": actuator(70.0, -70.0),
    "volume maximum": actuator(75.0, -70.0),
    "volume maximum next to rest": actuator(54.8, -54.8),
    "elastomer's limit": actuator(88.0, 70.0, GENT),
    "elastomer's limit, very short": actuator(88.0, 70.0, Gent(290.0e3, 0.01)),
    "elastomer's limit just beyond": actuator(88.0, 60.0, Gent(290.0e3, 2.9)),
    "limit point": actuator(88.0, 70.0, Yeoh(c1=145.0e3, c2=-30.0e3, c3=3.0e3)),
    "limit point, then stiff": actuator(88.0, 70.0, Yeoh(145.0e3, -400.0e3, 400.0e3)),
    "tiny angle": actuator(88.0, 1.0),
    "tiny angles": actuator(2.0, 1.0),
    "tiny modulus": actuator(material=NeoHookean(1e-6)),
    "huge modulus": actuator(material=MooneyRivlin(1e14, 1e14)),
    "exact form": actuator(88.0, 60.0, curvature_form=EXACT),
    "straight fiber locks": actuator(90.0, 70.0, curvature_form=EXACT),
    "straight fiber far out": actuator(
        88.0, 60.0, straight_fiber_radius=9.0e-3, curvature_form=EXACT
    ),
}
LAWS: list[HyperelasticLaw] = [
    MooneyRivlin(c1=130.0e3, c2=15.0e3),
    Yeoh(c1=145.0e3, c2=-30.0e3, c3=3.0e3),
    GENT,
]
# One actuator for each kind of limit.
ENDS = {
    ActuationLimit.FIBER_LOCKING: HARD["fiber locking"],
    ActuationLimit.VOLUME_MAXIMUM: actuator(70.0, -65.0),
    ActuationLimit.LIMIT_POINT: HARD["limit point"],
    ActuationLimit.MATERIAL_LIMIT: HARD["elastomer's limit"],
}
EPSILON = 2.0**-52
# From rest, over the branch, to its end.
FRACTIONS = (1e-9, 1e-4, *np.linspace(0.01, 0.99, 8), 1 - 1e-4, 1 - 1e-9, 1.0)


def check(case: Actuator, fraction: float) -> None:
    """Compare pressure, inverse and shape at a fraction of the branch's elongation."""
    pair = case.fiber_pair
    # Families that nearly coincide magnify rounding.
    crossing = abs(math.sin(pair.alpha - pair.beta))
    tolerance, bits = max(1e-12, 2e-15 / crossing), 8.0 * EPSILON / crossing
    actuation = FreeActuation(case)
    end = actuation.stretch_limit
    stretch = min(1.0 + fraction * (end - 1.0), end)
    expected = reference_pressure(case, stretch)
    # What a few last bits of the stretch mean.
    nearby = stretch * (1.0 - bits), stretch * (1.0 + bits)
    bit = max(abs(reference_pressure(case, one) - expected) for one in nearby)
    assert pressure_from_stretch(case, stretch) == pytest.approx(expected, rel=tolerance, abs=bit)
    pressure = actuation.pressure_from_stretch(stretch)
    assert pressure == pytest.approx(expected, rel=tolerance, abs=bit)
    assert reference_pressure(case, actuation.stretch_from_pressure(pressure)) == pytest.approx(
        pressure, rel=tolerance, abs=bit
    )
    found, direct = (
        actuation.unloaded_shape_from_stretch(stretch),
        unloaded_shape_from_stretch(case, stretch),
    )
    rounding = 4.0 * EPSILON / case.fiber_radius
    twists = [reference_twist(case, one) for one in (*nearby, stretch)]
    spread = (max(twists) - min(twists)) / case.wound_radius
    assert found.stretch == pytest.approx(stretch, rel=4.0 * EPSILON)
    assert found.backbone_length == pytest.approx(direct.backbone_length, rel=1e-14)
    assert found.curvature == pytest.approx(
        direct.curvature, rel=tolerance, abs=rounding + abs(twists[-1]) * spread
    )
    assert found.torsion == pytest.approx(direct.torsion, rel=tolerance, abs=spread)


@pytest.mark.parametrize("name", HARD)
def test_the_curve_is_the_law_to_twelve_digits(name: str) -> None:
    for fraction in FRACTIONS:
        check(HARD[name], float(fraction))


@repeatable
@given(
    fibers=extending_pairs,
    law=st.sampled_from(LAWS),
    fraction=st.one_of(st.floats(0.0, 1.0), st.sampled_from([1e-12, 1e-6, 1 - 1e-12, 1 - 1e-6])),
    form=st.sampled_from(CurvatureForm),
)
def test_random_curves_are_the_law(
    fibers: FiberAngles, law: HyperelasticLaw, fraction: float, form: CurvatureForm
) -> None:
    check(
        Actuator(PAPER_TUBE, fibers, law, curvature_form=form, pressure_law=PressureLaw.UNIFORM),
        fraction,
    )


@pytest.mark.parametrize("name", ["fiber locking", "exact form", "locks far out"])
def test_near_rest_the_shape_is_right_to_its_own_rounding(name: str) -> None:
    case = HARD[name]
    actuation = FreeActuation(case)
    step = 1e-3 * actuation.pressure_limit
    near = [actuation.unloaded_shape(step * 10.0**-k) for k in range(6, 13)]
    for one, ten in zip(near[1:], near, strict=False):
        # A tenth of the pressure is a tenth of the curvature, but for its square.
        assert one.curvature == pytest.approx(0.1 * ten.curvature, rel=1e-7)
        assert one.torsion == pytest.approx(0.1 * ten.torsion, rel=1e-7)


def test_the_limit_point_is_where_the_pressure_is_largest() -> None:
    actuation = FreeActuation(HARD["limit point"])
    assert actuation.limit is ActuationLimit.LIMIT_POINT
    around = np.linspace(actuation.stretch_limit - 0.05, actuation.stretch_limit + 0.05, 101)
    highest = max(pressure_from_stretch(actuation.actuator, float(one)) for one in around)
    assert actuation.pressure_limit >= highest * (1.0 - 1e-14)
    mirrored = dataclasses.replace(
        actuation.actuator, fibers=actuation.actuator.fiber_pair.mirrored()
    )
    assert FreeActuation(mirrored).stretch_limit == actuation.stretch_limit


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
    assert actuation.unloaded_shape(0.0) == UnloadedShape(0.0, 0.0, PAPER_TUBE.length, 1.0)
    # Below it the stretch rises with pressure.
    pressures = [*np.linspace(0.0, 0.999 * top, 400), *(top * (1 - np.logspace(-4, -9)))]
    stretches = [actuation.stretch_from_pressure(float(p)) for p in pressures]
    assert np.all(np.diff(stretches) > 0.0)


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
