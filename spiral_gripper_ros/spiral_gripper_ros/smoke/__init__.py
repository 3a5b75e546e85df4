"""One full grasp and release for ``spiral-gripper smoke``."""
