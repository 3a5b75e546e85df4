"""The rod: certified static shapes under load. Knows no actuator."""
