# SPDX-License-Identifier: Apache-2.0
"""Curves of the wraps of made-up and of the paper's grippers, each solved once."""

from functools import cache
from math import sqrt

from core.gripper_cases import linear_gripper, paper_gripper

from spiral_core import WrapCurve

G = 9.80665
TILTED = (G / sqrt(1.25), 0.5 * G / sqrt(1.25), 0.0)
OUTER_RADIUS = 4.7625e-3 + 0.79375e-3


@cache
def paper_curve(name="P2", gravity=(G, 0.0, 0.0), axis=None):
    return WrapCurve(paper_gripper(name, gravity, axis))


@cache
def linear_curve(**options):
    return WrapCurve(linear_gripper(**options))
