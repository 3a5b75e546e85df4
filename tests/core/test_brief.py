# SPDX-License-Identifier: Apache-2.0
"""Every public value is shown on a few lines, whatever it holds."""

import dataclasses

import numpy as np
import pytest
from core.gripper_cases import paper_gripper

from spiral_core import RodStatus, Tube
from spiral_core.brief import brief_repr


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
        ((0,) * 9, "<9 of int>"),
        (Tube(0.004, 0.001, 0.3), "<Tube>"),
        ((Tube(0.004, 0.001, 0.3),), "<1 of Tube>"),
        (paper_gripper("P1"), "<Gripper P1>"),
    ],
)
def test_each_kind_of_field_is_short(held, shown):
    assert repr(Held(held)) == f"Held(held={shown})"
