"""A simulated regulator, gripper and source of radii: the node without hardware."""
