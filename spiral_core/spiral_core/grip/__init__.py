# SPDX-License-Identifier: Apache-2.0
"""The grip: a gripper that closes on an object, what it holds and when it lets go."""
