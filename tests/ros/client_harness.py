# SPDX-License-Identifier: Apache-2.0
"""What the tests of the Python client share."""

import time

from ros.harness import DEADLINE

RADIUS = 0.02
# Of everything that these tests wait for [s].
PATIENCE = DEADLINE


def wait_until(condition):
    """Poll a condition that listens itself until it holds."""
    deadline = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < deadline
