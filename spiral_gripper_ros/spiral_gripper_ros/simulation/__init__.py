# SPDX-License-Identifier: Apache-2.0
"""A simulated regulator, gripper and source of radii: the node without hardware."""
