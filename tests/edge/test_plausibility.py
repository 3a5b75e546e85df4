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


def noisy(truth, seed=4):
    return extensions(truth, PRESSURES, noise=np.random.default_rng(seed))


PSI = 6.894757293168361


@pytest.mark.parametrize(
    ("pressure", "response", "expected"),
    [
        (1.0, 1.0, None),
        (1.6, 1.0, None),  # handbook constants may be this far off
        (1.0 / PSI, 1.0, "psi taken for kPa"),
        (PSI, 1.0, "kPa taken for psi"),
        (0.01, 1.0, "bar taken for kPa"),
        (100.0, 1.0, "kPa taken for bar"),
        (PSI / 100.0, 1.0, "bar taken for psi"),
        (100.0 / PSI, 1.0, "psi taken for bar"),
        (1.0, 1.0 / 25.4, "in taken for mm"),
        (1.0, 25.4, "mm taken for in"),
        (1.0, 0.1, "cm taken for mm"),
        (1.0, 0.001, "m taken for mm"),
    ],
)
def test_mix_ups_of_units_are_named(pressure, response, expected):
    truth = actuator(NeoHookean(c1=145.0e3))
    readings = [
        replace(r, pressure=r.pressure * pressure, extension=r.extension * response)
        for r in noisy(truth)
    ]
    _, _, stated = (expected or "").partition(" taken for ")
    column = "pressure" if response == 1.0 else "extension"
    found = possible_mix_ups(
        Trial(FreeActuation(truth), None), readings, {column: stated or "kPa"} if expected else {}
    )
    assert found[:1] == ([expected] if expected else [])


@pytest.mark.parametrize("degrees_for_radians", [True, False])
def test_mix_ups_of_angles_are_named(degrees_for_radians):
    truth = actuator(NeoHookean(c1=145.0e3))
    factor = math.degrees(1.0) if degrees_for_radians else math.radians(1.0)
    readings = [
        BendReading(p, factor * FreeActuation(truth).unloaded_shape(p).curvature * 0.2, 0.2, 0.01)
        for p in PRESSURES
    ]
    true, stated = ("deg", "rad") if degrees_for_radians else ("rad", "deg")
    found = possible_mix_ups(Trial(FreeActuation(truth), None), readings, {"bend_angle": stated})
    assert found == [f"{true} taken for {stated}"]


def test_shapes_and_grips_reveal_mix_ups_too():
    gripper = gripper_from_actuator(
        "g", spiral(NeoHookean(c1=145.0e3)), density=950.0, pressure_max=110.0e3
    )
    curve = WrapCurve(gripper)
    trial = Trial(gripper.actuation, gripper)
    grips = [
        GripReading(curve.pressure_from_radius(r) / PSI, r, 1.0e-4) for r in (0.012, 0.02, 0.03)
    ]
    shapes = [
        ShapeReading(
            p, tuple((curve.state_at_pressure(p).tip_position * 25.4).tolist()), None, 1e-3
        )
        for p in (30.0e3, 60.0e3, 90.0e3)
    ]
    assert possible_mix_ups(trial, grips, {}) == ["psi taken for kPa"]
    assert possible_mix_ups(trial, shapes, {"x": "in"}) == ["mm taken for in"]
    right = [replace(g, pressure=g.pressure * PSI) for g in grips]
    assert possible_mix_ups(trial, right, {}) == []


@pytest.mark.parametrize("factor", [0.1, 0.4, 1.0, 4.0, 6.9, 20.0])
def test_a_stiffer_or_softer_rubber_is_possible(factor):
    described = actuator(NeoHookean(c1=145.0e3))
    actual = replace(described, material=NeoHookean(c1=145.0e3 * factor))
    pressures = [factor * p for p in PRESSURES]
    modulus = needed_modulus(Trial(FreeActuation(described), None), extensions(actual, pressures))
    assert modulus == pytest.approx(6.0 * 145.0e3 * factor, rel=0.06)  # sought in steps of 10 %


@pytest.mark.parametrize("factor", [0.005, 100.0])
def test_what_no_elastomer_gives_is_told(factor):
    described = actuator(NeoHookean(c1=145.0e3))
    readings = [replace(r, pressure=factor * r.pressure) for r in noisy(described)]
    assert needed_modulus(Trial(FreeActuation(described), None), readings) is None


def test_a_forgotten_section_length_is_among_the_explanations():
    described = actuator(NeoHookean(c1=145.0e3))
    readings = [replace(r, section_length=0.361) for r in noisy(described)]  # 0.1 m in fact
    found = other_explanations(Trial(FreeActuation(described), None), readings, {})
    assert found[-1].startswith("a measured section of ")
    assert float(found[-1].split()[4]) == pytest.approx(100.0, rel=0.05)
