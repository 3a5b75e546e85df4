# SPDX-License-Identifier: Apache-2.0
"""What ties the gripper to a robot: estimates with their time, frames, the state of its joint."""
