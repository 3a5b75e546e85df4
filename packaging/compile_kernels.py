# SPDX-License-Identifier: Apache-2.0
"""Compile the numerical kernels once, in two processes: python packaging/compile_kernels.py.

Tests that run in parallel would otherwise compile the same kernels several times, and a first user
would wait.
"""

from concurrent.futures import ProcessPoolExecutor

from spiral_gripper.kernels import STEPS, note_compiled

if __name__ == "__main__":
    with ProcessPoolExecutor(len(STEPS)) as processes:
        for step in [processes.submit(step) for step in STEPS]:
            step.result()
    note_compiled()
