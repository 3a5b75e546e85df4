# SPDX-License-Identifier: Apache-2.0
"""Every public value is shown on a few lines, whatever it holds."""

import dataclasses
import inspect
import re
from enum import Enum
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from core.gripper_cases import paper_gripper

import spiral_core
import spiral_gripper
from spiral_core import Closing, Pull, WrapCurve, lay_into_coil, solve_grip
from spiral_core.grip.places import place_mount

# Longer ones fill more than seven lines of a terminal.
LONGEST = 560
# What the reference's examples import from modules, beside what the packages offer at their top.
EXAMPLES = (Path(__file__).parents[2] / "docs/reference_examples").glob("*.txt")
IMPORTED = re.findall(
    r"^>>> from (spiral_core\.[\w.]+) import ((?:[^\n]|\n\.\.\.)+)",
    "".join(path.read_text(encoding="utf-8") for path in EXAMPLES),
    re.MULTILINE,
)
PUBLIC = {
    name: getattr(package, name)
    for package in (spiral_core, spiral_gripper)
    for name in package.__all__
} | {
    name: getattr(import_module(module), name)
    for module, names in IMPORTED
    for name in re.findall(r"\w+", names)
}
# Shown by figures that they compute, so that they are made by solving something.
SOLVED = {"Grip", "GripPoint", "GripSetup", "GripWindow", "HoldingForce", "Mount", "WrapCurve"}
VALUES = sorted(
    name
    for name, kind in PUBLIC.items()
    if inspect.isclass(kind) and dataclasses.is_dataclass(kind) and name not in SOLVED
)


def filled(kind: type, depth: int = 0) -> object:
    """Return a value whose fields hold much of what their annotations say, without its checks."""
    value = object.__new__(kind)
    for field in dataclasses.fields(kind):
        object.__setattr__(value, field.name, sample(str(field.type), depth + 1))
    return value


def sample(annotation: str, depth: int) -> object:
    """Return a large value for an annotation."""
    first = annotation.partition("|")[0].strip()
    if match := re.fullmatch(r"tuple\[(.+), \.\.\.\]", annotation):
        return (sample(match[1], depth),) * 50
    if first.startswith("tuple["):
        inner = first[len("tuple[") : -1].split(",")
        return tuple(sample(part.strip(), depth) for part in inner)
    if first in {"Array", "ArrayLike"} or "ndarray" in first or "NDArray" in first:
        return np.linspace(0.0, 1.0 / 3.0, 300).reshape(100, 3)
    if "Callable" in annotation or "Field" in first:
        return lambda points: (points[:, 0], points)
    kind = PUBLIC.get(first)
    if inspect.isclass(kind) and dataclasses.is_dataclass(kind) and depth < 4:
        return filled(kind, depth)
    if inspect.isclass(kind) and issubclass(kind, Enum):
        return next(iter(kind))
    if first == "Vector":
        return (0.125,) * 3
    plain = {"str": "a name", "int": 7, "bool": True, "Path": "a/path"}
    return plain.get(first, 0.125)


def solved() -> list[object]:
    """Return a value of each kind that has to be solved."""
    curve = WrapCurve(paper_gripper("P1"))
    setup = lay_into_coil(curve.gripper, 0.012, closing=Closing.FRICTIONLESS, elements=60)
    grip = solve_grip(setup, (Pull.AWAY,), pressures=[1.02 * setup.tip_pressure])
    mount = place_mount(setup, (1e-3, 0.0, 0.0), (0.0, 0.0))
    held = grip.forces[Pull.AWAY][0]
    return [grip, grip.points[0], setup, grip.window, held, mount, curve]


def require_readable(value: object) -> None:
    text = repr(value)
    assert len(text) <= LONGEST, text
    assert "\n" not in text, text
    assert text.startswith(f"{type(value).__name__}("), text
    assert not re.search(r"array\(| at 0x", text), text


@pytest.mark.parametrize("name", VALUES)
def test_a_public_value_is_short(name: str) -> None:
    require_readable(filled(PUBLIC[name]))


def test_what_is_solved_is_short() -> None:
    values = solved()
    assert {type(value).__name__ for value in values} == SOLVED
    for value in values:
        require_readable(value)


def test_every_public_kind_of_value_is_looked_at() -> None:
    others = {
        name
        for name, kind in PUBLIC.items()
        if inspect.isclass(kind)
        and name not in {*VALUES, *SOLVED}
        and not issubclass(kind, Enum | Exception | tuple)
        and not getattr(kind, "_is_protocol", False)
    }
    assert others == set()
