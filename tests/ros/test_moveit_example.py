# SPDX-License-Identifier: Apache-2.0
"""The files of examples/moveit: names of the model and of the node, and the right scenes."""

import importlib
import sys
from types import SimpleNamespace
from xml.etree import ElementTree

import pytest
import rclpy
from geometry_msgs.msg import PoseStamped
from repo.source_tree import ROOT
from ros.harness import RunningNode
from ros.records import agrees, told

from spiral_gripper_ros.parameters.table import GripperParameters

FOLDER = ROOT / "examples/moveit"
MODEL = ElementTree.parse(ROOT / "spiral_gripper_ros/urdf/spiral_gripper.xacro").getroot()
SRDF = ElementTree.parse(FOLDER / "spiral_gripper.srdf").getroot()


class Message(SimpleNamespace):
    """Stands in for a message of MoveIt, which PyPI does not have."""

    CYLINDER, ADD, REMOVE = 3, b"\x00", b"\x01"
    robot_state = SimpleNamespace()


class Package:
    """Stands in for a package whose every name is such a message."""

    __getattr__ = staticmethod(lambda _: Message)


@pytest.fixture
def example(monkeypatch):
    """The example as a module, with stand-ins for the packages that PyPI does not have."""
    for name in (
        "moveit_msgs",
        "moveit_msgs.msg",
        "moveit_msgs.srv",
        "shape_msgs",
        "shape_msgs.msg",
    ):
        monkeypatch.setitem(sys.modules, name, Package())
    monkeypatch.syspath_prepend(str(FOLDER))
    return importlib.import_module("attach_and_detach")


def named(tree, path, attribute="name"):
    """The attributes of elements, in the gripper's part of a URDF without its prefix."""
    return {item.get(attribute).removeprefix("${prefix}") for item in tree.iterfind(path)}


def test_the_srdf_names_links_and_joints_of_the_model_and_opens_with_a_release():
    links = named(SRDF, "group[@name='gripper']/link")
    for end in ("link1", "link2"):
        links |= named(SRDF, "disable_collisions", end)
    links |= named(SRDF, "end_effector", "parent_link")
    assert links - named(MODEL, ".//link") == {"tool0"}  # of the arm
    assert named(SRDF, ".//joint") <= named(MODEL, ".//joint")
    assert named(SRDF, "end_effector", "group") == {"gripper"}
    joints = SRDF.iterfind("group_state/joint")
    opening, *values = sorted((float(joint.get("value")) for joint in joints), reverse=True)
    assert opening == GripperParameters().gripper_cmd.open_position
    assert named(SRDF, f"group_state/joint[@value='{opening:g}']/..") == {"open"}
    assert 0.0 < min(values) <= max(values) < opening


def test_the_arms_goals_are_asked_of_the_node(example, namespace, monkeypatch):
    node = rclpy.create_node("arm", namespace=namespace)
    monkeypatch.setattr(example, "NAMESPACE", namespace)
    with RunningNode(namespace), pytest.raises(SystemExit, match="poses tried grip"):
        example.find_approaches(node, 0.2, [1.0, 0.0, 0.5])
    node.destroy_node()


def test_the_object_is_attached_where_it_is_wrapped_and_detached(example):
    pose = PoseStamped()
    pose.header.frame_id = "gripper_base"
    pose.pose.position.x = 0.2
    scene = example.scene_with_attached(pose, radius=0.02, length=0.5)
    (attached,) = scene.robot_state.attached_collision_objects
    assert scene.is_diff is scene.robot_state.is_diff is True
    assert set(attached.touch_links) == named(SRDF, "group[@name='gripper']/link")
    (detached,) = example.scene_with_detached().robot_state.attached_collision_objects
    agrees("moveit", told(attached, detached))
