# SPDX-License-Identifier: Apache-2.0
"""The control logic: the pressure to command, and the reason. No ROS."""
