"""Checks of the ROS 2 installation for ``spiral-gripper doctor``."""
