# SPDX-License-Identifier: Apache-2.0
"""The actuator: from pressure to stretch, twist, curvature and torsion."""
