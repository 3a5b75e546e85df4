# SPDX-License-Identifier: Apache-2.0
"""Grips for tests, known by heart."""

import math

import numpy as np

from spiral_gripper_ros.planning.grip_figures import GripFigures
from spiral_gripper_ros.planning.grip_follower import GripFollower

DOWN = (9.80665, 0.0, 0.0)


def figures(tip=5.0e4, curling=6.0e4, loss=8.0e4, force=1.0):
    """A grip whose forces rise evenly from the onset on."""
    path = np.array([0.0, 0.5, 1.0, 1.5]) * tip
    return GripFigures(
        tip_pressure=tip,
        onset_wrap=0.98 * tip,
        onset_curling=curling or math.inf,
        loss=loss or math.inf,
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
        positions=np.zeros((4, 3, 3)) + path[:, None, None],
        orientations=np.tile([0.0, 0.0, 0.0, 1.0], (4, 3, 1)),
        center=(0.1, 0.0, 0.0),
        axis=(0.0, 0.0, 1.0),
    )


def unknown_grips(gripper, gravity):
    """Follow the grips of a gripper of which none is ever solved."""
    return GripFollower(gripper, gravity, None, None)
