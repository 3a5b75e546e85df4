"""From a rod and its load to the arrays of the compiled kernels."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np

from spiral_core.errors import InvalidInputError
from spiral_core.numerics.kernel import compiled
from spiral_core.rod._newton import System
from spiral_core.rod._shape import discrete_strain_scale
from spiral_core.rod.types import (
    MAX_ELEMENTS,
    Array,
    Rod,
    RodLoad,
    ScalarProfile,
    Vector,
    VectorProfile,
)

# Elements are chosen so that one turns by at most this angle [rad], at rest and where the load
# bends it; measured, the tip's error is then 3e-6 of the length in the median, 3e-5 at worst.
ELEMENT_ANGLE = 0.25
FEWEST_ELEMENTS = 24
# Sites at which a varying rod is looked at to choose its elements.
SURVEY_SITES = 65


@dataclass(frozen=True, slots=True, eq=False)
class RodArrays:
    """A rod on N elements.

    Args:
        step: h [m].
        force: (N + 1, 3) force of everything beyond a node, base frame [N].
        nodal: (N + 1, 3) weight of each node's tangent in the load's energy, base frame [N m].
        distributed: (N + 1, 3) load per length, base frame [N/m].
        tip_moment: (3,) base frame [N m].
        elements: (N, 10), see :mod:`spiral_core.rod._element`.
        stiffness: (N + 1, 3) diagonal of K at the nodes, or (1, 3) if it is uniform [N m^2].
        rest_strain: (N + 1, 3) or (1, 3), likewise [1/m].
        rest_energy: energy that the elements leave out because it does not depend on the shape:
            of the rest strain, and of the load at the clamped node [J].
        moment_scale: EI/L with the smallest EI, the unit of residuals and pivots [N m].
    """

    step: float
    force: Array
    nodal: Array
    distributed: Array
    tip_moment: Array
    elements: Array
    stiffness: Array
    rest_strain: Array
    rest_energy: float
    moment_scale: float

    @property
    def system(self) -> System:
        """What the kernels solve."""
        return (self.force, self.nodal, self.tip_moment, self.elements, self.step)

    @property
    def count(self) -> int:
        """Number of elements."""
        return int(self.elements.shape[0])


def element_count(rod: Rod, load: RodLoad, angle: float = ELEMENT_ANGLE) -> int:
    """Return how many elements turn by at most ``angle`` [rad] each; an even number.

    Raises:
        InvalidInputError: a profile is not valid, or it would be more than ``MAX_ELEMENTS``.
    """
    sites = np.linspace(0.0, rod.length, SURVEY_SITES)
    bending = scalar_samples("bending_stiffness", rod.bending_stiffness, sites).min()
    strains = vector_samples("rest_strain", rod.rest_strain, sites)
    weights = vector_samples("distributed", load.distributed, sites)
    with np.errstate(over="ignore"):
        curvature = np.linalg.norm(strains, axis=1).max()
        weight = np.linalg.norm(weights, axis=1).max()
    force = weight * rod.length + math.hypot(*load.tip_force)
    bent = math.sqrt(force / bending) + math.hypot(*load.tip_moment) / bending
    needed = float(rod.length * max(float(curvature), bent) / angle)
    if not needed <= MAX_ELEMENTS - 1:
        requirement = f"at most {MAX_ELEMENTS} for a rod and its load; are they in SI units?"
        raise InvalidInputError("elements", needed, requirement)
    count = math.ceil(needed)
    return max(FEWEST_ELEMENTS, count + count % 2)


def discretize(rod: Rod, load: RodLoad, count: int) -> RodArrays:
    """Return the arrays of ``rod`` and ``load`` on ``count`` elements.

    Raises:
        InvalidInputError: a profile's values have the wrong shape, are not finite or not positive.
    """
    bending, torsional = rod.bending_stiffness, rod.torsional_stiffness
    if (
        callable(bending)
        or callable(torsional)
        or callable(rod.rest_strain)
        or callable(load.distributed)
    ):
        return _discretize_profiles(rod, load, count)
    h = rod.length / count
    rest = floats(rod.rest_strain)
    force, nodal, distributed, elements, rest_energy = uniform_arrays(
        h,
        count,
        float(torsional),
        float(bending),
        rest,
        floats(load.distributed),
        floats(load.tip_force),
    )
    return RodArrays(
        step=h,
        force=force,
        nodal=nodal,
        distributed=distributed,
        tip_moment=np.array(load.tip_moment, dtype=np.float64),
        elements=elements,
        stiffness=np.array([[torsional, bending, bending]], dtype=np.float64),
        rest_strain=np.array([rest]),
        rest_energy=rest_energy,
        moment_scale=bending / rod.length,
    )


def between(first: RodArrays, last: RodArrays, at: float) -> RodArrays:
    """Return the arrays at the fraction ``at`` of the way from one discretized rod to another."""
    values = {
        field.name: (1.0 - at) * getattr(first, field.name) + at * getattr(last, field.name)
        for field in fields(RodArrays)
    }
    return RodArrays(**values)


@compiled
def uniform_arrays(
    h: float,
    count: int,
    torsional: float,
    bending: float,
    rest: Vector,
    weight: Vector,
    tip_force: Vector,
) -> tuple[Array, Array, Array, Array, float]:
    """Return force, nodal, distributed, elements and rest energy of a uniform rod."""
    force = np.empty((count + 1, 3))
    nodal = np.empty((count + 1, 3))
    distributed = np.empty((count + 1, 3))
    elements = np.zeros((count, 10))
    seen = discrete_strain_scale(
        h * math.sqrt(rest[0] * rest[0] + rest[1] * rest[1] + rest[2] * rest[2])
    )
    for i in range(count + 1):
        for k in range(3):
            force[i, k] = tip_force[k] + weight[k] * h * (count - i)
            nodal[i, k] = h * force[i, k]
            distributed[i, k] = weight[k]
    for k in range(3):
        nodal[count, k] = 0.5 * h * tip_force[k] + h * h / 12.0 * weight[k]
    for i in range(count):
        elements[i, 0] = torsional
        elements[i, 1] = bending
        elements[i, 2] = torsional * seen * rest[0]
        elements[i, 3] = bending * seen * rest[1]
        elements[i, 4] = bending * seen * rest[2]
    bent = rest[1] * rest[1] + rest[2] * rest[2]
    energy = 0.5 * h * count * seen * seen * (torsional * rest[0] * rest[0] + bending * bent)
    energy += h * h / 12.0 * weight[0] - 0.5 * h * force[0, 0]
    return force, nodal, distributed, elements, energy


def _discretize_profiles(rod: Rod, load: RodLoad, count: int) -> RodArrays:
    """Return the arrays of a rod that varies; Simpson's means over elements keep the order."""
    h = rod.length / count
    sites = np.linspace(0.0, rod.length, 2 * count + 1)
    stiffness = np.column_stack(
        (
            scalar_samples("torsional_stiffness", rod.torsional_stiffness, sites),
            scalar_samples("bending_stiffness", rod.bending_stiffness, sites),
        )
    )
    rest_strain = vector_samples("rest_strain", rod.rest_strain, sites)
    seen = rest_strain * _strain_scales(h * np.sqrt(np.sum(rest_strain**2, axis=1)))[:, None]
    diagonal = stiffness[:, [0, 1, 1]]
    moment = diagonal * seen
    columns = np.hstack((stiffness, moment))
    elements = np.hstack((_simpson(columns), np.diff(columns[::2], axis=0) / h))
    weight = vector_samples("distributed", load.distributed, sites)
    force = np.empty((count + 1, 3))
    force[-1] = load.tip_force
    force[:-1] = force[-1] + h * np.cumsum(_simpson(weight)[::-1], axis=0)[::-1]
    nodal = h * force
    nodal[-1] = 0.5 * h * force[-1] + h * h / 12.0 * weight[-1]
    return RodArrays(
        step=h,
        force=force,
        nodal=nodal,
        distributed=np.ascontiguousarray(weight[::2]),
        tip_moment=np.asarray(load.tip_moment, dtype=np.float64),
        elements=np.ascontiguousarray(elements),
        stiffness=diagonal[::2],
        rest_strain=rest_strain[::2],
        rest_energy=0.5 * h * float(np.sum(_simpson(np.sum(moment * seen, axis=1)[:, None])))
        + h * h / 12.0 * float(weight[0, 0])
        - 0.5 * h * float(force[0, 0]),
        moment_scale=float(stiffness[:, 1].min()) / rod.length,
    )


def scalar_samples(field: str, profile: ScalarProfile, sites: Array) -> Array:
    """Return a positive profile's values at the sites (n,)."""
    if not callable(profile):
        return np.full(len(sites), float(profile))
    values = np.asarray(profile(sites), dtype=np.float64)
    if values.shape != sites.shape or not np.all(np.isfinite(values)) or not np.all(values > 0.0):
        raise InvalidInputError(
            field, values, f"a function giving {len(sites)} positive finite values"
        )
    return values


def vector_samples(field: str, profile: VectorProfile, sites: Array) -> Array:
    """Return a vector profile's values at the sites (n, 3)."""
    if not callable(profile):
        return np.tile(np.asarray(profile, dtype=np.float64), (len(sites), 1))
    values = np.asarray(profile(sites), dtype=np.float64)
    if values.shape != (len(sites), 3) or not np.all(np.isfinite(values)):
        raise InvalidInputError(
            field, values, f"a function giving finite values of shape ({len(sites)}, 3)"
        )
    return values


def floats(vector: Vector) -> Vector:
    """Return the components as floats: one signature for the compiled kernel."""
    return (float(vector[0]), float(vector[1]), float(vector[2]))


def _strain_scales(angles: Array) -> Array:
    """Return :func:`discrete_strain_scale` of each angle."""
    return np.array([discrete_strain_scale(float(angle)) for angle in angles])


def _simpson(samples: Array) -> Array:
    """Return the means over the elements (n, k) of samples at nodes and midpoints (2 n + 1, k)."""
    means: Array = (samples[:-2:2] + 4.0 * samples[1:-1:2] + samples[2::2]) / 6.0
    return means
