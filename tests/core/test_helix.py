# SPDX-License-Identifier: Apache-2.0
"""The helix of constant curvature and torsion."""

from __future__ import annotations

import math

import pytest
from core.actuator_cases import repeatable
from hypothesis import given
from hypothesis import strategies as st

from spiral_core.wrap.helix import Helix


@repeatable
@given(
    curvature=st.floats(1.0, 60.0),
    torsion=st.one_of(st.floats(-50.0, 50.0), st.just(0.0)),
    turns=st.floats(0.0, 5.0),
)
def test_lengths_and_turns_are_consistent(curvature: float, torsion: float, turns: float) -> None:
    helix = Helix(curvature, torsion)
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
