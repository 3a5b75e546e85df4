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
from spiral_core import Closing, Pull, RodStatus, Tube, WrapCurve, lay_into_coil, solve_grip
from spiral_core.brief import brief_repr

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
KINDS = {name: kind for name, kind in PUBLIC.items() if inspect.isclass(kind)}
VALUES = {name for name, kind in KINDS.items() if dataclasses.is_dataclass(kind)}
# Shown by figures that they compute, so that they are made by solving something.
SOLVED = {"Grip", "GripPoint", "GripSetup", "GripWindow", "HoldingForce", "WrapCurve"}
# A dataclass shows all that these hold, except where that is little, or as much as was given.
LARGE = re.compile(r"Array|ndarray|\.\.\.|Callable")
LITTLE = {"Section"}


def require_readable(value):
    text = repr(value)
    assert len(text) <= LONGEST, text
    assert text.startswith(f"{type(value).__name__}("), text
    assert not re.search(r"array\(| at 0x|\n", text), text


@pytest.mark.parametrize("name", sorted(VALUES - SOLVED))
def test_a_public_value_is_short(name):
    kind, fields = KINDS[name], [one for one in dataclasses.fields(KINDS[name]) if one.repr]
    if kind.__repr__ is brief_repr:
        value = object.__new__(kind)
        for field in fields:
            object.__setattr__(value, field.name, 1.0 / 3.0)
        require_readable(value)
    elif name not in LITTLE:
        assert not any(LARGE.search(str(field.type)) for field in fields)


def test_what_is_solved_is_short():
    curve = WrapCurve(paper_gripper("P1"))
    setup = lay_into_coil(curve.gripper, 0.012, closing=Closing.FRICTIONLESS, elements=60)
    grip = solve_grip(setup, (Pull.AWAY,), pressures=[1.02 * setup.tip_pressure])
    values = [curve, setup, grip, grip.points[0], grip.window, grip.forces[Pull.AWAY][0]]
    assert {type(value).__name__ for value in values} == SOLVED
    for value in values:
        require_readable(value)


def test_every_public_kind_of_value_is_looked_at():
    for name in KINDS.keys() - VALUES - SOLVED:
        protocol = getattr(KINDS[name], "_is_protocol", False)
        assert protocol or issubclass(KINDS[name], Enum | Exception | tuple), name


@dataclasses.dataclass
class Held:
    held: object
    hidden: int = dataclasses.field(default=3, repr=False)
    _private: int = 4

    __repr__ = brief_repr


@pytest.mark.parametrize(
    ("held", "shown"),
    [
        (1.0 / 3.0, "0.333333"),
        ("a name", "'a name'"),
        ("x" * 500, "<str>"),
        (RodStatus.CONVERGED, "CONVERGED"),
        (np.zeros((9, 3)), "<array (9, 3)>"),
        ((1.0, 2.5), "(1, 2.5)"),
        ((1.0,), "(1,)"),
        ((0,) * 9, "<9 of int>"),
        (Tube(0.004, 0.001, 0.3), "<Tube>"),
        ((Tube(0.004, 0.001, 0.3),), "<1 of Tube>"),
        (paper_gripper("P1"), "<Gripper P1>"),
    ],
)
def test_each_kind_of_field_is_short(held, shown):
    assert repr(Held(held)) == f"Held(held={shown})"
