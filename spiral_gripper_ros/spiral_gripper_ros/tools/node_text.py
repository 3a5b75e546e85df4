# SPDX-License-Identifier: Apache-2.0
"""Texts of the node, which are in SI, for people."""

from __future__ import annotations

import re
from typing import Final

from spiral_gripper.files.shown import shown

_NUMBER: Final = r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?"
_QUANTITY: Final = re.compile(rf"(?<![\w.])({_NUMBER}) (Pa|m|N|kg)(?![\w/^]| [a-zA-Z]*\^)")


def node_text(text: str) -> str:
    """Return a text that came as a message of the node in the units that are shown.

    Example:
        >>> node_text("wraps 0.02 m at 62045.5 Pa, within 0.1 m/s")
        'wraps 20 mm at 62.05 kPa, within 0.1 m/s'
    """
    return _QUANTITY.sub(lambda found: shown(float(found[1]), found[2]), text)
