# SPDX-License-Identifier: Apache-2.0
"""A gripper's regions of capture in a JSON file beside its description."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from spiral_core.rod.types import Vector
from spiral_core.wrap.placement import misplacement
from spiral_gripper.files.beside import read_beside, write_beside
from spiral_gripper.files.description import GripperDescription
from spiral_gripper.files.storage import FileError

if TYPE_CHECKING:
    from spiral_core.grip.capture import CaptureRegion

SUFFIX = ".capture.json"
# An ellipsoid is not thinner than this [m, rad].
SMALLEST = 1e-9
# A region stands for radii and pressures within this fraction of its own, and gravity within this
# [m/s^2] of its own.
TOLERANCE, GRAVITY_TOLERANCE = 0.01, 0.2
# Numbers that a file rounds are the same within this fraction.
ROUNDED = 1e-5


@dataclass(frozen=True, slots=True)
class StoredRegion:
    """The ellipsoid of a region of capture, and what it was computed for.

    Attributes:
        radius: of the cylinder [m].
        pressure: up to which the gripper closes [Pa].
        payload: mass that it has to hold [kg]; None: only itself.
        friction: coefficient between tube and object.
        gravity: in the base frame [m/s^2].
        center: where the middle of the object belongs, in the base frame [m].
        frame: unit rows (3, 3): along the object, away from the base, across both.
        semi_axes: of the ellipsoid: shifts away and across [m], tilts about these [rad].
    """

    radius: float
    pressure: float
    payload: float | None
    friction: float
    gravity: Vector
    center: Vector
    frame: tuple[Vector, Vector, Vector]
    semi_axes: tuple[float, float, float, float]

    def margin(self, point: Vector, axis: Vector) -> float:
        """Return :meth:`CaptureRegion.margin` of an object that is seen somewhere.

        Args:
            point: any of its axis [m].
            axis: direction of its axis, a unit vector.
        """
        off = misplacement(point, axis, self.center, np.array(self.frame))
        return 1.0 - float(np.linalg.norm(off / np.maximum(self.semi_axes, SMALLEST)))

    def is_for(
        self,
        pressure: float,
        radius: float,
        gravity: Vector,
        friction: float,
        payload: float | None,
    ) -> bool:
        """Return whether it is known for a closing on an object of a radius [m] up to a pressure.

        A payload [kg] may be less than its own.
        """
        alike = (self.radius, radius), (self.pressure, pressure)
        return (
            all(abs(own - other) <= TOLERANCE * own for own, other in alike)
            and math.dist(self.gravity, gravity) <= GRAVITY_TOLERANCE
            and math.isclose(friction, self.friction, rel_tol=ROUNDED)
            and (payload or 0.0) <= (1.0 + ROUNDED) * (self.payload or 0.0)
        )


def capture_margin(
    regions: Sequence[StoredRegion],
    point: Vector,
    axis: Vector,
    asked: tuple[float, float, Vector, float, float | None],
) -> float | None:
    """Return the largest margin of an object in the regions that are known; None: none is.

    Args:
        regions: that are stored.
        point: any of the object's axis, in the base frame [m].
        axis: direction of its axis, a unit vector.
        asked: arguments of :meth:`StoredRegion.is_for`.
    """
    margins = (each.margin(point, axis) for each in regions if each.is_for(*asked))
    return max(margins, default=None)


def write_region(region: CaptureRegion, description: GripperDescription) -> Path:
    """Add a region to those beside the description; return the path.

    It takes the place of one for the same object and payload. Regions of other values of the
    description are dropped.

    Raises:
        FileError: it cannot be written.
    """
    setup = region.setup
    added = StoredRegion(
        radius=float(setup.obstacle.shape.feature_radius),
        pressure=region.pressure,
        payload=region.payload,
        friction=setup.obstacle.friction,
        gravity=setup.gripper.gravity,
        center=setup.obstacle.position,
        frame=setup.frame.tolist(),
        semi_axes=tuple(region.semi_axes[:4].tolist()),
    )
    try:
        known = read_regions(description)
    except FileError:
        known = ()
    of_object = added.radius, added.gravity, added.friction, added.payload
    kept = [
        each
        for each in known
        if not (
            each.is_for(each.pressure, *of_object)
            and math.isclose(each.payload or 0.0, added.payload or 0.0, rel_tol=ROUNDED)
        )
    ]
    document = {"regions": [asdict(each) for each in (*kept, added)]}
    return write_beside(description, SUFFIX, document)


def read_regions(description: GripperDescription) -> tuple[StoredRegion, ...]:
    """Return the regions beside a description file; none if there is no file of them.

    Raises:
        FileError: it cannot be used; see :func:`~spiral_gripper.files.beside.read_beside`.
    """
    try:
        document = read_beside(description, SUFFIX, 'capture {} --radius "15 mm" --table')
    except FileError as error:
        if error.action == "read":
            return ()
        raise
    return tuple(StoredRegion(**each) for each in document["regions"])
