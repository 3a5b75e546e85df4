# SPDX-License-Identifier: Apache-2.0
"""How far an object can be pulled, pushed or turned before it slips out of the coil."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from spiral_core.errors import InvalidInputError
from spiral_core.grip.point import GripPoint
from spiral_core.rod.contact.obstacles import Obstacle
from spiral_core.rod.contact.solve import follow_contact
from spiral_core.rod.contact.state import ContactState, ContactStatus
from spiral_core.rod.types import Array

# The object is moved in steps of this fraction of its own radius, or turned by this angle [rad].
STEP = 0.1
TURN_STEP = 0.1
# It slips where the force has not risen by this fraction of its rise for so many steps; a pull ends
# after so many steps.
RISE = 0.01
STEADY_STEPS = 6
MOST_STEPS = 60
# Along gravity a straight way off the object's axis pulls the tube taut in the end, with many times
# the force at which the object slides: only the first diameter of the object counts.
MOST_STEPS_DOWN = 20
# Below this share of gravity along the object nothing slides along it that would not fall across.
LEAST_SHARE = 1e-3
# A force or torque below this [N, N m] is rounding error.
ROUNDING = 1e-12


class Pull(Enum):
    """Where an object is moved to; the value says it in words."""

    AWAY = "along the object, away from the base"
    TOWARDS = "along the object, towards the base"
    TWIST_LEFT = "about the object, left-handed"
    TWIST_RIGHT = "about the object, right-handed"
    SIDEWAYS = "across the object, away from the base"
    DOWN = "along gravity"


class PullEnd(Enum):
    """Why a pull ended."""

    SLIPPED = "the object slides: the force rises no more"
    LOST = "the coil gives way at once"
    SELF_CONTACT = (
        "turns of the tube touch each other, which the model does not resist; the force is what "
        "was reached"
    )
    STEP_LIMIT = "the peak was not passed within the steps tried; the force is a lower bound"


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class HoldingForce:
    """What it takes to move an object out of the coil at a fixed pressure.

    Args:
        pull: where it was moved to.
        force: the peak [N]; of a twist the torque [N m].
        displacement: of the object at the peak [m]; of a twist the angle [rad].
        stiffness: force per displacement at the first step [N/m]; of a twist [N m/rad].
        displacements, forces: (n,) the whole curve, from zero.
        end: why the pull ended.
    """

    pull: Pull
    force: float
    displacement: float
    stiffness: float
    displacements: Array
    forces: Array
    end: PullEnd

    @property
    def is_lower_bound(self) -> bool:
        """Whether the force was still rising where the pull ended."""
        return self.end in (PullEnd.STEP_LIMIT, PullEnd.SELF_CONTACT)

    def __repr__(self) -> str:
        if is_twist(self.pull):
            value = f"{1e3 * self.force:.3g} N mm at {np.degrees(self.displacement):.3g} deg"
        else:
            value = f"{self.force:.3g} N at {1e3 * self.displacement:.3g} mm"
        return f"HoldingForce({self.pull.value}: {value}; {self.end.value})"


def is_twist(pull: Pull) -> bool:
    """Return whether a pull turns the object."""
    return pull in (Pull.TWIST_LEFT, Pull.TWIST_RIGHT)


def holding_force(point: GripPoint, pull: Pull = Pull.AWAY) -> HoldingForce:
    """Return what holds an object against being moved one way, with friction.

    The object is moved in small steps at fixed pressure without turning, or turned about its own
    axis; the tube follows in frictional equilibrium. The peak of the force is what holds. It is not
    one number for all directions: pulled away from the base a coil tightens like a finger trap,
    pushed towards it, it opens. Along gravity the object is moved straight, which keeps it from
    sliding along its own axis: no weight counts whose share along the axis is more than holds it
    there.

    Args:
        point: the grip at its pressure.
        pull: where the object is moved to.

    Raises:
        InvalidInputError: ``Pull.DOWN`` without gravity.
    """
    held = _pulled(point, pull)
    return held if pull is not Pull.DOWN else _limited_by_sliding(point, held)


def _limited_by_sliding(point: GripPoint, held: HoldingForce) -> HoldingForce:
    """Return what holds along gravity, at most the weight that would slide along the object."""
    along = float(pull_direction(point, Pull.DOWN) @ pull_direction(point, Pull.AWAY))
    if abs(along) < LEAST_SHARE:
        return held
    axial = _pulled(point, Pull.AWAY if along > 0.0 else Pull.TOWARDS)
    if axial.force >= abs(along) * held.force:
        return held
    return replace(axial, pull=Pull.DOWN, force=axial.force / abs(along))


def _pulled(point: GripPoint, pull: Pull) -> HoldingForce:
    """Return the result of one pull."""
    setup = point.setup
    direction = pull_direction(point, pull)
    turning = is_twist(pull)
    step = TURN_STEP if turning else STEP * float(setup.obstacle.shape.feature_radius)
    # Friction comes on, if it was not there while closing, before anything moves.
    state, end = _moved(point, point.state, setup.obstacle)
    forces = [] if state is None else [_resistance(state, direction, turning)]
    while state is not None:
        count = len(forces)
        if count > (MOST_STEPS_DOWN if pull is Pull.DOWN else MOST_STEPS):
            end = PullEnd.STEP_LIMIT
            break
        way = tuple((count * step * direction).tolist())
        moved = setup.obstacle.moved(**{"rotation" if turning else "translation": way})
        state, end = _moved(point, state, moved)
        if state is None:
            break
        forces.append(_resistance(state, direction, turning))
        if _slips(forces):
            end = PullEnd.SLIPPED
            break
    return _curve(pull, step, forces or [0.0], end)


def pull_direction(point: GripPoint, pull: Pull) -> Array:
    """Return the unit vector (3,) along which, or about which, a pull moves the object.

    Raises:
        InvalidInputError: ``Pull.DOWN`` without gravity.
    """
    setup = point.setup
    axis = setup.axis
    if pull is Pull.DOWN:
        gravity = np.asarray(setup.gripper.gravity)
        norm = float(np.linalg.norm(gravity))
        if not norm > 0.0:
            raise InvalidInputError("pull", pull.value, "another one: there is no gravity")
        return gravity / norm
    positions = point.state.positions
    if (positions[-1] - positions[0]) @ axis < 0.0:
        axis = -axis  # away from the base is where the coil advances to
    if pull is Pull.SIDEWAYS:
        across = np.asarray(setup.obstacle.position)
        across = across - (across @ axis) * axis
        norm = float(np.linalg.norm(across))
        return across / norm if norm > 0.0 else np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    return axis if pull in (Pull.AWAY, Pull.TWIST_RIGHT) else -axis


def _moved(
    point: GripPoint, state: ContactState, obstacle: Obstacle
) -> tuple[ContactState | None, PullEnd]:
    """Return the state after the object has moved on, or None and why there is none."""
    problem = point.setup.problem(point.pressure, obstacle)
    path = follow_contact([problem], start=state, stop_at_event=True)
    if not path.states:
        return None, PullEnd.LOST
    if path.states[-1].status is ContactStatus.SELF_CONTACT:
        return None, PullEnd.SELF_CONTACT
    return path.states[-1], PullEnd.STEP_LIMIT


def _slips(forces: list[float]) -> bool:
    """Return whether the force has stopped rising."""
    earlier = forces[:-STEADY_STEPS]
    if not earlier:
        return False
    return max(forces) - max(earlier) <= RISE * (max(forces) - min(forces))


def _resistance(state: ContactState, direction: Array, turning: bool) -> float:
    """Return the force [N] or torque [N m] that it takes to hold the object where it is."""
    resultant = state.on_obstacle()
    return -float((resultant.torque if turning else resultant.force) @ direction)


def _curve(pull: Pull, step: float, forces: list[float], end: PullEnd) -> HoldingForce:
    """Return the result of a pull from its force at each step."""
    values = np.array(forces)
    peak = int(np.argmax(values))
    held = float(values[peak])
    if held < ROUNDING:  # no friction, or a coil that itself pushes this way: it holds nothing
        held = 0.0
    displacements: Array = step * np.arange(len(values), dtype=np.float64)
    stiffness = float(values[1] - values[0]) / step if len(values) > 1 else 0.0
    return HoldingForce(
        pull, held, float(displacements[peak]), stiffness, displacements, values, end
    )
