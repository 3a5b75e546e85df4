# SPDX-License-Identifier: Apache-2.0
"""Records of what users see, compared with what comes out now.

A change on purpose is recorded by RECORD=1 pytest tests/ros, looked at with git diff,
and told in CHANGELOG.md.
"""

from enum import Enum
from itertools import zip_longest
from pathlib import Path

import yaml
from records import RECORDING, alike

TIMES = "stamp", "solve_time"


def plain(value):
    """Return what messages and dataclasses hold, but for times, what is 0 and what is empty."""
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, float):  # a solver leaves 1e-9 of nothing
        return float(f"{round(value, 9) + 0.0:.7g}")
    if isinstance(value, int | str | None):
        return value[:] if isinstance(value, str) else value  # of a class of its own
    if hasattr(value, "get_fields_and_field_types"):
        names = value.get_fields_and_field_types()
    elif not (names := getattr(value, "__dataclass_fields__", getattr(value, "__dict__", ()))):
        return [plain(one) for one in value]
    told = {name: plain(getattr(value, name)) for name in names if name not in TIMES}
    return {name: one for name, one in told.items() if one not in (None, 0, "", [], {})}


def told(*values):
    """Return messages and dataclasses as text."""
    return "".join(yaml.safe_dump(plain(v), default_flow_style=None, width=98) for v in values)


def agrees(name, found):
    """Compare a text with the record of this name, which is written first if that is asked for."""
    record = Path(__file__).parent / f"records/{name}.txt"
    if RECORDING:
        record.write_text(found, encoding="utf-8")
    kept = record.read_text(encoding="utf-8").splitlines()
    pairs = zip_longest(found.splitlines(), kept, fillvalue="")
    assert [old if alike(new, old) else new for new, old in pairs] == kept
