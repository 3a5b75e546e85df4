# SPDX-License-Identifier: Apache-2.0
"""How an arm should hold the gripper: poses in the world, symmetry, the search for the best."""

from dataclasses import replace
from math import cos, degrees, inf, pi, radians, sin
from types import SimpleNamespace

import numpy as np
import pytest
from core.gripper_cases import paper_gripper
from core.recorded import recorded
from numpy.linalg import norm
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from spiral_core import ApproachTask, NoCoilError, find_approaches
from spiral_core.grip import approach
from spiral_core.grip.approach import (
    BasePose,
    Trial,
    angle_between,
    approach_setup,
    base_rotation,
    candidate_poses,
    coarse_grip,
    screen,
    screen_shifted,
)
from spiral_core.grip.capture import CaptureOutcome, close_misplaced
from spiral_core.grip.setup import lay_into_coil
from spiral_core.grip.window import GripPoint, WindowEnd, grip_window

pytestmark = pytest.mark.long

DOWN = (0.0, 0.0, -9.80665)
GRIPPER = paper_gripper("70 degrees")
UPRIGHT = ApproachTask(GRIPPER, 0.015, (0.0, 0.0, 1.0), DOWN, 0.02)
LEVEL = replace(UPRIGHT, object_axis=(1.0, 0.0, 0.0))
LEANING = replace(UPRIGHT, object_axis=(0.3, 0.0, 1.0))
HANGING = BasePose((1.0, 0.0, 0.0), (1.0, 0.0, 0.0))


def test_a_pose_shows_the_base_the_world_s_gravity_and_object():
    for task in [UPRIGHT, LEVEL, replace(LEANING, gravity=(1.0, -2.0, 9.0))]:
        for pose in candidate_poses(task, 5):
            rotation = base_rotation(task, pose)
            assert_allclose(rotation.apply(pose.gravity), task.down, atol=1e-9)
            assert_allclose(rotation.apply(pose.axis), task.axis, atol=1e-9)
        there = approach_setup(task, replace(pose, shift=(1e-3, -2e-3, 3e-3))).obstacle.position
        shift = np.subtract(there, approach_setup(task, pose).obstacle.position)
        assert_allclose(shift, (1e-3, -2e-3, 3e-3), atol=1e-12)


def turned(pose, *rotation):
    """A pose whose base is turned by a rotation vector in the base frame."""
    turn = Rotation.from_rotvec(rotation)
    return BasePose(*(tuple(turn.apply(each).tolist()) for each in (pose.gravity, pose.axis)))


def test_orientations_that_the_object_s_symmetry_makes_alike_do_not_differ():
    for task, turn, alike in [
        (UPRIGHT, 1.0, True),
        (LEVEL, pi, True),
        (LEVEL, 1.0, False),
        (LEANING, pi, False),
    ]:
        pose = candidate_poses(task, 1)[-1]
        other = turned(pose, *np.multiply(turn, pose.gravity))
        assert_allclose(angle_between(task, pose, other), 0.0 if alike else turn, atol=1e-7)


@pytest.mark.parametrize("tilt", [25.0, 180.0])
def test_a_search_is_recorded_by_rules_in_place_of_grips(tilt, monkeypatch):
    """Poses tried, errors closed on, and the best three; and an interrupted search goes on."""
    closed, kept, steps = [], {}, []

    def screen(_, pose):
        force = 1.0 + np.dot(pose.gravity, (0.3, 1.0, 0.2)) + 20.0 * pose.shift[0]
        size = 6e-3 if pose.gravity[1] < 0.4 else 0.0
        grips = Trial("", force=float(force), size=size)
        return grips if force > 1.5 else Trial("weak", 1.5 - force)

    def close(pose, pressure, off, payload, elements):
        closed.append((*off / approach.UNIT_ERRORS, pressure, payload, elements))
        held = norm(closed[-1][:4]) < 5.0 + 9.0 * pose.axis[2] - 300.0 * pose.shift[1]
        return SimpleNamespace(outcome=CaptureOutcome.HOLDS if held else CaptureOutcome.TOO_WEAK)

    def region(*_, outlines, known, keep, **__):
        assert not outlines
        keep((0.0,) * 5, CaptureOutcome.HOLDS)
        return SimpleNamespace(semi_axes=np.array((3e-3, 2e-3, 0.02, 0.03, 1e-5 + len(known))))

    for rule, name in (
        (screen, "screen_shifted"),
        (close, "close_misplaced"),
        (region, "capture_region"),
    ):
        monkeypatch.setattr(approach, name, rule)
    monkeypatch.setattr(approach, "gripped", lambda _, pose: GripPoint(7e4, pose, None))
    monkeypatch.setattr(approach, "holding_force", lambda at, _: screen(None, at.setup))
    monkeypatch.setattr(approach, "JUDGED", 9)
    monkeypatch.setattr(BasePose, "balance_angle", inf, raising=False)
    task = replace(UPRIGHT, tilt_max=radians(tilt))
    given = {"keep": kept.__setitem__, "progress": lambda *step: steps.append(step)}
    found, count = find_approaches(task, **given), len(kept)
    best = [(one.found, one.pose) for one in found.approaches]
    screened = norm([(*pose.gravity, *pose.shift) for pose in found.tried])
    said = found.gripping, len(found.tried), len(closed), screened, found.reasons["weak"]
    asked = said, closed[::40], steps[::50]
    again = find_approaches(task, known=kept, **given)
    assert (len(kept), again.tried) == (count, found.tried)
    monkeypatch.delattr(BasePose, "balance_angle")
    recorded(f"approach/{tilt}", [best, found.nearest, *asked])


def test_reasons_that_differ_in_figures_are_counted_together():
    poses = candidate_poses(UPRIGHT, 1)
    said = ("0.5 turns at 3 kPa", "0.25 turns at 12.5 kPa", "", "0.5 turns at 3 Pa")
    tried = {pose: Trial(each) for pose, each in zip(poses, said, strict=False)}
    reasons = approach.ApproachAnswer(UPRIGHT, (), tried).reasons
    assert reasons == {"0.5 turns at 3 kPa": 2, "0.5 turns at 3 Pa": 1}


@pytest.mark.parametrize("task", [UPRIGHT, LEVEL, LEANING])
def test_a_centered_pose_has_the_object_where_its_misplacement_is(task):
    center = (7e-3, -4e-3, 0.1, -0.2, 0.0)
    for pose in candidate_poses(task, 2)[::4]:
        there = approach_setup(task, pose).moved(np.array((0.0, *center[:4]))).obstacle
        moved = approach.centered(task, pose, center)
        here = approach_setup(task, moved)
        assert_allclose(here.obstacle.position, there.position, atol=1e-12)
        axis = replace(here, obstacle=there).axis
        sense = np.sign(axis @ here.axis) if task is LEVEL else 1.0  # of a cylinder either
        assert_allclose(here.axis, sense * axis, atol=1e-12)
        assert_allclose(np.dot(moved.gravity, moved.axis), task.down @ task.axis, atol=1e-12)
        assert approach.centered(task, pose, ()) is pose


@pytest.mark.parametrize(
    ("tilt_max", "refused", "size", "center"),
    [
        (pi, False, 9e-3, (7.5e-3, 0.0, 0.0, radians(6.0), 0.0)),
        # The base must not turn so far: the object is shifted alone.
        (radians(5.0), False, 4e-3, (7.5e-3, 0.0, 0.0, 0.0, 0.0)),
        (pi, True, 2e-3, ()),
    ],
)
def test_an_object_is_moved_to_the_middle_of_its_region(
    tilt_max, refused, size, center, monkeypatch
):
    """10 mm about a place 7.5 mm farther away, and 10 degrees about a direction 6 degrees off."""
    task = replace(UPRIGHT, tilt_max=tilt_max)
    middle = approach_setup(task, HANGING).moved(np.array((0.0, 7.5e-3, 0.0, 0.0, radians(6.0))))

    def gripped(task, pose):
        if refused and pose != HANGING:
            raise NoCoilError(1.0, 2.0, 3.0)
        return GripPoint(7e4, approach_setup(task, pose), None)

    def close(setup, _, off, payload, elements):
        assert (payload, elements) == (task.payload, approach.SCREEN_ELEMENTS)
        there = setup.moved(np.array((0.0, *off[:4])))
        near = norm(np.subtract(there.obstacle.position, middle.obstacle.position)) < 10e-3
        held = near and there.axis @ middle.axis > cos(radians(10.0))
        return SimpleNamespace(outcome=CaptureOutcome.HOLDS if held else CaptureOutcome.TOO_WEAK)

    monkeypatch.setattr(approach, "gripped", gripped)
    monkeypatch.setattr(approach, "close_misplaced", close)
    monkeypatch.setattr(approach, "holding_force", lambda *_: SimpleNamespace(force=0.7))
    found = approach.judge(task, HANGING)
    assert_allclose((found.size, found.force, found.pressure), (size, 0.7, 7e4))
    assert_allclose(found.center, center, atol=1e-12)


@pytest.mark.parametrize("off", [0.0, 3.0, 5.0, 170.0])
def test_near_upright_a_pose_holds_no_tilt_by_which_the_tube_falls_to_another_side(
    off, monkeypatch
):
    """Exactly upright: turned by a degree to the other side the tube passes the object by."""
    holds = SimpleNamespace(outcome=CaptureOutcome.HOLDS)
    monkeypatch.setattr(approach, "close_misplaced", lambda *_: holds)
    gravity = (-cos(radians(off)), sin(radians(off)), 0.0)
    point = GripPoint(7e4, approach_setup(UPRIGHT, BasePose(gravity, gravity)), None)
    found = [approach.holds_shifted(point, size) for size in (2.0, 4.0, 6.0)]
    assert found == [off > size for size in (2.0, 4.0, 6.0)]
    assert point.setup.falls_by_choice is (off == 0.0)
    light = replace(GRIPPER, weight_per_length=0.01)
    setup = replace(point.setup, gripper=light.with_mount((-9.80665, 0.0, 0.0), None))
    assert (setup.balance_angle, setup.falls_by_choice) == (inf, False)
    region = SimpleNamespace(semi_axes=np.array((0.02, 0.03, 0.4, 0.5, 0.01)))
    monkeypatch.setattr(approach, "capture_region", lambda *_, **__: region)
    answer = approach.Approach(UPRIGHT, None, point, Trial(""))
    monkeypatch.setattr(approach, "_key", lambda *_: ())
    sized = approach.Search(UPRIGHT).with_region(answer).found.size
    assert_allclose(sized, 1e-3 * min(off, 20.0), atol=1e-12)


def test_what_wraps_just_below_the_pressure_limit_is_looked_for_up_to_it():
    setup = approach_setup(UPRIGHT, HANGING)
    onset = grip_window(setup).onset_wrap
    assert 0.98 < onset / setup.tip_pressure < 0.995
    weaker = replace(GRIPPER, pressure_max=1.01 * setup.tip_pressure)
    found = coarse_grip(replace(UPRIGHT, gripper=weaker), HANGING)
    assert onset <= found.pressure <= weaker.pressure_max


def test_an_arm_that_cannot_tilt_rolls_and_shifts():
    """And does not try directions that hardly differ."""
    tight, free = (approach.Search(replace(LEANING, tilt_max=each)) for each in (1e-3, pi))
    poses = candidate_poses(tight.task)
    assert 1 < len(poses) <= 6
    others = tight.around(poses[:1], 1.0)
    assert [each.shift for each in others] == [each.shift for each in free.around(poses[:1], 1.0)]
    assert all(approach.tilt_of(each) <= 1e-3 for each in others)
    turns = [degrees(angle_between(LEANING, poses[0], each)) for each in others]
    assert max(turns) > 20.0


def test_a_pose_that_is_not_wrapped_at_the_tip_criterion_s_pressure_is_given_up(monkeypatch):
    windows = []

    def watched(*given, **more):
        windows.append(grip_window(*given, **more))
        return windows[-1]

    monkeypatch.setattr(approach, "grip_window", watched)
    task = replace(UPRIGHT, object_axis=(1.4, 0.0, 1.0))
    found = coarse_grip(task, candidate_poses(task, 1)[0])
    assert found.refusal == windows[0].end.value == WindowEnd.PASSED_BY.value
    assert 1.0 <= windows[0].top / windows[0].setup.tip_pressure < 1.03


def test_first_errors_of_each_kind_and_sense_tell_poses_apart():
    """Millimeters and degrees: what is held with each of them alone."""
    sizes, leaning = [], candidate_poses(LEANING, 1)
    for task, pose in (UPRIGHT, HANGING), (LEANING, leaning[0]), (LEANING, leaning[14]):
        point = coarse_grip(task, pose)
        held = [0.0]
        for size in (4.0, 9.0):
            off = np.diag(size * np.array((1e-3, 1e-3, radians(1.0), radians(1.0), 0.0)))[:4]
            ends = [
                close_misplaced(point.setup, point.pressure, one).outcome is CaptureOutcome.HOLDS
                for one in (*off, *-off)
            ]
            held += [1e-3 * size] if all(ends) else []
        found = screen_shifted(task, pose)
        assert found == replace(screen(task, pose), size=max(held))
        sizes.append(found.size)
    assert_allclose(sizes, (4e-3, 0.0, 9e-3), rtol=1e-12)


def test_objects_are_tried_along_the_coil_and_leaning_from_it():
    """Their end to which the coil advances toward the base, by up to 24 degrees, on the cone."""
    weak = replace(LEANING, gravity=(0.0, 0.0, -0.1))  # upright, the coil advances upwards
    for task in (LEANING, replace(LEANING, object_axis=(2.0, 0.0, 1.0)), LEVEL, weak):
        for first in range(0, 12, 4):
            down = candidate_poses(task, 6)[first].gravity
            poses = [pose for pose in candidate_poses(task, 6) if pose.gravity == down]
            along, away, _ = lay_into_coil(task.mounted(down), task.radius).frame
            for lean in (0.0, 12.0, 24.0):
                line = cos(radians(lean)) * along - sin(radians(lean)) * away
                angles = np.linspace(0.0, 2.0 * pi, 361)[:, None] * np.array(down)
                every = Rotation.from_rotvec(angles).apply(poses[0].axis)
                best = np.abs(every @ line).max()
                near = max(abs(np.dot(pose.axis, line)) for pose in poses)
                assert best - 0.004 < near < best + 1e-4  # turns in steps of 10 degrees


def test_a_coarse_search_finds_poses_that_hold(monkeypatch):
    for name in ("COARSE_DIRECTIONS", "DIRECTIONS", "AROUND"):
        monkeypatch.setattr(approach, name, 1)
    task = replace(UPRIGHT, tilt_max=radians(15.0))
    answer = find_approaches(task, coarse=True)
    best = answer.approaches[0]
    recorded("approach/coarse", [best.found, len(answer.tried)], within=1e-3)
    assert best.found.force > 2.0 * 0.02 * 9.80665  # the payload, twice
    middle = base_rotation(task, best.pose).apply(best.point.setup.obstacle.position)
    assert_allclose(best.position, -middle)
    assert Rotation.from_quat(best.orientation).apply((1, 0, 0))[2] < -cos(task.tilt_max)
