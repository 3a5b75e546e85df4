# SPDX-License-Identifier: Apache-2.0
"""Both elements, starts, breaks, few elements, statuses, reproducible results."""

from __future__ import annotations

import math
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from core.rod_cases import COUPLED, HELIX, RODS, gripper_rod, helix_rod, straight_rod, two_tubes
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
    RodStatus,
    Section,
    SolverError,
    follow_rod,
    solve_rod,
)

LOAD = RodLoad((0.24, 0.05, 0.0), (0.01, 0.0, 0.02))
HANGING = RodLoad((0.24, 0.0, 0.0))
ROD = helix_rod(COUPLED)


def test_a_warm_start_ends_where_the_path_does_and_is_left_as_it_was() -> None:
    case, near = gripper_rod(), gripper_rod(curvature=21.2, torsion=-13.6)
    cold = solve_rod(near.rod, near.load)
    start = solve_rod(case.rod, case.load)
    before = start.orientations.copy()
    warm = solve_rod(near.rod, near.load, start=start)
    assert warm.iterations < cold.iterations / 3
    np.testing.assert_allclose(warm.positions, cold.positions, atol=1e-9)
    resampled = solve_rod(near.rod, near.load, start=start, elements=64)
    direct = solve_rod(near.rod, near.load, elements=64)
    np.testing.assert_allclose(resampled.positions, direct.positions, atol=1e-9)
    np.testing.assert_array_equal(start.orientations, before)
    for name in ("arc_lengths", "positions", "orientations", "forces", "moments", "strains"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(start, name)[0] = 0.0


DIGEST = """
import hashlib
from spiral_core import Rod, RodLoad, Section, solve_rod
rod = Rod(0.5, Section.inextensible(2.5e-4, 1.7e-4), rest_strain=(-21.0, 0.0, 31.0))
for _ in range(2):
    s = solve_rod(rod, RodLoad(distributed=(0.1, -0.2, 0.05), tip_force=(0.0, 0.01, 0.0)))
    data = b"".join(a.tobytes() for a in (s.positions, s.orientations, s.moments, s.strains))
    figures = repr((s.energy, s.residual, s.iterations, s.smallest_pivot)).encode()
    print(hashlib.sha256(data + figures).hexdigest())
"""


def test_results_are_bit_identical_in_one_process_and_in_two() -> None:
    command = [sys.executable, "-c", DIGEST]
    outputs = [
        subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
        for _ in range(2)
    ]
    assert len(outputs[0]) == 2
    assert len({digest for digests in outputs for digest in digests}) == 1


@pytest.mark.parametrize("name", ["weight", "coupled"])
def test_constant_functions_are_constants(name: str) -> None:
    """Cold, and from a state nearby, where a uniform rod goes a shorter way."""
    case = RODS[name]
    rest, load = np.array(case.rod.rest_strain), np.array(case.load.distributed)
    torsional, sideways, bending, coupling = case.rod.section.numbers

    def constant(value: float):
        return lambda s: np.full(len(s), value)

    def profiled(factor: float) -> Rod:
        section = Section.varying(
            constant(bending), torsional, constant(sideways), constant(coupling)
        )
        return replace(
            case.rod, section=section, rest_strain=lambda s: np.tile(factor * rest, (len(s), 1))
        )

    plain = replace(case.rod, rest_strain=tuple((1.01 * rest).tolist()))
    varied_load = replace(case.load, distributed=lambda s: np.tile(load, (len(s), 1)))
    a = solve_rod(case.rod, case.load, elements=40)
    b = solve_rod(profiled(1.0), varied_load, elements=40)
    near = solve_rod(plain, case.load, elements=40, start=a)
    far = solve_rod(profiled(1.01), case.load, elements=40, start=a)
    assert near.iterations == far.iterations > 0
    # Simpson's means of equal numbers round differently from the number itself.
    for one, other, off in ((a, b, 1e-11), (near, far, 1e-14)):
        np.testing.assert_allclose(other.positions, one.positions, rtol=0.0, atol=off)
        np.testing.assert_allclose(other.moments, one.moments, rtol=0.0, atol=off)
        np.testing.assert_allclose(other.strains, one.strains, rtol=1e-9, atol=1e-10)
        assert other.energy == pytest.approx(one.energy, rel=1e-10)


@pytest.mark.parametrize("direction", [(0.24, 0.0, 0.0), (0.0, 0.2, -0.13)])
def test_both_elements_agree_and_go_on_from_each_other(direction: tuple[float, ...]) -> None:
    load = RodLoad(direction)
    fast = solve_rod(ROD, load, elements=120)
    slow = solve_rod(ROD, load, elements=120, element=RodElement.MIXED)
    assert (fast.element, slow.element) == (RodElement.INEXTENSIBLE, RodElement.MIXED)
    again = solve_rod(ROD, load, elements=120, start=slow)
    back = solve_rod(ROD, load, elements=120, start=fast, element=RodElement.MIXED)
    assert again.element is RodElement.INEXTENSIBLE
    np.testing.assert_allclose(again.positions, fast.positions, atol=1e-9)
    for state in (slow, back):
        np.testing.assert_allclose(state.positions, fast.positions, atol=1e-6 * 0.36)
    np.testing.assert_allclose(slow.orientations, fast.orientations, atol=1e-6)
    for name in ("forces", "moments", "base_reaction"):
        one, other = getattr(fast, name), getattr(slow, name)
        np.testing.assert_allclose(other, one, atol=2e-6 * np.abs(one).max())
    assert fast.touching.shape == (0, 121)
    assert fast.contact_lengths.shape == fast.turns.shape == (0,)


TURNED = tuple(Rotation.from_rotvec((0.4, -0.7, 0.2)).as_quat().tolist())


@pytest.mark.parametrize(
    "base", [Clamped((0.1, 0.0, 0.2), TURNED), Clamped(orientation=(0.0, 0.0, 0.0, -1.0))]
)
def test_a_start_with_another_base_ends_at_the_clamp(base: Clamped) -> None:
    fresh = solve_rod(ROD, HANGING, elements=120)
    elsewhere = solve_rod(ROD, HANGING, elements=120, base=base)
    assert elsewhere.element is RodElement.MIXED
    state = solve_rod(ROD, HANGING, elements=120, start=elsewhere)
    assert state.element is RodElement.INEXTENSIBLE
    assert state.orientations[0] == pytest.approx([0.0, 0.0, 0.0, 1.0], abs=1e-15)
    np.testing.assert_allclose(state.positions, fresh.positions, atol=1e-9)


MIXED_CASES = {
    "obstacle": {"obstacles": (Obstacle(Plane(), position=(0.0, 0.0, -0.2)),)},
    "held tip": {"tip": Pinned((0.3, 0.0, 0.0))},
    "clamped elsewhere": {"base": Clamped((0.1, 0.0, 0.0))},
    "point load": {"point_loads": (PointLoad(0.1, force=(0.0, 0.0, 0.01)),)},
    "stretch": {"section": Section(COUPLED.stiffness, extension=100.0)},
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
    rod, load = replace(ROD, **kind), RodLoad((0.0, 0.02, 0.0))
    state = solve_rod(rod, load, elements=40, **given)
    assert state.stable
    assert state.element is RodElement.MIXED
    with pytest.raises(InvalidInputError, match="element"):
        solve_rod(rod, load, elements=40, element=RodElement.INEXTENSIBLE, **given)


def test_a_problem_is_solved_as_its_parts() -> None:
    problem = RodProblem(ROD, RodLoad((0.2, 0.0, 0.0)))
    state = solve_rod(problem)
    assert state.element is RodElement.INEXTENSIBLE
    np.testing.assert_array_equal(state.positions, solve_rod(ROD, problem.load).positions)
    path = follow_rod([problem, problem])
    assert [each.element for each in path.states] == 2 * [RodElement.INEXTENSIBLE]
    mixed = follow_rod([problem, problem], stop_at_event=True, elements=40)
    assert [each.element for each in mixed.states] == 2 * [RodElement.MIXED]
    listed = solve_rod(ROD, problem.load, elements=40, start=state.positions.tolist())
    assert listed.element is RodElement.MIXED
    coarse = solve_rod(ROD, problem.load, elements=40)
    np.testing.assert_allclose(listed.positions, coarse.positions, atol=1e-5 * 0.36)


def test_sections_are_compared_and_scaled_as_a_whole() -> None:
    scaled = Section.inextensible(3e-4, 2e-4, sideways=1e-4, coupling=-1e-4).scaled(4.0)
    assert scaled == Section.inextensible(12e-4, 8e-4, sideways=4e-4, coupling=-4e-4)
    assert Section(np.eye(6)) == Section(tuple(map(tuple, np.eye(6).tolist())))
    assert Section(np.array([1.0, 2.0, 3.0])) == Section((1.0, 2.0, 3.0))
    assert Section.inextensible(2.5e-4, 1.7e-4) == Section.inextensible(2.5e-4, 1.7e-4, 2.5e-4)
    spelled = Rod(0.36, Section(np.diag((1.7e-4, 2.5e-4, 2.5e-4))), rest_strain=HELIX)
    plain = replace(spelled, section=Section.inextensible(2.5e-4, 1.7e-4))
    np.testing.assert_array_equal(
        solve_rod(plain, LOAD).positions, solve_rod(spelled, LOAD).positions
    )


@pytest.mark.parametrize("scale", [1.0, 0.3, 2.5, 0.7, 1.1, 3.3])
@pytest.mark.parametrize("parts", [2, 3, 4, 6])
def test_equal_pieces_have_equally_many_elements(scale: float, parts: int) -> None:
    """Whatever rounding makes of their lengths."""
    breaks = tuple(0.4 * scale * k / parts for k in range(1, parts))
    stiff = Section.inextensible(1.0, 1.0)
    state = solve_rod(Rod(0.4 * scale, stiff, breaks=breaks), RodLoad())
    ends = [int(np.abs(state.arc_lengths - at).argmin()) for at in (*breaks, 0.4 * scale)]
    assert len(set(np.diff(ends, prepend=0).tolist())) == 1


@pytest.mark.parametrize("stiffness", [(2.5e-4, 5e-3), (5e-3, 2.5e-4), (2.5e-4, 2.5e-4)])
def test_breaks_keep_the_order_where_properties_jump(stiffness: tuple[float, float]) -> None:
    rod = two_tubes(*stiffness)
    tips = [solve_rod(rod, LOAD, elements=n).tip_position for n in (40, 80, 640)]
    errors = [float(np.linalg.norm(tip - tips[-1])) for tip in tips[:-1]]
    assert errors[1] < 1e-6
    assert math.log2(errors[0] / errors[1]) > 3.5  # elements are shared out: not all are halved


@pytest.mark.parametrize(
    "profile",
    [
        lambda s: 3e-4 * (1.0 + np.abs(s - 0.1234)),
        lambda s: 3e-4 * (1.5 + np.tanh((s - 0.15) / 0.01)),
        lambda s: 3e-4 * (1.0 + 0.5 * np.sin(60.0 * s)),
    ],
)
def test_kinks_and_steep_slopes_are_not_jumps(profile) -> None:
    rod = Rod(0.3, Section.varying(profile, 2e-4), rest_strain=(-5.0, 0.0, 10.0))
    state, exact = solve_rod(rod, LOAD), solve_rod(rod, LOAD, elements=2400)
    error = np.linalg.norm(state.tip_position - exact.tip_position)
    assert error < 3.0 * state.discretization_error + 1e-9


@pytest.mark.parametrize("elements", [2, 3, 4, 5, 6, 7, 8])
@pytest.mark.parametrize("turned", [0.5, 3.0, 8.0, 20.0])
def test_few_elements_are_honest(elements: int, turned: float) -> None:
    """Refused where an element turns too far, else an estimate that holds."""
    case = gripper_rod(curvature=turned / 0.36, torsion=0.4 * turned / 0.36)
    if math.hypot(1.0, 0.4) * turned > 2.0 * elements:
        with pytest.raises(InvalidInputError, match="turn by 2 rad at most"):
            solve_rod(case.rod, case.load, elements=elements)
        return
    state = solve_rod(case.rod, case.load, elements=elements, throw=False)
    if state.status is RodStatus.UNRESOLVED:
        assert turned / elements > 0.9
        assert not state.stable
        return
    assert state.stable
    exact = solve_rod(case.rod, case.load, elements=240, start=state)
    error = np.linalg.norm(state.tip_position - exact.tip_position)
    assert error < 1.5 * state.discretization_error
    assert state.discretization_error < 10.0 * max(error, 1e-6)


def test_the_chosen_elements_grow_with_the_rods_turning() -> None:
    for length, torsion in ((0.36, -13.5), (0.9, -20.0)):
        case = gripper_rod(length=length, torsion=torsion)
        state = solve_rod(case.rod, case.load, estimate_error=False)
        assert state.discretization_error is None
        count = len(state.arc_lengths) - 1
        assert count % 2 == 0
        assert count == pytest.approx(length * math.hypot(21.0, torsion) / 0.25, abs=4.0)


@pytest.mark.parametrize("ratio", [1e-3, 1e-2, 0.1, 10.0, 100.0, 1000.0])
def test_any_torsional_stiffness_has_the_elements_it_needs(ratio: float) -> None:
    """And as many where its bending is stated with a breath of anisotropy."""
    rod = Rod(0.36, Section.inextensible(2.5e-4, ratio * 2.5e-4), rest_strain=(-5.0, 0.0, 11.0))
    state = solve_rod(rod, RodLoad((0.1, 0.1, 0.0)))
    count = len(state.arc_lengths) - 1
    exact = solve_rod(rod, RodLoad((0.1, 0.1, 0.0)), elements=2 * count, start=state)
    assert exact.folds == 0
    error = np.linalg.norm(state.tip_position - exact.tip_position) / rod.length
    assert error < 5e-5
    for sideways, coupling in ((1.0 + 1e-12, 0.0), (1.0, 1e-12), (1.003, 0.0)):
        torsional = ratio * 2.5e-4
        section = Section.inextensible(
            2.5e-4, torsional, 2.5e-4 * sideways, coupling * min(torsional, 2.5e-4)
        )
        other = solve_rod(replace(rod, section=section), RodLoad((0.1, 0.1, 0.0)))
        assert len(other.arc_lengths) - 1 == pytest.approx(count, abs=2)


OVERFLOW = RodLoad(tip_force=(0.0, 1e300, 0.0))
TWISTED_TOO_FAR = RodLoad(tip_moment=(5e-3, 0.0, 0.0))
PRESSED = RodLoad((0.0, 0.0, 0.0), (-1.0, 0.01, 0.0))


@pytest.mark.parametrize(
    ("load", "elements", "status"),
    [
        (OVERFLOW, 10, RodStatus.NOT_FINITE),
        (TWISTED_TOO_FAR, 40, None),
        (PRESSED, 3, RodStatus.UNRESOLVED),
    ],
)
def test_what_is_no_answer_is_a_status_not_a_shape(
    load: RodLoad, elements: int, status: RodStatus | None
) -> None:
    """Twisting a straight rod past its limit: no certificate, and the figures say so."""
    state = solve_rod(straight_rod(), load, elements=elements, throw=False)
    assert state.status is (status or state.status)
    assert state.status is not RodStatus.CONVERGED
    assert not state.stable
    with pytest.raises(SolverError) as caught:
        solve_rod(straight_rod(), load, elements=elements)
    assert caught.value.status is state.status
    assert state.status.value in str(caught.value)
    assert caught.value.iterations == state.iterations
    assert isinstance(caught.value.residual, float)
    assert len({each.value for each in RodStatus}) == len(RodStatus)  # each has its own advice
