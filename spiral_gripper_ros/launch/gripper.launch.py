"""One gripper: the node, configured and activated by launch, with an optional namespace."""

from __future__ import annotations

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, EmitEvent, RegisterEventHandler
from launch.events import matches_action
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import LifecycleNode
from launch_ros.event_handlers import OnStateTransition
from launch_ros.events.lifecycle import ChangeState
from lifecycle_msgs.msg import Transition


def generate_launch_description() -> LaunchDescription:
    node = LifecycleNode(
        package="spiral_gripper_ros",
        executable="spiral_gripper_node",
        name="spiral_gripper",
        namespace=LaunchConfiguration("namespace"),
        output="screen",
        parameters=[
            {
                "autostart": False,
                "gripper": LaunchConfiguration("gripper"),
                "frame_id": LaunchConfiguration("frame_id"),
            }
        ],
    )

    def change(transition: int) -> EmitEvent:
        return EmitEvent(
            event=ChangeState(lifecycle_node_matcher=matches_action(node), transition_id=transition)
        )

    activate_when_configured = OnStateTransition(
        target_lifecycle_node=node,
        start_state="configuring",
        goal_state="inactive",
        entities=[change(Transition.TRANSITION_ACTIVATE)],
    )
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "gripper",
                default_value="paper_design_70",
                description="shipped gripper's name, or path of a description file",
            ),
            DeclareLaunchArgument("namespace", default_value="", description="of the node"),
            DeclareLaunchArgument(
                "frame_id", default_value="gripper_base", description="the gripper's base frame"
            ),
            RegisterEventHandler(activate_when_configured),
            node,
            change(Transition.TRANSITION_CONFIGURE),
        ]
    )
