# SPDX-License-Identifier: Apache-2.0
"""Pictures: what is drawn is what was computed; surfaces, shapes, charts, the winding sheet."""

import itertools
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from core.calibration_cases import fitted, noisy
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure

from spiral_core import (
    CurvatureForm,
    FreeActuation,
    InvalidInputError,
    NeoHookean,
    PressureLaw,
    pressure_uncertainty,
)
from spiral_core.actuator.actuator import windings_of
from spiral_core.grip.grip import GripCase, GripOutcome
from spiral_core.wrap.placement import ObjectPlacement
from spiral_gripper import load_description, plot
from spiral_gripper.bench.residual_plot import pressure_figure
from spiral_gripper.files.shown import shown_message
from spiral_gripper.reports.grip.plots import MOST_PANELS, window_figure
from spiral_gripper.reports.plots import section_figure
from spiral_gripper.reports.shaded import (
    OBJECT_RINGS,
    draw_surfaces,
    tube_surface,
    turned_surface,
)
from spiral_gripper.reports.shape_plots import shape_figure
from spiral_gripper.reports.tables import winding_rows
from spiral_gripper.reports.winding_sheet import winding_figures

DESCRIPTION = load_description("paper_design_70")
GRIPPER = DESCRIPTION.gripper
ACTUATOR = load_description("prototype_p2").actuator
HELD = GripOutcome("", 5.7e4, 5.5e4, 6.2e4, 8.7e4, 5.9e4, 0.15, 0.3, 0.22, 0.1)


def test_near_faces_are_drawn_over_far_ones_to_scale_and_from_the_front_only():
    line = np.linspace([0.05, 0.0, -0.1], [0.05, 0.0, 0.1], OBJECT_RINGS)
    near = tube_surface(line, 0.01)
    far = turned_surface(line[[0, -1]] - (0.1, 0.0, 0.0), np.full(OBJECT_RINGS, 0.02))
    for surfaces in ([near, far], [far, near]):
        axes = Figure().add_subplot()
        draw_surfaces(axes, surfaces, (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
        (faces,) = axes.collections
        red, _, blue, _ = faces.get_facecolor().T
        of_the_tube = (red > blue).tolist()
        assert of_the_tube[-1]
        assert of_the_tube == sorted(of_the_tube)
    points = np.concatenate([path.vertices for path in faces.get_paths()])
    assert np.ptp(points, axis=0) == pytest.approx((40.0, 200.0), rel=1e-3)
    assert axes.get_aspect() == 1.0
    # Half of the sides' triangles face the viewer; the caps are seen from their edge.
    whole = len(near.triangles) + len(far.triangles)
    assert len(faces.get_paths()) == pytest.approx(0.5 * whole, rel=0.05)


def test_a_shape_has_its_objects_projection_as_outline():
    tube = tube_surface(np.linspace([0.0, 0.0, 0.0], [0.3, 0.1, 0.1], 30), 0.0055)
    placement = ObjectPlacement((1.0, 2.0, 3.0), (0.0, 0.6, 0.8), 0.5, 2.5, 0.0)
    view = shape_figure([tube], "title", placement).axes[1]
    body, *ends = (patch.get_xy() for patch in view.patches)
    # Seen along y the axis has 0.8 of its length, 2.5 m and 1.5 radii at each end.
    assert np.ptp(body, axis=0) == pytest.approx((0.8 * 4.0e3, 1.0e3))
    assert [np.ptp(end[:, 0]) for end in ends] == pytest.approx([0.6 * 1.0e3] * 2, rel=1e-3)


def test_the_sheet_shows_each_turn_in_true_size():
    single = ACTUATOR.single_fibers[0]
    pair = (single, replace(single, position=single.position + 1.0))
    exact = {"pressure_law": PressureLaw.SECTION, "curvature_form": CurvatureForm.EXACT}
    (page,) = winding_figures(replace(ACTUATOR, single_fibers=pair, **exact), "p2", 0.02)
    (axes,) = page.axes
    assert (*axes.get_xlim(), *axes.get_ylim()) == (0.0, 210.0, 0.0, 279.0)
    ruler, *lines = axes.get_lines()
    assert np.ptp(ruler.get_xdata()) == pytest.approx(100.0)
    around = 2e3 * math.pi * ACTUATOR.tube.outer_radius
    strips = [patch.get_bbox() for patch in axes.patches]
    assert [strip.width for strip in strips] == pytest.approx([around] * len(strips))
    assert sum(strip.height for strip in strips) == pytest.approx(1e3 * ACTUATOR.tube.length)
    fibers = [*windings_of(ACTUATOR), *pair]
    drawn = itertools.product(strips, fibers)  # strip by strip
    for line, (strip, fiber) in zip(lines, drawn, strict=True):
        pieces = line.get_xydata().reshape(-1, 3, 2)[:, :2]  # two ends each, and the gap
        (left, right), (low, high) = pieces.T
        assert (low == strip.y0).all()
        assert high == pytest.approx(strip.y1)
        assert right - left == pytest.approx(math.tan(fiber.angle) * strip.height)
        assert np.diff(left) == pytest.approx(-around)  # each turn is drawn anew
        assert line.clipbox.extents == pytest.approx(axes.transData.transform_bbox(strip).extents)
    first, second = (line.get_xdata()[0] for line in lines[len(fibers) - 2 : len(fibers)])
    assert math.tau * (second - first) / around % math.tau == pytest.approx(1.0)


def test_a_sheet_that_cannot_be_is_refused_and_a_long_tube_takes_two():
    tube = ACTUATOR.tube
    thick = replace(ACTUATOR, tube=replace(tube, inner_radius=0.03))
    long = replace(ACTUATOR, tube=replace(tube, length=1.5))
    with pytest.raises(InvalidInputError, match=r"outer diameter \[mm\] must be at most 59"):
        winding_figures(thick, "thick", 0.02)
    assert len(winding_figures(long, "long", 0.02)) == 2
    steep = replace(ACTUATOR, fibers=replace(ACTUATOR.fibers, alpha=math.radians(89.9)))
    with pytest.raises(InvalidInputError) as refusal:
        winding_figures(steep, "steep", 0.02)
    # The steepest one that it states is drawn.
    steepest = math.radians(float(re.search(r"at most (\S+) deg", shown_message(refusal.value))[1]))
    drawn = replace(ACTUATOR, fibers=replace(ACTUATOR.fibers, alpha=steepest))
    assert winding_figures(drawn, "steep", 0.02)
    for actuator, told in ((steep, "rings"), (drawn, "right-handed, pitch 0.1")):
        (row,) = [
            text for name, text in winding_rows(actuator, 0.02) if name.startswith("winding at 89")
        ]
        assert row.startswith(told)


def test_the_band_is_the_interval_of_the_calibration():
    truth = replace(DESCRIPTION.actuator, material=NeoHookean(c1=1.5e5))
    fit = fitted(truth, noisy(truth, pressures=(2e4, 4e4, 6e4)), gripper=GRIPPER)
    (axes,) = pressure_figure(fit, "my_gripper", 0.95).axes
    band = next(area for area in axes.collections if area.get_hatch())
    corners = band.get_paths()[0].vertices
    radius = corners[:, 0].min()
    (one,) = pressure_uncertainty(fit, [1e-3 * radius], 0.95)
    ends = {p for r, p in corners.tolist() if r == radius}
    assert (min(ends), max(ends)) == pytest.approx([1e-3 * end for end in one.interval], rel=1e-6)


def test_a_section_is_stretched_away_from_the_straight_fiber():
    views = section_figure(DESCRIPTION.actuator, [0.0, 6e4], "mine").axes[:2]
    meshes = [next(c for c in view.collections if isinstance(c, QuadMesh)) for view in views]
    rest, pressed = (np.ravel(mesh.get_array().data) for mesh in meshes)
    assert rest == pytest.approx(1.0)
    assert pressed.argmin() in (0, 180, 181, 361)  # the fiber's angle, on both walls
    stretch = FreeActuation(DESCRIPTION.actuator).stretch_from_pressure(6e4)
    assert pressed[:180].mean() == pytest.approx(stretch, rel=1e-6)


def test_a_window_without_a_loss_ends_at_its_grippers_limit():
    limits = [90.0, 80.0]
    cases = [GripCase(replace(GRIPPER, pressure_max=1e3 * p), 0.02, 0.3) for p in limits]
    views = window_figure(cases, [replace(HELD, loss=None)] * 2).axes
    assert [view.dataLim.y1 for view in views] == pytest.approx(limits)


def test_what_there_is_no_picture_of_is_refused():
    cases = [GripCase(GRIPPER, 0.02, 0.1 * k) for k in range(MOST_PANELS + 1)]
    with pytest.raises(InvalidInputError, match="at most 3 panels"):
        window_figure(cases, [HELD] * len(cases))
    with pytest.raises(InvalidInputError, match="one of Grip, Wrap, WrapCurve"):
        plot(3.0)
