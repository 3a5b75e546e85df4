# SPDX-License-Identifier: Apache-2.0
"""Grasp goals as ROS 2 actions: our own, and those of control_msgs."""
