# SPDX-License-Identifier: Apache-2.0
"""An interrupt while kernels compute ends the call with KeyboardInterrupt: no crash, none lost."""

from __future__ import annotations

import subprocess
import sys

CODE = """
import random, signal, sys
from spiral_core import WrapCurve
from spiral_gripper import load_gripper
from spiral_gripper.cli.interrupt import interrupt

curve = WrapCurve(load_gripper("paper_design_70"))
signal.signal(signal.SIGALRM, interrupt)
random.seed(3)
for number in range(100):
    try:
        signal.setitimer(signal.ITIMER_REAL, random.uniform(2e-4, 4e-3))
        for step in range(10**6):
            curve.wrap_for_radius(0.012 + 1e-5 * (step % 1000))
    except KeyboardInterrupt:
        assert sys.gettrace() is None
        continue
    sys.exit("lost")
"""


def test_an_interrupt_is_raised_once_numba_has_packed_its_result() -> None:
    asked = [sys.executable, "-c", CODE]
    done = subprocess.run(asked, check=False, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
