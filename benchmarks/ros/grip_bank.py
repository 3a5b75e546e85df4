# SPDX-License-Identifier: Apache-2.0
"""Grips for a node whose time runs faster than grips are solved: solved once, then scaled."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import replace
from random import Random
from typing import Any

import numpy as np

from spiral_core.errors import NotGrippableError, SpiralError
from spiral_core.grip.curve import GripCurve, GripQuestion
from spiral_core.grip.tabulate import solve_curve
from spiral_core.wrap.curve import WrapCurve
from spiral_core.wrap.gripper import Gripper

# Share of the questions that are answered with a refusal.
REFUSED = 0.1


class GripBank:
    """Answers questions at once, in place of the process that solves grips.

    The nearest radius that was solved stands for the one in question, its pressures scaled by what
    the wraps need by the criterion at the tip.

    Args:
        gripper: whose grips are solved, in a minute or so.
        count: of the radii that are solved.
        random: decides which questions are refused.
    """

    def __init__(self, gripper: Gripper, count: int, random: Random) -> None:
        curve = WrapCurve(gripper)
        radii = np.geomspace(1.03 * curve.radius_min, 0.97 * curve.radius_max, count).tolist()
        self._solved = {radius: solve_curve(GripQuestion(gripper, radius)) for radius in radii}
        self._random = random
        self.answered = self.refused = 0

    def submit(
        self, solve: Callable[..., Any], question: GripQuestion, is_wanted: Callable[[], bool]
    ) -> Future[GripCurve]:
        """Return the answer, as a pool would that has just computed it."""
        del solve, is_wanted
        answer: Future[GripCurve] = Future()
        try:
            answer.set_result(self._answer(question))
        except SpiralError as error:
            self.refused += 1
            answer.set_exception(error)
        return answer

    def _answer(self, question: GripQuestion) -> GripCurve:
        if self._random.random() < REFUSED:
            raise NotGrippableError(question.radius, "refused at random", 0.0, None)
        nearest = min(self._solved, key=lambda radius: abs(radius - question.radius))
        solved = self._solved[nearest]
        tip = WrapCurve(question.gripper).pressure_from_radius(question.radius)
        scale = tip / solved.tip_pressure
        self.answered += 1
        return replace(
            solved,
            tip_pressure=tip,
            onset_wrap=scale * solved.onset_wrap,
            onset_curling=scale * solved.onset_curling,
            loss=scale * solved.loss,
            highest_good=scale * solved.highest_good,
            top=scale * solved.top,
            pressures=scale * solved.pressures,
            force_pressures=scale * solved.force_pressures,
        )

    def shutdown(self, **options: Any) -> None:  # noqa: ANN401
        """Do what a pool does when its node ends: nothing is left to do."""
