# SPDX-License-Identifier: Apache-2.0
"""How an arm should hold the gripper: poses in the world, symmetry, the search for the best."""

from dataclasses import replace
from math import cos, degrees, nan, pi, radians
from types import SimpleNamespace

import numpy as np
import pytest
from core.gripper_cases import paper_gripper
from numpy.testing import assert_allclose
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


@pytest.fixture
def few(monkeypatch):
    """Few directions, so that a search takes seconds."""
    for name in ("COARSE_DIRECTIONS", "DIRECTIONS", "AROUND"):
        monkeypatch.setattr(approach, name, 1)
    monkeypatch.setattr(approach, "PARTS", (1.0,))


@pytest.fixture
def point(monkeypatch):
    """A grip that every pose has; its force is not known."""
    setup = approach_setup(UPRIGHT, HANGING, 20)
    point = GripPoint(70e3, setup, hanging_tube(setup))
    monkeypatch.setattr(approach, "gripped", lambda *_: point)
    monkeypatch.setattr(approach, "holding_force", lambda *_: SimpleNamespace(force=nan))
    return point


def test_a_pose_shows_the_base_the_world_s_gravity_and_object():
    for task in [UPRIGHT, LEVEL, replace(LEANING, gravity=(1.0, -2.0, 9.0))]:
        for pose in candidate_poses(task, 5):
            rotation = base_rotation(task, pose)
            assert_allclose(rotation.apply(pose.gravity), task.down, atol=1e-9)
            assert_allclose(rotation.apply(pose.axis), task.axis, atol=1e-9)
        there = approach_setup(task, replace(pose, shift=(1e-3, -2e-3, 3e-3))).obstacle.position
        shift = np.subtract(there, approach_setup(task, pose).obstacle.position)
        assert_allclose(shift, (1e-3, -2e-3, 3e-3), atol=1e-12)


def test_poses_are_hanging_upright_level_and_spread_within_the_limit():
    seen, limit = {pose.gravity for pose in candidate_poses(UPRIGHT, 40)}, radians(25.0)
    assert {tuple(row) for row in np.concatenate((np.eye(3), 0.0 - np.eye(3))).tolist()} <= seen
    limited = np.array([each.gravity for each in candidate_poses(replace(UPRIGHT, tilt_max=limit))])
    assert len(limited) > approach.DIRECTIONS  # the hanging one too
    assert 0.95 * limit < np.arccos(limited[:, 0].min()) <= limit


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


def test_a_pose_is_judged_by_the_first_error_that_is_not_held(point, monkeypatch):
    tried = []

    def close(setup, pressure, off, payload, _):
        tried.append((off / approach.UNIT_ERRORS).tolist())
        assert (setup, pressure, payload) == (point.setup, point.pressure, 0.02)
        held = np.abs(off[2]) < radians(5.0)
        return SimpleNamespace(outcome=CaptureOutcome.HOLDS if held else CaptureOutcome.TOO_WEAK)

    monkeypatch.setattr(approach, "close_misplaced", close)
    assert judge(UPRIGHT, HANGING) == Trial("", 0.0, 70e3, 0.0, 4e-3)
    assert tried[:2] == [[2.0, 0.0, 0.0, 0.0, 0.0], [0.0, 2.0, 0.0, 0.0, 0.0]]
    assert tried[-1] == [0.0, 0.0, 6.0, 0.0, 0.0]


def test_the_larger_region_is_better_then_the_larger_force():
    trials = {
        turned(HANGING, 0.0, 0.0, angle): trial
        for angle, trial in (
            (0.0, Trial("", size=2.1e-3, force=3.0)),
            (1.0, Trial("no", missing=0.1)),
            (2.0, Trial("", size=2.3e-3, force=4.0)),
            (3.0, Trial("", size=4e-3, force=1.0)),
            # Hardly another than the one before it.
            (3.2, Trial("", size=3e-3, force=1.0)),
        )
    }
    poses = [*trials]
    assert distinct(UPRIGHT, trials, 4) == [poses[each] for each in (3, 2, 0, 1)]


@pytest.mark.usefixtures("few")
def test_a_coarse_search_finds_poses_and_goes_on_from_what_is_known(monkeypatch):
    task, kept, steps = replace(UPRIGHT, tilt_max=radians(15.0)), {}, []
    answer = find_approaches(
        task, coarse=True, keep=kept.__setitem__, progress=lambda *step: steps.append(step)
    )
    best = answer.approaches[0]
    assert best.region is None
    assert best.found.force == max(each.found.force for each in answer.approaches)
    assert best.found.force > 2.0 * 0.02 * 9.80665  # the payload, twice
    middle = base_rotation(task, best.pose).apply(best.point.setup.obstacle.position)
    assert_allclose(best.position, -middle, atol=1e-12)
    assert Rotation.from_quat(best.orientation).apply((1, 0, 0))[2] < -cos(task.tilt_max)
    assert steps[-1][0] == steps[-1][1]
    assert answer.gripping + sum(answer.reasons.values()) == len(answer.tried) > 1
    monkeypatch.setattr(approach, "mapping", lambda _: lambda _, poses: iter(poses))
    again = find_approaches(task, coarse=True, known=kept)
    assert [each.pose for each in again.approaches] == [each.pose for each in answer.approaches]


@pytest.mark.usefixtures("few", "point")
def test_the_region_of_a_full_search_goes_into_the_score(monkeypatch):
    kept, knowns = {}, []

    def region(*_, known, keep, **__):
        knowns.append(known)
        keep((0.0,) * 5, CaptureOutcome.HOLDS)
        return SimpleNamespace(semi_axes=np.array((3e-3, 2e-3, 0.02, 0.03, 1e-5)))

    for name, value in (("capture_region", region), ("ERRORS", ()), ("VARIED", 1)):
        monkeypatch.setattr(approach, name, value)
    for _ in range(2):
        task = replace(UPRIGHT, tilt_max=radians(15.0))
        (best,) = find_approaches(task, known=kept, keep=kept.__setitem__).approaches
    assert_allclose(best.found.size, 1e-3 * degrees(0.02))
    assert best.found.score[1] == 2
    assert knowns == [{}, {(0.0,) * 5: CaptureOutcome.HOLDS}]
