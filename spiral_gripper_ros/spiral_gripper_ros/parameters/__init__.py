# SPDX-License-Identifier: Apache-2.0
"""The parameters of the nodes: their tables, how ROS declares them, what was given at start."""
