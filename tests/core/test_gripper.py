# SPDX-License-Identifier: Apache-2.0
"""A gripper: what it refuses, and the rod, load and stiffness it stands for."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from core.gripper_cases import linear_gripper, paper_gripper

from spiral_core import InvalidInputError, Section, gripper_from_actuator
from spiral_core.actuator.actuator import Actuator, UnloadedShape
from spiral_core.wrap.gripper import stiffness_from_actuator


def test_stiffness_is_that_of_the_annulus() -> None:
    gripper = paper_gripper("P2")
    actuator = gripper.actuation.actuator  # type: ignore[attr-defined]
    assert isinstance(actuator, Actuator)
    r, o = 4.7625e-3, 4.7625e-3 + 0.79375e-3
    second = math.pi / 4.0 * (o**4 - r**4)
    modulus = 6.0 * 145.0e3
    stiffness = stiffness_from_actuator(actuator)
    assert stiffness.bending == pytest.approx(modulus * second, rel=1e-12)
    assert stiffness.torsional == pytest.approx(modulus / 3.0 * 2.0 * second, rel=1e-12)
    assert gripper.stiffness == stiffness
    assert gripper.weight_per_length == pytest.approx(
        930.0 * 9.80665 * math.pi * (o**2 - r**2), rel=1e-12
    )


def test_what_is_given_is_used() -> None:
    actuator = paper_gripper("P1").actuation.actuator  # type: ignore[attr-defined]
    stiffness = linear_gripper().stiffness
    gripper = gripper_from_actuator(
        "given", actuator, density=930.0, extra_mass_per_length=0.01, stiffness=stiffness
    )
    assert gripper.stiffness is stiffness
    assert gripper.pressure_max == gripper.actuation.pressure_limit
    lighter = gripper_from_actuator("light", actuator, density=930.0)
    gained = gripper.weight_per_length - lighter.weight_per_length
    assert gained == pytest.approx(0.01 * 9.80665, rel=1e-9)


def test_a_stretched_backbone_keeps_its_mass() -> None:
    gripper = linear_gripper(weight=0.3, gravity=(0.0, -9.80665, 0.0))
    load = gripper.load(UnloadedShape(20.0, -10.0, 0.6))
    assert not callable(load.distributed)
    assert load.distributed == pytest.approx((0.0, -0.3 * 0.5 / 0.6, 0.0))
    rod = gripper.rod(UnloadedShape(20.0, -10.0, 0.6))
    assert (rod.length, rod.rest_strain) == (0.6, (-10.0, 0.0, 20.0))


def test_another_mount_changes_nothing_else() -> None:
    gripper = paper_gripper("P1")
    tilted = gripper.with_mount((0.0, 0.0, -9.8), (0.0, 1.0, 0.0))
    assert (tilted.gravity, tilted.object_axis) == ((0.0, 0.0, -9.8), (0.0, 1.0, 0.0))
    assert tilted.with_mount(gripper.gravity, gripper.object_axis) == gripper


@pytest.mark.parametrize("ratio", [0.0099, 101.0, 1e-9, 1e9])
def test_stiffnesses_of_no_tube_are_refused(ratio: float) -> None:
    gripper = paper_gripper("P1")
    bending = gripper.stiffness.bending
    for allowed in (0.0101, 99.0):
        replace(gripper, stiffness=Section.inextensible(bending, allowed * bending))
    with pytest.raises(InvalidInputError, match="a hundredth to a hundred times") as caught:
        replace(gripper, stiffness=Section.inextensible(bending, ratio * bending))
    assert caught.value.field == "torsional"
