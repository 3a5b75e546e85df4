# SPDX-License-Identifier: Apache-2.0
"""The wrap: a gripper as a rod with the actuator's curvature; the pressure that wraps an object."""
