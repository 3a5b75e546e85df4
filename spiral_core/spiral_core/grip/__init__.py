# SPDX-License-Identifier: Apache-2.0
"""The grip: a gripper that closes on an object, its holding forces, and the loss of the grip."""
