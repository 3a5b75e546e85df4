# SPDX-License-Identifier: Apache-2.0
"""The files of examples/moveit: names of the model and of the node, and the right scenes."""

import importlib
import sys
from types import ModuleType, SimpleNamespace
from xml.etree import ElementTree

import pytest
from geometry_msgs.msg import PoseStamped
from repo.source_tree import ROOT

from spiral_gripper_ros.parameters.table import GripperParameters

FOLDER = ROOT / "examples/moveit"
MODEL = ElementTree.parse(ROOT / "spiral_gripper_ros/urdf/spiral_gripper.xacro").getroot()
SRDF = ElementTree.parse(FOLDER / "spiral_gripper.srdf").getroot()
OF_THE_ARM = {"tool0"}


class Message:
    """Stands in for a message of MoveIt, which PyPI does not have."""

    CYLINDER, ADD, REMOVE = 3, b"\x00", b"\x01"

    def __init__(self, **fields):
        self.robot_state = SimpleNamespace()
        vars(self).update(fields)


@pytest.fixture
def example(monkeypatch):
    """The example as a module, with stand-ins for the packages that PyPI does not have."""
    names = {
        "moveit_msgs.msg": ("AttachedCollisionObject", "CollisionObject", "PlanningScene"),
        "moveit_msgs.srv": ("ApplyPlanningScene",),
        "shape_msgs.msg": ("SolidPrimitive",),
    }
    for module, kinds in names.items():
        stand_in = ModuleType(module)
        vars(stand_in).update(dict.fromkeys(kinds, Message))
        monkeypatch.setitem(sys.modules, module, stand_in)
        monkeypatch.setitem(sys.modules, module.split(".")[0], ModuleType(module.split(".")[0]))
    monkeypatch.syspath_prepend(str(FOLDER))
    monkeypatch.delitem(sys.modules, "attach_and_detach", raising=False)
    return importlib.import_module("attach_and_detach")


def named(tree, path, attribute="name"):
    """The attributes of elements, in the gripper's part of a URDF without its prefix."""
    return {item.get(attribute).removeprefix("${prefix}") for item in tree.iterfind(path)}


def test_the_srdf_names_links_and_joints_of_the_model_and_opens_with_a_release():
    links = named(SRDF, "group[@name='gripper']/link")
    for end in ("link1", "link2"):
        links |= named(SRDF, "disable_collisions", end)
    links |= named(SRDF, "end_effector", "parent_link")
    assert links - named(MODEL, ".//link") == OF_THE_ARM
    assert named(SRDF, ".//joint") <= named(MODEL, ".//joint")
    assert named(SRDF, "end_effector", "group") == {"gripper"}
    values = {
        state.get("name"): float(state.find("joint").get("value"))
        for state in SRDF.iter("group_state")
    }
    opening = GripperParameters().gripper_cmd.open_position
    assert values.pop("open") == opening
    assert values
    assert all(0.0 < value < opening for value in values.values())


def test_the_object_is_attached_where_it_is_wrapped_and_detached(example):
    pose = PoseStamped()
    pose.header.frame_id = "gripper_base"
    pose.pose.position.x = 0.2
    scene = example.scene_with_attached(pose, radius=0.02, length=0.5)
    (attached,) = scene.robot_state.attached_collision_objects
    assert scene.is_diff is scene.robot_state.is_diff is True
    assert attached.link_name == attached.object.header.frame_id == "gripper_base"
    assert set(attached.touch_links) == named(SRDF, "group[@name='gripper']/link")
    assert attached.object.operation == Message.ADD
    assert attached.object.pose.position.x == 0.2
    assert attached.object.primitives[0].dimensions == [0.5, 0.02]  # height, radius
    (detached,) = example.scene_with_detached().robot_state.attached_collision_objects
    assert detached.object.id == attached.object.id == example.OBJECT
    assert detached.object.operation == Message.REMOVE
