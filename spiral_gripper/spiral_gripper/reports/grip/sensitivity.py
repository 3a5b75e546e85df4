# SPDX-License-Identifier: Apache-2.0
"""What the answers of ``wrap`` and ``grip`` depend on: every input changed, the question solved."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple, TypeAlias

from rich.markup import escape
from rich.table import Table

from spiral_core.errors import InvalidInputError, NoCoilError, NotGrippableError, SolverError
from spiral_core.grip.holding import Pull, holding_forces
from spiral_core.grip.setup import GripSetup, friction_of
from spiral_core.grip.window import FRICTION_TOLERANCE, grip_window, sharp_onset
from spiral_core.numerics.tasks import in_turn
from spiral_core.wrap.curve import WrapCurve
from spiral_core.wrap.profile import wrap_for_profile
from spiral_gripper.files.description import GripperDescription, vary_gripper
from spiral_gripper.files.fields import CONSTANTS
from spiral_gripper.files.shown import axis_label, scale_of, shown
from spiral_gripper.reports.fields import Json, Progress
from spiral_gripper.reports.grip.document import GripQuestion, closed_window, setup_of
from spiral_gripper.reports.wrap_document import read_profile

# Figure -> its value in SI; None where there is none, all of them where the object is not held.
Figures: TypeAlias = dict[str, float | None]
# A question, and the pressure of its forces [Pa].
Side: TypeAlias = tuple[GripQuestion, float]

# Figures are resolved to this fraction of themselves, if not better than their changes.
RESOLUTIONS: Mapping[str, float] = {"loss": FRICTION_TOLERANCE}
# Changes: of a length, but no more than a fraction of it; of an angle; of the rest a fraction.
LENGTH = 1e-3
THICKNESS = 1e-4
MOST_OF_IT = 0.2
ANGLE = math.radians(1.0)
FRACTION = 0.1
SMALL_FRACTION = 0.01
PRESSURE_FRACTION = 0.05

# Fields of a gripper's file: name in tables, change, and its unit or "%" of the value.
_FIELDS: Mapping[str, tuple[str, float, str]] = {
    "tube.wall_thickness": ("wall", THICKNESS, "m"),
    "tube.inner_radius": ("bore's radius", THICKNESS, "m"),
    "tube.length": ("tube's length", SMALL_FRACTION, "%"),
    "fibers.alpha": ("fiber angle alpha", ANGLE, "rad"),
    "fibers.beta": ("fiber angle beta", ANGLE, "rad"),
    "fibers.straight_fiber_radius": ("straight fiber's radius", THICKNESS, "m"),
    **{f"material.{name}": (name.replace("_", " "), FRACTION, "%") for name in CONSTANTS},
    "stiffness.bending": ("bending stiffness", FRACTION, "%"),
    "stiffness.torsional": ("torsional stiffness", FRACTION, "%"),
}


class Method(NamedTuple):
    """How a question is solved, and which of its figures ranks the inputs.

    Attributes:
        solve: returns the figures of a question, given the pressure of its forces [Pa].
        ranked: key of the figure.
        columns: name and unit of each figure; "%" shows a change as a fraction.
    """

    solve: Callable[[GripQuestion, float], Figures]
    ranked: str
    columns: Mapping[str, tuple[str, str]]


@dataclass(frozen=True, slots=True)
class Input:
    """One input of a question, and the question with less and with more of it.

    Args:
        name: for tables and programs.
        change: by how much it differs, in SI.
        unit: of the change; "%" of the value.
        less, more: None where there is no such gripper.
    """

    name: str
    change: float
    unit: str
    less: Side | None
    more: Side | None

    @property
    def label(self) -> str:
        """Name and change in words."""
        change = (
            f"{100.0 * self.change:.2g} %" if self.unit == "%" else shown(self.change, self.unit)
        )
        return f"{self.name} ±{change}"


@dataclass(frozen=True, slots=True)
class Sensitivity:
    """What one input changes.

    Args:
        input: the input.
        less, more: figures with less and with more of it.
    """

    input: Input
    less: Figures
    more: Figures

    def changes(self, base: Figures, key: str) -> tuple[float, float]:
        """Return by how much less and more of it change a figure.

        Infinite: there is none any more; NaN: it could not be computed.
        """
        at = base[key]
        less, more = (
            math.inf if at is None or there is None else there - at
            for there in (self.less.get(key), self.more.get(key))
        )
        return less, more

    def size(self, base: Figures, key: str) -> float:
        """Return the larger of both changes; infinite where the figure is lost."""
        return max(0.0 if math.isnan(c) else abs(c) for c in self.changes(base, key))


@dataclass(frozen=True, slots=True)
class Varied:
    """What the inputs of a question change.

    Args:
        method: how it was solved.
        base: figures of the question as it is.
        inputs: what each input changes, the largest change first.
    """

    method: Method
    base: Figures
    inputs: tuple[Sensitivity, ...]

    def table(self) -> Table:
        """Return the changes by less and by more of every input, for people."""
        keys = [key for key in self.method.columns if self.base.get(key)]
        table = Table(title="by so much less / more", title_justify="left")
        table.add_column("input")
        for name, unit in (self.method.columns[key] for key in keys):
            label = f"{name} [%]" if unit == "%" else axis_label(name, unit)
            table.add_column(escape(label), justify="right")
        for each in self.inputs:
            cells = (
                " / ".join(self._text(c, key) for c in each.changes(self.base, key)) for key in keys
            )
            table.add_row(each.input.label, *cells)
        return table

    def _text(self, change: float, key: str) -> str:
        """Return a change as text; 0 where it is within what the figure is resolved to."""
        if not math.isfinite(change):
            return "?" if math.isnan(change) else "none"
        unit, at = self.method.columns[key][1], self.base[key] or 1.0
        scale = 100.0 / at if unit == "%" else scale_of(unit).factor
        return f"{scale * change:+.2g}" if abs(change) > RESOLUTIONS.get(key, 0.0) * at else "0"

    def as_dict(self) -> Json:
        """Return the figures for programs, in SI."""
        return {
            "sensitivity_at": self.base,
            "sensitivity": [
                {
                    "input": each.input.name,
                    "change": each.input.change,
                    "unit": "of its value" if each.input.unit == "%" else each.input.unit,
                    "less": each.less,
                    "more": each.more,
                }
                for each in self.inputs
            ],
        }


def tip_figures(question: GripQuestion, _: float) -> Figures:
    """Return the pressure of the tip criterion."""
    curve = WrapCurve(question.gripper)
    if question.profile is None:
        return {"pressure": curve.pressure_from_radius(float(question.radius or 0.0))}
    return {"pressure": wrap_for_profile(curve, read_profile(question.profile)).pressure}


def wrap_figures(question: GripQuestion, _: float) -> Figures:
    """Return the pressure from which on the object is wrapped."""
    window = grip_window(setup_of(question)[0], until_wrapped=True)
    return {"onset_wrap": sharp_onset(window)}


def grip_figures(question: GripQuestion, pressure: float) -> Figures:
    """Return the ends of the window, and the forces at a pressure [Pa]."""
    window, _ = closed_window(question)
    held: Figures = {"holding_force_away": None, "holding_force_towards": None}
    with suppress(InvalidInputError, SolverError):  # lost below that pressure
        forces = holding_forces(window.at(pressure), (Pull.AWAY, Pull.TOWARDS))
        held = {f"holding_force_{pull.name.lower()}": f.force for pull, f in forces.items()}
    return {"onset_wrap": sharp_onset(window), "loss": window.loss, **held}


GRIP = Method(
    grip_figures,
    "holding_force_away",
    {
        "holding_force_away": ("holds away", "%"),
        "holding_force_towards": ("towards", "%"),
        "onset_wrap": ("wrapped from", "Pa"),
        "loss": ("lost at", "Pa"),
    },
)
METHODS: Mapping[str, Method] = {
    "tip": Method(tip_figures, "pressure", {"pressure": ("tip criterion", "Pa")}),
    "wrap": Method(wrap_figures, "onset_wrap", {"onset_wrap": ("wrapped from", "Pa")}),
    "grip": GRIP,
}


def inputs_of(
    method: Method,
    question: GripQuestion,
    description: GripperDescription,
    setup: GripSetup | None,
    pressure: float,
) -> Iterator[Input]:
    """Yield the inputs of a question that its answer depends on.

    Args:
        method: how it is solved.
        question: with the gripper as it is mounted.
        description: of that gripper.
        setup: of the question; None where there is no contact.
        pressure: of the forces [Pa].
    """
    question = replace(question, pressures=(), payload=None, force_max=None, spread=False)

    def both(
        name: str, change: float, unit: str, at: float, vary: Callable[[float], GripQuestion]
    ) -> Input:
        if unit == "m" and at > 0.0:
            change = min(change, MOST_OF_IT * at)
        step = change * at if unit == "%" else change
        sides: list[Side | None] = [None, None]
        for side, value in enumerate((at - step, at + step)):
            with suppress(InvalidInputError):  # there is no such gripper
                sides[side] = vary(value), pressure
        return Input(name, change, unit, *sides)

    gripper, radius = question.gripper, question.radius
    if radius is not None:
        yield both("object's radius", LENGTH, "m", radius, lambda v: replace(question, radius=v))
    for field, (name, change, unit) in _FIELDS.items():
        value = description.values.get(field)
        if isinstance(value, float):

            def vary(value: float, field: str = field) -> GripQuestion:
                varied = vary_gripper(description, field, value)
                mounted = varied.with_mount(gripper.gravity, gripper.object_axis)
                return replace(question, gripper=mounted)

            yield both(name, change, unit, value, vary)
    if any(gripper.gravity):

        def pulled(factor: float) -> GripQuestion:
            x, y, z = (factor * component for component in gripper.gravity)
            return replace(question, gripper=gripper.with_mount((x, y, z), gripper.object_axis))

        yield both("gravity or mass", FRACTION, "%", 1.0, pulled)
    if setup is None:
        return
    friction = friction_of(gripper, question.friction)
    if friction > 0.0:
        yield both("friction", FRACTION, "%", friction, lambda v: replace(question, friction=v))
    x, y, z = setup.frame[1].tolist()

    def moved(shift: float) -> GripQuestion:
        a, b, c = setup.obstacle.position
        return replace(question, place=(a + shift * x, b + shift * y, c + shift * z))

    yield both("object's distance", LENGTH, "m", 0.0, moved)
    limit = gripper.pressure_max
    if method is GRIP and 0.0 < pressure < limit:
        change = min(PRESSURE_FRACTION, limit / pressure - 1.0)
        less, more = (1.0 - change) * pressure, min((1.0 + change) * pressure, limit)
        yield Input("pressure", change, "%", (question, less), (question, more))


def solve_sensitivity(
    method: Method,
    question: GripQuestion,
    description: GripperDescription,
    setup: GripSetup | None,
    pressure: float,
    executor: Executor | None,
    progress: Progress,
) -> Varied:
    """Return the figures of a question, and what every input changes, the largest change first.

    Each input is changed to both sides and the question solved again, as its command would: the end
    of a window and the force at which an object slips depend on the whole path with friction, and
    no formula gives their derivative. The object is laid into the coil anew, unless its place is
    given.

    Args:
        method: how to solve it.
        question: with the gripper as it is mounted.
        description: of that gripper.
        setup: of the question; None where there is no contact.
        pressure: of the forces [Pa].
        executor: solves the questions; None: one after the other, here.
        progress: called with the number solved and the number there are.
    """
    inputs = tuple(inputs_of(method, question, description, setup, pressure))
    asked = [(question, pressure), *(side for each in inputs for side in (each.less, each.more))]
    found = list(in_turn(partial(_figures, method.solve), asked, executor, progress))
    base = found[0]
    changed = [Sensitivity(each, *found[1 + 2 * k : 3 + 2 * k]) for k, each in enumerate(inputs)]
    changed.sort(key=lambda each: each.size(base, method.ranked), reverse=True)
    return Varied(method, base, tuple(changed))


def _figures(solve: Callable[[GripQuestion, float], Figures], side: Side | None) -> Figures:
    """Return the figures of a question; none where there is none, or the object is not held."""
    try:
        return solve(*side) if side else {}
    except (InvalidInputError, NotGrippableError, NoCoilError, SolverError):
        return {}
