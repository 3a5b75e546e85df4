# SPDX-License-Identifier: Apache-2.0
"""What random rods never meet: symmetric loads, jumps, few elements, soft modes, bad arguments."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from core.reference_shooting import Rods, shoot
from core.rod_cases import gripper_rod, straight_rod

from spiral_core import (
    InvalidInputError,
    Rod,
    RodCertificate,
    RodLoad,
    RodStatus,
    Section,
    SolverError,
    find_equilibria,
    solve_rod,
    solve_rods,
)
from spiral_core.rod.path import follow_path

AXES = [tuple(sign * row) for row in np.eye(3) for sign in (-1.0, 1.0)]
TILTS = (0.0, 1e-12, 1e-11, 1e-10, 1e-9, 1e-6, 1e-3)


@pytest.mark.parametrize("length", np.linspace(0.3, 1.0, 15))
def test_an_upright_gripper_is_solved_at_every_length(length: float) -> None:
    rod = Rod(length, Section.inextensible(2.06e-4, 1.37e-4), rest_strain=(-13.5, 0.0, 21.0))
    state = solve_rod(rod, RodLoad((-0.2347, 0.0, 0.0)), estimate_error=False)
    assert state.certificate is RodCertificate.STRICT_MINIMUM


@pytest.mark.parametrize("tilt", TILTS)
@pytest.mark.parametrize("heaviness", [9.0, 60.0, 300.0, 1000.0])
def test_a_straight_rod_buckles_to_the_side_it_leans_to(tilt: float, heaviness: float) -> None:
    """Upright: a circle of equal minima. However small a tilt, it picks one of them."""
    load = RodLoad((-heaviness * math.cos(tilt), 0.6 * heaviness * math.sin(tilt), 0.0))
    state = solve_rod(Rod(1.0, Section.inextensible(1.0, 0.66)), load)
    assert state.stable
    if tilt == 0.0:
        assert state.neutral_modes == 1
        assert state.certificate is RodCertificate.STABLE_UP_TO_ROTATION
    if tilt >= 1e-6:
        assert state.certificate is RodCertificate.STRICT_MINIMUM
    if tilt > 0.0:
        _, y, z = state.tip_position
        across = state.positions[:, 1:].sum(axis=0)
        assert abs(z) <= 0.01
        assert math.hypot(y, z) > 0.05
        assert across @ (1.0, 0.0) > 0.0  # the load pulls it to +y
    assert state.discretization_error is not None
    assert state.discretization_error < 1e-3


def test_the_neutral_mode_is_a_zero_of_the_energy() -> None:
    """Turned about the axis the state is one of the same energy, and as good a solution."""
    rod, load = Rod(1.0, Section.inextensible(1.0, 0.66)), RodLoad((-30.0, 0.0, 0.0))
    state = solve_rod(rod, load)
    angle = 1.1
    turn = np.array([math.sin(angle / 2), 0.0, 0.0, math.cos(angle / 2)])
    x, y, z, w = state.orientations.T
    s, c = turn[0], turn[3]
    left = np.array([c * x + s * w, c * y - s * z, c * z + s * y, c * w - s * x])
    x, y, z, w = left
    both = np.column_stack((c * x - s * w, c * y - s * z, c * z + s * y, c * w + s * x))
    turned = solve_rod(rod, load, start=replace(state, orientations=both))
    assert turned.folds == 0
    assert turned.energy == pytest.approx(state.energy, rel=1e-12)
    assert turned.neutral_modes == 1
    cosine, sine = math.cos(angle), math.sin(angle)
    y, z = state.tip_position[1:]
    expected = (cosine * y - sine * z, sine * y + cosine * z)
    np.testing.assert_allclose(turned.tip_position[1:], expected, atol=1e-9)


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("strain", [(0.0, 0.0, 0.0), (9.0, 0.0, 0.0), (0.0, 0.0, 14.0)])
def test_loads_along_every_axis_are_solved(
    axis: tuple[float, float, float], strain: tuple[float, float, float]
) -> None:
    for heaviness in (20.0, 200.0):
        weight = tuple(heaviness * component for component in axis)
        for pull in (-5.0, 0.0, 5.0):
            state = solve_rod(
                Rod(1.0, Section.inextensible(1.0, 0.66), rest_strain=strain),
                RodLoad(weight, (pull, 0.0, 0.0)),
            )
            assert state.stable
            assert state.residual <= 1e-8
            assert state.last_step <= 1e-6


def piecewise(stiffness: tuple[float, float], at: float) -> Rod:
    """Return a rod of two tubes."""
    near, far = stiffness
    return Rod(
        0.36,
        Section.varying(
            lambda s: np.where(s < at, near, far),
            lambda s: np.where(s < at, 0.66 * near, 0.66 * far),
        ),
        rest_strain=lambda s: np.where(s[:, None] < at, (-13.5, 0.0, 21.0), (4.0, 0.0, -10.0)),
        breaks=(at,),
    )


LOAD = RodLoad((0.24, 0.05, 0.0), (0.01, 0.0, 0.02))


@pytest.mark.parametrize("stiffness", [(2.5e-4, 5e-3), (5e-3, 2.5e-4), (2.5e-4, 2.5e-4)])
def test_breaks_keep_the_order_where_properties_jump(stiffness: tuple[float, float]) -> None:
    rod = piecewise(stiffness, 0.131)
    exact = solve_rod(rod, LOAD, elements=640, estimate_error=False).tip_position
    errors = [
        float(
            np.linalg.norm(
                solve_rod(rod, LOAD, elements=n, estimate_error=False).tip_position - exact
            )
        )
        for n in (40, 80)
    ]
    assert errors[1] < 1e-6
    assert math.log2(errors[0] / errors[1]) > 3.5  # elements are shared out: not all are halved


def test_a_rod_of_two_tubes_agrees_with_shooting() -> None:
    """Two pieces, each integrated with its own constants: the second from where the first ends."""
    rod = piecewise((2.5e-4, 5e-3), 0.18)
    state = solve_rod(rod, LOAD)

    # The reference's steps fall on the jump: its profile is a function of s / L.
    def k(x: float) -> np.ndarray:
        value = 2.5e-4 if x < 0.5 else 5e-3
        return np.array([[0.66 * value, value, value]])

    def u(x: float) -> np.ndarray:
        return np.array([[-13.5, 0.0, 21.0] if x < 0.5 else [4.0, 0.0, -10.0]])

    weight, force = np.array([LOAD.distributed]), np.array([LOAD.tip_force])
    rods = Rods(np.array([0.36]), k, u, weight, force, np.zeros((1, 3)))
    found = shoot(rods, np.array(state.orientations[-1:]), np.array([0.0, 1.0]))
    assert found.miss.max() < 1e-7
    # An adaptive integrator steps over a jump to its tolerance, about 1e-6.
    np.testing.assert_allclose(state.tip_position, found.positions[0, -1], atol=2e-6)
    assert state.discretization_error is not None
    assert state.discretization_error < 1e-5


@pytest.mark.parametrize("given", ["bending", "torsional", "rest_strain"])
@pytest.mark.parametrize("size", [1e-3, 1.0, 20.0])
def test_a_jump_that_no_break_declares_is_refused(given: str, size: float) -> None:
    def step(s: np.ndarray) -> np.ndarray:
        return 1.0 + size * (s > 0.1234)

    plain = Rod(0.3, Section.inextensible(3e-4, 2e-4), rest_strain=(-5.0, 0.0, 10.0))
    field, profile = {
        "bending": ("section", Section.varying(lambda s: 3e-4 * step(s), 2e-4)),
        "torsional": ("section", Section.varying(3e-4, lambda s: 2e-4 * step(s))),
        "rest_strain": ("rest_strain", lambda s: step(s)[:, None] * (-5.0, 0.0, 10.0)),
    }[given]
    for solve in (solve_rod, find_equilibria):
        with pytest.raises(InvalidInputError, match=r"a jump at 0\.1234 m") as caught:
            solve(replace(plain, **{field: profile}), LOAD)
        assert caught.value.field == field
    with pytest.raises(InvalidInputError, match="breaks"):
        follow_path([replace(plain, **{field: profile})], LOAD)
    assert solve_rod(replace(plain, **{field: profile}, breaks=(0.1234,)), LOAD).stable


def test_kinks_and_steep_slopes_are_not_jumps() -> None:
    for profile in (
        lambda s: 3e-4 * (1.0 + np.abs(s - 0.1234)),
        lambda s: 3e-4 * (1.5 + np.tanh((s - 0.15) / 0.01)),
        lambda s: 3e-4 * (1.0 + 0.5 * np.sin(60.0 * s)),
    ):
        state = solve_rod(
            Rod(0.3, Section.varying(profile, 2e-4), rest_strain=(-5.0, 0.0, 10.0)), LOAD
        )
        exact = solve_rod(replace_elements(state, profile), LOAD, elements=2400)
        error = np.linalg.norm(state.tip_position - exact.tip_position)
        assert state.discretization_error is not None
        assert error < 3.0 * state.discretization_error + 1e-9


def replace_elements(_: object, profile: object) -> Rod:
    """Return the rod of the test above."""
    return Rod(0.3, Section.varying(profile, 2e-4), rest_strain=(-5.0, 0.0, 10.0))  # type: ignore[arg-type]


@pytest.mark.parametrize("elements", [2, 3, 4, 5, 6, 7, 8])
def test_few_elements_are_honest(elements: int) -> None:
    """Refused where an element turns too far, else an estimate that holds."""
    for turned in (0.5, 3.0, 8.0, 20.0):
        case = gripper_rod(curvature=turned / 0.36, torsion=0.4 * turned / 0.36)
        if math.hypot(1.0, 0.4) * turned > 2.0 * elements:
            with pytest.raises(InvalidInputError, match="turn by 2 rad at most"):
                solve_rod(case.rod, case.load, elements=elements)
            continue
        state = solve_rod(case.rod, case.load, elements=elements, throw=False)
        if state.status is RodStatus.UNRESOLVED:
            assert turned / elements > 0.9
            assert not state.stable
            continue
        assert state.stable
        exact = solve_rod(case.rod, case.load, elements=240, start=state)
        error = np.linalg.norm(state.tip_position - exact.tip_position)
        assert state.discretization_error is not None
        assert error < 1.5 * state.discretization_error
        assert state.discretization_error < 10.0 * max(error, 1e-6)


@pytest.mark.parametrize("ratio", [1e-3, 1e-2, 0.1, 10.0, 100.0, 1000.0])
def test_any_torsional_stiffness_has_the_elements_it_needs(ratio: float) -> None:
    rod = Rod(0.36, Section.inextensible(2.5e-4, ratio * 2.5e-4), rest_strain=(-5.0, 0.0, 11.0))
    state = solve_rod(rod, RodLoad((0.1, 0.1, 0.0)))
    count = 2 * (len(state.arc_lengths) - 1)
    exact = solve_rod(rod, RodLoad((0.1, 0.1, 0.0)), elements=count, start=state)
    assert exact.folds == 0
    error = np.linalg.norm(state.tip_position - exact.tip_position) / rod.length
    assert error < 5e-5


def test_a_soft_rod_converges_in_its_shape_not_only_in_its_forces() -> None:
    """Polished further, the tip stays: the Newton step that is left is small."""
    rng = np.random.default_rng(3)
    for _ in range(20):
        case = gripper_rod(
            length=rng.uniform(0.8, 1.0),
            modulus=0.5e6,
            curvature=rng.uniform(3.0, 10.0),
            gravity=(-1.0, *(1e-4 * rng.normal(size=2))),
        )
        state = solve_rod(case.rod, case.load)
        again = solve_rod(case.rod, case.load, start=state)
        assert state.discretization_error is not None
        moved = np.linalg.norm(again.tip_position - state.tip_position)
        assert moved < 1e-6 * case.rod.length + state.discretization_error
        assert state.last_step <= 1e-6


def test_states_are_read_only() -> None:
    state = solve_rod(straight_rod(), LOAD, estimate_error=False)
    arrays = ("arc_lengths", "positions", "orientations", "forces", "moments", "strains")
    for name in arrays:
        with pytest.raises(ValueError, match="read-only"):
            getattr(state, name)[0] = 0.0


ROD = straight_rod()


@pytest.mark.parametrize("elements", [-5, 0, 1, True, 2.5, "a", 20_001])
def test_bad_numbers_of_elements_are_refused_everywhere(elements: object) -> None:
    for call in (
        lambda: solve_rod(ROD, LOAD, elements=elements),  # type: ignore[arg-type]
        lambda: follow_path([ROD], LOAD, elements=elements),  # type: ignore[arg-type]
        lambda: find_equilibria(ROD, LOAD, elements=elements),  # type: ignore[arg-type]
        lambda: solve_rods(0.3, 1.0, 1.0, (0, 0, 1), (1, 0, 0), elements=elements),  # type: ignore[arg-type]
    ):
        with pytest.raises(InvalidInputError) as caught:
            call()
        assert caught.value.field == "elements"
        assert caught.value.value is elements


def test_what_is_no_start_is_refused() -> None:
    state = solve_rod(ROD, LOAD, elements=10)
    short = replace(state, orientations=state.orientations[:5])
    single = replace(state, orientations=state.orientations[:1], arc_lengths=np.zeros(1))
    unknown = replace(state, orientations=state.orientations * np.nan)
    for start in (short, single, unknown, "a", state.orientations):
        for call in (
            lambda start=start: solve_rod(ROD, LOAD, start=start),
            lambda start=start: follow_path([ROD], LOAD, start=start),
        ):
            with pytest.raises(InvalidInputError) as caught:
                call()
            assert caught.value.field == "start"


@pytest.mark.parametrize("breaks", [(0.0,), (0.5,), (0.3, 0.2), (0.2, 0.2), ("a",), 0.2, (np.nan,)])
def test_breaks_lie_in_order_between_the_ends(breaks: object) -> None:
    with pytest.raises(InvalidInputError) as caught:
        Rod(0.5, Section.inextensible(1.0, 1.0), breaks=breaks)  # type: ignore[arg-type]
    assert caught.value.field == "breaks"


def test_bad_rods_loads_and_stations_are_refused() -> None:
    for call, field in (
        (lambda: solve_rod("rod", LOAD), "rod"),  # type: ignore[arg-type]
        (lambda: solve_rod(ROD, (1.0, 0.0, 0.0)), "load"),  # type: ignore[arg-type]
        (lambda: follow_path([], LOAD), "rods"),
        (lambda: follow_path(ROD, LOAD), "rods"),  # type: ignore[arg-type]
        (lambda: follow_path([ROD], [LOAD, LOAD]), "loads"),
        (lambda: follow_path([ROD], 3.0), "loads"),  # type: ignore[arg-type]
        (lambda: follow_path([ROD, replace(ROD, breaks=(0.1,))], LOAD), "rods"),
        (lambda: find_equilibria(ROD, LOAD, seed=-1), "seed"),
        (lambda: find_equilibria(ROD, LOAD, starts=0), "starts"),
    ):
        with pytest.raises(InvalidInputError) as caught:
            call()
        assert caught.value.field == field


def test_an_element_that_turns_too_far_is_refused() -> None:
    """At rest: before the solve. Under load: by its status."""
    with pytest.raises(InvalidInputError, match="at least 8, for each to turn by 2 rad") as caught:
        solve_rod(
            Rod(0.36, Section.inextensible(2.5e-4, 1.7e-4), rest_strain=(0.0, 0.0, 40.0)),
            LOAD,
            elements=3,
        )
    assert caught.value.field == "elements"
    with pytest.raises(SolverError, match="use more elements") as failed:
        solve_rod(straight_rod(), RodLoad((0.0, 0.0, 0.0), (-1.0, 0.01, 0.0)), elements=3)
    assert failed.value.status is RodStatus.UNRESOLVED
