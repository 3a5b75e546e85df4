# SPDX-License-Identifier: Apache-2.0
"""Compile the numerical kernels once, in two processes: python packaging/compile_kernels.py.

Tests that run in parallel would otherwise compile the same kernels several times, and a first user
would wait.
"""

from spiral_gripper.kernels import compile_kernels

if __name__ == "__main__":
    compile_kernels(processes=2)
