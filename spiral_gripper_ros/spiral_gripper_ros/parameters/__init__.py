# SPDX-License-Identifier: Apache-2.0
"""The parameters of the nodes: tables, declaration in ROS, checks of those given at start."""
