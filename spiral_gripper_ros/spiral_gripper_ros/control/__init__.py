# SPDX-License-Identifier: Apache-2.0
"""What is commanded and why: the control logic, without ROS."""
