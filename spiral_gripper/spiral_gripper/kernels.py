# SPDX-License-Identifier: Apache-2.0
"""Compiling every numerical kernel once, and whether that has been done."""

from __future__ import annotations

import hashlib
import math
import os
import sys
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path

import spiral_core as core
from spiral_core.numerics.kernel import KERNEL_FILES, SOURCE_DIGEST, processor_features


def compile_rods_and_wraps() -> None:
    """Compile the kernels of rods and of wraps, by solving small problems."""
    from spiral_gripper.files.description import load_gripper  # a node that starts needs no files

    load, rest = core.RodLoad(distributed=(0.24, 0.0, 0.0)), (-5.0, 0.0, 10.0)
    sections = core.Section.inextensible(3e-4, 2e-4), core.Section.inextensible(3e-4, 1e-4)
    uniform = [core.Rod(0.3, section, rest_strain=rest) for section in sections]
    core.follow_rod([core.RodProblem(rod, load) for rod in uniform])
    core.find_equilibria(uniform[0], load, starts=2)
    varying = core.Section.varying(lambda s: 3e-4 * (1.0 + s), 2e-4)
    for rod in (uniform[0], core.Rod(0.3, varying, rest_strain=rest)):
        core.solve_rod(rod, load, start=core.solve_rod(rod, load))
    curve = core.WrapCurve(load_gripper("paper_design_70"))
    radius = math.sqrt(curve.radius_min * curve.radius_max)
    pressure = curve.wrap_for_radius(radius).pressure
    curve.regime(pressure, radius, curve.state_at_pressure(pressure))


def compile_contacts() -> None:
    """Compile the kernels of contact and motion: a rod on a floor with friction."""
    rod = core.Rod(0.3, core.Section((2e-4, 3e-4, 3e-4)), radius=5e-3)
    floor = core.Obstacle(core.Plane(), position=(0.0, 0.0, -0.02), friction=0.5)
    load = core.RodLoad(distributed=(0.0, 0.0, -0.28))
    hanging = core.RodProblem(rod, load, obstacles=(floor,))
    state = core.solve_rod(hanging, elements=8)
    core.solve_rod(hanging, start=state.positions, elements=8)
    core.Cone(0.01, 0.1).distance(state.positions)
    inertia = core.Inertia(mass=0.0285, rotary=3e-7)
    core.solve_motion(lambda time: hanging, inertia, (0.0, 0.01), start=state)
    core.vibration_modes(core.solve_rod(rod, elements=8), inertia)


# They share small kernels only, so that two processes may take one each.
STEPS = (compile_rods_and_wraps, compile_contacts)


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

    Its name is a digest of what the kernels depend on; numba looks at the files' times too.
    """
    package = Path(str(core.__file__)).parent
    times = [path.stat().st_mtime_ns for path in KERNEL_FILES]
    processor = (os.environ.get("NUMBA_CPU_NAME"), processor_features())
    versions = (version("numba"), sys.version_info)
    state = repr((str(package), SOURCE_DIGEST, times, versions, processor))
    name = f"spiral_kernels_{hashlib.sha256(state.encode()).hexdigest()[:16]}"
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    folders = [Path(chosen)] if chosen else [package / "__pycache__", Path("~/.cache/numba")]
    return tuple(folder.expanduser() / name for folder in folders)
