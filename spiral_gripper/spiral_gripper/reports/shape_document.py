# SPDX-License-Identifier: Apache-2.0
"""A solved shape as rows for people and as plain data for programs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from spiral_core.actuator.actuator import UnloadedShape
from spiral_core.rod.solve import solve_rod
from spiral_core.rod.types import RodState
from spiral_core.wrap.gripper import Gripper
from spiral_gripper.files.shown import shown
from spiral_gripper.reports.design_document import plain


@dataclass(frozen=True, slots=True)
class SolvedShape:
    """A gripper at one pressure, coiled or not.

    Args:
        gripper: as it is mounted.
        pressure: gauge pressure [Pa].
        unloaded_shape: what it would be unloaded.
        state: its certified shape.
    """

    gripper: Gripper
    pressure: float
    unloaded_shape: UnloadedShape
    state: RodState


def solve_shape(gripper: Gripper, pressure: float) -> SolvedShape:
    """Return the shape of a gripper at a pressure [Pa].

    Raises:
        InvalidInputError: the pressure is not in [0, the gripper's ``pressure_max``].
        SolverError: the shape could not be certified.
    """
    rest = gripper.unloaded_shape(pressure)
    state = solve_rod(gripper.rod(rest), gripper.load(rest))
    return SolvedShape(gripper, pressure, rest, state)


def shape_rows(shape: SolvedShape) -> list[tuple[str, str]]:
    """Return the figures of a shape as names and texts."""
    state, rest = shape.state, shape.unloaded_shape
    error = state.discretization_error
    tip = ", ".join(shown(float(x), "m") for x in state.tip_position)
    return [
        ("tip (x, y, z)", tip),
        ("curvature, torsion unloaded", f"{rest.curvature:.4g}, {rest.torsion:.4g} /m"),
        ("stretch", "" if rest.stretch is None else f"{rest.stretch:.5g}"),
        ("length", shown(rest.backbone_length, "m")),
        ("stable", "yes, certified" if state.stable else "no"),
        ("discretization error", "" if error is None else shown(error, "m")),
        ("folds passed on the way", str(state.folds)),
    ]


def shape_as_dict(shape: SolvedShape) -> dict[str, Any]:
    """Return a shape for programs, in SI, base frame, quaternions (x, y, z, w)."""
    state = shape.state
    return {
        "gripper": shape.gripper.name,
        "pressure": shape.pressure,
        "gravity": list(shape.gripper.gravity),
        **plain(shape.unloaded_shape),
        "status": plain(state.status),
        "stable": state.stable,
        "folds": state.folds,
        "discretization_error": plain(state.discretization_error),
        "arc_lengths": plain(state.arc_lengths),
        "positions": plain(state.positions),
        "orientations": plain(state.orientations),
    }
