# SPDX-License-Identifier: Apache-2.0
"""Derivatives of a state: against differences of states solved again, and closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest
from core.contact_cases import down, floor
from core.derivative_cases import (
    BENDING,
    FORCE,
    LENGTH,
    contact_case,
    free_case,
    units_of,
    way_error,
)
from core.rod_cases import RODS

from spiral_core import (
    Clamped,
    Guided,
    Inertia,
    InvalidInputError,
    Rod,
    RodElement,
    RodLoad,
    RodProblem,
    RodStatus,
    Section,
    differentiate,
    solve_motion,
    solve_rod,
)

SECTION = Section((0.8 * BENDING, BENDING, BENDING))
ROD = Rod(LENGTH, SECTION)
GREENHILL = 7.8373473  # w L^3 / EI, at which an upright rod buckles


# Of those in contact, seeds that this leaves out are next to a change of their contacts, which
# differences cannot tell.
@pytest.mark.parametrize(
    ("make", "seeds"),
    [
        (free_case, (0, 1, 2, 3, 4, 5, 9, 39)),
        (contact_case, (0, 8, 10, 14, 18, 23)),
        *(
            pytest.param(make, range(100), marks=pytest.mark.slow)
            for make in (free_case, contact_case)
        ),
    ],
)
def test_derivatives_are_those_of_differences(make, seeds):
    """Along random ways through all parameters; of twelve rods, along each component alone."""
    errors, sticks, slides = [], 0, 0
    for seed, case in ((seed, case) for seed in seeds if (case := make(seed))):
        _, state, _, _ = case
        sticks += state.sticking.sum()
        slides += (state.touching & ~state.sticking).sum()
        units = units_of(*case[:3])
        ways = [units * np.random.default_rng(seed).normal(size=len(units))]
        if len(seeds) > 8 and seed < 12:
            ways += [*np.diag(units)[units > 0.0]]
        errors += [way_error(*case, way) for way in ways]
    assert (sticks * slides > 0) == (make is contact_case)
    found = [error for error in errors if error < math.inf]
    assert len(found) > 0.95 * len(errors) > 0.65 * len(seeds)
    # Differences where a node sticks need steps so small that what a solve leaves shows.
    assert max(found) < (1e-6 if make is free_case else 1e-5)
    assert np.median(found) < 3e-7


def test_the_cantilever_bends_by_its_loads_and_stiffness():
    """Small deflections: F L^3 / 3 EI, w L^4 / 8 EI, M L^2 / 2 EI; by -1 of them per modulus."""
    state = solve_rod(ROD, RodLoad(tip_force=(0.0, 1e-4 * FORCE, 0.0)))
    found, deflection = differentiate(state), state.tip_position[1]
    # The state itself is bent by 3e-5 of the length; what that changes is its square.
    for name, component, axis, expected in (
        ("tip_force", 1, 1, LENGTH**3 / (3.0 * BENDING)),
        ("distributed", 2, 2, LENGTH**4 / (8.0 * BENDING)),
        ("tip_moment", 2, 1, LENGTH**2 / (2.0 * BENDING)),
        ("stiffness", 2, 1, -deflection),
        ("length", 0, 1, 3.0 * deflection),
    ):
        tip = found.positions[found.columns[name], -1]
        assert tip[component, axis] == pytest.approx(expected, rel=1e-7)
    reaction = found.base_reaction[found.columns["tip_force"]][1]
    assert reaction == pytest.approx((0.0, -1.0, 0.0, 0.0, 0.0, -LENGTH), abs=1e-7)


@pytest.mark.parametrize("element", RodElement)
def test_a_circle_changes_with_its_rest_curvature(element):
    """The tip of an arc is (sin kL, 1 - cos kL) / k."""
    rod, angle = replace(ROD, rest_strain=(0.0, 0.0, 7.0)), 7.0 * LENGTH
    found = differentiate(solve_rod(rod, element=element, elements=60), ("rest_strain", "length"))
    tip = np.array((math.sin(angle), 1.0 - math.cos(angle), 0.0)) / 7.0
    along = LENGTH * np.array((math.cos(angle), math.sin(angle), 0.0))
    # The mixed element's chords are of fourth order.
    near = 1e-9 if element is RodElement.INEXTENSIBLE else 1e-6
    expected = (along - tip) / 7.0, along
    np.testing.assert_allclose(found.positions[2:, -1], expected, atol=near)
    assert found.rotations[2, -1] == pytest.approx((0.0, 0.0, LENGTH), abs=1e-9)


@pytest.mark.parametrize(
    "problem",
    [
        RODS["coupled"],
        # Near a fold: differences are small against the pivot.
        RodProblem(
            replace(ROD, section=Section((0.8 * BENDING, 2.0 * BENDING, BENDING))),
            RodLoad((-0.998 * GREENHILL * FORCE / LENGTH, 0.0, 0.0), (0.0, 3e-5 * FORCE, 0.0)),
        ),
    ],
)
def test_both_elements_agree(problem):
    """On how a base turns a rod against its loads, too, which the inextensible one cannot do."""
    free = solve_rod(problem, elements=60)
    mixed = solve_rod(problem, elements=60, start=free, element=RodElement.MIXED)
    one, other = map(differentiate, (free, mixed))
    for name, least in (("positions", 1e-9), ("rotations", 1e-6), ("base_reaction", 1e-9)):
        first, second = (getattr(each, name).reshape(25, -1) for each in (one, other))
        size = np.abs(second).max(axis=1, keepdims=True)
        assert (np.abs(first - second) <= 3e-6 * size + least).all()


def test_next_to_a_fold_or_free_to_turn_the_derivatives_are_unbounded():
    """Greenhill's column, whose pivot vanishes; and buckled it may point anywhere."""
    for weight in (0.9, 1.0 - 1e-8, 1.5):
        load = RodLoad((-weight * GREENHILL * FORCE / LENGTH, 0.0, 0.0))
        state = solve_rod(ROD, load, elements=60)
        found = differentiate(state)
        assert found.bounded == (weight == 0.9)
        assert np.isfinite(found.positions).all() == found.bounded
        assert (found.smallest_pivot < 1e-6) == (weight == 1.0 - 1e-8)
        assert state.neutral_modes == (weight == 1.5)


def test_margins_say_how_near_the_contacts_are_to_a_change():
    """A node that sticks is as far from its cone as its forces say; one that slid is at its edge.

    Solved again from itself, that is: it has not moved since.
    """
    _, state, found, _ = contact_case(8)
    (normal,), (touches,), (gaps,) = state.normal_forces, state.touching, state.gaps
    assert found.margins["gap"] == pytest.approx(gaps[1:][~touches[1:]].min() / LENGTH)
    assert found.margins["force"] == pytest.approx(normal[touches].min() / normal.max())
    square = np.sum(state.contact_forces[0] ** 2, axis=1) - normal**2
    cones = np.sqrt(np.maximum(square, 0.0))[state.sticking[0]] / (0.6 * normal[state.sticking[0]])
    assert found.margins["stick"] == pytest.approx(1.0 - cones.max(), rel=1e-5)
    assert found.margins["slip"] == math.inf
    problem, state, found, solved = contact_case(10)
    assert found.margins["slip"] > 1e3
    margins = differentiate(solved(problem, start=state)).margins
    assert min(margins["stick"], margins["slip"]) < 1e-4
    assert {*differentiate(solve_rod(ROD)).margins.values()} == {math.inf}


def test_what_has_no_derivatives_is_refused():
    """Not a state, not a stable one, a parameter it does not have, a guided base's rotation."""
    state = solve_rod(ROD, element=RodElement.MIXED)
    guided = Guided(orientation=(0.0, 0.0, 0.0, 1.0))
    held = solve_rod(ROD, base=guided, tip=Clamped((LENGTH, 0.0, 0.0)))
    assert differentiate(held, ("base_position",)).bounded
    falling = RodProblem(ROD, down(0.3))
    motion = solve_motion(lambda _: falling, Inertia(0.03, 1e-7), (0.0, 0.1), start=state)
    for given, match in (
        ((ROD,), "a RodState"),
        ((replace(state, status=RodStatus.UNSTABLE),), "a stable state"),
        ((state, ("friction",)), "parameters"),
        ((held, ("base_rotation",)), "base_rotation"),
        ((motion.frames[-1].state,), "at rest"),
    ):
        with pytest.raises(InvalidInputError, match=match):
            differentiate(*given)


def test_a_tip_that_alone_rests_on_a_floor_follows_it():
    """The floor takes half of the tip's force."""
    deflection = 1e-4 * FORCE * LENGTH**3 / (3.0 * BENDING)
    below = floor(-0.5 * deflection - 2e-3)
    rod, load = replace(ROD, radius=2e-3), down(0.0, 1e-4 * FORCE)
    state = solve_rod(rod, load, obstacles=(below,), elements=40)
    found = differentiate(state, ("obstacle_position",))
    assert np.flatnonzero(state.touching[0]).tolist() == [40]
    # The bent tip also moves along the floor, by its slope.
    assert found.positions[2, -1] == pytest.approx((0.0, 0.0, 1.0), abs=1e-4)


@pytest.mark.parametrize(
    "other", [(0.0, 0.0, 0.0), (0.0, 0.0, 0.7), (1e-12, 1e-10, 0.0), (0.5, 0, 0)]
)
def test_where_obstacles_share_a_load_in_any_way_there_are_no_derivatives(other):
    """One floor given twice, or as two that hardly differ; not a slope beside it, in a corner."""
    rod, below = replace(ROD, radius=2e-3), floor(-5e-3)
    side = below.moved(rotation=other)
    load = RodLoad((0.0, 0.1 * (other[0] == 0.5), -0.3))
    state = solve_rod(rod, load, obstacles=(below, side), elements=40)
    found = differentiate(state, ("obstacle_position", "stiffness"))
    assert found.bounded == (other[0] == 0.5)
    assert np.isfinite(found.contact_forces).all() == found.bounded
    assert (state.touching.sum(axis=0) > 1).any()
