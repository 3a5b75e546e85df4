# SPDX-License-Identifier: Apache-2.0
"""A solved rod: its shape, its forces and the evidence for them, alone and along a path."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from spiral_core.brief import brief_repr
from spiral_core.errors import InvalidInputError
from spiral_core.rod import _newton
from spiral_core.rod._algebra import matrices
from spiral_core.rod._profiles import UniformRod
from spiral_core.rod._system import System
from spiral_core.rod.contact._continuation import Point
from spiral_core.rod.contact._mesh import node_lengths
from spiral_core.rod.contact.obstacles import turns_about
from spiral_core.rod.types import Array

# A node touches where its normal force is above this fraction of its obstacle's largest, and of
# EI/L^2.
TOUCH = 1e-6


class RodStatus(Enum):
    """How a solve ended; the value is advice to the user. Only ``CONVERGED`` is an answer."""

    CONVERGED = "converged to a stable equilibrium"
    ITERATION_LIMIT = (
        "the iteration limit was reached; use more elements, or approach the load in smaller steps"
    )
    LINE_SEARCH_FAILED = (
        "the energy could not be lowered although forces are out of balance; the tolerance is "
        "below rounding error, or the tip moment does work that no energy describes: loosen the "
        "tolerance or reduce the moment"
    )
    NOT_FINITE = "a number overflowed; check lengths, stiffnesses and loads for their units"
    UNSTABLE = (
        "no stable equilibrium lies near: the rod slides or snaps away; start elsewhere, reduce "
        "the load, or follow its motion with follow_rod"
    )
    LEFT_BRANCH = "the branch of stable states ends before this load: the rod would snap"
    FOLD_LIMIT = (
        "the rod snaps more than 32 times on its loading path, which was given up there; use more "
        "elements, or approach the load in stations with follow_rod"
    )
    UNRESOLVED = (
        "an element turns by more than 2 rad, which its ends cannot tell; use more elements"
    )
    NOT_HELD = (
        "the rod keeps moving and finds no equilibrium: nothing holds it, or it slides off its "
        "obstacle; hold an end, raise the friction, or take more elements where it is pulled hard"
    )
    SELF_CONTACT = (
        "the rod touches itself, which this model does not resist; reduce the load, use a longer "
        "pitch or a thinner rod"
    )
    INSIDE_OBSTACLE = (
        "the start, or an end as it is held, lies inside of an obstacle; begin where the rod is "
        "clear of it, give a start, or hold the end outside"
    )


# By the kernels' outcomes, whose names they have.
STATUSES = {vars(_newton)[one.name]: one for one in RodStatus if one.name in vars(_newton)}


class RodElement(Enum):
    """The element that a rod was solved with."""

    INEXTENSIBLE = "clamped and free, neither stretched nor sheared, among no obstacles"
    MIXED = "any ends, any section, obstacles"


class RodCertificate(Enum):
    """What is proved about a state's stability; the value is the text."""

    NONE = "not certified"
    STRICT_MINIMUM = "a strict local minimum of the energy: stable"
    STABLE_UP_TO_ROTATION = (
        "one of a row of equal minima: stable up to a motion that nothing resists, such as a "
        "rotation about the load's axis"
    )


@dataclass(frozen=True, slots=True, eq=False)
class Resultant:
    """What a rod does to an obstacle.

    Args:
        force: sum of the contact forces on the obstacle [N], base frame.
        torque: their moment about the obstacle's position [N m], base frame.
    """

    force: Array
    torque: Array


@dataclass(frozen=True, slots=True, eq=False)
class RodState:
    """A rod's static shape, and the evidence for it.

    Arrays run over the n nodes, and over the m obstacles first where they concern contact. Write
    into none of them: what is solved next starts from them.

    Args:
        status: how the solve ended; the arrays are an answer only if it is ``CONVERGED``.
        arc_lengths: (n,) unstretched, of the nodes [m], from 0 at the base to L at the tip.
        positions: (n, 3) in the base frame [m].
        orientations: (n, 4) unit quaternions, scalar last, material frame to base frame.
        forces: (n, 3) internal force in the base frame [N]; the mean of both sides where a contact
            or a point load makes it jump.
        moments: (n, 3) internal moment in the material frame [N m].
        strains: (n, 3) strain vector in the material frame [1/m]; (0, 3) with the mixed element.
        contact_forces: (m, n, 3) of each obstacle on each node [N], base frame.
        normal_forces: (m, n) their normal part [N].
        gaps: (m, n) distance between the rod's surface and the obstacle's [m]. Elements between
            two touching nodes dip into an obstacle of radius R by up to h^2 / 8 (R + r).
        sticking: (m, n) whether a touching node sticks.
        base_reaction: (6,) force [N] and moment [N m] with which the base is held, base frame.
        tip_reaction: (6,) likewise.
        energy: elastic energy and potential of the loads about the origin [J].
        residual: largest moment imbalance at a node, as a fraction of EI/L; with the mixed element
            also of forces, as a fraction of EI/L^2, of the sum of the loads or a tenth of the
            largest force inside, and of lengths as one of L/10.
        smallest_pivot: smallest pivot of the energy's Hessian with its active contacts, as a
            fraction of EI/L: the certificate. Positive proves a strict local minimum of the
            discrete energy, for the given friction, up to the neutral mode if there is one;
            motions that nothing resists (a round rod spinning about its axis) are stiffened by
            1e-9 EI/L.
        iterations: Newton iterations spent; on a path since the state before, with those of
            attempts that failed and of snaps.
        folds: how often the rod snapped on the way: along the loading path, or from the start;
            the mixed element does not count.
        discretization_error: estimated largest error of a position [m]; where other elements find
            no state, infinite or, with the inextensible element, the length; None where it was not
            asked for. With a neutral mode it is the error up to the free rotation.
        last_step: largest rotation of a node in the Newton step that was left [rad].
        neutral_modes: 1 if the whole rod may turn about the base's axis at no cost (an isotropic
            rod, straight at rest, that buckled under a load along that axis), with the mixed
            element if nothing resists some motion, else 0.
        self_clearance: least distance between two turns of the rod's surface [m], up to two radii:
            of elements farther apart along the rod than pi radii. Infinite where the rod is too
            short to touch itself, or has no radius. Ends held at one place touch.
        trail: (k, n, 3) positions that the rod passed, overdamped, where it snapped or slid to this
            state [m]; empty if it did not.
    """

    __repr__ = brief_repr

    status: RodStatus
    arc_lengths: Array
    positions: Array
    orientations: Array
    forces: Array
    moments: Array
    strains: Array
    contact_forces: Array
    normal_forces: Array
    gaps: Array
    sticking: NDArray[np.bool_] = field(repr=False)
    base_reaction: Array
    tip_reaction: Array
    energy: float
    residual: float
    smallest_pivot: float
    iterations: int
    folds: int = 0
    discretization_error: float | None = None
    last_step: float = field(default=0.0, repr=False)
    neutral_modes: int = 0
    self_clearance: float = math.inf
    trail: Array = field(default_factory=lambda: np.empty((0, 0, 3)), repr=False)
    # What the next increment starts from.
    _point: Point | None = field(default=None, repr=False)
    # The point passed before it, to extrapolate from.
    _before: Point | None = field(default=None, repr=False)
    # What the inextensible element solved.
    _data: UniformRod | System | None = field(default=None, repr=False)

    @property
    def certificate(self) -> RodCertificate:
        """What is proved about the state's stability."""
        if not self.stable:
            return RodCertificate.NONE
        if self.neutral_modes:
            return RodCertificate.STABLE_UP_TO_ROTATION
        return RodCertificate.STRICT_MINIMUM

    @property
    def element(self) -> RodElement:
        """The element that it was solved with."""
        return RodElement.INEXTENSIBLE if self._point is None else RodElement.MIXED

    @property
    def stable(self) -> bool:
        """Whether the state is an equilibrium with a certificate of stability."""
        return self.status is RodStatus.CONVERGED and self.smallest_pivot > 0.0

    @property
    def tip_position(self) -> Array:
        """Position of the tip in the base frame (3,) [m]."""
        tip: Array = self.positions[-1]
        return tip

    @property
    def tangents(self) -> Array:
        """Unit vectors along the rod's sections (n, 3), base frame."""
        tangents: Array = matrices(self.orientations)[:, :, 0]
        return tangents

    @property
    def node_lengths(self) -> Array:
        """Length of rod that each node stands for (n,) [m]."""
        return node_lengths(self.arc_lengths)

    @property
    def touching(self) -> NDArray[np.bool_]:
        """Whether a node touches an obstacle (m, n)."""
        largest = self.normal_forces.max(axis=1, initial=0.0)
        scale = 0.0
        if self._point is not None:
            scale = self._point.arrays.bending / self._point.arrays.length**2
        touching: NDArray[np.bool_] = (
            self.normal_forces > TOUCH * np.maximum(largest, scale)[:, None]
        )
        if self._point is not None:
            touching = touching & self._point.solution.contacts.active
        return touching

    @property
    def contact_lengths(self) -> Array:
        """Length that the touching nodes of each obstacle stand for (m,) [m].

        Next to where a rod lifts off, gaps of micrometers open and close with the elements:
        :meth:`lengths_within` does not depend on those.
        """
        lengths: Array = np.sum(np.where(self.touching, self.node_lengths, 0.0), axis=1)
        return lengths

    def lengths_within(self, gap: float) -> Array:
        """Return the length of each element within a gap [m] of each obstacle (m, n - 1) [m].

        The gap is linear between nodes, and at most this at both ends of what counts.
        """
        low = np.minimum(self.gaps[:, :-1], self.gaps[:, 1:])
        high = np.maximum(self.gaps[:, :-1], self.gaps[:, 1:])
        with np.errstate(divide="ignore", invalid="ignore"):
            parts = np.where(high <= gap, 1.0, np.maximum((gap - low) / (high - low), 0.0))
        lengths: Array = parts * np.diff(self.arc_lengths)
        return lengths

    @property
    def turns(self) -> Array:
        """Turns of the rod about each obstacle's z axis (m,), from base to tip.

        Counterclockwise positive, NaN for shapes without an axis. Along a path they change
        continuously: nothing passes through an obstacle.
        """
        obstacles = () if self._point is None else self._point.arrays.obstacles
        return np.array([turns_about(obstacle, self.positions) for obstacle in obstacles])

    def on_obstacle(self, index: int = 0) -> Resultant:
        """Return what the rod does to an obstacle: resultant of normal forces and friction.

        Contact forces act where friction does, at the rod's surface by default.
        """
        if self._point is None or not -len(self.gaps) <= index < len(self.gaps):
            raise InvalidInputError("index", index, f"one of {len(self.gaps)} obstacles")
        arrays = self._point.arrays
        obstacle = arrays.obstacles[index]
        pushes = -self.contact_forces[index]
        normal = self._point.solution.contacts.normal[index]
        lever = self.positions - arrays.lever * normal - np.asarray(obstacle.position)
        return Resultant(pushes.sum(axis=0), np.cross(lever, pushes).sum(axis=0))


@dataclass(frozen=True, slots=True, eq=False)
class RodEvent:
    """A place on a path where a branch of stable states ends and the rod snaps or slips away.

    Args:
        position: where, as a station's index plus the fraction of the way to the next one.
        before: the last state of the branch that ends.
        after: where the rod comes to rest; not converged if it does not; None if it moves on and
            its motion was not followed.
    """

    __repr__ = brief_repr

    position: float
    before: RodState
    after: RodState | None

    @property
    def last(self) -> RodState:
        """Where the rod is after it, as far as that is known."""
        return self.before if self.after is None else self.after

    @property
    def contact_lost(self) -> float:
        """Length of contact that the event costs, over all obstacles [m]; negative if gained.

        All of it where the rod's motion was not followed.
        """
        after = 0.0 if self.after is None else np.sum(self.after.contact_lengths)
        return float(np.sum(self.before.contact_lengths) - after)


@dataclass(frozen=True, slots=True)
class SelfContact:
    """Where a rod on a path first touches itself.

    Args:
        position: where on the path, as an event's.
        places: arc lengths of the two places that touch [m].
    """

    position: float
    places: tuple[float, float]


@dataclass(frozen=True, slots=True, eq=False)
class RodPath:
    """States along a path.

    Args:
        states: one for each station reached; fewer than stations if the rod was lost on the way.
        events: folds and losses, in the order met.
        self_contact: where the rod first touched itself, in any increment or while it snapped; None
            if it did not. States from there on are not answers, though it may be clear again.
    """

    __repr__ = brief_repr

    states: tuple[RodState, ...]
    events: tuple[RodEvent, ...]
    self_contact: SelfContact | None = None
