# SPDX-License-Identifier: Apache-2.0
"""The studio without its page: surfaces, settings, answers, the chart's data, exports."""

import io
import math
import threading
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh

from spiral_core import (
    InvalidInputError,
    Pull,
    Rod,
    RodLoad,
    Section,
    WrapRegime,
    lay_into_coil,
    solve_rod,
)
from spiral_gripper import load_description
from spiral_gripper.files.shown import display_units
from spiral_gripper.reports.meshes import SIDES, tube_mesh
from spiral_gripper.studio.charts import chart_data, chart_scales, force_data, force_scales
from spiral_gripper.studio.closing import Closings, StoppedError
from spiral_gripper.studio.exports import EXPORTS, shape_csv, shape_mesh
from spiral_gripper.studio.pull import pull_frames
from spiral_gripper.studio.scene import node_values
from spiral_gripper.studio.session import Session, answer_for, object_shape
from spiral_gripper.studio.settings import gripper_for, settings_of
from spiral_gripper.studio.words import answer_text, closing_line

RADIUS = 0.0055
# A polygon's area as a fraction of its circle's.
ROUNDNESS = SIDES / (2.0 * math.pi) * math.sin(2.0 * math.pi / SIDES)


@pytest.fixture(scope="module")
def description():
    return load_description("paper_design_70")


@pytest.fixture(scope="module")
def settings(description):
    return settings_of(description, object_radius=0.02)


@pytest.fixture(scope="module")
def answer(description, settings):
    return answer_for(settings, gripper_for(description, settings))


@pytest.fixture(scope="module")
def held(description, settings):
    """The complete answer, with contact and holding forces."""
    done = threading.Event()
    session = Session(description, settings, lambda said: said.is_complete and done.set())
    assert done.wait(timeout=900.0)
    session.close()
    return session.answer


@pytest.fixture(scope="module")
def state():
    return solve_rod(
        Rod(0.36, Section.inextensible(2.7e-4, 1.8e-4), rest_strain=(-13.5, 0.0, 21.0)),
        RodLoad((0.24, 0.0, 0.0)),
    )


@pytest.fixture(scope="module")
def said(description):
    """What the page says of a gripper with the described limit."""

    def text(answer, settings, state, waited=None):
        return answer_text(answer, settings, description.gripper, state, waited)

    return text


def surface(mesh):
    return trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)


def test_a_tube_is_closed_and_holds_its_volume(state):
    mesh = tube_mesh(state.positions, RADIUS)
    tube = surface(mesh)
    assert tube.is_watertight
    # Pappus: area times length of the centerline; chords between nodes 10 mm apart lose 1.8 %.
    assert tube.volume == pytest.approx(math.pi * RADIUS**2 * 0.36 * ROUNDNESS, rel=0.02)
    distances = np.linalg.norm(mesh.vertices - state.positions[mesh.rows], axis=1)
    assert set(np.round(distances / RADIUS, 9)) == {0.0, 1.0}


def test_a_turned_object_is_closed_and_holds_its_volume():
    ends = np.array([[0.1, 0.2, 0.3], [0.1, 0.2, 0.5]])
    cone = surface(tube_mesh(ends, np.array([0.01, 0.03])))
    assert cone.is_watertight
    exact = math.pi * 0.2 / 3.0 * (0.01**2 + 0.01 * 0.03 + 0.03**2)
    assert cone.volume == pytest.approx(exact * ROUNDNESS, rel=1e-9)


@pytest.mark.parametrize(
    "gravity", [(9.8, 0.0, 0.0), (-9.8, 0.0, 0.0), (0.0, 0.0, 3.0), (1.0, -2.0, 0.5)]
)
def test_tilt_and_roll_are_the_mount_of_the_file(description, gravity):
    held = replace(description, gripper=description.gripper.with_mount(gravity, None))
    settings = settings_of(held, 0.02)
    assert settings.gravity_vector == pytest.approx(gravity, abs=1e-12)


def test_untouched_settings_are_the_described_gripper(description, settings):
    gripper = gripper_for(description, settings)
    assert gripper.actuation is description.gripper.actuation
    assert gripper.gravity == pytest.approx(description.gripper.gravity)


def test_fibers_and_length_follow_the_sliders(description, settings):
    gripper = gripper_for(
        description, replace(settings, angles=(settings.angles[0], math.radians(60.0)), length=0.5)
    )
    assert gripper.tube.length == 0.5
    assert (
        gripper.unloaded_shape(4e4).curvature != description.gripper.unloaded_shape(4e4).curvature
    )
    assert gripper.pressure_max <= description.gripper.pressure_max


def test_an_answer_is_that_of_the_core(answer):
    assert answer.wrap.pressure == answer.curve.pressure_from_radius(0.02)
    assert answer.regime(answer.wrap.pressure) is WrapRegime.PERFECT_WRAP
    assert answer.regime(0.5 * answer.wrap.pressure) is WrapRegime.OVERHANG
    assert answer.placement.radius == pytest.approx(0.02)
    assert np.all(np.diff(answer.radii) > 0.0)
    assert np.all(np.diff(answer.pressures) < 0.0)
    assert answer.refusal == ""


def test_a_gripper_whose_coiled_range_has_a_gap_is_answered(description, settings):
    level = replace(settings, length=0.3, tilt=0.5 * math.pi)
    answer = answer_for(level, gripper_for(description, level))
    ((low, high),) = answer.curve.gaps
    known = np.isfinite(answer.pressures)
    assert np.array_equal(known, (answer.radii <= low) | (answer.radii >= high))


def test_what_cannot_be_wrapped_is_refused_with_its_reason(description, settings):
    thick = replace(settings, object_radius=0.07)
    answer = answer_for(thick, gripper_for(description, thick))
    assert answer.wrap is None
    assert answer.regime(5e4) is None
    assert "too thick" in answer.refusal
    short = replace(settings, length=0.05)
    assert answer_for(short, gripper_for(description, short)).curve is None


def test_a_session_answers_the_newest_settings(description, settings):
    heard = threading.Semaphore(0)
    session = Session(description, settings, lambda _: heard.release())
    assert heard.acquire(timeout=60.0)
    assert session.current
    session.update(replace(settings, object_radius=0.025))
    assert not session.current
    while not session.current:
        assert heard.acquire(timeout=60.0)
    assert session.answer.wrap.object_radius == pytest.approx(0.025)
    session.update(replace(settings, object_radius=0.025, pressure=5e4))
    assert session.current
    assert session.shape().stable
    with pytest.raises(InvalidInputError):
        session.update(replace(settings, length=-1.0))
    assert session.settings.object_radius == 0.025
    session.update(replace(session.settings, pressure=1e9))
    assert session.settings.pressure == session.gripper.pressure_max
    session.close()


def test_the_chart_holds_the_point_where_the_gripper_is(answer):
    radii, wraps, now = chart_data(answer, 0.02, 5.0e4)
    assert np.all(np.diff(radii) > 0.0)
    (place,) = np.flatnonzero(np.isfinite(now))
    assert (radii[place], now[place]) == (20.0, 50.0)
    assert wraps[place] == pytest.approx(1e-3 * answer.wrap.pressure, rel=1e-3)
    outside, wraps, now = chart_data(answer, 0.07, 5.0e4)
    assert (outside[-1], now[-1]) == (pytest.approx(70.0), 50.0)
    assert np.isnan(wraps[-1])
    assert chart_data(None, 0.02, 0.0)[0][0] == 20.0
    assert chart_scales(answer, 1.1e5)["y"]["range"] == (0.0, pytest.approx(110.0))


def test_exports_hold_the_shape(state):
    rows = np.genfromtxt(io.BytesIO(shape_csv(state)), delimiter=",", skip_header=1)
    assert rows[:, 1:4] == pytest.approx(state.positions, abs=1e-8)
    for kind in ("stl", "glb"):
        data = shape_mesh(state.positions, RADIUS, kind)
        read = trimesh.load(io.BytesIO(data), file_type=kind, force="mesh")
        assert read.bounds == pytest.approx(
            surface(tube_mesh(state.positions, RADIUS)).bounds, abs=1e-6
        )


@pytest.mark.slow
def test_colors_follow_what_they_name(description, held):
    gripper = description.gripper
    free = gripper.unloaded_shape(6e4)
    state = solve_rod(gripper.rod(free), gripper.load(free))
    assert node_values(gripper, 6e4, state, "plain") is None
    assert not node_values(gripper, 6e4, state, "contact force").any()
    curvatures = node_values(gripper, 6e4, state, "curvature")
    assert curvatures == pytest.approx(np.linalg.norm(state.strains[:, 1:], axis=1), rel=1e-6)
    assert node_values(gripper, 6e4, state, "bending moment")[-1] == pytest.approx(0.0, abs=1e-12)
    strain = node_values(gripper, 6e4, state, "strain")  # the tip carries no moment
    assert strain[-1] == pytest.approx(2.0 * gripper.tube.outer_radius * free.curvature, rel=1e-6)
    point = held.contact_at(6.5e4)
    pressed = node_values(gripper, point.pressure, point.state, "contact force")
    assert pressed.sum() == pytest.approx(point.normal_force)


def test_words_say_what_is_known(said, answer, settings, state):
    assert "computing" in said(None, settings, state)
    text = said(answer, replace(settings, pressure=answer.wrap.pressure), state)
    assert "tip criterion of 20 mm" in text
    assert f"{answer.wrap.pressure / 1e3:.4g} kPa" in text
    unheld = said(replace(answer, no_grip="it slips"), settings, state)
    assert unheld.startswith("**not wrapped** (in contact)")
    assert "**not held:** it slips" in unheld
    refused = replace(answer, wrap=None, placement=None, refusal="too thick for it")
    assert "20 mm cannot be wrapped:** too thick for it" in said(refused, settings, state)


def test_margins_are_those_of_limit_and_strain(said, description, answer, settings, state):
    limit = description.gripper.pressure_max  # 16 psi
    text = said(answer, replace(settings, pressure=0.75 * limit), state)
    assert "margins: 25 % below the pressure limit (110.3 kPa)" in text
    strains = [description.gripper.unloaded_shape(f * limit).stretch - 1.0 for f in (0.75, 1.0)]
    assert (
        "strain {:.1f} %, at the pressure limit {:.1f} %".format(*np.multiply(strains, 100)) in text
    )
    with display_units("psi", "in"):
        text = said(answer, replace(settings, pressure=0.75 * limit), state)
        assert "25 % below the pressure limit (16 psi)" in text
        assert "tip criterion of 0.7874 in: **8.274 psi**" in text
        assert not any(unit in text for unit in (" mm", " kPa"))


@pytest.mark.slow
def test_the_margin_to_the_loss_is_known_with_contact(said, held, settings, state):
    loss = held.window.loss
    known = f"the loss ({1e-3 * loss:.4g} kPa)"
    assert f"20 % below {known}" in said(held, replace(settings, pressure=0.799 * loss), state)
    assert f"**9.6 % above** {known}" in said(
        held, replace(settings, pressure=1.0951 * loss), state
    )


@pytest.mark.slow
def test_a_closing_is_computed_once_for_its_settings(description, settings, held):
    session = Session(description, replace(settings, rate=2e5), lambda _: None)
    closings, shares = Closings(), []
    assert closings.of(session, shares.append) is None  # contact is not known yet
    session.answer = held
    closing = closings.of(session, shares.append)
    assert closing.course.pressures[-1] == pytest.approx(1.15 * held.wrap.pressure)
    assert closing.course.times[1] == pytest.approx(1.15 * held.wrap.pressure / 2e5)
    assert closing.is_complete
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    session.update(replace(session.settings, pressure=5e4))
    assert closings.of(session, shares.append) is closings.known(session) is closing
    assert closing_line(closing, 2e5).startswith("closed at 200 kPa/s: ")
    session.update(replace(session.settings, rate=1e5))
    assert closings.known(session) is None
    session.answer = held
    with pytest.raises(StoppedError):
        closings.of(session, stop)
    session.close()


def stop(_):
    raise StoppedError


@pytest.mark.slow
def test_a_complete_answer_holds_contact_and_forces(said, held, settings, state):
    pressure = held.grip.recommended_pressure()
    point = held.contact_at(pressure)
    assert abs(point.pressure - pressure) <= 0.05 * pressure
    assert point.state.gaps.min() > -1e-5
    assert held.contact_at(1.2 * held.window.top) is None
    text = said(held, replace(settings, pressure=pressure), state)
    assert "(in contact)" in text
    assert "N** away from the base" in text
    assert "computing" not in text
    assert "lost" in said(held, replace(settings, pressure=1.2 * held.window.top), state)
    waiting = replace(held, window=None, grip=None)
    assert said(waiting, settings, state).count("computing") == 1
    assert "not held:** too slippery" in said(
        replace(waiting, no_grip="too slippery"), settings, state
    )


@pytest.mark.slow
def test_the_force_chart_holds_the_point_where_the_gripper_is(held):
    pressures, away, towards, now = force_data(held, 7.0e4)
    assert np.all(np.diff(pressures) > 0.0)
    (place,) = np.flatnonzero(np.isfinite(now))
    assert pressures[place] == pytest.approx(70.0)
    assert now[place] == away[place]
    assert away[place - 1] < away[place] < away[place + 1]
    assert np.isfinite(towards).all()
    low, high = force_scales(held, 1.1e5)["y"]["range"]
    assert low == 0.0
    assert high > max(away)
    assert np.isnan(force_data(None, 7.0e4)[1]).all()


@pytest.mark.slow
def test_a_pull_moves_the_object_and_resists(held):
    frames = pull_frames(held.grip, 6.0e4)
    moved = [float(np.linalg.norm(frame.displacement)) for frame in frames]
    assert moved == sorted(moved)
    assert len(frames) > 5
    assert max(frame.force for frame in frames) == pytest.approx(
        held.grip.force(Pull.AWAY)[np.argmin(np.abs(held.grip.pressures - 6.0e4))], rel=0.1
    )


def test_every_export_is_of_what_is_shown(description, settings, tmp_path):
    session = Session(description, replace(settings, length=0.3, pressure=5e4), lambda _: None)
    written = {name: write(session) for name, (_, write) in EXPORTS.items()}
    session.close()
    saved = tmp_path / "saved.yaml"
    saved.write_bytes(written["gripper file"])
    read = load_description(saved)
    assert read.gripper.tube.length == 0.3
    assert "# Our choice" in saved.read_text(encoding="utf-8")
    assert session.gripper.unloaded_shape(5e4).curvature == pytest.approx(
        read.gripper.unloaded_shape(5e4).curvature, rel=1e-9
    )
    robot = ElementTree.fromstring(written["urdf"])
    spheres = robot.findall("link/collision/geometry/sphere")
    assert len(spheres) == written["spheres"].decode().count("  - [")
    assert len(spheres) == len(robot.findall("link/visual"))


def test_a_tapered_object_is_a_cone_with_the_radius_in_the_middle(settings):
    assert object_shape(settings, 0.1) is None
    for taper in (0.1, -0.1, 0.3):
        shape = object_shape(replace(settings, taper=taper), 0.1)
        radius, slope = settings.object_radius, math.tan(taper)
        on_surface = [[radius + slope * z, 0.0, z] for z in (-0.03, 0.0, 0.03)]
        gap, _, _ = shape.distance(np.array(on_surface))
        assert gap == pytest.approx(0.0, abs=1e-9)
        assert min(shape.radii) > 0.19 * radius


def test_a_tapered_object_is_laid_into_the_coil(description, settings, answer):
    shape = object_shape(replace(settings, taper=0.1), answer.wrap.object_length_needed)
    gripper = gripper_for(description, settings)
    setup = lay_into_coil(gripper, settings.object_radius, shape=shape, curve=answer.curve)
    assert setup.tip_pressure == pytest.approx(answer.wrap.pressure)


def test_what_is_computed_is_said_with_its_time(said, answer, settings, state):
    words = said(answer, settings, state, waited=7.2)
    assert "contact: computing ..., 7 s" in words
    assert said(None, settings, state, waited=0.4).startswith("**computing ..., 0 s**")
