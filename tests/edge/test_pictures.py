# SPDX-License-Identifier: Apache-2.0
"""Pictures: shaded surfaces, shapes with their object, the winding sheet in true size."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from spiral_core import (
    InvalidInputError,
    ObjectPlacement,
    Rod,
    RodLoad,
    Section,
    WrapCurve,
    solve_rod,
)
from spiral_core.actuator.actuator import windings_of
from spiral_gripper import load_description, plot
from spiral_gripper.cli.main import run
from spiral_gripper.reports.shaded import (
    OBJECT_RINGS,
    draw_surfaces,
    turned_surface,
)
from spiral_gripper.reports.shape_plots import shape_figure
from spiral_gripper.reports.winding_sheet import winding_figures

RADIUS = 0.0055


@pytest.fixture(scope="module")
def state():
    return solve_rod(
        Rod(0.36, Section.inextensible(2.7e-4, 1.8e-4), rest_strain=(-13.5, 0.0, 21.0)),
        RodLoad((0.24, 0.0, 0.0)),
    )


@pytest.fixture(scope="module")
def actuator():
    return load_description("prototype_p2").actuator


def cylinder(x, radius):
    """A cylinder along the base's z axis, before (x > 0) or behind the plane x = 0."""
    ends = np.array([[x, 0.0, -0.1], [x, 0.0, 0.1]])
    return turned_surface(ends, np.full(OBJECT_RINGS, radius))


def painted(surface, color):
    return surface._replace(colors=np.tile(to_rgb(color), (len(surface.triangles), 1)))


def drawn(surfaces):
    """Return the picture of surfaces seen along -x, z upwards."""
    axes = Figure().add_subplot()
    draw_surfaces(axes, surfaces, (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    (faces,) = axes.collections
    return axes, faces


def test_near_faces_are_drawn_over_far_ones():
    near = painted(cylinder(0.05, 0.01), "#ff0000")
    far = painted(cylinder(-0.05, 0.02), "#0000ff")
    for surfaces in ([near, far], [far, near]):
        _, faces = drawn(surfaces)
        red = faces.get_facecolor()[:, 0] > 0.0
        assert red.any()
        assert not red[: np.flatnonzero(~red).max()].any()


def test_a_picture_is_to_scale_in_millimeters_and_shows_the_front_only():
    axes, faces = drawn([cylinder(0.0, 0.02)])
    points = np.concatenate([path.vertices for path in faces.get_paths()])
    assert np.ptp(points[:, 0]) == pytest.approx(40.0, rel=1e-3)
    assert np.ptp(points[:, 1]) == pytest.approx(200.0)
    assert axes.get_aspect() == 1.0
    # Half of the side's triangles face the viewer; the caps are seen from their edge.
    whole = len(cylinder(0.0, 0.02).triangles)
    assert len(faces.get_paths()) == pytest.approx(0.5 * whole, rel=0.05)


def test_a_shape_has_the_outline_of_its_object_or_none(state):
    placement = ObjectPlacement((0.1, 0.0, 0.0), (1.0, 0.0, 0.0), 0.02, 0.08, 0.0)
    figure = shape_figure(state.positions, RADIUS, "title", placement)
    assert [axes.get_xlabel() for axes in figure.axes] == ["y [mm]", "z [mm]"]
    assert [len(axes.patches) for axes in figure.axes] == [3, 3]
    assert not shape_figure(state.positions, RADIUS, "title").axes[0].patches


def test_a_drawn_outline_is_the_objects_projection(state):
    placement = ObjectPlacement((1.0, 2.0, 3.0), (0.0, 0.6, 0.8), 0.5, 2.5, 0.0)
    figure = shape_figure(state.positions, RADIUS, "title", placement)
    body, *ends = (patch.get_xy() for patch in figure.axes[1].patches)
    # Seen along y the axis has 0.8 of its length, 2.5 m and 1.5 radii at each end.
    assert np.ptp(body[:, 0]) == pytest.approx(0.8 * 4.0e3)
    assert np.ptp(body[:, 1]) == pytest.approx(1.0e3)
    for end in ends:
        assert np.ptp(end[:, 0]) == pytest.approx(0.6 * 1.0e3, rel=1e-3)


def test_the_sheet_shows_each_turn_in_true_size(actuator):
    (page,) = winding_figures(actuator, "p2", 0.02)
    assert page.get_size_inches() * 25.4 == pytest.approx((210.0, 279.0))
    (axes,) = page.axes
    assert (*axes.get_xlim(), *axes.get_ylim()) == (0.0, 210.0, 0.0, 279.0)
    ruler = axes.get_lines()[0].get_xdata()
    assert np.ptp(ruler) == pytest.approx(100.0)
    around = 2e3 * math.pi * actuator.tube.outer_radius
    strips = [patch.get_extents().transformed(axes.transData.inverted()) for patch in axes.patches]
    assert [strip.width for strip in strips] == pytest.approx([around] * len(strips))
    assert sum(strip.height for strip in strips) == pytest.approx(1e3 * actuator.tube.length)
    angles = [turn.angle for turn in windings_of(actuator)]
    angles += [fiber.angle for fiber in actuator.single_fibers]
    lines = axes.get_lines()[1:]  # strip by strip, behind the ruler
    assert len(lines) == len(strips) * len(angles)
    for number, line in enumerate(lines):
        strip, slope = strips[number // len(angles)], math.tan(angles[number % len(angles)])
        pieces = line.get_xydata().reshape(-1, 3, 2)[:, :2]  # two ends each, and the gap
        assert pieces[:, :, 1] == pytest.approx(np.tile((strip.y0, strip.y1), (len(pieces), 1)))
        assert np.ptp(pieces[:, :, 0], axis=1) == pytest.approx(abs(slope) * strip.height)
        assert ((pieces[:, 1, 0] - pieces[:, 0, 0]) * slope >= 0.0).all()
        assert np.diff(pieces[:, 0, 0]) == pytest.approx(-around)  # each turn is drawn anew
        assert line.clipbox.extents == pytest.approx(axes.transData.transform_bbox(strip).extents)
        ends = (pieces[0, 0, 0], pieces[-1, 1, 0]) if slope >= 0.0 else (pieces[-1, 0, 0],)
        assert all(strip.x0 <= end <= strip.x1 for end in ends)


def test_a_sheet_that_cannot_be_is_refused(actuator, tmp_path, capsys):
    thick = replace(actuator, tube=replace(actuator.tube, inner_radius=0.03))
    with pytest.raises(InvalidInputError, match=r"outer diameter \[mm\] must be at most 59"):
        winding_figures(thick, "thick", 0.02)
    long = replace(actuator, tube=replace(actuator.tube, length=1.5))
    assert len(winding_figures(long, "long", 0.02)) == 2
    file = tmp_path / "sheet.svg"
    assert run(["winding-sheet", "prototype_p2", "--save", str(file)]) == 0
    shown = capsys.readouterr().out
    assert "540 mm" in shown
    assert "right-handed, pitch 20.16 mm" in shown
    assert re.search(r'width="595.*pt" height="790.*pt"', file.read_text(encoding="utf-8"))


def test_plot_draws_what_it_knows_and_refuses_the_rest():
    gripper = load_description("paper_design_70").gripper
    wrap = WrapCurve(gripper).wrap_for_radius(0.02)
    assert [axes.get_xlabel() for axes in plot(wrap).axes] == ["y [mm]", "z [mm]"]
    assert plot(gripper).axes[0].get_ylabel() == "pressure [kPa]"
    with pytest.raises(InvalidInputError, match="one of Grip, Wrap, WrapCurve"):
        plot(3.0)
