"""One gripper: the node, configured and activated by launch, with an optional namespace."""

from __future__ import annotations

from launch import LaunchContext, LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    EmitEvent,
    LogInfo,
    OpaqueFunction,
    RegisterEventHandler,
)
from launch.events import matches_action
from launch.substitutions import LaunchConfiguration, ThisLaunchFileDir
from launch_ros.actions import LifecycleNode
from launch_ros.event_handlers import OnStateTransition
from launch_ros.events.lifecycle import ChangeState
from lifecycle_msgs.msg import Transition

# Arguments that set the parameter of their name if they are given, whatever the file says.
SETTINGS = ("gripper", "frame_id")


def generate_launch_description() -> LaunchDescription:
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "parameters",
                default_value=[ThisLaunchFileDir(), "/../config/gripper.yaml"],
                description="YAML file of the node's parameters",
            ),
            DeclareLaunchArgument(
                "gripper",
                default_value="",
                description="shipped gripper's name, or path of a description file; "
                "not given: as the parameters file says",
            ),
            DeclareLaunchArgument(
                "frame_id",
                default_value="",
                description="the gripper's base frame; not given: as the parameters file says",
            ),
            DeclareLaunchArgument("namespace", default_value="", description="of the node"),
            DeclareLaunchArgument(
                "use_sim_time",
                default_value="false",
                choices=["true", "false"],
                description="whether time is that of /clock",
            ),
            OpaqueFunction(function=gripper_node),
        ]
    )


def gripper_node(context: LaunchContext) -> list[object]:
    given = {name: LaunchConfiguration(name).perform(context) for name in SETTINGS}
    node = LifecycleNode(
        package="spiral_gripper_ros",
        executable="spiral_gripper_node",
        name="spiral_gripper",
        namespace=LaunchConfiguration("namespace"),
        output="screen",
        parameters=[
            LaunchConfiguration("parameters"),
            {
                "autostart": False,
                "use_sim_time": LaunchConfiguration("use_sim_time").perform(context) == "true",
                **{name: value for name, value in given.items() if value},
            },
        ],
    )

    def change(transition: int) -> EmitEvent:
        return EmitEvent(
            event=ChangeState(lifecycle_node_matcher=matches_action(node), transition_id=transition)
        )

    def after(start: str, goal: str, entity: object) -> RegisterEventHandler:
        return RegisterEventHandler(
            OnStateTransition(
                target_lifecycle_node=node,
                start_state=start,
                goal_state=goal,
                entities=[entity],
            )
        )

    return [
        after("configuring", "inactive", change(Transition.TRANSITION_ACTIVATE)),
        after(
            "configuring",
            "unconfigured",
            LogInfo(msg="spiral_gripper was not configured: its log says why"),
        ),
        node,
        change(Transition.TRANSITION_CONFIGURE),
    ]
