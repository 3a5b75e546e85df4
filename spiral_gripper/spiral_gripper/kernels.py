# SPDX-License-Identifier: Apache-2.0
"""Compiling every numerical kernel once, and whether that has been done.

What the steps need is imported in them: a node that starts only looks for the note.
"""

from __future__ import annotations

import hashlib
import math
import os
import sys
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path
from typing import Final

import spiral_core
from spiral_core import Section
from spiral_core.numerics.kernel import KERNEL_FILES, SOURCE_DIGEST, processor_features


def compile_rods_and_wraps() -> None:
    """Compile the kernels of rods and of wraps, by solving small problems."""
    from spiral_core import Rod, RodLoad, WrapCurve, find_equilibria, solve_rod
    from spiral_core.rod.path import follow_path
    from spiral_gripper.files.description import load_gripper

    load = RodLoad(distributed=(0.24, 0.0, 0.0))
    uniform = [
        Rod(0.3, Section.inextensible(3e-4, 2e-4), rest_strain=(-0.5 * bend, 0.0, bend))
        for bend in (5.0, 10.0)
    ]
    follow_path(uniform, load)
    find_equilibria(uniform[0], load, starts=2)
    varying = Rod(
        0.3, Section.varying(lambda s: 3e-4 * (1.0 + s), 2e-4), rest_strain=(-5.0, 0.0, 10.0)
    )
    for rod in (uniform[0], varying):
        solve_rod(rod, load, start=solve_rod(rod, load))
    curve = WrapCurve(load_gripper("paper_design_70"))
    radius = math.sqrt(curve.radius_min * curve.radius_max)
    pressure = curve.wrap_for_radius(radius).pressure
    curve.regime(pressure, radius, curve.state_at_pressure(pressure))


def compile_contacts() -> None:
    """Compile the kernels of contact and motion: a rod on a floor with friction."""
    from spiral_core import (
        Inertia,
        Obstacle,
        Plane,
        Rod,
        RodLoad,
        RodProblem,
        Section,
        solve_motion,
        vibration_modes,
    )
    from spiral_core.rod.contact.solve import solve_contact

    rod = Rod(0.3, Section((2e-4, 3e-4, 3e-4)), radius=5e-3)
    floor = Obstacle(Plane(), position=(0.0, 0.0, -0.02), friction=0.5)
    hanging = RodProblem(rod, RodLoad(distributed=(0.0, 0.0, -0.28)), obstacles=(floor,))
    state = solve_contact(hanging, elements=8)
    solve_contact(hanging, start=state.positions, elements=8)
    inertia = Inertia(mass=0.0285, rotary=3e-7)
    solve_motion(lambda time: hanging, inertia, (0.0, 0.01), start=state)
    vibration_modes(solve_contact(RodProblem(rod), elements=8), inertia)


# They share small kernels only, so that two processes may take one each.
STEPS: Final = (compile_rods_and_wraps, compile_contacts)


def compile_kernels(processes: int = 1) -> None:
    """Compile all kernels that are not cached, and note that it has been done."""
    if processes > 1:
        with ProcessPoolExecutor(processes) as pool:
            for future in [pool.submit(step) for step in STEPS]:
                future.result()
    else:
        for step in STEPS:
            step()
    for note in _notes():
        with suppress(OSError):
            note.parent.mkdir(parents=True, exist_ok=True)
            note.touch()
            return


def kernels_are_compiled() -> bool:
    """Return whether :func:`compile_kernels` has run with these sources, numba and computer."""
    return any(note.exists() for note in _notes())


def _notes() -> tuple[Path, ...]:
    """Return where the note may be, beside the cached kernels or in the user's cache.

    Its name is a digest of what the kernels depend on.
    """
    package = Path(str(spiral_core.__file__)).parent
    processor = (os.environ.get("NUMBA_CPU_NAME"), processor_features())
    times = [path.stat().st_mtime_ns for path in KERNEL_FILES]  # numba looks at them too
    state = repr(
        (str(package), SOURCE_DIGEST, times, version("numba"), sys.version_info, processor)
    )
    name = f"spiral_kernels_{hashlib.sha256(state.encode()).hexdigest()[:16]}"
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    folders = [Path(chosen)] if chosen else [package / "__pycache__", Path("~/.cache/numba")]
    return tuple(folder.expanduser() / name for folder in folders)
