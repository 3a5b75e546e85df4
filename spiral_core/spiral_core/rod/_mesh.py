# SPDX-License-Identifier: Apache-2.0
"""How many elements a rod needs, piece by piece between its breaks, and the system on them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np

from spiral_core.errors import InvalidInputError
from spiral_core.rod._element import Elements
from spiral_core.rod._profiles import (
    SURVEY_SITES,
    pieces,
    sites_in,
    stiffness_samples,
    uniform_rod,
    varies,
    vector_samples,
)
from spiral_core.rod._system import System, discrete_strain_scale, uniform_system
from spiral_core.rod.types import MAX_ELEMENTS, Array, Rod, RodLoad

# Elements in each piece of a rod.
Counts: TypeAlias = tuple[int, ...]
# Elements are chosen so that one turns by at most this angle [rad], at rest and where the load
# bends it; measured, the tip's error is then 3e-6 of the length in the median, 3e-5 at worst.
ELEMENT_ANGLE = 0.25
FEWEST_ELEMENTS = 24
# So little more than a whole number of elements [elements] is rounding.
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
PATH_SITES = 65
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
        sites = np.zeros(1) if uniform else sites_in(rod, piece, SURVEY_SITES)
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
            to ``MAX_ELEMENTS``.
    """
    fewest = max(2, len(rod.breaks) + 1)
    if type(elements) is not int or not fewest <= elements <= MAX_ELEMENTS:
        raise InvalidInputError(
            "elements", elements, f"a whole number from {fewest} to {MAX_ELEMENTS}"
        )
    turns = rest_turns(rod)
    if not sum(turns) <= LARGEST_REST_TURN * elements:
        fewest = math.ceil(sum(turns) / LARGEST_REST_TURN)
        raise InvalidInputError(
            "elements", elements, f"at least {fewest}, for each to turn by 2 rad at most at rest"
        )
    if not rod.breaks:
        return (elements,)
    wanted = np.array(element_counts(rod, load), dtype=np.float64)
    spare = elements - len(wanted)
    shares = spare * wanted / wanted.sum()
    counts = np.floor(shares).astype(int)
    for index in np.argsort(counts - shares, kind="stable")[: spare - int(counts.sum())]:
        counts[index] += 1
    return tuple(int(count) + 1 for count in counts)


def path_count(count: int, turn: float, stiffer: float, share: float = 1.0) -> int:
    """Return how many of a piece's elements suffice to follow the loading path.

    The piece turns by ``turn`` [rad] at rest, its torsional stiffness is at most ``stiffer`` times
    the bending one, and it is a ``share`` of the rod's length.
    """
    angle = turn * max(1.0, STIFF_COUPLING * math.sqrt(stiffer))
    return min(count, max(math.ceil(PATH_ELEMENTS * share), math.ceil(angle / PATH_ANGLE)))


def path_counts(rod: Rod, counts: Counts) -> Counts:
    """Return how many of these elements suffice to follow the loading path."""
    each = []
    for piece, turn, count in zip(pieces(rod), rest_turns(rod), counts, strict=True):
        sites = sites_in(rod, piece, PATH_SITES)
        softest, farthest = principal_stiffnesses(*stiffness_samples(rod, sites).T)
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
        sites = sites_in(rod, piece, PATH_SITES)
        strains = vector_samples("rest_strain", rod.rest_strain, sites)
        turns.append(float(np.linalg.norm(strains, axis=1).max()) * (piece[1] - piece[0]))
    return turns


# What the coupling adds to K u: the twist's share to bending about z, and the other way round.
COUPLED = np.array([1.0, 0.0, 1.0])


def discretize(rod: Rod, load: RodLoad, counts: Counts) -> System:
    """Return ``rod`` and ``load`` on ``counts`` elements in each piece.

    Raises:
        InvalidInputError: a profile's values have the wrong shape, are not finite or not positive.
    """
    if not varies(rod, load):
        return uniform_system(sum(counts), uniform_rod(rod, load))
    parts = [_piece(rod, load, *each) for each in zip(pieces(rod), counts, strict=True)]
    elements, steps, weights, stiffness, moments, energies = zip(*parts, strict=True)
    h, mean_weights = np.concatenate(steps), np.concatenate([_simpson(w) for w in weights])
    force = np.empty((len(h) + 1, 3))
    force[-1] = load.tip_force
    force[:-1] = force[-1] + np.cumsum((h[:, None] * mean_weights)[::-1], axis=0)[::-1]
    return System(
        force=force,
        load_start=np.concatenate([w[:-2:2] for w in weights]),
        load_end=np.concatenate([w[2::2] for w in weights]),
        tip_moment=np.array(load.tip_moment, dtype=np.float64),
        elements=Elements(*(np.concatenate(columns) for columns in zip(*elements, strict=True))),
        steps=h,
        node_stiffness=_nodal(stiffness),
        node_rest=_nodal(moments),
        rest_energy=math.fsum(energies),
    )


def _nodal(samples: Sequence[Array]) -> Array:
    """Return the values at the nodes (N + 1, k), of pieces' samples at nodes and midpoints."""
    return np.concatenate([part[:-1:2] for part in samples] + [samples[-1][-1:]])


def _piece(
    rod: Rod, load: RodLoad, piece: tuple[float, float], count: int
) -> tuple[Elements, Array, Array, Array, Array, float]:
    """Return one piece's elements, their steps (n,), its load, K, K u* and rest energy.

    Load (2 n + 1, 3), K (2 n + 1, 4) and K u* (2 n + 1, 3) are at nodes and midpoints; Simpson's
    means over elements keep the order.
    """
    h = (piece[1] - piece[0]) / count
    sites = sites_in(rod, piece, 2 * count + 1)
    stiffness = stiffness_samples(rod, sites)
    rest_strain = vector_samples("rest_strain", rod.rest_strain, sites)
    angles = h * np.sqrt(np.sum(rest_strain**2, axis=1))
    scales = np.array([discrete_strain_scale(float(angle)) for angle in angles])[:, None]
    moment = stiffness[:, :3] * rest_strain + stiffness[:, 3:] * COUPLED * rest_strain[:, ::-1]
    (mean, slope), (rest, rest_slope) = (
        (_simpson(part), np.diff(part[::2], axis=0) / h) for part in (stiffness, scales * moment)
    )
    density = np.sum(scales**2 * moment * rest_strain, axis=1)
    return (
        Elements(mean, rest, slope, rest_slope),
        np.full(count, h),
        vector_samples("distributed", load.distributed, sites),
        stiffness,
        moment,
        0.5 * h * float(np.sum(_simpson(density[:, None]))),
    )


def _simpson(samples: Array) -> Array:
    """Return the means over the elements (n, k) of samples at nodes and midpoints (2 n + 1, k)."""
    means: Array = (samples[:-2:2] + 4.0 * samples[1:-1:2] + samples[2::2]) / 6.0
    return means
