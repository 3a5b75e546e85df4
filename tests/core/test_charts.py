# SPDX-License-Identifier: Apache-2.0
"""Charts as data: closed forms, agreement with the wrap curve, and what gravity does."""

from dataclasses import replace
from math import cos, nan, pi, tan
from types import SimpleNamespace

import numpy as np
import pytest
from core.actuator_cases import PAPER_TUBE, actuator
from core.gripper_cases import paper_gripper
from core.recorded import recorded, said
from numpy.testing import assert_allclose, assert_array_equal

from spiral_core import (
    CurvatureForm,
    FreeActuation,
    InvalidInputError,
    PressureLaw,
    WrapCurve,
    design_space,
    pressure_range,
    regime_chart,
)
from spiral_core.design import charts
from spiral_core.design.charts import helix_range
from spiral_core.design.helix_estimate import helix_grip

HOOP = actuator(90.0, 60.0, pressure_law=PressureLaw.SECTION)


def test_design_space_of_hoop_windings_in_closed_form():
    """kappa r = lambda - 1, tau r = sqrt(sec^2 beta - lambda^2) - tan beta."""
    steep, beta = np.radians((20.0, 70.0))
    (locked,) = design_space(HOOP, [steep], stretch_max=1.5)
    assert 1.06 < locked.stretch[-1] < 1.0 / cos(steep)
    (curve,) = design_space(HOOP, [beta], turns_required=1.5, stretch_max=1.4, points=21)
    assert (curve.fiber_angle_beta, curve.stretch[-1]) == (beta, 1.4)
    bend = curve.stretch - 1.0
    twist = np.sqrt(1.0 / cos(beta) ** 2 - curve.stretch**2) - tan(beta)
    square = bend**2 + twist**2
    ratio = bend / square - PAPER_TUBE.outer_radius / PAPER_TUBE.inner_radius
    winding = 1.5 * 2.0 * pi / square
    assert_allclose(curve.radius_ratio, ratio, 1e-9, 1e-9)
    assert_allclose(curve.object_length_ratio, winding * np.abs(twist), 1e-9)
    assert_allclose(curve.length_ratio, winding * np.sqrt(square), 1e-9)


def test_without_weight_rod_and_helix_agree_and_gravity_opens_the_coil_at_low_pressure():
    gripper = paper_gripper("P1")
    for form in CurvatureForm:
        actuation = FreeActuation(replace(gripper.actuation.actuator, curvature_form=form))
        gripper = replace(gripper, actuation=actuation, gravity=(0.0, 0.0, 0.0))
        rod = pressure_range(gripper, points=9)
        helix = helix_range(gripper, rod.pressure)
        # The rod's discretization and the axis fitted to it.
        assert_allclose(rod.radius, helix.radius, 0, 2e-5)
        assert_allclose(rod.gripper_length, helix.gripper_length, 1e-3)
        assert_allclose(rod.object_length, helix.object_length, 5e-3)
        cut = helix_grip(actuation, helix.radius[-1], gripper.turns_required)
        assert_allclose(helix.gripper_length[-1], cut.length_needed, 1e-6)
    limited = replace(paper_gripper("P2"), pressure_max=120e3)
    heavy = pressure_range(limited, points=33)
    light = helix_range(limited, heavy.pressure)
    assert heavy.gripper_length[0] > 1.2 * light.gripper_length[0]
    ends = heavy.pressure[-1], heavy.radius[-1]
    assert_allclose(ends, (120e3, light.radius[-1]), 0, 1e-4)
    assert np.diff(heavy.radius).max() < 0.0
    with pytest.raises(InvalidInputError, match="pressure"):
        helix_range(gripper, np.array([0.0]))


def test_the_chart_has_the_tip_criterion_and_refuses_what_that_does_not_wrap():
    curve = WrapCurve(paper_gripper("70 degrees"))
    ends = curve.radius_min, curve.radius_max
    chart, wide = (said(regime_chart, curve, *radii) for radii in (ends, (0.012, 0.04)))
    assert chart.tip.tolist() == [curve.pressure_from_radius(radius) for radius in chart.radius]
    found = [chart, wide, said(design_space, HOOP, [1.0], 1.5, 1.01), pressure_range(curve.gripper)]
    recorded("charts/charts", found)


def test_the_windows_of_a_chart_are_those_of_the_grips(monkeypatch):
    """Where an object is not wrapped, or a mark not reached, there is none."""

    def window(setup):
        radius = setup.obstacle.shape.radius
        onset = None if radius > 0.03 else 1e3 * radius
        return SimpleNamespace(onset_wrap=onset, onset_curling=2e3 * radius, loss=None)

    monkeypatch.setattr(charts, "grip_window", window)
    chart = charts.contact_chart(WrapCurve(paper_gripper("70 degrees")), 0.02, 0.033)
    recorded("charts/contact", chart)
    wrapped = np.where(chart.radius > 0.03, nan, 1e3 * chart.radius)
    assert_array_equal(chart.onset_wrap, wrapped)
