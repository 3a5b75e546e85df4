# SPDX-License-Identifier: Apache-2.0
"""The wrap: a gripper as a rod that its actuator curls, and the pressure that wraps an object."""
