# SPDX-License-Identifier: Apache-2.0
"""What a new process pays: import, first solve, memory; each in processes of its own."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import tracemalloc

import numpy as np

from benchmarks.accuracy import usual_state, warm_call
from benchmarks.results import MEGABYTE, Effort, Section, Table, milli

IMPORT = """
import time
begin = time.perf_counter()
import spiral_core
print(time.perf_counter() - begin)
"""
FIRST_SOLVE = """
import time
begin = time.perf_counter()
from spiral_core import Rod, RodLoad, Section, solve_rod
rod = Rod(0.36, Section.inextensible(2.7e-4, 1.8e-4), rest_strain=(-13.5, 0.0, 21.0))
solve_rod(rod, RodLoad((0.24, 0.0, 0.0)), elements=100, estimate_error=False)
print(time.perf_counter() - begin)
"""
# Resident memory [bytes] with numpy alone, after the import, after a solve, after many more.
MEMORY = """
import os
import numpy as np
def resident():
    with open("/proc/self/statm") as pages:
        return int(pages.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
found = [resident()]
import spiral_core
found.append(resident())
from spiral_core import Rod, RodLoad, Section, solve_rod
load, section = RodLoad((0.24, 0.0, 0.0)), Section.inextensible(2.7e-4, 1.8e-4)
rods = [Rod(0.36, section, rest_strain=(-13.5, 0.0, k)) for k in (21.0, 21.2)]
state = solve_rod(rods[0], load, elements=100, estimate_error=False)
state = solve_rod(rods[1], load, elements=100, start=state, estimate_error=False)
found.append(resident())
for i in range({solves}):
    state = solve_rod(rods[i % 2], load, elements=100, start=state, estimate_error=False)
found.append(resident())
print(*found)
"""


def run(code: str, cache: str | None = None) -> list[float]:
    """Return the numbers that a program prints in a new process."""
    environment = os.environ | ({} if cache is None else {"NUMBA_CACHE_DIR": cache})
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment
    )
    return [float(word) for word in done.stdout.split()]


def state_size() -> tuple[int, int]:
    """Return the bytes that a state of N = 100 keeps, and the peak that Python sees in a solve."""
    call = warm_call(100)
    call()
    tracemalloc.start()
    call()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    state = usual_state(100)
    arrays = (state.positions, state.orientations, state.forces, state.moments, state.strains)
    return sum(array.nbytes for array in arrays), peak


def measure(effort: Effort) -> Section:
    """Measure import, first solve with and without the compiled kernels' cache, and memory."""
    imports = float(np.median([run(IMPORT)[0] for _ in range(effort.starts)]))
    with tempfile.TemporaryDirectory() as empty:
        cache = empty if effort.compile_anew else None
        compiling = run(FIRST_SOLVE, cache)[0]
        first = float(np.median([run(FIRST_SOLVE, cache)[0] for _ in range(effort.starts)]))
        solves = effort.short * 10
        memory = run(MEMORY.replace("{solves}", str(solves)), cache)
    megabytes = [m / MEGABYTE for m in memory]
    kept, peak = state_size()
    growth = (memory[3] - memory[2]) / 1024.0
    return Section(
        (
            Table(
                "A new process",
                ("what", "time", "resident memory"),
                (
                    ("Python with numpy", "", f"{megabytes[0]:.0f} MB"),
                    ("import spiral_core", milli(imports), f"{megabytes[1]:.0f} MB"),
                    ("first solve, kernels cached", f"{first:.2f} s", f"{megabytes[2]:.0f} MB"),
                    ("first solve ever (compiles)", f"{compiling:.1f} s", ""),
                    (f"{solves:,} more solves", "", f"{growth:+.0f} kB"),
                ),
                f"The first solves include the import of numba. A state of N = 100 keeps "
                f"{kept / 1024.0:.0f} kB of arrays; a warm solve's peak, as Python's allocator "
                f"sees it, is {peak / 1024.0:.0f} kB.",
            ),
        ),
        {"import": imports, "first_cached": first, "first_compiling": compiling}
        | {"resident_import_mb": megabytes[1], "resident_solve_mb": megabytes[2]}
        | {"growth_kb": growth, "state_kb": kept / 1024.0, "peak_kb": peak / 1024.0},
    )
