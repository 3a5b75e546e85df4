# SPDX-License-Identifier: Apache-2.0
"""Shapes that a rod may touch, each given by its signed distance in a frame of its own."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from spiral_core.brief import brief_repr
from spiral_core.errors import InvalidInputError
from spiral_core.rod._algebra import around_axis, from_cone
from spiral_core.validation import require_finite, require_positive

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

Array: TypeAlias = NDArray[np.float64]
# Distance (n,), its gradient (n, 3) and Hessian (n, 3, 3), in the shape's frame.
Distance: TypeAlias = tuple[Array, Array, Array]
# Heights between which the z axis lies in the solid, a shape's optional ``axis_range``: without it
# turns are not counted, and a rod that jumps across the axis in a step is not detected.
Range: TypeAlias = tuple[float, float]

# Step of the central differences that give a user's distance its Hessian, in radii of curvature.
DIFFERENCE = 1e-5
# Newton steps to the nearest point of a profile, from the nearest of so many places of each of its
# pieces.
NEAREST_STEPS, PLACES = 12, 8
# By how much the norm of a user's gradient may be off one: forces are off by as much.
NOT_UNIT = 1e-3
# How near to a profile's center of curvature is at it.
NOT_A_CENTER = 1e-3


class Shape(Protocol):
    """A shape's signed distance in its own frame: positive outside, its gradient of norm one."""

    def distance(self, points: Array) -> Distance:
        """Return distance [m], gradient and Hessian [1/m] at points (n, 3) [m]."""

    @property
    def feature_radius(self) -> float:
        """Smallest radius of curvature of the surface where a rod bends around it [m]."""


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A cylinder about the z axis, without end.

    Args:
        radius: [m], > 0.
        inside: whether the rod lies inside it, as in a tube.
    """

    radius: float
    inside: bool = False

    def __post_init__(self) -> None:
        require_positive("radius", self.radius)

    def distance(self, points: Array) -> Distance:
        """Return the distance from the lateral surface."""
        gap, normal, bend = from_cone(points, self.radius, 0.0)
        return (-gap, -normal, -bend) if self.inside else (gap, normal, bend)

    @property
    def feature_radius(self) -> float:
        """The radius."""
        return self.radius

    @property
    def axis_range(self) -> Range | None:
        """Where the z axis lies in the solid: everywhere, or nowhere in a tube."""
        return None if self.inside else (-math.inf, math.inf)


@dataclass(frozen=True, slots=True)
class Cone:
    """A cone about the z axis, r(z) = radius + slope z; the rod must stay clear of its apex.

    Args:
        radius: at z = 0 [m], > 0.
        slope: dr/dz.
    """

    radius: float
    slope: float

    def __post_init__(self) -> None:
        require_positive("radius", self.radius)
        require_finite("slope", self.slope)

    def distance(self, points: Array) -> Distance:
        """Return the distance from the lateral surface."""
        return from_cone(points, self.radius, self.slope)

    @property
    def feature_radius(self) -> float:
        """The radius at z = 0."""
        return self.radius

    @property
    def axis_range(self) -> Range:
        """Where the z axis lies in the solid: up to the apex."""
        return _up_to_apexes((0.0, self.radius, self.slope), (0.0, self.radius, self.slope))


def _up_to_apexes(low: tuple[float, float, float], high: tuple[float, float, float]) -> Range:
    """Return where a body ends that goes on from height, radius and slope at two ends as a cone."""
    (z, r, slope), (top, last, bend) = low, high
    return (
        z - r / slope if slope > 0.0 else -math.inf,
        top - last / bend if bend < 0.0 else math.inf,
    )


@lru_cache(maxsize=32)
def _spline(heights: tuple[float, ...], radii: tuple[float, ...]) -> CubicSpline:
    """Return the natural cubic spline through the given points."""
    from scipy.interpolate import CubicSpline

    return CubicSpline(heights, radii, bc_type="natural")


@dataclass(frozen=True, slots=True)
class Profile:
    """A body of revolution about the z axis, r(z) a cubic spline, beyond its ends a cone.

    Args:
        heights: z of the given radii [m], increasing, at least two.
        radii: r there [m], > 0.
    """

    __repr__ = brief_repr

    heights: tuple[float, ...]
    radii: tuple[float, ...]

    def __post_init__(self) -> None:
        heights = [require_finite("heights", z) for z in np.atleast_1d(self.heights).tolist()]
        radii = [require_positive("radii", r) for r in np.atleast_1d(self.radii).tolist()]
        if len(heights) < 2 or any(not b > a for a, b in pairwise(heights)):
            raise InvalidInputError("heights", self.heights, "two or more increasing numbers")
        if len(radii) != len(heights):
            raise InvalidInputError("radii", self.radii, f"one for each of {len(heights)} heights")
        object.__setattr__(self, "heights", tuple(heights))
        object.__setattr__(self, "radii", tuple(radii))
        spline = _spline(self.heights, self.radii)
        turning = spline.derivative().roots(extrapolate=False)
        if not np.all(spline(turning[turning == turning]) > 0.0):
            requirement = "closer together where they change: their spline crosses zero"
            raise InvalidInputError("radii", self.radii, requirement)

    def distance(self, points: Array) -> Distance:
        """Return the distance from the lateral surface, from the nearest point of the profile."""
        rho, radial, around = around_axis(points)
        # From the nearest of some places of the profile, and of that as high as the point.
        pieces = len(self.heights) - 1
        sites = np.linspace(0, pieces, 1 + PLACES * pieces)
        heights = np.interp(sites, np.arange(pieces + 1), self.heights)
        square = (points[:, 2:] - heights) ** 2 + (rho[:, None] - self._curve(heights)[0]) ** 2
        level = np.abs(rho - self._curve(points[:, 2])[0]) < np.sqrt(square.min(axis=1))
        foot = np.where(level, points[:, 2], heights[square.argmin(axis=1)])
        for _ in range(NEAREST_STEPS):
            r, slope, bend = self._curve(foot)
            change = foot - points[:, 2] + (r - rho) * slope
            foot -= change / np.maximum(1.0 + slope**2 + (r - rho) * bend, 0.5)
        r, slope, bend = self._curve(foot)
        c = 1.0 / np.sqrt(1.0 + slope**2)
        normal = c[:, None] * radial
        normal[:, 2] = -c * slope
        along = (c * slope)[:, None] * radial
        along[:, 2] = c
        gap = c * (rho - r - slope * (points[:, 2] - foot))
        curve = -bend * c**3
        curve = curve / np.maximum(1.0 + curve * gap, NOT_A_CENTER)
        safe = np.maximum(rho, 1e-9 * min(self.radii))
        hessian = curve[:, None, None] * along[:, :, None] * along[:, None, :]
        hessian += (c / safe)[:, None, None] * around
        return gap, normal, hessian

    def _curve(self, heights: Array) -> tuple[Array, Array, Array]:
        """Return r, r' and r'' at the heights."""
        spline = _spline(self.heights, self.radii)
        inside = np.clip(heights, self.heights[0], self.heights[-1])
        slope = spline(inside, 1)
        bend = np.where(heights == inside, spline(inside, 2), 0.0)
        return spline(inside) + slope * (heights - inside), slope, bend

    @property
    def feature_radius(self) -> float:
        """The smallest of the given radii."""
        return min(self.radii)

    @property
    def axis_range(self) -> Range:
        """Where the z axis lies in the solid: up to the apexes of the cones at its ends."""
        ends = np.array((self.heights[0], self.heights[-1]))
        radii, slopes, _ = self._curve(ends)
        low, high = np.column_stack((ends, radii, slopes)).tolist()
        return _up_to_apexes((*low,), (*high,))


@dataclass(frozen=True, slots=True)
class Sphere:
    """A sphere about the origin.

    Args:
        radius: [m], > 0.
    """

    radius: float

    def __post_init__(self) -> None:
        require_positive("radius", self.radius)

    def distance(self, points: Array) -> Distance:
        """Return the distance from the surface."""
        return _ball(points, self.radius)

    @property
    def feature_radius(self) -> float:
        """The radius."""
        return self.radius


def _ball(points: Array, radius: float) -> Distance:
    """Return the distance from a sphere about the origin."""
    away = np.sqrt(np.sum(points**2, axis=1))
    safe = np.maximum(away, 1e-9 * radius)
    normal = points / safe[:, None]
    normal[away == 0.0] = (1.0, 0.0, 0.0)
    bend = (np.eye(3) - normal[:, :, None] * normal[:, None, :]) / safe[:, None, None]
    return away - radius, normal, bend


@dataclass(frozen=True, slots=True)
class Capsule:
    """A cylinder about the z axis with hemispherical ends.

    Args:
        radius: [m], > 0.
        length: of the cylindrical part, from -length / 2 to length / 2 [m], > 0.
    """

    radius: float
    length: float

    def __post_init__(self) -> None:
        require_positive("radius", self.radius)
        require_positive("length", self.length)

    def distance(self, points: Array) -> Distance:
        """Return the distance from the surface."""
        half = 0.5 * self.length
        from_core = points.copy()
        from_core[:, 2] -= np.clip(points[:, 2], -half, half)
        gap, normal, bend = _ball(from_core, self.radius)
        side = np.abs(points[:, 2]) <= half
        bend[side, 2, :] = 0.0
        bend[side, :, 2] = 0.0
        return gap, normal, bend

    @property
    def feature_radius(self) -> float:
        """The radius."""
        return self.radius

    @property
    def axis_range(self) -> Range:
        """Where the z axis is that of the cylindrical part."""
        return -0.5 * self.length, 0.5 * self.length


@dataclass(frozen=True, slots=True)
class Plane:
    """The half-space z <= 0; the rod stays above."""

    def distance(self, points: Array) -> Distance:
        """Return the height above the plane."""
        normal = np.zeros_like(points)
        normal[:, 2] = 1.0
        return points[:, 2].copy(), normal, np.zeros((len(points), 3, 3))

    @property
    def feature_radius(self) -> float:
        """A plane bends nothing."""
        return math.inf


@dataclass(frozen=True, slots=True, eq=False)
class SignedDistance:
    """Any shape with a signed distance.

    Args:
        function: from points (n, 3) [m] to distances (n,) [m] and gradients (n, 3) of norm one.
        feature_radius: smallest radius of curvature that a rod meets [m], > 0.
    """

    function: Callable[[Array], tuple[Array, Array]] = field(repr=False)
    feature_radius: float

    def __post_init__(self) -> None:
        require_positive("feature_radius", self.feature_radius)

    def distance(self, points: Array) -> Distance:
        """Return the function's values; the Hessian by central differences of its gradient."""
        gap, normal = self._checked(points)
        step = DIFFERENCE * self.feature_radius
        bend = np.empty((len(points), 3, 3))
        for k in range(3):
            shift = step * np.eye(3)[k]
            bend[:, :, k] = self._checked(points + shift)[1] - self._checked(points - shift)[1]
        bend /= 2.0 * step
        return gap, normal, 0.5 * (bend + bend.transpose(0, 2, 1))

    def _checked(self, points: Array) -> tuple[Array, Array]:
        gap, normal = (np.asarray(x, dtype=np.float64) for x in self.function(points))
        if gap.shape != points.shape[:1] or normal.shape != points.shape:
            raise InvalidInputError(
                "function", (gap.shape, normal.shape), "distances (n,) and gradients (n, 3)"
            )
        sizes = np.linalg.norm(normal, axis=1)
        if not (np.all(np.isfinite(gap)) and np.all(np.abs(sizes - 1.0) <= NOT_UNIT)):
            requirement = "finite distances, and gradients of norm one"
            raise InvalidInputError("function", (gap, normal), requirement)
        return gap, normal
