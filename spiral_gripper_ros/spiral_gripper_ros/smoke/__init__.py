# SPDX-License-Identifier: Apache-2.0
"""One full grasp and release for ``spiral-gripper smoke``."""
