# SPDX-License-Identifier: Apache-2.0
"""`find_approach`: the core's search for an object at its place in any frame, and its cancel."""

import math
from dataclasses import replace

import numpy as np
import pytest
import yaml
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import Point, Vector3
from ros.grasp_goals import Goals, refused
from ros.harness import RunningNode
from ros.records import agrees, told
from scipy.spatial.transform import Rotation

from spiral_core import ApproachTask, InvalidInputError, find_approaches
from spiral_core.wrap.gripper import STANDARD_GRAVITY
from spiral_gripper import load_gripper
from spiral_gripper_msgs.action import FindApproach
from spiral_gripper_ros.actions.find_approach import question_from_msg
from spiral_gripper_ros.control.states import Reason
from spiral_gripper_ros.messages.conversions import quaternion_from_msg, vector_from_msg

GRIPPER = load_gripper("paper_design_70")


def goal(radius=0.015, **fields):
    request = FindApproach.Goal(object_radius=radius, **fields)
    request.object_pose.pose.position = Point(x=1.0, y=-2.0, z=0.5)
    request.object_pose.header.frame_id = "world"
    return request


# The object's orientation, and fields of the goal; the first has its z along the world's x.
GOALS = """
- {y: 0.5, w: 0.5, payload: [0.02], tilt_max: [1.0]}
- {gravity: [{x: 3.7}], friction_coefficient: [0.3], regions: true}
- {radius: 0.0}
- {radius: .nan}
- {radius: 15.0}
- {w: 0.0}
- {z: .nan}
- {gravity: [{}]}
- {gravity: [{x: .inf}]}
- {payload: [0.0]}
- {payload: [101.0]}
- {friction_coefficient: [-0.1]}
- {tilt_max: [3.2]}
"""


def test_a_goal_states_the_object_in_the_world_or_is_refused_as_on_record():
    found = []
    for fields in yaml.safe_load(GOALS):
        found.append(f"# {fields}")
        turn = {name: fields.pop(name) for name in "xyzw" if name in fields}
        if "gravity" in fields:
            fields["gravity"] = [Vector3(**one) for one in fields["gravity"]]
        request = goal(**fields)
        for name, part in turn.items():
            setattr(request.object_pose.pose.orientation, name, part * math.sqrt(2.0))
        try:
            question = question_from_msg(request, GRIPPER, 1e9)
            friction = question.gripper.friction_coefficient
            found += [told(replace(question, gripper=None)), f"friction {friction}"]
        except InvalidInputError as error:
            found.append(str(error))
    agrees("approaches", "\n".join(found))
    # No approach needs more than the node commands.
    assert question_from_msg(goal(), GRIPPER, 6e4).gripper.pressure_max == 6e4
    assert question_from_msg(goal(), GRIPPER, 1e9).gripper == GRIPPER


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
        pose = found.base_pose.pose
        base = Rotation.from_quat(quaternion_from_msg(pose.orientation)).inv()
        seen = base.apply(np.subtract((1.0, -2.0, 0.5), vector_from_msg(pose.position)))
        assert seen == pytest.approx(core.point.setup.obstacle.position, abs=1e-12)
        assert base.apply((0.0, 0.0, -1.0)) == pytest.approx(core.pose.gravity, abs=1e-9)
