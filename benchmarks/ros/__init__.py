# SPDX-License-Identifier: Apache-2.0
"""Benchmarks of the gripper's node: ``python -m benchmarks.ros``."""
