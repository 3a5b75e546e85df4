# SPDX-License-Identifier: Apache-2.0
"""Gripper and tubing files: YAML with units to values of the core."""
