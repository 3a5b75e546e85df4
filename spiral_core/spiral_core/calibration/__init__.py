"""The calibration: from bench readings to constants, with their uncertainty."""
