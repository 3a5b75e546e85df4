"""spiral_gripper_ros."""
