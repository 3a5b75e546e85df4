"""``spiral_gripper_demo``: the node fed with a recorded stream of radii."""
