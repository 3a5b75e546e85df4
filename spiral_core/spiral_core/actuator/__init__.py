"""The actuator: from pressure to stretch, twist, curvature and torsion."""
