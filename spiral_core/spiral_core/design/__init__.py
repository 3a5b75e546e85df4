"""The design: from objects and limits to tube, angles, length and pressures."""
