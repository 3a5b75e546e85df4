# SPDX-License-Identifier: Apache-2.0
"""Rods whose twist and bending are coupled, and that bend unequally: a section's full stiffness."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from core.reference_shooting import Rods, shoot
from scipy.spatial.transform import Rotation

from spiral_core import (
    Clamped,
    InvalidInputError,
    Obstacle,
    Pinned,
    Plane,
    PointLoad,
    Rod,
    RodElement,
    RodLoad,
    RodProblem,
    Section,
    find_equilibria,
    follow_rod,
    solve_rod,
)
from spiral_core.rod._mesh import element_count
from spiral_core.rod.path import follow_path

STIFFNESS = Section.inextensible(bending=6.0e-4, torsional=5.0e-4, sideways=2.0e-4, coupling=4.0e-4)
HELIX = (-9.0, 0.0, 18.0)


def rod(rest: tuple[float, float, float] = HELIX, stiffness: Section = STIFFNESS) -> Rod:
    return Rod(0.36, stiffness, rest_strain=rest)


def mirrored(stiffness: Section) -> Section:
    torsional, sideways, bending, coupling = stiffness.numbers
    return Section.inextensible(bending, torsional, sideways, -coupling)


def test_a_small_moment_at_the_tip_bends_and_twists_by_the_compliance() -> None:
    moment = 1e-9 * np.array([3.0, -2.0, 5.0])
    state = solve_rod(rod((0.0, 0.0, 0.0)), RodLoad(tip_moment=tuple(moment.tolist())))
    twist, about_y, about_z = np.linalg.solve(np.array(STIFFNESS.matrix), moment)
    np.testing.assert_allclose(
        state.tip_position[1:], 0.5 * 0.36**2 * np.array([about_z, -about_y]), rtol=1e-4
    )  # what is left out grows with the moment
    assert 2.0 * state.orientations[-1, 0] == pytest.approx(0.36 * twist, rel=1e-4)


@pytest.mark.parametrize("stiffness", [STIFFNESS, mirrored(STIFFNESS)], ids=["with", "against"])
@pytest.mark.parametrize("rest", [(0.0, 0.0, 0.0), HELIX], ids=["straight", "helix"])
@pytest.mark.parametrize("direction", [(1.0, 0.0, 0.0), (0.3, 0.8, -0.52)], ids=["along", "askew"])
def test_a_heavy_cantilever_is_that_of_shooting(
    stiffness: Section, rest: tuple[float, float, float], direction: tuple[float, float, float]
) -> None:
    weight = tuple(0.24 * component for component in direction)
    force = (0.004, -0.006, 0.003)
    state = solve_rod(rod(rest, stiffness), RodLoad(weight, tip_force=force), elements=160)
    rods = Rods(np.array([0.36]), np.array([stiffness.matrix]), np.array([rest]),
                np.array([weight]), np.array([force]), np.zeros((1, 3)))  # fmt: skip
    # Near the state: which of several equilibria it is, is not the question here.
    near = Rotation.from_quat(state.orientations[-1]) * Rotation.from_rotvec([0.02, -0.01, 0.02])
    expected = shoot(rods, near.as_quat()[None], np.array([0.0, 0.5, 1.0]))
    assert expected.miss.max() < 1e-9
    assert state.stable
    for site, node in ((1, 80), (2, 160)):
        away = np.linalg.norm(state.positions[node] - expected.positions[0, site])
        assert away < 2e-7 * 0.36  # fourth order: 160 elements leave this much
    np.testing.assert_allclose(
        state.moments[0], expected.moments[0, 0], atol=1e-6 * np.abs(expected.moments).max()
    )
    error = state.discretization_error
    assert error is not None
    assert error < 1e-6 * 0.36


@pytest.mark.parametrize("gravity", [(0.24, 0.0, 0.0), (0.0, 0.2, -0.13)])
def test_both_elements_agree_where_both_apply(gravity: tuple[float, float, float]) -> None:
    load = RodLoad(distributed=gravity)
    fast = solve_rod(rod(), load, elements=120)
    slow = solve_rod(rod(), load, elements=120, element=RodElement.MIXED)
    assert (fast.element, slow.element) == (RodElement.INEXTENSIBLE, RodElement.MIXED)
    np.testing.assert_allclose(fast.positions, slow.positions, atol=1e-6 * 0.36)
    np.testing.assert_allclose(fast.base_reaction, slow.base_reaction, atol=1e-6)
    again = solve_rod(rod(), load, elements=120, start=slow)  # either goes on from the other
    assert again.element is RodElement.INEXTENSIBLE
    np.testing.assert_allclose(again.positions, fast.positions, atol=1e-9)
    back = solve_rod(rod(), load, elements=120, start=fast, element=RodElement.MIXED)
    np.testing.assert_allclose(back.positions, slow.positions, atol=1e-6 * 0.36)
    assert fast.touching.shape == (0, 121)
    assert fast.contact_lengths.shape == fast.turns.shape == (0,)


TURNED = Rotation.from_rotvec((0.4, -0.7, 0.2)).as_quat().tolist()


@pytest.mark.parametrize(
    "base", [Clamped((0.1, 0.0, 0.2), tuple(TURNED)), Clamped(orientation=(0.0, 0.0, 0.0, -1.0))]
)
def test_a_start_with_another_base_ends_at_the_clamp(base: Clamped) -> None:
    load = RodLoad(distributed=(0.24, 0.0, 0.0))
    fresh = solve_rod(rod(), load, elements=120)
    elsewhere = solve_rod(rod(), load, elements=120, base=base)
    assert elsewhere.element is RodElement.MIXED
    state = solve_rod(rod(), load, elements=120, start=elsewhere)
    assert state.element is RodElement.INEXTENSIBLE
    assert state.orientations[0] == pytest.approx([0.0, 0.0, 0.0, 1.0], abs=1e-15)
    np.testing.assert_allclose(state.positions, fresh.positions, atol=1e-9)


def test_what_is_no_element_or_start_is_refused() -> None:
    load = RodLoad(distributed=(0.24, 0.0, 0.0))
    state = solve_rod(rod(), load, elements=40)
    with pytest.raises(InvalidInputError, match="a RodElement"):
        solve_rod(rod(), load, element="mixed")  # type: ignore[arg-type]
    with pytest.raises(InvalidInputError, match="start must be"):
        follow_rod([RodProblem(rod(), load)], start=state.positions)  # type: ignore[arg-type]
    with pytest.raises(InvalidInputError, match="a state of the mixed element"):
        follow_rod([RodProblem(rod(), load)] * 2, start=state, stop_at_event=True)
    listed = solve_rod(rod(), load, elements=40, start=state.positions.tolist())
    assert listed.element is RodElement.MIXED
    np.testing.assert_allclose(listed.positions, state.positions, atol=1e-5 * 0.36)
    with pytest.raises(InvalidInputError, match="radius must be 0"):
        find_equilibria(dataclasses.replace(rod(), radius=1e-3), load)
    for numbers in ((math.nan, 1e-4), (1e-4, -1.0), ("x", 1e-4)):
        with pytest.raises(InvalidInputError):
            Section.varying(*numbers)
    with pytest.raises(InvalidInputError, match="section must be a function giving"):
        solve_rod(Rod(0.3, lambda _: STIFFNESS), load)  # type: ignore[arg-type,return-value]


FLOOR = Obstacle(Plane(), position=(0.0, 0.0, -0.2))
MIXED_CASES = {
    "obstacle": {"obstacles": (FLOOR,)},
    "held tip": {"tip": Pinned((0.3, 0.0, 0.0))},
    "clamped elsewhere": {"base": Clamped((0.1, 0.0, 0.0))},
    "point load": {"point_loads": (PointLoad(0.1, force=(0.0, 0.0, 0.01)),)},
    "stretch": {"section": Section(STIFFNESS.stiffness, extension=100.0)},
    "coupled otherwise": {"section": Section(((5e-4, 1e-4, 0), (1e-4, 4e-4, 0), (0, 0, 4e-4)))},
    "varying 6x6": {
        "section": lambda s: np.tile(np.diag((5e-4, 4e-4, 4e-4, 90.0, 40.0, 40.0)), (len(s), 1, 1))
    },
    "radius": {"radius": 1e-3},
    "centerline": {"start": np.linspace((0.0, 0.0, 0.0), (0.36, 0.0, 0.0), 41)},
}


@pytest.mark.parametrize("case", MIXED_CASES)
def test_what_the_fast_element_cannot_take_goes_to_the_mixed_one(case: str) -> None:
    given = dict(MIXED_CASES[case])
    kind = {name: given.pop(name) for name in ("section", "radius") if name in given}
    each = dataclasses.replace(rod(), **kind)
    load = RodLoad((0.0, 0.02, 0.0))
    state = solve_rod(each, load, elements=40, **given)
    assert state.stable
    assert state.element is RodElement.MIXED
    with pytest.raises(InvalidInputError, match="element"):
        solve_rod(each, load, elements=40, element=RodElement.INEXTENSIBLE, **given)


def test_a_problem_is_solved_as_its_parts() -> None:
    problem = RodProblem(rod(), RodLoad((0.2, 0.0, 0.0)))
    state = solve_rod(problem)
    assert state.element is RodElement.INEXTENSIBLE
    np.testing.assert_array_equal(state.positions, solve_rod(rod(), problem.load).positions)
    with pytest.raises(InvalidInputError, match="a Rod, where loads"):
        solve_rod(problem, RodLoad())
    path = follow_rod([problem, problem])
    assert [each.element for each in path.states] == 2 * [RodElement.INEXTENSIBLE]
    mixed = follow_rod([problem, problem], stop_at_event=True, elements=40)
    assert [each.element for each in mixed.states] == 2 * [RodElement.MIXED]


def test_error_falls_with_the_fourth_power_where_the_section_varies() -> None:
    """Every stiffness a function of the arc length, the coupling too."""
    varied = Rod(
        0.36,
        Section.varying(
            lambda s: 0.0006 * (1.0 - 0.8 * s),
            lambda s: 0.0005 * (1.0 + s),
            sideways=lambda s: 0.0002 * (1.0 + 2.0 * s),
            coupling=lambda s: 0.0004 * np.cos(9.0 * s),
        ),
        rest_strain=lambda s: np.column_stack((-9.0 + 12.0 * s, 5.0 * s, 18.0 - 20.0 * s)),
    )
    load = RodLoad((0.1, 0.15, -0.1))
    tips = [
        solve_rod(varied, load, elements=n, estimate_error=False).tip_position
        for n in (20, 40, 80, 640)
    ]
    errors = [float(np.linalg.norm(tip - tips[-1])) for tip in tips[:-1]]
    assert 3.6 < math.log2(errors[0] / errors[1]) < 4.6
    assert 3.6 < math.log2(errors[1] / errors[2]) < 4.6
    even = solve_rod(rod(), load, elements=80)
    section = Section.varying(
        6.0e-4, 5.0e-4, lambda s: np.full(len(s), 2.0e-4), lambda s: np.full(len(s), 4.0e-4)
    )
    constant = dataclasses.replace(rod(), section=section)
    same = solve_rod(constant, load, elements=80)
    assert np.linalg.norm(even.tip_position - same.tip_position) < 1e-9
    assert even.energy == pytest.approx(same.energy, rel=1e-9)


def test_without_load_the_rod_keeps_its_rest_shape_and_no_energy() -> None:
    state = solve_rod(rod(), RodLoad())
    np.testing.assert_allclose(state.strains, np.tile(HELIX, (len(state.strains), 1)), atol=1e-6)
    assert abs(state.energy) < 1e-15


def test_a_path_of_coupled_rods_ends_where_each_alone_hangs() -> None:
    rods = [rod(tuple(f * part for part in HELIX)) for f in (0.2, 0.6, 1.0)]
    path = follow_path(rods, RodLoad((0.24, 0.0, 0.0)), elements=60)
    assert path.events == ()
    alone = solve_rod(rods[-1], RodLoad((0.24, 0.0, 0.0)), elements=60)
    assert np.linalg.norm(path.states[-1].tip_position - alone.tip_position) < 1e-9


def test_stiff_fibers_tie_twist_to_bending() -> None:
    """One motion left free: strains move along it alone, the more the stiffer the rest."""
    across = []
    for stiffer in (30.0, 300.0):
        free, held = 1.0e-3, stiffer * 1.0e-3
        along = np.array([-0.5, 0.0, 1.0]) / math.sqrt(1.25)
        square = along[2] ** 2
        stiffness = Section.inextensible(
            bending=free * square + held * (1.0 - square),
            torsional=free * (1.0 - square) + held * square,
            sideways=4.0e-4,
            coupling=(free - held) * along[0] * along[2],
        )
        state = solve_rod(rod(HELIX, stiffness), RodLoad((0.24, 0.0, 0.0)))
        change = state.strains - np.array(HELIX)
        normal = np.array([along[2], 0.0, -along[0]])
        across.append(float(np.abs(change @ normal).max() / np.abs(change @ along).max()))
    assert across[0] < 0.1
    assert across[1] == pytest.approx(0.1 * across[0], rel=0.1)  # in proportion, to first order


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("coupling", 6.0e-4),
        ("coupling", -math.sqrt(6.0e-4 * 5.0e-4)),
        ("coupling", math.nan),
        ("sideways", 0.0),
        ("sideways", math.inf),
    ],
)
def test_sections_that_do_not_resist_are_refused(field: str, value: float) -> None:
    with pytest.raises(InvalidInputError) as caught:
        Section.inextensible(6.0e-4, 5.0e-4, **{field: value})
    assert caught.value.field == field


def test_profiles_that_do_not_resist_are_refused() -> None:
    for field, given, bad in (
        ("section", "coupling", lambda s: 6.0e-4 + 0.0 * s),
        ("coupling", "coupling", lambda s: math.nan * s),
        ("coupling", "coupling", lambda s: np.zeros(2)),
        ("section", "sideways", lambda s: -1.0 + 0.0 * s),
    ):
        section = Section.varying(6.0e-4, 5.0e-4, **{given: bad})
        with pytest.raises(InvalidInputError) as caught:
            solve_rod(dataclasses.replace(rod(), section=section), RodLoad())
        assert caught.value.field == field
    section = Section.varying(6e-4, 5e-4, coupling=lambda s: np.where(s < 0.1, 1e-4, -1e-4))
    with pytest.raises(InvalidInputError, match="a jump at"):
        solve_rod(dataclasses.replace(rod(), section=section), RodLoad())


def test_alike_in_every_direction_is_the_plain_rod() -> None:
    plain = Rod(0.36, Section.inextensible(2.5e-4, 1.7e-4), rest_strain=HELIX)
    spelled = dataclasses.replace(plain, section=Section(np.diag((1.7e-4, 2.5e-4, 2.5e-4))))
    load = RodLoad((0.1, 0.2, 0.0))
    one, other = solve_rod(plain, load), solve_rod(spelled, load)
    np.testing.assert_array_equal(one.positions, other.positions)
    assert Section.inextensible(2.5e-4, 1.7e-4) == Section.inextensible(2.5e-4, 1.7e-4, 2.5e-4)


@pytest.mark.parametrize("torsional", [3.0e-6, 3.0e-2])
def test_a_breath_of_anisotropy_changes_no_mesh(torsional: float) -> None:
    """A rod soft or stiff in torsion needs its many elements however its bending is stated."""
    load = RodLoad(distributed=(0.0, 0.1, 0.1), tip_force=(0.01, 0.05, 0.02))
    plain = Rod(0.4, Section.inextensible(3e-4, torsional), rest_strain=(-5.0, 0.0, 12.0))
    count = element_count(plain, load)
    for sideways, coupling in ((3.0e-4 * (1.0 + 1e-12), 0.0), (3.0e-4, 1e-12), (3.01e-4, 0.0)):
        section = Section.inextensible(3e-4, torsional, sideways, coupling * torsional)
        rod = dataclasses.replace(plain, section=section)
        assert element_count(rod, load) == pytest.approx(count, abs=2)


def test_a_stiffer_material_scales_the_whole_section() -> None:
    scaled = Section.inextensible(3e-4, 2e-4, sideways=1e-4, coupling=-1e-4).scaled(4.0)
    assert scaled == Section.inextensible(12e-4, 8e-4, sideways=4e-4, coupling=-4e-4)
    assert Section.inextensible(3e-4, 2e-4).scaled(2.0) == Section.inextensible(6e-4, 4e-4)
