# SPDX-License-Identifier: Apache-2.0
"""How many files a reader opens to follow one command, counted by tracing it."""

from repo.tracing import files_entered

from spiral_gripper import load_gripper
from spiral_gripper_ros.control.grasp import GraspGoal
from spiral_gripper_ros.control.grasp_attempt import GraspAttempt
from spiral_gripper_ros.control.grip_control import GripControl
from spiral_gripper_ros.control.limits import Limits
from spiral_gripper_ros.planning.planner import GripperPlanner

RADIUS = 0.02


def test_control_enters_few_files():
    """From a radius to its pressure, and for a goal, beside the mechanics that plan it."""
    gripper = load_gripper("paper_design_70")
    planner = GripperPlanner(gripper)
    planner.warm_up()
    control = GripControl(Limits(pressure_cap=gripper.pressure_max))
    control.activate()
    now, radius = 0.0, RADIUS

    def hear_radius():
        nonlocal now, radius
        now, radius = now + 0.02, radius + 1.0e-3
        assert control.offer_radius(now, radius, planner)
        assert control.command(now) >= 0.0

    def grasp():
        nonlocal now
        now += 0.02
        assert isinstance(control.start_grasp(now, GraspGoal(RADIUS), planner), GraspAttempt)
        control.command(now)

    assert 3 <= len(files_entered(hear_radius, "spiral_gripper_ros")) <= 10
    assert 3 <= len(files_entered(grasp, "spiral_gripper_ros")) <= 11
