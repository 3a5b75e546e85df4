# SPDX-License-Identifier: Apache-2.0
"""The closed form against the integrated frame, through every singular corner."""

from __future__ import annotations

import math

import numpy as np
import pytest
from core.actuator_cases import repeatable
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from spiral_core import (
    Helix,
    InvalidInputError,
    helix_from_curvature,
    helix_orientations,
    helix_positions,
)

# Curvatures and torsions of grippers, and near-singular ones [1/m].
rates = st.one_of(st.floats(0.1, 60.0), st.sampled_from([0.0, 1e-300, 1e-12, 1e-8, 1e-4]))
signed_rates = st.one_of(rates, rates.map(lambda rate: -rate))
LENGTH = 0.5
ARC = np.linspace(0.0, LENGTH, 41)


def integrated(curvature: float, torsion: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return positions and frames (columns x, y, z) from the frame's differential equation."""
    skew = np.array([[0, -curvature, 0], [curvature, 0, -torsion], [0, torsion, 0]], dtype=float)

    def slope(_: float, state: NDArray[np.float64]) -> NDArray[np.float64]:
        frame = state[3:].reshape(3, 3)
        return np.concatenate([frame[:, 0], (frame @ skew).ravel()])

    start = np.concatenate([np.zeros(3), np.eye(3).ravel()])
    result = solve_ivp(
        slope, (0.0, LENGTH), start, method="DOP853", t_eval=ARC, rtol=1e-12, atol=1e-13
    )
    return result.y[:3].T, result.y[3:].T.reshape(-1, 3, 3)


CORNERS = [
    (20.0, -12.0),
    (20.0, 12.0),
    (60.0, 50.0),
    (20.0, 0.0),
    (20.0, 1e-9),
    (0.0, 15.0),
    (1e-9, 15.0),
    (1e-9, -1e-9),
    (1e-3, 1e-3),
    (0.0, 0.0),
]


@pytest.mark.parametrize(("curvature", "torsion"), CORNERS)
def test_positions_and_frames_solve_the_frame_equation(curvature: float, torsion: float) -> None:
    positions, frames = integrated(curvature, torsion)
    # The integrator's tolerance, 1e-12 a step.
    np.testing.assert_allclose(helix_positions(curvature, torsion, ARC), positions, atol=1e-11)
    closed = Rotation.from_quat(helix_orientations(curvature, torsion, ARC)).as_matrix()
    np.testing.assert_allclose(closed, frames, atol=1e-9)


@repeatable
@given(curvature=signed_rates, torsion=signed_rates)
def test_centerline_has_unit_speed_along_the_frames_x(curvature: float, torsion: float) -> None:
    h = 1e-4
    ahead, behind = (helix_positions(curvature, torsion, ARC + d) for d in (h, -h))
    far_ahead, far_behind = (helix_positions(curvature, torsion, ARC + d) for d in (2 * h, -2 * h))
    speed = (8.0 * (ahead - behind) - (far_ahead - far_behind)) / (12.0 * h)
    tangents = Rotation.from_quat(helix_orientations(curvature, torsion, ARC)).as_matrix()[:, :, 0]
    # The differences' own error, (k h)^4 / 30 at k = 85 per meter, is 2e-10.
    np.testing.assert_allclose(speed, tangents, atol=3e-10)


@repeatable
@given(curvature=rates.filter(lambda k: k >= 0.1), torsion=signed_rates)
def test_points_lie_on_a_cylinder_of_the_helix_radius(curvature: float, torsion: float) -> None:
    helix = Helix(curvature, torsion)
    axis = np.array([torsion, 0.0, curvature]) / helix.angular_rate
    center = np.array([0.0, helix.radius, 0.0])
    offsets = helix_positions(curvature, torsion, ARC) - center
    along = offsets @ axis
    distance = np.linalg.norm(offsets - np.outer(along, axis), axis=1)
    np.testing.assert_allclose(
        distance, helix.radius, rtol=1e-12, atol=1e-13 * helix.radius + 1e-15
    )
    # Signed advance: positive pitch and positive turns go together along the axis.
    expected = helix.pitch * helix.turns(LENGTH)
    assert along[-1] == pytest.approx(expected, rel=1e-12, abs=1e-14)


@repeatable
@given(curvature=signed_rates, torsion=signed_rates)
def test_orientations_are_unit_and_continuous(curvature: float, torsion: float) -> None:
    quaternions = helix_orientations(curvature, torsion, ARC)
    np.testing.assert_allclose(np.linalg.norm(quaternions, axis=1), 1.0, rtol=1e-14)
    assert np.all(np.sum(quaternions[1:] * quaternions[:-1], axis=1) > 0.0)


@repeatable
@given(curvature=signed_rates, torsion=signed_rates)
def test_mirror_image_in_the_bending_plane(curvature: float, torsion: float) -> None:
    positions = helix_positions(curvature, torsion, ARC)
    mirrored = helix_positions(curvature, -torsion, ARC)
    np.testing.assert_array_equal(mirrored, positions * [1.0, 1.0, -1.0])


@repeatable
@given(curvature=rates, torsion=signed_rates)
def test_continuing_from_a_point_is_the_same_helix(curvature: float, torsion: float) -> None:
    half = LENGTH / 2.0
    start = helix_positions(curvature, torsion, [half])[0]
    turned = Rotation.from_quat(helix_orientations(curvature, torsion, [half])[0])
    continued = start + turned.apply(helix_positions(curvature, torsion, ARC[:20]))
    np.testing.assert_allclose(
        continued, helix_positions(curvature, torsion, half + ARC[:20]), atol=2e-15
    )


@pytest.mark.parametrize("angle", [0.999999, 1.0, 1.000001])
def test_series_and_formula_meet(angle: float) -> None:
    x, _, z = helix_positions(0.6, 0.8, [angle])[0]
    deficit = angle - math.sin(angle)  # k = 1
    assert x == pytest.approx(angle - 0.36 * deficit, rel=1e-15)
    assert z == pytest.approx(0.48 * deficit, rel=1e-14)


def test_circle_bends_towards_y_and_returns() -> None:
    quarter = math.pi / 2.0 / 10.0
    positions = helix_positions(10.0, 0.0, [quarter, 2.0 * quarter, 4.0 * quarter])
    expected = [[0.1, 0.1, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.0]]
    np.testing.assert_allclose(positions, expected, atol=1e-16)


def test_right_handed_coil_advances_right_handed() -> None:
    # Seen from the end it advances towards, a right-handed helix turns counterclockwise.
    positions = helix_positions(20.0, 5.0, np.linspace(0.0, 0.3, 50))
    axis = np.array([5.0, 0.0, 20.0])
    radial = positions - [0.0, Helix(20.0, 5.0).radius, 0.0]
    turning = np.cross(radial[:-1], radial[1:]) @ axis
    advance = np.diff(positions @ axis)
    assert np.all(turning * advance > 0.0)


@repeatable
@given(
    curvature=st.floats(1.0, 60.0),
    torsion=st.one_of(st.floats(-50.0, 50.0), st.just(0.0)),
    turns=st.floats(0.0, 5.0),
)
def test_lengths_and_turns_are_consistent(curvature: float, torsion: float, turns: float) -> None:
    helix = helix_from_curvature(curvature, torsion)
    length = helix.length_for_turns(turns)
    assert helix.turns(length) == pytest.approx(turns, rel=1e-14)
    unrolled = turns * math.hypot(2.0 * math.pi * helix.radius, helix.pitch)
    assert length == pytest.approx(unrolled, rel=1e-13)
    advance = helix.object_length(turns)
    projected = length * math.cos(helix.helix_angle)
    assert advance == pytest.approx(projected, rel=1e-12, abs=1e-15 * length)
    assert helix.radius == pytest.approx(math.sin(helix.helix_angle) ** 2 / curvature, rel=1e-13)
    assert helix.object_radius(5.0e-3) == helix.radius - 5.0e-3
    assert math.copysign(1.0, helix.pitch) == math.copysign(1.0, torsion)


def test_helix_of_zero_torsion_is_a_circle() -> None:
    helix = Helix(20.0, 0.0)
    assert (helix.radius, helix.pitch, helix.helix_angle) == (0.05, 0.0, math.pi / 2.0)
    assert helix.object_length(3.0) == 0.0


def test_nothing_fits_a_coil_filled_by_its_tube() -> None:
    assert Helix(200.0, 0.0).object_radius(6.0e-3) == pytest.approx(-1.0e-3)


def test_huge_and_tiny_rates_neither_overflow_nor_vanish() -> None:
    assert Helix(1e200, 1e200).radius == pytest.approx(0.5e-200)
    assert Helix(1e-200, 0.0).radius == pytest.approx(1e200)


@pytest.mark.parametrize("curvature", [0.0, -1.0, math.nan, math.inf])
def test_curvature_must_be_positive(curvature: float) -> None:
    with pytest.raises(InvalidInputError, match="curvature must be a positive"):
        helix_from_curvature(curvature, 10.0)


@pytest.mark.parametrize("torsion", [math.nan, math.inf])
def test_torsion_must_be_finite(torsion: float) -> None:
    with pytest.raises(InvalidInputError, match="torsion"):
        helix_from_curvature(20.0, torsion)
    with pytest.raises(InvalidInputError, match="torsion"):
        helix_positions(20.0, torsion, ARC)
    with pytest.raises(InvalidInputError, match="torsion"):
        helix_orientations(20.0, torsion, ARC)


@pytest.mark.parametrize("arc_lengths", [0.1, [[0.1]], [math.nan], ["a"], None], ids=repr)
def test_arc_lengths_must_be_a_finite_row(arc_lengths: object) -> None:
    for function in (helix_positions, helix_orientations):
        with pytest.raises(InvalidInputError, match="one-dimensional"):
            function(20.0, 10.0, arc_lengths)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("method", "value"),
    [("turns", -0.1), ("length_for_turns", -1.0), ("object_length", -1.0), ("object_radius", 0.0)],
)
def test_counts_and_lengths_must_not_be_negative(method: str, value: float) -> None:
    with pytest.raises(InvalidInputError):
        getattr(Helix(20.0, 10.0), method)(value)


def test_empty_arc_gives_empty_arrays() -> None:
    assert helix_positions(20.0, 10.0, []).shape == (0, 3)
    assert helix_orientations(20.0, 10.0, []).shape == (0, 4)
