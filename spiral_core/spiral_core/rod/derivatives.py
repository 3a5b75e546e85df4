# SPDX-License-Identifier: Apache-2.0
"""Derivatives of a static state by loads, base pose, rest strain, stiffness, obstacles, friction.

Derived in ``docs/derivations/derivatives.md``: the state's equations are linearized and solved for
all parameters at once.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dgbsv

from spiral_core.brief import brief_repr
from spiral_core.errors import InvalidInputError
from spiral_core.rod._algebra import matrices
from spiral_core.rod._derivatives import band_of, element_columns, free_differences
from spiral_core.rod._profiles import UniformRod
from spiral_core.rod._system import uniform_system
from spiral_core.rod.contact._contact import STICK_SLIPS, Contacts, Law, contact_terms, no_touch
from spiral_core.rod.contact._continuation import Point
from spiral_core.rod.contact._mesh import last_slip
from spiral_core.rod.contact._newton import assemble, load_terms, no_elements
from spiral_core.rod.state import RodState
from spiral_core.rod.types import DEFAULT_TOLERANCE, Array
from spiral_core.validation import require_kind

# A state is known to the solver's tolerance over its smallest pivot [rad]: where that is larger
# than this, it is next to a fold, or nothing resists one of its motions.
LARGEST_DOUBT = 1e-2
# Obstacles that press on one node resist each other where so little of a normal is its own.
DEPENDENT = 1e-6
# Half the step of differences, as a fraction of the scales of the state, far from folds: what is
# not linear or quadratic leaves its square.
STEP = 1e-5
# Parameters and the number of their components, in the order of a change; those after the base's
# for each obstacle.
COMPONENTS = {
    "distributed": 3, "rest_strain": 3, "stiffness": 6, "length": 1, "tip_force": 3,
    "tip_moment": 3, "base_position": 3, "base_rotation": 3, "obstacle_position": 3,
    "obstacle_radius": 1, "friction": 1,
}  # fmt: skip
OWN = 25  # components but for those of obstacles


@dataclass(frozen=True, slots=True, eq=False)
class StateDerivatives:
    """How a state changes; arrays run over the k components of the parameters first.

    Args:
        columns: where the components of each parameter are in the arrays, by its name.
        positions: (k, n, 3) of the nodes, base frame [m].
        rotations: (k, n, 3) rotation vectors of the sections, base frame [rad].
        base_reaction: (k, 6) force [N] and moment about the base [N m], base frame.
        contact_forces: (k, n, 3) of all obstacles on each node, base frame [N].
        bounded: whether the derivatives exist. At a fold, where nothing resists a motion, or where
            obstacles press on one node against each other or side by side, they grow without bound:
            all of them are infinite.
        smallest_pivot: of the state, as a fraction of EI/L; zero at a fold.
        margins: how near the contacts are to changing their kind. ``gap``: smallest gap of a node
            that does not touch, of the length. ``force``: smallest normal force, of its obstacle's
            largest. ``stick``: distance of friction from its cone, of the cone. ``slip``: of a
            sliding node in the last increment, beyond the largest elastic one, of that. Infinite
            where there are none.
    """

    __repr__ = brief_repr

    columns: dict[str, slice]
    positions: Array
    rotations: Array
    base_reaction: Array
    contact_forces: Array
    bounded: bool
    smallest_pivot: float
    margins: dict[str, float]


def differentiate(state: RodState, parameters: Sequence[str] | None = None) -> StateDerivatives:
    r"""Return how a static state changes with its loads, base, rod and obstacles.

    .. math:: \frac{\partial F}{\partial x} \frac{dx}{d\theta} = -\frac{\partial F}{\partial \theta}

    with F the equations that the state x solves; no new solve. Nodes that touch, stick or slide go
    on to; friction is that of the state's last increment, whose anchors go with their obstacle.

    The parameters; loads are dead, vectors in the base frame:

    - ``distributed`` (3 components): added along the whole rod [N/m]; ``tip_force`` (3) [N];
      ``tip_moment`` (3) [N m].
    - ``rest_strain`` (3): added along the whole rod: twist, bending about y and about z [1/m].
    - ``stiffness`` (6): of twist, bending about y and z, stretch, shear in y and z, each relative;
      moduli that are coupled keep their correlation.
    - ``length`` (1): relative; everything per length stays, breaks and point loads keep their
      fractions of the length.
    - ``base_position`` (3) [m], ``base_rotation`` (3) about the base [rad], not of a guided one;
      loads, obstacles and tip stay.
    - ``obstacle_position`` (3 m) [m], ``obstacle_radius`` (m): of a surface moved towards the rod
      [m], as by a larger radius or, around the rod, a smaller one; ``friction`` (m), where there is
      some.

    Args:
        state: a converged one, of either element, at rest: not one of a motion.
        parameters: which; None takes all that the state has.

    Raises:
        InvalidInputError: not a stable state at rest, or a parameter that it does not have.

    Example:
        >>> from spiral_core import Rod, RodLoad, Section, solve_rod
        >>> rod = Rod(0.2, Section.inextensible(1e-3, 1e-3))
        >>> found = differentiate(solve_rod(rod, RodLoad()), ("tip_force",))
        >>> deflection = found.positions[1, -1, 1]  # by the force along y: L^3 / 3 EI
        >>> round(float(deflection), 6), round(0.2**3 / 3e-3, 6)
        (2.666667, 2.666667)
    """
    require_kind("state", state, RodState)
    if not state.stable:
        raise InvalidInputError("state", state.status, "a stable state at rest")
    point, obstacles = state._point, len(state.gaps)
    sizes = [size * (obstacles if k > 7 else 1) for k, size in enumerate(COMPONENTS.values())]
    known = dict(zip(COMPONENTS, zip(np.cumsum([0, *sizes]), sizes, strict=False), strict=True))
    if point is not None and 0.0 < np.trace(point.arrays.end_free[0, 3:, 3:]) < 2.5:
        del known["base_rotation"]  # the line of a guided base would turn with it
    if point is None or not all(one.friction > 0.0 for one in point.arrays.obstacles):
        del known["friction"]
    known = {name: place for name, place in known.items() if place[1]}
    columns: dict[str, slice] = {}
    places: list[int] = []
    for name in known if parameters is None else parameters:
        if name not in known:
            raise InvalidInputError("parameters", name, f"of {', '.join(known)}")
        first, size = known[name]
        columns[name] = slice(len(places), len(places) + size)
        places += range(first, first + size)
    rows = np.eye(OWN + 5 * obstacles)[places]
    bounded = not state.neutral_modes and state.smallest_pivot * LARGEST_DOUBT > DEFAULT_TOLERANCE
    found = _free(state, rows) if point is None else _mixed(point, rows)
    bounded = bounded and not np.isnan(found[0]).any()
    moved, turned, reaction, forces = (np.where(bounded, one, math.inf) for one in found)
    pivot, margins = state.smallest_pivot, _margins(state)
    return StateDerivatives(columns, moved, turned, reaction, forces, bounded, pivot, margins)


def _margins(state: RodState) -> dict[str, float]:
    """Return how near the contacts are to changing their kind."""
    point = state._point
    if point is None:
        return dict.fromkeys(("gap", "force", "stick", "slip"), math.inf)
    found: dict[str, list[Array]] = {"gap": [], "force": [], "stick": [], "slip": []}
    contacts = point.solution.contacts
    for j, pressed in enumerate(state.normal_forces):
        on = contacts.active[j]
        found["gap"].append(contacts.gap[j, contacts.touchable & ~on] / state.arc_lengths[-1])
        found["force"].append(pressed[on] / (pressed.max() or 1.0))
        if contacts.friction[j] > 0.0:
            size = np.linalg.norm(contacts.touch.slip[j, on], axis=1)
            size /= STICK_SLIPS * last_slip(point.arrays)
            found["stick"].append((1.0 - size[size < 1.0]) ** 2)
            found["slip"].append(size[size >= 1.0] - 1.0)
    return {key: float(np.hstack([math.inf, *values]).min()) for key, values in found.items()}


def _pressed_twice(contacts: Contacts) -> bool:
    """Return whether obstacles press on a node in directions that depend on each other."""
    for node in np.flatnonzero(contacts.active.sum(axis=0) > 1):
        normals = contacts.normal[contacts.active[:, node], node]
        if len(normals) > 3 or np.linalg.svd(normals, compute_uv=False)[-1] < DEPENDENT:
            return True
    return False


def _free(state: RodState, rows: Array) -> tuple[Array, Array, Array, Array]:
    """Return the changes of positions, rotations, base reaction, contact forces: a free rod's."""
    data, nodes = state._data, len(state.positions)
    if data is None:
        raise InvalidInputError("state", data, "one that a solver returned")
    given = uniform_system(nodes - 1, data) if isinstance(data, UniformRod) else data
    steps = _steps(state.arc_lengths[-1], float(given.elements.stiffness[:, 1:3].min()))
    # Next to a fold Newton's step is linear only in what is small against the pivot.
    steps *= min(1.0, state.smallest_pivot) ** (2.0 / 3.0)
    turns, moved, base = free_differences(np.array(state.orientations), given, rows * steps)
    per = rows @ (1.0 / steps)
    shift, turn = rows[:, None, 19:22], rows[:, None, 22:25]
    positions = per[:, None, None] * moved + shift + np.cross(turn, state.positions)
    turns = np.einsum("nij,knj->kni", matrices(state.orientations), turns)
    base = np.cross(turn, state.base_reaction.reshape(2, 3)).reshape(-1, 6) - per[:, None] * base
    return positions, per[:, None, None] * turns + turn, base, np.zeros((len(rows), nodes, 3))


def _steps(length: float, bending: float, obstacles: int = 0) -> Array:
    """Return half the step of each component's difference."""
    force = bending / length**2
    sizes = [force / length] * 3 + [1.0 / length] * 3 + [1.0] * 7 + [force] * 3
    sizes += [force * length] * 3 + [length] * 3 + [1.0] * (3 + 5 * obstacles)
    return STEP * np.array(sizes)


def _mixed(point: Point, rows: Array) -> tuple[Array, Array, Array, Array]:
    """Return the changes of positions, rotations, base reaction, contact forces."""
    arrays, x, contacts = point.arrays, point.x, point.solution.contacts
    count, obstacles, total = arrays.count, len(arrays.obstacles), len(rows)
    steps, turn, ratio = np.diff(arrays.arc_lengths), matrices(x.q), rows[:, 12, None, None]
    found, loads = no_elements(count), load_terms(arrays, x)
    assemble(x, arrays.elements, found)
    active = contacts.active
    at = np.concatenate(([0], np.cumsum(9 + active.sum(axis=0))))[:-1]
    size, width = int(at[-1]) + 6 + int(active[:, -1].sum()), int(np.diff(at).max()) + 5
    nodes, inside = at[:, None] + np.arange(6), at[1:, None] - 3 + np.arange(3)
    pressed = at + 6 + np.cumsum(active, axis=0) - active

    # What the parameters add to the equations of elements and nodes.
    changes = _steps(arrays.length, arrays.bending, obstacles)
    columns = element_columns(x, arrays.elements, rows * changes)
    columns /= (rows @ changes)[:, None, None]
    by_node = np.zeros((total, count + 1, 6))
    by_node[:, -1] = -np.hstack((rows[:, 16:19] @ turn[-1], rows[:, 13:16]))
    load = 0.5 * steps[:, None] * rows[:, None, :3] + ratio * arrays.elements.half_load
    by_node[:, :-1] += np.dstack((columns[:, :, :3], ratio * arrays.growing - load))
    by_node[:, 1:] += np.dstack((columns[:, :, 3:6], -ratio * arrays.growing - load))

    # The contacts: each one's normal force is an unknown of its node.
    law = Law(True, 0.0, last_slip(arrays), 0.0, math.inf, True)
    loaded, tangent, pushes, by_gap = by_node.copy(), loads.tangent, [], []
    shifts, others = rows[:, OWN : OWN + 3 * obstacles], rows[:, OWN + 3 * obstacles :]
    again = contacts._replace(touch=no_touch(*active.shape))
    for j, (normal, obstacle) in enumerate(zip(contacts.normal, arrays.obstacles, strict=True)):
        own = loads._replace(tangent=np.zeros_like(tangent))
        contact_terms(law, again, x, point.anchors, j, own)
        heading = again.touch.heading[j]
        arm = -arrays.lever * np.cross(normal, heading)
        rub = np.hstack((np.einsum("nji,nj->ni", turn, arm), heading))
        shift = shifts[:, 3 * j : 3 * j + 3]
        by_node -= np.einsum("nij,kj->kni", own.tangent[:, :, 3:], shift)
        by_node += (others[:, obstacles + j, None] * x.normal[j] * active[j])[:, :, None] * rub
        tangent = tangent + own.tangent
        by_gap.append(-others[:, j, None] - shift @ normal.T)
        pushes.append(obstacle.friction * rub)
        pushes[j][:, 3:] -= normal
    band = band_of(at, found.hessians, tangent, width, size)
    rhs = np.zeros((size, total))
    rhs[nodes] = -by_node.transpose(1, 2, 0)
    rhs[inside] = -columns[:, :, 6:].transpose(1, 2, 0)
    every = zip(active, pressed, contacts.normal, pushes, by_gap, strict=True)
    for on, own, normal, push, gap in every:
        mine, them = own[on, None], nodes[on]
        band[2 * width + them - mine, mine] = push[on]
        band[2 * width + mine - them[:, 3:], them[:, 3:]] = normal[on]
        rhs[own[on]] = -gap[:, on].T

    # The ends as they are held, the base as it is moved.
    held = np.hstack((rows[:, 22:25] @ turn[0], rows[:, 19:22])).T
    for node, free in zip((0, -1), arrays.end_free, strict=True):
        mine = nodes[node]
        near = np.arange(at[1] + 6) if node == 0 else np.arange(at[-2], size)
        where = 2 * width + mine[:, None] - near, near
        band[where] = free @ band[where]
        band[2 * width + mine[:, None] - mine, mine] += np.eye(6) - free
        rhs[mine] = free @ rhs[mine] + (np.eye(6) - free) @ held * (node == 0)
    *_, solved, info = dgbsv(width, width, band, rhs, overwrite_ab=True, overwrite_b=True)
    if info > 0 or _pressed_twice(contacts):
        solved.fill(math.nan)
    step, forces = solved[nodes].transpose(2, 0, 1), solved[inside].transpose(2, 0, 1)
    # Forces at the nodes balance: what the elements and loads leave is a contact's or a hold's.
    left = loaded[:, :, 3:].copy()
    left[:, 1:] += forces
    left[:, :-1] -= forces
    ends = np.hstack((step[:, 0, :3], step[:, 1, :3], forces[:, 0]))
    moment = loaded[:, 0, :3] + ends @ found.hessians[0, :3].T
    moment += step[:, 0] @ loads.tangent[0, :3].T
    moment += 0.5 * np.cross(step[:, 0, :3], point.solution.gradient[0, :3])
    reaction = np.hstack((left[:, 0], moment @ turn[0].T))
    left[:, ~active.any(axis=0)] = 0.0
    return step[:, :, 3:], np.einsum("nij,knj->kni", turn, step[:, :, :3]), reaction, left
