# SPDX-License-Identifier: Apache-2.0
"""Many grips at once: designs x objects x friction x mounts, on any executor, resumable."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor, as_completed
from dataclasses import dataclass, replace
from itertools import product

from spiral_core.brief import brief_repr
from spiral_core.errors import NoCoilError, NotGrippableError, SolverError
from spiral_core.grip.grip import Grip, solve_grip
from spiral_core.grip.holding import Pull
from spiral_core.grip.setup import Closing, friction_of, lay_into_coil
from spiral_core.grip.window import Progress
from spiral_core.rod.types import Vector
from spiral_core.wrap.gripper import Gripper


@dataclass(frozen=True, slots=True)
class GripCase:
    """One grip of a study.

    Args:
        gripper: as it is mounted.
        radius: of the cylinder [m].
        friction: Coulomb's coefficient.
        closing: how it closes.
    """

    __repr__ = brief_repr

    gripper: Gripper
    radius: float
    friction: float
    closing: Closing = Closing.SLOW


@dataclass(frozen=True, slots=True)
class GripOutcome:
    """The result of one grip of a study, as plain numbers.

    Args:
        refusal: why it is not held; empty if it is.
        tip_criterion: pressure of the perfect wrap by the free coil's tip [Pa].
        onset_wrap, onset_curling, loss: the window [Pa]; None where there is none.
        pressure: recommended [Pa], at which the other figures are.
        contact_length: [m].
        normal_force: sum [N].
        away, towards: holding forces [N]; None where not even the first step could be followed.
        away_is_lower_bound, towards_is_lower_bound: whether the force was still rising where the
            pull ended.
    """

    refusal: str
    tip_criterion: float | None = None
    onset_wrap: float | None = None
    onset_curling: float | None = None
    loss: float | None = None
    pressure: float | None = None
    contact_length: float | None = None
    normal_force: float | None = None
    away: float | None = None
    towards: float | None = None
    away_is_lower_bound: bool = False
    towards_is_lower_bound: bool = False


def grip_cases(
    grippers: Iterable[Gripper],
    radii: Sequence[float],
    frictions: Sequence[float] | None = None,
    gravities: Sequence[Vector] | None = None,
    closing: Closing = Closing.SLOW,
) -> tuple[GripCase, ...]:
    """Return every combination of designs, objects, friction and mounts.

    Args:
        grippers: designs, as they are mounted.
        radii: of the objects [m].
        frictions: Coulomb's coefficients; None takes each gripper's own or the default.
        gravities: accelerations in the base frame [m/s^2], a mount each; None keeps the grippers'.
        closing: how they close.
    """
    mounts: Sequence[Vector | None] = [None] if gravities is None else list(gravities)
    return tuple(
        GripCase(
            gripper if gravity is None else replace(gripper, gravity=gravity),
            radius,
            friction,
            closing,
        )
        for gripper in grippers
        for radius, friction, gravity in product(
            radii, (friction_of(gripper, None),) if frictions is None else frictions, mounts
        )
    )


def solve_case(case: GripCase) -> GripOutcome:
    """Return one grip of a study; plain values in and out, so that it runs anywhere.

    Forces are those at the recommended pressure.
    """
    try:
        setup = lay_into_coil(
            case.gripper, case.radius, friction=case.friction, closing=case.closing
        )
        window = solve_grip(setup, (), pressures=()).window
        middle = Grip(window, (), {}).recommended_pressure()
        grip = solve_grip(setup, pressures=[middle], window=window)
    except (NotGrippableError, NoCoilError, SolverError) as error:
        return GripOutcome(str(error))
    point = grip.points[0]
    (away,), (towards,) = grip.forces[Pull.AWAY], grip.forces[Pull.TOWARDS]
    return GripOutcome(
        refusal="",
        tip_criterion=setup.tip_pressure,
        onset_wrap=window.onset_wrap,
        onset_curling=window.onset_curling,
        loss=window.loss,
        pressure=middle,
        contact_length=point.contact_length,
        normal_force=point.normal_force,
        away=_known(away.force),
        towards=_known(towards.force),
        away_is_lower_bound=away.is_lower_bound,
        towards_is_lower_bound=towards.is_lower_bound,
    )


def _known(force: float) -> float | None:
    return None if math.isnan(force) else force


def solve_cases(
    cases: Sequence[GripCase],
    executor: Executor | None = None,
    progress: Progress | None = None,
    *,
    known: Mapping[int, GripOutcome] | None = None,
    keep: Callable[[int, GripOutcome], None] | None = None,
) -> tuple[GripOutcome, ...]:
    """Return every grip of a study, in the order of its cases.

    Args:
        cases: what to solve.
        executor: where; None solves one after the other, here.
        progress: called with the number done and the number there are, after each.
        known: outcomes of an interrupted study by their case's number; they are not solved again.
        keep: called with each new outcome and its case's number as soon as it is known, so that an
            interruption costs only what is under way.
    """
    done = dict(known or {})
    open_cases = [number for number in range(len(cases)) if number not in done]

    def finish(number: int, outcome: GripOutcome) -> None:
        done[number] = outcome
        if keep is not None:
            keep(number, outcome)
        if progress is not None:
            progress(len(done), len(cases))

    if executor is None:
        for number in open_cases:
            finish(number, solve_case(cases[number]))
        return tuple(done[number] for number in range(len(cases)))
    jobs = {executor.submit(solve_case, cases[number]): number for number in open_cases}
    try:
        for job in as_completed(jobs):
            finish(jobs[job], job.result())
    except BaseException:
        for job in jobs:
            job.cancel()
        raise
    return tuple(done[number] for number in range(len(cases)))
