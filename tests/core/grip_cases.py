# SPDX-License-Identifier: Apache-2.0
"""Grips for tests, known by heart."""

from math import inf

import numpy as np
from core.gripper_cases import paper_gripper

from spiral_core import NotGrippableError
from spiral_core.grip import tabulate
from spiral_core.grip.curve import GripCurve, GripShapes
from spiral_core.grip.table import GripTable

DOWN = (9.80665, 0.0, 0.0)


def figures(tip=5.0e4, curling=6.0e4, loss=8.0e4, force=1.0):
    """A grip whose forces rise evenly from the onset on."""
    path = np.array([0.0, 0.5, 1.0, 1.5]) * tip
    return GripCurve(
        tip_pressure=tip,
        onset_wrap=0.98 * tip,
        onset_curling=curling or inf,
        loss=loss or inf,
        highest_good=curling or 1.5 * tip,
        top=1.5 * tip,
        friction=0.3,
        pressures=path,
        contact_lengths=np.array([0.0, 0.0, 0.1, 0.2]),
        normal_forces=np.array([0.0, 0.0, 1.0, 2.0]) * force,
        force_pressures=np.array([0.95, 1.05, 1.5]) * tip,
        away=np.array([0.0, 1.0, 5.5]) * force,
        towards=np.array([0.0, 0.1, 0.55]) * force,
        down=np.array([0.0, 0.5, 2.75]) * force,
        settling=np.array([0.05, 0.1, 0.1]),
        shapes=GripShapes(
            positions=np.zeros((4, 3, 3)) + path[:, None, None],
            orientations=np.tile([0.0, 0.0, 0.0, 1.0], (4, 3, 1)),
            center=(0.1, 0.0, 0.0),
            axis=(0.0, 0.0, 1.0),
        ),
    )


def table_of(radii, grips, error=0.0, gravity=DOWN):
    """A table of grips, interpolated between them with one error."""
    errors = (error,) * (len(radii) - 1)
    return GripTable(tuple(radii), tuple(grips), errors, gravity, rate=1.5e4)


def solved_table(monkeypatch, force, count=3, executor=None):
    """A table of grips whose force is a function of the radius, and that are known at once."""

    def solve(question):
        scale = force(question.radius)
        if scale is None:
            raise NotGrippableError(question.radius, "the tube passes by", 0.0, None)
        return figures(force=scale)

    monkeypatch.setattr(tabulate, "solve_curve", solve)
    return tabulate.solve_table(paper_gripper("70 degrees"), count, 1.5e4, executor)
