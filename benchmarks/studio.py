# SPDX-License-Identifier: Apache-2.0
"""How often a second the studio can show a free shape: ``python -m benchmarks.studio [GRIPPER]``.

A pressure is changed, its shape solved and certified, and the surface of its tube made. Processor
time is measured: what the browser draws meanwhile runs in another process.
"""

from __future__ import annotations

import sys
import time
from dataclasses import replace

import numpy as np

from spiral_gripper import load_description
from spiral_gripper.reports.meshes import tube_mesh
from spiral_gripper.studio.session import Session
from spiral_gripper.studio.settings import settings_of

PRESSURES = 200
WANTED = 30.0  # updates a second


def update_times(name: str) -> np.ndarray:
    """Return the processor time of each update [s], from no pressure to the limit."""
    description = load_description(name)
    settings = settings_of(description, 0.02)
    session = Session(description, settings, lambda answer: None)
    session.close()  # nothing else is computed meanwhile
    session.shape()  # compiled
    times = []
    for pressure in np.linspace(0.0, session.gripper.pressure_max, PRESSURES):
        begin = time.thread_time()
        session.update(replace(settings, pressure=float(pressure)))
        tube_mesh(session.shape().positions, session.gripper.tube.outer_radius)
        times.append(time.thread_time() - begin)
    return np.array(times)


def main() -> int:
    """Print the rate; return 0 if 95 % of the updates are as fast as wanted."""
    times = update_times(sys.argv[1] if len(sys.argv) > 1 else "paper_design_70")
    median, slow = np.percentile(times, (50, 95))
    print(f"{1.0 / median:.0f} updates a second (median), {1.0 / slow:.0f} for the slowest 5 %")
    return 0 if 1.0 / slow >= WANTED else 1


if __name__ == "__main__":
    sys.exit(main())
