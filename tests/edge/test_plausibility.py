# SPDX-License-Identifier: Apache-2.0
"""Whether readings could be in the units they claim: mix-ups are named, stiff rubbers are not."""

import math
from dataclasses import replace

import numpy as np
import pytest
from core.calibration_cases import PRESSURES, actuator, extensions, spiral

from spiral_core import (
    BendReading,
    FreeActuation,
    GripReading,
    NeoHookean,
    ShapeReading,
    WrapCurve,
    gripper_from_actuator,
)
from spiral_core.calibration.model import Trial
from spiral_gripper.bench.plausibility import (
    needed_modulus,
    other_explanations,
    possible_mix_ups,
)

PSI = 6.894757293168361
TRUTH = actuator(NeoHookean(c1=145.0e3))
TRIAL = Trial(FreeActuation(TRUTH), None)
READINGS = extensions(TRUTH, PRESSURES, noise=np.random.default_rng(4))


MIX_UPS = {
    "psi taken for kPa": ("pressure", 1.0 / PSI),
    "bar taken for kPa": ("pressure", 0.01),
    "in taken for mm": ("extension", 1.0 / 25.4),
    "cm taken for mm": ("extension", 0.1),
    "m taken for mm": ("extension", 0.001),
    "deg taken for rad": ("bend_angle", math.degrees(1.0)),
    "rad taken for deg": ("bend_angle", math.radians(1.0)),
}


@pytest.mark.parametrize("mix_up", MIX_UPS)
def test_mix_ups_of_units_are_named(mix_up):
    column, factor = MIX_UPS[mix_up]
    readings = READINGS
    if column == "bend_angle":
        bends = [0.2 * FreeActuation(TRUTH).unloaded_shape(p).curvature for p in PRESSURES]
        readings = [BendReading(p, b, 0.2, 0.01) for p, b in zip(PRESSURES, bends, strict=True)]
    wrong = [replace(r, **{column: factor * getattr(r, column)}) for r in readings]
    assert possible_mix_ups(TRIAL, wrong, {column: mix_up.split()[-1]})[0] == mix_up
    # Handbook constants may be this far off.
    right = [replace(reading, pressure=1.6 * reading.pressure) for reading in readings]
    assert possible_mix_ups(TRIAL, right, {}) == []


def test_shapes_and_grips_reveal_mix_ups_too():
    material = spiral(NeoHookean(c1=145.0e3))
    gripper = gripper_from_actuator("g", material, density=950.0, pressure_max=110.0e3)
    curve, trial = WrapCurve(gripper), Trial(gripper.actuation, gripper)
    right = [GripReading(curve.pressure_from_radius(r), r, 1.0e-4) for r in (0.012, 0.02, 0.03)]
    grips = [replace(one, pressure=one.pressure / PSI) for one in right]
    shapes = [
        ShapeReading(p, tuple(25.4 * curve.state_at_pressure(p).tip_position), None, 1e-3)
        for p in (30.0e3, 60.0e3, 90.0e3)
    ]
    assert possible_mix_ups(trial, grips, {}) == ["psi taken for kPa"]
    assert possible_mix_ups(trial, shapes, {"x": "in"}) == ["mm taken for in"]
    assert possible_mix_ups(trial, right, {}) == []


@pytest.mark.parametrize("factor", [0.1, 1.0, 6.9, 20.0])
def test_a_stiffer_or_softer_rubber_is_possible(factor):
    actual = replace(TRUTH, material=NeoHookean(c1=145.0e3 * factor))
    modulus = needed_modulus(TRIAL, extensions(actual, [factor * p for p in PRESSURES]))
    assert modulus == pytest.approx(6.0 * 145.0e3 * factor, rel=0.06)  # sought in steps of 10 %


def test_what_no_elastomer_gives_is_told_and_a_forgotten_length_is_an_explanation():
    for factor in (0.005, 100.0):
        readings = [replace(r, pressure=factor * r.pressure) for r in READINGS]
        assert needed_modulus(TRIAL, readings) is None
    readings = [replace(r, section_length=0.361) for r in READINGS]  # 0.1 m in fact
    found = other_explanations(TRIAL, readings, {})
    assert found[-1].startswith("a measured section of ")
    assert float(found[-1].split()[4]) == pytest.approx(100.0, rel=0.05)
