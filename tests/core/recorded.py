# SPDX-License-Identifier: Apache-2.0
"""What public results say, compared with files in ``records``: figures whose change is a decision.

A change on purpose is recorded by RECORD=1 pytest -n 0 FILE, and told in the changelog if users see
it. Why a figure is right is asked elsewhere: closed forms, references, invariants.
"""

import json
import re
from enum import Enum
from numbers import Real
from pathlib import Path

import numpy as np
from records import RECORDING, alike

from spiral_core import SpiralError

# What was given, what is asked elsewhere, and what the last bits decide.
LEFT_OUT = {
    "setup", "gripper", "requirement", "model", "actuator", "readings", "state", "residual",
    "iterations", "error", "frames", "largest_gap", "tip_gap", "effort", "coil", "points", "task",
    "outer_radius", "curve", "tried", "candidate", "elastomer", "margins", "sentence", "unit",
    "actuation", "stiffness", "trial",
}  # fmt: skip


def said(ask, *given):
    """Return a call's answer, or its error in words, without a solver's iterations."""
    try:
        return ask(*given)
    except SpiralError as error:
        return re.sub(r", \d+ iterations", "", f"{type(error).__name__}: {error}")


def told(value, at=""):
    """Return a value's public figures by their places, to six digits; a long row's norm."""
    if isinstance(value, Enum | str):
        return {at: getattr(value, "name", str(value))}
    if isinstance(value, Real | np.ndarray):
        row = np.ravel(value).astype(float)
        row = row if len(row) < 10 else [np.linalg.norm(row)]
        largest = np.max(np.abs(row), initial=1e-9, where=np.isfinite(row))
        digits = max(0, 5 - int(np.floor(np.log10(largest))))
        return {at: " ".join(f"{round(one, digits) + 0.0:.{digits}f}" for one in row)}
    if isinstance(value, list | tuple):
        if value and {*map(type, value)} <= {float, int, np.float64}:
            return told(np.array(value), at)
        value = dict(list(enumerate(value))[:: 1 + len(value) // 7])
    elif not isinstance(value, dict):
        names = {k for k in dir(value) if k[0] != "_" and type(value).__module__[:6] == "spiral"}
        value = {k: said(getattr, value, k) for k in sorted(names - LEFT_OUT)}
    shown = (told(one, f"{at} {key}".strip()) for key, one in value.items())
    return {place: leaf for each in shown for place, leaf in each.items()}


def recorded(place, value, within=1e-6):
    """Compare a result with what is recorded at a place, FILE/NAME, to a part of each figure."""
    file, name = place.split("/")
    path, found = Path(__file__).parent / "records" / f"{file}.json", told(value)
    records = json.loads(path.read_text("utf-8")) if path.exists() else {}
    if RECORDING:
        text = json.dumps(records | {name: found}, indent=0, sort_keys=True, ensure_ascii=False)
        path.write_text(text + "\n", "utf-8")
        return
    known = records[name]
    different = [
        f"{name} {at}: {found.get(at)}; recorded: {known.get(at)}"
        for at in sorted(found.keys() | known.keys())
        if not alike(found.get(at, ""), known.get(at, ""), within)
    ]
    assert not different, "\n".join(different)
