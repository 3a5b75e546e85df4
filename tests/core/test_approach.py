# SPDX-License-Identifier: Apache-2.0
"""How an arm should hold the gripper: poses in the world, symmetry, the search for the best."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from core.gripper_cases import paper_gripper
from scipy.spatial.transform import Rotation

from spiral_core import ApproachTask, find_approaches
from spiral_core.grip import approach
from spiral_core.grip.approach import (
    BasePose,
    Trial,
    angle_between,
    approach_setup,
    base_rotation,
    candidate_poses,
    distinct,
    judge,
)
from spiral_core.grip.capture import CaptureOutcome
from spiral_core.grip.setup import hanging_tube
from spiral_core.grip.window import GripPoint

pytestmark = pytest.mark.long

DOWN = (0.0, 0.0, -9.80665)
GRIPPER = paper_gripper("70 degrees")
UPRIGHT = ApproachTask(GRIPPER, 0.015, (0.0, 0.0, 1.0), DOWN, 0.02)
LEVEL = replace(UPRIGHT, object_axis=(1.0, 0.0, 0.0))
LEANING = replace(UPRIGHT, object_axis=(0.3, 0.0, 1.0))
HANGING = BasePose((1.0, 0.0, 0.0), (1.0, 0.0, 0.0))


def turned(pose, turn):
    """A pose whose base is turned by a rotation in the base frame."""
    gravity, axis = (tuple(turn.apply(each).tolist()) for each in (pose.gravity, pose.axis))
    return BasePose(gravity, axis)


@pytest.fixture
def few(monkeypatch):
    """Few directions, so that a search takes seconds."""
    for name in ("COARSE_DIRECTIONS", "DIRECTIONS"):
        monkeypatch.setattr(approach, name, 1)
    monkeypatch.setattr(approach, "PARTS", (1.0,))
    monkeypatch.setattr(approach, "AROUND", 1)


@pytest.fixture
def point(monkeypatch):
    """A grip that every pose has; its force is not known."""
    setup = approach_setup(UPRIGHT, HANGING, 20)
    point = GripPoint(70e3, setup, hanging_tube(setup))
    monkeypatch.setattr(approach, "gripped", lambda *_: point)
    monkeypatch.setattr(approach, "holding_force", lambda *_: SimpleNamespace(force=math.nan))
    return point


@pytest.mark.parametrize("task", [UPRIGHT, LEVEL, replace(LEANING, gravity=(1.0, -2.0, 9.0))])
def test_a_pose_shows_the_base_the_world_s_gravity_and_object(task):
    for pose in candidate_poses(task, 5):
        rotation = base_rotation(task, pose)
        assert rotation.apply(pose.gravity) == pytest.approx(task.down, abs=1e-9)
        assert rotation.apply(pose.axis) == pytest.approx(task.axis, abs=1e-9)


def test_poses_are_hanging_upright_level_and_spread_within_the_limit():
    seen = {pose.gravity for pose in candidate_poses(UPRIGHT, 40)}
    assert {tuple(row) for row in np.concatenate((np.eye(3), 0.0 - np.eye(3))).tolist()} <= seen
    limit = math.radians(25.0)
    limited = np.array([each.gravity for each in candidate_poses(replace(UPRIGHT, tilt_max=limit))])
    angles = np.arccos(np.clip(limited[:, 0], -1.0, 1.0))
    assert len(limited) > approach.DIRECTIONS  # the hanging one too
    assert 0.95 * limit < angles.max() <= limit


@pytest.mark.parametrize(
    ("task", "turn", "alike"),
    [(UPRIGHT, 1.0, True), (LEVEL, math.pi, True), (LEVEL, 1.0, False), (LEANING, math.pi, False)],
)
def test_orientations_that_the_object_s_symmetry_makes_alike_do_not_differ(task, turn, alike):
    pose = candidate_poses(task, 1)[-1]
    about_gravity = Rotation.from_rotvec(turn * np.array(pose.gravity))
    other = turned(pose, about_gravity)
    if task is LEVEL and alike:
        assert other.axis == pytest.approx(tuple(-each for each in pose.axis))
    assert angle_between(task, pose, other) == pytest.approx(0.0 if alike else turn, abs=1e-7)


def test_a_pose_is_judged_by_the_first_error_that_is_not_held(point, monkeypatch):
    tried = []

    def close(setup, pressure, off, payload, _):
        tried.append((off / approach.UNIT_ERRORS).tolist())
        assert (setup, pressure, payload) == (point.setup, point.pressure, 0.02)
        held = np.abs(off[2]) < math.radians(5.0)
        outcome = CaptureOutcome.HOLDS if held else CaptureOutcome.TOO_WEAK
        return SimpleNamespace(outcome=outcome)

    monkeypatch.setattr(approach, "close_misplaced", close)
    assert judge(UPRIGHT, HANGING) == Trial("", 0.0, 70e3, 0.0, 4e-3)
    assert tried[:2] == [[2.0, 0.0, 0.0, 0.0, 0.0], [0.0, 2.0, 0.0, 0.0, 0.0]]
    assert tried[-1] == [0.0, 0.0, 6.0, 0.0, 0.0]


def test_the_larger_region_is_better_then_the_larger_force():
    small, strong = Trial("", size=2.1e-3, force=3.0), Trial("", size=2.3e-3, force=4.0)
    large, refused = Trial("", size=4e-3, force=1.0), Trial("no", missing=0.1)
    poses = [turned(HANGING, Rotation.from_rotvec((0.0, 0.0, angle))) for angle in (0, 1, 2, 3)]
    trials = dict(zip(poses, (small, refused, strong, large), strict=True))
    assert distinct(UPRIGHT, trials, 4) == [poses[3], poses[2], poses[0], poses[1]]
    near = turned(HANGING, Rotation.from_rotvec((0.0, 0.0, 3.2)))
    assert near not in distinct(UPRIGHT, trials | {near: small}, 5)


@pytest.mark.usefixtures("few")
def test_a_coarse_search_finds_poses_and_goes_on_from_what_is_known(monkeypatch):
    task, kept, steps = replace(UPRIGHT, tilt_max=math.radians(15.0)), {}, []
    answer = find_approaches(
        task, coarse=True, keep=kept.__setitem__, progress=lambda *step: steps.append(step)
    )
    best = answer.approaches[0]
    assert best.region is None
    assert best.found.force == max(each.found.force for each in answer.approaches)
    assert best.found.force > 2.0 * 0.02 * 9.80665  # the payload, twice
    middle = base_rotation(task, best.pose).apply(best.point.setup.obstacle.position)
    assert np.array(best.position) + middle == pytest.approx(np.zeros(3))
    assert Rotation.from_quat(best.orientation).apply((1, 0, 0))[2] < -math.cos(task.tilt_max)
    assert steps[-1][0] == steps[-1][1]
    assert answer.gripping + sum(answer.reasons.values()) == len(answer.tried) > 1
    monkeypatch.setattr(approach, "mapping", lambda _: lambda _, poses: iter(poses))
    again = find_approaches(task, coarse=True, known=kept)
    assert [each.pose for each in again.approaches] == [each.pose for each in answer.approaches]


@pytest.mark.usefixtures("few", "point")
def test_the_region_of_a_full_search_goes_into_the_score(monkeypatch):
    def region(*_, known, keep, **__):
        knowns.append(known)
        keep((0.0,) * 5, CaptureOutcome.HOLDS)
        return type("Region", (), {"semi_axes": np.array((3e-3, 2e-3, 0.02, 0.03, 1e-5))})

    monkeypatch.setattr(approach, "capture_region", region)
    monkeypatch.setattr(approach, "ERRORS", ())
    monkeypatch.setattr(approach, "VARIED", 1)
    kept, knowns = {}, []
    task = replace(UPRIGHT, tilt_max=math.radians(15.0))
    for _ in range(2):
        answer = find_approaches(task, known=kept, keep=kept.__setitem__)
    (best,) = answer.approaches
    assert best.found.size == pytest.approx(1e-3 * math.degrees(0.02))
    assert best.found.score[1] == 2
    assert knowns == [{}, {(0.0,) * 5: CaptureOutcome.HOLDS}]


def test_a_shift_moves_the_object_in_the_base_frame():
    shift = (1e-3, -2e-3, 3e-3)
    here, there = (
        approach_setup(UPRIGHT, pose) for pose in (HANGING, replace(HANGING, shift=shift))
    )
    moved = np.subtract(there.obstacle.position, here.obstacle.position)
    assert moved == pytest.approx(shift, abs=1e-12)
