# SPDX-License-Identifier: Apache-2.0
"""The doctor's checks of the compiled kernels and of the gripper description files."""

from __future__ import annotations

import hashlib
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from spiral_gripper.doctor.checks import Check, Facts, Finding, Mark

SECTION = "Grippers"
# A first start compiles the solver: some 15 s, minutes on a slow and busy machine.
COMPILE_LIMIT = 600.0
# With this variable set, numba compiles nothing; the solver requires compiled functions.
NO_COMPILATION = "NUMBA_DISABLE_JIT"
# What the solver imports when it is first used; a test compares it with a start.
START_LOADS = (
    "spiral_core.rod.solve",
    "spiral_core.rod._arrays",
    "spiral_core.wrap._kernels",
)
_KERNELS = ("grippers.kernel_cache", "grippers.kernels")


def checks(facts: Facts) -> tuple[Check, ...]:
    """Return the checks of this table: the kernels, then each gripper."""
    if facts.gripper is None:
        from spiral_gripper.files.catalog import available_grippers

        names = available_grippers()
    else:
        names = (facts.gripper,)
    return (
        Check("grippers.kernel_cache", "kernel cache", check_cache),
        Check("grippers.kernels", "kernels", check_kernels, _KERNELS[:1], COMPILE_LIMIT),
        *(
            Check(f"grippers.{name}", Path(name).stem, partial(check_gripper, name), _KERNELS)
            for name in names
        ),
    )


@dataclass(frozen=True, slots=True)
class KernelCache:
    """The state of numba's cache of compiled kernels.

    Attributes:
        kernels: how many a start of the node needs.
        current: how many of them are kept, compiled from the code as it is now.
        folder: where they are kept.
    """

    kernels: int
    current: int
    folder: Path

    @classmethod
    def here(cls) -> KernelCache:
        """Return the state of this installation's cache."""
        kernels = list(_kernels())
        ready: set[str] = set()
        for kernel in reversed(kernels):  # those that call come after those that are called
            if kernel.py_func.__qualname__ not in ready and is_kept(kernel):
                add_called(kernel.py_func, ready)
        current = sum(kernel.py_func.__qualname__ in ready for kernel in kernels)
        return cls(len(kernels), current, Path(kernels[0].stats.cache_path))


def check_cache(facts: Facts, cache: KernelCache | None = None) -> Finding:
    """Check whether the kernels are compiled already, and where they are stored."""
    if facts.environ.get(NO_COMPILATION, "0") not in ("", "0"):
        text = f"{NO_COMPILATION} is set: the kernels cannot be compiled"
        return Finding(Mark.PROBLEM, text, "Remove it:", (f"unset {NO_COMPILATION}",))
    try:
        found = KernelCache.here() if cache is None else cache
    except RuntimeError as error:  # numba has found no folder that it may write to
        return Finding(
            Mark.PROBLEM,
            str(error),
            "The compiled kernels need a folder that can be written to:",
            (f"export NUMBA_CACHE_DIR={Path.home() / '.cache' / 'numba'}",),
        )
    if found.current == found.kernels:
        return Finding(Mark.OK, f"all {found.kernels} are compiled, in {found.folder}")
    state = "not compiled yet" if found.current == 0 else "not compiled yet or out of date"
    text = f"{found.kernels - found.current} of {found.kernels} are {state}"
    return Finding(Mark.INFO, f"{text}; compiling them now, once: some 15 s or more")


def check_kernels(facts: Facts) -> Finding:
    """Start the solver as a node does: load the kernels, and compile those that are missing."""
    del facts
    missing = KernelCache.here()
    start = time.monotonic()
    compile_kernels()
    return kernels_finding(time.monotonic() - start, missing, KernelCache.here())


def compile_kernels() -> None:
    """Compile every kernel that :class:`KernelCache` counts, where it is not kept."""
    from spiral_core.rod.path import follow_path
    from spiral_core.rod.solve import solve_rod
    from spiral_core.rod.types import Rod, RodLoad
    from spiral_core.wrap.curve import WrapCurve
    from spiral_gripper.files.catalog import available_grippers
    from spiral_gripper.files.description import load_gripper

    curve = WrapCurve(load_gripper(available_grippers()[0]))
    curve.wrap_for_radius(0.5 * (curve.radius_min + curve.radius_max))
    # Kernels of rods alone, uniform and not, which wraps do not use.
    load = RodLoad(distributed=(0.24, 0.0, 0.0))
    rods = [Rod(0.3, 3e-4, 2e-4, (-0.5 * bend, 0.0, bend)) for bend in (5.0, 10.0)]
    follow_path(rods, load)
    varying = Rod(0.3, lambda s: 3e-4 * (1.0 + s), 2e-4, (-5.0, 0.0, 10.0))
    for rod in (rods[0], varying):
        solve_rod(rod, load, start=solve_rod(rod, load))


def kernels_finding(elapsed: float, before: KernelCache, after: KernelCache) -> Finding:
    """Judge a start of the solver.

    Args:
        elapsed: how long it took [s].
        before: what was compiled before.
        after: what is compiled now.
    """
    if before.current == before.kernels:
        return Finding(Mark.OK, f"loaded in {elapsed:.1f} s")
    if after.current == after.kernels:
        return Finding(Mark.OK, f"compiled in {elapsed:.0f} s; from now on they are only loaded")
    return Finding(
        Mark.WARNING,
        f"compiled in {elapsed:.0f} s, but not kept in {after.folder}",
        "Every start will compile them again. Free disk space, or name another folder:",
        (f"export NUMBA_CACHE_DIR={Path.home() / '.cache' / 'numba'}",),
    )


def check_gripper(name: str, facts: Facts) -> Finding:
    """Check whether a gripper description is valid and its gripper can wrap an object."""
    from spiral_core import SpiralError
    from spiral_core.wrap.curve import WrapCurve
    from spiral_gripper.files.description import load_gripper
    from spiral_gripper.files.errors import DescriptionError
    from spiral_gripper.files.shown import shown, shown_range

    del facts
    try:
        gripper = load_gripper(name)
        curve = WrapCurve(gripper)
    except DescriptionError as error:
        first, *others = error.problems
        more = f" (and {len(others)} more)" if others else ""
        advice = "The fields and their units are explained in docs/gripper_files.md."
        return Finding(Mark.PROBLEM, f"{first}{more}", advice)
    except SpiralError as error:
        return Finding(Mark.PROBLEM, f"it cannot be used: {error}")
    radii = shown_range(curve.radius_min, curve.radius_max)
    limit = shown(gripper.pressure_max, "Pa")
    return Finding(Mark.OK, f"coils; grips radii from {radii}, up to {limit}")


def _kernels() -> Iterator[Any]:
    """Yield the compiled kernels that a start of the solver loads."""
    for name in START_LOADS:
        import_module(name)
    folders = {name.rpartition(".")[0] for name in START_LOADS}
    for name, module in sorted(sys.modules.items()):
        if name.rpartition(".")[0] not in folders:
            continue
        for value in vars(module).values():
            # numba's dispatchers, told by what they have: numba is the core's business
            if not hasattr(value, "stats") or value.py_func.__module__ != name:
                continue
            if value.targetoptions.get("inline") != "always":  # else never compiled on its own
                yield value


def is_kept(kernel: Any) -> bool:  # noqa: ANN401 - numba's dispatchers are untyped
    """Return whether the machine code of a kernel, as it is now, is kept on disk.

    numba tells whether a source has changed by its digest, older versions by its time.
    """
    source, name = Path(kernel.py_func.__code__.co_filename), kernel.py_func.__qualname__
    kept = list(Path(kernel.stats.cache_path).glob(f"*.{name}-*.nbi"))
    changed = source.stat().st_mtime
    if any(file.stat().st_mtime >= changed for file in kept):
        return True
    digest = hashlib.sha256(source.read_bytes()).digest()
    return any(digest in file.read_bytes() for file in kept)


def add_called(function: Any, names: set[str]) -> None:  # noqa: ANN401
    """Add the names of a kernel and of all that it calls: its machine code holds theirs."""
    if function.__qualname__ in names:
        return
    names.add(function.__qualname__)
    for name in function.__code__.co_names:
        called = function.__globals__.get(name)
        if hasattr(called, "py_func"):
            add_called(called.py_func, names)
