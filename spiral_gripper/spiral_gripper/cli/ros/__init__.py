# SPDX-License-Identifier: Apache-2.0
"""Commands that need ROS 2: a running node, the simulation."""
