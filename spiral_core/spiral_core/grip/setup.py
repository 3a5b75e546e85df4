# SPDX-License-Identifier: Apache-2.0
"""The setup of a grip: gripper, object, its place, how the one closes, and the tube beside it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from spiral_core.brief import brief_repr
from spiral_core.errors import InvalidInputError, NotGrippableError, SolverError
from spiral_core.rod.contact._contact import distances
from spiral_core.rod.contact._continuation import NO_SIDE
from spiral_core.rod.contact.obstacles import Obstacle, frame_of
from spiral_core.rod.contact.problem import RodProblem
from spiral_core.rod.contact.shapes import Cylinder, Profile, Shape
from spiral_core.rod.contact.solve import solve_contact
from spiral_core.rod.state import RodState, RodStatus
from spiral_core.rod.types import MAX_ELEMENTS, Array, Vector
from spiral_core.validation import require_in_range, require_kind, require_positive
from spiral_core.wrap.curve import WrapCurve
from spiral_core.wrap.gripper import DEFAULT_FRICTION, FRICTION_MAX, Gripper
from spiral_core.wrap.placement import coil_place
from spiral_core.wrap.profile import ObjectProfile, wrap_for_profile

# Elements of the rod: at least so many, and none longer than this fraction of the arc on which the
# tube's axis goes around the object.
LEAST_ELEMENTS = 90
ELEMENT_ARC = 0.4
# Without contact nothing begins within an element.
FREE_ELEMENTS = 60
# Weight per length times length cubed, over the bending stiffness, at which a column buckles.
TALLEST_COLUMN = 7.837


class Closing(Enum):
    """Whether the object's surface resists while the gripper closes; the value says it in words."""

    SLOW = "closed slowly, with friction"
    FRICTIONLESS = "closed without friction: the best case"


@dataclass(frozen=True, slots=True)
class GripSetup:
    """A gripper, an object in its place, and how the one closes on the other.

    The pressure rises slowly from the hanging tube, with the object in place. The object is rigid
    and does not move while the gripper closes.

    Args:
        gripper: the gripper as it is mounted; its base is at the origin, the tube leaves along +x.
        obstacle: the object's shape at its place, with its coefficient of friction.
        closing: with friction, or without.
        elements: of the rod; None takes enough for the object, at least 90.
        tip_pressure: of the perfect wrap by the criterion at the free coil's tip [Pa], to compare;
            None where it is not known.

    Raises:
        InvalidInputError: a value is not of its kind, or out of its range.
    """

    __repr__ = brief_repr

    gripper: Gripper
    obstacle: Obstacle
    closing: Closing = Closing.SLOW
    elements: int | None = None
    tip_pressure: float | None = None

    def __post_init__(self) -> None:
        for name, kind in (("gripper", Gripper), ("obstacle", Obstacle), ("closing", Closing)):
            require_kind(name, getattr(self, name), kind)
        require_in_range("friction", self.obstacle.friction, 0.0, FRICTION_MAX)
        if self.elements is not None:
            require_in_range("elements", self.elements, 2, MAX_ELEMENTS)
            if type(self.elements) is not int:
                raise InvalidInputError("elements", self.elements, "a whole number")
        if self.tip_pressure is not None:
            require_positive("tip_pressure", self.tip_pressure)

    @property
    def element_count(self) -> int:
        """Elements of the rod."""
        if self.elements is not None:
            return self.elements
        arc = self.obstacle.shape.feature_radius + self.gripper.tube.outer_radius
        return max(LEAST_ELEMENTS, math.ceil(self.gripper.tube.length / (ELEMENT_ARC * arc)))

    @property
    def axis(self) -> Array:
        """Direction of the object's own z axis (3,), a unit vector in the base frame."""
        return frame_of(self.obstacle.orientation)[:, 2]

    @property
    def frame(self) -> Array:
        """Unit rows (3, 3): along the object, from the base square to it, across both."""
        axis = self.axis
        place = np.asarray(self.obstacle.position)
        away = place - (place @ axis) * axis
        if not np.linalg.norm(away) > NO_SIDE * np.linalg.norm(place):  # the axis meets the base
            away = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
        away = away / np.linalg.norm(away)
        return np.array((axis, away, np.cross(axis, away)))

    def moved(self, by: Array) -> GripSetup:
        """Return the setup with its object moved by three shifts [m] and two tilts [rad] (5,).

        Shifts along its axis, away from the base square to it, and across both; tilts about the
        last two of these directions: :attr:`frame`.
        """
        if not by.any():
            return self
        obstacle = self.obstacle.moved(
            translation=tuple((by[:3] @ self.frame).tolist()),
            rotation=tuple((by[3:] @ self.frame[1:]).tolist()),
        )
        return replace(self, obstacle=obstacle)

    def weight_of(self, payload: float) -> float:
        """Return the weight of a mass [kg] where the gripper is [N]."""
        return require_positive("payload", payload) * math.hypot(*self.gripper.gravity)

    @property
    def balance_angle(self) -> float:
        """Angle of the base to an upright one, about which the tube falls to other sides [rad].

        Infinite for a tube that can stand. Where the object stands between, another side may be
        another grip.
        """
        shape = self.gripper.unloaded_shape(0.0)
        down, *across = np.asarray(self.gripper.load(shape).distributed).tolist()
        bending = np.linalg.eigvalsh(self.gripper.stiffness.matrix[1:, 1:]).min()
        if math.hypot(down, *across) * shape.backbone_length**3 <= TALLEST_COLUMN * bending:
            return math.inf
        return math.atan2(math.hypot(*across), -down)

    @property
    def falls_by_choice(self) -> bool:
        """Whether nothing says to which side the tube without pressure falls.

        That is an upright one, to a millionth, too heavy to stand: taken to fall to the side to
        which it bends.
        """
        return self.balance_angle <= NO_SIDE

    def problem(self, pressure: float, obstacle: Obstacle | None = None) -> RodProblem:
        """Return the contact problem at a pressure [Pa], with friction.

        Args:
            pressure: gauge pressure, at most the gripper's limit.
            obstacle: the object elsewhere; None leaves it in its place.
        """
        obstacles = (self.obstacle if obstacle is None else obstacle,)
        return replace(free_problem(self.gripper, pressure), obstacles=obstacles)

    def closing_problem(self, pressure: float) -> RodProblem:
        """Return the problem at a pressure [Pa] while the gripper closes."""
        if self.closing is Closing.SLOW:
            return self.problem(pressure)
        return self.problem(pressure, replace(self.obstacle, friction=0.0))


def free_problem(gripper: Gripper, pressure: float) -> RodProblem:
    """Return the problem of a gripper without an object, at a pressure [Pa]."""
    shape = gripper.unloaded_shape(pressure)
    rod = replace(gripper.rod(shape), radius=gripper.tube.outer_radius)
    return RodProblem(rod, gripper.load(shape))


def lay_into_coil(
    gripper: Gripper,
    radius: float,
    *,
    shape: Shape | None = None,
    friction: float | None = None,
    closing: Closing = Closing.SLOW,
    elements: int | None = None,
    curve: WrapCurve | None = None,
    center: Vector | None = None,
) -> GripSetup:
    """Return the setup whose object lies where the free coil would wrap it, or at a place.

    The object's axis is the gripper's ``object_axis`` or, if that is None, the one that fits the
    coil at the pressure of the perfect wrap; its center is where that coil touches it best. Where
    the base would then lie inside of the object, the object is moved away from it.

    Args:
        gripper: the gripper as it is mounted.
        radius: of the object, where it is to be gripped [m].
        shape: the object's, about its z axis, z = 0 in the middle of the coil; None is a cylinder.
        friction: Coulomb's coefficient; None takes the gripper's own or
            :data:`DEFAULT_FRICTION`.
        closing: with friction, or without.
        elements: of the rod; None takes enough.
        curve: the gripper's wraps, where they are known already; of use if about a fitted axis.
        center: where the shape's own origin lies instead, in the base frame [m].

    Raises:
        InvalidInputError: the radius is not positive, friction not in [0, 10], the center not
            finite.
        NotGrippableError: no pressure coils the gripper to this radius; carries the nearest radius
            that can be wrapped.
        NoCoilError: the gripper makes no coil.
        SolverError: a shape could not be certified.
    """
    require_positive("radius", radius)
    if curve is None or curve.gripper.object_axis is not None:
        curve = WrapCurve(replace(gripper, object_axis=None))
    wrap = curve.wrap_for_radius(radius)
    placement = coil_place(wrap, gripper)
    body = Cylinder(radius) if shape is None else shape
    if center is None:
        center = placement.center
    obstacle = Obstacle.along(body, center, placement.axis, friction_of(gripper, friction))
    return GripSetup(gripper, obstacle, closing, elements, wrap.pressure)


def lay_profile_into_coil(
    gripper: Gripper,
    profile: ObjectProfile,
    *,
    friction: float | None = None,
    closing: Closing = Closing.SLOW,
    center: Vector | None = None,
) -> GripSetup:
    """Return the setup of an object whose radius varies along its axis.

    The coil covers it where :func:`wrap_for_profile` puts it; there the profile becomes smooth, a
    cubic spline through its samples.

    Args:
        gripper: the gripper as it is mounted.
        profile: radii along the object's axis, which points the way the coil advances.
        friction: see :func:`lay_into_coil`.
        closing: with friction, or without.
        center: of the part that is covered, in the base frame [m]; None: in the free coil.

    Raises:
        InvalidInputError: a value is out of its range.
        NotGrippableError: the object cannot be wrapped anywhere.
        SolverError: a shape could not be certified.
    """
    curve = WrapCurve(replace(gripper, object_axis=None))
    wrap = wrap_for_profile(curve, profile)
    middle = 0.5 * (wrap.start + wrap.end)
    positions, radii = profile.samples
    shape = Profile(tuple((positions - middle).tolist()), tuple(radii.tolist()))
    return lay_into_coil(
        gripper,
        profile.radius_at(middle),
        shape=shape,
        friction=friction,
        closing=closing,
        curve=curve,
        center=center,
    )


def friction_of(gripper: Gripper, friction: float | None) -> float:
    """Return a coefficient of friction: the one given, the gripper's own or the default.

    Raises:
        InvalidInputError: it is not in [0, 10].
    """
    if friction is None:
        own = gripper.friction_coefficient
        friction = DEFAULT_FRICTION if own is None else own
    return require_in_range("friction", friction, 0.0, FRICTION_MAX)


def vector_of(components: Array | Vector) -> Vector:
    """Return three components as plain floats."""
    x, y, z = (float(component) for component in components)
    return (x, y, z)


# An object that overlaps the freely hanging tube by up to this fraction of the tube's radius
# pushes it aside; one that overlaps more lies in its way. Nearer to the clamp than so many radii
# the tube gives way with the cube of the distance only: at the clamp not at all.
PUSHED_ASIDE, GIVES_WAY = 0.1, 10.0
# Of each element so many places are looked at; what touches overlaps by rounding.
PLACES, ROUNDING = 10, 1e-6


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
    radius, inside = problem.rod.radius, state.status is RodStatus.INSIDE_OBSTACLE
    at_base = float(distances(setup.obstacle, np.zeros((1, 3)), radius)[0][0])
    if inside or at_base < 0.0 or state.normal_forces.any():
        free = solve_contact(replace(problem, obstacles=()), elements=count)
        at = np.linspace(0.0, problem.rod.length, PLACES * count + 1)
        shapes = [np.stack([np.interp(at, free.arc_lengths, x) for x in free.positions.T], axis=1)]
        near = np.minimum(1.0, (at / (GIVES_WAY * radius)) ** 3)
        if not inside:  # it leans on the object; wedged is what neither bends away at the clamp
            shapes.append(np.outer(at, (1.0, 0.0, 0.0)))
            near[at > GIVES_WAY * radius] = np.inf
        gaps = np.max([distances(setup.obstacle, shape, radius)[0] for shape in shapes], axis=0)
        wedged = gaps < -radius * (PUSHED_ASIDE * near + ROUNDING)
        if wedged.any():
            raise _in_the_way(setup, float(gaps[wedged].min()))
        if inside:
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
