# SPDX-License-Identifier: Apache-2.0
"""``spiral_gripper_demo``: the node fed with a recorded stream of radii."""
