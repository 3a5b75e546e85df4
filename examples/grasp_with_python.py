# SPDX-License-Identifier: Apache-2.0
"""Wrap an object from Python, hold it, and release it.

Start a gripper's node first (``spiral_gripper_node``), then run
``python examples/grasp_with_python.py [NAMESPACE]``.
"""

from __future__ import annotations

import sys

from spiral_gripper_ros.client import SpiralGripper, WrapOutcome

with SpiralGripper(namespace=sys.argv[1] if len(sys.argv) > 1 else "") as gripper:
    gripper.wait_until_active(timeout=60.0)

    # Before the arm approaches: can the gripper wrap it, and at which pressure?
    print(gripper.plan(radius=0.02).message)

    try:
        # Wrap 20 mm, with 5 kPa more than the wrap needs, for a firmer hold.
        gripper.wrap(radius=0.02, overpressure=5.0e3, timeout=20.0, abort_policy="vent")
        while not gripper.is_done():
            feedback = gripper.feedback()
            if feedback is not None:
                print(f"{feedback.progress:4.0%}, {1e-3 * feedback.pressure_command:.1f} kPa")
        result = gripper.wait(timeout=1.0)
        if result.outcome is not WrapOutcome.SUCCEEDED:
            raise SystemExit(result.message)
        print(f"{result.message}; {result.turns:.2f} turns, {result.line_force:.1f} N/m")

        # Here the arm would move. The gripper holds, whatever `object_radius` says, until release:
    finally:  # after an error or Ctrl-C too; otherwise the gripper would keep holding
        gripper.release()
