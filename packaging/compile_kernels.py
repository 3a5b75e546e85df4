# SPDX-License-Identifier: Apache-2.0
"""Compile the numerical kernels once, lest parallel tests compile each and a first user waits."""

from spiral_gripper.kernels import compile_kernels

if __name__ == "__main__":
    compile_kernels(processes=2)
