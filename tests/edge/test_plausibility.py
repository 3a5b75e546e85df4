# SPDX-License-Identifier: Apache-2.0
"""Whether readings could be in the units they claim: mix-ups are named, stiff rubbers are not."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from core.calibration_cases import PRESSURES, actuator, bends, extensions

from spiral_core import (
    FreeActuation,
    GripReading,
    NeoHookean,
    ShapeReading,
    WrapCurve,
)
from spiral_core.calibration.model import Trial
from spiral_gripper import load_gripper
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
    "m taken for mm": ("extension", 0.001),
    "deg taken for rad": ("bend_angle", math.degrees(1.0)),
}


@pytest.mark.parametrize("mix_up", MIX_UPS)
def test_mix_ups_of_units_are_named(mix_up):
    column, factor = MIX_UPS[mix_up]
    readings = bends(TRUTH, PRESSURES) if column == "bend_angle" else READINGS
    wrong = [replace(r, **{column: factor * getattr(r, column)}) for r in readings]
    assert possible_mix_ups(TRIAL, wrong, {column: mix_up.split()[-1]})[0] == mix_up
    # Handbook constants may be this far off.
    right = [replace(reading, pressure=1.6 * reading.pressure) for reading in readings]
    assert possible_mix_ups(TRIAL, right, {}) == []


def test_shapes_and_grips_reveal_mix_ups_too():
    gripper = load_gripper("paper_design_70")
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


@pytest.mark.parametrize("factor", [0.1, 20.0])
def test_a_stiffer_or_softer_rubber_is_possible(factor):
    actual = replace(TRUTH, material=NeoHookean(c1=145.0e3 * factor))
    modulus = needed_modulus(TRIAL, extensions(actual, [factor * p for p in PRESSURES]))
    assert modulus == pytest.approx(6.0 * 145.0e3 * factor, rel=0.06)  # sought in steps of 10 %
    # No elastomer is as soft or stiff as these need.
    beyond = 100.0 if factor > 1.0 else 0.005
    readings = [replace(r, pressure=beyond * r.pressure) for r in READINGS]
    assert needed_modulus(TRIAL, readings) is None


def test_a_forgotten_length_is_an_explanation():
    readings = [replace(r, section_length=0.361) for r in READINGS]  # 0.1 m in fact
    found = other_explanations(TRIAL, readings, {})[-1]
    length = re.fullmatch(r"a measured section of ([\d.]+) mm.*", found)[1]
    assert float(length) == pytest.approx(100.0, rel=0.05)
