# SPDX-License-Identifier: Apache-2.0
"""Grips and solvers of grips for tests, known by heart."""

from concurrent.futures import Future

import numpy as np

from spiral_gripper_ros.planning.grip_figures import GripFigures
from spiral_gripper_ros.planning.grip_follower import GripFollower

DOWN = (9.80665, 0.0, 0.0)
RANGE = (0.005, 0.04)


def figures(tip=5.0e4, curling=6.0e4, loss=8.0e4, force=1.0):
    """A grip whose forces rise evenly from the onset on."""
    path = np.array([0.0, 0.5, 1.0, 1.5]) * tip
    held = np.array([0.95, 1.05, 1.5]) * tip
    nodes = np.zeros((4, 3, 3)) + path[:, None, None]
    return GripFigures(
        tip_pressure=tip,
        onset_wrap=0.98 * tip,
        onset_curling=curling,
        loss=loss,
        highest_good=curling,
        top=1.5 * tip,
        friction=0.3,
        pressures=path,
        contact_lengths=np.array([0.0, 0.0, 0.1, 0.2]),
        normal_forces=np.array([0.0, 0.0, 1.0, 2.0]) * force,
        force_pressures=held,
        away=np.array([0.0, 1.0, 5.5]) * force,
        towards=np.array([0.0, 0.1, 0.55]) * force,
        down=np.array([0.0, 0.5, 2.75]) * force,
        settling=np.array([0.05, 0.1, 0.1]),
        positions=nodes,
        orientations=np.tile([0.0, 0.0, 0.0, 1.0], (4, 3, 1)),
        center=(0.1, 0.0, 0.0),
        axis=(0.0, 0.0, 1.0),
    )


class Pool:
    """Holds the questions until they are answered here."""

    def __init__(self):
        self.asked = []

    def submit(self, solve, question, is_wanted):
        self.is_wanted = is_wanted
        self.asked.append((question, Future()))
        return self.asked[-1][1]

    def answer(self, outcome):
        future = self.asked[-1][1]
        if isinstance(outcome, Exception):
            future.set_exception(outcome)
        else:
            future.set_result(outcome)


class Bench:
    def __init__(self, gripper, count=3):
        self.pool, self.now, self.count = Pool(), 100.0, count
        self.follower = GripFollower(gripper, DOWN, None, self.pool)

    def follow(self, in_use=None, gravity=DOWN, radii=RANGE, elapsed=0.1):
        self.now += elapsed
        return self.follower.follow(self.now, gravity, radii, self.count, in_use)

    def fill(self):
        """Answer until the table is done: its radii, and the middle of each two."""
        self.follow()
        for _ in range(2 * self.count - 1):
            self.pool.answer(figures())
            self.follow()


def unknown_grips(gripper, gravity):
    """Follow the grips of a gripper of which none is ever solved."""
    return GripFollower(gripper, gravity, None, None)
