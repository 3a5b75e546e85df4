# SPDX-License-Identifier: Apache-2.0
"""The tube without pressure, beside the object: where every closing begins."""

from __future__ import annotations

from dataclasses import replace

from spiral_core.errors import NotGrippableError, SolverError
from spiral_core.grip.setup import GripSetup
from spiral_core.rod.contact._contact import distances
from spiral_core.rod.contact.solve import solve_contact
from spiral_core.rod.state import RodState, RodStatus

# An object that overlaps the freely hanging tube by up to this fraction of the tube's radius
# pushes it aside; one that overlaps more lies in its way.
PUSHED_ASIDE = 0.1


def hanging_tube(setup: GripSetup) -> RodState:
    """Return the tube without pressure, beside the object.

    Where the straight tube would run through the object but the hanging one does not, it hangs
    freely before the object is put beside it.

    Raises:
        NotGrippableError: the object lies in its way.
        SolverError: it has no certified shape.
    """
    problem, count = setup.closing_problem(0.0), setup.element_count
    state = solve_contact(problem, elements=count, throw=False)
    if state.status is RodStatus.INSIDE_OBSTACLE:
        free = solve_contact(replace(problem, obstacles=()), elements=count)
        radius = problem.rod.radius
        gap = float(distances(setup.obstacle, free.positions[1:], radius)[0].min())
        if not gap > -PUSHED_ASIDE * radius:
            raise _in_the_way(setup, gap)
        state = solve_contact(problem, start=free.positions, elements=count, throw=False)
    if state.status is not RodStatus.CONVERGED:
        raise SolverError(state.status, state.residual, state.iterations)
    return state


def _in_the_way(setup: GripSetup, gap: float) -> NotGrippableError:
    """Return the refusal of an object that the hanging tube would run through."""
    reason = (
        "the tube without pressure runs through where the object lies; move the object, or lay it "
        "along the tube (object_axis)"
    )
    return NotGrippableError(float(setup.obstacle.shape.feature_radius), reason, gap, None)
