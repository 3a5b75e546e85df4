# SPDX-License-Identifier: Apache-2.0
"""How many elements a rod needs, piece by piece between its breaks, and the system on them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple, TypeAlias

import numpy as np

from spiral_core.errors import InvalidInputError
from spiral_core.numerics.kernel import compiled
from spiral_core.rod._element import Elements
from spiral_core.rod._profiles import (
    COLUMNS,
    ROWS,
    pieces,
    section_samples,
    sites_in,
    stiffness_samples,
    uniform_rod,
    varies,
    vector_samples,
)
from spiral_core.rod._system import System, discrete_strain_scale, uniform_system
from spiral_core.rod.types import MAX_ELEMENTS, Array, Rod, RodLoad, Section, section_parts

# Elements in each piece of a rod.
Counts: TypeAlias = tuple[int, ...]
# Elements are chosen so that one turns by at most this angle [rad], at rest and where the load
# bends it; measured, the tip's error is then 3e-6 of the length in the median, 3e-5 at worst.
ELEMENT_ANGLE = 0.25
FEWEST_ELEMENTS = 24
# So little more than a whole number of elements [elements], or than an angle [of it], is rounding.
ROUNDING = 1e-9
# A section that resists torsion and bending unequally turns strain into strain of another kind at
# the rate of the strain times the root of the stiffnesses' ratio; these fractions of it count,
# where torsion is the softer and where it is the stiffer; measured.
SOFT_COUPLING = 0.4
STIFF_COUPLING = 0.2
# The loading path is followed on this many elements at the least, and with at most this angle in
# one at its end [rad].
PATH_ELEMENTS = 24
PATH_ANGLE = 0.6
# An element that turns by more than this at rest [rad] may as well turn the other way round.
LARGEST_REST_TURN = 2.0


def element_counts(rod: Rod, load: RodLoad, angle: float = ELEMENT_ANGLE) -> Counts:
    r"""Return how many elements of each piece turn by at most ``angle`` [rad]; even numbers.

    The strain of a loaded rod varies along it at the rate of :math:`|u^*|`, of
    :math:`\sqrt{F/EI}`, of :math:`|M|/EI` and, where bending and torsional stiffness are far
    apart, of :math:`m/\sqrt{EI\,GJ}` with the largest internal moment :math:`m`, or, if torsion is
    the stiffer, of the curvature times :math:`\sqrt{GJ/EI}`.

    Raises:
        InvalidInputError: a profile is not valid, or it would be more than ``MAX_ELEMENTS``.
    """
    angles = piece_angles(rod, load)
    needed = sum(angles) / angle
    if not needed <= MAX_ELEMENTS - 2 * len(angles):
        requirement = f"at most {MAX_ELEMENTS} for a rod and its load; are they in SI units?"
        raise InvalidInputError("elements", needed, requirement)
    counts = []
    for (begin, end), turned in zip(pieces(rod), angles, strict=True):
        fewest = FEWEST_ELEMENTS * (end - begin) / rod.length
        count = math.ceil(max(turned / angle, fewest) - ROUNDING)
        counts.append(max(2, count + count % 2))
    return tuple(counts)


def element_count(rod: Rod, load: RodLoad, angle: float = ELEMENT_ANGLE) -> int:
    """Return how many elements :func:`element_counts` gives in all."""
    return sum(element_counts(rod, load, angle))


def piece_angles(rod: Rod, load: RodLoad) -> list[float]:
    """Return by how much each piece turns [rad], at rest or where the load bends it."""
    uniform = not varies(rod, load)
    sampled = []
    for piece in pieces(rod):
        sites = np.zeros(1) if uniform else sites_in(rod, piece)
        softest, farthest = principal_stiffnesses(*stiffness_samples(rod, sites).T)
        strains = vector_samples("rest_strain", rod.rest_strain, sites)
        weights = vector_samples("distributed", load.distributed, sites)
        with np.errstate(over="ignore"):
            curvature = np.linalg.norm(strains, axis=1).max()
            weight = np.linalg.norm(weights, axis=1).max()
        ends = float(softest.min()), float(farthest.min())
        sampled.append((*ends, float(curvature), float(weight)))
    heaviest = max(weight for *_, weight in sampled)
    force = heaviest * rod.length + math.hypot(*load.tip_force)
    moment = math.hypot(*load.tip_moment)
    angles = []
    for (begin, end), (bending, torsional, curvature, _) in zip(pieces(rod), sampled, strict=True):
        bent = math.sqrt(force / bending)
        strain = curvature + bent
        if torsional < bending:
            inner = min(force * rod.length + moment, bending * strain + moment)
            coupled = SOFT_COUPLING * inner / math.sqrt(bending) / math.sqrt(torsional)
        else:
            coupled = STIFF_COUPLING * strain * math.sqrt(torsional / bending)
        rate = max(curvature, bent + moment / bending, coupled)
        angles.append((end - begin) * rate)
    return angles


def principal_stiffnesses(
    torsional: Array, sideways: Array, bending: Array, coupling: Array
) -> tuple[Array, Array]:
    """Return the softest bending of sections (n,), and the stiffness farthest from it.

    That is GJ where bending is alike in every direction and not coupled; otherwise the least or the
    largest of the section, whichever lies at the greater ratio to the softest bending.
    """
    if np.array_equal(sideways, bending) and not np.any(coupling):
        return bending, torsional
    softest = np.minimum(sideways, bending - coupling * coupling / torsional)
    mean, spread = 0.5 * (torsional + bending), np.hypot(0.5 * (torsional - bending), coupling)
    largest = np.maximum(mean + spread, sideways)
    least = (torsional * bending - coupling * coupling) / (mean + spread)
    return softest, np.where(softest / least > largest / softest, least, largest)


def shared_counts(rod: Rod, load: RodLoad, elements: object) -> Counts:
    """Return ``elements`` shared out to the pieces, at least one each.

    Raises:
        InvalidInputError: ``elements`` is not a whole number from 2, and from the number of pieces,
            to ``MAX_ELEMENTS``, or so few that one would turn too far at rest.
    """
    elements, least = least_counts(elements, rest_turns(rod))
    if not rod.breaks:
        return (elements,)
    wanted = np.array(element_counts(rod, load), dtype=np.float64)
    spare = elements - len(wanted)
    shares = spare * wanted / wanted.sum()
    counts = np.floor(shares).astype(int)
    for index in np.argsort(counts - shares, kind="stable")[: spare - int(counts.sum())]:
        counts[index] += 1
    counts = np.maximum(counts + 1, least)
    while counts.sum() > elements:
        counts[np.argmax(counts - least)] -= 1
    return tuple(counts.tolist())


def least_counts(elements: object, turns: Sequence[float]) -> tuple[int, list[int]]:
    """Return a number of elements, and the least in pieces that turn so far [rad] at rest.

    Raises:
        InvalidInputError: as :func:`shared_counts`.
    """
    fewest = max(2, len(turns))
    if type(elements) is not int or not fewest <= elements <= MAX_ELEMENTS:
        requirement = f"a whole number from {fewest} to {MAX_ELEMENTS}"
        raise InvalidInputError("elements", elements, requirement)
    needed = (min(turn / LARGEST_REST_TURN, MAX_ELEMENTS + 1) for turn in turns)
    least = [max(1, math.ceil(each)) for each in needed]
    if sum(least) > elements:
        requirement = f"at least {sum(least)}, for each to turn by 2 rad at most at rest"
        raise InvalidInputError("elements", elements, requirement)
    return elements, least


def path_count(count: int, turn: float, stiffer: float, share: float = 1.0) -> int:
    """Return how many of a piece's elements suffice to follow the loading path.

    The piece turns by ``turn`` [rad] at rest, its torsional stiffness is at most ``stiffer`` times
    the bending one, and it is a ``share`` of the rod's length.
    """
    angle = turn * max(1.0, STIFF_COUPLING * math.sqrt(stiffer))
    return math.ceil(min(count, max(PATH_ELEMENTS * share, angle / PATH_ANGLE)))


def path_counts(rod: Rod, counts: Counts) -> Counts:
    """Return how many of these elements suffice to follow the loading path."""
    each = []
    for piece, turn, count in zip(pieces(rod), rest_turns(rod), counts, strict=True):
        softest, farthest = principal_stiffnesses(*stiffness_samples(rod, sites_in(rod, piece)).T)
        stiffer = float((farthest / softest).max())
        each.append(path_count(count, turn, stiffer, (piece[1] - piece[0]) / rod.length))
    return tuple(each)


def rest_turns(rod: Rod) -> list[float]:
    """Return the largest angle [rad] by which each piece may turn at rest."""
    if not callable(rod.rest_strain):
        strain = math.hypot(*rod.rest_strain)
        return [strain * (end - begin) for begin, end in pieces(rod)]
    turns = []
    for piece in pieces(rod):
        strains = vector_samples("rest_strain", rod.rest_strain, sites_in(rod, piece))
        turns.append(float(np.linalg.norm(strains, axis=1).max()) * (piece[1] - piece[0]))
    return turns


# At breaks, where properties may jump, they are looked at this fraction of an element inside of it.
INSIDE = 1e-9


class Samples(NamedTuple):
    """A rod at the start, the middle and the end of each of N elements.

    Attributes:
        sites: (N, 3) arc lengths [m].
        stiffness: (N, 3, 3, 3) of twist and bending [N m^2].
        compliance: likewise, to the internal force [1/N].
        coupling: likewise, moment by the internal force [m].
        rest: (N, 3, 3) rest strain u* [1/m].
        seen: likewise, as an element of one strain sees it.
    """

    sites: Array
    stiffness: Array
    compliance: Array
    coupling: Array
    rest: Array
    seen: Array

    @property
    def moment(self) -> Array:
        """K times the rest strain that an element sees (N, 3, 3) [N m]."""
        moment: Array = np.einsum("nkij,nkj->nki", self.stiffness, self.seen)
        return moment

    def rest_energy(self, steps: Array) -> float:
        """Return the energy without strain [J] of elements of lengths (N,) [m]."""
        density = np.einsum("nki,nki->nk", self.moment, self.seen)
        return 0.5 * float(steps @ mean_of(density))


def sampled(rod: Rod, nodes: Array) -> Samples:
    """Return what describes a rod on elements that end at the nodes (N + 1,) [m].

    Raises:
        InvalidInputError: a profile's values have the wrong shape, are not finite or not positive,
            or an element turns too far at rest.
    """
    steps = np.diff(nodes)
    apart = np.abs(nodes[:, None] - np.array(rod.breaks))
    jumps = np.any(apart <= INSIDE * rod.length, axis=1)
    start, end = nodes[:-1] + INSIDE * steps * jumps[:-1], nodes[1:] - INSIDE * steps * jumps[1:]
    sites = np.stack((start, nodes[:-1] + 0.5 * steps, end), axis=1)
    if isinstance(rod.section, Section):
        parts = [np.tile(part, (sites.size, 1, 1)) for part in rod.section.parts]
    else:
        parts = [*section_parts(section_samples(rod, sites.ravel()))]
    stiffness, compliance, coupling = (part.reshape(-1, 3, 3, 3) for part in parts)
    rest = vector_samples("rest_strain", rod.rest_strain, sites.ravel()).reshape(-1, 3, 3)
    angles = steps[:, None] * np.sqrt(np.sum(rest * rest, axis=2))
    if not angles.max() <= LARGEST_REST_TURN * (1.0 + ROUNDING):
        fewest = min(len(steps) * angles.max() / LARGEST_REST_TURN, MAX_ELEMENTS + 1)
        requirement = f"at least {math.ceil(fewest)}, for each to turn by 2 rad at most at rest"
        raise InvalidInputError("elements", len(steps), requirement)
    seen = rest * strain_scales(angles)[:, :, None]
    return Samples(sites, stiffness, compliance, coupling, rest, seen)


@compiled
def strain_scales(angles: Array) -> Array:
    """Return by what factors elements see strains that turn them by the angles (n, 3) [rad]."""
    scales = np.empty_like(angles)
    for e in range(len(angles)):
        for k in range(3):
            scales[e, k] = discrete_strain_scale(angles[e, k])
    return scales


def mean_of(samples: Array) -> Array:
    """Return the means over elements of samples at start, middle and end (N, 3, ...)."""
    mean: Array = (samples[:, 0] + 4.0 * samples[:, 1] + samples[:, 2]) / 6.0
    return mean


def slope_of(samples: Array, steps: Array) -> Array:
    """Return the slopes between the ends of elements of lengths (N,) [m]."""
    return np.ascontiguousarray(((samples[:, 2] - samples[:, 0]).T / steps).T)


def even_nodes(ends: Sequence[float], counts: Counts) -> Array:
    """Return the nodes' arc lengths, even in each piece between the ends [m]."""
    pairs = zip(pairwise(ends), counts, strict=True)
    parts = [np.linspace(a, b, count, endpoint=False) for (a, b), count in pairs]
    return np.append(np.concatenate(parts), ends[-1])


def discretize(rod: Rod, load: RodLoad, counts: Counts) -> System:
    """Return a rod and its load on ``counts`` elements in each piece; raises as :func:`sampled`."""
    if not varies(rod, load):
        return uniform_system(sum(counts), uniform_rod(rod, load))
    nodes = even_nodes((0.0, *rod.breaks, rod.length), counts)
    steps, at = np.diff(nodes), sampled(rod, nodes)
    weight = vector_samples("distributed", load.distributed, at.sites.ravel()).reshape(-1, 3, 3)
    force = np.empty((len(nodes), 3))
    force[-1] = load.tip_force
    force[:-1] = force[-1] + np.cumsum((steps[:, None] * mean_of(weight))[::-1], axis=0)[::-1]
    # Kernels are compiled anew for arrays of another layout.
    stiffness = np.ascontiguousarray(at.stiffness[:, :, ROWS, COLUMNS])
    moment = at.moment
    unseen = np.einsum("nkij,nkj->nki", at.stiffness, at.rest)
    return System(
        force=force,
        load_start=weight[:, 0].copy(),
        load_end=weight[:, 2].copy(),
        tip_moment=np.array(load.tip_moment, dtype=np.float64),
        elements=Elements(
            *(mean_of(part) for part in (stiffness, moment)),
            *(slope_of(part, steps) for part in (stiffness, moment)),
        ),
        steps=steps,
        node_stiffness=np.concatenate((stiffness[:, 0], stiffness[-1:, 2])),
        node_rest=np.concatenate((unseen[:, 0], unseen[-1:, 2])),
        rest_energy=at.rest_energy(steps),
    )
