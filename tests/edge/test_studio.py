# SPDX-License-Identifier: Apache-2.0
"""The studio without its page: surfaces, settings, answers, the charts' data, words, exports."""

import io
import math
import threading
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh

from spiral_core import (
    InvalidInputError,
    Pull,
    SpiralError,
    WrapRegime,
    lay_into_coil,
    solve_grip,
    solve_rod,
)
from spiral_core.grip.window import WindowEnd
from spiral_gripper import load_description, plot
from spiral_gripper.files.description import parse_description
from spiral_gripper.reports.meshes import SIDES, tube_mesh
from spiral_gripper.studio.charts import (
    chart_scales,
    update_chart,
)
from spiral_gripper.studio.exports import EXPORTS, shape_csv, shape_mesh
from spiral_gripper.studio.scene import node_values
from spiral_gripper.studio.session import Session, answer_for, object_shape
from spiral_gripper.studio.settings import gripper_for, settings_of
from spiral_gripper.studio.words import answer_text

RADIUS = 0.0055
DESCRIPTION = load_description("paper_design_70")
GRIPPER = DESCRIPTION.gripper
SETTINGS = settings_of(DESCRIPTION, object_radius=0.02)


def answered(**changes):
    settings = replace(SETTINGS, **changes)
    return answer_for(settings, gripper_for(DESCRIPTION, settings))


@pytest.fixture(scope="module")
def answer():
    return answered()


def free_coil(pressure):
    """Return the state of the free coil."""
    shape = GRIPPER.unloaded_shape(pressure)
    return solve_rod(GRIPPER.rod(shape), GRIPPER.load(shape))


def told(answer, pressure=SETTINGS.pressure, waited=None):
    """Return what the page says of an answer at a pressure."""
    settings = replace(SETTINGS, pressure=pressure)
    return answer_text(answer, settings, GRIPPER, free_coil(pressure), waited)


def test_the_same_ends_of_an_axis_are_not_sent_again():
    ends = chart_scales(None, 1.2e5)
    chart = SimpleNamespace(scales=chart_scales(None, 1.0e5))
    for each in (ends, chart_scales(None, 1.2e5)):
        update_chart(chart, (), each)
        assert chart.scales is ends


def test_a_tube_is_closed_and_holds_its_volume():
    state = free_coil(6e4)
    mesh = tube_mesh(state.positions, RADIUS)
    surface = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    assert surface.is_watertight
    # Pappus: area times length of the centerline.
    length = np.linalg.norm(np.diff(state.positions, axis=0), axis=1).sum()
    area = 0.5 * SIDES * math.sin(2.0 * math.pi / SIDES) * RADIUS**2
    assert surface.volume == pytest.approx(area * length, rel=0.01)
    distances = np.linalg.norm(mesh.vertices - state.positions[mesh.rows], axis=1)
    assert set(np.round(distances / RADIUS, 9)) == {0.0, 1.0}
    data = io.BytesIO(shape_mesh(state.positions, RADIUS, "stl"))
    bounds = trimesh.load(data, file_type="stl").bounds
    assert bounds == pytest.approx(np.array([mesh.vertices.min(0), mesh.vertices.max(0)]))
    rows = np.genfromtxt(io.BytesIO(shape_csv(state)), delimiter=",", skip_header=1)
    assert rows[:, 1:4] == pytest.approx(state.positions, abs=1e-8)


def test_settings_are_those_of_the_file_until_the_sliders_change_them():
    gravity = (1.0, -2.0, 0.5)
    mounted = replace(DESCRIPTION, gripper=GRIPPER.with_mount(gravity, None))
    assert settings_of(mounted, 0.02).gravity_vector == pytest.approx(gravity, abs=1e-12)
    assert gripper_for(DESCRIPTION, SETTINGS).actuation is GRIPPER.actuation
    moved = replace(SETTINGS, angles=(SETTINGS.angles[0], math.radians(60.0)))
    gripper = gripper_for(DESCRIPTION, moved)
    assert gripper.unloaded_shape(4e4).curvature != GRIPPER.unloaded_shape(4e4).curvature
    assert gripper.pressure_max <= GRIPPER.pressure_max


def test_an_answer_is_that_of_the_core_or_its_reason(answer):
    assert answer.wrap.pressure == answer.curve.pressure_from_radius(0.02)
    assert answer.regime(0.5 * answer.wrap.pressure) is WrapRegime.OVERHANG
    thick = answered(object_radius=0.07)
    assert thick.regime(5e4) is None
    assert "too thick" in thick.refusal
    with pytest.raises(SpiralError, match="too thick"):
        EXPORTS["urdf"][1](SimpleNamespace(known=thick))
    assert answered(length=0.05).curve is None
    gapped = answered(length=0.3, tilt=0.5 * math.pi)
    ((low, high),) = gapped.curve.gaps
    known = np.isfinite(gapped.pressures)
    assert np.array_equal(known, (gapped.radii <= low) | (gapped.radii >= high))
    assert plot(gapped.curve).axes[0].get_ylim()[1] > 50.0


def test_a_session_answers_the_newest_settings_and_exports_what_is_shown():
    heard = threading.Semaphore(0)
    session = Session(DESCRIPTION, SETTINGS, lambda _: heard.release())
    moved = replace(SETTINGS, object_radius=0.025, length=0.3)
    session.update(moved)
    assert session.known is None
    with pytest.raises(SpiralError, match="still being computed"):
        EXPORTS["urdf"][1](session)
    while session.known is None:
        assert heard.acquire(timeout=60.0)
    while not session.known.is_complete:
        assert heard.acquire(timeout=60.0)
    assert session.answer.wrap.object_radius == pytest.approx(0.025)
    session.update(replace(moved, pressure=1e9))
    assert session.settings.pressure == session.gripper.pressure_max
    session.update(replace(moved, pressure=5e4))
    with pytest.raises(InvalidInputError):
        session.update(replace(SETTINGS, length=-1.0))
    assert session.known is not None
    written = {name: write(session) for name, (_, write) in EXPORTS.items()}
    session.close()
    saved = written["gripper file"].decode()
    assert "# Our choice" in saved
    read = parse_description(saved, Path("saved.yaml")).gripper
    assert read.tube == session.gripper.tube
    curvature = read.unloaded_shape(5e4).curvature
    assert session.gripper.unloaded_shape(5e4).curvature == pytest.approx(curvature, rel=1e-9)


def test_words_say_what_is_known(answer):
    assert told(None, waited=0.4).startswith("**computing ..., 0 s**")
    text = told(answer, waited=7.2)
    assert "misses the object by up to 2.36 mm\n\ncontact: computing ..., 7 s" in text
    unheld = told(replace(answer, refusal="it slips"))
    assert unheld.startswith("**not wrapped** (in contact)")
    assert "**not held:** it slips" in unheld


def test_the_verdict_on_a_pressure_is_that_of_the_window(answer):
    grip = solve_grip(lay_into_coil(GRIPPER, 0.02), pressures=(56e3, 60e3))
    known = replace(answer, window=grip.window, grip=grip)
    window = grip.window
    onset, lifts_off = 0.5 * window.onset_wrap, 0.6 * window.onset_wrap
    lifted = replace(known, window=replace(window, onset_wrap=onset, lift_off=lifts_off))
    ended = replace(known, window=replace(window, loss=None, end=WindowEnd.SELF_CONTACT))
    before, wrapped, beyond = (
        window.onset_wrap - 100.0,
        window.onset_wrap + 100.0,
        window.loss + 1.0,
    )
    for each, pressure, verdict, holding in (
        (known, before, "overhang", False),
        (known, wrapped, "perfect wrap", True),
        (known, window.onset_curling - 100.0, "perfect wrap", True),
        (known, window.onset_curling + 100.0, "curling", True),
        (known, 0.5 * (window.top + window.loss), "curling", False),
        (known, beyond, "lost:", False),
        (ended, beyond, "not known:** turns of the tube", False),
        (lifted, window.pressures[window.pressures < before][-1], "overhang", False),
    ):
        text = told(each, pressure)
        assert text.startswith(f"**{verdict}")
        assert ("away from the base" in text) is holding
    away = grip.force(Pull.AWAY)
    assert f"holds **{np.mean(away):.3g} N**" in told(known, 58e3)


def test_a_tapered_object_is_a_cone_with_the_radius_in_the_middle():
    for taper in (-0.1, 0.3):
        shape = object_shape(replace(SETTINGS, taper=taper), 0.1)
        on_surface = [[0.02 + math.tan(taper) * z, 0.0, z] for z in (-0.03, 0.0, 0.03)]
        gap, _, _ = shape.distance(np.array(on_surface))
        assert gap == pytest.approx(0.0, abs=1e-9)
        assert min(shape.radii) > 0.19 * 0.02


def test_colors_follow_what_they_name():
    color = partial(node_values, GRIPPER, 6e4, free_coil(6e4))
    # The tip carries no moment.
    assert color("bending moment")[-1] == pytest.approx(0.0, abs=1e-12)
    curvature = GRIPPER.unloaded_shape(6e4).curvature
    strain = 2.0 * GRIPPER.tube.outer_radius * curvature
    found = [color(name)[-1] for name in ("curvature", "strain")]
    assert found == pytest.approx([curvature, strain], rel=1e-3)
