# SPDX-License-Identifier: Apache-2.0
"""Properties that vary along a rod: their values, checked, and the jumps that nobody declared."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from spiral_core.errors import InvalidInputError
from spiral_core.message import Message, Quantity
from spiral_core.rod.types import (
    Array,
    Rod,
    RodLoad,
    Section,
    Vector,
    VectorProfile,
    as_floats,
    positive_definite,
)

# Where the four numbers of a section stand in its stiffness matrix.
ROWS, COLUMNS = (0, 1, 2, 0), (0, 1, 2, 2)
# Values at the ends of a piece are taken this far inside [of the rod's length]: what a profile says
# at a break itself, and how the break's place was rounded, do not matter then.
INSET = 1e-10
# Sites in a piece at which a profile is looked at first. A feature narrower than their distance
# may pass unseen.
SURVEY_SITES = 257
# The intervals between them where a jump is most likely are divided again and again, each time into
# as many parts, the part of the largest change kept.
SUSPECTS = 16
PARTS = 16
DIVISIONS = 6
# What then changes by more than this fraction of the profile's largest value is a jump.
SMALLEST_JUMP = 1e-6


class UniformRod(NamedTuple):
    """A uniform rod and its load, as numbers.

    Attributes:
        length: [m].
        torsional: GJ [N m^2].
        bending: EI about z [N m^2].
        sideways: EI about y [N m^2].
        coupling: of twist and bending about z [N m^2].
        rest_strain: u* [1/m].
        weight: load per length, base frame [N/m].
        tip_force: base frame [N].
        tip_moment: base frame [N m].
    """

    length: float
    torsional: float
    bending: float
    sideways: float
    coupling: float
    rest_strain: Vector
    weight: Vector
    tip_force: Vector
    tip_moment: Vector


def varies(rod: Rod, load: RodLoad) -> bool:
    """Return whether a property is a function, or breaks divide the rod."""
    return (
        callable(rod.section)
        or callable(rod.rest_strain)
        or callable(load.distributed)
        or bool(rod.breaks)
    )


def pieces(rod: Rod) -> list[tuple[float, float]]:
    """Return where each piece between two breaks begins and ends [m]."""
    ends = (0.0, *rod.breaks, rod.length)
    return list(pairwise(ends))


def sites_in(rod: Rod, piece: tuple[float, float]) -> Array:
    """Return evenly spaced sites from end to end of a piece, the ends just inside."""
    sites = np.linspace(*piece, SURVEY_SITES)
    inset = INSET * rod.length
    sites[0] += inset if piece[0] > 0.0 else 0.0
    sites[-1] -= inset if piece[1] < rod.length else 0.0
    return sites


def section_samples(rod: Rod, sites: Array) -> Array:
    """Return a rod's stiffness matrices at the sites: (n, 3, 3) or (n, 6, 6).

    Raises:
        InvalidInputError: its function gives another shape, or what is not positive definite.
    """
    if isinstance(rod.section, Section):
        return np.tile(rod.section.matrix, (len(sites), 1, 1))
    given = rod.section(sites)
    values = as_floats(given)
    shapes = ((3,), (3, 3), (6, 6))
    if values.shape not in [(len(sites), *one) for one in shapes] or not positive_definite(values):
        requirement = (
            f"a function giving finite positive definite stiffness ({len(sites)}, 3), "
            f"({len(sites)}, 3, 3) or ({len(sites)}, 6, 6)"
        )
        raise InvalidInputError("section", given, requirement)
    return values[:, :, None] * np.eye(3) if values.ndim == 2 else values


def stiffness_samples(rod: Rod, sites: Array) -> Array:
    """Return the four stiffnesses of a rod's section at the sites (n, 4), in the kernels' order.

    Twist, bending about y and about z, and what couples twist with bending about z.

    Raises:
        InvalidInputError: the section is not valid, or has stiffnesses that are none of these.
    """
    four: Array = section_samples(rod, sites)[:, ROWS, COLUMNS]
    return four


def vector_samples(field: str, profile: VectorProfile, sites: Array) -> Array:
    """Return a vector profile's values at the sites (n, 3)."""
    if not callable(profile):
        return np.tile(np.asarray(profile, dtype=np.float64), (len(sites), 1))
    values = as_floats(profile(sites))
    if values.shape != (len(sites), 3) or not np.all(np.isfinite(values)):
        raise InvalidInputError(
            field, values, f"a function giving finite values of shape ({len(sites)}, 3)"
        )
    return values


def is_plain(rod: Rod) -> bool:
    """Return whether a rod neither stretches nor shears, and couples twist with one bending."""
    if isinstance(rod.section, Section):
        return rod.section.plain
    values = section_samples(rod, np.linspace(0.0, rod.length, SURVEY_SITES))
    return values.shape[1] == 3 and not values[:, 1, (0, 2)].any()


def require_plain(rod: Rod) -> None:
    """Raise unless the inextensible element can take the rod's section and radius."""
    if rod.radius > 0.0:
        requirement = "0: the inextensible element sees no contact; solve_rod takes others"
        raise InvalidInputError("radius", rod.radius, requirement)
    if not is_plain(rod):
        requirement = "inextensible, without coupling of bending about y; solve_rod takes others"
        raise InvalidInputError("section", rod.section, requirement)


def require_continuous(rod: Rod, load: RodLoad) -> None:
    """Raise if a property jumps anywhere but at the rod's breaks.

    Raises:
        InvalidInputError: it does, or its values are not valid; names the property and the place.
    """
    samplers: dict[str, Callable[[Array], Array]] = {}
    if callable(rod.section):
        samplers["section"] = partial(section_samples, rod)
    for field, profile in (("rest_strain", rod.rest_strain), ("distributed", load.distributed)):
        if callable(profile):
            samplers[field] = partial(vector_samples, field, profile)
    for field, sample in samplers.items():

        def values(sites: Array, sample: Callable[[Array], Array] = sample) -> Array:
            return sample(sites).reshape(len(sites), -1)

        for piece in pieces(rod):
            place = jump(values, sites_in(rod, piece))
            if place is not None:
                raise InvalidInputError(
                    field,
                    Message("a jump at {}", Quantity(place, "m")),
                    "continuous between breaks; name the place of the jump in the rod's breaks",
                )


def jump(profile: Callable[[Array], Array], sites: Array) -> float | None:
    """Return where a profile, giving (n, k) for sites (n,), jumps; None if nothing was found.

    Example:
        >>> place = jump(lambda s: np.where(s < 0.3, 1.0, 2.0)[:, None], np.linspace(0.0, 1.0, 65))
        >>> round(place, 6)
        0.3
        >>> jump(lambda s: np.sin(30.0 * s)[:, None], np.linspace(0.0, 1.0, 65)) is None
        True
    """
    values = profile(sites)
    scale = float(np.abs(values).max())
    change = np.diff(values, axis=0)
    beside = np.vstack((change[1:2], change, change[-2:-1]))
    unusual = np.abs(change - 0.5 * (beside[:-2] + beside[2:])).max(axis=1)
    suspects = np.argsort(unusual)[-SUSPECTS:]
    low, high = sites[suspects], sites[suspects + 1]
    rows = np.arange(len(suspects))
    sizes = np.zeros(len(suspects))
    for _ in range(DIVISIONS):
        parts = np.linspace(low, high, PARTS + 1, axis=1)
        steps = np.diff(profile(parts.ravel()).reshape(*parts.shape, -1), axis=1)
        steps = np.abs(steps).max(axis=2)
        largest = steps.argmax(axis=1)
        low, high = parts[rows, largest], parts[rows, largest + 1]
        sizes = steps[rows, largest]
    worst = int(sizes.argmax())
    return float(0.5 * (low + high)[worst]) if sizes[worst] > SMALLEST_JUMP * scale else None


def uniform_rod(rod: Rod, load: RodLoad) -> UniformRod:
    """Return what describes a uniform rod and its load to the kernels."""
    section, rest, weight = rod.section, rod.rest_strain, load.distributed
    if callable(section) or callable(rest) or callable(weight):
        raise TypeError("a rod that varies is not described by numbers")
    torsional, sideways, bending, coupling = section.numbers
    return UniformRod(
        float(rod.length),
        torsional,
        bending,
        sideways,
        coupling,
        rest,
        weight,
        load.tip_force,
        load.tip_moment,
    )
