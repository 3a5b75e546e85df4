# SPDX-License-Identifier: Apache-2.0
"""spiral_gripper_ros."""
