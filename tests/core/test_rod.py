# SPDX-License-Identifier: Apache-2.0
"""The rod's border: inputs, statuses, warm starts, reproducible results."""

from __future__ import annotations

import math
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from core.rod_cases import GRAVITY, gripper_rod, straight_rod

from spiral_core import InvalidInputError, Rod, RodLoad, RodStatus, SolverError, solve_rod
from spiral_core.rod.types import Section

FREE = RodLoad()


def test_a_warm_start_ends_where_the_path_does() -> None:
    case, near = gripper_rod(), gripper_rod(curvature=21.2, torsion=-13.6)
    cold = solve_rod(near.rod, near.load)
    start = solve_rod(case.rod, case.load)
    warm = solve_rod(near.rod, near.load, start=start)
    assert warm.iterations < cold.iterations / 3
    np.testing.assert_allclose(warm.positions, cold.positions, atol=1e-9)
    resampled = solve_rod(near.rod, near.load, start=start, elements=64)
    direct = solve_rod(near.rod, near.load, elements=64)
    np.testing.assert_allclose(resampled.positions, direct.positions, atol=1e-9)


def test_the_start_is_left_as_it_was() -> None:
    case = gripper_rod()
    start = solve_rod(case.rod, case.load)
    before = start.orientations.copy()
    other = gripper_rod(curvature=30.0)
    solve_rod(other.rod, other.load, start=start, elements=len(before) - 1)
    np.testing.assert_array_equal(start.orientations, before)


DIGEST = """
import hashlib
from spiral_core import Rod, RodLoad, Section, solve_rod
rod = Rod(0.5, Section.inextensible(2.5e-4, 1.7e-4), rest_strain=(-21.0, 0.0, 31.0))
s = solve_rod(rod, RodLoad(distributed=(0.1, -0.2, 0.05), tip_force=(0.0, 0.01, 0.0)))
data = b"".join(a.tobytes() for a in (s.positions, s.orientations, s.moments, s.strains))
print(hashlib.sha256(data + repr((s.energy, s.residual, s.iterations)).encode()).hexdigest())
"""


def test_results_are_bit_identical_in_two_processes() -> None:
    digests = {
        subprocess.run(
            [sys.executable, "-c", DIGEST], check=True, capture_output=True, text=True
        ).stdout
        for _ in range(2)
    }
    assert len(digests) == 1


def test_results_are_bit_identical_in_one_process() -> None:
    case = gripper_rod(gravity=(0.2, -0.9, 0.3))
    a, b = (solve_rod(case.rod, case.load) for _ in range(2))
    for field in ("positions", "orientations", "moments", "strains", "forces"):
        np.testing.assert_array_equal(getattr(a, field), getattr(b, field))
    assert (a.energy, a.residual, a.smallest_pivot) == (b.energy, b.residual, b.smallest_pivot)


def test_constant_functions_are_constants() -> None:
    case = gripper_rod(gravity=(0.2, -0.9, 0.3))
    assert not callable(case.load.distributed)
    weight = np.array(case.load.distributed)
    same = Rod(
        case.rod.length,
        Section.varying(
            lambda s: np.full(len(s), case.rod.section.bending),
            lambda s: np.full(len(s), case.rod.section.torsional),
        ),
        rest_strain=lambda s: np.tile((-13.5, 0.0, 21.0), (len(s), 1)),
    )
    a = solve_rod(case.rod, case.load, elements=40)
    b = solve_rod(same, RodLoad(lambda s: np.tile(weight, (len(s), 1))), elements=40)
    np.testing.assert_allclose(b.positions, a.positions, atol=1e-11)
    np.testing.assert_allclose(b.energy, a.energy, rtol=1e-10)


@pytest.mark.parametrize("field", ["length", "bending", "torsional"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf, True, "1"])
def test_rods_refuse_bad_constants_by_name(field: str, value: object) -> None:
    values: dict[str, object] = {"length": 0.3, "bending": 1e-4, "torsional": 1e-4, field: value}
    with pytest.raises(InvalidInputError) as caught:
        Rod(values.pop("length"), Section.inextensible(**values))  # type: ignore[arg-type]
    assert caught.value.field == field


@pytest.mark.parametrize(
    ("rod", "weight"),
    [
        (Rod(300000.0, Section.inextensible(1e-4, 1e-4), rest_strain=(0.0, 0.0, 20.0)), 0.2),
        (Rod(0.3, Section.inextensible(1e-4, 1e-4), rest_strain=(0.0, 0.0, 1e300)), 0.2),
        (Rod(0.3, Section.inextensible(1e-300, 1e-300), rest_strain=(0.0, 0.0, 20.0)), 0.2),
        (Rod(0.3, Section.inextensible(1e-4, 1e-4), rest_strain=(0.0, 0.0, 20.0)), 1e300),
    ],
)
def test_rods_that_need_endless_elements_are_refused_at_once(rod: Rod, weight: float) -> None:
    with pytest.raises(InvalidInputError, match=r"elements must be at most 20000 .* SI units"):
        solve_rod(rod, RodLoad((weight, 0.0, 0.0)))


@pytest.mark.parametrize("field", ["distributed", "tip_force", "tip_moment"])
@pytest.mark.parametrize("value", [(1.0, 2.0), (1.0, 2.0, math.nan), 3.0, "abc"])
def test_loads_refuse_bad_vectors_by_name(field: str, value: object) -> None:
    with pytest.raises(InvalidInputError) as caught:
        RodLoad(**{field: value})  # type: ignore[arg-type]
    assert caught.value.field == field


def test_the_rest_strain_is_refused_by_name() -> None:
    with pytest.raises(InvalidInputError) as caught:
        Rod(0.3, Section.inextensible(1e-4, 1e-4), rest_strain=(1.0, math.inf, 0.0))
    assert caught.value.field == "rest_strain"


@pytest.mark.parametrize("value", [np.nan, -1.0, 0.0])
@pytest.mark.parametrize("field", ["bending", "torsional"])
def test_profiles_of_bad_values_are_named(field: str, value: float) -> None:
    values = {"bending": 1e-4, "torsional": 1e-4}
    profile = lambda s: np.where(s > 0.2, value, 1e-4)  # noqa: E731
    rod = Rod(0.3, Section.varying(**{**values, field: profile}))  # type: ignore[arg-type]
    with pytest.raises(InvalidInputError) as caught:
        solve_rod(rod, FREE)
    assert caught.value.field == (field if math.isnan(value) else "section")


def test_profiles_of_the_wrong_shape_are_named() -> None:
    flat = Rod(0.3, Section.inextensible(1e-4, 1e-4), rest_strain=lambda s: np.ones(len(s)))
    with pytest.raises(InvalidInputError) as caught:
        solve_rod(flat, FREE)
    assert caught.value.field == "rest_strain"
    load = RodLoad(distributed=lambda s: np.full((len(s), 3), np.nan))
    with pytest.raises(InvalidInputError) as caught:
        solve_rod(straight_rod(), load, elements=10)
    assert caught.value.field == "distributed"
    scalar = Rod(0.3, Section.varying(lambda s: np.ones((len(s), 1)), 1e-4))
    with pytest.raises(InvalidInputError) as caught:
        solve_rod(scalar, FREE)
    assert caught.value.field == "bending"


@pytest.mark.parametrize("elements", [0, 1, -5, True, 2.5, "10", 20_001])
def test_a_bad_number_of_elements_is_refused(elements: object) -> None:
    with pytest.raises(InvalidInputError) as caught:
        solve_rod(straight_rod(), FREE, elements=elements)  # type: ignore[arg-type]
    assert caught.value.field == "elements"
    assert caught.value.value is elements


def test_overflow_ends_as_a_status_not_as_a_shape() -> None:
    load = RodLoad(tip_force=(0.0, 1e300, 0.0))
    state = solve_rod(straight_rod(), load, elements=10, throw=False)
    assert state.status is RodStatus.NOT_FINITE
    assert not state.stable
    with pytest.raises(SolverError) as caught:
        solve_rod(straight_rod(), load, elements=10)
    assert caught.value.status is RodStatus.NOT_FINITE
    assert RodStatus.NOT_FINITE.value in str(caught.value)


def test_a_moment_past_what_any_state_balances_is_said_to_be_unstable() -> None:
    """Twisting a straight rod far past its limit: no certificate, and the figures say so."""
    load = RodLoad(tip_moment=(5e-3, 0.0, 0.0))
    state = solve_rod(straight_rod(), load, elements=40, throw=False)
    assert state.status is not RodStatus.CONVERGED
    assert not state.stable
    with pytest.raises(SolverError) as caught:
        solve_rod(straight_rod(), load, elements=40)
    assert caught.value.status is state.status
    assert caught.value.iterations == state.iterations > 0
    assert isinstance(caught.value.residual, float)


def test_gravity_of_the_cases_is_standard() -> None:
    """The cases' weight is that of the paper's tube: 0.24 N/m."""
    assert gripper_rod().load.distributed[0] == pytest.approx(0.2395, rel=0.01)  # type: ignore[index]
    assert GRAVITY == 9.80665


def test_the_uniform_rods_short_way_gives_the_same_state() -> None:
    case = gripper_rod(gravity=(5.0, -6.0, 4.0), tip_force=(0.01, 0.02, -0.01))
    start = solve_rod(case.rod, case.load, elements=40, estimate_error=False)
    rest = case.rod.rest_strain
    assert not callable(rest)
    bent = replace(case.rod, rest_strain=tuple(1.01 * u for u in rest))
    constant = np.array(bent.rest_strain)
    profiled = replace(bent, rest_strain=lambda s: np.tile(constant, (len(s), 1)))
    short = solve_rod(bent, case.load, elements=40, start=start, estimate_error=False)
    general = solve_rod(profiled, case.load, elements=40, start=start, estimate_error=False)
    assert short.iterations == general.iterations > 0
    # Simpson's means of equal numbers round differently from the number itself.
    np.testing.assert_allclose(short.positions, general.positions, rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(short.moments, general.moments, rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(short.strains, general.strains, rtol=1e-10, atol=1e-10)
    assert short.energy == pytest.approx(general.energy, rel=1e-12)
