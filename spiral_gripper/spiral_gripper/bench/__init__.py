# SPDX-License-Identifier: Apache-2.0
"""Bench measurements: CSV files with units to a calibrated gripper file."""
