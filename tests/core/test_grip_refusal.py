# SPDX-License-Identifier: Apache-2.0
"""What a refusal says of its cause, and what would be held instead."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from core.actuator_cases import actuator
from core.recorded import recorded, said
from numpy.linalg import norm
from numpy.testing import assert_allclose

from spiral_core import (
    Closing,
    NeoHookean,
    NotGrippableError,
    PressureLaw,
    Tube,
    grip_window,
    gripper_from_actuator,
    lay_into_coil,
    solve_grip,
)
from spiral_core.grip import places
from spiral_core.grip.places import find_place, held_radii, nearest_held_radius, what_helps
from spiral_gripper import load_gripper

pytestmark = pytest.mark.long
PAPER, PROTOTYPE = load_gripper("paper_design_70"), load_gripper("prototype_p1")


def rough(closing=Closing.SLOW):
    """Return a thick-walled gripper whose tube friction stops before it is wrapped."""
    tube, law = Tube(4e-3, 1.2e-3, 0.42), PressureLaw.SECTION
    thick = actuator(87.0, 65.0, NeoHookean(190e3), tube=tube, pressure_law=law)
    gripper = gripper_from_actuator("thick", thick, density=1100.0, pressure_max=200e3)
    return lay_into_coil(gripper, 0.025, friction=0.5, closing=closing)


def aside():
    """Return an object next to which the coil closes."""
    setup = lay_into_coil(PAPER, 0.025, closing=Closing.FRICTIONLESS)
    return replace(setup, obstacle=setup.obstacle.moved((0.0, 0.2, 0.0)))


def weak():
    return replace(aside(), gripper=replace(PAPER, pressure_max=45e3), tip_pressure=None)


def test_refusals_say_their_cause():
    """An object that the tip passes by is given up before the pressure limit."""
    thick = partial(lay_into_coil, PAPER, 0.06)
    found = [said(lambda make=make: solve_grip(make())) for make in (rough, aside, weak, thick)]
    recorded("refusal/causes", [*found, grip_window(aside())])
    assert solve_grip(rough(Closing.FRICTIONLESS), (), pressures=()).onset_wrap > 0.0


@pytest.mark.parametrize("ranges", [[(0.0, 0.021)], [(0.0131, 0.0177), (0.0222, 1.0)], []])
def test_the_radii_that_are_held_end_where_contact_ends(monkeypatch, ranges):
    """Every end is held, and next to it, by a percent, is what is not held or was not tried.

    None is tried that a closed coil has no hole for.
    """
    gripper, tried = replace(PAPER, pressure_max=200e3), []

    def is_held(radius):
        return any(low <= radius <= high for low, high in ranges)

    def window(setup, **_):
        tried.append(setup.obstacle.shape.feature_radius)
        if not is_held(tried[-1]):
            raise NotGrippableError(tried[-1], "nothing is", -1.0, None)
        return SimpleNamespace(onset_wrap=5e4)

    monkeypatch.setattr(places, "grip_window", window)
    found = np.array(held_radii(gripper))
    reach, count = (min(tried), max(tried)), len(tried)
    assert all(map(is_held, found.flat))
    assert_allclose(found, np.clip(np.array(ranges), *reach), 0.01)
    wrong = [radius for radius in (0.0185, 0.0198, 0.0215) if not is_held(radius)]
    told = []
    nearest = [
        nearest_held_radius(lay_into_coil(gripper, radius), lambda *at: told.append(at))
        for radius in wrong
    ]
    assert all(map(is_held, nearest)) or not ranges
    recorded(f"refusal/radii {len(ranges)}", [found, reach, count, nearest, told])


LEANING = (-0.719 * 9.81, 0.678 * 9.81, 0.152 * 9.81)


# Where the tip touches, of those that are tried near a coil of prototype_p1.
BEST_PLACE = (0.34, 0.03, -0.04)


@pytest.fixture
def holding(monkeypatch):
    """Setups that are closed, and those among them that are to be held: fill the second."""
    closed, held = [], []

    def window(setup, **_):
        closed.append(setup)
        there = norm(np.subtract(setup.obstacle.position, BEST_PLACE))
        point = SimpleNamespace(
            tip_gap=there, contact_length=max(0.0, 0.4 - setup.obstacle.position[0])
        )
        onset = 5e4 if setup in held else None
        return SimpleNamespace(setup=setup, onset_wrap=onset, points=(point,))

    monkeypatch.setattr(places, "grip_window", window)
    return closed, held


@pytest.mark.parametrize("axis", [None, (1.0, 0.0, 0.0)])
def test_places_near_the_coil_are_tried_the_nearest_first_then_around_the_best(holding, axis):
    setup = lay_into_coil(replace(PROTOTYPE, object_axis=axis), 0.0165)
    closed, held = holding
    assert find_place(setup) is None
    assert closed[0] is setup
    places = [[*one.obstacle.position, *one.axis] for one in closed]
    recorded(f"refusal/places {axis}", [np.array(places), len(closed), *places])
    missed = norm(np.array(places)[:, :3] - BEST_PLACE, axis=1)
    assert np.mean(missed[-13:]) < 0.5 * np.mean(missed[1:17])
    held += closed[9], closed[7]
    assert find_place(setup) == held[1]


def test_a_roll_helps_before_another_direction_does(holding):
    """The base rolled by 90 degrees about x: what lay along z lies along its y."""
    setup = lay_into_coil(PROTOTYPE.with_mount(LEANING, (0.0, 0.0, 1.0)), 0.0165)
    closed, held = holding
    helps = [what_helps(setup)]
    mounts = [(*one.gripper.gravity, *(one.gripper.object_axis or ())) for one in closed]
    for one in (closed[-1], closed[1]):
        held.append(one)
        helps.append(what_helps(setup))
    recorded("refusal/helps", [helps, *mounts])


@pytest.mark.slow
def test_an_object_that_is_held_elsewhere_is_found_there():
    setup = lay_into_coil(PROTOTYPE.with_mount(LEANING, None), 0.0165)
    assert grip_window(setup).onset_wrap is None
    assert grip_window(find_place(setup)).onset_wrap is not None
