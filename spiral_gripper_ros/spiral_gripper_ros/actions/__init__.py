# SPDX-License-Identifier: Apache-2.0
"""Goals as ROS 2 actions: our own, and those of control_msgs."""
