# SPDX-License-Identifier: Apache-2.0
"""`find_approach`: the core's search for an object at its place in any frame, and its cancel."""

import math

import pytest
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import Vector3
from ros.grasp_goals import Goals, refused
from ros.harness import RunningNode
from scipy.spatial.transform import Rotation

from spiral_core import ApproachTask, InvalidInputError, find_approaches
from spiral_core.wrap.gripper import STANDARD_GRAVITY
from spiral_gripper import load_gripper
from spiral_gripper_msgs.action import FindApproach
from spiral_gripper_ros.actions.find_approach import question_from_msg
from spiral_gripper_ros.control.states import Reason

GRIPPER = load_gripper("paper_design_70")


def goal(radius=0.015, orientation=(0.0, 0.0, 0.0, 1.0), **fields):
    request = FindApproach.Goal(object_radius=radius, **fields)
    pose, names = request.object_pose.pose, "xyzw"
    for name, value in zip(names, orientation, strict=True):
        setattr(pose.orientation, name, float(value))
    pose.position.x, pose.position.y, pose.position.z = 1.0, -2.0, 0.5
    request.object_pose.header.frame_id = "world"
    return request


def test_a_goal_states_the_object_in_the_world():
    level = (0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5))  # z along the world's x
    asked = question_from_msg(goal(orientation=level, payload=[0.02], tilt_max=[1.0]), GRIPPER)
    assert asked.object_axis == pytest.approx((1.0, 0.0, 0.0))
    assert (asked.gravity, asked.payload) == ((0.0, 0.0, -STANDARD_GRAVITY), 0.02)
    assert (asked.tilt_max, asked.regions, asked.gripper) == (1.0, False, GRIPPER)
    pulled = goal(gravity=[Vector3(x=3.7)], friction_coefficient=[0.3])
    assert question_from_msg(pulled, GRIPPER).gravity == (3.7, 0.0, 0.0)
    assert question_from_msg(pulled, GRIPPER).gripper.friction_coefficient == 0.3


@pytest.mark.parametrize(
    ("fields", "named"),
    [
        ({"radius": 0.0}, "radius"),
        ({"radius": math.nan}, "radius"),
        ({"orientation": (0, 0, 0, 0)}, "orientation"),
        ({"orientation": (0, 0, math.nan, 1)}, "orientation"),
        ({"gravity": [Vector3()]}, "gravity"),
        ({"gravity": [Vector3(x=math.inf)]}, "gravity"),
        ({"payload": [0.0]}, "payload"),
        ({"friction_coefficient": [-0.1]}, "friction_coefficient"),
        ({"tilt_max": [3.2]}, "tilt_max"),
    ],
)
def test_what_makes_no_sense_is_refused_by_name_before_a_search(fields, named):
    with pytest.raises(InvalidInputError) as refusal:
        question_from_msg(goal(**fields), GRIPPER)
    assert named in refusal.value.field


def test_a_search_can_be_canceled_and_the_next_one_says_why_nothing_grips(namespace, client):
    with RunningNode(namespace):
        goals = Goals(client, FindApproach, "find_approach")
        running = goals.send(goal(regions=True))
        client.wait_until(
            lambda: running.feedback and running.feedback[-1].closed > 0, "the first closing"
        )
        assert running.feedback[-1].closed <= running.feedback[-1].expected
        assert running.cancel()
        assert running.end()[0] == GoalStatus.STATUS_CANCELED
        assert "poses tried grip" in refused(goals.send(goal(radius=0.2)), Reason.NOT_CERTIFIED)
        older = goals.send(goal())
        assert "radius" in refused(goals.send(goal(radius=-1.0)), Reason.INVALID_REQUEST)
        assert not older.is_done
        newer = goals.send(goal(radius=0.2))
        assert "replaced by a newer goal" in refused(older, Reason.INVALID_REQUEST)
        assert newer.end()[0] == GoalStatus.STATUS_ABORTED
        goals.close()


@pytest.mark.slow
def test_the_base_poses_are_those_of_the_core_at_the_object_s_place(namespace, client):
    request = goal(payload=[0.02], tilt_max=[1.0])
    task = ApproachTask(GRIPPER, 0.015, (0, 0, 1), (0, 0, -STANDARD_GRAVITY), 0.02, 1.0)
    expected = find_approaches(task, coarse=True)
    with RunningNode(namespace):
        goals = Goals(client, FindApproach, "find_approach")
        status, result = goals.send(request).end()
        goals.close()
    assert status == GoalStatus.STATUS_SUCCEEDED
    for found, core in zip(result.approaches, expected.approaches, strict=True):
        assert found.base_pose.header.frame_id == "world"
        assert (found.pressure, found.force) == (core.found.pressure, core.found.force)
        assert not found.capture_size
        place, turn = found.base_pose.pose.position, found.base_pose.pose.orientation
        base = Rotation.from_quat((turn.x, turn.y, turn.z, turn.w))
        seen = base.inv().apply((1.0 - place.x, -2.0 - place.y, 0.5 - place.z))
        assert seen == pytest.approx(core.point.setup.obstacle.position, abs=1e-12)
        down = base.inv().apply((0.0, 0.0, -1.0))
        assert down == pytest.approx(core.pose.gravity, abs=1e-9)
