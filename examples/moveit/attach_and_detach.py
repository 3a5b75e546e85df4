# SPDX-License-Identifier: Apache-2.0
"""Approach and wrap an object, attach it to the arm in MoveIt's planning scene, release it.

Start MoveIt and the gripper's node with the files beside this one, then run
``python3 attach_and_detach.py RADIUS LENGTH X Y Z`` for a cylinder that stands upright with its
middle at X Y Z of MoveIt's planning frame, all in meters.
"""

from __future__ import annotations

import sys
from typing import Any

import rclpy
from geometry_msgs.msg import Pose, PoseStamped
from moveit_msgs.msg import AttachedCollisionObject, CollisionObject, PlanningScene
from moveit_msgs.srv import ApplyPlanningScene
from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.task import Future
from rclpy.wait_for_message import wait_for_message
from shape_msgs.msg import SolidPrimitive

from spiral_gripper_msgs.action import FindApproach
from spiral_gripper_msgs.msg import Approach
from spiral_gripper_ros.client import SpiralGripper, WrapOutcome

NAMESPACE = "/spiral_gripper"
PLANNING_FRAME, OBJECT = "world", "wrapped_object"
# Largest angle between gravity and the tube at the base that the arm can reach [rad].
TILT_MAX = 1.0
SEARCH_TIMEOUT = 600.0
# They may touch the object while it is attached.
TOUCHING = ["gripper_base", "gripper_shape"]


def find_approaches(node: Node, radius: float, place: list[float]) -> list[Approach]:
    """Return goals for the link gripper_base, the best first; takes about a minute."""
    client = ActionClient(node, FindApproach, f"{NAMESPACE}/find_approach")
    goal = FindApproach.Goal(object_radius=radius, tilt_max=[TILT_MAX])
    goal.object_pose.header.frame_id = PLANNING_FRAME
    point = goal.object_pose.pose.position
    point.x, point.y, point.z = place
    if not client.wait_for_server(timeout_sec=10.0):
        raise SystemExit(f"there is no action {NAMESPACE}/find_approach: does the node run?")
    handle = answered(node, client.send_goal_async(goal), 10.0)
    if not handle.accepted:
        raise SystemExit("the node refuses to search")
    result = answered(node, handle.get_result_async(), SEARCH_TIMEOUT).result
    if not result.success:
        raise SystemExit(result.message)
    return list(result.approaches)


def answered(node: Node, answer: Future, timeout: float) -> Any:  # noqa: ANN401
    """Return an answer that comes within a time [s]."""
    rclpy.spin_until_future_complete(node, answer, timeout_sec=timeout)
    if not answer.done():
        raise SystemExit(f"no answer within {timeout:g} s, or interrupted")
    return answer.result()


def scene_with_attached(pose: PoseStamped, radius: float, length: float) -> PlanningScene:
    """Return the change of the scene that attaches a cylinder to the gripper's base.

    Args:
        pose: the middle of the cylinder, z along its axis, as on the topic wrapped_object_pose.
        radius: of the cylinder [m].
        length: of the cylinder [m].
    """
    cylinder = SolidPrimitive(type=SolidPrimitive.CYLINDER, dimensions=[length, radius])
    attached = AttachedCollisionObject(link_name=TOUCHING[0], touch_links=TOUCHING)
    attached.object = CollisionObject(id=OBJECT, operation=CollisionObject.ADD)
    attached.object.header = pose.header
    attached.object.pose = pose.pose
    attached.object.primitives = [cylinder]
    attached.object.primitive_poses = [Pose()]
    return change(attached)


def scene_with_detached() -> PlanningScene:
    """Return the change of the scene that leaves the object where it is, attached to nothing."""
    attached = AttachedCollisionObject(link_name=TOUCHING[0])
    attached.object = CollisionObject(id=OBJECT, operation=CollisionObject.REMOVE)
    return change(attached)


def change(attached: AttachedCollisionObject) -> PlanningScene:
    """Return a scene that changes one attached object and nothing else."""
    scene = PlanningScene(is_diff=True)
    scene.robot_state.is_diff = True
    scene.robot_state.attached_collision_objects = [attached]
    return scene


def main(radius: float, length: float, *place: float) -> None:
    """Grasp and release once."""
    rclpy.init()
    node = rclpy.create_node("attach_and_detach")
    client = node.create_client(ApplyPlanningScene, "/apply_planning_scene")
    if not client.wait_for_service(timeout_sec=10.0):
        raise SystemExit("MoveIt does not run: there is no service /apply_planning_scene")

    def apply(scene: PlanningScene) -> None:
        answer = client.call_async(ApplyPlanningScene.Request(scene=scene))
        if not answered(node, answer, 10.0).success:
            raise SystemExit("MoveIt has not changed its planning scene")

    with SpiralGripper(NAMESPACE) as gripper:
        gripper.wait_until_active(timeout=60.0)
        try:
            approach, *_ = find_approaches(node, radius, list(place))  # the first it can reach
            print(approach.base_pose.pose)  # here the arm moves there
            # The node commands the approach's pressure, as overpressure above that of its wrap.
            planned = gripper.plan(radius)
            if not planned.success:
                raise SystemExit(planned.message)
            (wrap,) = planned.figures
            extra = approach.pressure - (wrap.pressure - wrap.overpressure)
            gripper.wrap(radius=radius, overpressure=max(extra, 0.0))
            result = gripper.wait(timeout=30.0)
            if result.outcome is not WrapOutcome.SUCCEEDED:
                raise SystemExit(result.message)
            found, pose = wait_for_message(
                PoseStamped, node, f"{NAMESPACE}/wrapped_object_pose", time_to_wait=5.0
            )
            if not found:
                raise SystemExit(
                    "wrapped_object_pose is silent: set the node's publish.robot_state_rate"
                )
            apply(scene_with_attached(pose, radius, length))
            # Here the arm moves with the object.
        finally:
            gripper.release()
        apply(scene_with_detached())
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main(*map(float, sys.argv[1:6]))
