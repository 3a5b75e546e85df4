# SPDX-License-Identifier: Apache-2.0
"""Compile the numerical kernels once: python packaging/compile_kernels.py.

Each solver is called on a small problem. Tests that run in parallel would otherwise compile the
same kernels several times, and a first user would wait. Rods and wraps are compiled beside contacts
and motion, which share only small kernels with them.
"""

import math
from concurrent.futures import ProcessPoolExecutor

from spiral_core import (
    ContactProblem,
    ElasticRod,
    Inertia,
    Obstacle,
    Plane,
    Rod,
    RodLoad,
    Section,
    WrapCurve,
    find_equilibria,
    follow_path,
    solve_contact,
    solve_motion,
    solve_rod,
    vibration_modes,
)
from spiral_gripper import load_gripper


def rods() -> None:
    """Solve uniform rods and rods that vary."""
    load = RodLoad(distributed=(0.24, 0.0, 0.0))
    uniform = [Rod(0.3, 3e-4, 2e-4, (-0.5 * bend, 0.0, bend)) for bend in (5.0, 10.0)]
    follow_path(uniform, load)
    find_equilibria(uniform[0], load, starts=2)
    varying = Rod(0.3, lambda s: 3e-4 * (1.0 + s), 2e-4, (-5.0, 0.0, 10.0))
    for rod in (uniform[0], varying):
        solve_rod(rod, load, start=solve_rod(rod, load))


def wraps() -> None:
    """Plan a wrap, as the node does at its start."""
    curve = WrapCurve(load_gripper("paper_design_70"))
    radius = math.sqrt(curve.radius_min * curve.radius_max)
    pressure = curve.wrap_for_radius(radius).pressure
    curve.regime(pressure, radius, curve.state_at_pressure(pressure))


def contacts() -> None:
    """Solve a rod on a floor with friction, at rest and in motion."""
    rod = ElasticRod(0.3, Section((2e-4, 3e-4, 3e-4)), radius=5e-3)
    floor = Obstacle(Plane(), position=(0.0, 0.0, -0.02), friction=0.5)
    hanging = ContactProblem(rod, RodLoad(distributed=(0.0, 0.0, -0.28)), obstacles=(floor,))
    state = solve_contact(hanging, elements=8)
    solve_contact(hanging, start=state.positions, elements=8)
    inertia = Inertia(mass=0.0285, rotary=3e-7)
    solve_motion(lambda time: hanging, inertia, (0.0, 0.01), start=state)
    vibration_modes(solve_contact(ContactProblem(rod), elements=8), inertia)


def rods_and_wraps() -> None:
    """Solve rods, then plan a wrap, which needs the same kernels and a few more."""
    rods()
    wraps()


if __name__ == "__main__":
    with ProcessPoolExecutor(2) as processes:
        for step in [processes.submit(step) for step in (rods_and_wraps, contacts)]:
            step.result()
