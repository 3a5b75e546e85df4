# SPDX-License-Identifier: Apache-2.0
"""Whether readings could be in the units they claim: mix-ups are named, stiff rubbers are not."""

import math
from dataclasses import replace

import numpy as np
from core.calibration_cases import PRESSURES, actuator, bends, extensions
from numpy.testing import assert_allclose

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
    possible_mix_ups,
)

PSI = 6.894757293168361
TRUTH = actuator(NeoHookean(c1=145.0e3))
TRIAL = Trial(FreeActuation(TRUTH), None)
READINGS = extensions(TRUTH, PRESSURES, noise=np.random.default_rng(4))


def test_mix_ups_of_units_are_named():
    gripper = load_gripper("paper_design_70")
    curve, spiral = WrapCurve(gripper), Trial(gripper.actuation, gripper)
    grips = [GripReading(curve.pressure_from_radius(r), r, 1.0e-4) for r in (0.012, 0.02, 0.03)]
    for trial, right, column, factor, mix_up in (
        (TRIAL, READINGS, "pressure", 1.0 / PSI, "psi taken for kPa"),
        (TRIAL, READINGS, "extension", 0.001, "m taken for mm"),
        (TRIAL, bends(TRUTH, PRESSURES), "bend_angle", math.degrees(1.0), "deg taken for rad"),
        (spiral, grips, "pressure", 1.0 / PSI, "psi taken for kPa"),
    ):
        wrong = [replace(each, **{column: factor * getattr(each, column)}) for each in right]
        assert possible_mix_ups(trial, wrong, {column: mix_up.split()[-1]})[0] == mix_up
        # Handbook constants may be this far off.
        off = [replace(each, pressure=1.6 * each.pressure) for each in right]
        assert possible_mix_ups(trial, off, {}) == []
    shapes = [
        ShapeReading(p, tuple(25.4 * curve.state_at_pressure(p).tip_position), None, 1e-3)
        for p in (30.0e3, 60.0e3, 90.0e3)
    ]
    assert possible_mix_ups(spiral, shapes, {"x": "in"}) == ["mm taken for in"]


def test_a_stiffer_or_softer_rubber_is_possible_within_bounds():
    for factor, beyond in [(0.1, 0.005), (20.0, 100.0)]:
        actual = replace(TRUTH, material=NeoHookean(c1=145.0e3 * factor))
        modulus = needed_modulus(TRIAL, extensions(actual, np.multiply(factor, PRESSURES)))
        assert_allclose(modulus, 6.0 * 145.0e3 * factor, 0.06)  # sought in steps of 10 %
        readings = [replace(r, pressure=beyond * r.pressure) for r in READINGS]
        assert needed_modulus(TRIAL, readings) is None
