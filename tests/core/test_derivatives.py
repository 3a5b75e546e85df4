# SPDX-License-Identifier: Apache-2.0
"""Derivatives of a state: against differences of states solved again, and closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest
from core.derivative_cases import (
    BENDING,
    FORCE,
    LENGTH,
    components_of,
    contact_case,
    free_case,
    prepared,
    random_error,
    turn_between,
    way_error,
)
from scipy.spatial.transform import Rotation

from spiral_core import (
    Clamped,
    Guided,
    Inertia,
    InvalidInputError,
    Obstacle,
    Plane,
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


# Seeds that this leaves out are next to a change of their contacts, which differences cannot tell.
CONTACTS = (0, 2, 7, 10, 11, 12)


@pytest.mark.parametrize(
    ("make", "seed"),
    [
        *((free_case, seed) for seed in (0, 1, 2, 3, 4, 5, 9, 39)),
        *((contact_case, seed) for seed in CONTACTS),
    ],
)
def test_rods_agree_with_differences(make, seed):
    """Symmetric ones, few elements, varying properties; both elements; in contact."""
    error, state = random_error(make(seed), seed)
    assert error < 1e-6
    assert state.touching.any() == (make is contact_case)


@pytest.mark.slow
@pytest.mark.parametrize(("make", "compared"), [(free_case, 100), (contact_case, 70)])
def test_a_hundred_rods_agree_with_differences(make, compared):
    """Of those in contact, the ones that are not next to a change of their contacts."""
    found = [random_error(make(seed), seed) for seed in range(100)]
    errors = [one[0] for one in found if one is not None and one[0] is not None]
    assert len(errors) >= compared
    assert max(errors) < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("make", [free_case, contact_case])
def test_each_component_agrees_with_differences(make):
    """Each alone, with contacts of all kinds."""
    errors, sticking, sliding = [], 0, 0
    for seed in range(12):
        ready = prepared(make(seed))
        if ready is None:
            continue
        case, state, found = ready
        for name, component in components_of(case, found, state):
            errors.append(way_error(case, found, state, [(name, component, 1.0)]))
        sticking += int(state.sticking.sum())
        sliding += int((state.touching & ~state.sticking).sum())
    errors = [error for error in errors if error is not None]
    # Differences where a node sticks need steps so small that what a solve leaves shows.
    assert max(errors) < (1e-6 if make is free_case else 1e-5)
    assert np.median(errors) < 3e-7
    assert make is free_case or (sticking > 0 and sliding > 0)


def test_the_cantilever_bends_by_its_loads_and_stiffness():
    """Small deflections: F L^3 / 3 EI, w L^4 / 8 EI, M L^2 / 2 EI; by -1 of them per modulus."""
    state = solve_rod(Rod(LENGTH, SECTION), RodLoad(tip_force=(0.0, 1e-4 * FORCE, 0.0)))
    found = differentiate(state)
    tip = found.positions[:, -1]
    force, weight, moment = (
        tip[found.columns[name]] for name in ("tip_force", "distributed", "tip_moment")
    )
    # The state itself is bent by 3e-5 of the length; what that changes is its square.
    assert force[1, 1] == pytest.approx(LENGTH**3 / (3.0 * BENDING), rel=1e-7)
    assert weight[2, 2] == pytest.approx(LENGTH**4 / (8.0 * BENDING), rel=1e-7)
    assert moment[2, 1] == pytest.approx(LENGTH**2 / (2.0 * BENDING), rel=1e-7)
    deflection = state.tip_position[1]
    assert tip[found.columns["stiffness"]][2, 1] == pytest.approx(-deflection, rel=1e-7)
    assert tip[found.columns["length"]][0, 1] == pytest.approx(3.0 * deflection, rel=1e-7)
    reaction = found.base_reaction[found.columns["tip_force"]][1]
    assert reaction == pytest.approx((0.0, -1.0, 0.0, 0.0, 0.0, -LENGTH), abs=1e-7)


@pytest.mark.parametrize("element", RodElement)
def test_a_circle_changes_with_its_rest_curvature(element):
    """The tip of an arc is (sin kL, 1 - cos kL) / k."""
    curvature = 7.0
    rod = Rod(LENGTH, SECTION, rest_strain=(0.0, 0.0, curvature))
    found = differentiate(solve_rod(rod, element=element, elements=60), ("rest_strain", "length"))
    angle = curvature * LENGTH
    tip = np.array((math.sin(angle), 1.0 - math.cos(angle), 0.0)) / curvature
    along = np.array((math.cos(angle), math.sin(angle), 0.0))
    # The mixed element's chords are of fourth order.
    near = 1e-9 if element is RodElement.INEXTENSIBLE else 1e-6
    assert found.positions[2, -1] == pytest.approx((LENGTH * along - tip) / curvature, abs=near)
    assert found.rotations[2, -1] == pytest.approx((0.0, 0.0, LENGTH), abs=1e-9)
    assert found.positions[3, -1] == pytest.approx(LENGTH * along, abs=near)


def test_a_turned_base_turns_the_free_rod_against_its_loads():
    """The inextensible element's base cannot be turned; the mixed one's can."""
    section = Section.inextensible(BENDING, 0.7 * BENDING)
    rod, load = Rod(LENGTH, section, rest_strain=(3.0, 0.0, 6.0)), RodLoad((0.1, 0.02, -0.05))
    free = differentiate(solve_rod(rod, load, elements=40))
    mixed = differentiate(solve_rod(rod, load, elements=40, element=RodElement.MIXED))
    for name in ("base_rotation", "base_position"):
        one, other = free.columns[name], mixed.columns[name]
        # The elements' positions differ by the discretization, all else by rounding.
        assert free.positions[one] == pytest.approx(mixed.positions[other], abs=1e-6)
        assert free.rotations[one] == pytest.approx(mixed.rotations[other], abs=1e-7)
        assert free.base_reaction[one] == pytest.approx(mixed.base_reaction[other], abs=1e-8)
    start = solve_rod(rod, load, elements=40, element=RodElement.MIXED)
    turns = Rotation.from_rotvec(((0.0, 2e-4, 0.0), (0.0, -2e-4, 0.0))).as_quat()
    more, less = (solve_rod(rod, load, base=Clamped(orientation=(*q,)), start=start) for q in turns)
    slope = turn_between(less.orientations, more.orientations) / 4e-4
    assert mixed.rotations[mixed.columns["base_rotation"]][1] == pytest.approx(slope, abs=1e-6)


def test_next_to_a_fold_the_derivatives_are_unbounded():
    """Greenhill's column: its pivot vanishes where w L^3 / EI = 7.8373."""
    rod, bounded = Rod(LENGTH, SECTION), []
    for part in (0.9, 1.0 - 1e-8):
        weight = 7.8373473 * part * FORCE / LENGTH
        found = differentiate(solve_rod(rod, RodLoad((-weight, 0.0, 0.0)), elements=60))
        bounded.append(found.bounded)
        assert np.isfinite(found.positions).all() == found.bounded
    assert bounded == [True, False]
    assert 0.0 < found.smallest_pivot < 1e-6


def test_near_a_fold_the_elements_agree():
    """The mixed one's system is exact; the other's differences are small against the pivot."""
    rod = Rod(LENGTH, Section((0.8 * BENDING, 2.0 * BENDING, BENDING)))
    weight = 7.8373473 * 0.998 * FORCE / LENGTH
    load = RodLoad((-weight, 0.0, 0.0), tip_force=(0.0, 3e-5 * FORCE, 0.0))
    free = solve_rod(rod, load, elements=60)
    mixed = solve_rod(rod, load, elements=60, start=free, element=RodElement.MIXED)
    names = ("tip_force", "length", "rest_strain")
    one, other = (differentiate(state, names).positions for state in (free, mixed))
    assert free.smallest_pivot < 4e-3
    for k in (1, 3, 6):
        assert one[k] == pytest.approx(other[k], abs=2e-6 * np.abs(other[k]).max())


def test_a_rod_that_may_turn_freely_has_no_derivatives():
    """A column that buckled may point anywhere."""
    state = solve_rod(Rod(LENGTH, SECTION), RodLoad((-12.0 * FORCE / LENGTH, 0.0, 0.0)))
    assert state.neutral_modes == 1
    found = differentiate(state, ("tip_force",))
    assert not found.bounded
    assert np.isinf(found.positions).all()


def test_margins_say_how_near_the_contacts_are_to_a_change():
    """A node that sticks is as far from its cone as its forces say; one that slid is at its edge.

    Solved again from itself, that is: it has not moved since.
    """
    _, state, found = prepared(contact_case(2))
    assert state.sticking.any()
    (normal,), (touches,), (gaps,) = state.normal_forces, state.touching, state.gaps
    assert found.margins["gap"] == pytest.approx(gaps[1:][~touches[1:]].min() / LENGTH)
    assert found.margins["force"] == pytest.approx(normal[touches].min() / normal.max())
    square = np.sum(state.contact_forces[0] ** 2, axis=1) - normal**2
    friction = np.sqrt(np.maximum(square, 0.0))
    sticks = state.sticking[0]
    cones = friction[sticks] / (0.6 * normal[sticks])
    assert found.margins["stick"] == pytest.approx(1.0 - cones.max(), rel=1e-5)
    assert found.margins["slip"] == math.inf
    case, state, found = prepared(contact_case(10))
    assert not state.sticking.any()
    assert found.margins["slip"] > 1e3
    margins = differentiate(replace(case, start=state).solved(state)).margins
    assert min(margins["stick"], margins["slip"]) < 1e-4
    free = differentiate(solve_rod(Rod(0.4, SECTION)))
    assert set(free.margins.values()) == {math.inf}


def test_what_has_no_derivatives_is_refused():
    """Not a state, not a stable one, a parameter it does not have, a guided base's rotation."""
    rod = Rod(LENGTH, SECTION)
    with pytest.raises(InvalidInputError, match="a RodState"):
        differentiate(rod)
    state = solve_rod(rod)
    with pytest.raises(InvalidInputError, match="a stable state"):
        differentiate(replace(state, status=RodStatus.UNSTABLE))
    with pytest.raises(InvalidInputError, match="parameters"):
        differentiate(state, ("friction",))
    held = solve_rod(
        rod, base=Guided(orientation=(0.0, 0.0, 0.0, 1.0)), tip=Clamped((LENGTH, 0, 0))
    )
    with pytest.raises(InvalidInputError, match="base_rotation"):
        differentiate(held, ("base_rotation",))
    assert differentiate(held, ("base_position",)).bounded
    begin = solve_rod(rod, element=RodElement.MIXED)
    falling = RodProblem(rod, RodLoad((0.0, 0.0, -0.3)))
    motion = solve_motion(lambda _: falling, Inertia(0.03, 1e-7), (0.0, 0.1), start=begin)
    with pytest.raises(InvalidInputError, match="one at rest"):
        differentiate(motion.frames[-1].state)


def test_a_tip_that_alone_rests_on_a_floor_follows_it():
    """The floor takes half of the tip's force."""
    deflection = 1e-4 * FORCE * LENGTH**3 / (3.0 * BENDING)
    floor = Obstacle(Plane(), position=(0.0, 0.0, -0.5 * deflection - 2e-3))
    rod, load = Rod(LENGTH, SECTION, radius=2e-3), RodLoad(tip_force=(0.0, 0.0, -1e-4 * FORCE))
    state = solve_rod(rod, load, obstacles=(floor,), elements=40)
    found = differentiate(state, ("obstacle_position",))
    assert np.flatnonzero(state.touching[0]).tolist() == [40]
    # The bent tip also moves along the floor, by its slope.
    assert found.positions[2, -1] == pytest.approx((0.0, 0.0, 1.0), abs=1e-4)


@pytest.mark.parametrize("element", RodElement)
def test_stiffness_and_rest_strain_that_vary_together(element):
    """Their slopes' product is part of a moment's mean: where twist and bending are coupled."""

    def solved(changes):
        def section(s):
            moduli = BENDING * np.diag((1.0, 0.7, 1.2)) * (1.0 + 0.8 * s / LENGTH)[:, None, None]
            moduli[:, 0, 2] = moduli[:, 2, 0] = 0.25 * BENDING * (1.0 - 1.5 * s / LENGTH)
            factors = 1.0 + 0.5 * changes
            return factors[:, None] * moduli * factors

        def rest(s):
            return np.stack((3.0 + 20.0 * s, -4.0 + 0.0 * s, 6.0 - 30.0 * s), axis=1)

        rod, load = Rod(LENGTH, section, rest_strain=rest), RodLoad((0.05, 0.01, 0.02))
        return solve_rod(rod, load, element=element, elements=40)

    found = differentiate(solved(np.zeros(3)), ("stiffness",)).positions
    for column, step in zip(found[:3], 3e-4 * np.eye(3), strict=True):
        exact = (solved(step).positions - solved(-step).positions) / 6e-4
        assert np.abs(column - exact).max() <= 1e-6 * np.abs(exact).max()
