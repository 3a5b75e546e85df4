"""The adapter from ``pressure_command`` to the pressure regulators that labs have."""
