"""Bench measurements: CSV files with units to a calibrated gripper file."""
