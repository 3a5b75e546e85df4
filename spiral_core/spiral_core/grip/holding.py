# SPDX-License-Identifier: Apache-2.0
"""Holding forces: an object is pulled, pushed or turned until it slips out of the coil."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from spiral_core.errors import InvalidInputError
from spiral_core.grip.window import GripPoint
from spiral_core.rod.contact.solve import follow_contact
from spiral_core.rod.state import RodState, RodStatus
from spiral_core.rod.types import Array
from spiral_core.validation import require_non_negative

# The object is moved in steps of this fraction of its own radius, or turned by this angle [rad].
STEP = 0.1
TURN_STEP = 0.1
# It slips where the force has not risen by this fraction of its rise for so many steps; a pull ends
# after so many steps.
RISE = 0.01
STEADY_STEPS = 6
MOST_STEPS = 60
# Moved straight along gravity, not along its axis, the object pulls the tube taut in the end, with
# many times the force at which it slides: only the first diameter of the object counts.
MOST_STEPS_DOWN = 20
# Above this component of gravity along the object, 18 degrees, only sliding along its axis counts:
# moved straight it could not slide, and the coil of a thin object has not tightened in a diameter.
MOSTLY_ALONG = 0.95
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
    LOST = "the coil snaps and gives way"
    SELF_CONTACT = "turns of the tube touch each other, which the model does not resist"
    NOT_FOLLOWED = "the tube finds no rest that could be certified"
    STEP_LIMIT = "the peak was not passed within the steps tried"
    ENOUGH = "it holds as much as was asked for"


# Ends that say nothing of what the object would still have taken.
OPEN_ENDS = (PullEnd.SELF_CONTACT, PullEnd.NOT_FOLLOWED, PullEnd.STEP_LIMIT, PullEnd.ENOUGH)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class HoldingForce:
    """What it takes to move an object out of the coil at a fixed pressure.

    Args:
        pull: where it was moved to.
        force: the peak [N]; of a twist the torque [N m]; NaN where not even the
            first step could be followed: ``end`` says why.
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
        """Whether the pull ended before the coil had given way or let the object slide."""
        return self.end in OPEN_ENDS and not math.isnan(self.force)

    def within(self, displacement: float) -> float:
        """Return the largest force until the object has moved so far [N, m]; torque and angle.

        Towards the base the peak may come after several diameters of the object, when it has all
        but left the coil: the largest force within one diameter is what keeps it in its place.

        Raises:
            InvalidInputError: a displacement that is no number, or below 0.
        """
        require_non_negative("displacement", displacement)
        if math.isnan(self.force):
            return math.nan
        near = self.forces[self.displacements <= displacement * (1.0 + 1e-9)]
        return _rounded(float(near.max()))

    def __repr__(self) -> str:
        least = "at least " if self.is_lower_bound else ""
        if math.isnan(self.force):
            value = "unknown"
        elif is_twist(self.pull):
            value = f"{1e3 * self.force:.3g} N mm at {np.degrees(self.displacement):.3g} deg"
        else:
            value = f"{self.force:.3g} N at {1e3 * self.displacement:.3g} mm"
        return f"HoldingForce({self.pull.value}: {least}{value}; {self.end.value})"


def is_twist(pull: Pull) -> bool:
    """Return whether a pull turns the object."""
    return pull in (Pull.TWIST_LEFT, Pull.TWIST_RIGHT)


def holding_force(
    point: GripPoint, pull: Pull = Pull.AWAY, enough: float = math.inf
) -> HoldingForce:
    """Return what holds an object against being moved one way, with friction.

    The object is moved in small steps at fixed pressure without turning, or turned about its own
    axis; the tube follows in frictional equilibrium. The peak of the force is what holds. It is not
    one number for all directions: pulled away from the base a coil tightens like a finger trap,
    pushed towards it, it opens. Along gravity the object may slide along its own axis: then the
    weight counts whose component along the axis equals the force that holds there. If gravity is
    within 18 degrees of the axis, that is the result. Otherwise the object is also moved straight
    along gravity, by at most a diameter, and the smaller force counts.

    Args:
        point: the grip at its pressure.
        pull: where the object is moved to.
        enough: force [N], of a twist torque [N m], at which the pull may end.

    Raises:
        InvalidInputError: ``Pull.DOWN`` without gravity; ``enough`` is no number, or below 0.
    """
    if enough != math.inf:
        require_non_negative("enough", enough)
    return _down(point, {}, enough) if pull is Pull.DOWN else _pulled(point, pull, enough)


def holding_forces(point: GripPoint, pulls: Sequence[Pull]) -> dict[Pull, HoldingForce]:
    """Return what :func:`holding_force` returns for each of several pulls."""
    found: dict[Pull, HoldingForce] = {}
    for pull in pulls:
        if pull is not Pull.DOWN:
            found[pull] = _pulled(point, pull)
    if Pull.DOWN in pulls:
        found[Pull.DOWN] = _down(point, found)
    return {pull: found[pull] for pull in pulls}


def _down(
    point: GripPoint, found: Mapping[Pull, HoldingForce], enough: float = math.inf
) -> HoldingForce:
    """Return what holds along gravity, at most the weight that would slide along the object."""
    along = float(pull_direction(point, Pull.DOWN) @ pull_direction(point, Pull.AWAY))
    share = abs(along)
    if share < LEAST_SHARE:
        return _pulled(point, Pull.DOWN, enough)
    way = Pull.AWAY if along > 0.0 else Pull.TOWARDS
    axial = found[way] if way in found else _pulled(point, way, enough * share)
    sliding = _as_weight(axial, share)
    if share >= MOSTLY_ALONG:
        return sliding
    straight = _pulled(point, Pull.DOWN, enough)
    # A force that is not known may be the smaller one.
    return min(sliding, straight, key=lambda held: np.nan_to_num(held.force, nan=-math.inf))


def _as_weight(axial: HoldingForce, share: float) -> HoldingForce:
    """Return the pull along gravity of an object that slides along its axis.

    Of its weight the ``share`` acts along the axis, and of its way as much is along gravity.
    """
    return HoldingForce(
        Pull.DOWN,
        axial.force / share,
        axial.displacement * share,
        axial.stiffness / share**2,
        axial.displacements * share,
        axial.forces / share,
        axial.end,
    )


def _pulled(point: GripPoint, pull: Pull, enough: float = math.inf) -> HoldingForce:
    """Return the result of one pull, to its peak or to where it holds enough."""
    setup = point.setup
    direction = pull_direction(point, pull)
    turning = is_twist(pull)
    step = TURN_STEP if turning else STEP * float(setup.obstacle.shape.feature_radius)
    most = MOST_STEPS_DOWN if pull is Pull.DOWN else MOST_STEPS
    curve: list[tuple[float, float]] = []
    state, end, count = point.state, PullEnd.STEP_LIMIT, 0
    # Friction comes on, if it was not there while closing, before anything moves: the step 0.
    for count in range(most + 1):
        way = tuple((count * step * direction).tolist())
        moved = setup.obstacle.moved(**{"rotation" if turning else "translation": way})
        path = follow_contact(
            [setup.problem(point.pressure, moved)], start=state, stop_at_event=True
        )
        if path.self_contact is not None:
            end = PullEnd.SELF_CONTACT
            break
        if path.events:
            event = path.events[0]
            end = PullEnd.LOST if event.after is None else PullEnd.NOT_FOLLOWED
            if event.position > 0.0:
                reached = max(0.0, count - 1.0 + event.position) * step
                curve.append((reached, _resistance(event.before, direction, turning)))
            break
        if path.states[0].status is not RodStatus.CONVERGED:
            end = PullEnd.NOT_FOLLOWED
            break
        state = path.states[0]
        curve.append((count * step, _resistance(state, direction, turning)))
        if _slips([force for _, force in curve]):
            end = PullEnd.SLIPPED
            break
        if curve[-1][1] >= enough:
            end = PullEnd.ENOUGH
            break
    known = count > 1 or end not in OPEN_ENDS or end is PullEnd.ENOUGH
    return _result(pull, curve, end, known)


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
    if pull is Pull.SIDEWAYS:
        away: Array = setup.frame[1]
        return away
    positions = point.state.positions
    if (positions[-1] - positions[0]) @ axis < 0.0:
        axis = -axis  # away from the base is where the coil advances to
    return axis if pull in (Pull.AWAY, Pull.TWIST_RIGHT) else -axis


def _slips(forces: list[float]) -> bool:
    """Return whether the force has stopped rising."""
    earlier = forces[:-STEADY_STEPS]
    if not earlier:
        return False
    return max(forces) - max(earlier) <= RISE * (max(forces) - min(forces))


def _resistance(state: RodState, direction: Array, turning: bool) -> float:
    """Return the force [N] or torque [N m] that it takes to hold the object where it is."""
    resultant = state.on_obstacle()
    return -float((resultant.torque if turning else resultant.force) @ direction)


def _result(
    pull: Pull, curve: list[tuple[float, float]], end: PullEnd, known: bool
) -> HoldingForce:
    """Return the result of a pull from its displacements and forces."""
    displacements, values = np.array(curve or [(0.0, 0.0)]).T
    if not known:
        return HoldingForce(pull, math.nan, math.nan, math.nan, displacements, values, end)
    peak = int(np.argmax(values))
    held = _rounded(float(values[peak]))
    rise, way = np.diff(values[:2]), np.diff(displacements[:2])
    stiffness = float(rise[0] / way[0]) if way.size and way[0] > 0.0 else 0.0
    return HoldingForce(
        pull, held, float(displacements[peak]), stiffness, displacements, values, end
    )


def _rounded(force: float) -> float:
    """Return what holds; nothing without friction, or where the coil itself pushes this way."""
    return 0.0 if force < ROUNDING else force
