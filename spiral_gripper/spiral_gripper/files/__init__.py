"""Gripper and tubing files: YAML with units to values of the core."""
