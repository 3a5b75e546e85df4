# SPDX-License-Identifier: Apache-2.0
"""The section law for any set of fibers: helical, two, one family; what is refused."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from core.actuator_cases import PAPER_TUBE
from core.section_cases import one_family, section, uniform
from numpy.typing import NDArray

from spiral_core import (
    CurvatureForm,
    FreeActuation,
    InvalidInputError,
    NeoHookean,
    PressureLaw,
    SingleFiber,
    design_space,
)
from spiral_core.actuator import section as section_module
from spiral_core.actuator.curvature import longest_stretch, unloaded_shape_from_stretch
from spiral_core.actuator.fibers import fiber_state
from spiral_core.actuator.section import Array, FiberSet, closures, section_path
from spiral_core.actuator.uniform_law import pressure_from_stretch

pytestmark = pytest.mark.long


def test_small_strain_of_a_hoop_family_is_three_halves_too() -> None:
    bent = section(90.0, 89.9)  # as good as no twist
    ratio = pressure_from_stretch(bent, 1.0 + 1e-7) / pressure_from_stretch(
        uniform(bent), 1.0 + 1e-7
    )
    assert ratio == pytest.approx(1.5, abs=1e-5)


def test_a_helical_fiber_coils_at_rest_as_it_is_wound() -> None:
    shape = FreeActuation(section(88.0, 60.0, gamma=20.0)).unloaded_shape(0.0)
    assert shape.curvature == 0.0
    assert shape.torsion == pytest.approx(math.tan(math.radians(20.0)) / PAPER_TUBE.inner_radius)


def test_the_end_of_a_steep_fibers_path_is_found_in_few_states(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Where the section stops closing each state is dear: it is found in some ten rounds."""
    rounds = []

    def counted(fibers: FiberSet, strains: Array) -> tuple[Array, NDArray[np.bool_]]:
        rounds.append(len(strains))
        return closures(fibers, strains)

    monkeypatch.setattr(section_module, "closures", counted)
    fibers = section(88.0, 60.0, gamma=-60.0).fiber_set
    found = section_path.__wrapped__(fibers)
    assert len(rounds) < 30
    up_to_end = np.linspace(0.0, found.edges[-1], 97)[1:]
    assert closures(fibers, up_to_end)[1].all()


def test_two_fibers_bend_as_one_when_they_meet() -> None:
    one, two = FreeActuation(section(88.0, 60.0)), FreeActuation(section(88.0, 60.0, apart=0.2))
    shape, other = one.unloaded_shape(60.0e3), two.unloaded_shape(60.0e3)
    assert other.curvature == pytest.approx(shape.curvature, rel=1e-5)  # cos(0.1 deg)
    assert other.torsion == pytest.approx(shape.torsion, rel=1e-5)


def test_a_contracting_tube_shortens_unless_a_single_fiber_would_have_to_push() -> None:
    actuation = FreeActuation(section(45.0, -45.0).without_single_fibers())
    assert actuation.stretch_limit < actuation.stretch_from_pressure(20.0e3) < 1.0
    with pytest.raises(InvalidInputError, match="at most 1"):
        actuation.pressure_from_stretch(1.01)
    with pytest.raises(InvalidInputError, match="pair that extends"):
        FreeActuation(section(45.0, -45.0))


@pytest.mark.parametrize(
    ("choices", "match"),
    [
        ({"twist_shear": False}, "twist_shear"),
        ({"thick_wall": True, "pressure_law": PressureLaw.UNIFORM}, "thick_wall"),
        ({"single_fibers": (SingleFiber(0.2),), "pressure_law": PressureLaw.UNIFORM}, "section"),
        ({"single_fibers": (SingleFiber(0.2),), "curvature_form": CurvatureForm.FIRST_ORDER},
         "exact"),
        ({"single_fibers": (SingleFiber(0.1), SingleFiber(0.2, 1.0))}, "fibers that cross"),
        ({"single_fibers": (SingleFiber(math.radians(60.0)),)}, "another angle"),
        ({"single_fibers": (SingleFiber(), SingleFiber(0.0, 1.0), SingleFiber(0.0, 2.0))},
         "at most 2"),
        ({"single_fibers": (SingleFiber(), SingleFiber(0.0, math.pi))}, "170 degrees"),
        ({"single_fibers": (SingleFiber(), SingleFiber())}, "they are one"),
        ({"single_fibers": (3.0,)}, "SingleFiber"),
    ],
)  # fmt: skip
def test_contradictions_are_refused(choices: dict[str, object], match: str) -> None:
    with pytest.raises(InvalidInputError, match=match):
        dataclasses.replace(section(88.0, 60.0), **choices)  # type: ignore[arg-type]


def test_one_hoop_family_bends_without_twist() -> None:
    """Without a second family nothing turns it; at small strain the hoop keeps plane sections."""
    hoop = FreeActuation(one_family(90.0, NeoHookean(c1=145.0e3)))
    shape = hoop.unloaded_shape(20.0e3)
    assert shape.curvature > 1.0
    assert abs(shape.torsion) < 1e-9
    # Plane strain, bending about the straight fiber: P = 3/2 (A / pi r^2) 4/3 E (lambda - 1).
    wall = PAPER_TUBE.wall_area / (math.pi * PAPER_TUBE.inner_radius**2)
    stretch = hoop.stretch_from_pressure(10.0)
    linear = 1.5 * wall * (4.0 / 3.0) * 6.0 * 145.0e3 * (stretch - 1.0)
    assert linear == pytest.approx(10.0, rel=1e-3)  # of the order of the strain


def test_one_family_and_its_mirror_image() -> None:
    right, left = FreeActuation(one_family(70.0)), FreeActuation(one_family(-70.0))
    one, other = right.unloaded_shape(40.0e3), left.unloaded_shape(40.0e3)
    assert one.torsion < -1.0
    assert other.torsion == pytest.approx(-one.torsion, rel=1e-8)
    assert other.curvature == pytest.approx(one.curvature, rel=1e-8)
    pressure = right.pressure_from_stretch(one.stretch or math.nan)
    assert pressure == pytest.approx(40.0e3, rel=1e-8)


def test_what_needs_two_families_says_so() -> None:
    with pytest.raises(InvalidInputError, match="two families"):
        unloaded_shape_from_stretch(one_family(70.0), 1.1)
    for choices in ({"thick_wall": True}, {"pressure_law": PressureLaw.UNIFORM},
                    {"curvature_form": CurvatureForm.FIRST_ORDER}):  # fmt: skip
        with pytest.raises(InvalidInputError, match="famil"):
            dataclasses.replace(one_family(70.0), **choices)
    with pytest.raises(InvalidInputError, match="extends the tube"):
        FreeActuation(one_family(30.0))


def test_straight_sections_that_shorten_have_shapes_in_both_forms() -> None:
    exact = section(45.0, -45.0).without_single_fibers()
    for form in CurvatureForm:
        actuation = FreeActuation(dataclasses.replace(exact, curvature_form=form))
        shape = actuation.unloaded_shape(20.0e3)
        assert shape.curvature == 0.0
        assert shape.stretch == pytest.approx(actuation.stretch_from_pressure(20.0e3), rel=1e-14)
    with pytest.raises(InvalidInputError, match="at most 1 for these"):
        unloaded_shape_from_stretch(exact, 1.01)
    spiral = dataclasses.replace(section(50.0, -40.0), single_fibers=())
    even = FreeActuation(spiral).unloaded_shape(10.0e3)
    first = dataclasses.replace(spiral, curvature_form=CurvatureForm.FIRST_ORDER)
    paper = FreeActuation(first).unloaded_shape(10.0e3)
    assert even.torsion * (even.stretch or 0.0) == pytest.approx(paper.torsion, rel=1e-10)


def test_first_order_twist_of_a_thick_wall_is_that_of_its_wound_fibers() -> None:
    thick = dataclasses.replace(
        section(88.0, 60.0, thick_wall=True), curvature_form=CurvatureForm.FIRST_ORDER
    )
    shape = unloaded_shape_from_stretch(thick, 1.1)
    twist = fiber_state(thick.fiber_pair, 1.1).twist
    assert shape.torsion == pytest.approx(twist / PAPER_TUBE.outer_radius, rel=1e-14)
    assert shape.curvature == pytest.approx(0.1 / PAPER_TUBE.outer_radius, rel=1e-14)


def test_design_space_ends_where_the_fibers_do() -> None:
    (space,) = design_space(section(88.0, 60.0), [math.radians(50.0)], stretch_max=3.0)
    assert 1.47 < space.stretch[-1] < longest_stretch(section(88.0, 50.0)) < 1.48
