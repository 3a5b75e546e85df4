# SPDX-License-Identifier: Apache-2.0
"""When what comes out agrees with what was recorded.

Each folder has a file or module of records of its own. ``RECORD=1 pytest FILE`` records anew what
was changed on purpose: git shows how it differs, and CHANGELOG.md tells what users see of it.
"""

import os
import re

RECORDING = bool(os.environ.get("RECORD"))
NUMBER = re.compile(r"-?\d+(?:\.\d+)?")


def alike(now, then, within=1e-6):
    """Return whether two lines differ by no more than rounding, or this part of a number."""
    numbers = zip(NUMBER.findall(now), NUMBER.findall(then), strict=False)
    return NUMBER.sub("0", now) == NUMBER.sub("0", then) and all(
        near(*pair, within) for pair in numbers
    )


def near(one, other, within):
    """Return whether two numbers differ by one unit of the last digit, or a part, at most."""
    decimals = max(len(each.partition(".")[2]) for each in (one, other))
    exact = decimals == 0 and len(one) < 4
    tolerance = 0.0 if exact else max(1.01 * 10.0**-decimals, within * abs(float(other)))
    return abs(float(one) - float(other)) <= tolerance
