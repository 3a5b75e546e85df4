# SPDX-License-Identifier: Apache-2.0
"""Records of what users see, compared with what comes out now.

A change on purpose is recorded by RECORD_INTERFACES=1 pytest tests/ros, looked at with git diff,
and told in CHANGELOG.md.
"""

import os
import re
from enum import Enum
from itertools import zip_longest
from pathlib import Path

import pytest
import yaml

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
    if os.environ.get("RECORD_INTERFACES"):
        record.write_text(found, encoding="utf-8")
    kept = record.read_text(encoding="utf-8").splitlines()
    pairs = zip_longest(found.splitlines(), kept, fillvalue="")
    assert [old if is_alike(new, old) else new for new, old in pairs] == kept


def is_alike(line, other):
    """Return whether only the rounding of numbers differs: 1e-6, or the last of three digits."""
    new, old = (re.split(r"(\d+(?:\.\d+)?)", one) for one in (line, other))
    last = [1.01 * 10.0 ** (x.find(".") - len(x) + 1) * (len(x) > 3) for x in old[1::2]]
    near = [pytest.approx(float(x), abs=unit) for x, unit in zip(old[1::2], last, strict=True)]
    return new[::2] == old[::2] and list(map(float, new[1::2])) == near
