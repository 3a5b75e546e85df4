"""Benchmarks of the gripper's node: ``python -m benchmarks.ros``."""
